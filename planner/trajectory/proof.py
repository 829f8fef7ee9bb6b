"""What is proven of a trajectory: no contact on any of its curves, limits between its samples, the floor under w."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import OptionError
from planner.base.resolutions import PROOF
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.kinematics.manipulability import manipulability, prove_floor
from planner.robot.robot import Robot
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.moving_obstacles import TimeProof, prove_in_time
from planner.trajectory.report import Finding
from planner.trajectory.trajectory import Trajectory
from planner.trajectory.violations import Jump, largest_jump, limits_exceeded

_CLOSER = (1.0, 0.1, 0.01)  # of the room: what is undecided is tried again with less
ASSUMES = "the geometry of robot and scene as given, a controller that follows the interpolation, floating point"


@dataclass(frozen=True, eq=False)
class MotionProof:
    """The verdicts (k,) on a trajectory's pieces, the limits that it breaks, the floor under w, and what moves.

    ``pair`` (k,) is what stopped a piece's proof. ``floor_asked`` (k,) says which pieces are asked to keep w above
    ``floor``, not those of the stretches from a start and to a goal below it, and ``floor_holds`` (k,) which of all do
    that or are exempt. ``unjudged`` are kinds of limits that are infinite by the ``jump`` of what they limit the change
    of, and that are merely assumed.
    """

    verdict: Ints
    pair: Ints
    excesses: tuple[Finding, ...]
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
            "limits_exceeded": [excess.what[0] for excess in self.excesses],
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


def require_joints(joints: tuple[str, ...], checker: CollisionChecker) -> None:
    """Raise :class:`OptionError` for a checker of another robot."""
    if joints != checker.robot.joints:
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
    verdict, pair = prove_pieces(trajectory.coefficients, prover, room)
    asked = _floor_asked(trajectory, prover.robot, floor)
    holds = ~asked
    if asked.any():
        holds[asked] = prove_floor(prover.robot, trajectory.coefficients[asked], floor).holds
    excesses = limits_exceeded(trajectory, prover.robot, limits, kinds)
    in_time = in_time or prove_in_time(trajectory, prover.checker)
    jump = largest_jump(trajectory, limits)
    unjudged = tuple(kind for kind in kinds if jump and kind in jump.infinite and not limits.given(kind))
    return MotionProof(verdict, pair, excesses, floor, asked, holds, in_time, jump, unjudged, prover.world.keeps.texts)


def prove_pieces(coefficients: Floats, prover: EdgeProver, room: float) -> tuple[Ints, Ints]:
    """The verdict (k,) on each of the pieces (k, degree + 1, dof), and the pair (k,) that stopped its proof."""
    if prover.all_free(coefficients, room):
        return np.full(len(coefficients), int(Verdict.FREE)), np.full(len(coefficients), -1)
    proofs = prover.prove_curves(coefficients, room)
    verdict, pair = proofs.verdict.copy(), proofs.pair.copy()
    for share in _CLOSER[1:]:
        open_ = np.flatnonzero(verdict == Verdict.UNDECIDED)
        if not len(open_):
            break
        again = prover.prove_curves(coefficients[open_], share * room)
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
