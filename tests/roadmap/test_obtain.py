"""The roadmap that a request names: grown, or loaded and linked."""

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.kinematics.manipulability import manipulability
from planner.problem.request import PlanRequest
from planner.query.query import make_query
from planner.roadmap.build import build_roadmap
from planner.roadmap.load_or_build import load_or_build_roadmap, reprove, reprove_in_other_world
from planner.roadmap.storage import same_world, save_roadmap
from planner.robot.poses import pose
from planner.robot.robot import Robot, with_carried
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Carried, Obstacle, Sphere
from tests.coal_judge import CoalWorld
from tests.random_shapes import box_mesh
from tests.worlds import load, make_post, post_roadmap

REQUEST = PlanRequest.from_options(
    robot=load("planar_2r"), scene=make_post().world.scene, start="q:-1,0.8", goal="q:1,-0.8", nodes=40, seed=3
)


def test_without_a_file_it_is_grown_as_the_request_says() -> None:
    query = make_query(REQUEST.what)
    direct = build_roadmap(query.robot, query.checker, query.starts, query.goals, 40, 3)
    assert load_or_build_roadmap(REQUEST.quality, query).sha256 == direct.sha256


def test_a_kept_one_gets_the_querys_ends(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    save_roadmap(post_roadmap(), tmp_path / "kept.npz")
    request = REQUEST.with_options(roadmap=tmp_path / "kept.npz", start="q:-1.1,0.7")
    query = make_query(request.what)
    found = load_or_build_roadmap(request.quality, query)
    np.testing.assert_array_equal(found.nodes[found.starts], query.starts)
    np.testing.assert_array_equal(found.nodes[found.goals], query.goals)
    np.testing.assert_array_equal(found.nodes[: len(post_roadmap().nodes)], post_roadmap().nodes)
    assert found.is_connected
    assert ("--nodes is not followed" in caplog.text) == (len(post_roadmap().nodes) != request.quality.nodes)
    load_or_build_roadmap(request.with_options(nodes=41).quality, query)
    assert "--nodes is not followed" in caplog.text


def test_of_a_file_of_another_world_the_edges_that_hold_are_used(tmp_path: Path) -> None:
    save_roadmap(post_roadmap(), tmp_path / "kept.npz")
    request = REQUEST.with_options(roadmap=tmp_path / "kept.npz", scene="empty")
    query = make_query(request.what)
    found = load_or_build_roadmap(request.quality, query)
    assert same_world(found, query.checker)
    assert found.proven.all()
    assert len(found.edges) >= len(post_roadmap().edges)


OLD = post_roadmap()
POST, AT = Box((0.1, 0.02, 0.2)), pose([0.75, 0, 0])
BALL = Sphere(0.08), pose([-0.5, 0.5, 0])
FINGER = Carried("link_2", "finger", Sphere(0.05), pose([0.45, 0, 0]), ("link_2",))


def made(robot: Robot | None = None, margin=0.0, backend="fcl", **obstacles):
    items = tuple(Obstacle(name, shape, place) for name, (shape, place) in obstacles.items())
    return make_checker(robot or load("planar_2r"), Scene("made", items), backend, margin)


WORLDS = {
    "moved": lambda: made(thing0=(POST, pose([0.7, 0.1, 0]))),
    "added": lambda: made(thing0=(POST, AT), ball=BALL),
    "removed": lambda: made(),
    "a mesh added": lambda: made(thing0=(POST, AT), slab=(box_mesh((0.02, 0.3, 0.2)), pose([-0.2, -0.7, 0]))),
    "a larger margin": lambda: made(thing0=(POST, AT), margin=0.01),
    "something carried": lambda: made(with_carried(load("planar_2r"), [FINGER]), thing0=(POST, AT)),
    "another base": lambda: made(Robot.load("planar_2r", base=pose([0.1, 0, 0])), thing0=(POST, AT)),
    "by coal": lambda: made(thing0=(POST, pose([0.7, 0.1, 0])), backend="coal"),
}


def keys(nodes: np.ndarray, edges: np.ndarray) -> set[tuple[bytes, bytes]]:
    return {(nodes[i].tobytes(), nodes[j].tobytes()) for i, j in edges}


@pytest.mark.parametrize("name", WORLDS)
def test_edges_that_are_kept_are_free_in_coals_opinion_and_those_dropped_are_not(name):
    checker = WORLDS[name]()
    new, world = reprove(OLD, checker), CoalWorld(checker.world)
    for i, j, promised in zip(*new.edges.T, new.clearance, strict=True):
        delta = new.nodes[j] - new.nodes[i]
        assert world.nearest_along(new.nodes[i], delta, 0.02, 0.005) > checker.world.margin + promised - 1e-6
    np.testing.assert_array_equal(new.nodes, [q for q in OLD.nodes if is_free(checker, q)])
    dropped = keys(OLD.nodes, OLD.edges) - keys(new.nodes, new.edges)
    for a, b in dropped:
        start, end = np.frombuffer(a), np.frombuffer(b)
        assert world.nearest_along(start, end - start, 0.02, 0.005) < checker.world.margin + 2e-3
    assert new.proven.all()
    assert same_world(new, checker)


def test_in_its_own_world_it_stays_as_it_is_and_elsewhere_a_message_counts_edges(caplog):
    assert reprove_in_other_world(OLD, make_post()) is OLD
    assert caplog.text == ""
    with caplog.at_level(logging.DEBUG, "planner.notes"):
        part = reprove_in_other_world(OLD, WORLDS["added"]())
    assert f"{len(part.edges)} of {len(OLD.edges)} hold" in caplog.text


def test_a_world_is_the_same_to_the_bit_of_shapes_and_places_and_with_no_larger_margin():
    assert same_world(OLD, make_post())
    assert same_world(replace(OLD, origin=replace(OLD.origin, margin=0.02)), WORLDS["a larger margin"]())
    assert not same_world(OLD, made(thing0=(POST, pose([0.75 + 1e-9, 0, 0]))))
    for name in set(WORLDS) - {"by coal"}:
        assert not same_world(OLD, WORLDS[name]()), name
    robot = load("planar_2r")
    wider, narrower = (replace(robot, upper=robot.upper + step) for step in (0.1, -0.1))
    assert same_world(OLD, make_checker(wider, make_post().world.scene))
    assert not same_world(OLD, make_checker(narrower, make_post().world.scene))


def test_where_w_has_other_rows_it_is_measured_again():
    """Nothing else differs: such a roadmap would have the costs of another manipulability."""
    robot = load("planar_2r")
    other = replace(robot, jacobian_rows="pose" if robot.jacobian_rows != "pose" else "translation")
    checker = make_checker(other, make_post().world.scene)
    assert not same_world(OLD, checker)
    part = reprove_in_other_world(OLD, checker)
    assert len(part.edges) == len(OLD.edges)
    np.testing.assert_allclose(part.manipulability, manipulability(other, part.nodes), rtol=1e-9)


def test_once_stopped_the_rest_is_dropped_as_unproven():
    done = []
    progress = Progress(lambda *report: done.append(report), lambda: bool(done))
    part = reprove(OLD, make_post(), progress)
    assert 0 <= len(part.edges) <= len(OLD.edges)
    assert part.proven.all()


def test_other_joints_or_no_node_left_are_refused():
    with pytest.raises(FileError, match=r"is for joints .*: build one for this robot"):
        reprove(OLD, make_checker(load("ur5"), Scene("none")))
    with pytest.raises(FileError, match="no node of the roadmap is free"):
        reprove(OLD, made(all=(Sphere(9.0), pose([0, 0, 0]))))
