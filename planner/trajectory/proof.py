"""Proofs about a trajectory: contact-free pieces, limits by exact extrema, and the floor under w."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import OptionError, choices
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

ROUNDING = 1e-6  # relative: printed numbers that are read back exceed a limit by less
_LEAST = 1e-6  # of the limit on the jumping derivative: printed numbers that are read back jump by less
_ROUNDED = 4  # last bits of a position
_REMEDY = {"lines": "; give velocities too", "cubics": "; give accelerations too"}
_FINER = (0.1, 0.01)  # of the resolution, for pieces that it leaves undecided
ASSUMES = "the geometry of robot and scene as given, a controller that follows the interpolation, floating point"


@dataclass(frozen=True)
class Jump:
    """A jump of a joint's ``what`` (velocity or acceleration) at ``time`` s by ``size``.

    It is the largest of ``count`` jumps.
    """

    what: str
    joint: str
    size: float
    time: float
    count: int

    @property
    def infinite(self) -> tuple[str, ...]:
        """The derivatives that are infinite at the jump: acceleration and jerk, or jerk."""
        return KINDS[KINDS.index(self.what) + 1 :]

    def text(self, robot: Robot) -> str:
        """Return joint, size and time of the jump as part of a sentence."""
        largest = "" if self.count == 1 else f" (the largest of {self.count} jumps)"
        size = f"{self.size:.4g} {unit_of(robot, self.joint, self.what)}"
        return f"the {self.what} of joint '{self.joint}' jumps by {size} at {self.time:.3f} s{largest}"


@dataclass(frozen=True, eq=False)
class MotionProof:
    """Verdicts (k,) on a trajectory's pieces, violations of limits, the floor under w, and proofs in time.

    ``pair`` (k,) is the pair that stopped a piece's proof. ``floor_required`` (k,) marks the pieces that have to keep w
    above ``floor``: all but those that lead up from a start, or down to a goal, below it. ``floor_holds`` (k,) marks
    those that do, or are exempt. ``unchecked`` are the assumed limits that a ``jump`` makes infinite.
    """

    verdict: Ints
    pair: Ints
    violations: tuple[Finding, ...]
    floor: float
    floor_required: Bools
    floor_holds: Bools
    in_time: TimeProof
    jump: Jump | None = None
    unchecked: tuple[str, ...] = ()
    constraints: tuple[str, ...] = ()  # that free pieces are proven to keep

    @property
    def free(self) -> bool:
        """Whether every piece is proven free."""
        return bool((self.verdict == Verdict.FREE).all())

    @property
    def whole(self) -> bool:
        """Whether every proof succeeded."""
        limits = not self.violations and not self.unchecked
        return self.free and limits and bool(self.floor_holds.all()) and self.in_time.whole

    def to_dict(self, margin: float, library: str) -> dict[str, Any]:
        """Return the proof with the keys of ``trajectory.json``."""
        record: dict[str, Any] = {
            "pieces": len(self.verdict),
            "pieces_free": int((self.verdict == Verdict.FREE).sum()),
            "margin": margin,
            "collision": library,
            "limits_exceeded": [violation.what[0] for violation in self.violations],
            **({"limits_not_judged": list(self.unchecked)} if self.unchecked else {}),
            "assumes": ASSUMES,
        }
        if self.floor > 0:
            record["floor"] = self._floor()
        if self.constraints:
            record["kept"] = list(self.constraints)
        return record | self.in_time.to_dict()

    def _floor(self) -> dict[str, Any]:
        """Return the numbers of pieces proven above the floor, exempt, or unproven."""
        required, above = int(self.floor_required.sum()), int((self.floor_required & self.floor_holds).sum())
        pieces = {"above": above, "exempt": len(self.verdict) - required, "below": required - above}
        counts = {f"pieces_{name}": count for name, count in pieces.items()}
        return {"asked": self.floor, **counts, "proven": above == required > 0}


def require_joints(joints: tuple[str, ...], checker: CollisionChecker) -> None:
    """Raise :class:`OptionError` if the checker's robot has other ``joints``."""
    if joints != checker.robot.joints:
        raise OptionError(
            f"joints of the trajectory must be {choices(checker.robot.joints)}, got {choices(joints)}: make a checker "
            "for its robot."
        )


def prove_motion(
    trajectory: Trajectory,
    prover: EdgeProver,
    limits: MotionLimits,
    floor: float = 0.0,
    *,
    kinds: Sequence[str] = KINDS,
    in_time: TimeProof | None = None,
) -> MotionProof:
    """Prove the pieces free, the limits kept by exact extrema, and w above ``floor`` once it is reached.

    Only limits of the first ``kinds`` are checked; ``in_time`` is a proof in time from before.
    """
    verdict, pair = prove_pieces(trajectory.coefficients, prover, PROOF)
    required = _find_floor_pieces(trajectory, prover.robot, floor)
    holds = ~required
    if required.any():
        holds[required] = prove_floor(prover.robot, trajectory.coefficients[required], floor).holds
    violations = find_limit_violations(trajectory, prover.robot, limits, kinds)
    in_time = in_time or prove_in_time(trajectory, prover.checker)
    jump = largest_jump(trajectory, limits)
    unchecked = tuple(kind for kind in kinds if jump and kind in jump.infinite and not limits.is_given(kind))
    return MotionProof(
        verdict, pair, violations, floor, required, holds, in_time, jump, unchecked, prover.world.constraints.texts
    )


