"""Chord bounds of the tool frame attacked by a hill climb, and proofs along curves against dense samples."""

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from planner.base.polynomials import evaluate
from planner.constraints.path_constraints import frame_of
from planner.constraints.tool_bound import Frame, ToolBound, prove_along
from planner.robot.files.robot_files import JointChoice
from planner.robot.robot import Robot
from tests.linkages import palletizer, random_linkage
from tests.two_arms import load_two_arms
from tests.worlds import joint_xml, link_xml, load, random_q


def sliding(urdf_file) -> Robot:
    """Slide, turn, slide, turn, and a joint that does not carry the tool."""
    inside = "".join(link_xml(name) for name in "abcdef")
    inside += joint_xml("j1", "a", "b", "prismatic", "0 1 0") + joint_xml("j2", "b", "c", xyz="0.2 0 0", limit="-3 3")
    inside += joint_xml("j3", "c", "d", "prismatic", "1 0 0", xyz="0.3 0 0.1")
    inside += joint_xml("j4", "d", "e", axis="0 1 0", xyz="0.3 0 0", limit="-2 2") + joint_xml("j5", "c", "f")
    return Robot.load(urdf_file(inside, name="sliding"), "e", choice=JointChoice(joints=("j1", "j2", "j3", "j4", "j5")))


def made(name: str, urdf_file) -> Robot:
    made = {"sliding": lambda: sliding(urdf_file), "palletizer": lambda: palletizer().robot}
    made["linkage"] = lambda: random_linkage(9).robot
    return made.get(name, lambda: load(name))()


