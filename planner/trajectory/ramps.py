"""Parabolic ramps: every joint from a position and velocity to another in the same time (Hauser, Ng-Thow-Hing 2010)."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats

_SHORTEST = 1e-6  # of the ramp: what lies between nearer changes of an acceleration is left out

State = tuple[Floats, Floats]  # position and velocity (dof,)


def quickest_ramp(start: State, end: State, durations: Floats, velocity: Floats, acceleration: Floats) -> Floats | None:
    """Pieces (m, 3, dof) from ``start`` to ``end``, position and velocity (dof,) each; s of a piece is time by its own.

    In the shortest of ``durations`` (n,), ascending, in which every joint can: it speeds up, cruises where it would be
    faster than ``velocity`` (dof,), and slows down, or the other way round, with the least acceleration that does it.
    None where that is beyond ``acceleration`` (dof,) for all durations.
    """
    rates, rises, falls = _rates(start, end, durations[:, None], velocity)
    able = ((np.abs(rates) <= acceleration) & (rises + falls <= durations[:, None] * (1.0 + 1e-12))).all(axis=1)
    if not able.any():
        return None
    k = int(able.argmax())
    return _pieces(start, end, float(durations[k]), rates[k], rises[k], falls[k])


def _rates(start: State, end: State, t: Floats, velocity: Floats) -> tuple[Floats, Floats, Floats]:
    """Accelerations (n, dof), with their sign, and how long they last at the beginning and, negated, at the end.

    Without cruising, a rises for (t + change / a) / 2, and a² t² + 2 (t (v0 + v1) - 2 d) a = change² for the distance
    d and the change of velocity; of its two solutions the one that lasts for times in [0, t].
    """
    (q0, v0), (q1, v1) = start, end
    distance, change = q1 - q0, v1 - v0
    short = t * (v0 + v1) - 2.0 * distance
    rate = -np.copysign(np.abs(short) + np.sqrt(short**2 + (t * change) ** 2), short) / t**2
    with np.errstate(divide="ignore", invalid="ignore"):
        rise = np.where(rate == 0.0, 0.5 * t, 0.5 * (t + change / rate))
        fall = t - rise
        most = np.copysign(velocity, rate)
        cruises = np.abs(v0 + rate * rise) > velocity
        slower = ((most - v0) ** 2 + (most - v1) ** 2) / (2.0 * (most * t - distance))
        slower = np.where(slower * most > 0.0, slower, np.inf)
        rise = np.where(cruises, (most - v0) / slower, rise)
        fall = np.where(cruises, (most - v1) / slower, fall)
    return np.where(cruises, slower, rate), rise, fall


def _pieces(start: State, end: State, t: float, rate: Floats, rise: Floats, fall: Floats) -> Floats:
    """The parabolas between the moments at which some joint's acceleration changes."""
    moments = np.unique(np.concatenate([[0.0, t], rise, t - fall]).clip(0.0, t))
    moments = moments[np.concatenate([[True], np.diff(moments) > _SHORTEST * t])]
    moments[-1] = t
    early, late = moments[:-1, None], moments[1:, None]
    middle, h = 0.5 * (early + late), late - early
    bend = np.where(middle < rise, rate, np.where(middle > t - fall, -rate, 0.0))
    (q0, v0), (q1, v1) = start, end
    up, back = np.minimum(early, rise), np.minimum(t - early, fall)
    cruise = v0 + rate * rise
    q = np.where(
        early <= t - fall,
        q0 + v0 * up + 0.5 * rate * up**2 + cruise * (early - up),
        q1 - v1 * back - 0.5 * rate * back**2,
    )
    v = np.where(early <= t - fall, v0 + rate * up, v1 + rate * back)
    return np.stack([q, v * h, 0.5 * bend * h**2], axis=1)
