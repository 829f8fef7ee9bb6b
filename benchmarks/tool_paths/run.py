"""Measures tool paths that are followed: the share, the time, and deviations that a judge of its own sees.

How. Each path lies across the tool's axis around where that is in a random free configuration; the tool may turn about
its axis; for roboplan it keeps the turn with which ours begins, and begins there. The judge looks at the motion in time
every 0.05 mm of the tool's way, with Pinocchio's frames; coal looks every 0.5 mm. Rasters have 200 points. Seconds are
of CPU, first to motion. toppra (where it is installed) runs along the same curve without limits on jerk. Limitations.
Looks at 0.05 mm are no proof; the paths lie away from joint limits, so shares followed are those of reachable places.

Columns. One path. ``followed``: share of it, and by a ladder of four times as many solutions; ``position`` and
``angle``: the largest deviations that the judge saw, as shares of the tube; ``jump``: largest step of a joint between
two looks (rad); seconds of CPU from nothing without a motion, with another beta, and for the same again with a motion.
``toppra_s``: how long toppra takes along the same curve; then what roboplan's Cartesian planner makes of the path.
"""

from __future__ import annotations

import itertools
import re
import time
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import bench
from benchmarks.others import roboplan_runner
from benchmarks.others.elsewhere import answer_of, environments
from benchmarks.others.roboplan_law import describe_robot, roboplan_motion
from benchmarks.others.toppra_law import installed, toppra_duration
from benchmarks.text import markdown_table, median
from benchmarks.tool_paths.judge import deviations, states_every, tool_frames
from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.kinematics.manipulability import manipulability
from planner.planning.follow import Follower
from planner.planning.result import Plan
from planner.problem.request import FollowRequest, TimingRequest
from planner.query.query import make_checker_for
from planner.tool_paths.file import read_tool_path
from planner.tool_paths.tool_motion import ToolGuide
from planner.tool_paths.tool_path import ToolPath
from planner.trajectory.limits import MotionLimits
from planner.trajectory.timing import time_curve
from planner.trajectory.trajectory import Trajectory

KINDS = ("raster", "line", "circle")
_WAIT = 120.0  # s that roboplan may take
_DENSER = 4  # times the solutions, of the ladder that says what could be followed
_ROUND = 0.5  # of the limits' middle: begin with configurations that are not at a limit
_FIRST, _AGAIN = 1.0, 0.05  # s that are aimed at for a raster of 200 points
_OPTIMUM = 1.05  # of toppra's duration
_WHOLE = 1.0 - 1e-9  # share of a path that counts as followed


def tool_paths(
    out: bench.Out = Path("bench-tool-paths"),
    robots: tuple[str, ...] = ("panda", "iiwa14", "ur5"),
    scenes: tuple[str, ...] = ("empty", "table"),
    kinds: tuple[str, ...] = KINDS,
    paths: int = 3,
    seed: int = 0,
    python: tuple[str, ...] = (),
    debug: bench.Debug = False,
) -> int:
    """Rasters, lines and circles of the tool: what share is followed, how fast, and what a judge of its own sees.

    It looks at the motion every 0.05 mm. Writes tool-paths.csv, one row a path, and tool-paths.md.

    Args:
        robots: Names of built-in robots.
        scenes: Names of built-in scenes.
        kinds: Kinds of paths.
        paths: Paths of each kind, for every robot in every scene.
        seed: Seed of the first path.
        python: roboplan=PATH, the Python of an environment with roboplan, whose Cartesian planner is asked too.
    """
    other = environments(python).get("roboplan", "")
    for kind in kinds:
        if kind not in KINDS:
            raise OptionError(f"kind '{kind}' not found; kinds are {', '.join(KINDS)}.")
    settings = itertools.product(robots, scenes, kinds, range(seed, seed + paths))
    rows = [bench.make_settings("robot scene kind seed", *each) for each in settings]
    return bench.run_bench(BENCH, out, [bench.Case((row,), row) for row in rows], partial(_measure, python=other))


def path_of(case: bench.Row, checker: CollisionChecker) -> ToolPath:
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


def _measure(case: bench.Row, progress: Progress, python: str) -> dict[str, Any]:
    request = FollowRequest.from_options(robot=case.robot, scene=case.scene, seed=case.seed)
    checker = make_checker_for(request.what)
    path = path_of(case, checker)
    begin = time.process_time()
    follower = Follower.from_tool_path(path, request)
    first = follower.plan(request)
    planned = time.process_time()
    follower.plan(request.with_options(beta=0.2))
    again = time.process_time()
    timed = follower.plan(request, timing=TimingRequest())
    motion = time.process_time()
    found = timed.tool_path
    assert found is not None
    columns: dict[str, Any] = {"first_s": planned - begin, "again_s": again - planned, "motion_s": motion - again}
    columns |= {"points": int(path.given.max()), "followed": found.record.followed, "proven": found.record.proven}
    columns |= {"denser": Follower.from_tool_path(path, request.with_options(ladder_density=_DENSER)).reached.share}
    columns |= dict.fromkeys(_JUDGED, 0.0) if timed.trajectory is None else _judged(timed.trajectory, checker, path)
    columns |= {"toppra_s": _toppra(follower, timed)} if installed() and len(timed.path) > 1 else {}
    columns |= _by_roboplan(python, timed, checker, path) if python and len(timed.path) else {}
    return columns | {"outcome": first.outcome.key}


