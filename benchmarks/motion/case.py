"""One problem of ``benchmarks motion``: plan, time the path, look at the motion with the other library."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from benchmarks.motion.other_law import roboplan_law
from benchmarks.motion.toppra_law import installed, toppra_duration
from planner.base.errors import PlannerError
from planner.base.progress import Progress
from planner.collision import BACKENDS, make_checker
from planner.planning.motion import cost_in_motion
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.request import DEFAULT_TIME_LAW, LimitsRequest, PlanRequest
from planner.trajectory.check import sampled_contact
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.timing import timed_curve
from planner.trajectory.trajectory import Trajectory

STEP = 1e-4  # m of motion between two looks at a motion
REFUSED = "refused"


def measure(
    request: PlanRequest, motion: LimitsRequest, progress: Progress, python: str | None = None
) -> dict[str, Any]:
    """The columns of a row; input that the planner refuses is a row like any other."""
    try:
        found = plan(request, progress)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    columns = {"outcome": found.outcome.key, "message": found.outcome.value}
    return columns | (_timed(found, motion, python) if found.outcome is Outcome.SOLVED else {})


def _timed(found: Plan, motion: LimitsRequest, python: str | None) -> dict[str, Any]:
    limits, floor = MotionLimits.of(found.robot, motion), found.request.min_manipulability
    begin = time.process_time()
    trajectory, curve = timed_curve(found.path, found.checker, limits, DEFAULT_TIME_LAW, floor, cost_in_motion(found))
    seconds = time.process_time() - begin
    blended, stopping = (
        timed_curve(found.path, found.checker, limits, law, floor)[0].duration for law in ("blended", "stop-at-corners")
    )
    other = next(name for name in BACKENDS if name != found.request.collision)
    judge = make_checker(found.robot, found.scene, other)
    contact = sampled_contact(trajectory, judge, STEP)
    toppra = toppra_duration(curve, limits.velocity, limits.acceleration) if installed() else None
    return {
        "timed_s": trajectory.duration,
        "blended_s": blended,
        "stopping_s": stopping,
        "toppra_s": toppra,
        "corners": trajectory.proof["corners"],
        "blended": trajectory.proof["corners_blended"],
        "shortcuts": trajectory.proof["shortcuts"],
        "proven": trajectory.proven,
        "largest_share": largest_share(trajectory, limits),
        "contact": "" if contact is None else f"{contact.contact} at {contact.begin:.4f} s",
        "knots": len(trajectory.times),
        "cpu_s": seconds,
    } | (roboplan_law(python, found.path, judge, limits, STEP) if python else {})


def largest_share(trajectory: Trajectory, limits: MotionLimits, kinds: Sequence[str] = KINDS) -> float:
    """The largest share of any limit of these kinds that is used, by the exact extrema of the pieces."""
    return max(trajectory.worst(order, getattr(limits, kind))[0] for order, kind in enumerate(kinds, start=1))
