"""The scene: obstacles, named states, and the YAML files that store them."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, get_type_hints

import pydantic

from planner.base.arrays import Floats
from planner.base.cache import content_hash
from planner.base.errors import Note, OptionError, SceneError, choices
from planner.base.files import StrPath, make_folder, write_whole
from planner.base.resources import list_published_scenes, scene_file, scene_names
from planner.base.yamlfile import (
    FARTHEST,
    Coordinate,
    Name,
    Number,
    Strict,
    find_duplicates,
    parse_yaml,
    quote,
    read_text,
    validate,
    yaml_text,
)
from planner.problem.conditions import AND, read_conditions
from planner.problem.options import EMPTY, SceneLike
from planner.problem.targets import TURN
from planner.robot.clouds import notes_on_clouds
from planner.robot.files.clouds import SEEN, SensorFile, read_cells, read_seen
from planner.robot.files.meshes import collada_notes, read_mesh
from planner.robot.moving import LONGEST, KnownMotion, MovingObstacle, require_times
from planner.robot.poses import pose, quaternion_of
from planner.robot.shapes import Box, Capsule, Carried, Cylinder, Mesh, Obstacle, Shape, Sphere

if TYPE_CHECKING:
    from planner.robot.moveit.scenes import PlanningScene

_OF_MOVEIT = {"world", "robot_model_name", "allowed_collision_matrix"}  # keys of a PlanningScene message

Triple = tuple[Coordinate, Coordinate, Coordinate]


class PoseFile(Strict):
    """A placement: metres, and either rpy (rad) or a quaternion [x, y, z, w]."""

    position: Triple = (0.0, 0.0, 0.0)
    rpy: Triple | None = None
    quaternion: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = None

    @pydantic.model_validator(mode="after")
    def _one_rotation(self) -> PoseFile:
        if self.rpy is not None and self.quaternion is not None:
            raise ValueError("give rpy or quaternion, not both")
        if self.rpy is not None and max(map(abs, self.rpy)) > TURN:
            raise ValueError(f"rpy is in rad, and {list(self.rpy)} is more than a turn: degrees? 90 degrees are 1.5708")
        self.matrix()
        return self

    def matrix(self) -> Floats:
        return pose(self.position, self.rpy, self.quaternion)


class TimedPoseFile(PoseFile):
    """Pose of a moving obstacle at ``t`` (s)."""

    t: Annotated[Number, pydantic.Field(ge=0, le=LONGEST)]


class _ObstacleItem(PoseFile):
    """An obstacle; it stands, follows a ``motion``, or may move within its ``speed_limit`` (m/s)."""

    name: Name = pydantic.Field(min_length=1)
    motion: tuple[TimedPoseFile, ...] = ()
    speed_limit: Annotated[Number, pydantic.Field(ge=0, le=FARTHEST)] = 0.0

    @pydantic.model_validator(mode="after")
    def _one_motion(self) -> _ObstacleItem:
        if "motion" in self.model_fields_set:
            require_times([pose.t for pose in self.motion])
            if placed := {"position", "rpy", "quaternion", "speed_limit"} & self.model_fields_set:
                raise ValueError(f"give a motion or a {min(placed)}, not both")
        elif getattr(self, "type", "") in SEEN:
            if not {"position", "rpy", "quaternion", "frame"} & self.model_fields_set:
                raise ValueError("give the pose of the sensor, position: [0, 0, 0] where its numbers are the world's")
            if "self_filter" in self.model_fields_set and not getattr(self, "seen_at", ""):
                raise ValueError("give seen_at, the state of the robot when the sensor saw it")
        return self


class _CarriedItem(PoseFile):
    """A payload in the frame of a link, which it may touch, as it may ``touch_links``."""

    name: Name = pydantic.Field(min_length=1)
    link: Name = pydantic.Field(min_length=1)
    touch_links: tuple[Name, ...] = ()


@dataclass(frozen=True)
class _MeshFile:
    file: str
    scale: Annotated[Number, pydantic.Field(ge=1e-9, le=1e9)] = 1.0


_SHAPES = {"box": Box, "sphere": Sphere, "cylinder": Cylinder, "capsule": Capsule, "mesh": _MeshFile}


def _models_by_shape(thing: type[PoseFile], name: str, shapes: Mapping[str, Any] = _SHAPES) -> Any:
    """Return the union of file models of ``thing``, one per shape, selected by the key ``type``."""
    models = []
    for kind, shape in shapes.items():
        hints = get_type_hints(shape, include_extras=True)
        keys: dict[str, Any] = {key: (hint, getattr(shape, key, ...)) for key, hint in hints.items()}
        keys["type"] = Literal[kind], ...
        models.append(pydantic.create_model(f"{name}{kind.capitalize()}File", __base__=thing, **keys))
    return Annotated[reduce(or_, models), pydantic.Field(discriminator="type")]


ObstacleFile: TypeAlias = _models_by_shape(_ObstacleItem, "", _SHAPES | SEEN)  # pyright: ignore[reportInvalidTypeForm]
CarriedFile: TypeAlias = _models_by_shape(_CarriedItem, "Carried")  # pyright: ignore[reportInvalidTypeForm]


class PlacementFile(Strict):
    """Set-up of a robot in a scene: its base, tool and fixed joints."""

    base: PoseFile = PoseFile()
    tool: str | None = None
    fixed_joints: dict[str, Coordinate] = pydantic.Field(default_factory=dict)


class SceneFile(Strict):
    """Content of a scene file."""

    name: Name | None = None
    description: str = ""
    obstacles: list[ObstacleFile] = pydantic.Field(default_factory=list)
    carried: list[CarriedFile] = pydantic.Field(default_factory=list)
    states: dict[str, dict[str, str]] = pydantic.Field(default_factory=dict)
    robots: dict[str, PlacementFile] = pydantic.Field(default_factory=dict)
    allowed: list[tuple[Name, Name]] = pydantic.Field(default_factory=list)  # obstacles and links that may touch
    constraints: list[str] = pydantic.Field(default_factory=list)  # what motions keep all along

    @pydantic.field_validator("constraints")
    @classmethod
    def _check_constraints(cls, constraints: list[str]) -> list[str]:
        try:
            read_conditions(constraints)
        except OptionError as error:
            raise ValueError(str(error)) from None
        return constraints

    @pydantic.model_validator(mode="after")
    def _distinct_names(self) -> SceneFile:
        if twice := find_duplicates(item.name for item in (*self.obstacles, *self.carried)):
            raise ValueError(f"name '{twice[0]}' is used twice; names must differ, also those of carried things")
        return self


@dataclass(frozen=True, eq=False)
class Scene:
    """Obstacles in the world frame, named states, and the set-up of each robot.

        Scene("cell", [{"type": "box", "size": [1, 1, 0.1], "position": [0, 0, -0.06]}])

    Dicts with the keys of a scene file become obstacles, named ``box_0`` and so on by default; paths of their meshes
    are relative to the working directory. Obstacles with a known motion become ``moving``: only timed plans avoid them;
    the roadmap ignores them. Raises :class:`SceneError` for unknown keys and repeated names.
    """

    name: str = "scene"
    obstacles: tuple[Obstacle, ...] = ()
    description: str = ""
    states: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    robots: Mapping[str, PlacementFile] = field(default_factory=dict)
    moving: tuple[MovingObstacle, ...] = ()
    carried: tuple[Carried, ...] = ()  # shapes that a link of the robot holds
    allowed: frozenset[frozenset[str]] = frozenset()  # pairs of names that may touch
    message: PlanningScene | None = None  # the PlanningScene message, if the scene was read from one
    notes: tuple[Note, ...] = ()  # on ignored content of its file or of a request
    constraints: str = ""  # on all motions, as ``--constraint`` takes them; no part of what stands there

    def __post_init__(self) -> None:
        given, notes = build_obstacles(self.obstacles, f"scene '{self.name}'")
        moving = [item for item in given if isinstance(item, MovingObstacle)]
        object.__setattr__(self, "obstacles", tuple(item for item in given if isinstance(item, Obstacle)))
        notes += tuple(note for note in notes_on_clouds(self.obstacles) if note not in self.notes)
        for name, more in (("moving", moving), ("carried", ()), ("notes", notes)):
            object.__setattr__(self, name, (*getattr(self, name), *more))
        if twice := find_duplicates(item.name for item in (*self.obstacles, *self.moving, *self.carried)):
            raise SceneError(f"scene '{self.name}' has {quote(twice[0])} twice: name each once.")

    def __repr__(self) -> str:
        kinds = (self.obstacles, "obstacles"), (self.moving, "that move"), (self.carried, "carried")
        return f"<Scene: {self.name}, {', '.join(f'{len(items)} {kind}' for items, kind in kinds if items) or 'empty'}>"

    @staticmethod
    def load(name: StrPath | SceneLike) -> Scene:
        """Load a built-in scene by name, or our YAML, MoveIt's PlanningScene YAML or ``.scene`` text by path.

        A scene is returned unchanged, None is the empty scene. Raises :class:`SceneError` or ``FileError``.
        """
        if isinstance(name, Scene):
            return name
        name = EMPTY if name is None else os.fspath(name)  # type: ignore[arg-type]
        path = scene_file(name) or Path(name)
        known = path.suffix.lower() in (".yaml", ".yml", ".scene")
        if not known and "/" not in name and not os.path.isfile(path):
            there = choices([*scene_names(), *list_published_scenes()])
            raise SceneError(f"scene '{name}' not found; scenes are {there}, or give the path of a scene file.")
        where, text = f"scene file {path}", read_text(path, "scene file")
        is_text = path.suffix.lower() == ".scene"
        data = None if is_text else parse_yaml(text, where)
        if is_text or (isinstance(data, dict) and _OF_MOVEIT & set(data)):
            from planner.robot.moveit.scenes import parse_planning_scene, parse_scene_text

            message = parse_scene_text(text, path) if is_text else parse_planning_scene(data, path)
            more = {"carried": message.carried, "allowed": message.allowed, "message": message, "notes": message.notes}
            return Scene(message.name, message.obstacles, "from MoveIt", **more)
        return scene_from_file(validate(SceneFile, data, where, SceneError), path)

    def placement(self, robot: str) -> PlacementFile:
        """Return the set-up of a robot in this scene, or the default."""
        return self.robots.get(robot, PlacementFile())

    @property
    def limited(self) -> tuple[Obstacle, ...]:
        """The obstacles that may move, each within its speed limit."""
        return tuple(item for item in self.obstacles if item.speed_limit > 0)

    def states_of(self, robot: str) -> Mapping[str, str]:
        """Return the named states of a robot as text."""
        return self.states.get(robot, {})

    @property
    def identity(self) -> str:
        """A hash of obstacles and permissions, independent of order and of names without permissions."""
        solid = sorted(content_hash([*item.shape.content(), item.placement]) for item in self.obstacles)
        named = {item.object for item in self.obstacles}
        allowed = sorted(sorted(pair) for pair in self.allowed if pair & named)
        owners = sorted((item.object, item.placement.tolist()) for item in self.obstacles) if allowed else []
        return content_hash([solid, allowed, owners])


def _shape(item: ObstacleFile | CarriedFile, folder: Path) -> Shape:
    """Return the shape of an item; mesh paths are relative to ``folder``."""
    match item.type:
        case "mesh":
            return read_mesh(folder / item.file, item.scale)
        case "voxels" | "points":
            return read_cells(item, folder)
    shape = _SHAPES[item.type]
    return shape(*(getattr(item, key) for key in get_type_hints(shape)))


def read_obstacle(item: ObstacleFile, folder: Path = Path()) -> list[Obstacle | MovingObstacle]:
    """Return the obstacle of a file in ``folder``; of a depth image the surface and the unknown space."""
    if item.type == "depth" and (item.motion or item.speed_limit):
        raise SceneError(f"obstacle '{item.name}': a depth image must stand, got a motion or a speed limit.")
    if item.type in SEEN and not item.motion:
        how = {key: getattr(item, key) for key in ("speed_limit", *get_type_hints(SensorFile))}
        return [replace(each, **how) for each in read_seen(item, folder, item.matrix())]
    if not item.motion:
        return [Obstacle(item.name, _shape(item, folder), item.matrix(), speed_limit=item.speed_limit)]
    motion = KnownMotion([pose.t for pose in item.motion], [pose.matrix() for pose in item.motion])
    return [MovingObstacle(item.name, _shape(item, folder), motion)]


def build_obstacles(
    items: Iterable[Obstacle | MovingObstacle | Mapping[str, Any]], where: str
) -> tuple[list[Obstacle | MovingObstacle], tuple[Note, ...]]:
    """Return obstacles, with dicts converted as :class:`Scene` documents, and notes on mesh files."""
    given = list(items)
    if wrong := [item for item in given if not isinstance(item, Mapping | Obstacle | MovingObstacle)]:
        raise TypeError(f"obstacles must be planner.Obstacle, MovingObstacle or dicts, got {type(wrong[0]).__name__}.")
    dicts = [
        {"name": f"{item.get('type')}_{k}"} | {key: _as_plain_data(value) for key, value in item.items()}
        for k, item in enumerate(given)
        if isinstance(item, Mapping)
    ]
    files = validate(SceneFile, {"obstacles": dicts}, where, SceneError).obstacles
    read = (read_obstacle(item) for item in files)
    groups = [next(read) if isinstance(item, Mapping) else [item] for item in given]
    return [item for items in groups for item in items], mesh_notes(files)


def _as_plain_data(value: Any) -> Any:
    """Return an array as a list and a path as text; other values unchanged."""
    return value.tolist() if hasattr(value, "tolist") else os.fspath(value) if hasattr(value, "__fspath__") else value


def mesh_notes(items: Iterable[ObstacleFile | CarriedFile], folder: Path = Path()) -> tuple[Note, ...]:
    """Return notes on the mesh files of ``items``, relative to ``folder``."""
    return tuple(collada_notes(folder / item.file for item in items if item.type == "mesh"))


def scene_from_file(file: SceneFile, path: Path) -> Scene:
    """Return the scene of a file's content; paths of meshes are relative to its folder."""
    folder = path.parent
    obstacles: Any = [obstacle for item in file.obstacles for obstacle in read_obstacle(item, folder)]
    return Scene(
        file.name or path.stem,
        obstacles,
        file.description,
        file.states,
        file.robots,
        carried=tuple(
            Carried(item.link, item.name, _shape(item, folder), item.matrix(), item.touch_links)
            for item in file.carried
        ),
        allowed=frozenset(frozenset(pair) for pair in file.allowed),
        notes=mesh_notes((*file.obstacles, *file.carried), folder),
        constraints=AND.join(each.text for each in read_conditions(file.constraints)),
    )


