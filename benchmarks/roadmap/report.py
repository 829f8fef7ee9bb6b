"""The rows of ``benchmarks roadmap``, and the tables of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.bench import aim_lines, closing_lines, growth_exponent
from planner.base.tables import markdown_table
from reproduce.verdict import Verdict, tally

OURS = "gabf-planner"
OMPL, OMPL_PLAIN, PYROBOPLAN = "OMPL PRM, our checker", "OMPL PRM, plain coal", "pyroboplan PRM"
PEERS = (OMPL, OMPL_PLAIN, PYROBOPLAN)
PLAN = "gabf-planner, plan"
CHECKS = ("FCL checks", "coal checks")
_LARGE = 20_000  # nodes
MEASURED, NOT_INSTALLED, TIMED_OUT, CRASHED = "measured", "not installed", "timed out", "crashed"


@dataclass(frozen=True)
class Row:
    """One method in one scene. Up to ``software``: the settings; then the results.

    ``build_s``: seconds to a roadmap of ``nodes`` nodes; ``node_checks_s``: of these, the checker's look at every node,
    measured once more by itself. ``query_ms``, ``query_worst_ms``: median and longest of the
    ``queries`` new starts and goals put to it one by one, of which ``solved`` were solved. ``many_ms``: milliseconds a
    start where all starts share one goal and one field. ``touching``: of ``looked_at`` edges of the roadmap, those on
    which coal finds a contact when they are sampled every millimetre of motion. ``contacts``: segments of the
    answered paths on which it does. The ``check`` columns, microseconds a configuration, belong to the checkers' rows;
    ``plan_s`` and ``memory_mib``, the peak of its process, to the rows of whole plans. ``cpu_s``: processor time of our
    building, or of the plan.
    """

    method: str
    robot: str
    scene: str
    collision: str
    nodes_asked: int
    queries: int
    seed: int
    time_limit_s: float
    software: str
    outcome: str
    message: str = ""
    build_s: float | None = None
    node_checks_s: float | None = None
    nodes: int | None = None
    edges: int | None = None
    proven: int | None = None
    query_ms: float | None = None
    query_worst_ms: float | None = None
    solved: int | None = None
    many_ms: float | None = None
    looked_at: int | None = None
    touching: int | None = None
    contacts: int | None = None
    check_single_us: float | None = None
    check_batch_us: float | None = None
    check_edge_us: float | None = None
    cpu_s: float | None = None
    plan_s: float | None = None
    memory_mib: float | None = None

    @property
    def key(self) -> tuple:
        """What was asked."""
        asked = self.robot, self.scene, self.collision, self.nodes_asked, self.queries, self.seed
        return (self.method, *asked, self.time_limit_s, self.software)


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What is meant to show, and whether these rows do; of 0 where it was not measured."""
    every = [row for row in rows if row.method == OURS and row.build_s is not None]
    ours = [row for row in every if row.nodes_asked == rows[0].nodes_asked]
    peers = [row for row in rows if row.method in PEERS and row.build_s is not None]
    growth = growth_exponent((row.nodes_asked, row.build_s) for row in every if row.build_s)
    large = [row.build_s for row in every if row.nodes_asked == _LARGE and row.build_s]
    ratios = {peer.method: ratio for peer in peers if (ratio := _ratio(peer.build_s, ours and ours[0].build_s))}
    queries = [row.query_ms for row in ours if row.query_ms is not None]
    return (
        tally(
            "Building is 10 times faster than with the Python peers at the same number of nodes.",
            (ratio >= 10.0 for ratio in ratios.values()),
            ", ".join(f"{name}: {ratio:.1f} times" for name, ratio in ratios.items()),
        ),
        tally(
            "A query on a kept roadmap takes less than 50 ms in the median.",
            (value < 50.0 for value in queries),
            ", ".join(f"{value:.1f} ms" for value in queries),
        ),
        tally(
            "No edge and no path of ours touches anything.",
            (row.touching == 0 and row.contacts == 0 for row in every),
            "",
        ),
        tally(
            "The time to build grows at most as n^1.2.",
            [] if growth is None else [growth <= 1.2],
            "" if growth is None else f"n^{growth:.2f}",
        ),
        tally(
            f"{_LARGE} proven nodes are there within 40 s.",
            (value <= 40.0 for value in large),
            ", ".join(f"{value:.1f} s" for value in large),
        ),
    )


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The tables for people: roadmaps, state checks, aims."""
    ours = next((row for row in rows if row.method == OURS), None)
    header = ["method", "build (s)", "over ours", "nodes", "edges", "proven", "touching", "query (ms)", "over ours"]
    header += ["longest (ms)", "solved", "of", "segments touching", "many starts (ms each)"]
    compared = [row for row in rows if row.method not in (*CHECKS, PLAN) and row.nodes_asked == rows[0].nodes_asked]
    maps = [_cells(row, ours) for row in compared]
    lines = ["# python -m benchmarks roadmap", "", _title(rows), "", *markdown_table(header, maps), ""]
    lines += [*_node_checks(ours), *_growth(rows)]
    checks = [
        [row.method, row.check_single_us, row.check_batch_us, row.check_edge_us] for row in rows if row.method in CHECKS
    ]
    lines += [*markdown_table(["", "one by one (us)", "batch (us)", "along edges (us)"], checks), ""] if checks else []
    lines += aim_lines(aims(rows))
    lines += [f"- {row.method}: {row.outcome}. {row.message}".rstrip() for row in rows if row.outcome != MEASURED]
    return "\n".join([*lines, *closing_lines(rows, complete, "methods", _METHOD)]) + "\n"


def _node_checks(ours: Row | None) -> list[str]:
    """What the look at every node costs, and the build without it."""
    if ours is None or ours.build_s is None or ours.node_checks_s is None or not ours.nodes:
        return []
    each, without = 1e3 * ours.node_checks_s / ours.nodes, ours.build_s - ours.node_checks_s
    text = (
        f"Of our build {ours.node_checks_s:.3f} s are the check of its nodes by {ours.collision}, {each:.3f} ms a node"
    )
    return [f"{text}; without it the build takes {without:.3f} s.", ""]


def _growth(rows: Sequence[Row]) -> list[str]:
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
        "building": growth_exponent((size, row.build_s) for size, row in maps.items() if row.build_s),
        "its CPU time": growth_exponent((size, row.cpu_s) for size, row in maps.items() if row.cpu_s),
        "a query": growth_exponent((size, row.query_ms) for size, row in maps.items() if row.query_ms),
        "a plan": growth_exponent((size, row.plan_s) for size, row in plans.items() if row.plan_s),
    }
    fitted = ", ".join(f"{name} n^{slope:.2f}" for name, slope in slopes.items() if slope is not None)
    return [*markdown_table(header, lines, texts=0), "", f"Growth with the nodes, fitted: {fitted}.", ""]


def _title(rows: Sequence[Row]) -> str:
    if not rows:
        return "Nothing was measured."
    row = rows[0]
    size = f"{row.nodes_asked} nodes, {row.queries} queries, seed {row.seed}"
    return f"{row.robot} in {row.scene}, {row.collision}, {size}."


def _cells(row: Row, ours: Row | None) -> list[Any]:
    build, query = (_ratio(getattr(row, name), getattr(ours, name, None)) for name in ("build_s", "query_ms"))
    touching = None if row.touching is None else f"{row.touching} of {row.looked_at}"
    cells = [row.method, row.build_s, build, row.nodes, row.edges, row.proven, touching, row.query_ms, query]
    return [*cells, row.query_worst_ms, row.solved, row.queries, row.contacts, row.many_ms]


def _ratio(value: float | None, base: Any) -> float | None:
    return value / base if value is not None and base else None


_METHOD = """How. All methods get the same robot, scene, collision pairs and queries: random free starts and goals.
Each runs in a process of its own, one after the other; times are of the wall clock, once the libraries are loaded.
Ours: `planner.build_roadmap`, every edge proven; a query is `attach`, `build_network`, the field by GABF under the
singularity-free law, and the path. "Many starts" attaches all starts and one goal, computes one field, and reads every
path off it. OMPL's PRM has its defaults, its motions sampled at its default resolution, and a Python callback as
state check: "our checker" is the same as ours, "plain coal" asks Pinocchio about all pairs in turn, as its
documentation shows. A query is `solve` on the kept roadmap, which grows further where start and goal are not joined.
pyroboplan's PRM (`pip install --no-deps pyroboplan`: it asks for another Pinocchio than this package) has its
defaults, save a linking radius of 2 rad, as its 0.5 rad links nothing here; it gets coal's geometry whatever the
checker. Touching: edges, at most 200 drawn at random, and answered paths, sampled every millimetre of motion by
coal.
Growth: roadmaps of ours of more sizes, and whole plans, refined as by default, from the scene's start to its goal,
each in a process of its own whose peak memory is given. State checks are those of `python -m benchmarks agreement`,
over free configurations of this scene. Limitations. OMPL's PRM alternates by the clock and is not reproducible. The
roadmaps are not alike: ours is sparse, grown from trees, and proven, theirs are denser, uniform, and not."""
