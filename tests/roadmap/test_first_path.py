"""The search for a first path: proven motions from a start to a goal, or None within its counts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planner.base.progress import Progress
from planner.collision.edge_prover import EdgeProver, Verdict, recheck
from planner.roadmap.first_path import FIRST_PATH, FirstPathSearch, JoinSettings
from planner.roadmap.motions import Motions
from planner.roadmap.ompl_planners import seed_everything
from tests.worlds import POST_GOAL, POST_START, make_post

SETTINGS = JoinSettings(range=0.4, motions=4000, shortcuts=20)


def search(prover: EdgeProver, progress: Progress | None = None) -> FirstPathSearch:
    seed_everything(0)
    return FirstPathSearch(Motions(prover), SETTINGS, progress or Progress())


def test_the_path_is_proven_subdivided_and_joins_its_ends() -> None:
    checker = make_post()
    found = search(EdgeProver(checker)).join(POST_START[None], POST_GOAL[None])
    assert found is not None
    np.testing.assert_array_equal(found[[0, -1]], [POST_START, POST_GOAL])
    delta = np.diff(found, axis=0)
    assert np.linalg.norm(delta, axis=1).max() <= SETTINGS.range * (1 + 1e-9)
    assert (EdgeProver(checker).prove(found[:-1], delta).verdict == Verdict.FREE).all()
    assert all(recheck(checker, q, d, 1e-3) is None for q, d in zip(found, delta, strict=False))


def test_the_last_report_says_that_it_is_there() -> None:
    seen: list[tuple[str, int, int]] = []
    search(EdgeProver(make_post()), Progress(lambda *report: seen.append(report))).join(
        POST_START[None], POST_GOAL[None]
    )
    assert seen[-1] == (FIRST_PATH, SETTINGS.motions, SETTINGS.motions)


class Nothing(EdgeProver):
    """Proves no motion at all."""

    def prove(self, *motions: Any, **more: Any):  # type: ignore[override]
        proofs = super().prove(*motions, **more)
        proofs.verdict[:] = Verdict.UNDECIDED
        return proofs


def test_what_cannot_be_proven_is_not_returned_and_the_search_ends() -> None:
    looking = search(Nothing(make_post()))
    assert looking.join(POST_START[None], POST_GOAL[None]) is None
    assert looking.checked >= SETTINGS.motions


@pytest.mark.parametrize("ends", [(0, 1), (1, 0)])
def test_without_a_start_or_a_goal_there_is_nothing_to_join(ends: tuple[int, int]) -> None:
    looking = search(EdgeProver(make_post()))
    assert looking.join(POST_START[None][: ends[0]], POST_GOAL[None][: ends[1]]) is None
    assert looking.checked == 0


def test_a_stop_ends_it() -> None:
    assert search(EdgeProver(make_post()), Progress(stop=lambda: True)).join(POST_START[None], POST_GOAL[None]) is None
