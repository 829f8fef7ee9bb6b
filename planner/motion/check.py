"""A check of a trajectory from any source: what a controller makes of its points, against scene and limits."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import FileError
from planner.base.polynomials import bernstein, evaluate
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF_OF_CHECK, RECHECK
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.world import Contact
from planner.kinematics.manipulability import manipulability
from planner.motion.in_time import first_touch_in_time
from planner.motion.limits import MotionLimits
from planner.motion.points import Points
from planner.motion.proof import MotionProof, limits_exceeded, prove_motion
from planner.motion.trajectory import Trajectory
from planner.query.resolve import looks_like_degrees

_W_APART, _LOOKS = 0.01, 10_000  # s between two looks at w, and how many there are at most
_FARTHEST = 1000.0  # rad (m)


@dataclass(frozen=True, eq=False)
class TrajectoryContact:
    """Where a trajectory touches: between ``begin`` and ``end`` s; at ``begin``, in ``q``, where it was sampled."""

    begin: float
    end: float
    contact: Contact
    q: Floats | None


@dataclass(frozen=True, eq=False)
class TrajectoryReport:
    """What was found on a trajectory; where its times are at ``fault`` or it looks like ``degrees`` nothing else.

    ``contact`` is the first one, seen by the second checker every ``step`` metres of motion or by a proof. ``w`` (n,)
    is sampled at ``w_times`` (n,).
    """

    checker: CollisionChecker
    points: Points
    limits: MotionLimits
    step: float
    fault: str | None
    degrees: bool = False
    trajectory: Trajectory | None = None
    proof: MotionProof | None = None
    contact: TrajectoryContact | None = None
    w: Floats | None = None
    w_times: Floats | None = None

    @property
    def ok(self) -> bool:
        """A controller runs it, within all limits, and no contact was found."""
        if self.fault or self.degrees or self.proof is None:
            return False
        return not self.proof.excesses and self.contact is None


def check_trajectory(
    checker: CollisionChecker,
    points: Points,
    limits: MotionLimits,
    step: float = RECHECK,
    progress: Progress = QUIET,
) -> TrajectoryReport:
    """Rebuild what a controller runs between ``points``; prove it or refute it against the scene and ``limits``."""
    report = TrajectoryReport(checker, points, limits, step, points.fault())
    if report.fault:
        return report
    trajectory = points.trajectory()
    _require_within_reason(trajectory)
    degrees = bool(limits_exceeded(trajectory, checker.robot, limits)) and looks_like_degrees(
        checker.robot, points.columns[0]
    )
    if degrees:
        return TrajectoryReport(checker, points, limits, step, None, True)
    pieces = len(trajectory.coefficients)
    seen = _earliest(
        sampled_contact(trajectory, second_checker(checker), step, progress),
        _contact_in_time(trajectory, checker, step),
    )
    proof = prove_motion(trajectory, EdgeProver(checker), limits, room=PROOF_OF_CHECK)
    progress("proofs", pieces, pieces)
    times = np.linspace(trajectory.times[0], trajectory.times[-1], min(int(trajectory.duration / _W_APART), _LOOKS) + 2)
    w = manipulability(checker.robot, trajectory.at(times))
    contact = seen or _proven_contact(trajectory, proof, checker)
    return TrajectoryReport(checker, points, limits, step, None, False, trajectory, proof, contact, w, times)


def _require_within_reason(trajectory: Trajectory) -> None:
    """Raise :class:`FileError` for swings that no arm does, and that would take forever to sample."""
    hull = np.abs(bernstein(trajectory.coefficients)).max(axis=(1, 2))
    if hull.max() > _FARTHEST:
        k = int(hull.argmax())
        raise FileError(
            f"between {trajectory.times[k]:g} and {trajectory.times[k + 1]:g} s the trajectory swings as far as "
            f"{hull[k]:.3g} rad: mend its positions or velocities."
        )


def sampled_contact(
    trajectory: Trajectory, judge: CollisionChecker, step: float, progress: Progress = QUIET
) -> TrajectoryContact | None:
    """The first contact on a trajectory sampled every ``step`` metres of motion, without bounds or proofs."""
    total = len(trajectory.coefficients)
    for piece, u in enumerate(_samples(trajectory, judge, step)):
        states = evaluate(np.repeat(trajectory.coefficients[piece][None], len(u), axis=0), u)
        found = judge.first_contact(states)
        if found is not None:
            row, contact = found
            begin, end = trajectory.times[piece : piece + 2]
            t = float(begin + u[row] * (end - begin))
            return TrajectoryContact(t, t, contact, states[row])
        progress("contacts", piece + 1, total)
    return None


def _contact_in_time(trajectory: Trajectory, checker: CollisionChecker, step: float) -> TrajectoryContact | None:
    """The first contact with an obstacle that moves along a known motion."""
    found = first_touch_in_time(trajectory, checker, checker.world.scene.moving, step)
    return None if found is None else TrajectoryContact(found[0], found[0], found[1], found[2])


def _earliest(*contacts: TrajectoryContact | None) -> TrajectoryContact | None:
    return min((item for item in contacts if item is not None), key=lambda item: item.begin, default=None)


def _samples(trajectory: Trajectory, judge: CollisionChecker, step: float) -> Iterator[Floats]:
    """Places u (n,) in [0, 1] on each piece, both ends included, no point moving further than ``step`` between them."""
    fastest = trajectory.largest(1) * trajectory.seconds[:, None]
    motion = judge.world.reach.motion(fastest).max(axis=1, initial=0.0)
    for count in np.maximum(1, np.ceil(motion / step)).astype(int):
        yield np.linspace(0.0, 1.0, count + 1)


def _proven_contact(trajectory: Trajectory, proof: MotionProof, checker: CollisionChecker) -> TrajectoryContact | None:
    """The first piece that is proven to touch, where no sample has met it."""
    for k, (begin, end) in enumerate(itertools.pairwise(trajectory.times.tolist())):
        if proof.verdict[k] == Verdict.COLLIDES:
            contact = EdgeProver(checker).static_contact or checker.world.contact(int(proof.pair[k]))
            return TrajectoryContact(begin, end, contact, None)
    return None
