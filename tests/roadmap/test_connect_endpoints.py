"""New starts and goals on a roadmap that is there."""

import re
from dataclasses import replace

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import StateError
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.collision.recheck import sample_segment
from planner.kinematics.manipulability import manipulability
from planner.roadmap.build import build_roadmap
from planner.roadmap.connect_endpoints import attach, grow_bridges
from planner.roadmap.connections import NEIGHBOURS
from planner.roadmap.grow import GrowthSettings
from planner.roadmap.roadmap import edge_motions
from planner.robot.poses import pose
from planner.robot.shapes import Box
from planner.search.network import build_network
from tests.worlds import POST_START, checker_of, load, make_post, post_roadmap, random_q, scene_of

Q, OTHER = np.array([[-0.9, 1.2]]), np.array([[0.8, -1.1]])


def around_the_post():
    return post_roadmap(seed=2)  # in which nobody beyond the post sees POST_START


def test_new_ends_become_linked_nodes():
    old = around_the_post()
    new = attach(old, make_post(), Q, OTHER)
    n = len(old.nodes)
    assert new.starts.tolist() == [n]
    assert new.goals.tolist() == [n + 1]
    np.testing.assert_array_equal(new.nodes[:n], old.nodes)
    np.testing.assert_array_equal(new.nodes[n : n + 2], [Q[0], OTHER[0]])
    kept = new.edges[(new.edges < n).all(axis=1)]
    assert {tuple(edge) for edge in old.edges.tolist()} <= {tuple(edge) for edge in kept.tolist()}  # and shortcuts
    added = new.edges[(new.edges >= n).any(axis=1)]
    assert 0 < (added < n + 2).all(axis=1).sum() <= 2 * NEIGHBOURS
    assert (new.edges[:, 0] < new.edges[:, 1]).all()
    assert (np.lexsort((new.edges[:, 1], new.edges[:, 0])) == np.arange(len(new.edges))).all()
    assert new.is_connected
    apart = np.linalg.norm(new.nodes[:n] - Q, axis=1)
    assert set(new.edges[new.edges[:, 1] == n, 0]) <= set(np.argsort(apart)[:NEIGHBOURS])
    for i, j in added:
        assert sample_segment(make_post(), new.nodes[i], new.nodes[j] - new.nodes[i]) is None


def shortest(roadmap):
    """The length (rad) of the shortest path from the start to a goal."""
    network = build_network(roadmap, 1.0)
    return gabf.oracle(network)[roadmap.starts[0]] * roadmap.scale.joint_length


def test_the_straight_motion_from_start_to_goal_is_there_where_it_is_proven():
    goals = np.array([[-0.2, -1.9], [-0.6, 2.3]])
    new = attach(around_the_post(), make_post(), Q, goals)
    for goal in goals:
        alone = attach(around_the_post(), make_post(), Q, goal[None])
        assert sample_segment(make_post(), Q[0], goal - Q[0]) is None
        np.testing.assert_allclose(shortest(alone), np.linalg.norm(goal - Q[0]), rtol=1e-9)
    np.testing.assert_allclose(shortest(new), np.linalg.norm(goals - Q, axis=1).min(), rtol=1e-9)


def test_ends_that_are_not_free_are_refused():
    touching = "start is in collision: 'link_2' and 'thing0' touch"
    for q, text in (([-0.5, 1.2], touching), ([9, 0], "outside its limits")):
        with pytest.raises(StateError, match=text):
            attach(around_the_post(), make_post(), np.array([q], dtype=float), OTHER)
    with pytest.raises(StateError, match="goal must have 2 joint values, got 3"):
        attach(around_the_post(), make_post(), Q, np.zeros((1, 3)))


def test_what_is_a_node_already_is_that_node():
    old = around_the_post()
    new = attach(old, make_post(), old.nodes[[5]], old.nodes[[9]] + 1e-12)
    assert (new.starts.tolist(), new.goals.tolist()) == ([5], [9])
    np.testing.assert_array_equal(new.nodes[: len(old.nodes)], old.nodes)
    assert [new.edge_index(i, j) for i, j in old.edges]
    assert new.sha256 != old.sha256  # other ends
    same = attach(old, make_post(), old.nodes[old.starts], old.nodes[old.goals])
    assert (same.sha256, same.origin) == (old.sha256, old.origin)


