"""The robot of a request, objects that it attaches and detaches, and every file that a request reads.

A process reads a robot once while its files do not change, and returns the same object, as reaches, hulls and pairs are
cached per object.
"""

import contextlib
import hashlib
import logging
import os
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TypeVar, get_args

import numpy as np

from planner.base.arrays import Bools, Floats, frozen
from planner.base.cache import load_or_compute
from planner.base.errors import Note, OptionError, PlannerError, RobotError
from planner.base.files import StrPath
from planner.base.resources import scene_file
from planner.base.yamlfile import parse_yaml, read_text
from planner.collision import make_checker
from planner.collision.checker import APART, CollisionChecker
from planner.kinematics.forward import joint_placements, tool_pose
from planner.kinematics.manipulability import BANDS, is_always_singular, manipulability
from planner.problem.options import Measure, MeasureName, Rows
from planner.problem.request import PlanRequest, SweepRequest, WorldRequest
from planner.problem.targets import TURN, Joints, Target
from planner.query.resolve import looks_like_degrees
from planner.robot.cell import Cell
from planner.robot.files.packages import PATHS
from planner.robot.files.planar import Area
from planner.robot.files.robot_files import JointChoice, RobotFiles, find_robot, read_robot, robot_file
from planner.robot.files.urdf import read_description
from planner.robot.files.urdf_geometry import mesh_files
from planner.robot.moveit.requests import MotionPlanRequest, choose_joints, request_notes, start_values
from planner.robot.poses import pose
from planner.robot.robot import Robot, assemble, with_carried, with_tool, with_widened_limits
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Obstacle

_NEAR = 200  # random configurations around mid-range

_log = logging.getLogger(__name__)

_known: dict[tuple[object, ...], tuple[RobotFiles, dict[Path, tuple[int, int] | None]]] = {}


def robot_of(request: WorldRequest, scene: Scene, message: MotionPlanRequest | None) -> Robot:
    """Return the robot as scene and request set it up; a Robot object keeps its own files and base."""
    if isinstance(request.robot, Robot):
        for option in ("srdf", "group", "joints", "base", "base_limits"):
            if getattr(request, option) is not None:
                text = f"{option} needs a robot given by name or path, got a Robot: give it to Robot.load."
                raise OptionError(text)
        robot = with_tool(request.robot, request.tool)
        return _set_up(
            with_measure(robot, request.jacobian_rows, request.manipulability), scene, message, JointChoice()
        )
    if not isinstance(request.robot, str):
        kind = f"{type(request.robot).__name__}: see planner.Robot.from_pinocchio."
        raise TypeError(f"robot must be a name, a file or a planner.Robot, got {kind}")
    files = files_of(request.robot, request.srdf, request.base_limits)
    placement = scene.placement(files.name)
    tool, fixed = request.tool or placement.tool, dict(placement.fixed_joints)
    choice = JointChoice(request.group, request.joints)
    if message is not None:
        choice, start = choose_joints(message, choice, files), start_values(message, scene)
        planned = files.select_joints(tool, choice, fixed)
        free = [name for name in files.model.names[1:] if name in start and name not in planned]
        held = {name: start[name] for name in free if files.description.mimic(name).leader not in planned}
        _log.info("joints that are not planned are held as the request has them: %s", held or "it names none")
        fixed |= held
    base = placement.base.matrix() if request.base is None else pose(request.base[:3], request.base[3:] or None)
    robot = _assemble(files, tool, choice, tuple(fixed.items()), tuple(np.ravel(base).tolist()))
    robot = with_measure(robot, request.jacobian_rows, request.manipulability)
    return _set_up(robot, scene, message, choice)


W = TypeVar("W", bound=WorldRequest)


def open_cell(request: W) -> W:
    """Return the request with the composite robot and the scene of its cell in place of the cell."""
    if request.cell is None:
        return request
    cell = load_cell(request.cell)
    return replace(request, cell=None, robot=cell.robot, scene=cell.scene)


def load_cell(cell: object) -> Cell:
    """Return a cell, or the one of a file, which a process reads once while it does not change."""
    if isinstance(cell, Cell):
        return cell
    if not isinstance(cell, str):
        raise TypeError(f"cell must be a file or a planner.Cell, got {type(cell).__name__}.")
    return _read_cell(cell, os.stat(cell).st_mtime_ns if os.path.isfile(cell) else 0)


@lru_cache(maxsize=4)
def _read_cell(path: str, _: int) -> Cell:
    return Cell.load(path)


