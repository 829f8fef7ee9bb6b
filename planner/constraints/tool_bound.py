"""Deviation of a frame from the chord of a joint motion, and proofs of convex conditions on its pose.

Along q(s) a carried point x has x'' = sum_i J_i q_i'' + sum_ik (dJ_i/dq_k) q_i' q_k', where J_i, the linear column of
the Jacobian, is at most the reach from axis i, with the rates of :func:`column_rates`. The rotation R has dR/dq_i =
[z_i] R and d²R/dq_i dq_k = [z_min] [z_max] R, with columns of length at most 1. A curve whose second derivative is at
most M deviates from its chord by at most M s (1 - s) / 2 <= M / 8. So a condition that is convex in (x, R) holds on the
whole curve if it holds at both ends with that slack. Halving a curve divides the needed slack by four.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, length, numbers
from planner.base.polynomials import bernstein, derivative, evaluate, part
from planner.kinematics.forward import Chain, joint_placements, tool_joint, travel
from planner.robot.reach import Reach
from planner.robot.robot import Robot
from planner.robot.shapes import Body, Sphere

_FINEST = 1e-7  # m, or length of a column's change: intervals with less deviation are not halved
_SHORTEST = 2.0**-40  # of a curve: shortest interval on which a change of alternative is sought
_POINT = 1e-9  # m: radius of a point as a body
_ROUNDED = 64 * np.finfo(np.float64).eps  # relative, a joint: of placements, joint values and derivatives

Slack = Callable[[Ints, Floats, Floats, Floats], Floats]
"""Slack (n, a, k) of conditions at points of curves: ``slack(curve, s, rotation, position)``.

Arguments: curve number (n,), s (n,), the frame's rotation (n, 3, 3) and position (n, 3). Negative slack is a violation.
All k conditions of one of the ``a`` alternatives must hold on an interval. Each is concave in (s, rotation, position).
"""


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame with a ``placement`` (4, 4) in the frame of a joint (0: the base).

    Its pose is that in another frame ``base``, or in the world without one. In another frame the joints between the two
    form one chain: up from that frame to the joint that carries both, and down to this one.
    """

    joint: int
    placement: Floats
    base: Frame | None = None

    @staticmethod
    def tool(robot: Robot, point: Floats | None = None) -> Frame:
        """Return the tool frame of ``robot``, its origin moved to ``point`` (3,) m of that frame."""
        joint, placement = tool_joint(robot)
        moved = placement.homogeneous.copy()
        if point is not None:
            moved[:3, 3] += moved[:3, :3] @ numbers("point", point, (3,))
        return Frame(joint, moved)

    def reach(self, robot: Robot) -> Floats:
        """Return (joints,) m: largest distance of its origin from each axis; 1 for a slide, 0 if not carried."""
        if self.base is None:
            item = Body("tool", "tool", self.joint, Sphere(_POINT), self.placement)
            return Reach.from_robot(robot, (item,)).bodies[0]
        chain, own = Chain.from_arm(robot), replace(self, base=None).reach(robot)
        up, down = chain.ancestors(self.base.joint), chain.ancestors(self.joint)
        radius, reach = length(self.placement[:3, 3]) + _POINT, np.zeros(len(own))
        for joint in (joint for joint in down if joint not in up):
            reach[joint - 1] = own[joint - 1]
            radius += length(chain.offset[joint - 1]) + travel(robot, chain, joint - 1)
        for joint in reversed([joint for joint in up if joint not in down]):  # to its origin, which is on its axis
            radius += length(chain.offset[joint - 1]) + travel(robot, chain, joint - 1)
            reach[joint - 1] = 1.0 if chain.prismatic[joint - 1] else radius
        return reach

    def order(self, robot: Robot) -> Ints:
        """Return (joints,) numbers that ascend along the chain to this frame, among the joints that move it."""
        index = np.arange(1, len(Chain.from_arm(robot).parent) + 1)
        if self.base is None:
            return index
        return np.where(np.isin(index, Chain.from_arm(robot).ancestors(self.base.joint)), -index, index)

    def poses(self, robot: Robot, q: Floats) -> tuple[Floats, Floats]:
        """Return rotations (n, 3, 3) and positions (n, 3) at configurations (n, dof)."""
        rotation, position = (array[self.joint] for array in joint_placements(Chain.from_arm(robot), q))
        rotation, position = rotation @ self.placement[:3, :3], position + rotation @ self.placement[:3, 3]
        if self.base is None:
            return rotation, position
        turn, at = self.base.poses(robot, q)
        return turn.swapaxes(-1, -2) @ rotation, np.einsum("nji,nj->ni", turn, position - at)


