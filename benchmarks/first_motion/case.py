"""One run of ``benchmarks first-motion``, in a process of its own: a motion by one method, and a dense look at it."""

from __future__ import annotations

import contextlib
import gc
import importlib.metadata
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.first_motion.report import OMPL, OURS, WHOLE
from benchmarks.looks import FirstPath, largest_share, motion_contact, other_checker, path_contacts
from benchmarks.others import solver_runner
from benchmarks.others.elsewhere import ROBOPLAN, answer_of
from benchmarks.others.exchange import describe_problem
from benchmarks.others.ompl import OmplConnect
from benchmarks.others.roboplan_law import roboplan_motion, time_by_roboplan_elsewhere
from benchmarks.problems import read_request
from benchmarks.roadmap.case import plain_check
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.progress import Progress
from planner.batch.run import NO_PATH, REFUSED, SOLVED
from planner.planning.plan import plan
from planner.problem.request import LimitsRequest, PlanRequest, TimingRequest
from planner.problem.targets import joints_text
from planner.query.query import Query, make_query
from planner.robot.scene import Scene
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.measure import count_corners, joint_path_length
from planner.trajectory.trajectory import Trajectory

_WAIT = 30.0  # s that a process of another environment may take beyond the time for its search

Columns = dict[str, Any]


@dataclass(frozen=True, eq=False)
class _Found:
    """A path (k, dof) and a motion along it, where there are any; ``kinds`` of limits that the motion is to keep."""

    columns: Columns
    path: Floats | None
    motion: Trajectory | None = None
    kinds: Sequence[str] = KINDS


def measure(method: str, python: str, request: Columns, motion: Columns, seconds: float) -> Columns:
    """The columns of one row; ``python`` runs methods of other environments."""
    plain, asked = read_request(request), LimitsRequest(**motion)
    try:
        query = make_query(plain.what)
        limits = MotionLimits.from_robot(query.robot, asked)
        if method in (OURS, WHOLE):
            found = _ours(query, plain.with_options(path_only=method == OURS), asked)
        elif method == OMPL:
            found = _ompl(query, plain.quality.seed, seconds)
        else:
            found = _other(method, python, query, plain.quality.seed, seconds)
        if method == ROBOPLAN:
            found = _add_roboplan_motion(found, python, query, limits)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    if found.path is None:
        return {"outcome": NO_PATH, **found.columns}
    return {"outcome": SOLVED, **found.columns, **_measure_contacts(query, found, limits, plain.what.collision)}


def _ours(query: Query, request: PlanRequest, motion: LimitsRequest) -> _Found:
    """``planner plan``, without its page, after a plan of the same robot where nothing stands.

    Robot, scene and states are in memory then, and all that belongs to the robot is made.
    """
    ends = {"start": joints_text(query.starts[0]), "goal": joints_text(query.goals[0])}
    scene = replace(query.scene, carried=())  # the robot carries them already
    asked = request.with_options(robot=query.robot, scene=scene, motion_plan_request=None, widen_limits=False, **ends)
    timing = TimingRequest(**vars(motion))
    with contextlib.suppress(PlannerError):
        plan(request=asked.with_options(scene=Scene("empty")), timing=timing)
    gc.collect()
    watch, cpu = FirstPath(), time.process_time()
    found = plan(request=asked, progress=Progress(watch), timing=timing)
    total, cpu = time.perf_counter() - watch.begin, time.process_time() - cpu
    columns: Columns = {"ready_s": found.timings["setup"], "cpu_s": cpu, "version": _version("gabf-planner")}
    made = found.trajectory
    if made is None:
        return _Found(columns | {"message": found.message}, None)
    ready, motion_s = found.timings["setup"], found.timings["timing"]
    path_s = total - ready - motion_s
    first_s = path_s if watch.seconds is None else watch.seconds - ready
    columns |= {"first_s": first_s, "path_s": path_s, "motion_s": motion_s, "total_s": total, "proven": made.proven}
    return _Found(columns, found.path, made)


def _version(package: str) -> str:
    return importlib.metadata.version(package)


def _ompl(query: Query, seed: int, seconds: float) -> _Found:
    """RRTConnect with Pinocchio's loop over all pairs of coal as state check, as its documentation shows."""
    gc.collect()
    begin, cpu = time.perf_counter(), time.process_time()
    connect = OmplConnect(query.robot, plain_check(query.checker), seed)
    columns: Columns = {"ready_s": time.perf_counter() - begin, "version": _version("ompl"), "proven": False}
    begin = time.perf_counter()
    solved = connect.solve(query.starts[0], query.goals[0], seconds)
    columns["first_s"] = time.perf_counter() - begin
    path = connect.simplify() if solved else None
    if solved:
        columns["path_s"] = time.perf_counter() - begin
    return _Found(columns | {"cpu_s": time.process_time() - cpu}, path)


def _other(method: str, python: str, query: Query, seed: int, seconds: float) -> _Found:
    """What :mod:`benchmarks.others.solver_runner` answers, run by another Python."""
    problem = describe_problem(query, seed, seconds)
    columns = answer_of(method, python, solver_runner.__file__, problem, seconds + _WAIT, [method])
    path = columns.pop("path")
    return _Found(columns, None if path is None else query.robot.unwound(np.array(path)))


def _add_roboplan_motion(found: _Found, python: str, query: Query, limits: MotionLimits) -> _Found:
    """roboplan's path with its motion, which knows no limits on jerk; what it does not time has none."""
    if found.path is None:
        return found
    timed = time_by_roboplan_elsewhere(python, found.path, query.robot, limits)
    if "times" not in timed:
        return replace(found, columns=found.columns | {"message": f"not timed: {timed['message']}"})
    motion_s = timed["motion_s"]
    total = found.columns["ready_s"] + found.columns["path_s"] + motion_s
    columns = found.columns | {"motion_s": motion_s, "total_s": total}
    return replace(found, columns=columns, motion=roboplan_motion(timed, limits), kinds=KINDS[:2])


def _measure_contacts(query: Query, found: _Found, limits: MotionLimits, collision: str) -> Columns:
    """What path and motion are like, and what the library that has not planned finds on them."""
    assert found.path is not None
    judge = other_checker(query.robot, query.scene, collision)
    contacts = path_contacts(judge, found.path)
    columns: Columns = {
        "length_rad": joint_path_length(found.path),
        "corners": count_corners(found.path),
        "contacts": len(contacts),
    }
    if contacts:
        columns["message"] = contacts[0]
    if found.motion is None:
        return columns
    return columns | {
        "duration_s": found.motion.duration,
        "largest_share": largest_share(found.motion, limits, found.kinds),
        "motion_contact": motion_contact(found.motion, judge),
    }
