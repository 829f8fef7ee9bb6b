"""The rows of ``benchmarks roadmap``, and the tables of them.

Columns. One method in one scene. Up to ``software``: the settings; then the results.

``build_s``: seconds to a roadmap of ``nodes`` nodes; ``node_checks_s``: of these, the checker's look at every node,
measured again by itself. ``query_ms``, ``query_worst_ms``: median and longest of the ``queries`` new starts and
goals put to it one by one, of which ``solved`` were solved. ``many_ms``: milliseconds a start where all starts share
one goal and one field. ``touching``: of ``looked_at`` edges of the roadmap, those on which coal finds a contact when
they are sampled every millimetre of motion. ``contacts``: segments of the answered paths on which it does. ``plan_s``
and ``memory_mib``, the peak of its process, belong to the rows of whole plans. ``cpu_s``: processor time of our
building, or of the plan.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks import bench
from benchmarks.text import markdown_table

OURS = "gabf-planner"
PEERS = OMPL, OMPL_PLAIN = "OMPL PRM, our checker", "OMPL PRM, plain coal"
PLAN = "gabf-planner, plan"
_LARGE = 20_000  # nodes
MEASURED = "measured"


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """What is meant to show, and whether these rows do; of 0 where it was not measured."""
    every = [row for row in rows if row.method == OURS and row.build_s is not None]
    ours = [row for row in every if row.nodes_asked == rows[0].nodes_asked]
    peers = [row for row in rows if row.method in PEERS and row.build_s is not None]
    growth = bench.growth_exponent((row.nodes_asked, row.build_s) for row in every if row.build_s)
    large = [row.build_s for row in every if row.nodes_asked == _LARGE and row.build_s]
    ratios = {
        peer.method: ratio for peer in peers if (ratio := bench.ratio(peer.build_s, ours[0].build_s if ours else None))
    }
    queries = [row.query_ms for row in ours if row.query_ms is not None]
    return (
        bench.tally(
            "Building is 10 times faster than with the Python peers at the same number of nodes.",
            (ratio >= 10.0 for ratio in ratios.values()),
            ", ".join(f"{name}: {ratio:.1f} times" for name, ratio in ratios.items()),
        ),
        bench.tally(
            "A query on a kept roadmap takes less than 50 ms in the median.",
            (value < 50.0 for value in queries),
            ", ".join(f"{value:.1f} ms" for value in queries),
        ),
        bench.tally(
            "No edge and no path of ours touches anything.",
            (row.touching == 0 and row.contacts == 0 for row in every),
            "",
        ),
        bench.tally(
            "The time to build grows at most as n^1.2.",
            [] if growth is None else [growth <= 1.2],
            "" if growth is None else f"n^{growth:.2f}",
        ),
        bench.tally(
            f"{_LARGE} proven nodes are there within 40 s.",
            (value <= 40.0 for value in large),
            ", ".join(f"{value:.1f} s" for value in large),
        ),
    )


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """Return a table of roadmaps and one of their growth."""
    ours = next((row for row in rows if row.method == OURS), None)
    header = ["method", "build (s)", "over ours", "nodes", "edges", "proven", "touching", "query (ms)", "over ours"]
    header += ["longest (ms)", "solved", "of", "segments touching", "many starts (ms each)"]
    compared = [row for row in rows if row.method != PLAN and row.nodes_asked == rows[0].nodes_asked]
    lines = [_title(rows), "", *markdown_table(header, [_cells(row, ours) for row in compared]), ""]
    return [*lines, *_node_checks(ours), *_growth(rows)]


def fault(row: bench.Row) -> str:
    """A method that was not measured."""
    return "" if row.outcome == MEASURED else f"{row.method}: {row.outcome}. {row.message or ''}".rstrip()


def _node_checks(ours: bench.Row | None) -> list[str]:
    """What the look at every node costs, and the build without it."""
    if ours is None or ours.build_s is None or ours.node_checks_s is None or not ours.nodes:
        return []
    each, without = 1e3 * ours.node_checks_s / ours.nodes, ours.build_s - ours.node_checks_s
    text = (
        f"Of our build {ours.node_checks_s:.3f} s are the check of its nodes by {ours.collision}, {each:.3f} ms a node"
    )
    return [f"{text}; without it the build takes {without:.3f} s.", ""]


def _growth(rows: Sequence[bench.Row]) -> list[str]:
    """How ours grows with the nodes, where more than one number of them was measured."""
    plans = {row.nodes_asked: row for row in rows if row.method == PLAN}
    maps = {row.nodes_asked: row for row in rows if row.method == OURS}
    if len(maps) < 2:
        return []
    header = [
        "nodes",
        "build (s)",
        "CPU (s)",
        "edges",
        "proven",
        "query (ms)",
        "plan (s)",
        "CPU (s)",
        "peak of it (MiB)",
    ]
    lines = []
    for size, row in sorted(maps.items()):
        plan = plans.get(size)
        cells = [size, row.build_s, row.cpu_s, row.edges, row.proven, row.query_ms]
        lines.append([*cells, *(getattr(plan, name, None) for name in ("plan_s", "cpu_s", "memory_mib"))])
    slopes = {
        "building": bench.growth_exponent((size, row.build_s) for size, row in maps.items() if row.build_s),
        "its CPU time": bench.growth_exponent((size, row.cpu_s) for size, row in maps.items() if row.cpu_s),
        "a query": bench.growth_exponent((size, row.query_ms) for size, row in maps.items() if row.query_ms),
        "a plan": bench.growth_exponent((size, row.plan_s) for size, row in plans.items() if row.plan_s),
    }
    fitted = ", ".join(f"{name} n^{slope:.2f}" for name, slope in slopes.items() if slope is not None)
    return [*markdown_table(header, lines, texts=0), "", f"Growth with the nodes, fitted: {fitted}.", ""]


def _title(rows: Sequence[bench.Row]) -> str:
    if not rows:
        return "Nothing was measured."
    row = rows[0]
    size = f"{row.nodes_asked} nodes, {row.queries} queries, seed {row.seed}"
    return f"{row.robot} in {row.scene}, {row.collision}, {size}."


def _cells(row: bench.Row, ours: bench.Row | None) -> list[Any]:
    build, query = (bench.ratio(getattr(row, name), getattr(ours, name, None)) for name in ("build_s", "query_ms"))
    touching = None if row.touching is None else f"{row.touching} of {row.looked_at}"
    cells = [row.method, row.build_s, build, row.nodes, row.edges, row.proven, touching, row.query_ms, query]
    return [*cells, row.query_worst_ms, row.solved, row.queries, row.contacts, row.many_ms]
