"""``benchmarks attack``: an optimiser that looks for distances, bounds and proofs that claim more than is true."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.attack.cases import KINDS
from benchmarks.attack.claims import attack_claims
from benchmarks.attack.reach import attack_reach
from benchmarks.attack.report import Row, to_markdown
from benchmarks.attack.segments import attack_segments
from benchmarks.bench import run_bench, software
from benchmarks.results import Results
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.collision import BACKENDS
from planner.models.robot import Robot
from planner.problem.request import SERIAL, WorkersRequest, require_seed

ROBOTS = ("planar_2r", "iiwa14")
PAIRS = tuple(combinations_with_replacement(KINDS, 2))

_Target = tuple[str, str, str, str, int]  # attack, first, second, library, tries


def bench_attack(
    folder: Path,
    tries: int = 1000,
    segments: int = 100,
    robots: Sequence[str] = ROBOTS,
    libraries: Sequence[str] = BACKENDS,
    seed: int = 0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Results[Row]:
    """Attack every pair of kinds of shapes and every robot; write ``attack.csv`` and ``attack.md``.

    ``tries``: pairs of shapes for each pair of kinds and library, and segments for the reach of each robot;
    ``segments``: segments to prove for each pair of kinds, and each robot, and library. Rows of the same attack,
    numbers, seed and software that are there already are kept. Once it is asked to stop the attack that runs is
    abandoned. Raises OptionError for numbers out of range, RobotError for an unknown robot, FileError where the folder
    cannot be used.
    """
    require_seed(seed)
    if tries < 1 or segments < 1:
        raise OptionError("give at least 1 try and 1 segment.")
    for name in robots:
        Robot.load(name)
    here = software()
    return run_bench(
        folder,
        "attack",
        Row,
        _targets(tries, segments, robots, libraries),
        lambda table, target: table.find((*target, seed, here)),
        partial(_measure, seed=seed),
        to_markdown,
        "attacks",
        progress,
        workers=workers,
    )


def _targets(tries: int, segments: int, robots: Sequence[str], libraries: Sequence[str]) -> list[_Target]:
    claims = [("claims", *pair, library, tries) for pair in PAIRS for library in libraries]
    swept = [*PAIRS, *((name, "mesh") for name in robots)]
    proofs = [("segments", *pair, library, segments) for pair in swept for library in libraries]
    return [*claims, *proofs, *(("reach", name, "", "", tries) for name in robots)]


def _measure(target: _Target, progress: Progress, seed: int) -> list[Row]:
    """One attack; no row where stopped."""
    attack, first, second, library, tries = target
    # each row has a stream of its own, so that it is the same whichever others were asked for
    rng = np.random.default_rng([seed, *attack.encode(), *first.encode(), *second.encode()])
    facts = _ATTACKS[attack](first, second, library, tries, rng, progress)
    if facts is None:
        return []
    empty = dict.fromkeys(Row.__annotations__)
    asked = {"attack": attack, "first": first, "second": second, "library": library, "tries": tries, "seed": seed}
    return [Row(**{**empty, **asked, **facts, "software": software()})]


def _claims(
    first: str, second: str, library: str, tries: int, rng: np.random.Generator, progress: Progress
) -> dict[str, Any] | None:
    worst = attack_claims((first, second), library, tries, rng, progress)
    if worst is None:
        return None
    return {
        "tried": worst.tried,
        "apart": worst.apart,
        "distances_m": worst.over["distances"],
        "coarse_m": worst.over["coarse"],
        "close_m": worst.over["close"],
        "verdict_m": worst.over.get("verdict"),
        "beyond_m": worst.beyond,
        "short_m": worst.short,
        "open_m": worst.open,
        "found": json.dumps(worst.found),
    }


def _segments(
    first: str, second: str, library: str, tries: int, rng: np.random.Generator, progress: Progress
) -> dict[str, Any] | None:
    proven = attack_segments((first, second), library, tries, rng, progress)
    if proven is None:
        return None
    return {
        "tried": proven.tried,
        "free": proven.free,
        "false_free": proven.false_free,
        "clearance_m": proven.over if proven.found else None,
        "found": json.dumps(proven.found.describe()) if proven.found else "",
    }


def _reach(
    name: str, _second: str, _library: str, tries: int, rng: np.random.Generator, progress: Progress
) -> dict[str, Any] | None:
    moved = attack_reach(name, tries, rng, progress)
    if moved is None:
        return None
    return {"tried": moved.tried, "reach_m": moved.over, "share": moved.share, "found": json.dumps(moved.found)}


_ATTACKS = {"claims": _claims, "segments": _segments, "reach": _reach}
