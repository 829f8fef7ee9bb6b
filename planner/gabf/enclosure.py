"""Proved bounds on the settling tau: upper and lower solutions that enclose every run."""

import math

import numpy as np

from planner.base.arrays import Floats
from planner.gabf.flows import Flow
from planner.gabf.problem import Premises, Problem, ceiling
from planner.gabf.splitting import make_parents

WIDTH = 0.5  # of a bracket, as a share of its end; it takes three times a run's work, 0.1 takes ten times
_STEPS, _ROUNDS = 64, 6
_MOST_STEPS = (
    40_000  # of one solution in a round, and of all rounds before the last: a rise over X at cost c takes X / c
)
_MOST_WORK = 10_000_000  # rows times hops, about 3 s: each step evaluates every row and advances by one hop
_BLUR = 64 * np.finfo(float).eps  # rounding of a state, times max(1, |x*|): inside and outside a band are undecided
_ROUNDING = 1e-9
_RAMP = 16.0  # share of early steps over that of later ones: far states fall as a power of tau, steeply at first
_SPARE = 1.05  # factor on the expected reach of parents: a smaller one is tighter, and fails more often
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
    """Return the earliest and latest tau at which a run from ``y0`` can settle.

    From then on all errors stay within their bands. ``tolerance`` defines the band as in :func:`planner.gabf.solve`;
    ``guess`` is an expected answer that affects the work only. Steps shrink until the bracket is ``width`` of its end,
    or the work is spent: half the width takes twice the work. The latest is +inf where the work does not suffice for
    the lower solution. The bracket is (0, inf) for a user's law, and for too many rows times hops. The result is proved
    up to rounding, for every increasing kernel.
    """
    if flow.compiled is None or problem.n_rows * problem.most_hops > _MOST_WORK:
        return 0.0, math.inf
    limits = [limit_states(problem, y0, y_star, upper) for upper in (True, False)]
    earliest, latest = 0.0, math.inf
    whole = guess or flow.pace
    dtau, spent = whole / max(_STEPS, problem.most_hops), 0  # each step finds one hop more
    for _ in range(_ROUNDS):
        sides = [BoundingSolution(problem, flow, y0, bounds, upper, limits[not upper]) for upper in (True, False)]
        ramp = math.expm1(min(_RAMP * dtau / whole * flow.far_power, 30.0))
        dates = [_settling_taus(side, y_star, tolerance, dtau, ramp) for side in sides]
        earliest = max(earliest, *(outside * (1.0 - _ROUNDING) for outside, _ in dates))
        latest = min(latest, max(inside * (1.0 + _ROUNDING) for _, inside in dates))
        spent += max(side.steps for side in sides)
        if math.isinf(latest) or latest - earliest <= width * latest or spent >= _MOST_STEPS:
            break
        dtau *= min(0.5, max(0.125, 0.8 * width * latest / (latest - earliest)))
    return earliest, latest


