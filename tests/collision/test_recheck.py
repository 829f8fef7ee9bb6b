"""Second looks: nothing moves farther between two of them than was asked, by forward kinematics of bodies' corners."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from planner.base.polynomials import evaluate
from planner.collision import BACKENDS, make_checker, second_checker
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.recheck import Clearance, sample_along, sample_contacts, sample_segment, straight
from planner.kinematics.forward import joint_placements
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, corners
from tests.collision.test_edge_prover import edges_of
from tests.worlds import checker_of, joint_xml, link_xml, load, random_q, scene_of

BRANCHED = (
    link_xml("base", '<box size="0.2 0.2 0.2"/>')
    + link_xml("a", '<box size="0.1 0.6 0.1"/>', '<origin xyz="0 0.4 0"/>')
    + link_xml("b", '<cylinder radius="0.05" length="0.4"/>', '<origin xyz="0.1 0 0.3"/>')
    + link_xml("c", '<sphere radius="0.07"/>', '<origin xyz="0.3 0 0"/>')
    + link_xml("left", '<box size="0.05 0.05 0.2"/>', '<origin xyz="0.1 0 0.1"/>')
    + link_xml("right", '<box size="0.05 0.05 0.2"/>', '<origin xyz="-0.1 0 0.1"/>')
    + joint_xml("turn", "base", "a", xyz="0 0 0.3", limit="-2 2")
    + joint_xml("slide", "a", "b", "prismatic", "0.6 0 0.8", xyz="0 0.8 0", limit="-0.4 0.4")
    + joint_xml("swing", "b", "c", axis="0 1 0", xyz="0 0 0.5", limit="-2 2")
    + joint_xml("open", "c", "left", "prismatic", "1 0 0", xyz="0.4 0 0", limit="-0.2 0.2")
    + joint_xml("turn_right", "c", "right", axis="1 0 0", xyz="0.4 0 0", limit="-1 1")
)
ARMS = ["panda", "ur5", "kinova", "planar_2r", "branched"]


@pytest.fixture(params=ARMS)
def checker(request: pytest.FixtureRequest, urdf_file) -> CollisionChecker:
    if request.param != "branched":
        return checker_of(request.param, "table") if request.param != "planar_2r" else checker_of("planar_2r", "paper")
    robot = Robot.load(urdf_file(BRANCHED), tool="left")
    return make_checker(robot, scene_of((Box((0.2, 0.2, 0.2)), pose([3.0, 0, 0]))))


def curves(robot: Robot, degree: int, count: int, rng: np.random.Generator) -> np.ndarray:
    """Pieces within limits, each of which begins where the last one ends: their Bernstein coefficients are within."""
    points = rng.uniform(robot.lower, robot.upper, (count * degree + 1, robot.dof)).clip(-3, 3)
    points = points[0] + 0.3 * (points - points[0])
    bezier = np.stack([points[k * degree : (k + 1) * degree + 1] for k in range(count)])
    return np.stack([of_bezier(each) for each in bezier])


def of_bezier(points: np.ndarray) -> np.ndarray:
    """The coefficients of s^0, s^1, ... of a Bézier curve of one, two or four spans."""
    n, found = len(points) - 1, []
    differences, binomial = points, 1.0
    for k in range(n + 1):
        found.append(binomial * differences[0])
        differences, binomial = np.diff(differences, axis=0), binomial * (n - k) / (k + 1)
    return np.array(found)


def corners_in_joints(checker: CollisionChecker) -> list[tuple[int, np.ndarray]]:
    """Of every body its joint, and some of its points (k, 3) in that joint's frame."""
    return [
        (body.joint, corners(body.shape)[0] @ body.placement[:3, :3].T + body.placement[:3, 3])
        for body in checker.world.bodies
    ]


def moved_by(checker: CollisionChecker, states: np.ndarray) -> np.ndarray:
    """How far points of each body get from one state to the next, (n - 1, bodies)."""
    turn, shift = joint_placements(checker.chain, states)
    placed = (
        np.einsum("nij,kj->nki", turn[joint], local) + shift[joint][:, None]
        for joint, local in corners_in_joints(checker)
    )
    return np.stack([np.linalg.norm(np.diff(each, axis=0), axis=2).max(axis=1) for each in placed], axis=1)