def test_the_scale_stays_and_the_measures_are_new():
    old = around_the_post()
    new = attach(old, make_post(), Q, OTHER)
    assert new.scale == old.scale
    np.testing.assert_allclose(new.manipulability, manipulability(load("planar_2r"), new.nodes))
    n = len(old.nodes)
    before, after = build_network(old), build_network(new)
    assert before.node_cost is not None
    assert after.node_cost is not None
    np.testing.assert_allclose(after.node_cost[:n], before.node_cost)


def test_an_edge_that_was_not_proven_does_not_become_proven():
    old = around_the_post()
    doubtful = replace(old, proven=np.arange(len(old.edges)) != 3)
    new = attach(doubtful, make_post(), old.nodes[old.starts], old.nodes[old.goals])
    np.testing.assert_array_equal(new.proven, doubtful.proven)


# where direct links do not do


def beyond_the_post(least: float):
    """What the roadmap has where the first joint is beyond ``least``: nobody there sees POST_START."""
    old = around_the_post()
    return old.part(old.nodes[:, 0] > least, np.ones(len(old.edges), dtype=bool))


@pytest.mark.parametrize("least", [0.8, 1.0], ids=["the goal is a node", "the goal is new"])
def test_it_grows_where_it_must(least, caplog):
    part, goal = beyond_the_post(least), around_the_post().nodes[around_the_post().goals]
    new = attach(part, make_post(), POST_START[None], goal)
    n = len(part.nodes)
    assert new.is_connected
    assert new.component_count == part.component_count
    assert n + 2 < len(new.nodes) < n + 40
    np.testing.assert_array_equal(new.nodes[:n], part.nodes)
    np.testing.assert_array_equal(new.nodes[new.starts], POST_START[None])
    np.testing.assert_allclose(new.nodes[new.goals], goal)
    assert [new.edge_index(i, j) for i, j in part.edges]
    assert len(new.edges) - len(part.edges) > 1.5 * (len(new.nodes) - n)  # linked to its neighbours
    for i, j in new.edges[(new.edges >= n).any(axis=1)]:
        assert sample_segment(make_post(), new.nodes[i], new.nodes[j] - new.nodes[i]) is None
    assert new.scale == part.scale
    # the message counts what the way needed, not the ends themselves, nor the shortcuts
    ends = 1 + int(new.goals[0] >= n)
    (grown,) = re.findall(r"the roadmap grew by (\d+) nodes to join them", caplog.text)
    assert 0 < int(grown) <= len(new.nodes) - n - ends


def test_one_reachable_goal_of_several_is_enough(monkeypatch):
    monkeypatch.setattr("planner.roadmap.connect_endpoints.grow_bridges", lambda *_, **__: pytest.fail("grown"))
    monkeypatch.setattr("planner.roadmap.connect_endpoints.prove_straight_paths", lambda *_: [])
    old = around_the_post()
    apart = [np.linalg.norm(old.nodes - q, axis=1) for q in (Q, OTHER)]
    lonely = int(np.argmax(np.minimum(*apart)))  # no neighbour of the new ends
    part = old.part(np.ones(len(old.nodes), dtype=bool), (old.edges != lonely).all(axis=1))
    new = attach(part, make_post(), Q, np.vstack([OTHER, old.nodes[[lonely]]]))
    assert new.is_connected
    assert new.components[lonely] != new.components[new.starts[0]]


def cell():
    """Two walls beside the second link while the first one points along y."""
    at = pose([0.0, 0.0, 0], [0, 0, np.pi / 2])
    return [(Box((0.3, 0.02, 0.2)), at @ pose([0.28, y, 0])) for y in (-0.12, 0.12)]


