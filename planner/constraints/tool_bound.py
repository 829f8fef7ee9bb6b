"""How far a frame of the arm leaves the chord of a joint motion, and proofs of convex conditions on its pose.

Along q(s) a point x that the joints carry has x'' = sum_i J_i q_i'' + sum_ik (dJ_i/dq_k) q_i' q_k', with J_i the
linear column of the Jacobian, no longer than the reach from axis i, and its rates from :func:`column_rates`. The
rotation R has dR/dq_i = [z_i] R and d²R/dq_i dq_k = [z_min] [z_max] R, of which no column is longer than 1. A curve
that bends by no more than M leaves the chord of its ends by M s (1 - s) / 2, an eighth of M at most. So what is convex
in (x, R) holds on a whole curve where it holds at both ends with that much to spare. Halving a curve divides what it
needs by four.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, numbers
from planner.base.polynomials import bernstein, derivative, evaluate, part
from planner.kinematics.forward import Chain, joint_placements, tool_joint
from planner.robot.reach import Reach
from planner.robot.robot import Robot
from planner.robot.shapes import Body, Sphere

_FINEST = 1e-7  # m, or the length of a column's change: pieces that leave their chord by less are not halved again
_SHORTEST = 2.0**-40  # of a curve: a change from one alternative to another is not looked for more closely
_POINT = 1e-9  # m: radius of a point as a body
_ROUNDED = 64 * np.finfo(np.float64).eps  # relative, a joint: of placements, joint values and derivatives

Slack = Callable[[Ints, Floats, Floats, Floats], Floats]
"""What conditions have to spare at points of curves: ``slack(curve, s, rotation, position)``.

The curve's number (n,), where on it (n,), the frame's rotation (n, 3, 3) and position (n, 3) there. The answer
(n, a, k) is negative where a condition is broken. The k conditions of one of the ``a`` alternatives have to hold all,
for the whole of a piece. Each is concave in (s, rotation, position) on its curve.
"""


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame that a joint (0: the base) carries: ``placement`` (4, 4) in the joint's frame."""

    joint: int
    placement: Floats

    @staticmethod
    def tool(robot: Robot, point: Floats | None = None) -> Frame:
        """The tool frame of ``robot``, its origin moved to ``point`` (3,) of that frame (m)."""
        joint, placement = tool_joint(robot)
        moved = placement.homogeneous.copy()
        if point is not None:
            moved[:3, 3] += moved[:3, :3] @ numbers("point", point, (3,))
        return Frame(joint, moved)

    def reach(self, robot: Robot) -> Floats:
        """(joints,) how far (m) its origin is from a joint's axis at most; 1 for a slide, 0 for what carries it not."""
        return Reach.from_robot(robot, (Body("tool", "tool", self.joint, Sphere(_POINT), self.placement),)).bodies[0]

    def poses(self, robot: Robot, q: Floats) -> tuple[Floats, Floats]:
        """Rotations (n, 3, 3) and positions (n, 3) of the frame in the world at configurations (n, dof)."""
        rotation, position = (array[self.joint] for array in joint_placements(Chain.from_arm(robot), q))
        return rotation @ self.placement[:3, :3], position + rotation @ self.placement[:3, 3]


def column_rates(robot: Robot, frame: Frame | None = None) -> tuple[Floats, Floats]:
    """How fast column i of a frame's Jacobian changes with joint k at most, linear and angular part, (dof, dof) each.

    Valid for every configuration within the joint limits; the tool's, if no frame is given. Where joints follow others
    the column of a planned one is the sum of theirs.
    """
    reach, chain = (frame or Frame.tool(robot)).reach(robot), Chain.from_arm(robot)
    turns, carries, share = ~chain.prismatic, reach > 0, np.abs(chain.coupling)
    both = carries[:, None] & carries[None, :]
    index = np.arange(len(reach))
    later = np.maximum(index[:, None], index[None, :])
    before = index[None, :] < index[:, None]  # [i, k]: joint k carries joint i
    turn_turn = both & turns[:, None] & turns[None, :]
    turned_slide = both & ~turns[:, None] & turns[None, :] & before
    slid_turn = both & turns[:, None] & ~turns[None, :] & ~before
    linear = np.where(turn_turn, reach[later], 0.0) + np.where(turned_slide | slid_turn, 1.0, 0.0)
    return share.T @ linear @ share, share.T @ np.where(turn_turn & before, 1.0, 0.0) @ share


