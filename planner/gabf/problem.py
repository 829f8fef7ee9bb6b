"""The part of a network that the dynamics acts on, and what the theorems assume of it, checked before a run."""

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

ROUNDED = 64 * float(np.finfo(float).eps)  # share of the largest state below which an xhat may be rounding


class State(NamedTuple):
    """States ``y`` (R + S,), ``xhat`` (R,) = y - m of eq. (xhat), its largest size, the range of the rows' y, and
    ``tau``.

    ``rejected`` steps were tried in vain until then.
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
    the arcs ``arc_ids`` of the network. ``hops`` (R,) fewest arcs to a source.
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
        """(A,) the row that each arc belongs to."""
        return np.repeat(np.arange(self.n_rows), np.diff(self.starts, append=self.heads.size))

    def parent_values(self, y: Floats) -> Floats:
        """(R,) m_i = min_j f_i(y_j, w_ij)."""
        if self.n_rows == 0:
            return np.empty(0)
        return np.minimum.reduceat(self.arcs(y[self.heads]), self.starts)

    def disequilibrium(self, y: Floats) -> Floats:
        """xhat (R,), eq. (xhat)."""
        return y[: self.n_rows] - self.parent_values(y)

    def hops_along(self, arcs: Bools) -> Ints:
        """(R + S,) the fewest of these ``arcs`` (A,) from each node to a source; -1 where they lead to none."""
        counts = np.bincount(self.owners[arcs], minlength=self.nodes.size)
        sources = np.arange(self.n_rows, self.nodes.size)
        return hops_to_source(np.concatenate(([0], np.cumsum(counts))), self.heads[arcs], sources)

    def hop_bound(self, k: int, a: float) -> float:
        """g_k(a): the largest, over the nodes of k hops, of the cheapest f_ij(a) towards k - 1 hops."""
        arcs, starts = self._stairs[k - 1]
        with np.errstate(over="ignore"):
            return float(np.minimum.reduceat(self.arcs.take(arcs)(np.full(arcs.size, a)), starts).max())

    @cached_property
    def _stairs(self) -> list[tuple[Ints, Ints]]:
        """For 1, 2, .. hops the arcs that lead one hop nearer to the sources, and where each node's begin."""
        hops = np.concatenate((self.hops, np.zeros(self.anchors.size, dtype=np.int64)))
        downhill = np.flatnonzero(hops[self.heads] < hops[self.owners])
        height = hops[self.owners[downhill]]
        downhill = downhill[np.argsort(height, kind="stable")]
        stairs = [downhill[a:b] for a, b in pairwise(np.cumsum(np.bincount(height, minlength=1)))]
        return [(arcs, np.flatnonzero(np.diff(self.owners[arcs], prepend=-1))) for arcs in stairs]

    def rungs(self, y0: Floats | None = None) -> Floats:
        """V_0 = max source, V_k = g_k(V_(k-1)), or the largest of the nodes of k hops in ``y0`` where that is more."""
        least = np.full(self.most_hops + 1, -np.inf)
        if y0 is not None:
            np.maximum.at(least, self.hops, y0[: self.n_rows])
        rungs = [float(self.anchors.max())]
        for k, floor in enumerate(least[1:].tolist(), start=1):
            rungs.append(max(floor, self.hop_bound(k, rungs[-1])))
        return np.array(rungs)

    def mean_cost(self, y: Floats) -> float:
        """What an arc adds on average at state ``y``: the scale that errors of one step are measured by."""
        heads = y[self.heads]
        return float(np.mean(np.abs(self.arcs(heads) - heads))) if self.n_rows else 0.0

    def with_sources(self, rows: Floats) -> Floats:
        """(R + S,) the states ``rows`` (R,), and the sources at their anchors."""
        return np.concatenate((rows, self.anchors))

    def pack(self, x: Floats) -> Floats:
        """States of these nodes from an array over all nodes, sources at their anchors."""
        return self.with_sources(x[self.rows])

    def unpack(self, y: Any, missing: float = np.inf) -> NDArray[Any]:
        """An array over all nodes out of ``y`` (R + S,), or of the rows alone (R,); ``missing`` at all others."""
        x = np.full(self.network.n_nodes, missing, dtype=y.dtype)
        x[self.nodes[: y.size]] = y
        return x


