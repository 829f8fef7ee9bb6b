"""Kernels f_i(a, b) of eq. (protocol): the cost-to-go of a node by an arc of cost b to a node at a."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, combine_costs
from planner.base.errors import AssumptionError, OptionError

UserFunction = Callable[[Ints, Floats, Floats], Floats]

_SAMPLES, _MOST_SAMPLES = 33, 400  # values of a at which a user's kernel is probed, first and at most
_STEADY = 0.01  # of a slope: smaller changes between neighbouring intervals are ignored


@dataclass(frozen=True, eq=False)
class AffineArcs:
    """f_ij(a) = slope_ij a + offset_ij over arcs; ``slope`` is None if all are 1 (the additive family)."""

    slope: Floats | None
    offset: Floats
    sampled: bool = False

    def __call__(self, a: Floats) -> Floats:
        return a + self.offset if self.slope is None else self.slope * a + self.offset

    def take(self, arcs: Ints | Bools) -> AffineArcs:
        return AffineArcs(None if self.slope is None else self.slope[arcs], self.offset[arcs])

    def extremes(self, lower: float, upper: float) -> tuple[Floats, Floats, Floats]:
        """Return on [lower, upper] the least f_ij(a) - a, the least and the largest slope, (arcs,) each.

        The first is zeta of eq. (progressive).
        """
        if self.slope is None:
            return self.offset, np.ones_like(self.offset), np.ones_like(self.offset)
        gains = (self.slope - 1.0) * np.array([[lower], [upper]]) + self.offset
        return gains.min(axis=0), self.slope, self.slope


@dataclass(frozen=True, eq=False)
class FunctionArcs:
    """A user's f(i, a, b) over arcs; extremes are those of samples, denser where slopes change."""

    function: UserFunction
    tails: Ints
    weight: Floats
    sampled: bool = True

    def __call__(self, a: Floats) -> Floats:
        return call_on_arrays("f", self.function, self.tails, a, self.weight)

    def take(self, arcs: Ints | Bools) -> FunctionArcs:
        return FunctionArcs(self.function, self.tails[arcs], self.weight[arcs])

    def extremes(self, lower: float, upper: float) -> tuple[Floats, Floats, Floats]:
        grid = np.unique(np.linspace(lower, upper, _SAMPLES))
        values, slopes = self._at(grid), np.ones((1, self.weight.size))
        while len(grid) > 1:
            gaps = np.diff(grid)
            slopes = np.diff(values, axis=0) / gaps[:, None]
            bent = _is_bent(slopes) & (gaps > 1e-9 * (upper - lower))
            if not bent.any() or len(grid) + np.count_nonzero(bent) > _MOST_SAMPLES:
                break
            middles = grid[:-1][bent] + 0.5 * gaps[bent]
            grid, values = np.concatenate([grid, middles]), np.concatenate([values, self._at(middles)])
            order = np.argsort(grid)
            grid, values = grid[order], values[order]
        return (values - grid[:, None]).min(axis=0), slopes.min(axis=0), slopes.max(axis=0)

    def _at(self, grid: Floats) -> Floats:
        return np.stack([self(np.full(self.weight.shape, a)) for a in grid])


def _is_bent(slopes: Floats) -> Bools:
    """Return which intervals (k, arcs) have another slope than a neighbouring one, on any arc."""
    change = np.abs(np.diff(slopes, axis=0)) > _STEADY * np.maximum(np.abs(slopes[:-1]), np.abs(slopes[1:]))
    ends = change.any(axis=1)
    return np.concatenate([ends, [False]]) | np.concatenate([[False], ends])


ArcMap: TypeAlias = AffineArcs | FunctionArcs