@pytest.mark.parametrize("degree", [1, 2, 5])
@pytest.mark.parametrize("step", [0.2, 0.02])
def test_no_point_moves_farther_between_looks_nor_pair_changes_more(checker, degree: int, step: float) -> None:
    pieces = curves(checker.robot, degree, 4, np.random.default_rng(degree))
    looks = sample_along(checker, pieces, step)
    states = evaluate(pieces[looks.piece], looks.s)
    np.testing.assert_allclose(states[[0, -1]], [pieces[0, 0], pieces[-1].sum(axis=0)], rtol=0, atol=1e-12)
    moved = moved_by(checker, states)
    assert moved.max() <= step * (1 + 1e-9)
    world = checker.world
    scene = looks.apart[: world.checked.size].reshape(world.checked.shape)
    assert (moved <= scene.min(axis=1, initial=np.inf) * (1 + 1e-9) + 1e-12).all()
    assert scene.max() <= step * (1 + 1e-9)


def test_no_distance_of_two_bodies_changes_more_between_looks(checker) -> None:
    """By coal, whose distances are off by a hundredth of a millimetre at most."""
    pieces = curves(checker.robot, 1, 2, np.random.default_rng(4))
    looks, judge = sample_along(checker, pieces, 0.2), second_checker(checker)
    pairs = checker.world.checked.size + np.arange(len(checker.world.self_pairs))
    gaps = np.array([judge.gaps(q, pairs) for q in evaluate(pieces[looks.piece], looks.s)])
    assert (np.abs(np.diff(gaps.clip(0), axis=0)) <= looks.apart[pairs] + 2e-5).all()


def test_samples_are_not_many_more_than_needed(checker) -> None:
    """What is farthest moves at least by half of the step between most of them."""
    pieces = curves(checker.robot, 1, 4, np.random.default_rng(9))
    looks = sample_along(checker, pieces, 0.01)
    moved = moved_by(checker, evaluate(pieces[looks.piece], looks.s))
    assert np.mean(moved.max(axis=1)) > 0.5 * 0.01


@pytest.mark.parametrize("checker", ["panda", "planar_2r", "branched"], indirect=True)
@pytest.mark.parametrize("degree", [1, 3])
def test_no_point_is_faster_anywhere_on_a_long_part(checker, degree: int) -> None:
    """Pieces in one part each: an optimiser looks for the fastest point in short steps."""
    robot, bound = checker.robot, checker.bound
    centre, fine = 0.5 * (robot.lower + robot.upper).clip(-3, 3), np.linspace(0.0, 1.0, 17)
    within = (0.5 * (robot.upper - robot.lower)).clip(0, 1) / (degree + 1)  # limits, in which reaches hold

    def excess(given: np.ndarray) -> float:
        piece = within * np.tanh(given).reshape(1, degree + 1, robot.dof)
        piece[:, 0] += centre
        parts, moved, _ = bound.native.walk(bound.motion_bounds, piece, 1e3)
        assert parts == [1]
        return -16.0 * float(moved_by(checker, evaluate(np.repeat(piece, 17, axis=0), fine)).max()) / moved[0]

    rng = np.random.default_rng(degree)
    for _ in range(2):
        found = minimize(excess, rng.normal(size=(degree + 1) * robot.dof), method="Powell", options={"maxfev": 100})
        assert 0.1 < -found.fun <= 1 + 1e-6


def test_joints_that_carry_each_other_speed_a_point_up_together(urdf_file) -> None:
    """A point on the axis about which seven joints turn all in all stands still for a moment.

    Their axes meet in one place, each a little farther round than the one that carries it: nothing turns that axis away
    faster, by sum_jk |sin|, j < k, where the joints by themselves come to their number.
    """
    angles = np.pi * (np.arange(7) + 0.5) / 7
    inside = "".join(link_xml(f"link{k}") for k in range(7))
    inside += link_xml("link7", '<sphere radius="0.001"/>', '<origin xyz="0 1 0"/>')
    for k, angle in enumerate(angles.tolist()):
        inside += joint_xml(f"j{k}", f"link{k}", f"link{k + 1}", axis=f"{math.cos(angle)!r} {math.sin(angle)!r} 0")
    checker = make_checker(Robot.load(urdf_file(inside)), scene_of((Box((0.2, 0.2, 0.2)), pose([3.0, 0, 0]))))
    together = sum(np.sin(angles[k] - angles[:k]).sum() for k in range(7))
    assert together > 2 * len(angles)
    for longest in (0.01, 0.05):
        line = np.array([np.full(7, -longest), np.full(7, 2 * longest)])[None]
        _, moved, _ = checker.bound.native.walk(checker.bound.motion_bounds, line, 1e3)
        fastest = moved_by(checker, evaluate(np.repeat(line, 2, axis=0), np.array([1 - 1e-6, 1.0]))).max() / 1e-6
        assert 0.8 * together * longest * 2 * longest < fastest <= moved[0]


