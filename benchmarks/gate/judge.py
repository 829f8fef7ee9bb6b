"""The judge on what the gate calls safe: the controller's own splines looked at closely, and limits by roots.

It shares nothing with the gate but the collision libraries, coal and FCL, which are asked about states alone.
"""

# pyright: reportAttributeAccessIssue=false
from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from benchmarks.gate.chunks import KINDS, Chunk
from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalChecker
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.robot import Robot
from planner.robot.shapes import corners
from planner.session.verdict import Verdict
from planner.trajectory.limits import MotionLimits

LOOKS = 64e-3, 16e-3, 4e-3, 1e-3, 2.5e-4, 5e-5  # m that a point moves from one state to the next, of each look
CLOSE = 1e-3  # m: states of such looks are put to both judges
_APART = 5e-4  # m between two states of a contact that may end
MEASURED = 8  # states whose distance is measured, for the climb


@dataclass(frozen=True, eq=False)
class Spline:
    """A polynomial (degree + 1, dof) of t in [0, seconds], from ``begin`` s on."""

    begin: float
    seconds: float
    powers: Floats

    def at(self, t: Floats, order: int = 0) -> Floats:
        """Values (n, dof) at ``t`` (n,) s since its begin, or a derivative."""
        c = self._slopes(order)
        return np.vander(t, len(c), increasing=True) @ c

    def _slopes(self, order: int) -> Floats:
        """The powers of a derivative."""
        c = self.powers
        for _ in range(order):
            c = c[1:] * np.arange(1, len(c))[:, None] if len(c) > 1 else 0.0 * c
        return c

    def bound(self, order: int) -> Floats:
        """No less than the largest absolute value (dof,) of a derivative: that of its control points."""
        c = self._slopes(order)
        n = len(c) - 1
        shares = [[math.comb(i, k) / math.comb(n, k) * self.seconds**k for k in range(n + 1)] for i in range(n + 1)]
        return np.abs(np.array(shares) @ c).max(axis=0)

    def largest(self, order: int) -> Floats:
        """The largest absolute value (dof,) of a derivative, at both ends and where the next one is 0."""
        found = np.abs(self.at(np.array([0.0, self.seconds]), order)).max(axis=0)
        for j in range(self.powers.shape[1]):
            slope = np.polynomial.Polynomial(self.powers[:, j]).deriv(order + 1)
            roots = np.atleast_1d(slope.roots()) if slope.degree() else np.zeros(0)
            real = np.asarray(roots.real, dtype=np.float64)
            inner = real[(np.abs(roots.imag) < 1e-9) & (real > 0) & (real < self.seconds)]
            if len(inner):
                found[j] = max(found[j], np.abs(self.at(inner, order)[:, j]).max())
        return found


def spline(begin: float, seconds: float, first: Floats, last: Floats) -> Spline:
    """The polynomial with the values and derivatives (rows, dof) at both ends: rows = 1, 2 or 3."""
    rows = len(first)
    conditions = []
    for t in (0.0, seconds):
        for order in range(rows):
            conditions.append([_slope(power, order) * t ** max(power - order, 0) for power in range(2 * rows)])
    powers = np.linalg.solve(np.array(conditions), np.concatenate([first, last]))
    return Spline(begin, seconds, np.asarray(powers, dtype=np.float64))


def _slope(power: int, order: int) -> float:
    return float(np.prod(np.arange(power, power - order, -1))) if power >= order else 0.0


def motion_of(chunk: Chunk) -> list[Spline]:
    """What a controller runs of a chunk."""
    rows = KINDS.index(chunk.kind) + 1
    return [
        spline(float(t), float(end - t), a[:rows], b[:rows])
        for t, end, a, b in zip(chunk.times, chunk.times[1:], chunk.knots, chunk.knots[1:], strict=False)
    ]


def stops_of(chunk: Chunk, verdict: Verdict) -> list[Spline] | None:
    """The stops that the verdict has from every target on; None where it has none for one."""
    found: list[Spline] = []
    for k, t in enumerate(chunk.times[1:].tolist(), 1):
        stop = verdict._stop_after(k)
        if stop is None:
            return None
        ends = np.stack(stop.columns, axis=1)
        parts = zip(stop.times.tolist(), stop.seconds.tolist(), ends, ends[1:], strict=False)
        found += [spline(t + begin, seconds, first, last) for begin, seconds, first, last in parts]
    return found


def possible_stops(verdict: Verdict) -> list[Spline] | None:
    """The stops that limits allow from every target on, proven or not; None where one has none."""
    pieces, seconds, _ = verdict._guard.find_stops(verdict._run().knots[1:])
    if not seconds[:, 1].all():
        return None
    return [
        Spline(0.0, float(t), c / t ** np.arange(len(c))[:, None])
        for c, t in zip(pieces.reshape(-1, *pieces.shape[2:]), seconds.ravel(), strict=True)
        if t > 0
    ]


def beyond_limits(motion: Sequence[Spline], stops: Sequence[Spline], limits: MotionLimits, kind: str) -> float:
    """The largest share of a limit, beyond 1, that the motion or a stop has of what is judged; 0 for none."""
    judged, worst = KINDS.index(kind) + 1, 0.0
    for curves, count in ((motion, judged), (stops, 3)):
        for one in curves:
            for order in range(1, count + 1):
                most = (limits.velocity, limits.acceleration, limits.jerk)[order - 1]
                if (one.bound(order) <= most).all():
                    continue
                worst = max(worst, float((one.largest(order) / most).max()) - 1.0)
    return worst if worst > 1e-5 else 0.0