def at_usable_home(files: RobotFiles, robot: Robot) -> Robot:
    """Return the robot of ``files``, with another home if they have none and zero is unusable."""
    if {*files.home} & {*robot.joints}:
        return robot
    home = load_or_compute("homes", [robot.identity, _NEAR, BANDS["poor"]], lambda: {"home": _usable_home(robot)})[
        "home"
    ]
    if np.array_equal(home, robot.home):
        return robot
    text = "No file has a home, and with all joints at zero links touch or the arm is singular: home is "
    note = Note(f"{text}q:{','.join(f'{value:g}' for value in home.tolist())} instead.")
    return replace(robot, home=frozen(home), notes=(*robot.notes, note))


def _usable_home(robot: Robot) -> Floats:
    """Return a free home (dof,): the robot's own unless w is poor, else a usable one near mid-range.

    A usable one has at least the median w of random configurations around mid-range.
    """
    span = np.minimum(robot.upper - robot.lower, TURN)
    random = np.random.default_rng(0).uniform(-0.5, 0.5, size=(_NEAR, robot.dof))
    random[0] = 0.0
    random = random[np.argsort(np.abs(random).sum(axis=1), kind="stable")]
    q = np.round(0.5 * (robot.lower + robot.upper) + random * span, 3)  # rounded for readers
    q = np.vstack([robot.home, np.clip(q, robot.lower, robot.upper)])
    free = ~touching_pairs(make_checker(robot, Scene("none"), "coal"), q).any(axis=1)
    w = manipulability(with_measure(robot, None, robot.measure), q)
    wanted = np.median(w[1:]) * np.append(BANDS["poor"], np.ones(_NEAR))
    rows = np.flatnonzero(free & (w >= wanted))
    rows = rows if len(rows) else np.flatnonzero(free)
    return q[rows[0]] if len(rows) else robot.home


def touching_pairs(checker: CollisionChecker, q: Floats) -> Bools:
    """Return (n, pairs) which pairs are not proven apart in configurations (n, dof)."""
    rotation, position = joint_placements(checker.chain, q)
    touching = checker.bound.coarse(rotation, position) <= 0
    rows, pairs = np.nonzero(touching)
    touching[rows, pairs] = checker.bound.close(rotation, position, rows, pairs, APART) <= 0
    return touching


@lru_cache(maxsize=16)
def with_measure(robot: Robot, rows: Rows | None, measure: Measure) -> Robot:
    """Return the robot with other rows of its Jacobian and another measure.

    All six rows if w of its own rows is 0 everywhere; :class:`RobotError` if w of the given ``rows`` is.
    """
    made = replace(robot, jacobian_rows=rows or robot.jacobian_rows, measure=measure)
    if measure not in get_args(MeasureName) or not is_always_singular(made):
        return robot if measure == robot.measure and rows in (None, robot.jacobian_rows) else made
    text = f"w of the {made.jacobian_rows} rows is 0 in every configuration with tool frame '{robot.tool_text}'"
    if rows is not None:
        raise RobotError(f"{text}: choose other --jacobian-rows, or another --tool.")
    note = Note(f"{text}: w is computed from all six rows; choose with --jacobian-rows, or another --tool.")
    return replace(made, jacobian_rows="pose", notes=(*robot.notes, note))


def _set_up(robot: Robot, scene: Scene, message: MotionPlanRequest | None, choice: JointChoice) -> Robot:
    """Return the robot with the scene's carried shapes, and limit scales and notes of a MoveIt request."""
    robot = with_carried(robot, scene.carried) if scene.carried else robot
    if message is None:
        return robot
    return _with_shares(robot, tuple(message.shares.items()), tuple(request_notes(message, robot, choice)))


@lru_cache(maxsize=16)
def _with_shares(robot: Robot, shares: tuple[tuple[str, float], ...], notes: tuple[Note, ...]) -> Robot:
    """Return the same object for the same arguments, so that its caches serve again."""
    return replace(robot, shares=dict(shares), notes=(*robot.notes, *notes))


def widen_limits_for(robot: Robot, targets: list[Target]) -> Robot:
    """Return the robot with limits widened to joint targets, except those that look like degrees."""
    wanted = [np.array(t.values) for t in targets if isinstance(t, Joints) and len(t.values) == robot.dof]
    wanted = [q for q in wanted if np.isfinite(q).all() and not looks_like_degrees(robot, q)]
    wide = with_widened_limits(robot, np.array(wanted)) if wanted else robot
    wider = np.flatnonzero((wide.lower < robot.lower) | (wide.upper > robot.upper))
    texts = [f"limits of {robot.joints[k]} widened to [{wide.lower[k]:.4f}, {wide.upper[k]:.4f}]" for k in wider]
    return replace(wide, notes=(*robot.notes, *map(Note, texts))) if texts else robot


