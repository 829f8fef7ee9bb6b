"""Cells: the composite robot against its parts, by Pinocchio and coal on each part alone; refusals of files."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from planner.base.resources import scenes_folder
from planner.collision import make_checker
from planner.collision.world import World
from planner.robot.cell import Cell
from planner.robot.poses import pose
from planner.robot.robot import Robot, load_visuals, with_carried
from planner.robot.scene import Scene
from planner.robot.shapes import Capsule, Carried
from planner.trajectory.limits import KINDS, MotionLimits
from tests.coal_judge import CoalWorld, coal_distance, coal_geometry
from tests.refusals import refusal_of

TWO_ARMS = scenes_folder() / "examples" / "two-arms.yaml"
ROD = Carried("b_panda_hand_tcp", "rod", Capsule(0.01, 0.3), pose(), ("b_panda_hand",))


@pytest.fixture(scope="module")
def cell() -> Cell:
    """A Panda next to a UR5 without an SRDF of its own, a rod in the hand."""
    robots = {"b": Robot.load("panda"), "u": replace(Robot.load("ur5", base=pose([0.4, 0.1, 0])), disabled_pairs=None)}
    return Cell("mixed", robots, Scene("mixed", carried=(ROD,)))


def placements(robot: Robot, q: np.ndarray) -> dict[str, np.ndarray]:
    """The placement of each body by Pinocchio, on the model of ``robot`` alone."""
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    return {body.name: data.oMi[body.joint].homogeneous @ body.placement for body in robot.bodies}


def test_bodies_and_pictures_stand_where_those_of_the_parts_stand(cell: Cell) -> None:
    rng = np.random.default_rng(0)
    q = rng.uniform(cell.robot.lower, cell.robot.upper)
    whole = placements(cell.robot, q)
    for name, columns in cell.columns.items():
        alone = placements(cell.robots[name], q[columns])
        for body, placed in alone.items():
            assert np.allclose(whole.pop(cell.prefixes[name] + body), placed, atol=1e-12)
        prefix = cell.prefixes[name]
        assert [body.name for body in load_visuals(cell.robot) if body.name.startswith(prefix)] == [
            prefix + body.name for body in load_visuals(cell.robots[name])
        ]
    assert not whole


def test_every_pair_between_two_robots_is_checked_and_no_other_pair_is_added(cell: Cell) -> None:
    robot = with_carried(cell.robot, cell.scene.carried)
    world = make_checker(robot, cell.scene, "coal").world
    pairs = {frozenset(robot.bodies[k].link for k in pair) for pair in world.self_pairs.tolist()}
    for one, other in itertools.product(robot.bodies, robot.bodies):
        owners = {cell.owner(one.link), cell.owner(other.link)}
        if len(owners) == 2:
            assert (frozenset((one.link, other.link)) in pairs) == bool(one.joint or other.joint)
    for name, part in cell.robots.items():
        own = make_checker(part, Scene("none"), "coal").world
        expected = {
            frozenset(cell.prefixes[name] + part.bodies[k].link for k in pair) for pair in own.self_pairs.tolist()
        }
        assert expected == {
            pair for pair in pairs if {cell.owner(link) for link in pair} == {name} and "rod" not in pair
        }


def test_distances_between_robots_are_those_of_coal_on_each_robot_alone(cell: Cell) -> None:
    robot, rng = with_carried(cell.robot, cell.scene.carried), np.random.default_rng(1)
    checker = make_checker(robot, cell.scene, "coal")
    world, touched = checker.world, 0
    shapes = {body.name: coal_geometry(body.shape) for part in cell.robots.values() for body in part.bodies}
    for q in rng.uniform(robot.lower, robot.upper, (60, robot.dof)):
        least = np.inf
        (one, two), columns = cell.robots.values(), list(cell.columns.values())
        at, to = placements(one, q[columns[0]]), placements(two, q[columns[1]])
        for first, second in itertools.product(one.bodies, two.bodies):
            if first.joint or second.joint:
                least = min(
                    least, coal_distance(shapes[first.name], at[first.name], shapes[second.name], to[second.name])
                )
        bare = world_between(world, cell)
        contact = type(checker)(bare, checker).first_contact(q[None])
        assert (contact is not None) == (least <= 0) or abs(least) < 1e-3
        touched += least <= 0
    assert 0 < touched < 60


def world_between(world: World, cell: Cell) -> World:
    """The pairs of links of two different robots only."""
    bodies = world.robot.bodies
    between = [
        "rod" not in (bodies[i].link, bodies[k].link) and cell.owner(bodies[i].link) != cell.owner(bodies[k].link)
        for i, k in world.self_pairs.tolist()
    ]
    return world.only(np.concatenate([np.zeros(world.checked.size, dtype=bool), between]))


def test_manipulability_is_the_least_of_the_parts(cell: Cell) -> None:
    q = np.random.default_rng(2).uniform(cell.robot.lower, cell.robot.upper, (20, cell.robot.dof))
    parts = [cell.robots[name].manipulability(q[:, columns]) for name, columns in cell.columns.items()]
    assert np.allclose(cell.robot.manipulability(q), np.min(parts, axis=0))
    assert 0 < np.argmin(parts, axis=0).sum() < 20


def test_limits_are_those_of_the_parts(cell: Cell) -> None:
    whole = MotionLimits.from_robot(cell.robot)
    for name, columns in cell.columns.items():
        own = MotionLimits.from_robot(cell.robots[name])
        for kind in KINDS:
            assert np.array_equal(getattr(whole, kind)[columns], getattr(own, kind))
    assert not whole.is_given("acceleration")  # the UR5's is assumed


def test_a_file_gives_robots_states_and_the_scene_of_each() -> None:
    cell = Cell.load(TWO_ARMS)
    assert cell.robot.states["here"] == tuple(float(x) for x in 2 * (0.7, 0.5, 0, -1.7, 0, 2.2, 0.8))
    alone = cell.scene_of("left")
    assert [item.name for item in alone.obstacles] == ["table", "tower", "right_panda_link0_0"]
    assert np.allclose(alone.obstacles[-1].placement, cell.robots["right"].bodies[0].placement)
    assert (cell.owner("right_panda_link3"), cell.owner("tower")) == ("right", None)
    distances = CoalWorld(make_checker(cell.robot, cell.scene, "coal").world).distances(cell.robot.home)
    assert (distances > 0).all()


TEXT = TWO_ARMS.read_text()
ROBOT = "right: {robot: panda"
REFUSED = {
    "no robot": (TEXT.partition("robots:")[2], " {}\n", "'robots'"),
    "one spot": ("[0.5, 0, 0], rpy", "[-0.5, 0, 0], rpy", "must stand apart, got both at (-0.5, 0, 0)"),
    "one prefix": ("{robot: panda, ", "{robot: panda, prefix: arm_, ", "prefixes must differ, got 'arm_'"),
    "no such robot": (ROBOT, "right: {robot: pandaa", "robot 'right' of cell file"),
    "unknown key": (ROBOT, "right: {model: panda", "unknown key 'robots.right.model'"),
    "states of no robot": ("  right:\n", "  rihgt:\n", "states of 'rihgt' belong to no robot: robots are left, right"),
    "a plain scene": ("robot: panda, ", "", "'robots.left.robot' is missing"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_files_get_one_sentence(case: str, tmp_path: Path) -> None:
    old, new, words = REFUSED[case]
    file = tmp_path / "cell.yaml"
    file.write_text(TEXT.replace(old, new))
    assert words in refusal_of(lambda: Cell.load(file))


def test_names_that_prefixes_make_equal_are_refused() -> None:
    arm = Robot.load("planar_2r")
    cell = Cell("c", {"a": arm, "b": replace(arm, base=pose([1, 0, 0]))}, prefixes={"a": "", "b": "x"})
    assert cell.robot.dof == 4
    other = Cell("c", {"a": cell.robot, "b": replace(cell.robot, base=pose([1, 0, 0]))}, prefixes={"a": "x", "b": ""})
    assert "must keep names apart" in refusal_of(lambda: other.robot)