def column_rates(robot: Robot, frame: Frame | None = None) -> tuple[Floats, Floats]:
    """Return bounds (dof, dof) on the change of Jacobian column i with joint k: linear and angular part.

    Valid within the joint limits, for the tool without ``frame``. For followers, the column of a planned joint is the
    sum of theirs.
    """
    reach, chain = (frame or Frame.tool(robot)).reach(robot), Chain.from_arm(robot)
    turns, carries, share = ~chain.prismatic, reach > 0, np.abs(chain.coupling)
    both = carries[:, None] & carries[None, :]
    index, order = np.arange(len(reach)), (frame or Frame.tool(robot)).order(robot)
    before = order[None, :] < order[:, None]  # [i, k]: joint k carries joint i
    later = np.where(before, index[:, None], index[None, :])
    turn_turn = both & turns[:, None] & turns[None, :]
    turned_slide = both & ~turns[:, None] & turns[None, :] & before
    slid_turn = both & turns[:, None] & ~turns[None, :] & ~before
    linear = np.where(turn_turn, reach[later], 0.0) + np.where(turned_slide | slid_turn, 1.0, 0.0)
    return share.T @ linear @ share, share.T @ np.where(turn_turn & before, 1.0, 0.0) @ share


class ToolBound:
    """Upper bounds on the deviation of a frame from the chord between its end poses, s in [0, 1].

        bound = ToolBound(robot)
        off, turned = bound(coefficients)     # (m,) m, and (m,) length by which any column of the rotation is off

    ``|x(s) - (1 - s) x(0) - s x(1)| <= off``, and the same for R times any unit vector with ``turned``; the Frobenius
    norm is at most sqrt(2) ``turned``. Valid within the joint limits, with rounding.
    """

    def __init__(self, robot: Robot, frame: Frame | None = None) -> None:
        self.robot, self.frame = robot, frame or Frame.tool(robot)
        reach, chain = self.frame.reach(robot), Chain.from_arm(robot)
        share, turns = np.abs(chain.coupling), (reach > 0) & ~chain.prismatic
        self.reach, self.turns = reach @ share, turns.astype(float) @ share
        self.rates = column_rates(robot, self.frame)[0]

    def __call__(self, coefficients: Floats, rounded: Floats | float = 0.0) -> tuple[Floats, Floats]:
        """Return bounds for curves (m, degree + 1, dof); derivatives are exact to ``rounded`` (m, dof)."""
        slope = derivative(coefficients)
        v, a = _largest(slope) + rounded, _largest(derivative(slope)) + rounded
        off = 0.125 * (a @ self.reach + np.einsum("ni,ik,nk->n", v, self.rates, v))
        turned = 0.125 * (a @ self.turns + (v @ self.turns) ** 2)
        return off * (1.0 + _ROUNDED), turned * (1.0 + _ROUNDED)

    def rounding(self, coefficients: Floats, position: Floats) -> tuple[Floats, Floats]:
        """Return bounds (m,) on rounding of a position (m) and of a column of R, near ``position`` (m, 3)."""
        joints = _ROUNDED * np.abs(coefficients).sum(axis=1)
        size = np.abs(position).sum(axis=1) + self.reach.sum() + 1.0
        count = _ROUNDED * self.robot.dof
        return joints @ self.reach + count * size, joints @ self.turns + count