def reduce_network(net: Network) -> Problem:
    """Leave out sources' arcs, unreachable nodes and arcs into them."""
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
    """``x``, or the x of a result, as one state a node (n,), finite or not; AssumptionError otherwise."""
    result = plain_numbers(name, getattr(x, "x", x), AssumptionError)
    if result.shape != (net.n_nodes,):
        raise AssumptionError(f"{name} has shape {result.shape} where ({net.n_nodes},) is needed: one state a node")
    return result


def check_finite_states(problem: Problem, x: Any, name: str) -> Floats:
    """``x`` as :func:`states` has it, finite at every reachable node."""
    result = check_states(problem.network, x, name)
    if (bad := problem.nodes[~np.isfinite(result[problem.nodes])]).size:
        raise AssumptionError(f"{name}[{bad[0]}] is {result[bad[0]]}: every state must be finite")
    return result


@dataclass(frozen=True)
class Premises:
    """The interval [lower, upper] that a run stays in, and zeta of eq. (progressive) and L of eq. (Lipschitz) on it.

    ``sampled`` is True where a user's kernel was probed on a grid, which can refuse a kernel but prove nothing.
    """

    lower: float
    upper: float
    zeta: float
    L: float
    sampled: bool


def overestimate(net: Network) -> Floats:
    """(n,) a strict overestimate of x*, as assumption (over) asks; +inf at nodes that reach no source.

    U_0 = max source value, U_k = g_k(U_(k-1)) with g_k(a) the largest, over nodes of k hops, of their cheapest arc's
    f_ij(a) towards k - 1 hops: a fewest-hops path costs at most U_k. Nodes of k hops start at g_k(U_k) > U_k.
    """
    problem = reduce_network(net)
    return problem.unpack(default_start(problem))


def default_start(problem: Problem) -> Floats:
    starts = [0.0, *(problem.hop_bound(k, rung) for k, rung in enumerate(problem.rungs().tolist()) if k)]
    return problem.with_sources(np.array(starts)[problem.hops])


def check_premises(problem: Problem, y0: Floats) -> Premises:
    """Check kernel and start; raises AssumptionError naming the node and arc that break an assumption.

    The interval: lemma (globalbound) from below, where x_i >= min{xbar_1*, min x(0)}, loosened to the sources' smallest
    value; from above the largest value of :func:`ceiling`.
    """
    kernel = problem.network.kernel
    if (bad := np.flatnonzero(~kernel.domain.holds(y0))).size:
        where = f"outside the domain {kernel.domain} of {type(kernel).__name__}: choose x0 and source_values inside"
        raise AssumptionError(f"node {problem.nodes[bad[0]]} starts at {y0[bad[0]]:g}, {where}")
    upper = float(problem.rungs(y0).max())
    if not np.isfinite(upper):
        raise AssumptionError("the bound on the states overflows: pass a smaller x0, or rescale the weights")
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
                f"reads node {net.indices[arc]}; raise that arc's cost, or choose x0 elsewhere"
            )
    return Premises(lower, upper, float(gains.min()), float(steepest.max()), problem.arcs.sampled)


def ceiling(problem: Problem, y0: Floats) -> Floats:
    """(R + S,) states that no run from ``y0`` exceeds (ours, for lemma (globalexistence) names no number).

    V of :meth:`Problem.rungs` satisfies T'V <= V, and the flow keeps order, so x stays below V.
    """
    return problem.with_sources(problem.rungs(y0)[problem.hops])


def require_overestimate(problem: Problem, y0: Floats, y_star: Floats, law: str) -> None:
    """Assumption (over): x_i(0) > x_i* at every non-source node."""
    if (bad := np.flatnonzero(~(y0 > y_star)[: problem.n_rows])).size:
        node = f"node {problem.nodes[bad[0]]} starts at {y0[bad[0]]:g} with x* = {y_star[bad[0]]:g}"
        raise AssumptionError(
            f"the {law} law needs starts above the optimum, eq. (ass:over), but {node}: use x0=overestimate(net), or "
            "the SingularityFree law"
        )


def pack_start(problem: Problem, x0: Floats | float | None) -> Floats:
    """The start as the solver holds it: ``x0`` (n,) or one number for all; sources keep their values."""
    if x0 is None:
        return default_start(problem)
    x = plain_numbers("x0", x0, AssumptionError)
    x = np.full(problem.network.n_nodes, float(x)) if x.ndim == 0 else x
    return problem.pack(check_finite_states(problem, x, "x0"))