def deviations(bound: ToolBound, curves: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far position and rotation (largest column; Frobenius by sqrt 2) are off their chords at s (m,)."""
    ends = [bound.frame.poses(bound.robot, evaluate(curves, at)) for at in (0 * s, s, 0 * s + 1)]
    (r0, x0), (r, x), (r1, x1) = ends
    turn = r - (r0 + s[:, None, None] * (r1 - r0))
    columns = np.linalg.norm(turn, axis=1).max(axis=1)
    whole = np.sqrt((turn**2).sum(axis=(1, 2)) / 2)
    return np.linalg.norm(x - (x0 + s[:, None] * (x1 - x0)), axis=1), np.maximum(columns, whole)


def climb(bound: ToolBound, degree: int, size: float, kind: int, seed: int, steps: int = 150) -> float:
    """The largest share of the bound that a hill climb over configuration, curve and s finds, among 40 climbers."""
    robot, rng, n = bound.robot, np.random.default_rng(seed), 40

    def share(q: np.ndarray, c: np.ndarray, s: np.ndarray) -> np.ndarray:
        curves = np.concatenate([q[:, None], size * c], axis=1)
        return deviations(bound, curves, s)[kind] / bound(curves)[kind]

    q, c = random_q(robot, n, seed), rng.normal(size=(n, degree, robot.dof))
    s, best, step = rng.uniform(0.2, 0.8, n), np.zeros(n), np.ones(n)
    for _ in range(steps):
        dq, dc = rng.normal(size=q.shape) * (robot.upper - robot.lower) / 4, rng.normal(size=c.shape)
        tries = np.clip(q + step[:, None] * dq, robot.lower, robot.upper), c + step[:, None, None] * dc
        at = np.clip(s + 0.2 * step * rng.normal(size=n), 0.01, 0.99)
        found = share(*tries, at)
        better = found > best
        q, c, s = (
            np.where(better[:, None], tries[0], q),
            np.where(better[:, None, None], tries[1], c),
            np.where(better, at, s),
        )
        best, step = np.where(better, found, best), np.clip(np.where(better, 1.5 * step, 0.85 * step), 1e-3, 1.0)
    return float(best.max())


@pytest.mark.parametrize("name", ["iiwa14", "ur5", "planar_2r", "sliding", "palletizer", "linkage"])
@pytest.mark.parametrize("degree", [1, 2, 5])
@pytest.mark.parametrize("size", [1e-2, 1.0])
def test_a_hill_climb_never_exceeds_the_bound(name: str, degree: int, size: float, urdf_file) -> None:
    bound = ToolBound(made(name, urdf_file))
    for kind in (0, 1):
        assert climb(bound, degree, size, kind, seed=degree) <= 1.0


RELATIVE = [("two arms", "right_tool", "left_tool"), ("two arms", "left_tool", "right_link3"), ("sliding", "e", "f")]
RELATIVE += [("sliding", "a", "e"), ("iiwa14", "iiwa14_link_2", "flange"), ("linkage", "", "")]


def relative(name: str, frame: str, base: str, urdf_file) -> ToolBound:
    robot = load_two_arms() if name == "two arms" else made(name, urdf_file)
    links = [each.name for each in robot.model.frames if each.type == pin.FrameType.BODY]
    return ToolBound(robot, frame_of(robot, frame or links[-1], base=base or links[len(links) // 2]))


@pytest.mark.parametrize(("name", "frame", "base"), RELATIVE)
def test_a_hill_climb_never_exceeds_the_bound_in_another_frame(name: str, frame: str, base: str, urdf_file) -> None:
    bound = relative(name, frame, base, urdf_file)
    for degree, size in ((1, 1e-2), (2, 1.0)):
        for kind in (0, 1):
            assert climb(bound, degree, size, kind, seed=degree) <= 1.0


@pytest.mark.parametrize(("name", "frame", "base"), RELATIVE)
def test_poses_in_another_frame_and_their_jacobian(name: str, frame: str, base: str, urdf_file) -> None:
    """By Pinocchio's placements; the joints that move the pose by finite differences are those with a reach."""
    bound = relative(name, frame, base, urdf_file)
    robot, far = bound.robot, 1e-6
    for q in random_q(robot, 3, seed=4):
        rotation, position = bound.frame.poses(robot, q + far * np.vstack([np.zeros(robot.dof), np.eye(robot.dof)]))
        moved = np.linalg.norm(position[1:] - position[0], axis=1) / far
        turned = np.linalg.norm(rotation[1:] - rotation[0], axis=(1, 2)) / far
        assert (moved <= bound.reach + 1e-6).all()
        assert ((turned > 1e-4) <= (bound.turns > 0)).all()
        assert (bound.turns[turned > 1e-4] >= turned[turned > 1e-4] / 2**0.5 - 1e-5).all()
        if frame:
            there, here = robot.fk(q, frame), robot.fk(q, base)
            np.testing.assert_allclose(np.linalg.inv(here) @ there, _matrix(rotation[0], position[0]), atol=1e-9)
            assert bound.turns.sum() < robot.dof or name == "two arms"


def _matrix(rotation: np.ndarray, position: np.ndarray) -> np.ndarray:
    return np.vstack([np.column_stack([rotation, position]), [0.0, 0.0, 0.0, 1.0]])


@pytest.mark.parametrize("name", ["iiwa14", "ur5", "planar_2r", "sliding"])
def test_straight_short_motions_come_within_a_third_of_the_bound(name: str, urdf_file) -> None:
    bound = ToolBound(made(name, urdf_file))
    for kind in (0, 1):
        assert climb(bound, 1, 1e-2, kind, seed=3, steps=400) >= 1 / 3


def test_a_point_a_metre_off_the_flange_is_bounded_too() -> None:
    robot = load("iiwa14")
    far = ToolBound(robot, Frame.tool(robot, np.array([1.0, 0.0, 0.0])))
    assert 0.3 <= climb(far, 1, 1e-2, 0, seed=1, steps=300) <= 1.0
    near = ToolBound(robot)
    wrist = np.zeros((1, 2, 7))
    wrist[0, 1, 6] = 0.1
    assert deviations(far, wrist, np.array([0.5]))[0][0] > near(wrist)[0][0]


def test_a_joint_that_does_not_carry_the_tool_moves_nothing(urdf_file) -> None:
    robot = sliding(urdf_file)
    curve = np.zeros((2, 3, robot.dof))
    curve[:, 1:, robot.joints.index("j5")] = 1.0
    curve[1, 1, robot.joints.index("j1")] = 0.5  # a slide alone moves it on its chord
    off, turned = ToolBound(robot)(curve)
    assert off.max() < 1e-12
    assert turned.max() < 1e-12


def ball(centre: np.ndarray, radius: Any):
    return lambda curve, s, rotation, position: (radius - np.linalg.norm(position - centre, axis=1))[:, None, None]


@pytest.mark.parametrize("name", ["iiwa14", "ur5", "sliding", "palletizer", "linkage"])
def test_balls_hold_or_break_as_dense_samples_say(name: str, urdf_file) -> None:
    robot, rng = made(name, urdf_file), np.random.default_rng(2)
    bound, s = ToolBound(robot), np.linspace(0, 1, 2001)
    for degree in (1, 3, 5):
        curve = np.concatenate(
            [random_q(robot, 1, degree)[None], 0.3 * rng.normal(size=(1, degree, robot.dof))], axis=1
        )
        dense = bound.frame.poses(robot, evaluate(np.repeat(curve, len(s), axis=0), s))[1]
        centre = dense[0]
        most = np.linalg.norm(dense - centre, axis=1).max()
        holds = prove_along(bound, curve, ball(centre, 1.001 * most), np.ones(1), np.zeros(1))
        breaks = prove_along(bound, curve, ball(centre, 0.999 * most), np.ones(1), np.zeros(1))
        assert holds.all()
        assert not breaks.any()


def test_one_of_two_alternatives_is_enough_for_each_piece() -> None:
    """Two balls that overlap hold a motion between them; neither does alone."""
    robot = load("planar_2r")
    bound, curve = ToolBound(robot), np.array([[[0.0, 0.5], [1.0, 0.0]]])
    ends = bound.frame.poses(robot, np.array([[0.0, 0.5], [1.0, 0.5]]))[1]
    radius = 0.75 * np.linalg.norm(ends[1] - ends[0])
    one, two = ball(ends[0], radius), ball(ends[1], radius)
    both = prove_along(bound, curve, lambda *at: np.concatenate([one(*at), two(*at)], axis=1), np.ones(1), np.zeros(1))
    assert both.all()
    assert not prove_along(bound, curve, one, np.ones(1), np.zeros(1)).any()
    assert not prove_along(bound, curve, two, np.ones(1), np.zeros(1)).any()