def _largest(coefficients: Floats) -> Floats:
    """Return upper bounds (m, dof) on each joint's polynomial on [0, 1], in absolute value."""
    spread = _ROUNDED * np.abs(coefficients).sum(axis=1)
    return np.abs(bernstein(coefficients)).max(axis=1) + spread


def prove_along(
    bound: ToolBound, coefficients: Floats, slack: Slack, per_metre: Floats, per_turn: Floats, finest: float = _FINEST
) -> Bools:
    """Return which curves sum_k c_k s^k, (m, degree + 1, dof), satisfy the conditions, (m,).

    ``per_metre`` and ``per_turn`` (k,) bound the change of each slack with the position (m), and with the length by
    which each column of the rotation changes (times sqrt(2) for the Frobenius norm). Intervals are halved until the
    ends prove them, or none needs more slack than ``finest`` and one alternative holds at both ends. Raises
    :class:`ArrayError` for wrong shapes or values that are not finite.
    """
    coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", bound.robot.dof))
    every = np.arange(len(coefficients))
    look = _CurveSlacks(
        bound, coefficients, slack, np.stack([per_metre, per_turn]).astype(float), np.ones(len(every), bool)
    )
    low, high = np.zeros(len(every)), np.ones(len(every))
    intervals = _Intervals(every, low, high, look.at(every, low), look.at(every, high))
    while len((intervals := intervals.only(look.holds[intervals.curve])).curve):
        needs = look.needs(intervals)
        covered = _holds(np.minimum(intervals.first, intervals.last) - needs[:, None, :])
        changing = ~_holds(np.minimum(intervals.first, intervals.last)) & (intervals.high - intervals.low > _SHORTEST)
        look.holds[intervals.curve[~covered & ~(needs.max(axis=1) > finest) & ~changing]] = False
        intervals = intervals.only(~covered & look.holds[intervals.curve])
        middle = 0.5 * (intervals.low + intervals.high)
        intervals = intervals.halve(middle, look.at(intervals.curve, middle))
    return look.holds


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Intervals ``low`` to ``high`` (n,) of curves (n,), with slacks (n, a, k) at both ends."""

    curve: Ints
    low: Floats
    high: Floats
    first: Floats
    last: Floats

    def only(self, rows: Bools) -> _Intervals:
        return _Intervals(self.curve[rows], self.low[rows], self.high[rows], self.first[rows], self.last[rows])

    def halve(self, middle: Floats, between: Floats) -> _Intervals:
        low, high = np.concatenate([self.low, middle]), np.concatenate([middle, self.high])
        first, last = np.concatenate([self.first, between]), np.concatenate([between, self.last])
        return _Intervals(np.tile(self.curve, 2), low, high, first, last)


@dataclass(frozen=True, eq=False)
class _CurveSlacks:
    """Slacks of conditions on curves, and which curves hold so far, (m,)."""

    bound: ToolBound
    coefficients: Floats
    slack: Slack
    weights: Floats  # (2, k)
    holds: Bools

    def at(self, curve: Ints, s: Floats) -> Floats:
        """Return slacks (n, a, k) at points, less rounding; a curve with a violated point does not hold."""
        coefficients = self.coefficients[curve]
        rotation, position = self.bound.frame.poses(self.bound.robot, evaluate(coefficients, s))
        noise = np.stack(self.bound.rounding(coefficients, position), axis=1) @ self.weights
        slacks = self.slack(curve, s, rotation, position) - noise[:, None, :]
        self.holds[curve[~_holds(slacks)]] = False
        return slacks

    def needs(self, pieces: _Intervals) -> Floats:
        """Return the slack (n, k) that intervals need between their ends."""
        coefficients, span = self.coefficients[pieces.curve], pieces.high - pieces.low
        parts = part(coefficients, pieces.low, pieces.high)
        rounded = _ROUNDED * np.abs(coefficients).sum(axis=1) * span[:, None]
        return np.stack(self.bound(parts, rounded), axis=1) @ self.weights


def _holds(slacks: Floats) -> Bools:
    """Return where (n,) all conditions of one alternative of slacks (n, a, k) hold."""
    holds: Bools = slacks.min(axis=2).max(axis=1) >= 0
    return holds
