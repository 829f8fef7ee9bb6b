"""One size of ``benchmarks gabf``: the network, and every method timed on it in a process of its own."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.memory import peak_memory
from planner import gabf
from planner.base.arrays import Floats
from planner.gabf.problem import reduce_network

LAW = gabf.SingularityFree()
KERNEL = gabf.TradeOff(beta=0.5)
_ARRAYS = ("indptr", "indices", "weight", "sources", "node_cost")
RTOL = 1e-6
"""Relative tolerance of RK45; the absolute one stays at SciPy's default, 1e-6, to its advantage."""

TAU_SPARE = 1.1
"""RK45 in tau runs to this many times the tau at which GABF settled."""

T_SHARE = 0.9975
"""RK45 in t runs to this share of T_p, as the paper's ode45 would."""


def geometric_network(nodes: int, neighbours: int, rng: np.random.Generator) -> gabf.Network:
    """Uniform points in a square, linked in both directions to their nearest ``neighbours``; unit density, one source.

    Weights are distances, node costs uniform in [0.1, 1], the kernel is that of eq. (finew) with beta = 0.5.
    """
    from scipy.spatial import KDTree

    points = rng.random((nodes, 2)) * np.sqrt(nodes)
    near = np.asarray(KDTree(points).query(points, neighbours + 1)[1])[:, 1:]
    i, j = np.repeat(np.arange(nodes), neighbours), near.ravel()
    code = np.unique(np.concatenate((i * nodes + j, j * nodes + i)))
    i, j = code // nodes, code % nodes
    return gabf.Network.from_arcs(
        i,
        j,
        np.linalg.norm(points[i] - points[j], axis=1),
        sources=np.array([0]),
        n_nodes=nodes,
        node_cost=rng.uniform(0.1, 1.0, nodes),
        kernel=KERNEL,
    )


def write_network(network: gabf.Network, path: Path) -> None:
    """Write the arrays of a network whose kernel is ``KERNEL``."""
    np.savez(path, allow_pickle=False, **{name: getattr(network, name) for name in _ARRAYS})


def read_network(path: Path) -> gabf.Network:
    """Read the arrays that :func:`write_network` wrote."""
    with np.load(path, allow_pickle=False) as content:
        return gabf.Network(**{name: content[name] for name in _ARRAYS}, kernel=KERNEL)


def measure(network: str, repeats: int, rk45_repeats: int) -> list[dict[str, Any]]:
    """Columns of GABF, Dijkstra and RK45 (unless ``rk45_repeats`` is 0) on the network in a file.

    The rounds are interleaved, so that other work on the machine slows all methods alike. The peak memory is taken
    after one run of GABF alone.
    """
    graph = read_network(Path(network))
    loaded = peak_memory()
    result = _solve(graph)
    peak = peak_memory()
    dijkstra = dijkstra_on(graph)
    x_star = dijkstra()
    methods: dict[str, tuple[int, Callable[[], Any]]] = {
        "dijkstra": (repeats, dijkstra),
        "gabf": (repeats, lambda: _solve(graph)),
    }
    outcomes = {"dijkstra": (0.0, None), "gabf": (gabf.max_error(result, x_star), result.steps)}
    if rk45_repeats:
        assert result.estimated_tau is not None
        methods |= _runge_kutta(graph, TAU_SPARE * result.estimated_tau, rk45_repeats)
    seconds = _interleaved(methods, outcomes, x_star)
    medians = {name: statistics.median(each) for name, each in seconds.items()}
    shared = {"arcs": graph.n_arcs, "settling_tau": result.estimated_tau}
    shared |= {"memory_loaded_mib": loaded, "memory_peak_mib": peak}
    return [
        {
            "seconds": medians[name],
            "repeats": len(each),
            "over_dijkstra": medians[name] / medians["dijkstra"],
            "over_gabf": medians[name] / medians["gabf"],
            "error": outcomes[name][0],
            "work": outcomes[name][1],
            **shared,
        }
        for name, each in seconds.items()
    ]


def _solve(network: gabf.Network) -> gabf.CostToGo:
    """One solve from nothing but the arrays: a new network holds no reversed graph from an earlier run."""
    return gabf.solve(replace(network), law=LAW)


def dijkstra_on(network: gabf.Network) -> Callable[[], Floats]:
    """SciPy's Dijkstra from the source against the arcs, on a matrix made beforehand."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import dijkstra

    shape = (network.n_nodes, network.n_nodes)
    cost = network.arcs(np.zeros(network.n_arcs))
    against = csr_matrix((cost, (network.indices, network.tails)), shape=shape)
    source = int(network.sources[0])
    return lambda: dijkstra(against, indices=source)


def _runge_kutta(network: gabf.Network, tau_end: float, repeats: int) -> dict[str, tuple[int, Callable[[], Any]]]:
    """RK45 on right sides without overhead, on packed states; only the state at the end is kept."""
    problem = reduce_network(network)
    y0 = problem.pack(np.broadcast_to(np.asarray(gabf.overestimate(network), dtype=np.float64), network.n_nodes))
    anchored = np.zeros(problem.anchors.size)

    def in_tau(_: float, y: Floats) -> Floats:
        return np.concatenate((-LAW.flow.rate(problem.disequilibrium(y)), anchored))

    def in_t(t: float, y: Floats) -> Floats:
        # etabar(t) by its formula, eq. (ebar): gabf.right_side inverts the clock, most of an explicit solver's time
        return (LAW.gamma + 2.0 * (1.0 + LAW.h) / (LAW.T - t)) * in_tau(t, y)

    def run(slope: Callable[[float, Floats], Floats], end: float) -> tuple[Floats, int]:
        from scipy.integrate import solve_ivp

        solution = solve_ivp(slope, (0.0, end), y0, rtol=RTOL, t_eval=[end])
        last = solution.y[:, -1] if solution.status == 0 else np.full(y0.size, np.inf)
        return problem.unpack(last), solution.nfev

    return {
        "rk45 in tau": (repeats, lambda: run(in_tau, tau_end)),
        "rk45 in t": (repeats, lambda: run(in_t, T_SHARE * LAW.T)),
    }


def _interleaved(
    methods: dict[str, tuple[int, Callable[[], Any]]], outcomes: dict[str, tuple[float, int | None]], x_star: Floats
) -> dict[str, list[float]]:
    """Seconds of every run of every method; the error and work of each are added to ``outcomes``."""
    seconds: dict[str, list[float]] = {name: [] for name in methods}
    for turn in range(max(repeats for repeats, _ in methods.values())):
        for name, (repeats, run) in methods.items():
            if turn < repeats:
                begin = time.perf_counter()
                answer = run()
                seconds[name].append(time.perf_counter() - begin)
                if name not in outcomes:
                    outcomes[name] = (gabf.max_error(answer[0], x_star), answer[1])
    return seconds
