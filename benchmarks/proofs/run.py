"""``benchmarks proofs``: the same random straight motions put to our prover and to HPP's, in a folder of scenes."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import require_left_to_problems, run_bench, software
from benchmarks.elsewhere import answer_of
from benchmarks.first_motion import runner
from benchmarks.first_motion.exchange import exchanged
from benchmarks.problems import Problem, find_problems
from benchmarks.proofs.report import Row, to_markdown
from benchmarks.results import Results
from planner.base.arrays import Bools, Floats
from planner.base.errors import OptionError, PlannerError
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.edge_prover import EdgeProver
from planner.collision.looks import recheck
from planner.problem.request import PlanRequest
from planner.setup.open import Query, make_query

STEP = 1e-4  # m of motion between two looks at a motion on which the two differ
_WAIT = 600.0  # s


def bench_proofs(
    folder: Path,
    out: Path,
    plain: PlanRequest,
    python: str,
    motions: int = 2000,
    progress: Progress = QUIET,
) -> Results[Row]:
    """Both provers on ``motions`` random straight motions, shared out among the scenes of the problems in ``folder``.

    ``python`` is that of an environment with HPP. Writes ``proofs.csv`` and ``proofs.md`` to ``out``; rows that are
    there already are kept. Raises OptionError for too few motions, FileError where a folder cannot be used.
    """
    require_left_to_problems(plain)
    problems = find_problems(folder)
    if motions < len(problems):
        raise OptionError(f"{motions} motions are too few for {len(problems)} scenes: give at least one for each.")
    each = -(-motions // len(problems))
    measured = partial(_measure, plain=plain, python=python, motions=each)

    def known(table: Any, problem: Problem) -> list[Row]:
        keys = [_blank(problem, plain, each, method).key for method in runner.HPP_TOLERANCES]
        return [row for key in keys for row in table.find(key)]

    return run_bench(out, "proofs", Row, problems, known, measured, to_markdown, "scenes", progress)


def random_motions(checker: CollisionChecker, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Free configurations (count, dof), and motions from them: random shares of the way to random others."""
    arm, starts = checker.robot, np.zeros((0, checker.robot.dof))
    while len(starts) < count:
        q = rng.uniform(arm.lower, arm.upper, (count, arm.dof))
        starts = np.vstack([starts, q[[is_free(checker, row) for row in q]]])
    ends = rng.uniform(arm.lower, arm.upper, (count, arm.dof))
    return starts[:count], rng.uniform(size=(count, 1)) * (ends - starts[:count])


def _measure(problem: Problem, progress: Progress, plain: PlanRequest, python: str, motions: int) -> list[Row]:
    """A row for each of HPP's methods; a scene that cannot be told to it is a row too."""
    blanks = [_blank(problem, plain, motions, method) for method in runner.HPP_TOLERANCES]
    try:
        query = make_query(problem.asked(plain))
        rng = np.random.default_rng([plain.seed, *problem.name.encode()])
        start, delta = random_motions(query.checker, motions, rng)
        theirs = _proven_by_hpp(query, python, start, delta)
    except PlannerError as error:
        return [replace(blank, message=str(error)) for blank in blanks]
    begin = time.perf_counter()
    ours = EdgeProver(query.checker).free(start, delta)
    seconds = time.perf_counter() - begin
    beside = partial(_beside, query.checker, start, delta, ours)
    return [
        replace(blank, **beside(np.array(theirs[blank.method])), ours_s=seconds, theirs_s=theirs[f"{blank.method}_s"])
        for blank in blanks
    ]


def _proven_by_hpp(query: Query, python: str, start: Floats, delta: Floats) -> dict[str, Any]:
    motions = np.stack([start, start + delta], axis=1).tolist()
    asked = exchanged(query, 0, 0.0) | {"motions": motions}
    return answer_of("HPP", python, runner.__file__, asked, _WAIT, ["hpp proofs"])


def _beside(checker: CollisionChecker, start: Floats, delta: Floats, ours: Bools, theirs: Bools) -> dict[str, Any]:
    """What both prove, and of what one of them does alone, how much touches, as coal sees it at every ``STEP``."""
    found: dict[str, Any] = {"proven": int(ours.sum()), "both": int((ours & theirs).sum())}
    for name, alone in (("ours", ours & ~theirs), ("theirs", theirs & ~ours)):
        looks = (recheck(checker, start[k], delta[k], STEP) for k in np.flatnonzero(alone))
        touching = [str(contact) for contact in looks if contact is not None]
        found |= {f"only_{name}": int(alone.sum()), f"only_{name}_touching": len(touching)}
        if touching:
            found["message"] = f"motion proven by {name} alone: {touching[0]}"
    return found


def _blank(problem: Problem, plain: PlanRequest, motions: int, method: str) -> Row:
    return Row(problem.name, method, plain.seed, str(plain.robot), motions, problem.content(plain), software())