def limit_states(problem: Problem, y0: Floats, y_star: Floats, upper: bool) -> Floats:
    """Return states z (R + S,) with m(z) <= z, y0 <= z that no run exceeds (>=: falls below).

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


class BoundingSolution:
    """An upper (or lower) solution: states that no run from ``y0`` exceeds (falls below).

    ``y`` (R + S,) are the states at ``tau``. The law is cooperative: the right side increases with each parent's state,
    so runs keep their order, and parents that are too high (low) over a step give states that are too high (low).
    Parents that fall count with their value at the start of the step; parents that rise with a guess ``reach``, which
    the step proves: if no state goes farther with parents there, none does at all. First order in the step. No run goes
    beyond the states ``beyond`` (R + S,), see :func:`limit_states`.
    """

    def __init__(self, problem: Problem, flow: Flow, y0: Floats, bounds: Premises, upper: bool, beyond: Floats):
        self.tau, self.y, self.sign, self.steps = 0.0, y0, 1.0 if upper else -1.0, 0
        self._problem, self._rows, self._values = problem, slice(0, problem.n_rows), make_parents(problem, flow)
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
        """Advance by ``dtau``."""
        there = self._extrapolate(dtau)
        there = self._better(self._step_by_fastest(dtau) if there is None else there, self._limit)
        speed = np.maximum(self._outward(there), 0.0) / dtau
        slowing = np.divide(speed, self._speed, out=np.ones_like(speed), where=speed < self._speed)
        self._speed, self._expected = speed, speed * slowing
        self.tau, self.y, self.steps = self.tau + dtau, self._problem.with_sources(there), self.steps + 1

    def is_stationary(self, y_star: Floats) -> bool:
        """Whether no state ever leaves max(y, y_star) (min for a lower solution)."""
        worse = self._worse(self.y, y_star)
        own = worse[self._rows]
        return bool((self.sign * (self._values(worse) - own) <= 4e-16 * np.maximum(1.0, np.abs(own))).all())

    def _extrapolate(self, dtau: float) -> Floats | None:
        """Return the states if all move on as in the last step, slowing down likewise; None without a proof.

        A state that goes farther than its guess gets a larger guess, and all are evaluated again.
        """
        reach = _SPARE * dtau * self._expected
        for _ in range(_SWEEPS):
            there = self._flow_rows(reach, dtau)
            moved = self._outward(there)
            short = moved > reach
            if not short.any():
                return there
            reach[short] = _SPARE * moved[short]
        return None

    def _step_by_fastest(self, dtau: float) -> Floats:
        """Return the states if each may move as far as the fastest one, or to the limit.

        The fastest never becomes faster if L <= 1. The proved reach is the guess of the next round while it gains.
        """
        reach = self._outward(self._limit)
        if self._contracts:
            fastest = float(np.max(self.sign * (self._values(self.y) - self.y[self._rows]), initial=0.0))
            reach = np.minimum(reach, dtau * self._flow.speed(fastest))
        there = self._flow_rows(reach, dtau)
        for _ in range(_TIGHTER):
            moved = self._outward(there)
            if (moved >= 0.99 * reach).all():
                break
            reach = np.minimum(reach, np.maximum(moved, 0.0))
            there = self._flow_rows(reach, dtau)
        return there

    def _outward(self, there: Floats) -> Floats:
        """Return (R,) the distance of ``there`` beyond the states."""
        return self.sign * (there - self.y[self._rows])

    def _flow_rows(self, reach: Floats, dtau: float) -> Floats:
        """Return the rows after ``dtau`` at most (at least), with all states moved outwards by ``reach`` (R,)."""
        here = self.y[self._rows]
        m = self._values(self._problem.with_sources(self._better(here + self.sign * reach, self._limit)))
        s = here - m
        there = m + np.where(s < 0, self._rising(s, dtau), self._falling(s, dtau))
        stuck = np.flatnonzero((there == here) & (self.sign * s < 0.0))  # by rounding
        there[stuck] = np.nextafter(here[stuck], m[stuck])
        return there


def _settling_taus(
    side: BoundingSolution, y_star: Floats, tolerance: float, dtau: float, ramp: float
) -> tuple[float, float]:
    """Return the last tau with a state outside its band, and the first after which none leaves it.

    Both are proved, for this solution's side of the band.
    """
    scale = np.maximum(1.0, np.abs(y_star))
    band, blur = tolerance * scale, min(0.01 * tolerance, _BLUR) * scale
    outside, inside = 0.0, math.inf
    first = min(side.first_step, dtau)
    for _ in range(_MOST_STEPS):
        beyond = side.sign * (side.y - y_star)
        if not (beyond <= band - blur).all():
            inside = math.inf
        elif math.isinf(inside) and side.is_stationary(y_star):
            inside = side.tau
        if (beyond < -band - blur).any():
            outside = side.tau
        elif math.isfinite(inside):
            break
        side.step(min(dtau, max(first, ramp * side.tau)))
    return outside, inside
