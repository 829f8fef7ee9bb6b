"""One run of ``benchmarks first-motion``, in a process of its own: a motion by one method, and a dense look at it.

python -m benchmarks.first_motion.case out.json '{"method": "planner", "request": {"scene": "shelf"}, ...}'
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import importlib.metadata
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import plan_request
from benchmarks.elsewhere import answer_of
from benchmarks.first_motion import runner
from benchmarks.first_motion.exchange import exchanged
from benchmarks.first_motion.ompl_connect import OmplConnect
from benchmarks.first_motion.report import OMPL, OURS, ROBOPLAN, WHOLE
from benchmarks.motion.case import STEP, largest_share
from benchmarks.motion.other_law import roboplan_motion, timed_by_roboplan
from benchmarks.plan.case import path_contacts
from benchmarks.roadmap.case import plain_check
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.base.progress import Progress
from planner.batch.outcomes import NO_PATH, REFUSED, SOLVED
from planner.collision import BACKENDS, make_checker
from planner.models.scene import Scene
from planner.paths.measure import corners, joint_path_length
from planner.planning.plan import plan
from planner.problem.request import LimitsRequest, PlanRequest, TimingRequest
from planner.problem.targets import joints_text
from planner.sampling.first_path import FIRST_PATH
from planner.setup.open import Query, make_query
from planner.trajectory.check import sampled_contact
from planner.trajectory.limits import KINDS, MotionLimits
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


def measure(method: str, python: str, request: PlanRequest, motion: LimitsRequest, seconds: float) -> Columns:
    """The columns of one row; ``python`` runs methods of other environments."""
    try:
        query = make_query(request)
        limits = MotionLimits.of(query.robot, motion)
        if method in (OURS, WHOLE):
            found = _ours(query, replace(request, path_only=method == OURS), motion)
        elif method == OMPL:
            found = _ompl(query, request.seed, seconds)
        else:
            found = _other(method, python, query, request.seed, seconds)
        if method == ROBOPLAN:
            found = _timed_by_roboplan(found, python, query, limits)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    if found.path is None:
        return {"outcome": NO_PATH, **found.columns}
    return {"outcome": SOLVED, **found.columns, **_looked_at(query, found, limits, request.collision)}


def _ours(query: Query, request: PlanRequest, motion: LimitsRequest) -> _Found:
    """``planner plan``, without its page, after a plan of the same robot where nothing stands.

    Robot, scene and states are in memory then, and all that belongs to the robot is made.
    """
    ends = {"start": joints_text(query.starts[0]), "goal": joints_text(query.goals[0])}
    scene = replace(query.scene, carried=())  # the robot carries them already
    asked = replace(request, robot=query.robot, scene=scene, motion_plan_request=None, widen_limits=False, **ends)
    timing = TimingRequest(**vars(motion))
    with contextlib.suppress(PlannerError):
        plan(replace(asked, scene=Scene("empty")), timing=timing)
    gc.collect()
    watch, begin, cpu = _FirstPath(), time.perf_counter(), time.process_time()
    found = plan(asked, Progress(watch), timing)
    total, cpu = time.perf_counter() - begin, time.process_time() - cpu
    columns: Columns = {"ready_s": found.timings["setup"], "cpu_s": cpu, "version": _version("gabf-planner")}
    made = found.trajectory
    if made is None:
        return _Found(columns | {"message": found.message}, None)
    ready, motion_s = found.timings["setup"], found.timings["timing"]
    path_s = total - ready - motion_s
    first_s = path_s if watch.seconds is None else watch.seconds - begin - ready
    columns |= {"first_s": first_s, "path_s": path_s, "motion_s": motion_s, "total_s": total, "proven": made.proven}
    return _Found(columns, found.path, made)


class _FirstPath:
    """Notes from the progress of a plan when its first path is proven; shortcuts come after."""

    def __init__(self) -> None:
        self.seconds: float | None = None

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage == FIRST_PATH and done >= total and self.seconds is None:
            self.seconds = time.perf_counter()


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
    path = connect.simplified() if solved else None
    if solved:
        columns["path_s"] = time.perf_counter() - begin
    return _Found(columns | {"cpu_s": time.process_time() - cpu}, path)


def _other(method: str, python: str, query: Query, seed: int, seconds: float) -> _Found:
    """What :mod:`benchmarks.first_motion.runner` answers, run by another Python."""
    problem = exchanged(query, seed, seconds)
    columns = answer_of(method, python, runner.__file__, problem, seconds + _WAIT, [method])
    path = columns.pop("path")
    return _Found(columns, None if path is None else query.robot.unwound(np.array(path)))


def _timed_by_roboplan(found: _Found, python: str, query: Query, limits: MotionLimits) -> _Found:
    """roboplan's path with its motion, which knows no limits on jerk; what it does not time has none."""
    if found.path is None:
        return found
    timed = timed_by_roboplan(python, found.path, query.robot, limits)
    if "times" not in timed:
        return replace(found, columns=found.columns | {"message": f"not timed: {timed['message']}"})
    motion_s = timed["motion_s"]
    total = found.columns["ready_s"] + found.columns["path_s"] + motion_s
    columns = found.columns | {"motion_s": motion_s, "total_s": total}
    return replace(found, columns=columns, motion=roboplan_motion(timed, limits), kinds=KINDS[:2])


def _looked_at(query: Query, found: _Found, limits: MotionLimits, collision: str) -> Columns:
    """What path and motion are like, and what the library that has not planned finds on them."""
    assert found.path is not None
    judge = make_checker(query.robot, query.scene, next(name for name in BACKENDS if name != collision))
    contacts = path_contacts(judge, found.path)
    columns: Columns = {
        "length_rad": joint_path_length(found.path),
        "corners": corners(found.path),
        "contacts": len(contacts),
    }
    if contacts:
        columns["message"] = contacts[0]
    if found.motion is None:
        return columns
    contact = sampled_contact(found.motion, judge, STEP)
    return columns | {
        "duration_s": found.motion.duration,
        "largest_share": largest_share(found.motion, limits, found.kinds),
        "motion_contact": "" if contact is None else f"{contact.contact} at {contact.begin:.4f} s",
    }


def main(out: str, options: str) -> None:
    """What the process does: plan, look, write."""
    importlib.import_module("scipy.sparse.csgraph")  # as the other planners' libraries: before a clock starts
    values = json.loads(options)
    request, motion = plan_request(values.pop("request")), LimitsRequest(**values.pop("motion"))
    write_whole(Path(out), json.dumps(measure(request=request, motion=motion, **values), allow_nan=False).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
