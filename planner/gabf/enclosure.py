"""When a law settles, proved: upper and lower solutions that the true states stay between, from any start."""

from __future__ import annotations

import math

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import AssumptionError
from planner.gabf.assumptions import Premises, start_above
from planner.gabf.flows import Flow
from planner.gabf.problem import Problem
from planner.gabf.sub_super_solutions import Side, limit

WIDTH = 0.5
"""Share of the latest settling tau that a bracket may be wide before it is computed again with smaller steps.

It takes about three times the work of a run, at 0.1 ten times.
"""

_STEPS = 64
_ROUNDS = 6
_MOST_STEPS = 40_000
"""Steps of one side in one round, and of one in all rounds before the last: a rise over X at arcs of cost c takes X / c
at least.
"""

_MOST_WORK = 10_000_000
"""Rows times hops, the least work of a side: each step looks at every row and goes on by one hop. About 3 s."""

_BLUR = 64 * np.finfo(float).eps
"""Rounding of a state, relative to max(1, |x*|), that counts for neither side of a band; 1e-5 of the default one."""

_ROUNDING = 1e-9

_RAMP = 16.0
"""Early steps change states that fall from far away by this many times a later step's share of the whole: they fall as
a power of tau, from 17 to 1 within 1e-120 where an exponent is 99.
"""


def bracket_settling(
    problem: Problem,
    flow: Flow,
    y0: Floats,
    bounds: Premises,
    tolerance: float,
    guess: float,
    width: float = WIDTH,
    y_star: Floats | None = None,
) -> tuple[float, float]:
    """The earliest and the latest tau at which every error can have entered its band for good.

    ``tolerance`` defines the band as in :func:`planner.gabf.solve`; ``guess`` is where to expect the answer and
    decides about the work only. Steps shrink until the bracket is ``width`` of its end, or the work is spent: a
    smaller width takes proportionally more. The latest is +inf where the lower solution is not there within the work,
    and the earliest 0 as well where rows and hops to a source are too many to begin. Proved up to rounding, for every
    increasing kernel. ``y_star`` (R + S,): the fixed point, where it is known.
    """
    hops = int(problem.hops.max(initial=0))
    if problem.n_rows * hops > _MOST_WORK:
        return 0.0, math.inf
    y_star = _optimum(problem) if y_star is None else y_star
    limits = [limit(problem, y0, y_star, upper) for upper in (True, False)]
    earliest, latest = 0.0, math.inf
    whole = guess or flow.pace
    dtau, spent = whole / max(_STEPS, hops), 0  # what a step finds goes one hop on
    for _ in range(_ROUNDS):
        sides = [Side(problem, flow, y0, bounds, upper, limits[not upper]) for upper in (True, False)]
        ramp = math.expm1(min(_RAMP * dtau / whole * flow.far_power, 30.0))
        dates = [_dates(side, y_star, tolerance, dtau, ramp) for side in sides]
        earliest = max(earliest, *(outside * (1.0 - _ROUNDING) for outside, _ in dates))
        latest = min(latest, max(inside * (1.0 + _ROUNDING) for _, inside in dates))
        spent += max(side.steps for side in sides)
        if math.isinf(latest) or latest - earliest <= width * latest or spent >= _MOST_STEPS:
            break
        dtau *= min(0.5, max(0.125, 0.8 * width * latest / (latest - earliest)))
    return earliest, latest


def _optimum(problem: Problem) -> Floats:
    """x*, from above: as many sweeps of eq. (bellman-gabf) as there are rows suffice."""
    settled = problem.settled(start_above(problem), problem.n_rows)
    if settled is None:
        raise AssumptionError(
            f"x* is not reached in as many sweeps as there are nodes: {type(problem.network.kernel).__name__} does not "
            "increase, or is not progressive, somewhere between the values that it was probed at; mend it"
        )
    return settled[0]


def _dates(side: Side, y_star: Floats, tolerance: float, dtau: float, ramp: float) -> tuple[float, float]:
    """Two tau: the last at which this side proves a state outside its band, and the first after which none leaves it.

    "Leaves" means on this side only, and is proven too.
    """
    scale = np.maximum(1.0, np.abs(y_star))
    band, blur = tolerance * scale, min(0.01 * tolerance, _BLUR) * scale
    inner, outer = band - blur, -band - blur
    outside, inside = 0.0, math.inf
    first = min(side.first_step, dtau)
    for _ in range(_MOST_STEPS):
        beyond = side.sign * (side.y - y_star)
        within = bool((beyond <= inner).all())
        if not within:
            inside = math.inf
        elif math.isinf(inside) and side.stays(y_star):
            inside = side.tau
        short = bool((beyond < outer).any())
        if short:
            outside = side.tau
        elif math.isfinite(inside):
            break
        side.step(min(dtau, max(first, ramp * side.tau)))
    return outside, inside
