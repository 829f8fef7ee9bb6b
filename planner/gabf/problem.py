"""The part of a network that the dynamics changes, and the checked premises of the theorems."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Bools, Floats, Ints, plain_numbers
from planner.base.errors import AssumptionError
from planner.gabf.kernels import ArcMap
from planner.gabf.network import Network
from planner.native.compiled import hops_to_source

ROUNDED = 64 * float(np.finfo(float).eps)  # share of the largest state: a smaller xhat may be rounding


class State(NamedTuple):
    """States ``y`` (R + S,) at ``tau``, xhat (R,) = y - m of eq. (xhat) and its largest size ``residual``.

    ``lowest`` and ``highest`` are the range of the rows' y; ``rejected`` counts the steps rejected so far.
    """

    y: Floats
    xhat: Floats
    residual: float
    lowest: float
    highest: float
    tau: float = 0.0
    rejected: int = 0

    @property
    def largest(self) -> float:
        """The largest |y| of the rows."""
        return max(abs(self.lowest), abs(self.highest))

    @property
    def resolution(self) -> float:
        """The |xhat| that may be rounding: steps leave rounded states, the start is exact."""
        return ROUNDED * self.largest if self.tau > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class Problem:
    """The nodes that reach a source: the R non-source ones (rows) first, then the S sources.

    Row i reads the states at ``heads[starts[i]:starts[i + 1]]`` through ``arcs``, at least one. ``nodes`` (R + S,) are
    indices in the network, ``anchors`` (S,) the values of the sources; ``heads`` are positions in ``nodes``, ``arcs``
    the arcs ``arc_ids`` of the network. ``hops`` (R,) are the fewest arcs to a source.
    """

    network: Network
    starts: Ints
    heads: Ints
    arcs: ArcMap
    nodes: Ints
    anchors: Floats
    arc_ids: Ints
    hops: Ints

    @property
    def n_rows(self) -> int:
        return self.starts.size

    @property
    def rows(self) -> Ints:
        return self.nodes[: self.n_rows]

    @property
    def most_hops(self) -> int:
        return int(self.hops.max(initial=0))

    @cached_property
    def owners(self) -> Ints:
        """(A,) the row of each arc."""
        return np.repeat(np.arange(self.n_rows), np.diff(self.starts, append=self.heads.size))

    def parent_values(self, y: Floats) -> Floats:
        """Return (R,) m_i = min_j f_i(y_j, w_ij)."""
        if self.n_rows == 0:
            return np.empty(0)
        return np.minimum.reduceat(self.arcs(y[self.heads]), self.starts)

    def disequilibrium(self, y: Floats) -> Floats:
        """Return xhat (R,), eq. (xhat)."""
        return y[: self.n_rows] - self.parent_values(y)

    def hops_along(self, arcs: Bools) -> Ints:
        """Return (R + S,) the fewest of these ``arcs`` (A,) from each node to a source; -1 without a way."""
        counts = np.bincount(self.owners[arcs], minlength=self.nodes.size)
        sources = np.arange(self.n_rows, self.nodes.size)
        return hops_to_source(np.concatenate(([0], np.cumsum(counts))), self.heads[arcs], sources)

    def hop_bound(self, k: int, a: float) -> float:
        """Return g_k(a): the largest, over the nodes of k hops, of the cheapest f_ij(a) towards k - 1 hops."""
        arcs, starts = self._arcs_by_hops[k - 1]
        with np.errstate(over="ignore"):
            return float(np.minimum.reduceat(self.arcs.take(arcs)(np.full(arcs.size, a)), starts).max())

    @cached_property
    def _arcs_by_hops(self) -> list[tuple[Ints, Ints]]:
        """For 1, 2, .. hops: the arcs that lead one hop nearer to a source, and the first one of each node."""
        hops = np.concatenate((self.hops, np.zeros(self.anchors.size, dtype=np.int64)))
        downhill = np.flatnonzero(hops[self.heads] < hops[self.owners])
        height = hops[self.owners[downhill]]
        downhill = downhill[np.argsort(height, kind="stable")]
        groups = [downhill[a:b] for a, b in pairwise(np.cumsum(np.bincount(height, minlength=1)))]
        return [(arcs, np.flatnonzero(np.diff(self.owners[arcs], prepend=-1))) for arcs in groups]

    def hop_bounds(self, y0: Floats | None = None) -> Floats:
        """Return V_0 = max source, V_k = g_k(V_(k-1)), at least the largest y0 of the nodes of k hops."""
        least = np.full(self.most_hops + 1, -np.inf)
        if y0 is not None:
            np.maximum.at(least, self.hops, y0[: self.n_rows])
        hop_bounds = [float(self.anchors.max())]
        for k, floor in enumerate(least[1:].tolist(), start=1):
            hop_bounds.append(max(floor, self.hop_bound(k, hop_bounds[-1])))
        return np.array(hop_bounds)

    def mean_cost(self, y: Floats) -> float:
        """Return the mean cost of an arc at state ``y``: the scale of the error of a step."""
        heads = y[self.heads]
        return float(np.mean(np.abs(self.arcs(heads) - heads))) if self.n_rows else 0.0

    def with_sources(self, rows: Floats) -> Floats:
        """Return (R + S,) the states ``rows`` (R,), and the sources at their anchors."""
        return np.concatenate((rows, self.anchors))

    def pack(self, x: Floats) -> Floats:
        """Return the states of these nodes from an array over all nodes, sources at their anchors."""
        return self.with_sources(x[self.rows])

    def unpack(self, y: Any, missing: float = np.inf) -> NDArray[Any]:
        """Return an array over all nodes from ``y`` (R + S,), or from the rows (R,); ``missing`` elsewhere."""
        x = np.full(self.network.n_nodes, missing, dtype=y.dtype)
        x[self.nodes[: y.size]] = y
        return x


def reduce_network(net: Network) -> Problem:
    """Return the problem without sources' arcs, unreachable nodes and arcs into them."""
    hops = hops_to_source(net.indptr, net.indices, net.sources)
    is_row = hops > 0
    nodes = np.concatenate((np.flatnonzero(is_row), net.sources))
    position = np.full(net.n_nodes, -1, dtype=np.intp)
    position[nodes] = np.arange(nodes.size)
    arc_ids = np.flatnonzero(is_row[net.tails] & (hops[net.indices] >= 0))
    counts = np.bincount(position[net.tails[arc_ids]], minlength=nodes.size - net.sources.size)
    heads, arcs = position[net.indices[arc_ids]], net.arcs.take(arc_ids)
    starts = np.cumsum(counts) - counts
    return Problem(net, starts, heads, arcs, nodes, net.source_values, arc_ids, hops[is_row])


