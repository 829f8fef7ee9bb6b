"""Edges called free really are, edges called colliding really do: looked at again densely, by FCL and by coal."""

import tempfile
from dataclasses import replace
from pathlib import Path

import coal
import numpy as np
import pytest

from planner.base.progress import QUIET, Progress
from planner.collision import BACKENDS, make_checker
from planner.collision.checker import is_free
from planner.collision.coal import CoalChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.fcl import FclChecker
from planner.collision.recheck import sample_contacts, straight
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.files.robot_files import read_robot
from planner.robot.poses import pose
from planner.robot.robot import Robot, assemble
from planner.robot.scene import Scene
from planner.robot.shapes import Body, Box, Capsule, Mesh, Sphere
from tests.coal_judge import CoalWorld, coal_geometry, coal_transform
from tests.random_shapes import FCL_AT_ITS_WORST, box_mesh
from tests.robot.test_solids import box as closed_box
from tests.worlds import UR3, body, joint_xml, link_xml, load, scene_of


def edges_of(robot: Robot, n: int, seed: int, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Random segments of about ``length`` (rad) within limits."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(robot.lower, robot.upper, size=(n, robot.dof))
    step = rng.normal(size=(n, robot.dof)) * length / np.sqrt(robot.dof)
    return start, np.clip(start + step, robot.lower, robot.upper) - start


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("kind", ["box", "mesh"])
@pytest.mark.parametrize("thickness", [0.001, 0.002, 0.005])
def test_no_edge_through_a_wall_is_free(kind, thickness, backend):
    """planar_2r swings through a thin wall that stands anywhere across its way; a look at 2 cm would miss most."""
    robot, rng = load("planar_2r"), np.random.default_rng(int(1e4 * thickness))
    for _ in range(12):
        angle, far = rng.uniform(0.3, 1.2), rng.uniform(0.3, 0.8)
        size = (0.2, thickness, 0.5)
        place = pose([far * np.cos(angle), far * np.sin(angle), 0], [0, 0, angle])
        scene = scene_of((Box(size) if kind == "box" else box_mesh(size), place))
        prover = EdgeProver(make_checker(robot, scene, backend))
        bend = rng.uniform(-0.05, 0.05)
        start, delta = np.array([[0.0, bend]]), np.array([[1.5, rng.uniform(-0.1, 0.1)]])
        verdict = prover.prove(start, delta).verdict[0]
        assert verdict == Verdict.COLLIDES
        back = prover.prove(start + delta, -delta).verdict[0]
        assert back == Verdict.COLLIDES


def needle(shape, place, joint=2) -> Robot:
    return replace(load("planar_2r"), bodies=(replace(body(shape, place), joint=joint),))


# what FCL gets wrong must not get into a proof


def pushed(first, second, place) -> tuple[World, float]:
    """``first`` on a slide that pushes it towards ``second`` at ``place``, and their true distance."""
    result = coal.DistanceResult()
    shapes = coal_geometry(first), coal_transform(np.eye(4)), coal_geometry(second), coal_transform(place)
    true = coal.distance(*shapes, coal.DistanceRequest(), result)
    towards = (result.getNearestPoint2() - result.getNearestPoint1()) / true
    robot = sliding_robot(" ".join(repr(float(v)) for v in towards))
    robot = replace(robot, bodies=(replace(body(first), joint=1),))
    return World.from_scene(robot, scene_of((second, place)), frozenset()), true


def sliding_robot(axis: str) -> Robot:
    inside = link_xml("a") + link_xml("b") + link_xml("c")
    inside += joint_xml("slide", "a", "b", "prismatic", axis) + joint_xml("turn", "b", "c")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "slide.urdf"
        path.write_text(f'<robot name="slide">{inside}</robot>')
        return Robot.load(str(path))


@pytest.mark.parametrize("kind", [FclChecker, CoalChecker])
@pytest.mark.parametrize("case", FCL_AT_ITS_WORST, ids=lambda case: "-".join(type(s).__name__ for s in case[:2]))
def test_an_edge_into_an_obstacle_is_not_free(case, kind):
    world, true = pushed(*case)
    prover, judge, verdicts = EdgeProver(kind(world)), CoalWorld(world), []
    assert judge.distances(np.zeros(2))[0] == pytest.approx(true, abs=1e-6)
    for push in np.arange(true + 1e-3, 0.014, 5e-4):  # at least 1 mm into the obstacle, at the end
        end = np.array([push, 0.0])
        assert judge.distances(end)[0] < 0
        verdicts.append(prover.prove(-end, 2 * end).verdict[0])
    assert Verdict.FREE not in verdicts


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_edge_into_a_plate_of_two_triangles_is_not_free(backend):
    """Link 1 touches from 58 % of the way on; FCL put the two 3 mm apart half way, where 0.37 mm were left."""
    corners = np.array([[-0.55, -0.4, 0.0], [0.55, -0.4, 0.0], [0.55, 0.4, 0.0], [-0.55, 0.4, 0.0]])
    place = np.eye(4)
    place[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    place[:3, 3] = -0.1337, -0.8946, -0.5508
    plate = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    checker = make_checker(load("planar_2r"), scene_of((plate, place)), backend)
    start, delta = np.array([-1.774693515499277, 0.51]), np.array([-0.010612969001446097, 0.0])
    assert is_free(checker, start + 0.5 * delta)
    assert not is_free(checker, start + 0.6 * delta)
    assert EdgeProver(checker).prove(start, delta).verdict[0] == Verdict.COLLIDES


# margin


def ball_and_wall(gap: float, margin: float = 0.0) -> EdgeProver:
    """A ball of 10 cm at planar_2r's end that sweeps past a ball of 10 cm, ``gap`` away at the nearest."""
    robot = needle(Sphere(0.1), pose([0.4, 0, 0]))
    post = scene_of((Sphere(0.1), pose([0.9 + 0.2 + gap, 0, 0])))
    return EdgeProver(make_checker(robot, post, margin=margin))


@pytest.mark.parametrize(
    ("gap", "margin", "verdict"),
    [
        (0.002, 0.0, Verdict.FREE),
        (-0.002, 0.0, Verdict.COLLIDES),
        (0.012, 0.01, Verdict.FREE),
        (0.008, 0.01, Verdict.COLLIDES),
        (1e-6, 0.0, Verdict.UNDECIDED),
    ],
)
def test_the_gap_of_a_sweep_decides(gap, margin, verdict):
    prover = ball_and_wall(gap, margin)
    assert prover.prove(np.array([[-0.6, 0.0]]), np.array([[1.3, 0.0]])).verdict[0] == verdict


# what a proof says about itself


def test_no_wall_that_the_tip_of_a_folding_arm_crosses_is_called_clear():
    """The tip is near the first axis and swings out: the bound must hold until it is out."""
    robot, rng, proven = load("planar_2r"), np.random.default_rng(0), 0
    last = next(body for body in robot.bodies if body.joint == 2)
    arm = replace(robot, bodies=(replace(last, shape=Sphere(1e-3), placement=pose([0.5, 0, 0])),))
    for _ in range(25):
        start = np.array([rng.uniform(-2.5, 2.5), rng.choice([-1, 1]) * rng.uniform(2.0, 2.9)])
        delta = rng.uniform(-1.0, 1.0, 2) * rng.uniform(0.2, 1.2)
        angle = np.cumsum(start + np.linspace(0, 1, 401)[:, None] * delta, axis=1)
        tip = 0.5 * np.column_stack([np.cos(angle).sum(axis=1), np.sin(angle).sum(axis=1), 0 * angle[:, 0]])
        towards = rng.choice([1, -1]) * (tip[-1] - tip[0]) + rng.normal(scale=0.1, size=3) * [1, 1, 0]
        normal = towards / np.linalg.norm(towards)
        for beyond in (-0.03, -0.01, 1e-6, 0.003, 0.01, 0.03):
            middle = ((tip @ normal).max() + 1e-3 + beyond + 0.5) * normal
            place = pose(middle, rpy=[0.0, 0.0, float(np.arctan2(normal[1], normal[0]))])
            checker = make_checker(arm, scene_of((Box((1.0, 6.0, 6.0)), place)))
            proofs = EdgeProver(checker).prove(start[None], delta[None])
            if proofs.free[0]:
                assert proofs.clearance[0] <= beyond + 1e-9
                proven += 1
    assert proven > 60


def test_one_after_the_other_nothing_is_overlooked():
    a, b = np.array([0.3, 0.4]), np.array([0.2, -0.1])

    def is_free(scene: Scene, progress: Progress = QUIET, constraint: str = "") -> bool:
        return EdgeProver(make_checker(load("planar_2r"), scene, constraint=constraint), progress).each_free()(a, b)

    base = scene_of((Box((0.1, 0.1, 0.1)), np.eye(4)))
    assert is_free(Scene("empty"))
    assert not is_free(Scene("empty"), Progress(stop=lambda: True))
    assert not is_free(scene_of((closed_box(8.0), np.eye(4))))  # wholly inside
    assert not is_free(base)  # what no joint can move
    assert not is_free(Scene("empty"), constraint="box:5,5,5,6,6,6")
    assert not EdgeProver(make_checker(load("planar_2r"), Scene("empty"))).each_free()(a, np.array([np.nan, 0.0]))


# special edges


@pytest.mark.parametrize("margin", [0.0, 0.02])
def test_a_base_in_contact_refuses_every_edge(margin):
    gap = 0.01 if margin else -0.01
    table = scene_of((Box((1, 1, 0.1)), pose([0, 0, -0.05 - gap])))
    checker = make_checker(load("iiwa14"), table, margin=margin)
    prover = EdgeProver(checker)
    assert (prover.static_contact.first, prover.static_contact.second) == ("iiwa14_link_0", "thing0")
    q = np.zeros((3, 7))
    assert (prover.prove(q, q + 0.1).verdict == Verdict.COLLIDES).all()
    assert not is_free(checker, q[0])


def test_continuous_joints_take_the_short_way():
    """From 3.0 to -3.0 rad a continuous joint turns by 0.28 rad, past pi: a wall opposite is not in its way."""
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>'
    second = joint_xml("k", "b", "c")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "turn.urdf"
        path.write_text(f'<robot name="t">{link_xml("a")}{link_xml("b")}{link_xml("c")}{joint}{second}</robot>')
        robot = Robot.load(str(path))
    arm = replace(robot, bodies=(replace(body(Capsule(0.01, 0.5), pose([0.3, 0, 0], [0, np.pi / 2, 0])), joint=1),))
    ahead, behind = (pose([x, 0, 0]) for x in (0.4, -0.4))
    a, b = np.array([3.0, 0]), np.array([-3.0, 0])
    for place, verdict in ((ahead, Verdict.FREE), (behind, Verdict.COLLIDES)):
        prover = EdgeProver(FclChecker(World.from_scene(arm, scene_of((Box((0.1, 0.002, 0.1)), place)), frozenset())))
        assert prover.prove(a, arm.difference(a, b)).verdict[0] == verdict
        assert prover.prove(b, arm.difference(b, a)).verdict[0] == verdict


def test_curves_that_are_cleared_together_are_not_free_where_joints_work_against_each_other():
    """Along one diagonal of a box of configurations a folded arm's tip may stand still; they go along another."""
    robot, rng, some = load("planar_2r"), np.random.default_rng(5), 0
    arm = replace(robot, bodies=(replace(robot.bodies[-1], shape=Sphere(1e-4), placement=pose([0.375, 0, 0])),))
    for _ in range(300):
        q, delta = rng.uniform([-1.5, 2.2], [1.5, 3.0]), rng.uniform([0.0, -0.1], [0.1, 0.0])
        turn, shift = joint_placements(Chain.from_arm(arm), (q + 2.0 * delta)[None])
        end = turn[2, 0] @ np.array([0.375, 0.0, 0.0]) + shift[2, 0]
        checker = make_checker(arm, scene_of((Sphere(1e-4), pose(end.tolist()))))
        prover, pieces = EdgeProver(checker), np.stack([np.stack([q, delta]), np.stack([q + delta, delta])])
        if sample_contacts(checker, pieces[:1], 1e-3) is None:
            some += 1
            assert not prover.all_free(pieces)
    assert some > 200


# which of several motions are proven


def test_a_slide_beyond_its_limits_is_not_proven(urdf_file) -> None:
    """Reaches hold within the limits: a motion 3 m out, where it may go 0.1, was called free through an obstacle."""
    arm = "".join(map(link_xml, "ab")) + link_xml("c", '<sphere radius="0.05"/>')
    arm += joint_xml("j", "a", "b", limit="-3 3") + joint_xml("k", "b", "c", "prismatic", "1 0 0", limit="-0.1 0.1")
    robot = Robot.load(urdf_file(arm))
    for angle in np.linspace(-0.2, 0.2, 9):
        at = pose([3 * np.cos(angle), 3 * np.sin(angle), 0])
        prover = EdgeProver(make_checker(robot, scene_of((Sphere(0.2), at))))
        swing = np.array([[[-1.0, 3.0], [2.0, 0.0]]])
        assert prover.prove(swing[:, 0], swing[:, 1]).verdict.tolist() == [Verdict.UNDECIDED]
        assert not prover.prove_curves(swing).free.any()
        assert not prover.all_free(swing)
        within = np.array([[[-1.0, -0.1], [2.0, 0.2]], [[-1.0, 0.1], [2.0, 0.0]]])
        assert prover.prove_curves(within).free.all()
        assert prover.all_free(within)


def test_a_body_that_is_one_point_of_the_next_joint_has_the_reach_of_the_one_beyond(urdf_file) -> None:
    arm = "".join(map(link_xml, "abcd")) + joint_xml("j", "a", "b")
    arm += joint_xml("k", "b", "c", xyz="1 0 0", limit="-3 3") + joint_xml("l", "c", "d", xyz="1 0 0", limit="-3 3")
    robot = Robot.load(urdf_file(arm), tool="d")
    point = Body("p", "b", 1, Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])), pose([1.0, 0, 0]))
    bar = Body("s", "d", 3, Box((3.0, 0.01, 0.01)), pose([-0.5, 0.5, 0]))
    checker = make_checker(replace(robot, bodies=(point, bar)), Scene("none"), margin=1e-3)
    assert checker.world.pair_reach[0, 2] > 0.99
    for start, free in ((-1.0, True), (0.0, False), (0.5, False)):
        found = EdgeProver(checker).prove(np.array([[0.0, 0.0, start]]), np.array([[0.0, 0.0, 0.6]]))
        assert found.free.tolist() == [free]
        assert not free or found.clearance[0] < 0.8844


