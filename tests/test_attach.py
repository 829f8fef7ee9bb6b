"""New starts and goals on a roadmap that is there."""

from dataclasses import replace

import numpy as np
from conftest import POST_START, load, make_post, post_roadmap, scene_of

from planner.collision import make_checker
from planner.collision.edges import recheck
from planner.costs import build_network
from planner.kinematics.manipulability import manipulability
from planner.poses import pose
from planner.roadmap.attach import attach
from planner.roadmap.connect import NEIGHBOURS
from planner.shapes import Box

Q, OTHER = np.array([[-0.9, 1.2]]), np.array([[0.8, -1.1]])


def test_new_ends_become_linked_nodes():
    old = post_roadmap()
    new = attach(old, make_post(), Q, OTHER)
    n = len(old.nodes)
    assert new.starts.tolist() == [n]
    assert new.goals.tolist() == [n + 1]
    np.testing.assert_array_equal(new.nodes[:n], old.nodes)
    np.testing.assert_array_equal(new.nodes[n:], [Q[0], OTHER[0]])
    kept = new.edges[(new.edges < n).all(axis=1)]
    np.testing.assert_array_equal(kept, old.edges)
    added = new.edges[(new.edges >= n).any(axis=1)]
    assert 0 < len(added) <= 2 * NEIGHBOURS
    assert (new.edges[:, 0] < new.edges[:, 1]).all()
    assert (np.lexsort((new.edges[:, 1], new.edges[:, 0])) == np.arange(len(new.edges))).all()
    assert new.connected
    for i, j in added:
        assert recheck(make_post(), new.nodes[i], new.nodes[j] - new.nodes[i]) is None


def test_links_go_to_the_nearest():
    new = attach(post_roadmap(), make_post(), Q, Q)
    n = len(new.nodes) - 1
    linked = new.edges[new.edges[:, 1] == n, 0]
    apart = np.linalg.norm(new.nodes[:n] - Q, axis=1)
    assert set(linked) <= set(np.argsort(apart)[:NEIGHBOURS])


def test_what_is_a_node_already_is_that_node():
    old = post_roadmap()
    new = attach(old, make_post(), old.nodes[[5]], old.nodes[[9]] + 1e-12)
    assert (new.starts.tolist(), new.goals.tolist()) == ([5], [9])
    np.testing.assert_array_equal(new.nodes, old.nodes)
    np.testing.assert_array_equal(new.edges, old.edges)
    assert new.sha256 != old.sha256  # other ends


def test_the_same_ends_give_the_same_roadmap():
    old = post_roadmap()
    new = attach(old, make_post(), old.nodes[old.starts], old.nodes[old.goals])
    assert new.sha256 == old.sha256
    assert new.origin == old.origin


def test_start_and_goal_may_be_one():
    new = attach(post_roadmap(), make_post(), Q, Q)
    assert new.starts.tolist() == new.goals.tolist()
    assert len(new.nodes) == len(post_roadmap().nodes) + 1


def test_the_scale_stays_and_the_measures_are_new():
    old = post_roadmap()
    new = attach(old, make_post(), Q, OTHER)
    assert new.scale == old.scale
    np.testing.assert_allclose(new.manipulability, manipulability(load("planar_2r"), new.nodes))
    n = len(old.nodes)
    before, after = build_network(old), build_network(new)
    assert before.node_cost is not None
    assert after.node_cost is not None
    np.testing.assert_allclose(after.node_cost[:n], before.node_cost)


def test_an_end_that_cannot_be_linked_stays_alone():
    """Attached where a new obstacle shuts it in: no link is proven, so none is made."""
    first = np.sort(post_roadmap().nodes[:, 0])
    widest = int(np.argmax(np.diff(first)))
    angle = 0.5 * (first[widest] + first[widest + 1])  # no node's first link lies between the walls
    at = pose([0, 0, 0], [0, 0, angle])
    walls = [(Box((0.3, 0.02, 0.2)), at @ pose([x, y, 0])) for x, y in [(0.28, -0.055), (0.28, 0.055)]]
    q = np.array([[angle, 0.4]])
    shut = make_checker(load("planar_2r"), scene_of(*walls))
    new = attach(post_roadmap(), shut, POST_START[None], q)
    assert not new.connected
    assert len(new.edges) == len(post_roadmap().edges)


def test_an_edge_that_was_not_proven_does_not_become_proven():
    old = post_roadmap()
    doubtful = replace(old, proven=np.arange(len(old.edges)) != 3)
    new = attach(doubtful, make_post(), old.nodes[old.starts], old.nodes[old.goals])
    np.testing.assert_array_equal(new.proven, doubtful.proven)


def test_the_margin_is_that_of_the_weakest_proof():
    """Grown with 2 cm, attached to with none: 2 cm is no longer true of every edge."""
    old = replace(post_roadmap(), origin=replace(post_roadmap().origin, margin=0.02))
    assert attach(old, make_post(), Q, OTHER).origin.margin == 0.0
