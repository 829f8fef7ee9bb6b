"""The roadmap as data: hash, components, edges that go."""

from dataclasses import replace

import numpy as np
import pytest

from planner.base.resources import versions
from planner.collision.looks import recheck
from planner.kinematics.manipulability import manipulability
from planner.roadmap.build import build_roadmap
from planner.roadmap.measure import measure_edges
from planner.roadmap.roadmap import origin_of
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


def test_the_hash_minds_neither_memory_order_nor_integer_width():
    other = replace(ROADMAP, nodes=np.asfortranarray(ROADMAP.nodes), edges=ROADMAP.edges.astype(np.int32))
    assert other.sha256 == ROADMAP.sha256


def test_connected_asks_for_some_start_and_some_goal():
    lonely = replace(ROADMAP, edges=ROADMAP.edges[:0], proven=[], joint_length=[], tool_length=[])
    assert ROADMAP.connected
    assert not lonely.connected
    assert lonely.component_count == 60
    assert replace(lonely, goals=lonely.starts).connected
    assert replace(lonely, starts=np.array([3, 4]), goals=np.array([9, 4])).connected
    assert not replace(lonely, starts=np.array([], dtype=int)).connected


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
        assert recheck(checker, roadmap.nodes[i], robot.difference(roadmap.nodes[i], roadmap.nodes[j])) is None


def test_origin_tells_what_it_was_made_for():
    origin = ROADMAP.origin
    assert origin == origin_of(make_post(), 0)
    assert (origin.robot, origin.scene, origin.tool, origin.margin, origin.seed) == ("planar_2r", "made", "tool", 0, 0)
    assert origin.joints == ("joint_1", "joint_2")
    assert {"ompl", "pin", "python-fcl", "numpy"} <= set(versions())