def states_on(curve: Spline, reach: Floats, apart: float) -> Floats:
    """States (n, dof) on a curve between which no point moves farther than ``apart`` (m)."""
    count = int(np.ceil(_fastest(curve, reach) * curve.seconds / apart)) + 2
    return curve.at(np.linspace(0.0, curve.seconds, count))


def states_apart(robot: Robot, curves: Sequence[Spline], link: str, left: float, box: Floats | None) -> Floats:
    """States (n, dof) in which a link may not touch: after ``left`` s, or with a corner of it outside ``box`` (6,)."""
    reach, found, chain = reach_of(robot), [np.zeros((0, robot.dof))], Chain.from_arm(robot)
    for curve in curves:
        count = int(np.ceil(_fastest(curve, reach) * curve.seconds / _APART)) + 2
        t = np.linspace(0.0, curve.seconds, count)
        q, out = curve.at(t), curve.begin + t > left
        if box is not None:
            rotation, position = joint_placements(chain, q)
            for body in (body for body in robot.bodies if body.link == link):
                points, radius = corners(body.shape)
                points = points @ body.placement[:3, :3].T + body.placement[:3, 3]
                there = rotation[body.joint] @ points.T + position[body.joint][..., None]
                low, high = there.min(axis=2) - radius, there.max(axis=2) + radius
                out = out | (low < box[:3]).any(axis=1) | (high > box[3:]).any(axis=1)
        found.append(q[out])
    return np.concatenate(found)


@lru_cache(maxsize=8)
def reach_of(robot: Robot) -> Floats:
    """(bodies, dof): metres by which a point of a body moves at most per unit of a joint, of any configuration."""
    led = {item.joint: (item.leader, abs(item.multiplier), abs(item.offset)) for item in robot.followers}
    found = np.zeros((len(robot.bodies), robot.dof))
    for body, row in zip(robot.bodies, found, strict=True):
        points, radius = corners(body.shape)
        far = float(np.linalg.norm(points @ body.placement[:3, :3].T + body.placement[:3, 3], axis=1).max()) + radius
        joint = body.joint
        while joint:
            name, slides = robot.model.names[joint], robot.model.joints[joint].shortname().startswith("JointModelP")
            leader, factor, zero = led.get(name, (name, 1.0, 0.0))
            column = robot.joints.index(leader)
            row[column] += factor * (1.0 if slides else far)
            far += float(np.linalg.norm(robot.model.jointPlacements[joint].translation))
            most = max(abs(robot.lower[column]), abs(robot.upper[column]))
            far += float(factor * most + zero) if slides else 0.0
            joint = robot.model.parents[joint]
    return found


def _fastest(curve: Spline, reach: Floats) -> float:
    """How fast (m/s) a point moves at most."""
    return max(float((reach @ curve.bound(1)).max()), 1e-9)


def sample_states(curves: Sequence[Spline], judge: CoalChecker, reach: Floats) -> tuple[Floats, Floats]:
    """States (n, dof) on the curves: those every 0.05 mm wherever that may touch, and the last that were near.

    A state stands for all from which no point moves farther than half of ``LOOKS``: where every pair is farther apart
    than that by coal's own distances, none of these touches, else they are looked at more closely.
    """
    powers = np.zeros((len(curves), 6, reach.shape[1]))
    for row, curve in zip(powers, curves, strict=True):
        row[: len(curve.powers)] = curve.powers
    seconds = np.array([curve.seconds for curve in curves])
    moved = np.array([_fastest(curve, reach) for curve in curves]) * seconds
    count = np.ceil(moved / LOOKS[0]).astype(int)
    owner, width = np.repeat(np.arange(len(curves)), count), np.repeat(seconds / count, count)
    t = np.concatenate([(np.arange(n) + 0.5) * whole / n for n, whole in zip(count, seconds, strict=True)])
    pairs, close, last = judge.world.checked.size, [np.zeros((0, reach.shape[1]))], np.zeros(0)
    for apart, finer in zip(LOOKS, (*LOOKS[1:], LOOKS[-1]), strict=True):
        q = np.einsum("nk,nkd->nd", np.vander(t, 6, increasing=True), powers[owner])
        extra = np.full(pairs + len(judge.world.self_pairs), apart / 2)
        extra[pairs:] = apart  # both of them move
        near = judge.near(q, extra)
        last = q[near] if near.any() else last if len(last) else q
        close += [q[near]] if apart <= CLOSE else []
        parts = round(apart / finer)
        steps = (np.arange(parts) + 0.5) / parts - 0.5
        t = (t[near][:, None] + width[near][:, None] * steps).ravel()
        owner, width = np.repeat(owner[near], parts), np.repeat(width[near] / parts, parts)
    return np.concatenate(close), last


def touches(curves: Sequence[Spline], judges: tuple[CoalChecker, CollisionChecker]) -> tuple[float, bool]:
    """The smallest distance (m) to an obstacle that coal has seen, and whether coal or the other sees a contact."""
    coal, reach = judges[0], reach_of(judges[0].robot)
    close, last = sample_states(curves, coal, reach)
    seen = [curve.at(np.linspace(0.0, curve.seconds, 5)) for curve in curves]  # what is inside something stays there
    states = np.concatenate([close, *seen])
    touched = any(judge.first_contact(states) is not None for judge in judges)
    checked = np.flatnonzero(coal.world.checked.ravel() & coal.world.moving[: coal.world.checked.size])
    rotation, position = joint_placements(coal.chain, last[:: -(-len(last) // MEASURED)])
    gaps = [coal.distances(rotation[:, k], position[:, k], checked).min() for k in range(rotation.shape[1])]
    return float(min(gaps)), touched
