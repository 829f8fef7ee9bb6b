"""``benchmarks tool-paths``: seeded rasters, lines and circles of several robots, followed, timed and judged."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import run_bench, software
from benchmarks.tool_paths.judge import deviations, states_every, tool_frames
from benchmarks.tool_paths.report import Row, to_markdown
from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.batch.results import Results
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.kinematics.manipulability import manipulability
from planner.planning.follow import Follower
from planner.planning.result import Plan
from planner.problem.request import FollowRequest, TimingRequest
from planner.setup.open import open_world
from planner.tool_paths.file import read_tool_path
from planner.tool_paths.tool_path import ToolPath

KINDS = ("raster", "line", "circle")
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
    progress: Progress = QUIET,
) -> Results[Row]:
    """``paths`` paths of each kind for every robot in every scene; writes ``tool-paths.csv`` and ``tool-paths.md``.

    Raises :class:`OptionError` for kinds that are not there and no paths, FileError where the folder cannot be used.
    """
    for kind in kinds:
        if kind not in KINDS:
            raise OptionError(f"kind '{kind}' not found; kinds are {', '.join(KINDS)}.")
    cases = [Case(*each) for each in itertools.product(robots, scenes, kinds, range(seed, seed + paths))]
    found = run_bench(
        out, "tool-paths", Row, cases, lambda table, case: table.find(case.key),
        lambda case, progress: _measure(case), to_markdown, "paths", progress,
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


def _measure(case: Case) -> list[Row]:
    request = FollowRequest(robot=case.robot, scene=case.scene, seed=case.seed)
    checker = open_world(request)
    path = path_of(case, checker)
    begin = time.perf_counter()
    follower = Follower.of(path, request)
    first = follower.plan(request)
    planned = time.perf_counter()
    follower.plan(replace(request, beta=0.2))
    again = time.perf_counter()
    timed = follower.plan(request, timing=TimingRequest())
    motion = time.perf_counter()
    denser = Follower.of(path, replace(request, ladder_density=_DENSER)).followed
    found = timed.tool_path
    assert found is not None
    judged: dict[str, Any] = _judged(timed, path) if len(timed.path) > 1 else dict.fromkeys(_JUDGED, 0)
    seconds: dict[str, Any] = {"first_s": planned - begin, "again_s": again - planned, "motion_s": motion - again}
    share: dict[str, Any] = {"points": int(path.given.max()), "followed": found.record.followed, "denser": denser}
    return [Row(*case.key, **share, proven=found.record.proven, **judged, **seconds, outcome=first.outcome.key)]


_JUDGED = ("position", "angle", "contacts", "jump", "w_min", "duration")


def _judged(plan: Plan, path: ToolPath) -> dict[str, Any]:
    """Largest deviations as shares of the tube, contacts by coal, largest step of a joint, smallest w, s."""
    assert plan.trajectory is not None
    q = states_every(plan.trajectory, plan.robot)
    off, angle = deviations(path, *tool_frames(plan.robot, q))
    coal = make_checker(plan.robot, plan.scene, "coal")
    contacts = sum(coal.first_contact(part) is not None for part in np.array_split(q[::10], 10))
    jump = float(np.abs(np.diff(plan.path, axis=0)).max())
    w = float(manipulability(plan.robot, q[::10]).min())
    tube = path.tube
    found = (off.max() / tube.position, angle.max() / tube.angle, contacts, jump, w, plan.trajectory.duration)
    return dict(zip(_JUDGED, found, strict=True))
