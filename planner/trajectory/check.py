"""A check of a trajectory from any source: what a controller makes of its points, against scene and limits."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, numbers
from planner.base.errors import FileError
from planner.base.polynomials import bernstein
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF_OF_CHECK, RECHECK
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.looks import Seen, first_seen
from planner.collision.second_look import second_look
from planner.collision.world import Contact
from planner.constraints.keeps import Kept
from planner.kinematics.manipulability import manipulability
from planner.query.resolve import looks_like_degrees
from planner.trajectory.clearance import Nearest, nearest_in_motion
from planner.trajectory.limits import MotionLimits
from planner.trajectory.moving_obstacles import first_touch_in_time
from planner.trajectory.path_check import PathReport, check_path, require_step
from planner.trajectory.path_file import FAR
from planner.trajectory.points import Points
from planner.trajectory.proof import MotionProof, limits_exceeded, prove_motion, require_joints
from planner.trajectory.trajectory import Trajectory

_W_APART, _LOOKS = 0.01, 10_000  # s between two looks at w, and how many there are at most


@dataclass(frozen=True, eq=False)
class TrajectoryContact:
    """Where a trajectory touches: between ``begin`` and ``end`` s; at ``begin``, in ``q``, where it was sampled."""

    begin: float
    end: float
    contact: Contact
    q: Floats | None


@dataclass(frozen=True, eq=False)
class TrajectoryReport:
    """What was found on a trajectory, true if ok; where times are at ``fault`` or all in ``degrees`` nothing else.

    ``contact`` is the first one, seen by coal every ``step`` metres of motion, by the checker at fewer states, or by a
    proof. ``w`` (n,) and what is ``kept`` are sampled at ``w_times`` (n,). ``nearest`` is the smallest clearance, None
    where there is none.
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
    nearest: Nearest | None = None
    kept: tuple[Kept, ...] = ()

    def __bool__(self) -> bool:
        return self.ok

    def __repr__(self) -> str:
        return f"<TrajectoryReport: {len(self.points.times)} points, {'ok' if self.ok else 'not ok'}>"

    @property
    def ok(self) -> bool:
        """A controller runs it, within all limits, and no contact was found."""
        if self.fault or self.degrees or self.proof is None:
            return False
        return not self.proof.excesses and self.contact is None and not any(each.strays for each in self.kept)


def check(
    what: Floats | Sequence[Sequence[float]] | Trajectory,
    checker: CollisionChecker,
    step: float = RECHECK,
    progress: Progress = QUIET,
) -> PathReport | TrajectoryReport:
    """What is found on a path (k, dof) rad, or on a trajectory within the limits that it was made for.

    What ``planner check`` does: limits, contacts every ``step`` (m) of motion by the second checker, proofs, clearance
    and w, whoever made the path; ``report.ok`` is the verdict. A trajectory that says no limits is held to the robot's
    own. Raises :class:`ArrayError` for an array of another shape.
    """
    require_step(step)
    if not isinstance(what, Trajectory):
        return check_path(checker, numbers("path", what, ("k", len(checker.robot.joints)), most=FAR), step, progress)
    require_joints(what, checker)
    limits = what.limits or MotionLimits.of(checker.robot)
    return check_trajectory(checker, Points(what.joints, what.times, what.columns, limits), limits, step, progress)


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
        looked_at(trajectory, checker, step, progress),
        _contact_in_time(trajectory, checker, step),
    )
    proof = prove_motion(trajectory, EdgeProver(checker), limits, room=PROOF_OF_CHECK)
    progress("proofs", pieces, pieces)
    times = np.linspace(trajectory.times[0], trajectory.times[-1], min(int(trajectory.duration / _W_APART), _LOOKS) + 2)
    states = trajectory.at(times)
    w, kept = manipulability(checker.robot, states), checker.world.keeps.along(states, trajectory.coefficients)
    contact = seen or _proven_contact(trajectory, proof, checker)
    nearest = nearest_in_motion(trajectory, checker)
    return TrajectoryReport(
        checker, points, limits, step, None, False, trajectory, proof, contact, w, times, nearest, kept
    )


def _require_within_reason(trajectory: Trajectory) -> None:
    """Raise :class:`FileError` for swings that no arm does, and that would take forever to sample."""
    hull = np.abs(bernstein(trajectory.coefficients)).max(axis=(1, 2))
    if hull.max() > FAR:
        k = int(hull.argmax())
        raise FileError(
            f"between {trajectory.times[k]:g} and {trajectory.times[k + 1]:g} s the trajectory swings as far as "
            f"{hull[k]:.3g}: mend its positions or velocities."
        )


def looked_at(
    trajectory: Trajectory, checker: CollisionChecker, step: float = RECHECK, progress: Progress = QUIET
) -> TrajectoryContact | None:
    """The first contact that :func:`second_look` sees on a trajectory, coal every ``step`` metres of motion."""
    pieces = len(trajectory.coefficients)
    seen = second_look(checker, trajectory.coefficients, step, progress=lambda done: progress("contacts", done, pieces))
    return _at_time(trajectory, seen)


def sampled_contact(trajectory: Trajectory, judge: CollisionChecker, step: float) -> TrajectoryContact | None:
    """The first contact that one checker sees on a trajectory every ``step`` metres of motion."""
    return _at_time(trajectory, first_seen(judge, trajectory.coefficients, step))


def _at_time(trajectory: Trajectory, seen: Seen | None) -> TrajectoryContact | None:
    """The contact that was ``seen`` on one of the trajectory's pieces, with its time."""
    if seen is None:
        return None
    t = float(trajectory.times[seen.piece] + seen.s * trajectory.seconds[seen.piece])
    return TrajectoryContact(t, t, seen.contact, seen.q)


def _contact_in_time(trajectory: Trajectory, checker: CollisionChecker, step: float) -> TrajectoryContact | None:
    """The first contact with an obstacle that moves along a known motion."""
    found = first_touch_in_time(trajectory, checker, checker.world.scene.moving, step)
    return None if found is None else TrajectoryContact(found[0], found[0], found[1], found[2])


def _earliest(*contacts: TrajectoryContact | None) -> TrajectoryContact | None:
    return min((item for item in contacts if item is not None), key=lambda item: item.begin, default=None)


def _proven_contact(trajectory: Trajectory, proof: MotionProof, checker: CollisionChecker) -> TrajectoryContact | None:
    """The first piece that is proven to touch, where no sample has met it."""
    for k, (begin, end) in enumerate(itertools.pairwise(trajectory.times.tolist())):
        if proof.verdict[k] == Verdict.COLLIDES:
            contact = EdgeProver(checker).static_contact or checker.world.contact(int(proof.pair[k]))
            return TrajectoryContact(begin, end, contact, None)
    return None
