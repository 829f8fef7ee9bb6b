"""What the theorems assume, established on the interval that a run stays in, before it runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, plain_numbers
from planner.base.errors import AssumptionError
from planner.gabf.network import Network
from planner.gabf.problem import Problem, field, reduce


@dataclass(frozen=True)
class Premises:
    """The interval [lower, upper] that a run stays in, and zeta of eq. (progressive) and L of eq. (Lipschitz) on it.

    ``sampled`` is True where a user's kernel was probed on a grid, which can refuse a kernel but prove
    nothing.
    """

    lower: float
    upper: float
    zeta: float
    L: float
    sampled: bool


def overestimate(net: Network) -> Floats:
    """(n,) a strict overestimate of x*, as assumption (over) asks; +inf at nodes that reach no source.

    U_0 = max source value, U_k = g_k(U_(k-1)) with g_k(a) the largest, over nodes of k hops, of their
    cheapest arc's f_ij(a) towards k - 1 hops: a fewest-hops path costs at most U_k. Nodes of k hops start at
    g_k(U_k) > U_k.
    """
    problem = reduce(net)
    return problem.unpack(start_above(problem))


def start_above(problem: Problem) -> Floats:
    rungs = _ladder(problem, np.full(problem.most_hops + 1, -np.inf)).tolist()
    starts = [0.0, *(problem.climb(k, rungs[k]) for k in range(1, len(rungs)))]
    return problem.with_sources(np.array(starts)[problem.hops])


def premises(problem: Problem, y0: Floats) -> Premises:
    """Check kernel and start; raises AssumptionError naming the node and arc that break an assumption.

    The interval: lemma (globalbound) from below, where x_i >= min{xbar_1*, min x(0)}, loosened to the
    sources' smallest value; from above the largest value of :func:`ceiling`.
    """
    kernel, outside = problem.network.kernel, np.flatnonzero(~problem.network.kernel.domain.holds(y0))
    if outside.size:
        raise AssumptionError(
            f"node {problem.nodes[outside[0]]} starts at {y0[outside[0]]:g}, outside the domain {kernel.domain} of "
            f"{type(kernel).__name__}: choose x0 and source_values inside"
        )
    rows = y0[: problem.n_rows]
    upper = float(_rungs_above(problem, y0).max())
    if not np.isfinite(upper):
        raise AssumptionError("the bound on the states overflows: pass a smaller x0, or rescale the weights")
    lower = float(min(problem.anchors.min(), rows.min(initial=np.inf)))
    return check_kernel(problem, lower, upper)


def ceiling(problem: Problem, y0: Floats) -> Floats:
    """(R + S,) states that no run from ``y0`` exceeds (ours, for lemma (globalexistence) names no number).

    V_0 = max source, V_k = max(x_i(0) over nodes of k hops, g_k(V_(k-1))) with g_k of :func:`overestimate`
    satisfies T'V <= V, and the flow keeps order, so x stays below V.
    """
    return problem.with_sources(_rungs_above(problem, y0)[problem.hops])


def check_kernel(problem: Problem, lower: float, upper: float) -> Premises:
    """zeta, L and monotonicity of the kernel on [lower, upper]; AssumptionError where one fails."""
    if problem.n_rows == 0:
        return Premises(lower, upper, np.inf, 1.0, problem.arcs.sampled)
    least, steepest = problem.arcs.slopes(lower, upper)
    _refuse(problem, least > 0, least, f"does not increase on [{lower:g}, {upper:g}]: its slope falls to")
    gains = problem.arcs.progress(lower, upper)
    _refuse(problem, gains > 0, gains, f"is not progressive on [{lower:g}, {upper:g}]: f(a) - a falls to")
    return Premises(lower, upper, float(gains.min()), float(steepest.max()), problem.arcs.sampled)


def require_overestimate(problem: Problem, y0: Floats, y_star: Floats, law: str) -> None:
    """Assumption (over): x_i(0) > x_i* at every non-source node."""
    rows = problem.n_rows
    bad = np.flatnonzero(~(y0[:rows] > y_star[:rows]))
    if bad.size:
        raise AssumptionError(
            f"the {law} law needs starts above the optimum, eq. (ass:over), but node {problem.nodes[bad[0]]} "
            f"starts at {y0[bad[0]]:g} with x* = {y_star[bad[0]]:g}: use x0=overestimate(net), or the "
            "SingularityFree law"
        )


def pack_start(problem: Problem, x0: Floats | float | None) -> Floats:
    """The start as the solver holds it: ``x0`` (n,) or one number for all; sources keep their values."""
    if x0 is None:
        return start_above(problem)
    x = plain_numbers("x0", x0, AssumptionError)
    x = np.full(problem.network.n_nodes, float(x)) if x.ndim == 0 else x
    return problem.pack(field(problem, x, "x0"))


def _rungs_above(problem: Problem, y0: Floats) -> Floats:
    floor = np.full(problem.most_hops + 1, -np.inf)
    np.maximum.at(floor, problem.hops, y0[: problem.n_rows])
    return _ladder(problem, floor)


def _ladder(problem: Problem, floor: Floats) -> Floats:
    rungs = [float(problem.anchors.max())]
    for k, least in enumerate(floor[1:].tolist(), start=1):
        rungs.append(max(least, problem.climb(k, rungs[-1])))
    return np.array(rungs)


def _refuse(problem: Problem, fine: Bools, value: Floats, complaint: str) -> None:
    bad = np.flatnonzero(~np.broadcast_to(fine, problem.arc_ids.shape))
    if bad.size:
        net, arc = problem.network, problem.arc_ids[bad[0]]
        raise AssumptionError(
            f"{type(net.kernel).__name__} {complaint} {value[bad[0]]:g} on arc {arc}, by which node "
            f"{net.tails[arc]} reads node {net.indices[arc]}; raise that arc's cost, or choose x0 elsewhere"
        )
