"""What the gate says of a trajectory from a file: is there a proven stop from every point of it?"""

from __future__ import annotations

from planner.collision.checker import CollisionChecker
from planner.gate.guard import Guard
from planner.gate.judging import judge
from planner.gate.rules import Rules
from planner.gate.verdict import Verdict
from planner.trajectory.limits import MotionLimits
from planner.trajectory.points import Points


def judge_prefixes(checker: CollisionChecker, points: Points, limits: MotionLimits) -> Verdict:
    """The verdict on the points, of a robot that is at the first one when its time comes."""
    velocities, accelerations = (*points.columns[1:], None, None)[:2]
    guard = Guard.of(checker, Rules.of(checker.robot, limits))
    return judge(guard, (points.columns[0], velocities, accelerations, points.times, None), stop=True)


def prefixes_row(verdict: Verdict) -> tuple[str, str]:
    """The verdict as a row of the terminal's table."""
    text = "proven from every point" if verdict.safe else str(verdict)
    return "stops", "; ".join([text, *verdict.notes])