def check_states(net: Network, x: Any, name: str) -> Floats:
    """Return ``x``, or the x of a result, as one state per node (n,); AssumptionError for another shape."""
    result = plain_numbers(name, getattr(x, "x", x), AssumptionError)
    if result.shape != (net.n_nodes,):
        raise AssumptionError(f"{name} must have shape ({net.n_nodes},), one state per node, got {result.shape}.")
    return result


def check_finite_states(problem: Problem, x: Any, name: str) -> Floats:
    """Return ``x`` as :func:`check_states` does, finite at every reachable node."""
    result = check_states(problem.network, x, name)
    if (bad := problem.nodes[~np.isfinite(result[problem.nodes])]).size:
        raise AssumptionError(f"{name}[{bad[0]}] must be finite, got {result[bad[0]]}.")
    return result


@dataclass(frozen=True)
class Premises:
    """The interval [lower, upper] of a run's states, with zeta, eq. (progressive), and L, eq. (Lipschitz).

    ``sampled`` is True where a user's kernel was probed on a grid, which can refuse a kernel but prove nothing.
    """

    lower: float
    upper: float
    zeta: float
    L: float
    sampled: bool


def overestimate(net: Network) -> Floats:
    """Return a strict overestimate (n,) of x*, assumption (over); +inf at nodes that reach no source.

    U_0 = max source value, U_k = g_k(U_(k-1)) with g_k(a) the largest, over nodes of k hops, of their cheapest arc's
    f_ij(a) towards k - 1 hops: a fewest-hops path costs at most U_k. Nodes of k hops start at g_k(U_k) > U_k.
    """
    problem = reduce_network(net)
    return problem.unpack(default_start(problem))