@pytest.mark.parametrize("power", [2, 3, 5])
def test_a_joint_at_rest_in_the_middle_is_not_taken_to_stand_still(power: int, urdf_file) -> None:
    """A turn by (s - 1/2)^power: its velocity and mostly its acceleration vanish where the part is looked at."""
    arm = link_xml("a") + link_xml("b", '<sphere radius="1e-3"/>', '<origin xyz="1 0 0"/>')
    checker = make_checker(Robot.load(urdf_file(arm + joint_xml("j", "a", "b"))), scene_of((Box((1, 1, 1)), pose())))
    curve = 0.02 * np.polynomial.Polynomial([-1.0, 2.0]) ** power
    _, moved, _ = checker.bound.native.walk(
        checker.bound.motion_bounds, np.array(curve.coef, dtype=float)[None, :, None], 1.0
    )
    assert moved.shape == (1,)
    assert np.abs(curve.deriv()(np.linspace(0.0, 1.0, 101))).max() <= moved[0]


@pytest.mark.parametrize("backend", BACKENDS)
def test_motions_that_do_not_meet_touch_where_they_do_one_by_one(backend: str) -> None:
    checker = make_checker(load("panda"), Scene.load("shelf"), backend)
    start, delta = edges_of(checker.robot, 60, 18, 0.6)
    alone = [sample_segment(checker, q, d, 5e-3) for q, d in zip(start, delta, strict=True)]
    first = next(k for k, contact in enumerate(alone) if contact is not None)
    found = sample_contacts(checker, straight(start, delta), 5e-3)
    assert (found.piece, found.contact) == (first, alone[first])
    np.testing.assert_allclose(found.q, start[first] + found.s * delta[first], rtol=0, atol=1e-12)
    free = np.array([contact is None for contact in alone])
    assert free.sum() > 35
    assert sample_contacts(checker, straight(start[free], delta[free]), 5e-3) is None
    last = np.append(np.flatnonzero(free), first)
    found = sample_contacts(checker, straight(start[last], delta[last]), 5e-3)
    assert found.piece == len(last) - 1


@pytest.mark.parametrize(("robot", "scene"), [("iiwa14", "paper"), ("ur5", "table"), ("planar_2r", "window")])
def test_clearance_agrees_with_coal_and_with_state_checks(robot: str, scene: str) -> None:
    fcl, coal = checker_of(robot, scene), make_checker(load(robot), Scene.load(scene), backend="coal")
    q = random_q(load(robot), 60)
    ours, theirs = Clearance(fcl)(q), Clearance(coal)(q)
    free = np.array([is_free(fcl, each) for each in q])
    assert free.any()
    assert not free.all()
    np.testing.assert_array_equal(ours[free] > 0, True)
    np.testing.assert_allclose(ours[free], theirs[free], atol=2e-4)
    np.testing.assert_allclose(ours[~free], 0.0, atol=1e-6)


@pytest.mark.parametrize("below", [0.0, 0.02, 0.1, np.inf])
def test_below_is_where_clearances_are_exact(below: float) -> None:
    """Lower bounds elsewhere, of ``below`` or more."""
    clearance, q = Clearance(checker_of("ur5", "table")), random_q(load("ur5"), 60)
    exact, found = clearance(q), clearance(q, below)
    near = exact < below
    np.testing.assert_array_equal(found[near], exact[near])
    assert (found[~near] >= below).all()
    assert (found <= exact).all()
    assert clearance(q[:0]).shape == (0,)
