"""``benchmarks tool-paths``: seeded rasters, lines and circles of several robots, followed, timed and judged."""

from __future__ import annotations

import itertools
import re
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import run_bench, software
from benchmarks.elsewhere import answer_of
from benchmarks.motion.other_law import roboplan_motion, told
from benchmarks.motion.toppra_law import installed, toppra_duration
from benchmarks.results import Results
from benchmarks.tool_paths import runner
from benchmarks.tool_paths.judge import deviations, states_every, tool_frames
from benchmarks.tool_paths.report import Row, to_markdown
from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.kinematics.manipulability import manipulability
from planner.planning.follow import Follower
from planner.planning.result import Plan
from planner.problem.request import FollowRequest, TimingRequest
from planner.setup.open import open_world
from planner.tool_paths.file import read_tool_path
from planner.tool_paths.timing import ToolGuide
from planner.tool_paths.tool_path import ToolPath
from planner.trajectory.limits import MotionLimits
from planner.trajectory.timing import timed_curve
from planner.trajectory.trajectory import Trajectory

KINDS = ("raster", "line", "circle")
_WAIT = 120.0  # s that roboplan may take
_DENSER = 4  # times the solutions, of the ladder that says what could be followed
_ROUND = 0.5  # of the limits' middle: begin with configurations that are not at a limit


@dataclass(frozen=True)
class Case:
    """One path."""

    robot: str
    scene: str
    kind: str
    seed: int

    @property
    def key(self) -> tuple[str, str, str, int, str]:
        return (self.robot, self.scene, self.kind, self.seed, software())


def bench_tool_paths(
    out: Path,
    robots: Sequence[str] = ("panda", "iiwa14", "ur5"),
    scenes: Sequence[str] = ("empty", "table"),
    kinds: Sequence[str] = KINDS,
    paths: int = 3,
    seed: int = 0,
    python: str = "",
    progress: Progress = QUIET,
) -> Results[Row]:
    """``paths`` paths of each kind for every robot in every scene; writes ``tool-paths.csv`` and ``tool-paths.md``.

    ``python``: that of roboplan's environment, whose Cartesian planner is asked too; none where it is empty.

    Raises :class:`OptionError` for kinds that are not there and no paths, FileError where the folder cannot be used.
    """
    for kind in kinds:
        if kind not in KINDS:
            raise OptionError(f"kind '{kind}' not found; kinds are {', '.join(KINDS)}.")
    cases = [Case(*each) for each in itertools.product(robots, scenes, kinds, range(seed, seed + paths))]
    found = run_bench(
        out, "tool-paths", Row, cases, lambda table, case: table.find(case.key),
        lambda case, progress: _measure(case, python), to_markdown, "paths", progress,
    )  # fmt: skip
    return found


def path_of(case: Case, checker: CollisionChecker) -> ToolPath:
    """A path around where the tool is in a free configuration: 200 points of a raster, a line, or a circle.

    Across the tool's z axis, about which it may turn.
    """
    rng, robot = np.random.default_rng([KINDS.index(case.kind), case.seed]), checker.robot
    middle, half = 0.5 * (robot.lower + robot.upper), 0.5 * (robot.upper - robot.lower)
    half = np.where(robot.continuous, np.pi, half)
    while True:
        q = middle + _ROUND * half * rng.uniform(-1, 1, robot.dof)
        if checker.first_contact(q[None]) is None and manipulability(robot, q[None])[0] > 0.02:
            break
    rotation, position = tool_frames(robot, q[None])
    axis = rotation[0, :, 2]
    points = position[0] + _flat_points(case.kind) @ rotation[0, :, :2].T
    given: list[dict[str, Any]] = [{"position": point.tolist(), "axis": axis.tolist()} for point in points]
    if case.kind == "circle":
        for point in given[1::2]:
            point["via"] = "arc"
    return read_tool_path({"name": case.kind, "points": given})


def _flat_points(kind: str) -> Floats:
    """Points (k, 2) in m: 10 rows of 20 a centimetre apart, 0.3 m straight, or round in 0.1 m."""
    if kind == "line":
        return np.array([[-0.15, 0.0], [0.15, 0.0]])
    if kind == "circle":
        angles = 0.5 * np.pi * np.arange(5)
        return 0.1 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rows = [(0.01 * (x if y % 2 == 0 else 19 - x) - 0.095, 0.01 * y - 0.045) for y in range(10) for x in range(20)]
    return np.array(rows)


