"""What is proven of a trajectory: no contact on any of its curves, limits by exact extrema, the floor under w."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import OptionError
from planner.base.polynomials import bernstein, powers
from planner.base.resolutions import PROOF
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.constraints.floor import prove_floor
from planner.kinematics.manipulability import manipulability
from planner.query.resolve import beyond_limits
from planner.robot.robot import Robot
from planner.trajectory.limits import KINDS, UNITS, MotionLimits
from planner.trajectory.moving_obstacles import TimeProof, prove_in_time
from planner.trajectory.report import Finding
from planner.trajectory.trajectory import Trajectory

ROUNDING = 1e-6  # relative: a limit exceeded by less comes from numbers that were printed and read back
_LEAST = 1e-6  # of the limit on what jumps: less comes from numbers that were printed and read back
_ROUNDED = 4  # last bits of a position
_REMEDY = {"lines": "; give velocities too", "cubics": "; give accelerations too"}
_CLOSER = (1.0, 0.1, 0.01)  # of the room: what is undecided is tried again with less
ASSUMES = "the geometry of robot and scene as given, a controller that follows the interpolation, floating point"


@dataclass(frozen=True)
class Jump:
    """At ``time`` s a joint's ``what`` (velocity or acceleration) jumps by ``size``, the largest of ``count`` jumps."""

    what: str
    joint: str
    size: float
    time: float
    count: int

    @property
    def infinite(self) -> tuple[str, ...]:
        """The kinds of limits that no number can keep then: acceleration and jerk, or jerk."""
        return KINDS[KINDS.index(self.what) + 1 :]

    def text(self, robot: Robot) -> str:
        """Which joint jumps by how much and when, as part of a sentence."""
        largest = "" if self.count == 1 else f" (the largest of {self.count} jumps)"
        size = f"{self.size:.4g} {unit_of(robot, self.joint, self.what)}"
        return f"the {self.what} of joint '{self.joint}' jumps by {size} at {self.time:.3f} s{largest}"


@dataclass(frozen=True, eq=False)
class MotionProof:
    """The verdicts (k,) on a trajectory's pieces, the limits that it breaks, the floor under w, and what moves.

    ``pair`` (k,) is what stopped a piece's proof. ``floor_required`` (k,) says which pieces are asked to keep w above
    ``floor``, not those of the stretches from a start and to a goal below it, and ``floor_holds`` (k,) which of all do
    that or are exempt. ``unjudged`` are kinds of limits that are infinite by the ``jump`` of what they limit the change
    of, and that are merely assumed.
    """

    verdict: Ints
    pair: Ints
    excesses: tuple[Finding, ...]
    floor: float
    floor_required: Bools
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
        asked, above = int(self.floor_required.sum()), int((self.floor_required & self.floor_holds).sum())
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
    asked = _requires_floor(trajectory, prover.robot, floor)
    holds = ~asked
    if asked.any():
        holds[asked] = prove_floor(prover.robot, trajectory.coefficients[asked], floor).holds
    excesses = find_limit_violations(trajectory, prover.robot, limits, kinds)
    in_time = in_time or prove_in_time(trajectory, prover.checker)
    jump = largest_jump(trajectory, limits)
    unjudged = tuple(kind for kind in kinds if jump and kind in jump.infinite and not limits.given(kind))
    return MotionProof(
        verdict, pair, excesses, floor, asked, holds, in_time, jump, unjudged, prover.world.constraints.texts
    )


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


def _requires_floor(trajectory: Trajectory, robot: Robot, floor: float) -> Bools:
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


def unit_of(robot: Robot, joint: str, quantity: str = "position") -> str:
    """The unit of a joint's position, or of a derivative of it."""
    return ("m" if robot.prismatic[robot.joints.index(joint)] else "rad") + UNITS.get(quantity, "")