def _toppra(follower: Follower, timed: Plan) -> float:
    """Seconds of toppra along the same curve, without limits on jerk."""
    robot, limits = timed.robot, MotionLimits.from_robot(timed.robot)
    places = follower.reached.along[timed.path_nodes]
    guide = ToolGuide.from_path(timed.path, places, robot, follower.reached.ladder.tube, None)
    _, curve = time_curve(timed.path, timed.checker, limits, "blended", 0.0, guide=guide)
    joints = np.ascontiguousarray(curve.coefficients[..., : robot.dof])
    return toppra_duration(replace(curve, coefficients=joints), limits.velocity, limits.acceleration)


def _by_roboplan(python: str, timed: Plan, checker: CollisionChecker, path: ToolPath) -> dict[str, Any]:
    """What roboplan's Cartesian planner makes of a path, from where ours begins, with the orientation there."""
    robot, limits = timed.robot, MotionLimits.from_robot(timed.robot)
    poses = np.tile(np.eye(4), (len(path.positions), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = tool_frames(robot, timed.path[:1])[0], path.positions
    problem = describe_robot(robot, limits) | {
        "tool": robot.tool,
        "poses": (np.linalg.inv(robot.base) @ poses).tolist(),  # it knows of no scene that places the robot
        "start": timed.path[0].tolist(),
        "tube": asdict(path.tube),
    }
    found = answer_of("roboplan", python, roboplan_runner.__file__, problem, _WAIT, ["follow"])
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


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """Return a line per robot, scene and kind, and a comparison with roboplan."""
    columns: dict[str, bench.Pick] = {
        "paths": len,
        "whole": bench.total(lambda row: row.followed >= _WHOLE),
        "denser": bench.total(lambda row: row.denser >= _WHOLE),
        "off / tube": bench.most(lambda row: max(row.position, row.angle)),
        "jump (rad)": bench.most("jump"),
        "first (s)": bench.middle("first_s"),
        "again (s)": bench.middle("again_s"),
        "motion (s)": bench.middle("motion_s"),
    }
    both = [row for row in rows if row.roboplan_followed is not None]
    return bench.table(rows, ["robot", "scene", "kind"], columns) + (_compare_with_roboplan(both) if both else [])


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """The aims of following, and the number of rows that meet them."""
    moved, whole = [row for row in rows if row.followed > 0], [row for row in rows if row.denser >= _WHOLE]
    rasters = [row for row in rows if row.kind == "raster" and row.followed >= _WHOLE]
    followed, compared = [row.followed >= _WHOLE for row in whole], [row for row in rows if row.toppra_s]
    inside = [max(row.position, row.angle) <= 1.0 for row in moved]
    slower = f"A motion takes {_OPTIMUM:g} of the time that toppra takes along the same curve."
    return (
        bench.tally("A path that four times the solutions follow is followed.", followed, ""),
        bench.tally("What is followed is proven.", [row.proven for row in moved], ""),
        bench.tally("No look finds the tool outside the tube.", inside, ""),
        bench.tally("coal finds no contact.", [row.contacts == 0 for row in moved], ""),
        bench.tally(f"A raster is planned in {_FIRST:g} s.", [row.first_s <= _FIRST for row in rasters], ""),
        bench.tally(slower, [row.duration <= _OPTIMUM * (row.toppra_s or 0.0) for row in compared], ""),
        bench.tally(f"Another beta takes {_AGAIN:g} s.", [row.again_s <= _AGAIN for row in rasters], ""),
    )


def _compare_with_roboplan(rows: Sequence[bench.Row]) -> list[str]:
    """Shares followed, deviations, smallest w and durations, ours and roboplan's."""
    header = ["software", "share followed, mean", "whole", "deviation / tube", "contacts", "w, median", "s, median"]
    shares = [row.followed for row in rows], [row.roboplan_followed or 0.0 for row in rows]
    both = [row for k, row in enumerate(rows) if min(of[k] for of in shares) >= _WHOLE]
    lines = []
    for name, prefix, of in zip(("ours", "roboplan"), ("", "roboplan_"), shares, strict=True):
        found = {key: [getattr(row, prefix + key) or 0.0 for row in both] for key in _JUDGED if key != "jump"}
        off = max([*found["position"], *found["angle"]], default=0.0)
        middle = [median(found[key]) for key in ("w_min", "duration")]
        lines.append([name, sum(of) / len(of), sum(s >= _WHOLE for s in of), off, sum(found["contacts"]), *middle])
    said = "Roboplan's Cartesian planner on the same paths; from the third number on where both follow all:"
    return [said, "", *markdown_table(header, lines)]


BENCH = bench.Bench("tool-paths", __doc__, tables, aims)
