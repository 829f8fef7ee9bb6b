"""More of a roadmap: what was there stays as it was, what is new is proven and linked to it."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.collision.looks import recheck
from planner.construction.build import DENSITY, build_roadmap
from planner.construction.extend import extend
from planner.construction.repair import measures_hold, verify
from planner.kinematics.manipulability import manipulability
from planner.planning.network import build_network
from planner.roadmap.measure import measure_edges
from tests.worlds import load, make_post, post_roadmap, small_plan

OLD = post_roadmap()
NEW = extend(OLD, make_post(), 40)


def test_old_nodes_and_edges_stay():
    n, m = len(OLD.nodes), len(OLD.edges)
    assert len(NEW.nodes) == n + 40
    np.testing.assert_array_equal(NEW.nodes[:n], OLD.nodes)
    old = (NEW.edges < n).all(axis=1)
    kept = {tuple(edge): row for row, edge in enumerate(NEW.edges.tolist())}
    rows = [kept[tuple(edge)] for edge in OLD.edges.tolist()]
    for name in ("proven", "joint_length", "tool_length", "clearance", "samples"):
        np.testing.assert_array_equal(getattr(NEW, name)[rows], getattr(OLD, name))
    assert m <= old.sum()
    assert NEW.starts.tolist() == OLD.starts.tolist()
    assert NEW.goals.tolist() == OLD.goals.tolist()
    assert NEW.origin == OLD.origin


def test_new_nodes_are_linked_by_proven_edges():
    assert NEW.connected
    assert NEW.component_count == 1
    assert NEW.proven.all()
    assert len(np.unique(NEW.nodes, axis=0)) == len(NEW.nodes)
    assert (NEW.edges[:, 0] < NEW.edges[:, 1]).all()
    assert (np.lexsort((NEW.edges[:, 1], NEW.edges[:, 0])) == np.arange(len(NEW.edges))).all()
    assert len(np.unique(NEW.edges, axis=0)) == len(NEW.edges) == round(100 * DENSITY)
    new = NEW.edges[(NEW.edges >= len(OLD.nodes)).any(axis=1)]
    assert len(new) >= 40
    for i, j in new:
        assert recheck(make_post(), NEW.nodes[i], NEW.nodes[j] - NEW.nodes[i]) is None


def test_measures_and_scale():
    assert NEW.scale == OLD.scale
    np.testing.assert_allclose(NEW.manipulability, manipulability(load("planar_2r"), NEW.nodes))
    for name, values in measure_edges(load("planar_2r"), NEW.nodes, NEW.edges, NEW.scale).items():
        np.testing.assert_allclose(getattr(NEW, name), np.asarray(values))
    before, after = build_network(OLD), build_network(NEW)
    assert before.node_cost is not None
    assert after.node_cost is not None
    np.testing.assert_array_equal(after.node_cost[: len(OLD.nodes)], before.node_cost)


def test_the_cost_to_go_only_falls():
    """More choice, the same costs: no path gets costlier."""
    from planner import gabf

    before, after = (gabf.oracle(build_network(each)) for each in (OLD, NEW))
    n = len(OLD.nodes)
    assert (after[:n] <= before + 1e-12).all()
    assert (after[:n] < before - 1e-6).any()


def test_seeds():
    again = extend(OLD, make_post(), 40)
    assert again.sha256 == NEW.sha256
    assert extend(OLD, make_post(), 40, seed=7).sha256 != NEW.sha256
    # the seed that it was grown with would draw the same samples: the default never is that one
    assert extend(OLD, make_post(), 40, seed=OLD.origin.seed).sha256 != NEW.sha256


def test_twice_is_not_the_same_nodes_twice():
    twice = extend(NEW, make_post(), 40)
    assert len(np.unique(twice.nodes, axis=0)) == len(OLD.nodes) + 80


def test_a_denser_roadmap_stays_dense():
    dense = build_roadmap(make_post().robot, make_post(), OLD.nodes[0], OLD.nodes[1], 30, density=4.0)
    assert len(dense.edges) == 120
    assert len(extend(dense, make_post(), 10).edges) == 160


def test_two_parts_grow_both_and_may_meet():
    beyond = np.min(OLD.nodes[OLD.edges, 0], axis=1) > 0
    parted = OLD.part(np.ones(len(OLD.nodes), dtype=bool), beyond)
    assert not parted.connected
    more = extend(parted, make_post(), 60)
    assert more.component_count < parted.component_count
    assert more.connected


def test_stop_keeps_what_there_is():
    heard = []
    some = extend(OLD, make_post(), 500, progress=Progress(lambda *args: heard.append(args), lambda: len(heard) > 20))
    assert len(OLD.nodes) < len(some.nodes) < len(OLD.nodes) + 500
    assert verify(some, make_post()).complete
    nothing = extend(OLD, make_post(), 5, progress=Progress(stop=lambda: True))
    assert nothing.sha256 == OLD.sha256
    assert {stage for stage, _, _ in heard} == {"roadmap"}


def test_less_than_one_node():
    with pytest.raises(OptionError, match="0 nodes are no extension"):
        extend(OLD, make_post(), 0)


def test_a_smaller_margin_is_the_weaker_of_the_two():
    careful = make_checker(load("planar_2r"), make_post().world.scene, margin=0.02)
    old = build_roadmap(load("planar_2r"), careful, [-1.0, 0.8], [1.0, -0.8], 30)
    new = extend(old, make_post(), 20)
    assert new.origin.margin == 0.0
    rows = [new.edge_index(i, j) for i, j in old.edges]
    np.testing.assert_allclose(new.clearance[rows], old.clearance + 0.02)
    same = extend(old, careful, 20)
    assert same.origin.margin == 0.02


def test_an_arm_among_obstacles():
    plan = small_plan()
    more = extend(plan.roadmap, plan.checker, 30)
    assert len(more.nodes) == 180
    assert measures_hold(more, plan.robot)
    fresh = (more.edges >= 150).any(axis=1)
    a, b = more.nodes[more.edges[fresh, 0]], more.nodes[more.edges[fresh, 1]]
    assert EdgeProver(plan.checker).prove(a, plan.robot.difference(a, b)).free.all()