def test_stop_ends_growing_at_once():
    new = attach(beyond_the_post(0.8), make_post(), POST_START[None], OTHER, progress=Progress(stop=lambda: True))
    assert not new.is_connected
    assert len(new.nodes) <= len(beyond_the_post(0.8).nodes) + 2


def test_a_way_that_is_not_there_is_said_so(caplog):
    shut = make_checker(load("planar_2r"), scene_of(*cell()))
    some = around_the_post().part(np.abs(around_the_post().nodes[:, 0] - np.pi / 2) > 0.5, np.ones(120, dtype=bool))
    new = attach(some, shut, POST_START[None], np.array([[np.pi / 2, 0.0]]), settings=GrowthSettings(join_motions=300))
    assert not new.is_connected
    assert "neither direct links nor 0 more nodes joined start and goal" in caplog.text


def test_ends_that_have_come_apart_are_joined_again():
    old = around_the_post()
    kept = np.array([not np.isin(edge, old.goals).any() for edge in old.edges])
    apart = old.part(np.ones(len(old.nodes), dtype=bool), kept)
    assert not apart.is_connected
    same = old.nodes[old.starts], old.nodes[old.goals]
    assert attach(apart, make_post(), *same, join=False) is apart
    assert attach(apart, make_post(), *same).is_connected


def test_ends_half_a_turn_apart_are_linked_in_pieces():
    robot = load("kinova")
    checker = checker_of("kinova")
    ends = np.array([robot.home, robot.home + 0.3 * np.eye(6)[4]])
    start, goal = robot.home - 0.5 * np.eye(6)[4], robot.home - 0.5 * np.eye(6)[4] + np.pi * np.eye(6)[5]
    new = attach(build_roadmap(robot, checker, *ends, nodes=2, density=0.0), checker, start[None], goal[None])
    _, delta = edge_motions(new, robot, np.arange(len(new.edges)))
    assert new.is_connected
    assert robot.is_below_half_turn(delta).all()


LEFT, RIGHT = (post_roadmap().nodes[post_roadmap().nodes[:, 0] * side > 0.8] for side in (-1, 1))  # of the post


def assert_bridge(path: np.ndarray, part: np.ndarray, other: np.ndarray, prover: EdgeProver) -> None:
    assert (part == path[0]).all(axis=1).any()
    assert (other == path[-1]).all(axis=1).any()
    delta = prover.robot.difference(path[:-1], path[1:])
    assert np.linalg.norm(delta, axis=1).max() <= GrowthSettings().range * (1 + 1e-9)
    assert all(sample_segment(prover.checker, q, d) is None for q, d in zip(path, delta, strict=False))


@pytest.mark.parametrize("sizes", [(40, 9), (9, 40), (1, 1)])
def test_where_nothing_is_in_the_way_the_nearest_pair_is_among_them(sizes: tuple[int, int]) -> None:
    prover = EdgeProver(checker_of("planar_2r"))
    part, other = (random_q(prover.robot, size, seed) for seed, size in enumerate(sizes))
    found = grow_bridges(prover, part, other)
    apart = np.linalg.norm(part[:, None] - other[None], axis=2)
    i, k = np.unravel_index(np.argmin(apart), apart.shape)
    np.testing.assert_array_equal(found[0][[0, -1]], [part[i], other[k]])
    for path in found:
        assert_bridge(path, part, other, prover)


def test_without_a_way_there_is_none() -> None:
    """Two walls shut the second configuration in."""
    walls = [(Box((0.3, 0.02, 0.2)), pose([0.28, y, 0])) for y in (-0.12, 0.12)]
    shut = EdgeProver(make_checker(load("planar_2r"), scene_of(*walls)))
    part, other = np.array([[1.2, 0.5]]), np.array([[0.0, 0.0]])
    assert grow_bridges(shut, part, other, settings=GrowthSettings(join_motions=300)) == []
    assert grow_bridges(shut, part, other[:0]) == []
    assert grow_bridges(shut, part, other, progress=Progress(stop=lambda: True)) == []
