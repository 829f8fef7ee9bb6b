"""When a law settles, proved: upper and lower solutions of the equation in tau that every run stays between."""

import math

import numpy as np

from planner.base.arrays import Floats
from planner.gabf.flows import Flow
from planner.gabf.problem import Premises, Problem, ceiling
from planner.gabf.splitting import parents_of

WIDTH = (
    0.5  # share of the latest settling tau that a bracket may be wide; takes three times a run's work, 0.1 ten times
)
_STEPS, _ROUNDS = 64, 6
_MOST_STEPS = 40_000  # of one side in a round, and in all rounds before the last: a rise over X at cost c takes X / c
_MOST_WORK = 10_000_000  # rows times hops, as each step looks at every row and goes on by one hop: about 3 s
_BLUR = 64 * np.finfo(float).eps  # rounding of a state, times max(1, |x*|), that counts for neither side of a band
_ROUNDING = 1e-9
_RAMP = 16.0
"""Early steps change states that fall from far away by this many times a later step's share of the whole: they fall as
a power of tau, from 17 to 1 within 1e-120 where an exponent is 99.
"""
_SPARE = 1.05  # farther than expected that parents are held: nearer is tighter, and fails more often
_SWEEPS, _TIGHTER = 32, 16


def bracket_settling(
    problem: Problem,
    flow: Flow,
    y0: Floats,
    y_star: Floats,
    bounds: Premises,
    tolerance: float,
    guess: float,
    width: float = WIDTH,
) -> tuple[float, float]:
    """The earliest and the latest tau at which every error of a run from ``y0`` can have entered its band for good.

    ``tolerance`` defines the band as in :func:`planner.gabf.solve`; ``guess`` is where to expect the answer and decides
    about the work only. Steps shrink until the bracket is ``width`` of its end, or the work is spent: a smaller width
    takes proportionally more. The latest is +inf where the lower solution is not there within the work, and the
    earliest 0 as well where rows and hops to a source are too many to begin, and for a user's law. Proved up to
    rounding, for every increasing kernel.
    """
    if flow.compiled is None or problem.n_rows * problem.most_hops > _MOST_WORK:
        return 0.0, math.inf
    limits = [limit(problem, y0, y_star, upper) for upper in (True, False)]
    earliest, latest = 0.0, math.inf
    whole = guess or flow.pace
    dtau, spent = whole / max(_STEPS, problem.most_hops), 0  # each step finds one hop more
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


def limit(problem: Problem, y0: Floats, y_star: Floats, upper: bool) -> Floats:
    """(R + S,) states z with m(z) <= z, y0 <= z, which no run from ``y0`` exceeds (with >=: falls below).

    The least (largest) of them is x* itself, ``y_star``, where ``y0`` is nowhere above (below) it.
    """
    if (y0 <= y_star if upper else y0 >= y_star).all():
        return y_star
    worse = np.maximum if upper else np.minimum
    z = ceiling(problem, y0) if upper else y0
    for _ in range(problem.n_rows):
        swept = problem.with_sources(worse(y0[: problem.n_rows], problem.parent_values(z)))
        if np.array_equal(swept, z):
            break
        z = swept
    return z


