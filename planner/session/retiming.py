"""The same path in more time: a chunk's pieces at a rate that falls smoothly from 1.

With the chunk's own time s and the rate r = ds/dt the velocity is c'(s) r and the acceleration c''(s) r² + c'(s) dr/dt.
The robot has its velocity already, so r starts at 1, without a jump of r or dr/dt, and reaches 1 / scale after T:
r = 1 - (1 - 1 / scale) (3 τ² - 2 τ³), τ = t / T. Lines jump in velocity at every point, so their rate may jump too.
"""

import numpy as np

from planner.base.arrays import Floats
from planner.base.polynomials import derivative, evaluate
from planner.trajectory.trajectory import to_nanoseconds

SCALES = (1.1, 1.25, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)  # of the duration
_EASES = 1.1, 1.6, 2.5, 4.0  # times the shortest time in which the rate could fall
_LEAST_EASE = 0.02  # s
_STEPS, _STEP = 8, 0.04  # points while the rate falls, at most so many s apart
_NEAR = 2e-3  # s: a new point closer to one of the chunk is left out
_FINE = 1000  # intervals to find the time of a point


def ease_times(velocity: Floats, most: Floats, scale: float, is_lines: bool) -> list[float]:
    """Return times T (s) for the rate to fall, ascending; 0 for lines.

    The shortest one keeps the limits ``most`` (3, dof) for the largest ``velocity`` (dof,) on a straight path.
    """
    if is_lines:
        return [0.0]
    fall, speed = 1.0 - 1.0 / scale, np.abs(velocity)
    braking, jerking = 1.5 * fall * (speed / most[1]).max(), np.sqrt(6.0 * fall * (speed / most[2]).max())
    return [max(_LEAST_EASE, share * float(max(braking, jerking))) for share in _EASES]


def retime(times: Floats, coefficients: Floats, rows: int, scale: float, ease: float) -> tuple[Floats, Floats] | None:
    """Return new times (k + 1,) and columns (``rows``, k + 1, dof) of pieces (n, degree + 1, dof).

    ``times`` (n + 1,) are those of the pieces' ends. The rate falls in the first ``ease`` seconds. None if the chunk
    ends before.
    """
    rest = 1.0 / scale
    eased = 0.5 * (1.0 + rest) * ease
    since = times - times[0]
    if eased > since[-1]:
        return None
    fine = np.linspace(0.0, ease, _FINE + 1)
    clock = np.interp(since, _share(fine, ease, rest), fine) if ease else 0.0 * since
    clock = np.where(since >= eased, ease + (since - eased) * scale, clock)
    count = int(np.ceil(ease / min(ease / _STEPS, _STEP))) if ease else 0
    extra = ease * np.arange(1, count + 1) / max(count, 1)
    extra = extra[(np.abs(extra[:, None] - clock) > _NEAR).all(axis=1)]
    order = np.argsort(np.concatenate([clock, extra]))
    clock = to_nanoseconds(np.concatenate([clock, extra])[order]) / 1e9
    path = np.where(clock <= ease, _share(clock, ease, rest), eased + (clock - ease) / scale)
    known = order < len(since)  # exact at the chunk's own points, where derivatives can jump
    path[known] = since
    piece = np.clip(np.searchsorted(since, path, side="right") - 1, 0, len(coefficients) - 1)
    seconds = np.diff(times)[piece]
    q, slope, bend = (
        evaluate(derivative(coefficients, k)[piece], (path - since[piece]) / seconds) / seconds[:, None] ** k
        for k in range(3)
    )
    share = np.clip(clock / ease, 0.0, 1.0) if ease else np.ones_like(clock)
    rate = (1.0 - (1.0 - rest) * share**2 * (3.0 - 2.0 * share))[:, None]
    change = (-6.0 * (1.0 - rest) * share * (1.0 - share) / (ease or 1.0))[:, None]
    return clock + times[0], np.stack([q, slope * rate, bend * rate**2 + slope * change])[:rows]


def _share(t: Floats, ease: float, rest: float) -> Floats:
    """Return the chunk's own time at ``t`` (n,) s, up to ``ease``."""
    tau = t / (ease or 1.0)
    return (ease or 1.0) * (tau - (1.0 - rest) * tau**3 * (1.0 - 0.5 * tau))
