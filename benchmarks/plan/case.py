"""One run of ``benchmarks plan``, in a process of its own: find a path, time it, and look at both."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.looks import FirstPath, largest_share, motion_contact, other_checker, path_contacts
from benchmarks.memory import peak_memory
from benchmarks.others.ompl import OmplPaths
from benchmarks.others.roboplan_law import roboplan_law
from benchmarks.others.toppra_law import installed, toppra_duration
from benchmarks.problems import read_request
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.progress import Progress
from planner.batch.run import NO_PATH, REFUSED, SOLVED
from planner.collision.edge_prover import EdgeProver
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.planning.solve import make_timing_cost
from planner.problem.outcome import Outcome
from planner.problem.request import LimitsRequest, PlanRequest, TimingRequest
from planner.query.query import make_query
from planner.roadmap.edges import MotionChecker
from planner.roadmap.ompl_planners import JointSpace
from planner.robot.robot import Robot
from planner.trajectory.limits import MotionLimits
from planner.trajectory.measure import count_corners, measure_path, path_clearance, path_manipulability
from planner.trajectory.timing import time_curve

OURS = "planner"
_STAGES = ("setup", "roadmap", "costs", "gabf", "path")
_STEP = 0.02  # m of motion between two states that OMPL's planners check

Columns = dict[str, Any]


def measure(method: str, request: Columns, limits: Columns, seconds: float, python: str | None = None) -> Columns:
    """The columns of one row: by ``method``, ours or OMPL's; input that the planner refuses is a row like any other."""
    asked = read_request(request)
    try:
        if method == OURS:
            return _ours(asked, LimitsRequest(**limits), python)
        return _ompl(method, asked, seconds)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}


def _ours(request: PlanRequest, limits: LimitsRequest, python: str | None) -> Columns:
    watch, cpu = FirstPath(), time.process_time()
    found = plan(request=request, progress=Progress(watch), timing=None)
    columns: Columns = {"total_s": time.perf_counter() - watch.begin, "cpu_s": time.process_time() - cpu}
    columns |= {"memory_mib": peak_memory(), **_of_record(found)}
    if found.outcome is not Outcome.SOLVED:
        return columns
    columns |= {"first_path_s": watch.seconds, **_along(found.robot, found.path), **_measure_contacts(found)}
    return columns | _measure_motion(found, limits, python)


def _of_record(found: Plan) -> Columns:
    record = found.to_dict()
    roadmap, timings = record["roadmap"], record["timings_s"]
    columns: Columns = {"nodes": roadmap["nodes"], "edges": roadmap["edges"], "certified": roadmap["edges_certified"]}
    columns |= {"outcome": record["outcome"], "message": record["message"]}
    columns |= {f"{stage}_s": timings.get(stage) for stage in _STAGES}
    if found.outcome is Outcome.SOLVED:
        columns |= {"cost": record["cost"]["total"], "lower_bound": record["quality"]["lower_bound"]}
        columns |= {"waypoints": len(record["path"])}
    return columns


def _ompl(method: str, request: PlanRequest, seconds: float) -> Columns:
    query = make_query(request.what)
    robot, check = query.robot, MotionChecker(EdgeProver(query.checker)).make_state_check(_STEP)
    begin, cpu = time.perf_counter(), time.process_time()
    with OmplPaths(JointSpace.from_robot(robot), check, np.random.default_rng(request.quality.seed)) as planners:
        path = planners.path(method, query.starts, query.goals, seconds)
    columns = {"total_s": time.perf_counter() - begin, "cpu_s": time.process_time() - cpu}
    if path is None:
        return {"outcome": NO_PATH, **columns}
    return {"outcome": SOLVED, **columns, **_along(robot, robot.unwound(path))}


def _along(robot: Robot, path: Floats) -> Columns:
    measures, w = measure_path(robot, path), path_manipulability(robot, path)
    return {
        "length_rad": measures.joint_length,
        "length_m": measures.workspace_length,
        "straight_rad": float(np.linalg.norm(path[-1] - path[0], axis=0)),
        "corners": count_corners(path),
        "w_min": measures.w_min,
        "w_mean": measures.w_mean,
        "dips": bool(w.min() < (1.0 - 1e-6) * min(w[0], w[-1])),
    }


def _measure_contacts(found: Plan) -> Columns:
    """Clearance by the library that planned, contacts by the other one."""
    contacts = path_contacts(other_checker(found.robot, found.scene, found.request.what.collision), found.path)
    clearance = path_clearance(found.checker, found.path)[1].min(initial=np.inf)
    return {
        "clearance_m": float(clearance) if np.isfinite(clearance) else None,
        "contacts": len(contacts),
        "contact": contacts[0] if contacts else None,
    }


def _measure_motion(found: Plan, asked: LimitsRequest, python: str | None) -> Columns:
    """Return the columns of the motion along the path, and of other motions along it."""
    limits, floor = MotionLimits.from_robot(found.robot, asked), found.request.quality.min_manipulability
    begin = time.process_time()
    trajectory, curve = time_curve(
        found.path, found.checker, limits, TimingRequest().time_law, floor, make_timing_cost(found)
    )
    seconds = time.process_time() - begin
    blended, stopping = (
        time_curve(found.path, found.checker, limits, law, floor)[0].duration for law in ("blended", "stop-at-corners")
    )
    judge = other_checker(found.robot, found.scene, found.request.what.collision)
    return {
        "timed_s": trajectory.duration,
        "blended_s": blended,
        "stopping_s": stopping,
        "toppra_s": toppra_duration(curve, limits.velocity, limits.acceleration) if installed() else None,
        "timed_corners": trajectory.proof["corners"],
        "blended": trajectory.proof["corners_blended"],
        "shortcuts": trajectory.proof["shortcuts"],
        "proven": trajectory.proven,
        "largest_share": largest_share(trajectory, limits),
        "motion_contact": motion_contact(trajectory, judge),
        "knots": len(trajectory.times),
        "timing_cpu_s": seconds,
    } | (roboplan_law(python, found.path, judge, limits) if python else {})
