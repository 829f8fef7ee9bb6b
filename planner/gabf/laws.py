"""The control laws of the paper, and a user's: a clock tau(t) and an autonomous flow in tau."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

import numpy as np

from planner.base.arrays import Floats, plain_numbers
from planner.base.errors import OptionError, choices
from planner.gabf.flows import Flow, LinearFlow, PowerFlow, UserFlow


@dataclass(frozen=True)
class _Positive:
    """Base of clocks and laws: each number is positive and finite, else :class:`OptionError`."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, int | float) and not (math.isfinite(value) and value > 0):
                raise OptionError(f"{name} must be a positive finite number, got {value}.")


@dataclass(frozen=True)
class UniformClock(_Positive):
    """tau = eta t: the clock of laws without a prescribed time; a larger ``eta`` is faster in t."""

    eta: float = 1.0

    def tau(self, t: float | Floats) -> Floats:
        return self.eta * np.asarray(t, dtype=np.float64)

    def time(self, tau: float | Floats) -> Floats:
        return np.asarray(tau, dtype=np.float64) / self.eta

    def log_gain(self, tau: float | Floats) -> Floats:
        """Return ln(d tau / dt)."""
        return np.full(np.shape(tau), math.log(self.eta))

    def log10_remaining(self, tau: float) -> float | None:
        return None


