"""The quickest motion along a curve of lines and parabolas within limits on velocity and acceleration.

Along a piece q(s) the joints' acceleration is q' u + q'' x with u = d²s/dt² and x = (ds/dt)², dx/ds = 2 u. On a grid
within the pieces u is constant, so x is linear in s; q' is linear too and q'' constant, so that every joint's
acceleration is linear in s: within limits at both ends of an interval it is so everywhere on it. From the end back the
largest x from which the rest can be done, from the start on the largest u that stays below it (TOPP-RA: Pham and Pham
2018). A velocity limit bounds x by the square of v / q', which is not linear: between the ends of an interval a chord
below it is kept to, so that 24 intervals a corner come within 0.4 % of 800. Lines need no grid: they are accelerated
on, cruised along and braked on in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from planner.base.arrays import Floats
from planner.native.library import quickest_motion
from planner.trajectory.curve import Curve

_CORNER, _RAMP = 24, 3  # intervals of the parabolas of corners and ramps: s of a ramp is time, u stays near 0 there


@dataclass(frozen=True)
class Phase:
    """``duration`` s with a constant ``acceleration`` of the parameter of ``piece``, from ``s`` at ``speed``."""

    piece: int
    s: float
    speed: float
    acceleration: float
    duration: float


def _parts(count: int) -> Floats:
    """Intervals (count, 2) of a parabola, shorter towards its ends: with even ones motions take 1 % longer."""
    even = np.arange(count + 1) / count
    places = even**2 * (3.0 - 2.0 * even)
    return np.stack([places[:-1], places[1:]], axis=1)


_PARTS = {count: _parts(count) for count in (1, _RAMP, _CORNER)}


def quickest(curve: Curve, velocity: Floats, acceleration: Floats) -> list[Phase]:
    """The phases of the quickest motion along ``curve`` from rest to rest; limits (dof,)."""
    lines = np.logical_not(curve.coefficients[:, 2].any(axis=1))
    count = np.where(lines, 1, np.where(curve.corner < 0, _RAMP, _CORNER))
    piece = np.repeat(np.arange(len(lines)), count)
    parts = np.concatenate([_PARTS[number] for number in count.tolist()])
    joint = np.ones(len(piece))
    joint[np.cumsum(count) - 1] = _joints(curve)
    found = quickest_motion(curve.coefficients, piece, parts, joint, velocity, acceleration)
    phases: list[Phase] = []
    for k, (low, high), (x, end, u) in zip(piece.tolist(), parts.tolist(), found.tolist(), strict=True):
        if lines[k]:
            phases += _along_line(k, x, end, velocity, curve.coefficients[k, 1], u)
        else:
            phases.append(Phase(k, low, sqrt(x), u, 2.0 * (high - low) / (sqrt(x) + sqrt(end))))
    return phases


def _along_line(piece: int, x: float, end: float, velocity: Floats, delta: Floats, u: float) -> list[Phase]:
    """Speed up, cruise and brake, with the acceleration ``u`` of the parameter."""
    with np.errstate(divide="ignore"):
        most = float((velocity / np.abs(delta)).min()) ** 2
    peak = min(most, 0.5 * (x + end) + u)
    low, high, top = sqrt(x), sqrt(end), sqrt(peak)
    up, down = (peak - x) / (2.0 * u), (peak - end) / (2.0 * u)
    cruise = max(0.0, 1.0 - up - down)
    parts = [
        Phase(piece, 0.0, low, u, (top - low) / u),
        Phase(piece, up, top, 0.0, cruise / top),
        Phase(piece, 1.0 - down, top, -u, (top - high) / u),
    ]
    return [part for part in parts if part.duration > 0.0]


def _joints(curve: Curve) -> Floats:
    """By what x is multiplied behind each piece (m,), so that the joints' velocities go on; 0 for a stop."""
    slope, bend = curve.coefficients[:, 1], curve.coefficients[:, 2]
    end, start = ((slope + 2.0 * bend) ** 2).sum(axis=1), (slope**2).sum(axis=1)
    joint = np.zeros(len(curve.stop))
    joint[:-1] = np.where(curve.stop[:-1], 0.0, end[:-1] / start[1:])
    return joint
