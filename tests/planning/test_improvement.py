"""A roadmap improved for a request: it keeps what it had, and its best path is cheaper or above its ends."""

import numpy as np
import pytest

from planner import gabf
from planner.planning.improvement import add_path_without_dip, improve_roadmap, trim_roadmap
from planner.problem.request import PlanRequest
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.search.network import build_network
from tests.worlds import load, make_post, post_roadmap

ROBOT, REQUEST = load("planar_2r"), PlanRequest.from_options(robot="planar_2r", nodes=60, refinement_rounds=1)


def best(roadmap: Roadmap, beta: float) -> tuple[float, np.ndarray]:
    """The least cost of the roadmap's network, and its path."""
    network = build_network(roadmap, beta)
    field = gabf.solve(network)
    steps = gabf.extract_path(network, field, int(roadmap.starts[0]))
    return float(field.x[roadmap.starts[0]]), path_waypoints(roadmap, ROBOT, steps)


@pytest.mark.parametrize("beta", [0.0, 1.0])
def test_the_best_path_is_cheaper_and_nothing_is_lost(beta: float) -> None:
    old = post_roadmap(seed=2)
    found = improve_roadmap(old, make_post(), REQUEST.with_options(beta=beta).quality, beta).roadmap
    kept = {q.tobytes() for q in found.nodes}
    assert all(q.tobytes() in kept for q in old.nodes)
    assert found.proven.all()
    assert best(found, beta)[0] < best(old, beta)[0]
    smaller = trim_roadmap(found, len(old.nodes), REQUEST.with_options(beta=beta).quality)
    assert len(smaller.nodes) == REQUEST.quality.nodes
    assert best(smaller, beta)[0] == pytest.approx(best(found, beta)[0], rel=1e-12)


def test_without_rounds_or_a_path_nothing_changes() -> None:
    old = post_roadmap(seed=1)
    assert improve_roadmap(old, make_post(), REQUEST.with_options(refinement_rounds=0).quality, 0.5).roadmap is old
    alone = old.part(np.ones(len(old.nodes), dtype=bool), np.zeros(len(old.edges), dtype=bool))
    assert improve_roadmap(alone, make_post(), REQUEST.quality, 0.5).roadmap is alone
    assert add_path_without_dip(alone, make_post(), REQUEST.quality) == alone
