"""Curves called free are: sampled densely by the other backend, attacked by an optimiser that wants contact."""

from collections.abc import Callable

import numpy as np
import pytest

from planner.base.polynomials import evaluate, part
from planner.collision import make_checker, second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.collision.recheck import Clearance
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.shapes import Box, Sphere
from tests.worlds import checker_of, joint_xml, link_xml, load, scene_of

WALL = scene_of((Box((0.02, 0.3, 0.3)), pose([0.6, 0.3, 0.0])))


def curves(robot: Robot, n: int, degree: int, seed: int, reach: float = 0.5) -> np.ndarray:
    """Random curves (n, degree + 1, dof) whose Bernstein coefficients, and so all of them, lie within limits."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(robot.lower, robot.upper, size=(n, 1, robot.dof))
    points = np.clip(points + reach * rng.normal(size=(n, degree + 1, robot.dof)), robot.lower, robot.upper)
    powers = np.zeros((n, degree + 1, robot.dof))
    for j in range(degree + 1):  # sum_j B_j(s) p_j, expanded
        basis = np.polynomial.Polynomial([1.0])
        for _ in range(j):
            basis *= np.polynomial.Polynomial([0.0, 1.0])
        for _ in range(degree - j):
            basis *= np.polynomial.Polynomial([1.0, -1.0])
        powers += _choose(degree, j) * np.array(basis.coef, dtype=float)[None, :, None] * points[:, j : j + 1]
    return powers


def _choose(n: int, k: int) -> float:
    return float(np.prod([(n - i) / (i + 1) for i in range(k)]))


def states(curve: np.ndarray, count: int) -> np.ndarray:
    return evaluate(np.repeat(curve[None], count, axis=0), np.linspace(0.0, 1.0, count))


def both(name: str) -> tuple[CollisionChecker, CollisionChecker]:
    """FCL, which proves, and coal, which judges."""
    checker = make_checker(load(name), WALL) if name == "planar_2r" else checker_of(name, "paper")
    return checker, second_checker(checker)


@pytest.mark.parametrize("name", ["planar_2r", "iiwa14"])
def test_an_optimiser_finds_no_less_clearance_than_is_claimed(name: str) -> None:
    """Golden sections around the nearest samples of the tightest free curves, by the other backend."""
    checker, judge = both(name)
    found = curves(load(name), 60, 3, seed=11, reach=0.8)
    proofs, clearance = EdgeProver(checker).prove_curves(found), Clearance(judge)
    s = np.linspace(0.0, 1.0, 33)
    for k in np.flatnonzero(proofs.free)[np.argsort(proofs.clearance[proofs.free])][:3]:
        near = s[clearance(states(found[k], 33)).argmin()]
        low, high = max(0.0, near - s[1]), min(1.0, near + s[1])
        for _ in range(12):
            inner = np.array([low + 0.382 * (high - low), low + 0.618 * (high - low)])
            left, right = clearance(evaluate(np.repeat(found[k][None], 2, axis=0), inner))
            low, high = (low, inner[1]) if left < right else (inner[0], high)
            assert min(left, right) >= proofs.clearance[k] - 2e-5


def test_a_segment_is_a_curve_of_degree_one() -> None:
    """A segment padded with zero coefficients has the same verdict, and so have its halves."""
    robot = load("planar_2r")
    prover = EdgeProver(make_checker(robot, WALL))
    line = curves(robot, 40, 1, seed=3, reach=1.0)
    whole = prover.prove(line[:, 0], line[:, 1])
    for name in ("verdict", "pair", "samples", "clearance"):
        np.testing.assert_array_equal(getattr(prover.prove_curves(line), name), getattr(whole, name))
    padded = np.concatenate([line, np.zeros((len(line), 2, robot.dof))], axis=1)
    np.testing.assert_array_equal(prover.prove_curves(padded).verdict, whole.verdict)
    free = line[whole.free & (whole.clearance > 1e-3)]
    half = part(free, np.zeros(len(free)), np.full(len(free), 0.5))
    assert prover.prove_curves(half).free.all()


FROM_REST = {  # q(s) of (slide, shoulder, elbow) whose tip stands still at s = 0.5 and then goes as quickly as it may
    "a turn that speeds up": [[0.0] * 3, [0.0, -0.1, 0.0], [0.0, 0.1, 0.0]],
    "a slide that speeds up": [[0.0] * 3, [-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]],
    "a turn that speeds up more and more": [[0.0] * 3, [0.0, -0.075, 0.0], [0.0] * 3, [0.0, 0.1, 0.0]],
    "one turn, held by the slide": [[0.1, -0.1, 0.0], [-0.2, 0.2, 0.0]],
    "two turns, held by the slide": [[0.15, -0.1, -0.1], [-0.3, 0.2, 0.2]],
    "two turns of two speeds": [[0.1, -0.05, -0.1], [-0.2, 0.1, 0.2]],
}


@pytest.mark.parametrize("name", FROM_REST)
def test_a_point_reached_from_rest_is_not_called_clear(name: str, urdf_file: Callable[..., str]) -> None:
    """Along an arm that is stretched out joints add up in how they speed up a point: nothing of that may be left out.

    An obstacle stands where the tip comes to in the end, and the sample in the middle sees it at its farthest.
    """
    arm = "".join(map(link_xml, "abc")) + link_xml("d", '<sphere radius="1e-4"/>', '<origin xyz="0.5 0 0"/>')
    arm += joint_xml("slide", "a", "b", "prismatic", "0 1 0") + joint_xml("turn", "b", "c")
    robot = Robot.load(urdf_file(arm + joint_xml("bend", "c", "d", xyz="0.5 0 0")))
    curve = np.array(FROM_REST[name])
    turn, shift = joint_placements(Chain.from_arm(robot), states(curve, 3))
    middle, end = (turn[3, k] @ [0.5, 0.0, 0.0] + shift[3, k] for k in (1, 2))
    for share in (0.9, 1.0):
        place = pose(((1 - share) * middle + share * end).tolist())
        prover = EdgeProver(make_checker(robot, scene_of((Sphere(1e-4), place))))
        assert not prover.prove_curves(curve[None]).free.any()
    away = EdgeProver(make_checker(robot, scene_of((Sphere(1e-4), pose((1.3 * end - 0.3 * middle).tolist())))))
    assert away.prove_curves(curve[None]).free.all()
