"""One method that keeps a roadmap."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.roadmap.case import answer, plain_check, random_pairs
from planner.base.errors import SceneError
from planner.collision.checker import is_free
from planner.paths.measure import path_contact
from tests.worlds import POST_GOAL, POST_START, checker_of, load, make_post, post_roadmap, random_q


def test_one_field_answers_many_starts() -> None:
    roadmap, checker = post_roadmap(), make_post()
    starts = POST_START + np.array([[0.0, 0.0], [0.1, -0.2], [-0.2, 0.1]])
    paths = answer(roadmap, checker, starts, POST_GOAL)
    alone = [answer(roadmap, checker, start[None], POST_GOAL)[0] for start in starts]
    for path, start, single in zip(paths, starts, alone, strict=True):
        assert np.allclose(path[0], start)
        assert np.allclose(path[-1], POST_GOAL)
        assert path_contact(checker, path) is None
        assert np.allclose(single[-1], POST_GOAL)


def test_queries_are_free_and_the_same_for_all() -> None:
    checker = checker_of("planar_2r", "window")
    pairs = random_pairs(checker, 5, seed=2)
    assert pairs.shape == (5, 2, 2)
    assert all(is_free(checker, q) for q in pairs.reshape(-1, 2))
    assert np.array_equal(pairs, random_pairs(checker, 5, seed=2))
    assert not np.array_equal(pairs, random_pairs(checker, 5, seed=3))


def test_the_plain_check_says_the_same() -> None:
    checker = checker_of("panda", "shelf")
    free = plain_check(checker)
    q = random_q(load("panda"), 60, seed=6)
    said = [free(row) for row in q]
    assert said == [is_free(checker, row) for row in q]
    assert 0 < sum(said) < 60


def test_a_scene_without_room_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.roadmap.case.is_free", lambda checker, q: False)
    with pytest.raises(SceneError, match="only 0 are free"):
        random_pairs(checker_of("planar_2r", "window"), 2, seed=0)