class Side:
    """An upper (or lower) solution: states ``y`` (R + S,) at ``tau`` that no run from ``y0`` exceeds (falls below).

    The right side of a node's equation increases with every parent's state (the law is cooperative), so runs keep their
    order, and parents held too high (low) over a step give states that are too high (low). Where parents fall that is
    their value at the start of the step; where they rise it is a guess ``reach`` of how far, which the step itself
    proves: if no state goes farther with parents held there, none does at all. First order in the step. ``beyond`` (R +
    S,) are states that no run goes beyond, see :func:`limit`.
    """

    def __init__(self, problem: Problem, flow: Flow, y0: Floats, bounds: Premises, upper: bool, beyond: Floats):
        self.tau, self.y, self.sign, self.steps = 0.0, y0, 1.0 if upper else -1.0, 0
        self._problem, self._rows, self._values = problem, slice(0, problem.n_rows), parents_of(problem, flow)
        self._flow, self._worse, self._better = flow, *((np.maximum, np.minimum) if upper else (np.minimum, np.maximum))
        self._falling, self._rising = (flow.slowest, flow.fastest) if upper else (flow.fastest, flow.slowest)
        self._speed = self._expected = np.zeros(problem.n_rows)
        self._contracts = bounds.L <= 1.0 and not bounds.sampled  # between samples a kernel may be steeper
        self._limit = beyond[self._rows]

    @property
    def first_step(self) -> float:
        """A tenth of the time in which the fastest node would move by its own disequilibrium."""
        largest = float(np.abs(self.y[self._rows] - self._values(self.y)).max(initial=0.0))
        return 0.1 * largest / min(self._flow.speed(largest), 1e300) if largest else math.inf

    @np.errstate(over="ignore")
    def step(self, dtau: float) -> None:
        """Go on by ``dtau``."""
        there = self._from_speed(dtau)
        there = self._better(self._from_fastest(dtau) if there is None else there, self._limit)
        speed = np.maximum(self._outwards(there), 0.0) / dtau
        slowing = np.divide(speed, self._speed, out=np.ones_like(speed), where=speed < self._speed)
        self._speed, self._expected = speed, speed * slowing
        self.tau, self.y, self.steps = self.tau + dtau, self._problem.with_sources(there), self.steps + 1

    def stays(self, y_star: Floats) -> bool:
        """Whether no state ever leaves max(y, y_star) (min on the lower side): it is an upper solution that rests."""
        worse = self._worse(self.y, y_star)
        own = worse[self._rows]
        return bool((self.sign * (self._values(worse) - own) <= 4e-16 * np.maximum(1.0, np.abs(own))).all())

    def _from_speed(self, dtau: float) -> Floats | None:
        """Where the states get if they go on as in the last step, slowing down as before; None if it is not proved.

        A state that goes farther than guessed is held farther out, and all are looked at again.
        """
        reach = _SPARE * dtau * self._expected
        for _ in range(_SWEEPS):
            there = self._flown(reach, dtau)
            moved = self._outwards(there)
            short = moved > reach
            if not short.any():
                return there
            reach[short] = _SPARE * moved[short]
        return None

    def _from_fastest(self, dtau: float) -> Floats:
        """How far the states get if each moves as far as the fastest one, or to the limit.

        The fastest never becomes faster if L <= 1. The proved reach is the guess of the next round, as long as it
        gains.
        """
        reach = self._outwards(self._limit)
        if self._contracts:
            fastest = float(np.max(self.sign * (self._values(self.y) - self.y[self._rows]), initial=0.0))
            reach = np.minimum(reach, dtau * self._flow.speed(fastest))
        there = self._flown(reach, dtau)
        for _ in range(_TIGHTER):
            moved = self._outwards(there)
            if (moved >= 0.99 * reach).all():
                break
            reach = np.minimum(reach, np.maximum(moved, 0.0))
            there = self._flown(reach, dtau)
        return there

    def _outwards(self, there: Floats) -> Floats:
        """(R,) how far ``there`` is beyond the states."""
        return self.sign * (there - self.y[self._rows])

    def _flown(self, reach: Floats, dtau: float) -> Floats:
        """Where the rows get in ``dtau`` with all states held ``reach`` (R,) outwards, at most (at least)."""
        here = self.y[self._rows]
        m = self._values(self._problem.with_sources(self._better(here + self.sign * reach, self._limit)))
        s = here - m
        there = m + np.where(s < 0, self._rising(s, dtau), self._falling(s, dtau))
        held = np.flatnonzero((there == here) & (self.sign * s < 0.0))  # or rounding would hold them inside for ever
        there[held] = np.nextafter(here[held], m[held])
        return there


def _dates(side: Side, y_star: Floats, tolerance: float, dtau: float, ramp: float) -> tuple[float, float]:
    """Two tau: the last at which this side proves a state outside its band, and the first after which none leaves it.

    "Leaves" means on this side only, and is proven too.
    """
    scale = np.maximum(1.0, np.abs(y_star))
    band, blur = tolerance * scale, min(0.01 * tolerance, _BLUR) * scale
    outside, inside = 0.0, math.inf
    first = min(side.first_step, dtau)
    for _ in range(_MOST_STEPS):
        beyond = side.sign * (side.y - y_star)
        if not (beyond <= band - blur).all():
            inside = math.inf
        elif math.isinf(inside) and side.stays(y_star):
            inside = side.tau
        if (beyond < -band - blur).any():
            outside = side.tau
        elif math.isfinite(inside):
            break
        side.step(min(dtau, max(first, ramp * side.tau)))
    return outside, inside
