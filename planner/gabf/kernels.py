"""Kernels f_i(a, b) of eq. (protocol): what an arc adds to the cost-to-go of its head, for all arcs of a network."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, traded_off
from planner.base.errors import AssumptionError, OptionError

UserFunction = Callable[[Ints, Floats, Floats], Floats]

SAMPLES = 33
"""Values of a at which a user's kernel is probed first; more follow where its slope changes."""

_MOST_SAMPLES = 400
_STEADY = 0.01  # of a slope: by less, neighbouring pieces count as one


class ArcMap(Protocol):
    """What solvers and checks ask of the bound kernel; arrays run over the arcs."""

    @property
    def sampled(self) -> bool: ...
    def __call__(self, a: Floats) -> Floats: ...
    def take(self, arcs: Ints | Bools) -> ArcMap: ...
    def progress(self, lower: float, upper: float) -> Floats: ...
    def slopes(self, lower: float, upper: float) -> tuple[Floats, Floats]: ...


@dataclass(frozen=True, eq=False)
class AffineArcs:
    """f_ij(a) = slope_ij a + offset_ij; ``slope`` is None where every slope is 1 (the additive family)."""

    slope: Floats | None
    offset: Floats
    sampled: bool = False

    def __call__(self, a: Floats) -> Floats:
        return a + self.offset if self.slope is None else self.slope * a + self.offset

    def take(self, arcs: Ints | Bools) -> AffineArcs:
        return AffineArcs(None if self.slope is None else self.slope[arcs], self.offset[arcs])

    def progress(self, lower: float, upper: float) -> Floats:
        """Smallest f_ij(a) - a over a in [lower, upper] per arc: zeta of eq. (progressive).

        Exact, as an affine map has it at one of the two ends.
        """
        if self.slope is None:
            return self.offset
        gains = (self.slope - 1.0) * np.array([[lower], [upper]]) + self.offset
        return gains.min(axis=0)

    def slopes(self, lower: float, upper: float) -> tuple[Floats, Floats]:
        """Smallest and largest slope of each f_ij on [lower, upper]."""
        slope = np.ones_like(self.offset) if self.slope is None else self.slope
        return slope, slope


@dataclass(frozen=True, eq=False)
class FunctionArcs:
    """A user's f(i, a, b), vectorised over arcs; its properties are sampled, not proved."""

    function: UserFunction
    tails: Ints
    weight: Floats
    sampled: bool = True

    def __call__(self, a: Floats) -> Floats:
        return call_on_arrays("f", self.function, self.tails, a, self.weight)

    def take(self, arcs: Ints | Bools) -> FunctionArcs:
        return FunctionArcs(self.function, self.tails[arcs], self.weight[arcs])

    def progress(self, lower: float, upper: float) -> Floats:
        """Smallest f_ij(a) - a over the sampled a in [lower, upper], arc by arc."""
        grid, values = self._table(lower, upper)
        return (values - grid[:, None]).min(axis=0)

    def slopes(self, lower: float, upper: float) -> tuple[Floats, Floats]:
        """Smallest and largest difference quotient of each f_ij between neighbouring samples."""
        grid, values = self._table(lower, upper)
        if len(grid) == 1:
            return np.ones_like(self.weight), np.ones_like(self.weight)
        quotients = np.diff(values, axis=0) / np.diff(grid)[:, None]
        return quotients.min(axis=0), quotients.max(axis=0)

    def _table(self, lower: float, upper: float) -> tuple[Floats, Floats]:
        """Samples (k,), denser where slopes change, and every arc's value at each (k, arcs)."""
        grid = np.unique(np.linspace(lower, upper, SAMPLES))
        values = self._at(grid)
        finest = 1e-9 * (upper - lower)
        while len(grid) > 1:
            gaps = np.diff(grid)
            bent = _bent(np.diff(values, axis=0) / gaps[:, None]) & (gaps > finest)
            if not bent.any() or len(grid) + np.count_nonzero(bent) > _MOST_SAMPLES:
                break
            middles = grid[:-1][bent] + 0.5 * gaps[bent]
            grid = np.concatenate([grid, middles])
            values = np.concatenate([values, self._at(middles)])
            order = np.argsort(grid)
            grid, values = grid[order], values[order]
        return grid, values

    def _at(self, grid: Floats) -> Floats:
        return np.stack([self(np.full(self.weight.shape, a)) for a in grid])


