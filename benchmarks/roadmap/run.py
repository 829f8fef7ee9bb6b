"""``benchmarks roadmap``: building a kept roadmap and asking it, against the PRMs of OMPL and pyroboplan."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.bench import run_bench, run_module, software
from benchmarks.results import Results, ResultsFile
from benchmarks.roadmap.report import CHECKS, CRASHED, OURS, PEERS, PLAN, TIMED_OUT, Row, to_markdown
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.problem.request import WorldRequest, require_nodes, require_seed
from planner.setup.open import open_world

METHODS = (OURS, *PEERS, CHECKS[0])
"""What is run; the last fills the rows of both checkers."""


def bench_roadmap(
    folder: Path,
    world: WorldRequest,
    nodes: int = 1000,
    queries: int = 20,
    seed: int = 0,
    time_limit: float = 600.0,
    progress: Progress = QUIET,
    sizes: Sequence[int] = (),
) -> Results[Row]:
    """Measure every method on the robot and scene of ``world``; write ``roadmap.csv`` and ``roadmap.md``.

    With ``sizes`` ours is measured with each of these numbers of nodes too, and a plan with each and with ``nodes``.

    Each method has a process of its own, which is killed and recorded as timed out after ``time_limit`` seconds. Rows
    that are there already are kept. Once it is asked to stop the current method is abandoned. Raises OptionError for
    numbers out of range, RobotError and SceneError for what cannot be loaded, FileError where the folder is unusable.
    """
    for size in (nodes, *sizes):
        require_nodes(size)
    require_seed(seed)
    if queries < 1 or not time_limit > 0:
        raise OptionError("give at least one query, and a time limit above 0 s.")
    open_world(world)  # refuses an unknown robot or scene before anything is measured
    place = str(world.robot), str(world.scene), world.collision
    asked = (queries, seed, time_limit, software())
    cases = [(method, nodes) for method in METHODS]
    cases += [(method, size) for size in dict.fromkeys((nodes, *sizes)) for method in (OURS, PLAN) if sizes]
    return run_bench(
        folder,
        "roadmap",
        Row,
        [Row(method, *place, size, *asked, CRASHED) for method, size in dict.fromkeys(cases)],
        _kept,
        _measure,
        to_markdown,
        "methods",
        progress,
    )


def _kept(ledger: ResultsFile[Row], blank: Row) -> list[Row]:
    names = CHECKS if blank.method in CHECKS else (blank.method,)
    return [row for name in names for row in ledger.find(replace(blank, method=name).key)]


def _measure(blank: Row, progress: Progress) -> list[Row]:
    """The rows of one method; none where stopped."""
    options = {name: getattr(blank, name) for name in ("method", "robot", "scene", "collision", "queries", "seed")}
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "rows.json"
        arguments = [str(out), json.dumps(options | {"nodes": blank.nodes_asked})]
        ended = run_module("benchmarks.roadmap.case", arguments, progress, blank.time_limit_s)
        if ended.over_time:
            return [replace(blank, outcome=TIMED_OUT, message=f"Killed after {blank.time_limit_s:g} s.")]
        if ended.code is None:
            return []
        if ended.code != 0:
            return [replace(blank, message=f"The process ended with code {ended.code}: {ended.last_words}")]
        return [replace(blank, method=name, **columns) for name, columns in json.loads(out.read_text()).items()]
