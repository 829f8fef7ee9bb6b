"""Yoshikawa's measure against its closed form, its definition and its singular configurations."""

import numpy as np
import pytest

from planner.base.polynomials import evaluate
from planner.constraints.floor import ManipulabilityBound, prove_floor
from planner.constraints.tool_bound import column_rates
from planner.kinematics.manipulability import (
    jacobians,
    manipulability,
)
from planner.robot.robot import Robot
from tests.linkages import palletizer, random_linkage
from tests.worlds import ROBOTS, joint_xml, link_xml, load, random_q


def singular(name) -> np.ndarray:
    """Configurations whose Jacobian has lost a rank: stretched, or with a wrist whose axes line up."""
    robot, zero = load(name), np.zeros(load(name).dof)
    if name == "planar_2r":
        return np.array([[0.3, 0.0], [-2.0, 0.0]])
    if robot.dof == 7 and name != "xarm7":
        return np.array([zero, zero + np.eye(7)[0], zero + np.eye(7)[6]])
    wrist = {"ur5": 4, "ur10": 4}.get(name)
    if wrist is not None:
        q = random_q(robot, 20, seed=2)
        q[:, wrist] = 0.0
        return q
    return np.zeros((0, robot.dof))


@pytest.mark.parametrize("name", [name for name in ROBOTS if len(singular(name))])
def test_singular_configurations_are_zero_and_finite(name):
    w = manipulability(load(name), singular(name))
    assert np.isfinite(w).all()
    assert (w >= 0).all()
    assert (w < 1e-10).all()


def sliding(urdf_file) -> Robot:
    """Turn, slide, turn: every kind of neighbours."""
    inside = "".join(link_xml(name) for name in "abcde")
    inside += joint_xml("j1", "a", "b") + joint_xml("j2", "b", "c", "prismatic", "1 0 0", xyz="0.3 0 0.1")
    inside += joint_xml("j3", "c", "d", axis="0 1 0", xyz="0.2 0.1 0") + joint_xml("j4", "d", "e", xyz="0.3 0 0")
    return Robot.load(urdf_file(inside, name="sliding"))


def made(name: str, urdf_file) -> Robot:
    made = {"sliding": lambda: sliding(urdf_file), "palletizer": lambda: palletizer().robot}
    made["linkage"] = lambda: random_linkage(9).robot
    return made.get(name, lambda: load(name))()


def rates_by_differences(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    step, linear, angular = 1e-6, np.zeros((robot.dof, robot.dof)), np.zeros((robot.dof, robot.dof))
    for k in range(robot.dof):
        up, down = q.copy(), q.copy()
        up[k] += step
        down[k] -= step
        slope = np.subtract(*jacobians(robot, np.stack([up, down]))) / (2 * step)
        linear[:, k] = np.linalg.norm(slope[:3], axis=0)
        angular[:, k] = np.linalg.norm(slope[3:], axis=0)
    return linear, angular


@pytest.mark.parametrize("name", ["iiwa14", "ur5", "kinova", "planar_2r", "sliding", "palletizer", "linkage"])
def test_no_column_changes_faster_than_is_claimed(name: str, urdf_file) -> None:
    robot = made(name, urdf_file)
    claimed = column_rates(robot)
    for q in random_q(robot, 10, seed=5):
        for found, most in zip(rates_by_differences(robot, q), claimed, strict=True):
            assert (found <= most + 1e-6).all()


@pytest.mark.parametrize("name", ["iiwa14", "ur5", "planar_2r", "sliding", "palletizer", "linkage"])
def test_an_optimiser_finds_no_smaller_w_than_the_bound(name: str, urdf_file) -> None:
    """Random steps downhill in w within the spread; the bound of no spread is w itself."""
    robot = made(name, urdf_file)
    rng, bound = np.random.default_rng(4), ManipulabilityBound(robot)
    centres = random_q(robot, 6, seed=2)
    np.testing.assert_allclose(bound(centres, 0.0 * centres)[1], manipulability(robot, centres), rtol=1e-7, atol=1e-15)
    for size in (1e-3, 1e-2):
        spread = size * rng.uniform(0.1, 1.0, size=centres.shape)
        least = bound(centres, spread)[1]
        for k, centre in enumerate(centres):
            lowest = min(_downhill(robot, centre, spread[k], rng))
            assert lowest >= least[k]


def _downhill(robot: Robot, centre: np.ndarray, spread: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    best = centre
    for shrink in (1.0, 0.5, 0.2):
        tries = best + shrink * spread * rng.choice([-1.0, 0.0, 1.0], size=(60, robot.dof))
        tries = np.clip(tries, centre - spread, centre + spread)
        best = tries[manipulability(robot, tries).argmin()]
    return manipulability(robot, best[None])


@pytest.mark.parametrize("name", ["iiwa14", "planar_2r"])
def test_floors_hold_or_break_as_dense_samples_say(name: str) -> None:
    robot, rng = load(name), np.random.default_rng(8)
    curves = np.stack([random_q(robot, 8, seed=1), *(0.2 * rng.normal(size=(2, 8, robot.dof)))], axis=1)
    s = np.linspace(0.0, 1.0, 1001)
    lowest = np.array([manipulability(robot, evaluate(np.repeat(c[None], 1001, axis=0), s)).min() for c in curves])
    regular = lowest > 2e-3  # nearer a singular configuration w comes from the change of J that the bound allows for
    curves, lowest = curves[regular], lowest[regular]
    assert regular.sum() > 3
    under, over = prove_floor(robot, curves, 0.9 * lowest), prove_floor(robot, curves, 1.02 * lowest)
    assert under.holds.all()
    assert not under.broken.any()
    assert (under.lowest <= lowest + 1e-12).all()
    assert (under.lowest >= 0.9 * lowest).all()
    assert over.broken.all()
    assert not over.holds.any()
