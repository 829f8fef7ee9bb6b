"""Our proofs of random straight motions against HPP's continuous validation."""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np

from benchmarks.others import solver_runner
from benchmarks.others.elsewhere import answer_of
from benchmarks.others.exchange import describe_problem
from benchmarks.problems import Problem
from planner.base.arrays import Bools, Floats
from planner.base.errors import PlannerError
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.edge_prover import EdgeProver
from planner.collision.recheck import sample_segment
from planner.problem.request import PlanRequest
from planner.query.query import Query, make_query

METHODS = tuple(solver_runner.HPP_TOLERANCES)
STEP = 1e-4  # m of motion between two looks at a motion on which the two differ
_WAIT = 600.0  # s


def random_motions(checker: CollisionChecker, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Free configurations (count, dof), and motions from them: random shares of the way to random others."""
    arm, starts = checker.robot, np.zeros((0, checker.robot.dof))
    while len(starts) < count:
        q = rng.uniform(arm.lower, arm.upper, (count, arm.dof))
        starts = np.vstack([starts, q[[is_free(checker, row) for row in q]]])
    ends = rng.uniform(arm.lower, arm.upper, (count, arm.dof))
    return starts[:count], rng.uniform(size=(count, 1)) * (ends - starts[:count])


def compare_proofs(problem: Problem, plain: PlanRequest, python: str, motions: int) -> list[dict[str, Any]]:
    """Columns for each of HPP's methods; a scene that cannot be described to it has a message."""
    try:
        query = make_query(problem.asked(plain).what)
        rng = np.random.default_rng([plain.quality.seed, *problem.name.encode()])
        start, delta = random_motions(query.checker, motions, rng)
        theirs = _proven_by_hpp(query, python, start, delta)
    except PlannerError as error:
        return [{"message": str(error)} for _ in METHODS]
    begin = time.perf_counter()
    ours = EdgeProver(query.checker).free(start, delta)
    seconds = time.perf_counter() - begin
    compare = partial(_compare, query.checker, start, delta, ours)
    return [
        {**compare(np.array(theirs[method])), "tried": motions, "ours_s": seconds, "theirs_s": theirs[f"{method}_s"]}
        for method in METHODS
    ]


def _proven_by_hpp(query: Query, python: str, start: Floats, delta: Floats) -> dict[str, Any]:
    motions = np.stack([start, start + delta], axis=1).tolist()
    asked = describe_problem(query, 0, 0.0) | {"motions": motions}
    return answer_of("HPP", python, solver_runner.__file__, asked, _WAIT, ["hpp proofs"])


def _compare(checker: CollisionChecker, start: Floats, delta: Floats, ours: Bools, theirs: Bools) -> dict[str, Any]:
    """What both prove, and of what one of them does alone, how much touches, as coal sees it at every ``STEP``."""
    found: dict[str, Any] = {"free": int(ours.sum()), "both": int((ours & theirs).sum())}
    for name, alone in (("ours", ours & ~theirs), ("theirs", theirs & ~ours)):
        looks = (sample_segment(checker, start[k], delta[k], STEP) for k in np.flatnonzero(alone))
        touching = [str(contact) for contact in looks if contact is not None]
        found |= {f"only_{name}": int(alone.sum()), f"only_{name}_touching": len(touching)}
        if touching:
            found["message"] = f"motion proven by {name} alone: {touching[0]}"
    return found | {"false_free": found["only_ours_touching"]}
