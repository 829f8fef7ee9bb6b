"""The motion along a plan's path, and a second look at it."""

from __future__ import annotations

import logging
from dataclasses import asdict, replace

import numpy as np

from planner.collision.checker import CollisionChecker, keeping
from planner.collision.looks import second_look
from planner.cost.motion_cost import MotionCost
from planner.planning.extra_clearance import clearance_of_path
from planner.planning.result import Plan
from planner.problem.request import TimingRequest
from planner.trajectory.limits import MotionLimits
from planner.trajectory.timing import timed_curve
from planner.trajectory.trajectory import Trajectory

_log = logging.getLogger(__name__)


def timed(found: Plan, timing: TimingRequest, limits: MotionLimits | None) -> Trajectory:
    """The motion along a plan's path."""
    quality = found.request.quality
    how = (limits, timing.time_law, quality.min_manipulability, cost_in_motion(found), timing.extra_cost)
    wanted = 0.0 if found.scene.limited else quality.room  # of obstacles with a speed limit the proof counts the margin
    kept = min(wanted, found.clearance_kept)
    clearance = kept if kept > 0 else clearance_of_path(found.path, found.checker, wanted)
    made, _ = timed_curve(found.path, keeping(found.checker, clearance), *how)
    if not made.proven and clearance > 0:
        made, _ = timed_curve(found.path, found.checker, *how)
    return looked_at_again(made, found.checker)


def looked_at_again(made: Trajectory, checker: CollisionChecker) -> Trajectory:
    """A motion after a second look, which takes the proof from one that is seen to touch."""
    seen = second_look(checker, made.coefficients)
    if seen is None:
        return made
    t = float(made.times[seen.piece] + seen.s * made.seconds[seen.piece])
    _log.warning("the motion touches at %.3f s (%s), against its proof: it is not to be run", t, seen.contact)
    return replace(made, proven=False, proof=made.proof | {"contact": asdict(seen.contact) | {"t": t}})


def cost_in_motion(found: Plan) -> MotionCost:
    """The objective along motions of any length, charged along them whatever the roadmap charges.

    Motions in time are priced in short chords, on which the ends and the middle are enough.
    """
    objective = replace(found.request.quality.objective, charge="edges", floor=0.0)
    return MotionCost(found.robot, found.roadmap.scale, objective, longest=np.inf, states=3).of_pieces
