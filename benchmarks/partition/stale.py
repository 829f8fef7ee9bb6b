"""``benchmarks stale``: blocks that read old values of each other. What still holds, and what the paper covers.

The paper's law reads the neighbours' states of the same instant. Here a block reads what others sent ``delay`` steps
ago, or at the last multiple of a ``period`` of the law's time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.bench import closing_lines, run_bench, software
from benchmarks.gabf.case import geometric_network
from planner import gabf
from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.base.tables import markdown_table
from planner.batch.results import Results
from planner.gabf.laws import Law
from planner.gabf.partitioned.block import Block
from planner.gabf.partitioned.cut import Cut, bands
from planner.gabf.partitioned.run import PartitionedField
from planner.gabf.problem import reduce
from planner.gabf.solvers import State
from planner.problem.request import require_seed

NODES, BLOCKS, MOST_STEPS = 500, 4, 4000
LAWS: dict[str, Law] = {law.name: law for law in (gabf.SingularityFree(), gabf.PrescribedTime(), gabf.Nominal())}
DELAYS = (0, 1, 4, 16)  # steps
PERIODS = (0.01, 0.1, 0.5)  # shares of T_p


@dataclass(frozen=True)
class Row:
    """One law, start and staleness on ``graphs`` networks.

    ``settled``: ended at rest with x* to the bit of a run without staleness; ``crossed``: some state crossed x* by more
    than rounding, coming from above or below only. ``error``: the largest max |x - x*| / max(1, |x*|) at the end.
    ``tau_ratio``: median of the settling reading over that without staleness; ``late``: reached rest at a reading that
    no double t < T_p has.
    """

    law: str
    start: str
    stale: str
    graphs: int
    seed: int
    software: str
    settled: int = 0
    crossed: int = 0
    error: float | None = None
    tau_ratio: float | None = None
    late: int = 0

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.law, self.start, self.stale, self.graphs, self.seed, self.software


class StaleField(PartitionedField):
    """Blocks that receive the boundary of ``delay`` steps ago, or, if any are ``due``, at those readings tau only."""

    def __init__(self, cut: Cut, law: Law, y0: Floats, delay: int, due: Floats) -> None:
        parts = zip(cut.halos, cut.parts(y0), strict=True)
        arguments = ((rows, y, halo.sent, halo.received.size, law.flow) for halo, (rows, y) in parts)
        super().__init__(cut, [Block(*each) for each in arguments], -1.0)
        self._due, self._renewed = due, 0
        first = y0[cut.boundary]
        self._past: deque[Floats] = deque([first] * (delay + 1), maxlen=delay + 1)

    def state(self, tau: float, evaluations: int, rejected: int = 0) -> State:
        """Also where the boundary is sent."""
        state = super().state(tau, evaluations, rejected)
        passed = int(np.searchsorted(self._due, tau, side="right"))
        if not self._due.size or passed > self._renewed:
            self._renewed = passed
            self._past.append(state.y[self._cut.boundary])
        return state

    def retire(self) -> None:
        """No row rests for good: what it reads may still turn out to have moved."""

    def _exchange(self, sent: Sequence[Floats]) -> list[Floats]:
        return [self._past[0][halo.received] for halo in self._cut.halos]


def bench_stale(out: Path, graphs: int = 10, seed: int = 0, progress: Progress = QUIET) -> Results[Row]:
    """Every law, start and staleness on ``graphs`` networks of 500 nodes in 4 blocks; ``stale.csv``, ``stale.md``."""
    require_seed(seed)
    if graphs < 1:
        raise OptionError("give at least 1 graph.")
    stale = [*(f"{delay} steps" for delay in DELAYS), *(f"{share:g} T_p" for share in PERIODS)]
    here = software()
    blanks = [
        Row(law.name, start, how, graphs, seed, here)
        for law in LAWS.values()
        for start in (("above",) if law.needs_overestimate else ("above", "below"))
        for how in stale
        if law.prescribed_time is not None or "T_p" not in how
    ]
    return run_bench(
        out, "stale", Row, blanks, lambda table, row: table.find(row.key), _measure, to_markdown, "cases", progress
    )


def _measure(blank: Row, progress: Progress) -> list[Row]:
    """One case on all graphs; no row where stopped."""
    runs = []
    for k in range(blank.graphs):
        if progress.stopped:
            return []
        runs.append(_run(LAWS[blank.law], blank.start, blank.stale, np.random.default_rng([blank.seed, k])))
    ratios = [run.tau_ratio for run in runs if run.tau_ratio is not None]
    return [
        Row(
            *blank.key,
            settled=sum(run.settled for run in runs),
            crossed=sum(run.crossed for run in runs),
            error=max(run.error for run in runs),
            tau_ratio=float(np.median(ratios)) if ratios else None,
            late=sum(run.late for run in runs),
        )
    ]


@dataclass(frozen=True)
class _StaleRun:
    settled: bool
    crossed: bool
    error: float
    tau_ratio: float | None
    late: bool


def _run(law: Law, start: str, stale: str, rng: np.random.Generator) -> _StaleRun:
    network = geometric_network(NODES, 6, rng)
    problem = reduce(network)
    x0 = gabf.overestimate(network) if start == "above" else np.zeros(network.n_nodes)
    fresh = gabf.solve(network, law, x0)
    y0, y_star = problem.pack(x0), problem.pack(fresh.x)
    delay, due = _when(law, stale)
    field = StaleField(Cut.of(problem, bands(problem, BLOCKS), BLOCKS), law, y0, delay, due)
    states = gabf.Splitting().steps(field, law.flow, problem.mean_cost(y0), due)
    wrong_side, rounding = (-1.0 if start == "above" else 1.0), 1e-12 * np.maximum(1.0, np.abs(y_star))
    crossed, quiet, step = False, 0, 0
    while True:
        state, step = next(states), step + 1
        crossed |= bool((wrong_side * (state.y - y_star) > rounding).any())
        at_rest = not problem.disequilibrium(state.y).any()
        quiet = quiet + 1 if state.residual == 0.0 and state.tau >= due.max(initial=0.0) else 0
        if at_rest or step > MOST_STEPS or quiet > delay + 2:
            break
    ratio = state.tau / fresh.end_tau if at_rest else None
    late = law.prescribed_time is not None and float(law.clock.time(state.tau)) >= law.prescribed_time
    error = float((np.abs(state.y - y_star) / np.maximum(1.0, np.abs(y_star))).max())
    return _StaleRun(at_rest and error == 0.0, crossed, error, ratio, at_rest and late)


def _when(law: Law, stale: str) -> tuple[int, Floats]:
    """How many steps old what a block is told is, or the readings tau at which it is told anything."""
    number, unit = stale.split()
    if unit == "steps":
        return int(number), np.empty(0)
    share = float(number)
    return 0, law.clock.tau((law.prescribed_time or 0.0) * np.arange(share, 1.0 - 0.5 * share, share))


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """A line a case."""
    header = [
        "law",
        "start",
        "values are old by",
        "graphs",
        "at rest at x*",
        "crossed x*",
        "error",
        "tau / fresh",
        "t = T_p",
    ]
    cells = [(r.law, r.start, r.stale, r.graphs, r.settled, r.crossed, r.error, r.tau_ratio, r.late) for r in rows]
    table = markdown_table(header, cells, 3)
    return (
        "\n".join(["# python -m benchmarks stale", "", *table, *closing_lines(rows, complete, "cases", _METHOD)]) + "\n"
    )


_METHOD = """What theory covers. The paper's theorems read neighbours at the same instant, so none of them speaks of old
values. That x* stays the only rest, and that starts above x* stay above and starts below stay below, follows from the
kernel being increasing and progressive, and from the flow keeping order, whatever the delay; T_f and T_* do not: each
hop across a cut takes one delay more. Where values are told at a fixed period of t, no more are told than fit before
T_p, and a network whose optimal paths cross cuts more often than that does not settle by T_p at all. The runs stop at
rest, after 4000 steps, or where all blocks rest on old values. 0 steps: told once a step instead of twice."""
