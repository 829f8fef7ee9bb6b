"""What is proven of a trajectory: no contact on any of its curves, limits between its samples, the floor under w."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Ints
from planner.base.errors import OptionError
from planner.base.polynomials import bernstein
from planner.base.resolutions import PROOF
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.kinematics.manipulability import manipulability
from planner.kinematics.manipulability_proof import prove_floor
from planner.query.resolve import beyond_limits
from planner.robot.robot import Robot
from planner.trajectory.jumps import Jump, largest_jump
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.moving_obstacles import TimeProof, prove_in_time
from planner.trajectory.trajectory import Trajectory

ROUNDING = 1e-6  # relative: a limit exceeded by less comes from numbers that were printed and read back
_CLOSER = (1.0, 0.1, 0.01)  # of the room: what is undecided is tried again with less
ASSUMES = "the geometry of robot and scene as given, a controller that follows the interpolation, floating point"


@dataclass(frozen=True)
class Excess:
    """A limit that is exceeded: ``joint`` reaches ``value`` instead of ``limit`` between ``begin`` and ``end`` s.

    ``value`` is infinite where a velocity or an acceleration jumps.
    """

    kind: str  # position, velocity, acceleration or jerk
    joint: str
    value: float
    limit: float
    begin: float
    end: float


@dataclass(frozen=True, eq=False)
class MotionProof:
    """The verdicts (k,) on a trajectory's pieces, the limits that it breaks, the floor under w, and what moves.

    ``pair`` (k,) is what stopped a piece's proof. ``floor_asked`` (k,) says which pieces are asked to keep w above
    ``floor``, not those of the stretches from a start and to a goal below it, and ``floor_holds`` (k,) which of all do
    that or are exempt. ``unjudged`` are kinds of limits that are infinite by the ``jump`` of what they limit the change
    of, and that nobody gives: they are assumed.
    """

    verdict: Ints
    pair: Ints
    excesses: tuple[Excess, ...]
    floor: float
    floor_asked: Bools
    floor_holds: Bools
    in_time: TimeProof
    jump: Jump | None = None
    unjudged: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()  # what the pieces that are free are proven to keep besides

    @property
    def free(self) -> bool:
        """Every piece is proven free."""
        return bool((self.verdict == Verdict.FREE).all())

    @property
    def whole(self) -> bool:
        """All that was asked is proven."""
        limits = not self.excesses and not self.unjudged
        return self.free and limits and bool(self.floor_holds.all()) and self.in_time.whole

    def to_dict(self, margin: float, library: str) -> dict[str, Any]:
        """The proof as ``trajectory.json`` has it."""
        found: dict[str, Any] = {
            "pieces": len(self.verdict),
            "pieces_free": int((self.verdict == Verdict.FREE).sum()),
            "margin": margin,
            "collision": library,
            "limits_exceeded": [excess.kind for excess in self.excesses],
            **({"limits_not_judged": list(self.unjudged)} if self.unjudged else {}),
            "assumes": ASSUMES,
        }
        if self.floor > 0:
            found["floor"] = self._floor()
        if self.kept:
            found["kept"] = list(self.kept)
        return found | self.in_time.to_dict()

    def _floor(self) -> dict[str, Any]:
        """How many pieces are proven above the floor, exempt, or not proven; proven: something was asked, and holds."""
        asked, above = int(self.floor_asked.sum()), int((self.floor_asked & self.floor_holds).sum())
        pieces = {"above": above, "exempt": len(self.verdict) - asked, "below": asked - above}
        counts = {f"pieces_{name}": count for name, count in pieces.items()}
        return {"asked": self.floor, **counts, "proven": above == asked > 0}


def require_joints(trajectory: Trajectory, checker: CollisionChecker) -> None:
    """Raise :class:`OptionError` for a checker of another robot."""
    if trajectory.joints != checker.robot.joints:
        raise OptionError("the trajectory is of other joints than the checker's robot: make a checker for its robot.")


def prove_motion(
    trajectory: Trajectory,
    prover: EdgeProver,
    limits: MotionLimits,
    floor: float = 0.0,
    room: float = PROOF,
    *,
    kinds: Sequence[str] = KINDS,
    in_time: TimeProof | None = None,
) -> MotionProof:
    """Prove the pieces free, the limits kept by their exact extrema, and w above ``floor`` once it is reached.

    Of the limits those of the first ``kinds`` are asked for; ``in_time`` is what is proven in time already.
    """
    verdict, pair = _free(trajectory, prover, room)
    asked = _floor_asked(trajectory, prover.robot, floor)
    holds = ~asked
    if asked.any():
        holds[asked] = prove_floor(prover.robot, trajectory.coefficients[asked], floor).holds
    excesses = limits_exceeded(trajectory, prover.robot, limits, kinds)
    in_time = in_time or prove_in_time(trajectory, prover.checker)
    jump = largest_jump(trajectory, limits)
    unjudged = tuple(kind for kind in kinds if jump and kind in jump.infinite and not limits.given(kind))
    return MotionProof(verdict, pair, excesses, floor, asked, holds, in_time, jump, unjudged, prover.world.keeps.texts)


def _free(trajectory: Trajectory, prover: EdgeProver, room: float) -> tuple[Ints, Ints]:
    if prover.all_free(trajectory.coefficients, room):
        count = len(trajectory.coefficients)
        return np.full(count, int(Verdict.FREE)), np.full(count, -1)
    proofs = prover.prove_curves(trajectory.coefficients, room)
    verdict, pair = proofs.verdict.copy(), proofs.pair.copy()
    for share in _CLOSER[1:]:
        open_ = np.flatnonzero(verdict == Verdict.UNDECIDED)
        if not len(open_):
            break
        again = prover.prove_curves(trajectory.coefficients[open_], share * room)
        verdict[open_], pair[open_] = again.verdict, again.pair
    return verdict, pair


def _floor_asked(trajectory: Trajectory, robot: Robot, floor: float) -> Bools:
    """(k,) the pieces between the first and the last knot at which w reaches ``floor``; none for a floor of 0.

    The others lead up from the start and down to the end.
    """
    asked = np.zeros(len(trajectory.coefficients), dtype=bool)
    if floor <= 0:
        return asked
    above = np.flatnonzero(manipulability(robot, trajectory.knots()) >= floor)
    if len(above):
        asked[int(above[0]) : int(above[-1])] = True
    return asked


def limits_exceeded(
    trajectory: Trajectory, robot: Robot, limits: MotionLimits, kinds: Sequence[str] = KINDS
) -> tuple[Excess, ...]:
    """The worst excess of each kind of limit, by the exact extrema of every piece; of derivatives of ``kinds``.

    Where a derivative jumps at a point, the next one is infinite, beyond any limit that somebody gives. One that is
    assumed for want of any does not judge it.
    """
    found, jump = [_position_excess(trajectory, robot)], largest_jump(trajectory, limits)
    for order, kind in enumerate(kinds, start=1):
        if jump and kind in jump.infinite and limits.given(kind):
            most = float(getattr(limits, kind)[trajectory.joints.index(jump.joint)])
            found.append(Excess(kind, jump.joint, np.inf, most, jump.time, jump.time))
            continue
        most = getattr(limits, kind)
        share, piece, joint = trajectory.worst(order, most, 1.0)
        if share > 1.0 + ROUNDING:
            found.append(_excess(trajectory, kind, piece, joint, share * float(most[joint]), float(most[joint])))
    return tuple(excess for excess in found if excess is not None)


def _position_excess(trajectory: Trajectory, robot: Robot) -> Excess | None:
    hull = bernstein(trajectory.coefficients)
    if not beyond_limits(robot, hull.min(axis=1)).any() and not beyond_limits(robot, hull.max(axis=1)).any():
        return None
    low, high = trajectory.extrema()
    below, above = beyond_limits(robot, low), beyond_limits(robot, high)
    beyond = np.maximum(below, above)
    piece, joint = np.unravel_index(int(beyond.argmax()), beyond.shape)
    if not beyond[piece, joint]:
        return None
    over = above[piece, joint] >= below[piece, joint]
    value = (high if over else low)[piece, joint]
    limit = (robot.upper if over else robot.lower)[joint]
    return _excess(trajectory, "position", int(piece), int(joint), float(value), float(limit))


def _excess(trajectory: Trajectory, kind: str, piece: int, joint: int, value: float, limit: float) -> Excess:
    begin, end = trajectory.times[piece : piece + 2].tolist()
    return Excess(kind, trajectory.joints[joint], value, limit, begin, end)