def find_limit_violations(
    trajectory: Trajectory, robot: Robot, limits: MotionLimits, kinds: Sequence[str] = KINDS
) -> tuple[Finding, ...]:
    """The worst excess of each kind of limit, by the exact extrema of every piece; of derivatives of ``kinds``.

    Where a derivative jumps at a point, the next one is infinite, beyond any limit that is given. A limit that is
    merely assumed does not judge it.
    """
    found, jump = _beyond_positions(trajectory, robot), largest_jump(trajectory, limits)
    for order, kind in enumerate(kinds, start=1):
        most = getattr(limits, kind)
        if jump and kind in jump.infinite and limits.is_given(kind):
            allowed = float(most[trajectory.joints.index(jump.joint)])
            unit, at = unit_of(robot, jump.joint, kind), (jump.time, jump.time)
            infinite = f"an infinite {kind} where the limit is {allowed:g} {unit}"
            text = f"{jump.text(robot)}: {infinite}{_REMEDY.get(trajectory.interpolation, '')}"
            found.append(Finding("discontinuity", (kind, jump.joint), at, None, allowed, unit, text=text))
            continue
        share, piece, joint = trajectory.worst(order, most, 1.0)
        if share > 1.0 + ROUNDING:
            allowed = float(most[joint])
            found.append(_excess(trajectory, robot, kind, (piece, joint), share * allowed, allowed))
    return tuple(found)


def _beyond_positions(trajectory: Trajectory, robot: Robot) -> list[Finding]:
    hull = bernstein(trajectory.coefficients)
    if not beyond_limits(robot, hull.min(axis=1)).any() and not beyond_limits(robot, hull.max(axis=1)).any():
        return []
    low, high = trajectory.extrema()
    below, above = beyond_limits(robot, low), beyond_limits(robot, high)
    beyond = np.maximum(below, above)
    piece, joint = (int(k) for k in np.unravel_index(int(beyond.argmax()), beyond.shape))
    if not beyond[piece, joint]:
        return []
    over = above[piece, joint] >= below[piece, joint]
    value, limit = (high, robot.upper) if over else (low, robot.lower)
    return [_excess(trajectory, robot, "position", (piece, joint), float(value[piece, joint]), float(limit[joint]))]


def _excess(
    trajectory: Trajectory, robot: Robot, kind: str, at: tuple[int, int], value: float, allowed: float
) -> Finding:
    begin, end = trajectory.times[at[0] : at[0] + 2].tolist()
    joint = trajectory.joints[at[1]]
    return Finding("limit", (kind, joint), (begin, end), value, allowed, unit_of(robot, joint, kind))


def largest_jump(trajectory: Trajectory, limits: MotionLimits) -> Jump | None:
    """The largest jump of a velocity, measured by the limits on it; of an acceleration where no velocity jumps.

    In the end the robot stands. So it does before the beginning where it begins at rest; else it may move already.
    None where nothing jumps by more than 1e-6 of the limit, or than rounding may be.
    """
    stands = bool((np.abs(_sides(trajectory, 1)[1][0]) <= _LEAST * limits.velocity).all())
    for order, what in enumerate(KINDS[:2], start=1):
        before, after = _sides(trajectory, order)
        left = np.concatenate([0.0 * after[:1] if stands else after[:1], before])
        size = np.abs(np.concatenate([after, 0.0 * before[-1:]]) - left)
        least = _LEAST * getattr(limits, what) + _noise(trajectory, order)[:, None]
        shares = size / least
        if shares.max() > 1.0:
            k, joint = np.unravel_index(int(shares.argmax()), shares.shape)
            count = int((shares > 1.0).any(axis=1).sum())
            return Jump(what, trajectory.joints[joint], float(size[k, joint]), float(trajectory.times[k]), count)
    return None


def _sides(trajectory: Trajectory, order: int) -> tuple[Floats, Floats]:
    """A derivative at the end and at the beginning of every piece (k, dof): where it is given, one value on both."""
    if order < len(trajectory.columns):
        return trajectory.columns[order][1:], trajectory.columns[order][:-1]
    return trajectory.ends(order)


def _noise(trajectory: Trajectory, order: int) -> Floats:
    """(k + 1,) what rounded positions make of a derivative that is not given, at each point."""
    if order < len(trajectory.columns):
        return np.zeros(len(trajectory.times))
    for_pieces = (2.0, 24.0)[order - 1] * _ROUNDED * np.spacing(np.abs(trajectory.columns[0]).max())
    padded = np.pad(for_pieces / powers(trajectory.seconds, order)[:, -1], 1)
    return padded[:-1] + padded[1:]
