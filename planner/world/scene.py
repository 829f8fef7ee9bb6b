"""The obstacles around the robot, with named starts and goals: our own small YAML format."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import pydantic

from planner.base.arrays import Floats
from planner.base.errors import SceneError, choices
from planner.base.files import is_file
from planner.base.hashing import content_hash
from planner.base.resources import published_scene_names, scene_file, scene_names
from planner.base.targets import TURN
from planner.base.yamlfile import Coordinate, Name, Size, Strict, parse_yaml, read_text, validate
from planner.world.meshes import read_mesh
from planner.world.moveit import PlanningScene, looks_like_planning_scene, planning_scene, scene_text
from planner.world.poses import pose
from planner.world.shapes import Box, Capsule, Carried, Cylinder, Obstacle, Shape, Sphere

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


class _Named(PoseFile):
    name: Name = pydantic.Field(min_length=1)


class BoxFile(_Named):
    type: Literal["box"]
    size: tuple[Size, Size, Size]

    def shape(self, folder: Path) -> Shape:
        return Box(self.size)


class SphereFile(_Named):
    type: Literal["sphere"]
    radius: Size

    def shape(self, folder: Path) -> Shape:
        return Sphere(self.radius)


class CylinderFile(_Named):
    type: Literal["cylinder"]
    radius: Size
    length: Size

    def shape(self, folder: Path) -> Shape:
        return Cylinder(self.radius, self.length)


class CapsuleFile(_Named):
    type: Literal["capsule"]
    radius: Size
    length: Size

    def shape(self, folder: Path) -> Shape:
        return Capsule(self.radius, self.length)


class MeshFile(_Named):
    type: Literal["mesh"]
    file: str
    scale: Annotated[float, pydantic.Field(ge=1e-9, le=1e9)] = 1.0

    def shape(self, folder: Path) -> Shape:
        return read_mesh(folder / self.file, self.scale)


ObstacleFile = Annotated[
    BoxFile | SphereFile | CylinderFile | CapsuleFile | MeshFile, pydantic.Field(discriminator="type")
]


class _Held(Strict):
    """What is carried: placed in the frame of a link of the robot, which it may touch, as it may ``touch_links``."""

    link: Name = pydantic.Field(min_length=1)
    touch_links: tuple[Name, ...] = ()


class CarriedBoxFile(_Held, BoxFile): ...


class CarriedSphereFile(_Held, SphereFile): ...


class CarriedCylinderFile(_Held, CylinderFile): ...


class CarriedCapsuleFile(_Held, CapsuleFile): ...


class CarriedMeshFile(_Held, MeshFile): ...


CarriedFile = Annotated[
    CarriedBoxFile | CarriedSphereFile | CarriedCylinderFile | CarriedCapsuleFile | CarriedMeshFile,
    pydantic.Field(discriminator="type"),
]


class PlacementFile(Strict):
    """How a scene sets a robot up: where its base stands, which tool it uses, what is held fixed."""

    base: PoseFile = PoseFile()
    tool: str | None = None
    fixed_joints: dict[str, Coordinate] = pydantic.Field(default_factory=dict)


class SceneFile(Strict):
    """What a scene file holds."""

    name: Name | None = None
    description: str = ""
    obstacles: list[ObstacleFile] = pydantic.Field(default_factory=list)
    carried: list[CarriedFile] = pydantic.Field(default_factory=list)
    states: dict[str, dict[str, str]] = pydantic.Field(default_factory=dict)
    robots: dict[str, PlacementFile] = pydantic.Field(default_factory=dict)

    @pydantic.model_validator(mode="after")
    def _distinct_names(self) -> SceneFile:
        names = [item.name for item in (*self.obstacles, *self.carried)]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"name '{twice[0]}' is used twice; names must differ, also those of carried things")
        return self


@dataclass(frozen=True, eq=False)
class Scene:
    """Obstacles in the world frame and the named states and set-up of each robot. Load with :meth:`load`."""

    name: str
    obstacles: tuple[Obstacle, ...] = ()
    description: str = ""
    states: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    robots: Mapping[str, PlacementFile] = field(default_factory=dict)
    carried: tuple[Carried, ...] = ()  # shapes that a link of the robot holds
    allowed: frozenset[frozenset[str]] = frozenset()  # pairs of names that may touch

    @staticmethod
    def load(name: str) -> Scene:
        """A built-in scene by name, or by path: our own YAML, MoveIt's PlanningScene as YAML or its ``.scene`` text.

        Raises :class:`SceneError` or ``FileError``.
        """
        path = scene_file(name) or Path(name)
        known = path.suffix.lower() in (".yaml", ".yml", ".scene")
        if not known and "/" not in name and not is_file(path):
            there = choices([*scene_names(), *published_scene_names()])
            raise SceneError(f"scene '{name}' not found; scenes are {there}, or give the path of a scene file.")
        where = f"scene file {path}"
        text = read_text(path, "scene file")
        if path.suffix.lower() == ".scene":
            return _from_moveit(scene_text(text, path))
        data = parse_yaml(text, where)
        if looks_like_planning_scene(data):
            return _from_moveit(planning_scene(data, path))
        return _build(validate(SceneFile, data, where, SceneError), path)

    def placement(self, robot: str) -> PlacementFile:
        """How this scene sets up a robot; the default where it says nothing."""
        return self.robots.get(robot, PlacementFile())

    def states_of(self, robot: str) -> Mapping[str, str]:
        return self.states.get(robot, {})

    @property
    def identity(self) -> str:
        """A hash of obstacles and permissions; their order does not matter, nor does a name without a permission."""
        solid = sorted(content_hash([*item.shape.content(), item.placement]) for item in self.obstacles)
        named = {item.object for item in self.obstacles}
        allowed = sorted(sorted(pair) for pair in self.allowed if pair & named)
        owners = sorted((item.object, item.placement.tolist()) for item in self.obstacles) if allowed else []
        return content_hash([solid, allowed, owners])


def _from_moveit(scene: PlanningScene) -> Scene:
    return Scene(scene.name, scene.obstacles, "from MoveIt", carried=scene.carried, allowed=scene.allowed)


def _build(file: SceneFile, path: Path) -> Scene:
    obstacles = tuple(Obstacle(item.name, item.shape(path.parent), item.matrix()) for item in file.obstacles)
    carried = tuple(
        Carried(item.link, item.name, item.shape(path.parent), item.matrix(), item.touch_links) for item in file.carried
    )
    return Scene(file.name or path.stem, obstacles, file.description, file.states, file.robots, carried)
