"""What a roadmap keeps of its edges."""

import logging
from dataclasses import replace

import numpy as np
import pytest

from planner.base.resolutions import W_STATES_PER_EDGE
from planner.collision import make_checker
from planner.collision.world import Contact
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.roadmap.build import build_roadmap
from planner.roadmap.connect_endpoints import attach
from planner.roadmap.measure import check_nodes, measure_edges
from planner.robot.scene import Scene
from tests.worlds import load, make_post, post_roadmap, small_plan


def test_edge_manipulability_is_w_from_end_to_end() -> None:
    robot, rng = load("iiwa14"), np.random.default_rng(1)
    nodes = rng.uniform(robot.lower, robot.upper, (4, 7))
    edges = np.array([[0, 1], [2, 3]])
    w = measure_edges(robot, nodes, edges, small_plan().roadmap.scale)["edge_manipulability"]
    assert w.shape == (2, W_STATES_PER_EDGE)
    np.testing.assert_allclose(w[:, 0], manipulability(robot, nodes[[0, 2]]))
    np.testing.assert_allclose(w[:, -1], manipulability(robot, nodes[[1, 3]]), rtol=1e-9)


@pytest.mark.parametrize("name", ["planar_2r", "iiwa14", "kinova"])
def test_edge_lengths_against_a_plain_sum(name):
    robot, rng = load(name), np.random.default_rng(0)
    nodes = rng.uniform(robot.lower, robot.upper, size=(8, robot.dof))
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 7], [0, 7], [4, 4], [5, 6]])
    scale = small_plan().roadmap.scale
    measured = measure_edges(robot, nodes, edges, scale)
    joint, tool = measured["joint_length"], measured["tool_length"]
    for (i, j), ours, way in zip(edges, joint, tool, strict=True):
        delta = robot.difference(nodes[i], nodes[j])
        assert ours == pytest.approx(np.linalg.norm(delta))
        fine = tool_positions(robot, nodes[i] + np.linspace(0, 1, 2001)[:, None] * delta)
        assert way == pytest.approx(np.linalg.norm(np.diff(fine, axis=0), axis=1).sum(), rel=2e-3, abs=1e-12)
    empty = measure_edges(robot, nodes, np.zeros((0, 2), dtype=int), scale)
    assert {name: len(np.asarray(values)) for name, values in empty.items()} == dict.fromkeys(measured, 0)


class Strict:
    """A checker that finds fault with configurations whose first joint is beyond a value, whatever is true."""

    def __init__(self, inner, beyond: float) -> None:
        self._inner, self._beyond, self.asked = inner, beyond, 0

    def __getattr__(self, name: str):
        return getattr(self._inner, name)

    def first_contact(self, q):
        q = np.atleast_2d(q)
        self.asked += len(q)
        rows = np.flatnonzero(q[:, 0] > self._beyond)
        return (int(rows[0]), Contact("link_2", "post")) if len(rows) else None


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_the_library_that_was_asked_for_checks_every_node(backend: str) -> None:
    robot = load("planar_2r")
    checker = make_checker(robot, Scene.load("cage"), backend)
    asked = []
    real = checker.first_contact
    checker.first_contact = lambda q: asked.append(np.atleast_2d(q).copy()) or real(q)
    roadmap = build_roadmap(robot, checker, [0.0, 0.6], [2.0, 0.6], 40)
    seen = {q.tobytes() for rows in asked for q in rows}
    assert all(q.tobytes() in seen for q in roadmap.nodes)
    assert roadmap.nodes_checked == {"fcl": 0, "coal": 0} | {backend: len(roadmap.nodes)}


def test_a_node_that_the_library_refuses_is_left_out_and_said(caplog: pytest.LogCaptureFixture) -> None:
    roadmap = replace(post_roadmap(), checked_by=np.zeros(60, dtype=np.int8))
    limit = float(np.sort(np.delete(roadmap.nodes[:, 0], [0, 1]))[-3])
    checker = Strict(make_post(), limit)
    with caplog.at_level(logging.WARNING):
        left = check_nodes(roadmap, checker)
    refused = int((roadmap.nodes[:, 0] > limit).sum())
    assert refused >= 2
    assert len(left.nodes) == 60 - refused
    assert (left.nodes[:, 0] <= limit).all()
    assert len(left.edges) == int((roadmap.nodes[roadmap.edges, 0] <= limit).all(axis=1).sum())
    assert len(caplog.messages) == refused
    assert all("node removed: by fcl, 'link_2' and 'post' touch there" in text for text in caplog.messages)
    assert left.nodes_checked["fcl"] == len(left.nodes)


def test_a_query_has_its_new_nodes_checked_only() -> None:
    checker = Strict(make_post(), np.inf)
    found = attach(post_roadmap(), checker, np.array([[-0.9, 0.9]]), np.array([[0.9, -0.9]]))
    assert found.nodes_checked["fcl"] == len(found.nodes)
    # the two ends are asked for once more when they are resolved
    assert checker.asked == len(found.nodes) - 60 + 2