def files_of(name: str, srdf: StrPath | None, area: Area | None = None) -> RobotFiles:
    """Return the robot's files, read again if one of them has changed.

    A xacro or MJCF file is read each time, as it may include unknown files.
    """
    key = name, srdf, area, *map(os.environ.get, PATHS)
    files, stamps = _known.get(key, (None, {}))
    if files is None or any(_stamp(path) != stamp for path, stamp in stamps.items()):
        files = read_robot(name, srdf, area)
        if files.description.path.suffix.lower() not in (".xacro", ".xml"):
            own = [files.srdf.path] if files.srdf else []
            paths = robot_file(files.origin), files.description.path, *own, *mesh_files(files.description)
            _known[key] = files, {path: _stamp(path) for path in paths}
    return files


@lru_cache(maxsize=16)
def _assemble(
    files: RobotFiles,
    tool: str | None,
    choice: JointChoice,
    fixed: tuple[tuple[str, float], ...],
    base: tuple[float, ...],
) -> Robot:
    return at_usable_home(files, assemble(files, tool, choice, dict(fixed), np.reshape(base, (4, 4))))


def _stamp(path: Path) -> tuple[int, int] | None:
    """Return ctime (ns), which programs cannot set as mtime, and size of a file; None without a file."""
    try:
        stat = path.stat()
    except (OSError, ValueError):
        return None
    return stat.st_ctime_ns, stat.st_size


def attach_object(
    scene: Scene, item: Obstacle, robot: Robot, link: str, q: Floats, touch_links: tuple[str, ...] = ()
) -> Scene:
    """Return the scene with its obstacle ``item`` carried by ``link``, attached in configuration ``q``."""
    held = frozen(np.linalg.inv(_hand(robot, link, q)) @ item.placement)
    carried = Carried(link, item.name, item.shape, held, touch_links, speed_limit=item.speed_limit)
    obstacles = tuple(other for other in scene.obstacles if other is not item)
    return replace(scene, obstacles=obstacles, carried=(*scene.carried, carried))


def detach_object(scene: Scene, item: Carried, robot: Robot, q: Floats) -> Scene:
    """Return the scene with the carried ``item`` as an obstacle, detached in configuration ``q``."""
    put_down = Obstacle(item.name, item.shape, placement_in_hand(item, robot, q), speed_limit=item.speed_limit)
    carried = tuple(other for other in scene.carried if other is not item)
    return replace(scene, obstacles=(*scene.obstacles, put_down), carried=carried)


def placement_in_hand(item: Carried, robot: Robot, q: Floats) -> Floats:
    """Return the placement (4, 4) of a carried ``item`` in the configuration ``q`` (dof,)."""
    return frozen(_hand(robot, item.link, q) @ item.placement)


def _hand(robot: Robot, link: str, q: Floats) -> Floats:
    return tool_pose(with_tool(robot, link), q).homogeneous


def sources_hash(request: SweepRequest | PlanRequest) -> str:
    """Return SHA-256 (hex) over the files of a request: robot, scene, meshes, MoveIt request, roadmap.

    Missing files are hashed as such: the plan refuses them.
    """
    digest = hashlib.sha256()
    what = request.what
    more = (path for path in (what.motion_plan_request, request.quality.roadmap) if path is not None)
    for path in (*robot_sources(str(what.robot), what.srdf), *scene_sources(str(what.scene)), *more):
        try:
            digest.update(hashlib.sha256(Path(path).read_bytes()).digest())
        except (OSError, ValueError):
            digest.update(b"missing")
    return digest.hexdigest()


def robot_sources(name: str, srdf: StrPath | None = None) -> Iterator[Path]:
    """Yield robot.yaml or URDF, then the files that they name: URDF, SRDF, meshes; each before it is read."""
    yield robot_file(name)
    with contextlib.suppress(PlannerError):
        folder, file = find_robot(name)
        found, own = file.urdf.path(folder), file.srdf.path(folder) if file.srdf else None
        yield from (Path(path) for path in (found, srdf or own) if path is not None)
        if found.suffix.lower() == ".xacro":  # it may name any of these
            yield from (path for kind in ("*.xacro", "*.yaml") for path in sorted(found.parent.parent.rglob(kind)))
        yield from mesh_files(read_description(found, file.urdf.args))


def scene_sources(name: str) -> Iterator[Path]:
    """Yield the scene's file before it is read, and its meshes."""
    path = scene_file(name) or Path(name)
    yield path
    if path.suffix.lower() in (".yaml", ".yml") and path.is_file():
        with contextlib.suppress(PlannerError):
            data = parse_yaml(read_text(path, "scene file"), "scene file")
            things = [data.get(key) for key in ("obstacles", "carried")] if isinstance(data, dict) else []
            items = [item for each in things if isinstance(each, list) for item in each if isinstance(item, dict)]
            yield from (path.parent / item["file"] for item in items if isinstance(item.get("file"), str))