@dataclass(frozen=True)
class PrescribedClock(_Positive):
    """tau(t) = gamma t - 2 (1 + h) ln((T_p - t) / T_p), eq. (ts): maps [0, T_p) to [0, inf).

    Its rate is etabar(t) = gamma + 2 (1 + h) / (T_p - t) of eq. (ebar). Larger ``gamma`` and ``h`` reach a given tau
    earlier, with a larger gain. From tau of about gamma T + 74 (1 + h) on no double t < T_p is left, so tau and
    log10(T_p - t) are the record, and t rounds to T_p.
    """

    T: float = 4.0
    h: float = 1.0
    gamma: float = 1.0

    def tau(self, t: float | Floats) -> Floats:
        """Return tau at times t; +inf from T_p on. Each branch takes the share of T_p that rounds least."""
        t = np.asarray(t, dtype=np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            log_share = np.where(t < 0.5 * self.T, np.log1p(-t / self.T), np.log((self.T - t) / self.T))
            tau = self.gamma * t - 2.0 * (1.0 + self.h) * log_share
        return np.where(t >= self.T, np.inf, tau)

    def time(self, tau: float | Floats) -> Floats:
        return 0.0 - self.T * np.expm1(self._log_share(tau))

    def log_gain(self, tau: float | Floats) -> Floats:
        """Return ln etabar, eq. (ebar): finite at every finite tau; -inf from T_p on, where the gain is 0."""
        growing = math.log(2.0 * (1.0 + self.h) / self.T) - self._log_share(tau)
        return np.where(np.isinf(tau), -np.inf, np.logaddexp(math.log(self.gamma), growing))

    def log10_remaining(self, tau: float) -> float | None:
        """Return log10(T_p - t), finite for every finite tau."""
        return float((math.log(self.T) + self._log_share(tau)) / math.log(10.0))

    def _log_share(self, tau: float | Floats) -> Floats:
        """Return l = ln((T_p - t) / T_p), the root of gamma T (1 - e^l) - 2 (1 + h) l = tau.

        Newton from above, as 1 - e^l is less than -l and than 1: the left side is decreasing and concave, so the
        iterates fall monotonically to the root.
        """
        tau = np.asarray(tau, dtype=np.float64)
        endless = np.isinf(tau)
        reading = np.where(endless, 0.0, tau)
        slope, drift = 2.0 * (1.0 + self.h), self.gamma * self.T
        share = np.minimum(-reading / (drift + slope), (drift - reading) / slope)
        with np.errstate(under="ignore"):  # e^l underflows to 0
            for _ in range(100):
                miss = -drift * np.expm1(share) - slope * share - reading
                share = share + miss / (drift * np.exp(share) + slope)
                if np.all(np.abs(miss) <= 4e-16 * (1.0 + reading)):
                    break
        return np.where(endless, -np.inf, share)


_LARGEST_LOG_PACE = 500.0  # leaves ninety powers of ten for the settling times of large graphs


class Law(_Positive, ABC):
    """dx_i/dt = -(d tau/dt) phi(xhat_i), xhat_i = x_i - min_j f_i(x_j, w_ij), eq. (xhat).

    ``clock`` is tau(t), ``flow`` is phi and its flow, ``needs_overestimate`` is whether assumption (over) must hold,
    ``prescribed_time`` is T_p or None.
    """

    name: ClassVar[str]
    needs_overestimate: ClassVar[bool] = False

    @property
    @abstractmethod
    def clock(self) -> UniformClock | PrescribedClock: ...

    @property
    def flow(self) -> Flow:
        return LinearFlow()

    @property
    def prescribed_time(self) -> float | None:
        return self.clock.T if isinstance(self.clock, PrescribedClock) else None


class _TwoPowerLaw(Law):
    """A law with phi(s) = beta1 s^(p1/p2) + beta2 s^(m1/m2)."""

    beta1: float
    beta2: float
    p: tuple[int, int]
    m: tuple[int, int]

    @property
    def flow(self) -> PowerFlow:
        return PowerFlow(self.beta1, self.beta2, Fraction(*self.p), Fraction(*self.m))

    def __post_init__(self) -> None:
        """Refuse exponents on the wrong side of 1, and coefficients whose times overflow doubles."""
        super().__post_init__()
        for name, pair, order, example in (("p", self.p, -1, "p1 < p2, (3, 5)"), ("m", self.m, 1, "m1 > m2, (9, 7)")):
            odd = len(pair) == 2 and all(isinstance(k, int) and k > 0 and k % 2 for k in pair)
            if not odd or order * (pair[0] - pair[1]) <= 0:
                raise OptionError(f"{name} must be two positive odd integers with {example} for example, got {pair}.")
        if abs(self.flow.log_pace) > _LARGEST_LOG_PACE:
            betas, tau = f"beta1 = {self.beta1:g} and beta2 = {self.beta2:g}", f"tau = e^{self.flow.log_pace:.0f}"
            raise OptionError(f"{betas} make the law act within {tau}, beyond doubles: bring both closer to 1.")


@dataclass(frozen=True)
class Nominal(Law):
    """dx_i/dt = -eta xhat_i, eq. (protocol): exponential convergence from strict overestimates.

    A larger ``eta`` is faster, with a larger input. For a deadline use :class:`PrescribedTime`.
    """

    eta: float = 1.0
    name: ClassVar[str] = "nominal"

    @property
    def clock(self) -> UniformClock:
        return UniformClock(self.eta)


@dataclass(frozen=True)
class PrescribedTime(Law):
    """dx_i/dt = -etabar(t) xhat_i, eqs. (prespecified), (ebar): x = x* at T_p from any overestimate.

    Assumption (over): every start must lie strictly above the optimum; others are refused. The state settles at ``T``
    exactly, not before; larger ``h`` and ``gamma`` bring it close to x* earlier and need a larger input. From T_p on
    the gain is 0: a change of weights before T_p heals, after a later one solve again, which restarts the clock.
    """

    T: float = 4.0
    h: float = 1.0
    gamma: float = 1.0
    needs_overestimate: ClassVar[bool] = True
    name: ClassVar[str] = "prescribed-time"

    @property
    def clock(self) -> PrescribedClock:
        return PrescribedClock(self.T, self.h, self.gamma)


@dataclass(frozen=True)
class FixedTime(_TwoPowerLaw):
    """dx_i/dt = -eta (beta1 xhat_i^(p1/p2) + beta2 xhat_i^(m1/m2)), eq. (singularity): a finite time.

    It settles from any start. ``p`` = (p1, p2) and ``m`` = (m1, m2) are odd and positive with p1 < p2 and m1 > m2. A
    larger ``eta`` or ``beta1`` speeds up the end, ``beta2`` the approach from far; exponents nearer to 1 mean less
    input far away and more near x*. For a deadline that does not depend on the graph use :class:`SingularityFree`.
    """

    eta: float = 15.0
    beta1: float = 1.0
    beta2: float = 1.0
    p: tuple[int, int] = (3, 5)
    m: tuple[int, int] = (9, 7)
    name: ClassVar[str] = "fixed-time"

    @property
    def clock(self) -> UniformClock:
        return UniformClock(self.eta)


@dataclass(frozen=True)
class SingularityFree(_TwoPowerLaw):
    """dx_i/dt = -etabar(t) (beta1 xhat_i^(p1/p2) + beta2 xhat_i^(m1/m2)), eq. (fully): settles before T_p.

    It settles from any start. Parameters as in :class:`FixedTime` and :class:`PrescribedTime`; the defaults are those
    of section (comparison). A larger ``T`` is slower and gentler, larger ``h`` and ``gamma`` settle earlier with more
    input. ``eta`` has no effect: its branch of eq. (fully) acts only where xhat_i = 0, and there the right side is 0.
    From T_p on the law is inert: solve again after a change, from ``x0=result.x``.
    """

    T: float = 4.0
    h: float = 1.0
    gamma: float = 10.0
    eta: float = 15.0
    beta1: float = 1.0
    beta2: float = 1.0
    p: tuple[int, int] = (3, 5)
    m: tuple[int, int] = (9, 7)
    name: ClassVar[str] = "singularity-free"

    @property
    def clock(self) -> PrescribedClock:
        return PrescribedClock(self.T, self.h, self.gamma)


@dataclass(frozen=True)
class UserLaw(Law):
    """dx_i/dt = -(d tau/dt) rate(xhat_i): a law of your own, on a ``clock`` of the laws here.

    ``rate`` is phi: from an array of errors xhat_i to an array of as many speeds, each of the sign of its error, and
    rate(0) = 0. ``UniformClock(eta)`` is time itself for eta = 1, ``PrescribedClock(T)`` maps [0, T) to all of tau. The
    field is x* to the last bit, or the run ends as ``BUDGET_SPENT``. phi is known by its values alone, so nothing is
    proved about the settling time (its bracket is (0, inf)), and no certificate is proven. Raises AssumptionError where
    ``rate`` breaks this at errors from 1e-9 to 1e9, or in a run; TypeError unless it is a function.

    >>> network = gabf.Network.from_arcs([1, 2, 2], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], n_nodes=3)
    >>> result = gabf.solve(network, gabf.UserLaw(np.tanh, gabf.PrescribedClock(T=4.0)))
    >>> result.x, bool(result.settling_time < 4.0)
    (array([0., 1., 2.]), True)
    """

    rate: Callable[[Floats], Floats]
    clock: UniformClock | PrescribedClock = UniformClock()  # pyright: ignore[reportIncompatibleMethodOverride]
    name: ClassVar[str] = "user"

    def __post_init__(self) -> None:
        if not callable(self.rate) or not isinstance(self.clock, UniformClock | PrescribedClock):
            raise TypeError("a UserLaw needs a function and a clock: UserLaw(np.tanh, PrescribedClock(T=4.0)).")
        sizes = np.geomspace(1e-9, 1e9, 361)
        self.flow.rate(np.concatenate([-sizes, [0.0], sizes]))

    @property
    def flow(self) -> UserFlow:
        return UserFlow(self.rate)


def control_input(law: Law, tau: float | Floats, xhat: Floats) -> Floats:
    """Return u_i = dx_i/dt at clock reading ``tau`` for disequilibria ``xhat``, eq. (xhat), any shape.

    0 where xhat_i = 0, at any gain, and from T_p on.
    """
    rate, gain = law.flow.rate(plain_numbers("xhat", xhat)), law.clock.log_gain(tau)
    with np.errstate(divide="ignore", over="ignore"):
        size = np.exp(gain + np.log(np.abs(rate)))
    return np.copysign(size, -rate)


def law_from_name(name: str, T: float = 4.0) -> Law:
    """Return the law called ``name`` with the paper's parameters; laws without T_p ignore ``T`` (s).

    Raises :class:`OptionError` for an unknown name.
    """
    laws = {law.name: law for law in (Nominal(), PrescribedTime(T=T), FixedTime(), SingularityFree(T=T))}
    if name not in laws:
        raise OptionError(f"law '{name}' not found; laws are {choices(laws)}.")
    return laws[name]


def resolve_law(law: Law | str | None) -> Law:
    """Return the law itself, the one of that name, or the default one; TypeError for anything else."""
    if law is None or isinstance(law, str):
        return SingularityFree() if law is None else law_from_name(law)
    if not isinstance(law, Law):
        raise TypeError(f"law must be a name or a law, such as gabf.Nominal(), got {law!r}.")
    return law
