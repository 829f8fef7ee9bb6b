"""The quickest motion along a curve of lines and parabolas within limits on velocity and acceleration.

Along a piece q(s) the joints' acceleration is q' u + q'' x with u = d²s/dt² and x = (ds/dt)², dx/ds = 2 u. On a grid
within the pieces u is constant, so x is linear in s; q' is linear too and q'' constant, so that every joint's
acceleration is linear in s: within limits at both ends of an interval it is so everywhere on it. From the end back the
largest x from which the rest can be done, from the start on the largest u that stays below it (TOPP-RA: Pham and Pham
2018). Lines need no grid: they are accelerated on, cruised along and braked on in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.motion.curve import Curve

GRID = 24  # intervals of a parabola: with 12 motions take 2 % longer
_NEWTON = 60  # steps at most; each leaves one of finitely many lines behind


@dataclass(frozen=True)
class Phase:
    """``duration`` s with a constant ``acceleration`` of the parameter of ``piece``, from ``s`` at ``speed``."""

    piece: int
    s: float
    speed: float
    acceleration: float
    duration: float


def quickest(curve: Curve, velocity: Floats, acceleration: Floats) -> list[Phase]:
    """The phases of the quickest motion along ``curve`` from rest to rest; limits (dof,)."""
    steps = [step for piece in range(len(curve.corner)) for step in _steps(curve, piece, velocity, acceleration)]
    reachable = _backwards(steps)
    phases: list[Phase] = []
    x = 0.0
    for step, most in zip(steps, reachable[1:], strict=True):
        step_phases, x = step.forward(x, most)
        phases += step_phases
        x *= step.joint
    return phases


def _backwards(steps: list[_Line | _Bend]) -> list[float]:
    """The largest x at the start of every step, and at the end of the last, from which the rest can be done."""
    most = [0.0]
    for step in reversed(steps):
        # x of the step's own piece; at a stop the next one begins from rest
        most.append(step.controllable(most[-1] / step.joint if step.joint else 0.0))
    return most[::-1]


class _Line:
    """A whole line: any speed up to one limit, any acceleration up to another."""

    def __init__(self, piece: int, delta: Floats, velocity: Floats, acceleration: Floats, joint: float) -> None:
        self.piece, self.joint = piece, joint
        with np.errstate(divide="ignore"):
            self.u = float((acceleration / np.abs(delta)).min())
            self.x = float((velocity / np.abs(delta)).min()) ** 2

    def controllable(self, most: float) -> float:
        return min(self.x, min(most, self.x) + 2.0 * self.u)

    def forward(self, x: float, most: float) -> tuple[list[Phase], float]:
        """Speed up, cruise and brake; ``most`` is the x allowed at the end, in the next piece's parameter."""
        end = min(most / self.joint if self.joint else 0.0, self.x, x + 2.0 * self.u)
        peak = min(self.x, 0.5 * (x + end) + self.u)
        low, high, top = np.sqrt([x, end, peak]).tolist()
        up, down = (peak - x) / (2.0 * self.u), (peak - end) / (2.0 * self.u)
        cruise = max(0.0, 1.0 - up - down)
        parts = [
            Phase(self.piece, 0.0, low, self.u, (top - low) / self.u),
            Phase(self.piece, up, top, 0.0, cruise / top),
            Phase(self.piece, 1.0 - down, top, -self.u, (top - high) / self.u),
        ]
        return [part for part in parts if part.duration > 0.0], end


class _Bend:
    """One interval of a parabola, on which u is constant: the linear constraints on u and on x at its start."""

    def __init__(
        self, piece: int, s: float, length: float, slopes: Floats, bend: Floats, limits: tuple[Floats, Floats]
    ) -> None:
        """``slopes`` (2, dof) are q' at both ends, ``bend`` (dof,) is q''."""
        velocity, acceleration = limits
        self.piece, self.s, self.length, self.joint = piece, s, length, 1.0
        fastest = np.abs(slopes).max(axis=0)
        with np.errstate(divide="ignore"):
            self.x = float((velocity / fastest).min()) ** 2
        first, last = slopes[0], slopes[1] + 2.0 * length * bend  # x grows by 2 length u until the end
        self.by_u = np.concatenate([first, -first, last, -last, [2.0 * length, -2.0 * length]])
        self.by_x = np.concatenate([bend, -bend, bend, -bend, [1.0, -1.0]])
        self.at_most = np.concatenate([np.tile(acceleration, 4), [0.0, 0.0]])

    def _range(self, x: float, most: float) -> tuple[float, float, float, float]:
        """The least and the largest u at ``x``, and how they change with it."""
        self.at_most[-2] = most
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (self.at_most - self.by_x * x) / self.by_u
        up = np.where(self.by_u > 0, u, np.inf).argmin()
        low = np.where(self.by_u < 0, u, -np.inf).argmax()
        slopes = -self.by_x[[low, up]] / self.by_u[[low, up]]
        return float(u[low]), float(u[up]), float(slopes[0]), float(slopes[1])

    def controllable(self, most: float) -> float:
        """By Newton's method from above on (largest u) - (least u), which is concave and piecewise linear in x."""
        most = min(most, self.x)
        free = (self.by_u == 0.0) & (self.by_x > 0.0)
        x = min(self.x, float((self.at_most[free] / self.by_x[free]).min(initial=np.inf)))
        for _ in range(_NEWTON):
            low, high, low_slope, high_slope = self._range(x, most)
            if low <= high:
                break
            step = (high - low) / (high_slope - low_slope)
            if not 0.0 < step <= x or x - step == x:
                return max(0.0, x * (1.0 - 1e-12))
            x -= step
        return x

    def forward(self, x: float, most: float) -> tuple[list[Phase], float]:
        """Speed up as much as ``x`` and ``most`` at the end allow; ``most`` is in the next piece's parameter."""
        most = min(most / self.joint if self.joint else 0.0, self.x)
        low, high, _, _ = self._range(x, most)
        u = high if high >= low else 0.5 * (low + high)  # they cross by rounding only
        end = max(0.0, x + 2.0 * self.length * u)
        speed, last = np.sqrt([x, end]).tolist()
        return [Phase(self.piece, self.s, speed, u, 2.0 * self.length / (speed + last))], end


def _steps(curve: Curve, piece: int, velocity: Floats, acceleration: Floats) -> list[_Line | _Bend]:
    _, slope, bend = curve.coefficients[piece]
    joint = _joint(curve, piece)
    if curve.corner[piece] < 0:
        return [_Line(piece, slope, velocity, acceleration, joint)]
    grid = np.linspace(0.0, 1.0, GRID + 1)
    slopes = slope + 2.0 * grid[:, None] * bend
    limits = velocity, acceleration
    steps: list[_Line | _Bend] = [
        _Bend(piece, float(grid[k]), 1.0 / GRID, slopes[k : k + 2], 2.0 * bend, limits) for k in range(GRID)
    ]
    steps[-1].joint = joint
    return steps


def _joint(curve: Curve, piece: int) -> float:
    """By what x is multiplied where the next piece begins, so that the joints' velocities go on; 0 for a stop."""
    if curve.stop[piece]:
        return 0.0
    end = curve.coefficients[piece, 1] + 2.0 * curve.coefficients[piece, 2]
    return float((end**2).sum() / (curve.coefficients[piece + 1, 1] ** 2).sum())