def call_on_arrays(name: str, function: Callable[..., Any], *arrays: Any) -> Floats:
    """Return a user's ``function`` of ``arrays`` of one shape; AssumptionError for another shape."""
    shape, remedy = arrays[-1].shape, "it gets arrays, so use np.maximum(a, b) for max(a, b), np.where for if."
    try:
        values = np.asarray(function(*arrays), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise AssumptionError(f"{name} failed on arrays of shape {shape} ({error}): {remedy}") from error
    if values.shape != shape:
        raise AssumptionError(f"{name} must return an array of shape {shape}, got shape {values.shape}: {remedy}")
    return values


@dataclass(frozen=True)
class Domain:
    """The set R_1 of eq. (protocol), the domain of a kernel: [lower, upper], or [lower, upper) if open."""

    lower: float = -math.inf
    upper: float = math.inf
    open_above: bool = False

    def contains(self, a: Floats) -> Bools:
        return (a >= self.lower) & ((a < self.upper) if self.open_above else (a <= self.upper))

    def __str__(self) -> str:
        return f"[{self.lower:g}, {self.upper:g}{')' if self.open_above else ']'}"


class Kernel(ABC):
    """A family f_i(a, b): its domain, and the function that it becomes on each arc of a network.

    zeta of eq. (progressive), L of eq. (Lipschitz) and monotonicity follow from the bound arcs on the interval of a
    run's states (:func:`planner.gabf.problem.check_premises`), since several kernels have none on all of R.
    """

    domain: Domain = Domain()

    @abstractmethod
    def bind(self, net: Any) -> ArcMap:
        """Return the kernel on the arcs of a :class:`planner.gabf.Network`."""


@dataclass(frozen=True)
class Additive(Kernel):
    """f_i(a, b) = a + b: the shortest path, where GABF is biased min-consensus (DBMC).

    zeta = min b, L = 1.
    """

    def bind(self, net: Any) -> AffineArcs:
        return AffineArcs(None, net.weight)


@dataclass(frozen=True)
class TradeOff(Kernel):
    """f_i(x_j, w_ij) = x_j + (1 - beta) omega(j) + beta w_ij, eq. (finew).

    A larger ``beta`` in [0, 1] favours short paths, a smaller one paths through nodes of small ``node_cost`` omega.
    zeta = min of (1 - beta) omega(j) + beta w_ij, L = 1. :class:`EdgeIntegral` charges omega inside the edges instead.
    """

    beta: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 <= self.beta <= 1.0:
            raise OptionError(f"beta must be from 0 (manipulability only) to 1 (distance only), got {self.beta:g}.")

    def bind(self, net: Any) -> AffineArcs:
        return AffineArcs(None, combine_costs(self.beta, _cost(net, self, "node_cost")[net.indices], net.weight))


@dataclass(frozen=True)
class EdgeIntegral(TradeOff):
    """f_i(x_j, w_ij) = x_j + (1 - beta) c_ij + beta w_ij, c_ij the integral of omega along the edge.

    As :class:`TradeOff`, but ``arc_cost`` c_ij makes the result independent of the density of nodes. A larger ``beta``
    favours short paths. zeta = min of (1 - beta) c_ij + beta w_ij, L = 1.
    """

    def bind(self, net: Any) -> AffineArcs:
        return AffineArcs(None, combine_costs(self.beta, _cost(net, self, "arc_cost"), net.weight))


@dataclass(frozen=True)
class Multiplicative(Kernel):
    """f_i(x_j, w_ij) = 1 - (1 - x_j) wbar_ij, eq. (wb), on a < 1, with wbar_ij in (0, 1).

    With a number ``K`` the weights are lengths and wbar_ij = 1 - w_ij / K: a larger K brings the optimal path closer to
    the shortest one. With ``K`` None the weights are wbar_ij itself, as the learning rule moves it. zeta = min (1 -
    a)(1 - wbar_ij), which vanishes as a reaches 1; L = max wbar_ij < 1. AssumptionError names an arc whose wbar_ij is
    not in (0, 1).
    """

    K: float | None = None
    domain = Domain(upper=1.0, open_above=True)

    def __post_init__(self) -> None:
        if self.K is not None and not (math.isfinite(self.K) and self.K > 0):
            raise OptionError(f"K must be a positive number, got {self.K}: choose it above the longest weight.")

    def bind(self, net: Any) -> AffineArcs:
        wbar = net.weight if self.K is None else 1.0 - net.weight / self.K
        bad = np.flatnonzero(~((wbar > 0) & (wbar < 1)))
        if bad.size:
            arc = f"arc ({net.tails[bad[0]]}, {net.indices[bad[0]]}) has {wbar[bad[0]]:g}"
            remedy = "clip the learned weights, or choose K above the longest weight."
            raise AssumptionError(f"wbar must be between 0 and 1, eq. (wb), but {arc}: {remedy}")
        return AffineArcs(wbar, 1.0 - wbar)


@dataclass(frozen=True)
class NodeDependent(Kernel):
    """The kernel of the nine-node example, fig. (example1): 2a + |b| at even nodes, a + 2|b| at odd ones.

    The paper numbers from 1, so index i is node i + 1. Domain a >= 1; zeta = min of 1 + |b| and 2|b|, L = 2.
    """

    domain = Domain(lower=1.0)

    def bind(self, net: Any) -> AffineArcs:
        even, length = (net.tails + 1) % 2 == 0, np.abs(net.weight)
        return AffineArcs(np.where(even, 2.0, 1.0), np.where(even, length, 2.0 * length))


@dataclass(frozen=True)
class UserKernel(Kernel):
    """Any f(i, a, b): arrays over arcs (node, x_j, weight) to one array; a in [``lower``, ``upper``].

    It is probed on a grid over the interval of the run's states, and certificates say so: sampling can refuse a kernel
    that is not increasing or not progressive there; it cannot prove one.

    >>> costs = gabf.UserKernel(lambda i, a, b: np.maximum(a, 2.0) + b)
    >>> net = gabf.Network.from_arcs([1, 2], [0, 1], [1.0, 1.0], [0], 3, source_values=[2.0], kernel=costs)
    >>> gabf.solve(net).x
    array([2., 3., 4.])
    """

    f: UserFunction
    lower: float = -math.inf
    upper: float = math.inf

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise OptionError(f"lower must be below upper, got [{self.lower}, {self.upper}].")
        object.__setattr__(self, "domain", Domain(self.lower, self.upper))

    def bind(self, net: Any) -> FunctionArcs:
        return FunctionArcs(self.f, net.tails, net.weight)


def _cost(net: Any, kernel: Kernel, name: str) -> Floats:
    if (cost := getattr(net, name)) is None:
        raise AssumptionError(f"the {type(kernel).__name__} kernel needs {name}: give Network(..., {name}=...).")
    return cost