def _bent(slopes: Floats) -> Bools:
    """Which pieces (k, arcs) have a slope unlike that of a neighbouring piece, on any arc."""
    change = np.abs(np.diff(slopes, axis=0)) > _STEADY * np.maximum(np.abs(slopes[:-1]), np.abs(slopes[1:]))
    ends = change.any(axis=1)
    return np.concatenate([ends, [False]]) | np.concatenate([[False], ends])


def call_on_arrays(name: str, function: Callable[..., Any], *arrays: Any) -> Floats:
    """A user's ``function`` of ``arrays`` of one shape, as an array of that shape; AssumptionError where it is none."""
    shape, remedy = arrays[-1].shape, "it gets arrays, so use np.maximum(a, b) for max(a, b), np.where for if."
    try:
        values = np.asarray(function(*arrays), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise AssumptionError(f"{name} failed on arrays of shape {shape} ({error}): {remedy}") from error
    if values.shape != shape:
        raise AssumptionError(f"{name} must return an array of shape {shape}, got shape {values.shape}: {remedy}")
    return values


class ArcData(Protocol):
    """What kernels read of a network: its arcs i -> j, and what they and the nodes they lead to cost."""

    @property
    def tails(self) -> Ints: ...
    @property
    def indices(self) -> Ints: ...
    @property
    def weight(self) -> Floats: ...
    @property
    def node_cost(self) -> Floats | None: ...
    @property
    def arc_cost(self) -> Floats | None: ...


@dataclass(frozen=True)
class Domain:
    """The set R_1 of eq. (protocol) on which a kernel is defined: [lower, upper], or [lower, upper) if open."""

    lower: float = -math.inf
    upper: float = math.inf
    open_above: bool = False

    def holds(self, a: Floats) -> Bools:
        below = a < self.upper if self.open_above else a <= self.upper
        return (a >= self.lower) & below

    def __str__(self) -> str:
        return f"[{self.lower:g}, {self.upper:g}{')' if self.open_above else ']'}"


class Kernel(ABC):
    """A family f_i(a, b): where it is defined, and the function it becomes on each arc of a network.

    zeta of eq. (progressive), L of eq. (Lipschitz) and monotonicity follow from the bound arcs on the
    interval that a run stays in (:func:`planner.gabf.problem.check_kernel`), since several kernels have
    none on all of R.
    """

    @property
    def domain(self) -> Domain:
        return Domain()

    @abstractmethod
    def bind(self, net: ArcData) -> ArcMap: ...


@dataclass(frozen=True)
class Additive(Kernel):
    """f_i(a, b) = a + b: the shortest path, where GABF is the biased min-consensus (DBMC). zeta = min b, L = 1."""

    def bind(self, net: ArcData) -> AffineArcs:
        return AffineArcs(None, net.weight)


@dataclass(frozen=True)
class TradeOff(Kernel):
    """f_i(x_j, w_ij) = x_j + (1 - beta) omega(j) + beta w_ij, eq. (finew).

    A larger ``beta`` in [0, 1] favours short paths, a smaller one paths through nodes of small
    ``node_cost`` omega. zeta = min of (1 - beta) omega(j) + beta w_ij, L = 1.
    To charge omega inside the edges rather than at nodes, use :class:`EdgeIntegral`.
    """

    beta: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 <= self.beta <= 1.0:
            raise OptionError(f"beta must be from 0 (manipulability only) to 1 (distance only), got {self.beta:g}.")

    def bind(self, net: ArcData) -> AffineArcs:
        omega = _required(net.node_cost, "TradeOff", "node_cost")
        return AffineArcs(None, traded_off(self.beta, omega[net.indices], net.weight))


@dataclass(frozen=True)
class EdgeIntegral(TradeOff):
    """f_i(x_j, w_ij) = x_j + (1 - beta) c_ij + beta w_ij, with c_ij the manipulability cost integrated along the edge.

    As :class:`TradeOff`, but ``arc_cost`` c_ij makes the result independent of how densely nodes are sampled.
    A larger ``beta`` favours short paths. zeta = min of (1 - beta) c_ij + beta w_ij, L = 1.
    """

    def bind(self, net: ArcData) -> AffineArcs:
        cost = _required(net.arc_cost, "EdgeIntegral", "arc_cost")
        return AffineArcs(None, traded_off(self.beta, cost, net.weight))


@dataclass(frozen=True)
class Multiplicative(Kernel):
    """f_i(x_j, w_ij) = 1 - (1 - x_j) wbar_ij, eq. (wb), on a < 1, with wbar_ij in (0, 1).

    With a number ``K`` the weights are lengths and wbar_ij = 1 - w_ij / K: a larger K brings the optimal path
    closer to the shortest one. With ``K`` None the weights are wbar_ij itself, as the learning rule moves it.
    zeta = min (1 - a)(1 - wbar_ij), which vanishes as a reaches 1; L = max wbar_ij < 1.
    """

    K: float | None = None

    def __post_init__(self) -> None:
        if self.K is not None and not (math.isfinite(self.K) and self.K > 0):
            raise OptionError(f"K must be a positive number, not {self.K}; choose it above the longest weight")

    @property
    def domain(self) -> Domain:
        return Domain(upper=1.0, open_above=True)

    def bind(self, net: ArcData) -> AffineArcs:
        """The kernel on the arcs of ``net``; AssumptionError names an arc whose weight it does not allow."""
        wbar = net.weight if self.K is None else 1.0 - net.weight / self.K
        bad = np.flatnonzero(~((wbar > 0) & (wbar < 1)))
        if bad.size:
            i, j = net.tails[bad[0]], net.indices[bad[0]]
            raise AssumptionError(
                f"eq. (wb) needs 0 < wbar < 1, but arc ({i}, {j}) has {wbar[bad[0]]:g}: "
                "clip the learned weights, or choose K above the longest weight"
            )
        return AffineArcs(wbar, 1.0 - wbar)


@dataclass(frozen=True)
class NodeDependent(Kernel):
    """The kernel of the nine-node example, fig. (example1): 2a + |b| at nodes of even number, a + 2|b| at odd ones.

    The paper numbers from 1, so array index i is node i + 1. Domain a >= 1; zeta = min of 1 + |b| and 2|b|, L
    = 2.
    """

    @property
    def domain(self) -> Domain:
        return Domain(lower=1.0)

    def bind(self, net: ArcData) -> AffineArcs:
        even, length = (net.tails + 1) % 2 == 0, np.abs(net.weight)
        return AffineArcs(np.where(even, 2.0, 1.0), np.where(even, length, 2.0 * length))


@dataclass(frozen=True)
class UserKernel(Kernel):
    """Any f(i, a, b), vectorised: three arrays over arcs (reading node, x_j, weight) to one.

    It is probed on a grid over the interval the run stays in, and certificates say so: sampling can refuse a
    kernel that is not increasing or not progressive there, it cannot prove that one is.
    ``lower`` and ``upper`` bound its domain.
    """

    f: UserFunction
    lower: float = -math.inf
    upper: float = math.inf

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise OptionError(f"a kernel's domain [{self.lower}, {self.upper}] is empty: give lower below upper.")

    @property
    def domain(self) -> Domain:
        return Domain(self.lower, self.upper)

    def bind(self, net: ArcData) -> FunctionArcs:
        return FunctionArcs(self.f, net.tails, net.weight)


def _required(array: Floats | None, kernel: str, name: str) -> Floats:
    if array is None:
        raise AssumptionError(f"the {kernel} kernel reads {name}: give Network(..., {name}=...)")
    return array
