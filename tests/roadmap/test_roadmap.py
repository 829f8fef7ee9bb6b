"""The roadmap as data: hash, components, edges that go."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from planner.collision.recheck import sample_segment
from planner.kinematics.manipulability import manipulability
from planner.roadmap.build import build_roadmap
from planner.roadmap.measure import measure_edges
from tests.worlds import load, make_post, post_roadmap, small_plan

ROADMAP = post_roadmap()


def changed(name):
    array = np.array(getattr(ROADMAP, name))
    if name == "nodes":
        array[7, 1] = np.nextafter(array[7, 1], 9)
    elif name == "proven":
        array[3] = False
    elif name == "edges":
        array = np.delete(array, 5, axis=0)
        return replace(ROADMAP.without_edge(5), edges=array)
    else:
        array = np.array([2])
    return replace(ROADMAP, **{name: array})


@pytest.mark.parametrize("name", ["nodes", "edges", "proven", "starts", "goals"])
def test_the_hash_minds_the_smallest_change(name):
    assert changed(name).sha256 != ROADMAP.sha256


@pytest.mark.parametrize("key", ["joints", "tool"])
def test_the_hash_minds_what_the_numbers_mean(key):
    value = ("a", "b") if key == "joints" else "other"
    assert replace(ROADMAP, origin=replace(ROADMAP.origin, **{key: value})).sha256 != ROADMAP.sha256


def test_the_hash_does_not_mind_versions_or_the_scale():
    other = replace(
        ROADMAP, origin=replace(ROADMAP.origin, versions={"ompl": "9"}, seed=5), scale=replace(ROADMAP.scale, zeta=0.5)
    )
    assert other.sha256 == ROADMAP.sha256


def test_one_seed_is_one_roadmap_and_two_are_two():
    again = build_roadmap(load("planar_2r"), make_post(), [-1.0, 0.8], [1.0, -0.8], 60, 0)
    assert again.sha256 == ROADMAP.sha256
    np.testing.assert_array_equal(again.nodes, ROADMAP.nodes)
    assert post_roadmap(seed=1).sha256 != ROADMAP.sha256
    assert len(ROADMAP.sha256) == 64


def test_connected_asks_for_some_start_and_some_goal():
    lonely = replace(ROADMAP, edges=ROADMAP.edges[:0], proven=[], joint_length=[], tool_length=[])
    assert ROADMAP.is_connected
    assert not lonely.is_connected
    assert lonely.component_count == 60
    assert replace(lonely, goals=lonely.starts).is_connected
    assert replace(lonely, starts=np.array([3, 4]), goals=np.array([9, 4])).is_connected
    assert not replace(lonely, starts=np.array([], dtype=int)).is_connected


def test_an_edge_is_found_from_either_end():
    for row, (i, j) in enumerate(ROADMAP.edges):
        assert ROADMAP.edge_index(i, j) == ROADMAP.edge_index(j, i) == row
    taken = {tuple(edge) for edge in ROADMAP.edges}
    absent = next((i, j) for i in range(60) for j in range(i + 1, 60) if (i, j) not in taken)
    with pytest.raises(KeyError):
        ROADMAP.edge_index(*absent)


def test_without_an_edge_the_rest_stays():
    row = 11
    less = ROADMAP.without_edge(row)
    for name in ("edges", "proven", "joint_length", "tool_length"):
        np.testing.assert_array_equal(getattr(less, name), np.delete(getattr(ROADMAP, name), row, axis=0))
    assert less.scale == ROADMAP.scale
    with pytest.raises(KeyError):
        less.edge_index(*ROADMAP.edges[row])


@pytest.mark.parametrize("which", ["planar_2r", "iiwa14"])
def test_what_it_says_about_itself_holds(which):
    """Every edge free at 1 mm of motion (some of iiwa14's), manipulability and lengths measured anew."""
    roadmap, checker = (ROADMAP, make_post()) if which == "planar_2r" else (small_plan().roadmap, small_plan().checker)
    robot = checker.robot
    np.testing.assert_allclose(roadmap.manipulability, manipulability(robot, roadmap.nodes))
    for name, values in measure_edges(robot, roadmap.nodes, roadmap.edges, roadmap.scale).items():
        np.testing.assert_allclose(getattr(roadmap, name), np.asarray(values))
    assert ((roadmap.nodes >= robot.lower) & (roadmap.nodes <= robot.upper)).all()
    for i, j in roadmap.edges[:: 1 if which == "planar_2r" else 15]:
        assert sample_segment(checker, roadmap.nodes[i], robot.difference(roadmap.nodes[i], roadmap.nodes[j])) is None


def test_as_a_networkx_graph():
    networkx = pytest.importorskip("networkx")
    graph = ROADMAP.to_networkx()
    assert networkx.number_connected_components(graph) == ROADMAP.component_count
    assert {tuple(sorted(edge)) for edge in graph.edges} == set(map(tuple, ROADMAP.edges.tolist()))
    for k, data in graph.nodes(data=True):
        np.testing.assert_array_equal(data["q"], ROADMAP.nodes[k])
        assert data["manipulability"] == pytest.approx(manipulability(load("planar_2r"), data["q"][None])[0])
    for i, j, data in graph.edges(data=True):
        row = ROADMAP.edge_index(i, j)
        assert data["certified"] is bool(ROADMAP.proven[row])
        assert (data["joint_length"], data["tool_length"]) == (ROADMAP.joint_length[row], ROADMAP.tool_length[row])
        w = manipulability(load("planar_2r"), np.linspace(ROADMAP.nodes[min(i, j)], ROADMAP.nodes[max(i, j)], 1001))
        assert w.min() - 1e-9 <= data["w_min"] <= min(w[0], w[-1]) + 1e-9
        assert data["w_min"] <= w.mean()
    for name in ("joint_length", "tool_length"):
        edges = (getattr(ROADMAP, name), ROADMAP.edges.T)
        lengths = dijkstra(coo_matrix(edges, shape=(len(ROADMAP.nodes),) * 2), directed=False, indices=0)
        found = networkx.single_source_dijkstra_path_length(graph, 0, weight=name)
        assert found == pytest.approx({k: length for k, length in enumerate(lengths) if np.isfinite(length)})