def default_start(problem: Problem) -> Floats:
    """Return :func:`overestimate` as states (R + S,) of a problem."""
    starts = [0.0, *(problem.hop_bound(k, bound) for k, bound in enumerate(problem.hop_bounds().tolist()) if k)]
    return problem.with_sources(np.array(starts)[problem.hops])


def check_premises(problem: Problem, y0: Floats) -> Premises:
    """Check kernel and start; raise AssumptionError naming the node and arc that break an assumption.

    The interval: lemma (globalbound) from below, where x_i >= min{xbar_1*, min x(0)}, loosened to the sources' smallest
    value; from above the largest value of :func:`ceiling`.
    """
    kernel = problem.network.kernel
    if (bad := np.flatnonzero(~kernel.domain.contains(y0))).size:
        where = f"outside the domain {kernel.domain} of {type(kernel).__name__}: choose x0 and source_values inside it."
        raise AssumptionError(f"node {problem.nodes[bad[0]]} starts at {y0[bad[0]]:g}, {where}")
    upper = float(problem.hop_bounds(y0).max())
    if not np.isfinite(upper):
        raise AssumptionError("the bound on the states overflows: give a smaller x0, or rescale the weights.")
    lower = float(min(problem.anchors.min(), y0[: problem.n_rows].min(initial=np.inf)))
    if problem.n_rows == 0:
        return Premises(lower, upper, np.inf, 1.0, problem.arcs.sampled)
    gains, least, steepest = problem.arcs.extremes(lower, upper)
    for value, complaint in (
        (least, f"does not increase on [{lower:g}, {upper:g}]: its slope falls to"),
        (gains, f"is not progressive on [{lower:g}, {upper:g}]: f(a) - a falls to"),
    ):
        if (bad := np.flatnonzero(~(value > 0))).size:
            net, arc = problem.network, problem.arc_ids[bad[0]]
            raise AssumptionError(
                f"{type(kernel).__name__} {complaint} {value[bad[0]]:g} on arc {arc}, by which node {net.tails[arc]} "
                f"reads node {net.indices[arc]}: raise that arc's cost, or choose another x0."
            )
    return Premises(lower, upper, float(gains.min()), float(steepest.max()), problem.arcs.sampled)


def ceiling(problem: Problem, y0: Floats) -> Floats:
    """Return states (R + S,) that no run from ``y0`` exceeds.

    Ours: lemma (globalexistence) gives no number. V of :meth:`Problem.hop_bounds` satisfies T'V <= V, and the flow
    keeps order, so x stays below V.
    """
    return problem.with_sources(problem.hop_bounds(y0)[problem.hops])


def require_overestimate(problem: Problem, y0: Floats, y_star: Floats, law: str) -> None:
    """Raise AssumptionError unless (over) holds: x_i(0) > x_i* at every non-source node."""
    if (bad := np.flatnonzero(~(y0 > y_star)[: problem.n_rows])).size:
        node = f"node {problem.nodes[bad[0]]} starts at {y0[bad[0]]:g} with x* = {y_star[bad[0]]:g}"
        raise AssumptionError(
            f"the {law} law needs starts above the optimum, eq. (ass:over), but {node}: use x0=overestimate(net), or "
            "the SingularityFree law."
        )


def pack_start(problem: Problem, x0: Floats | float | None) -> Floats:
    """Return the start (R + S,) from ``x0`` (n,) or one number for all; sources keep their values."""
    if x0 is None:
        return default_start(problem)
    x = plain_numbers("x0", x0, AssumptionError)
    x = np.full(problem.network.n_nodes, float(x)) if x.ndim == 0 else x
    return problem.pack(check_finite_states(problem, x, "x0"))
