"""Errors of coal that must not come back: wrong verdicts, and verdicts that depend on earlier queries."""

from dataclasses import replace

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.checker import contact_at, is_free
from planner.collision.recheck import dense_states
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Mesh
from tests.coal_judge import CoalWorld
from tests.worlds import load, random_q, scene_of

# a capsule's axis, or a cylinder's cap, within 1e-6 m of the surface of what it is deep inside of
CAUGHT = [
    ("planar_2r", "shelf", [0.3033838000795752, 1.4372742769346543], -0.0249),
    ("planar_2r", "window", [2.3315949654361257, 0.02733209485857202], -0.0249),
    (
        "z1",
        "paper",
        [
            2.2261339488928846,
            2.5218086309759093,
            -0.14684909817975322,
            0.479593402145833,
            1.257143100783326,
            0.596307971,
        ],
        -1e-5,
    ),
]


@pytest.mark.parametrize(("robot", "scene", "q", "depth"), CAUGHT)
@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_a_state_deep_inside_is_not_free(robot: str, scene: str, q: list[float], depth: float, backend: str) -> None:
    checker = make_checker(load(robot), Scene.load(scene), backend)
    assert CoalWorld(checker.world).distances(np.array(q)).min() < depth
    assert not is_free(checker, np.array(q))
    assert not checker.bound.is_clear(np.array([q]))


def test_a_verdict_does_not_depend_on_earlier_questions() -> None:
    """7e-8 m inside a contact: asked in between random configurations, one by one and with others, always the same."""
    checker = make_checker(load("iiwa14"), Scene.load("cage"), "coal")
    q = np.array(
        [-2.35060193505, -1.40388306384, -1.80932300036, -0.74194653782, -1.10330449115, 1.02058439443, 1.0443870564]
    )
    others = random_q(load("iiwa14"), 200, seed=0)
    verdicts = set()
    for other in others:
        is_free(checker, other)
        verdicts.add(is_free(checker, q))
        verdicts.add(checker.first_touch(q[None]) is None)
    assert len(verdicts) == 1


PLATE = np.array([[0.2, -0.5, 0.0], [1.2, -0.5, 0.0], [1.2, 0.5, 0.0], [0.2, 0.5, 0.0]])


@pytest.mark.parametrize("triangles", [[[0, 1, 2], [0, 2, 3]]])
@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_a_level_plate_without_thickness_is_seen(triangles: list[list[int]], backend: str) -> None:
    """Coal's broadphase overlooks boxes without thickness, and its hull of flat meshes crashes."""
    robot = load("panda")
    q = random_q(robot, 300, seed=1)
    checker = make_checker(robot, scene_of((Mesh(PLATE, np.array(triangles)), pose([0.0, 0.0, 0.5]))), backend)
    plate = [pair for pair in range(len(checker.world.pair_reach)) if checker.world.is_scene_pair(pair)]
    truth = np.array([CoalWorld(checker.world).distances(row, plate).min() <= 0 for row in q])
    assert 5 < truth.sum() < 290
    rotation, position = joint_placements(checker.chain, q)
    for k, touching in enumerate(truth):
        if touching:
            assert not is_free(checker, q[k])
            assert checker.distances(rotation[:, k], position[:, k], np.array(plate)).min() <= 0


@pytest.mark.parametrize(("robot", "scene"), [("panda", "shelf"), ("iiwa14", "cage"), ("planar_2r", "window")])
def test_skipping_cleared_states_finds_the_same_first_contact(robot: str, scene: str) -> None:
    checker = make_checker(load(robot), Scene.load(scene), "coal", margin=0.002)
    touched = free = 0
    for seed, (a, b) in enumerate(random_q(load(robot), 60, seed=5).reshape(30, 2, -1)):
        short = (0.05 + 0.01 * seed) * (b - a)
        states, motion = dense_states(checker.world, a, short, 1e-3)
        every, found = checker.first_contact(states), checker.first_contact_along(states, motion)
        assert (every is None) == (found is None)
        if every is None or found is None:
            free += 1
            continue
        assert (found[0], str(found[1])) == (every[0], str(every[1]))
        touched += every[0] > 0
    assert touched >= 1
    assert free >= 2


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_a_checker_with_shared_shapes_answers_as_a_fresh_one(backend: str) -> None:
    first = make_checker(load("panda"), Scene.load("shelf"), backend)
    obstacles = first.world.obstacles
    moved = replace(obstacles[0], placement=pose([0.5, 0.1, 0.5]))
    scene = replace(first.world.scene, obstacles=(moved, *obstacles[2:]))
    world = World.from_scene(first.robot, scene, first.robot.disabled_pairs or frozenset())
    fresh, shared = type(first)(world), type(first)(world, first)
    del first
    q = random_q(load("panda"), 200, seed=2)
    placed = joint_placements(fresh.chain, q)
    np.testing.assert_array_equal(shared.bound.coarse(*placed), fresh.bound.coarse(*placed))
    for row in q:
        assert str(contact_at(shared, row)) == str(contact_at(fresh, row))


def moved(world: World, name: str, place: np.ndarray) -> World:
    obstacles = tuple(replace(o, placement=pose(place.tolist())) if o.name == name else o for o in world.obstacles)
    return replace(world, scene=replace(world.scene, obstacles=obstacles))