@pytest.mark.parametrize("c", [0.0, 2.6e-162, 2.7e-162, 1e-155, 1e-3])
def test_a_direction_whose_square_is_no_number_separates_nothing(urdf_file, c: float) -> None:
    """The middles of two shapes nearly coincide: the length of the way between them came out too short."""
    corners = np.array([[1.0, -1, -1], [-1, 1, -1], [-1, -1, 1], [-1, -1, -1]])
    solid = Mesh(corners, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    arm = "".join(map(link_xml, "abc")) + joint_xml("j", "a", "b") + joint_xml("k", "b", "c")
    robot = replace(Robot.load(urdf_file(arm)), bodies=(Body("body", "b", 1, solid, np.eye(4)),))
    checker = make_checker(robot, scene_of((Sphere(1e-3), pose([c, c, c]))), margin=0.6)  # they are 0.576 m apart
    found = EdgeProver(checker).prove(np.zeros((1, 2)), np.array([[0.01, 0.0]]))
    assert found.verdict.tolist() == [Verdict.COLLIDES]


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_motion_proven_with_pieces_of_meshes_touches_no_complete_mesh(backend: str) -> None:
    """Looked at every millimetre by the other library, which knows the meshes before they are split."""
    files, scene, other = read_robot(UR3), Scene.load("table"), "coal" if backend == "fcl" else "fcl"
    split, whole = (assemble(replace(files, description=replace(files.description, pieces=k))) for k in (True, False))
    start = np.random.default_rng(11).uniform(-2.5, 2.5, size=(60, split.dof))
    delta = np.random.default_rng(12).uniform(-0.3, 0.3, size=start.shape)
    proofs, before = (EdgeProver(make_checker(each, scene, backend)).prove(start, delta) for each in (split, whole))
    free = proofs.free
    assert (free >= before.free).all()
    assert before.free.sum() >= 30
    assert proofs.samples[free].sum() < 0.8 * before.samples[free].sum()
    assert sample_contacts(make_checker(whole, scene, other), straight(start[free], delta[free]), 1e-3) is None