class ToolBound:
    """Upper bounds on how far a frame leaves the chord between its poses at both ends of curves, s in [0, 1].

        bound = ToolBound(robot)
        off, turned = bound(coefficients)     # (m,) m, and (m,) the length of what any column of the rotation is off

    ``|x(s) - (1 - s) x(0) - s x(1)| <= off`` and so for every column of R, or R times any unit vector, by ``turned``;
    the Frobenius norm of the matrix by sqrt(2) ``turned``. Valid within the joint limits, rounding included.
    """

    def __init__(self, robot: Robot, frame: Frame | None = None) -> None:
        self.robot, self.frame = robot, frame or Frame.tool(robot)
        reach, chain = self.frame.reach(robot), Chain.from_arm(robot)
        share, turns = np.abs(chain.coupling), (reach > 0) & ~chain.prismatic
        self.reach, self.turns = reach @ share, turns.astype(float) @ share
        self.rates = column_rates(robot, self.frame)[0]

    def __call__(self, coefficients: Floats, rounded: Floats | float = 0.0) -> tuple[Floats, Floats]:
        """For curves (m, degree + 1, dof) whose derivatives are known to ``rounded`` (m, dof)."""
        slope = derivative(coefficients)
        v, a = _largest(slope) + rounded, _largest(derivative(slope)) + rounded
        off = 0.125 * (a @ self.reach + np.einsum("ni,ik,nk->n", v, self.rates, v))
        turned = 0.125 * (a @ self.turns + (v @ self.turns) ** 2)
        return off * (1.0 + _ROUNDED), turned * (1.0 + _ROUNDED)

    def rounding(self, coefficients: Floats, position: Floats) -> tuple[Floats, Floats]:
        """(m,) what rounding takes at most from a position (m), and from a column of R, near ``position`` (m, 3)."""
        joints = _ROUNDED * np.abs(coefficients).sum(axis=1)
        size = np.abs(position).sum(axis=1) + self.reach.sum() + 1.0
        count = _ROUNDED * self.robot.dof
        return joints @ self.reach + count * size, joints @ self.turns + count


def _largest(coefficients: Floats) -> Floats:
    """(m, dof) no less than the largest absolute value of each joint's polynomial on [0, 1]."""
    spread = _ROUNDED * np.abs(coefficients).sum(axis=1)
    return np.abs(bernstein(coefficients)).max(axis=1) + spread


def prove_along(
    bound: ToolBound, coefficients: Floats, slack: Slack, per_metre: Floats, per_turn: Floats, finest: float = _FINEST
) -> Bools:
    """On which curves sum_k c_k s^k, (m, degree + 1, dof), k conditions on the pose of ``bound``'s frame hold, (m,).

    ``slack`` says what each has to spare at a point; ``per_metre`` and ``per_turn`` (k,) by how much at most that
    changes with the position (m), and with the length by which each column of the rotation changes (for the Frobenius
    norm: sqrt(2)). Pieces that their ends do not prove are halved until none of them needs more than ``finest``, and
    those on which one alternative takes over from another until one of them holds at both ends. Raises
    :class:`ArrayError` for arrays of other shapes, or with what is no finite number.
    """
    coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", bound.robot.dof))
    every = np.arange(len(coefficients))
    look = _Look(bound, coefficients, slack, np.stack([per_metre, per_turn]).astype(float), np.ones(len(every), bool))
    low, high = np.zeros(len(every)), np.ones(len(every))
    open_ = _Pieces(every, low, high, look.at(every, low), look.at(every, high))
    while len((open_ := open_.only(look.holds[open_.curve])).curve):
        needs = look.needs(open_)
        covered = _kept(np.minimum(open_.first, open_.last) - needs[:, None, :])
        changing = ~_kept(np.minimum(open_.first, open_.last)) & (open_.high - open_.low > _SHORTEST)
        look.holds[open_.curve[~covered & ~(needs.max(axis=1) > finest) & ~changing]] = False
        open_ = open_.only(~covered & look.holds[open_.curve])
        middle = 0.5 * (open_.low + open_.high)
        open_ = open_.halved(middle, look.at(open_.curve, middle))
    return look.holds


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Pieces from ``low`` to ``high`` (n,) of curves (n,), and what there is to spare (n, a, k) at both ends."""

    curve: Ints
    low: Floats
    high: Floats
    first: Floats
    last: Floats

    def only(self, rows: Bools) -> _Pieces:
        return _Pieces(self.curve[rows], self.low[rows], self.high[rows], self.first[rows], self.last[rows])

    def halved(self, middle: Floats, between: Floats) -> _Pieces:
        low, high = np.concatenate([self.low, middle]), np.concatenate([middle, self.high])
        first, last = np.concatenate([self.first, between]), np.concatenate([between, self.last])
        return _Pieces(np.tile(self.curve, 2), low, high, first, last)


@dataclass(frozen=True, eq=False)
class _Look:
    """What is asked of curves, and which of them hold as far as was looked, (m,)."""

    bound: ToolBound
    coefficients: Floats
    slack: Slack
    weights: Floats  # (2, k)
    holds: Bools

    def at(self, curve: Ints, s: Floats) -> Floats:
        """(n, a, k) what there is to spare at points of curves, less rounding; without any a curve does not hold."""
        coefficients = self.coefficients[curve]
        rotation, position = self.bound.frame.poses(self.bound.robot, evaluate(coefficients, s))
        noise = np.stack(self.bound.rounding(coefficients, position), axis=1) @ self.weights
        found = self.slack(curve, s, rotation, position) - noise[:, None, :]
        self.holds[curve[~_kept(found)]] = False
        return found

    def needs(self, pieces: _Pieces) -> Floats:
        """(n, k) what pieces between points may use up."""
        coefficients, span = self.coefficients[pieces.curve], pieces.high - pieces.low
        parts = part(coefficients, pieces.low, pieces.high)
        rounded = _ROUNDED * np.abs(coefficients).sum(axis=1) * span[:, None]
        return np.stack(self.bound(parts, rounded), axis=1) @ self.weights


def _kept(spare: Floats) -> Bools:
    """(n,) where all conditions of one alternative of (n, a, k) are kept."""
    kept: Bools = spare.min(axis=2).max(axis=1) >= 0
    return kept
