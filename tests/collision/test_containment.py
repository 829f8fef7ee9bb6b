"""A shape wholly inside a mesh is a contact, for states, motions and paths, with either library."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planner.collision import BACKENDS, make_checker
from planner.collision.checker import CollisionChecker, contact_at, with_extra_margin
from planner.collision.containment import Containment
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.trajectory.measure import path_contact
from tests.robot.test_solids import box, together
from tests.worlds import joint_xml, link_xml, load, scene_of

ROOM = together(box(9.0), box(8.0, inward=True))
LIDLESS = Mesh(box(8.0).vertices, box(8.0).triangles[1:])


def planar(backend: str, shape: Shape, at: np.ndarray | None = None) -> CollisionChecker:
    return make_checker(load("planar_2r"), scene_of((shape, np.eye(4) if at is None else at)), backend)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("mesh", "at", "encloses"),
    [
        (box(8.0), None, True),
        (box(8.0, inward=True), None, True),
        (ROOM, None, False),  # the robot stands in the room, not in its walls
        (LIDLESS, None, False),  # nothing is inside of what is open
        (box(8.0), pose([20, 0, 0]), False),
    ],
    ids=["box", "box that faces inwards", "room", "open", "elsewhere"],
)
def test_a_robot_inside_a_mesh(backend: str, mesh: Mesh, at: np.ndarray | None, encloses: bool) -> None:
    checker = planar(backend, mesh, at)
    q, delta = np.array([0.3, 0.4]), np.array([0.2, -0.1])
    found = contact_at(checker, q)
    assert (found is not None) is encloses
    assert found is None or found.enclosed
    expected = Verdict.COLLIDES if encloses else Verdict.FREE
    proofs = EdgeProver(checker).prove(np.array([q, q]), np.array([delta, 0 * delta]))
    assert proofs.verdict.tolist() == [expected, expected]
    assert (path_contact(checker, np.array([q, q + delta])) is not None) is encloses


def test_all_pairs_names_every_pair_with_one_shape_inside_the_other() -> None:
    scene = scene_of((box(8.0), np.eye(4)), (box(9.0), pose([20, 0, 0])), (ROOM, np.eye(4)), (box(10.0), np.eye(4)))
    checker = make_checker(load("planar_2r"), scene)
    pairs = {checker.world.members(k) for k in checker.inside.all_pairs(np.array([[0.3, 0.4], [0.1, 0.2]])).tolist()}
    assert pairs == {(body, obstacle) for body in range(len(checker.world.bodies)) for obstacle in (0, 3)}
    bare = make_checker(load("planar_2r"), Scene("none"))
    assert not len(bare.inside.all_pairs(np.zeros((1, 2))))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    "what", [Box((0.1, 0.1, 0.1)), Sphere(0.05), Cylinder(0.05, 0.1), Capsule(0.03, 0.1), box(0.1)]
)
def test_an_obstacle_inside_a_link(backend: str, what: Shape, tmp_path: Path, urdf_file: Callable[..., str]) -> None:
    (tmp_path / "link.obj").write_text(_obj(box(0.6)))
    inside = link_xml("a") + link_xml("b", '<mesh filename="link.obj"/>', '<origin xyz="0.8 0 0"/>')
    robot = Robot.load(urdf_file(inside + joint_xml("j", "a", "b")))
    checker = make_checker(robot, scene_of((what, pose([0.8, 0.1, 0]))), backend)
    assert checker.first_touch(np.zeros((1, 1))) is None, "surfaces do not tell"
    found = checker.first_contact(np.array([[0.9], [-0.9], [0.0]]))
    assert (found[0], str(found[1]), found[1].enclosed) == (2, "'b' and 'thing0'", True)


# a finger of the hand inside a link of the arm, which FCL and coal both call free
@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("name", "q"),
    [("panda", [-2.53, -1.14, 0.87, -2.47, -0.73, 0.01, 2.39]), ("ur5", [-1.4, 0.38, 0.98, 1.86, -3.26, -0.43])],
)
def test_a_link_inside_another(backend: str, name: str, q: list[float]) -> None:
    checker = make_checker(load(name), Scene.load("empty"), backend)
    assert checker.first_touch(np.array([q])) is None
    found = contact_at(checker, np.array(q))
    assert found.enclosed


def test_an_allowed_pair_may_be_one_inside_the_other() -> None:
    robot, scene = load("planar_2r"), scene_of((box(8.0), np.eye(4)))
    links = {body.link for body in robot.bodies}
    allowed = frozenset(frozenset((link, "thing0")) for link in links)
    checker = make_checker(robot, Scene("made", scene.obstacles, allowed=allowed), "coal")
    assert contact_at(checker, np.zeros(2)) is None


def _obj(mesh: Mesh) -> str:
    lines = ["v {} {} {}".format(*row) for row in mesh.vertices]
    return "\n".join([*lines, *("f {} {} {}".format(*(row + 1)) for row in mesh.triangles)]) + "\n"


def test_with_more_clearance_the_same_pairs_have_their_new_numbers() -> None:
    """A hollow link swallows the hand; the base, which no joint moves, stands in a mesh of its own."""
    scene = scene_of((box(9.0), pose([20, 0, 0])), (box(6.0), np.eye(4)), (box(0.6), pose([0.7, 0, 0.5])))
    checker = make_checker(load("panda"), scene)
    wider = with_extra_margin(checker, 0.01)
    alone = Containment(wider.world, wider.chain)
    q = np.random.default_rng(0).uniform(checker.robot.lower, checker.robot.upper, (200, 7))
    np.testing.assert_array_equal(wider.inside.pairs(q), alone.pairs(q))
    np.testing.assert_array_equal(wider.inside.all_pairs(q), alone.all_pairs(q))
    assert len(alone.all_pairs(q)) < len(checker.inside.all_pairs(q)), "the base is left out"