def _measure(case: Case, python: str) -> list[Row]:
    request = FollowRequest(robot=case.robot, scene=case.scene, seed=case.seed)
    checker = open_world(request)
    path = path_of(case, checker)
    begin = time.process_time()
    follower = Follower.of(path, request)
    first = follower.plan(request)
    planned = time.process_time()
    follower.plan(replace(request, beta=0.2))
    again = time.process_time()
    timed = follower.plan(request, timing=TimingRequest())
    motion = time.process_time()
    denser = Follower.of(path, replace(request, ladder_density=_DENSER)).found.share
    found = timed.tool_path
    assert found is not None
    judged: dict[str, Any] = dict.fromkeys(_JUDGED, 0)
    if timed.trajectory is not None:
        judged = _judged(timed.trajectory, checker, path)
    seconds: dict[str, Any] = {"first_s": planned - begin, "again_s": again - planned, "motion_s": motion - again}
    share: dict[str, Any] = {"points": int(path.given.max()), "followed": found.record.followed, "denser": denser}
    others: dict[str, Any] = {"toppra_s": _toppra(follower, timed)} if installed() and len(timed.path) > 1 else {}
    others |= _by_roboplan(python, timed, checker, path) if python and len(timed.path) else {}
    kept: dict[str, Any] = {"proven": found.record.proven, "outcome": first.outcome.key}
    return [Row(*case.key, **share, **judged, **seconds, **kept, **others)]


def _toppra(follower: Follower, timed: Plan) -> float:
    """Seconds of toppra along the same curve, without limits on jerk."""
    robot, limits = timed.robot, MotionLimits.of(timed.robot)
    places = follower.found.along[timed.path_nodes]
    guide = ToolGuide.of(timed.path, places, robot, follower.found.ladder.tube, None)
    _, curve = timed_curve(timed.path, timed.checker, limits, "blended", 0.0, guide=guide)
    joints = np.ascontiguousarray(curve.coefficients[..., : robot.dof])
    return toppra_duration(replace(curve, coefficients=joints), limits.velocity, limits.acceleration)


def _by_roboplan(python: str, timed: Plan, checker: CollisionChecker, path: ToolPath) -> dict[str, Any]:
    """What roboplan's Cartesian planner makes of a path, from where ours begins, with the orientation there."""
    robot, limits = timed.robot, MotionLimits.of(timed.robot)
    poses = np.tile(np.eye(4), (len(path.positions), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = tool_frames(robot, timed.path[:1])[0], path.positions
    problem = told(robot, limits) | {
        "tool": robot.tool,
        "poses": (np.linalg.inv(robot.base) @ poses).tolist(),  # it knows of no scene that places the robot
        "start": timed.path[0].tolist(),
        "tube": asdict(path.tube),
    }
    found = answer_of("roboplan", python, runner.__file__, problem, _WAIT)
    if "times" not in found:
        stuck = re.search(r"path fraction ([0-9.]+)", found["message"])
        return {"roboplan_followed": float(stuck[1]) if stuck else 0.0}
    judged = _judged(roboplan_motion(found, limits), checker, path)
    return {"roboplan_followed": 1.0, **{f"roboplan_{name}": value for name, value in judged.items() if name != "jump"}}


_JUDGED = ("position", "angle", "contacts", "jump", "w_min", "duration")


def _judged(made: Trajectory, checker: CollisionChecker, path: ToolPath) -> dict[str, Any]:
    """Largest deviations as shares of the tube, contacts by coal, largest step of a joint, smallest w, s."""
    robot, q = checker.robot, states_every(made, checker.robot)
    off, angle = deviations(path, *tool_frames(robot, q))
    coal = make_checker(robot, checker.world.scene, "coal")
    contacts = sum(coal.first_contact(part) is not None for part in np.array_split(q[::10], 10))
    jump = float(np.abs(np.diff(q, axis=0)).max())
    w = float(manipulability(robot, q[::10]).min())
    tube = path.tube
    found = (off.max() / tube.position, angle.max() / tube.angle, contacts, jump, w, made.duration)
    return dict(zip(_JUDGED, found, strict=True))