def prove_pieces(coefficients: Floats, prover: EdgeProver, resolution: float) -> tuple[Ints, Ints]:
    """Return the verdict (k,) on each piece (k, degree + 1, dof), and the pair (k,) that stopped it."""
    if prover.all_free(coefficients, resolution):
        return np.full(len(coefficients), int(Verdict.FREE)), np.full(len(coefficients), -1)
    proofs = prover.prove_curves(coefficients, resolution)
    verdict, pair = proofs.verdict.copy(), proofs.pair.copy()
    for share in _FINER:
        open_ = np.flatnonzero(verdict == Verdict.UNDECIDED)
        if not len(open_):
            break
        again = prover.prove_curves(coefficients[open_], share * resolution)
        verdict[open_], pair[open_] = again.verdict, again.pair
    return verdict, pair


def _find_floor_pieces(trajectory: Trajectory, robot: Robot, floor: float) -> Bools:
    """Return which pieces (k,) lie between the first and the last knot with w of ``floor`` or more.

    The others lead up from the start and down to the end. A floor of 0 has none.
    """
    required = np.zeros(len(trajectory.coefficients), dtype=bool)
    if floor <= 0:
        return required
    above = np.flatnonzero(manipulability(robot, trajectory.knots()) >= floor)
    if len(above):
        required[int(above[0]) : int(above[-1])] = True
    return required


def unit_of(robot: Robot, joint: str, quantity: str = "position") -> str:
    """Return the unit of a joint's position, or of a derivative."""
    return ("m" if robot.prismatic[robot.joints.index(joint)] else "rad") + UNITS.get(quantity, "")


def find_limit_violations(
    trajectory: Trajectory, robot: Robot, limits: MotionLimits, kinds: Sequence[str] = KINDS
) -> tuple[Finding, ...]:
    """Return the worst violation of each kind of limit, by the exact extrema of every piece.

    A jump of a derivative makes the next one infinite, which violates a given limit; an assumed limit is not checked
    then.
    """
    findings, jump = _find_position_violation(trajectory, robot), largest_jump(trajectory, limits)
    for order, kind in enumerate(kinds, start=1):
        most = getattr(limits, kind)
        if jump and kind in jump.infinite and limits.is_given(kind):
            allowed = float(most[trajectory.joints.index(jump.joint)])
            unit, at = unit_of(robot, jump.joint, kind), (jump.time, jump.time)
            infinite = f"an infinite {kind} where the limit is {allowed:g} {unit}"
            text = f"{jump.text(robot)}: {infinite}{_REMEDY.get(trajectory.interpolation, '')}"
            findings.append(Finding("discontinuity", (kind, jump.joint), at, None, allowed, unit, text=text))
            continue
        share, piece, joint = trajectory.worst(order, most, 1.0)
        if share > 1.0 + ROUNDING:
            allowed = float(most[joint])
            findings.append(_make_finding(trajectory, robot, kind, (piece, joint), share * allowed, allowed))
    return tuple(findings)


def _find_position_violation(trajectory: Trajectory, robot: Robot) -> list[Finding]:
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
    return [
        _make_finding(trajectory, robot, "position", (piece, joint), float(value[piece, joint]), float(limit[joint]))
    ]


def _make_finding(
    trajectory: Trajectory, robot: Robot, kind: str, at: tuple[int, int], value: float, allowed: float
) -> Finding:
    begin, end = trajectory.times[at[0] : at[0] + 2].tolist()
    joint = trajectory.joints[at[1]]
    return Finding("limit", (kind, joint), (begin, end), value, allowed, unit_of(robot, joint, kind))


def largest_jump(trajectory: Trajectory, limits: MotionLimits) -> Jump | None:
    """Return the largest jump of a velocity, relative to its limit, else of an acceleration; or None.

    The robot rests after the end, and before a start at rest; before another start it may move already. Jumps below
    1e-6 of the limit, or within rounding, do not count.
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
    """Return a derivative at the end and at the start of every piece (k, dof): a given one is continuous."""
    if order < len(trajectory.columns):
        return trajectory.columns[order][1:], trajectory.columns[order][:-1]
    return trajectory.ends(order)


def _noise(trajectory: Trajectory, order: int) -> Floats:
    """Return the rounding error (k + 1,) at each point of a derivative that is computed from positions."""
    if order < len(trajectory.columns):
        return np.zeros(len(trajectory.times))
    for_pieces = (2.0, 24.0)[order - 1] * _ROUNDED * np.spacing(np.abs(trajectory.columns[0]).max())
    padded = np.pad(for_pieces / powers(trajectory.seconds, order)[:, -1], 1)
    return padded[:-1] + padded[1:]