def write_scene(scene: Scene, path: StrPath) -> list[Path]:
    """Write ``scene`` to ``path`` with each mesh in an OBJ file next to it; return the paths.

    :meth:`Scene.load` reads the same scene, to rounding. Raises :class:`FileError` if writing fails, and
    :class:`SceneError` for objects in frames of their own and meshes with a radius, which the format does not support.
    """
    path = Path(path)
    if placed := [item.name for item in (*scene.obstacles, *scene.carried) if item.frame]:
        raise SceneError(f"{choices(placed)} must be placed in the world, got a frame of its own: transform it first.")
    shapes = [item.shape for item in (*scene.obstacles, *scene.moving, *scene.carried)]
    if any(isinstance(shape, Mesh) and shape.radius for shape in shapes):
        raise SceneError("radius of a mesh must be 0 in a scene file, got more: remove the radius.")
    surfaces = [shape for shape in shapes if isinstance(shape, Mesh)]
    meshes = {path.with_name(f"{path.stem}-{k}.obj"): mesh for k, mesh in enumerate(surfaces)}
    files = iter(meshes)
    content = {
        "name": scene.name,
        "description": scene.description,
        "obstacles": [_item_data(item, files) for item in (*scene.obstacles, *scene.moving)],
        "carried": [_item_data(item, files) for item in scene.carried],
        "states": {robot: dict(named) for robot, named in scene.states.items()},
        "robots": {name: item.model_dump(exclude_defaults=True) for name, item in scene.robots.items()},
        "allowed": sorted(_permissions(scene)),
        "constraints": scene.constraints.split(AND) if scene.constraints else [],
    }
    text = yaml_text({key: value for key, value in content.items() if value or key == "name"})
    make_folder(path.parent)
    for file, mesh in meshes.items():
        lines = [f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist()]
        lines += [f"f {i} {j} {k}\n" for i, j, k in (mesh.triangles + 1).tolist()]
        write_whole(file, "".join(lines).encode())
    write_whole(path, text.encode())
    return [path, *meshes]


