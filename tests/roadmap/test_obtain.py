"""The roadmap that a request names: grown, or loaded and linked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planner.problem.request import PlanRequest
from planner.query.query import make_query
from planner.roadmap.build import build_roadmap
from planner.roadmap.obtain import obtain_roadmap
from planner.roadmap.storage import same_world, save_roadmap
from tests.worlds import load, make_post, post_roadmap

REQUEST = PlanRequest.from_options(
    robot=load("planar_2r"), scene=make_post().world.scene, start="q:-1,0.8", goal="q:1,-0.8", nodes=40, seed=3
)


def test_without_a_file_it_is_grown_as_the_request_says() -> None:
    query = make_query(REQUEST.what)
    direct = build_roadmap(query.robot, query.checker, query.starts, query.goals, 40, 3)
    assert obtain_roadmap(REQUEST.quality, query).sha256 == direct.sha256


def test_a_kept_one_gets_the_querys_ends(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    save_roadmap(post_roadmap(), tmp_path / "kept.npz")
    request = REQUEST.with_options(roadmap=tmp_path / "kept.npz", start="q:-1.1,0.7")
    query = make_query(request.what)
    found = obtain_roadmap(request.quality, query)
    np.testing.assert_array_equal(found.nodes[found.starts], query.starts)
    np.testing.assert_array_equal(found.nodes[found.goals], query.goals)
    np.testing.assert_array_equal(found.nodes[: len(post_roadmap().nodes)], post_roadmap().nodes)
    assert found.connected
    assert ("--nodes is not followed" in caplog.text) == (len(post_roadmap().nodes) != request.quality.nodes)
    obtain_roadmap(request.with_options(nodes=41).quality, query)
    assert "--nodes is not followed" in caplog.text


def test_of_a_file_of_another_world_the_edges_that_hold_are_used(tmp_path: Path) -> None:
    save_roadmap(post_roadmap(), tmp_path / "kept.npz")
    request = REQUEST.with_options(roadmap=tmp_path / "kept.npz", scene="empty")
    query = make_query(request.what)
    found = obtain_roadmap(request.quality, query)
    assert same_world(found, query.checker)
    assert found.proven.all()
    assert len(found.edges) >= len(post_roadmap().edges)