def _item_data(item: Obstacle | MovingObstacle | Carried, files: Iterator[Path]) -> dict[str, Any]:
    """Return an item under the keys of a scene file; a mesh takes the next of ``files``."""
    shape = {"file": next(files).name} if isinstance(item.shape, Mesh) else vars(item.shape)
    data = {"name": item.name, "type": type(item.shape).__name__.lower(), **shape}
    match item:
        case MovingObstacle(motion=motion):
            poses = zip(motion.times.tolist(), motion.poses, strict=True)
            return {**data, "motion": [{"t": t, **_pose(placement)} for t, placement in poses]}
        case Carried():
            return {**data, **_pose(item.placement), "link": item.link, "touch_links": list(item.touch_links)}
    limit = {"speed_limit": float(item.speed_limit)} if item.speed_limit > 0 else {}
    return {**data, **_pose(item.placement), **limit}


def _pose(placement: Floats) -> dict[str, Any]:
    return {"position": placement[:3, 3].tolist(), "quaternion": quaternion_of(placement[:3, :3])}


def _permissions(scene: Scene) -> Iterator[list[str]]:
    """Yield pairs of names of shapes or links that may touch."""
    shapes: dict[str, list[str]] = {}
    for item in (*scene.obstacles, *scene.carried):
        shapes.setdefault(item.object, []).append(item.name)
    for pair in scene.allowed:
        first, second = (tuple(pair) * 2)[:2]
        for a, b in itertools.product(shapes.get(first, [first]), shapes.get(second, [second])):
            yield sorted((a, b))
