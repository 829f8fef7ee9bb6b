"""The stops of verdicts, jumps at the first point, and shapes that touch by rounding."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import planner
from planner.collision import make_checker
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Capsule, Cylinder, Obstacle, Shape, Sphere
from planner.session.gate import Gate
from planner.session.guard import JUDGED
from tests.worlds import load

TIMES = np.array([0.5, 1.0])


@pytest.mark.parametrize(
    ("jumps", "judged", "kind", "limit"),
    [
        ((0.0, 0.0, 16.0), ("jerk",), "limit", "jerk"),
        ((0.0, 0.0, -0.02), JUDGED, "limit", "jerk"),
        ((0.0, 0.0, 0.005), JUDGED, None, None),  # within the tolerance
        ((0.0, 0.0, 16.0), ("position", "velocity"), None, None),
        ((0.02, 0.0, 0.0), JUDGED, "start", None),
    ],
)
def test_what_jumps_between_the_state_and_a_first_point_at_0_s_is_not_safe(
    jumps: tuple[float, ...], judged: tuple[str, ...], kind: str | None, limit: str | None
) -> None:
    robot, one = load("iiwa14"), np.eye(7)[2]
    limits = planner.MotionLimits.from_robot(robot, planner.TimingRequest(acceleration=20.0, jerk=500.0))
    gate, home, zero = Gate(robot, "empty", limits=limits, judged=judged), np.array(robot.home), np.zeros(7)
    points = np.vstack([home, home]), np.vstack([zero, zero]), np.vstack([8.0 * one, zero])
    state = home + jumps[0] * one, jumps[1] * one, (8.0 + jumps[2]) * one
    found = gate.check(*points, times=[0.0, 1.0], state=state)
    assert (found.safe, found.reason and found.reason.kind) == (kind is None, kind)
    if kind is not None:
        assert found.reason is not None
        assert (found.reason.limit, found.reason.joint, found.reason.on) == (limit, robot.joints[2], "start")
        assert (found.safe_until, found.first_bad) == (0.0, 0.0)
    unknown = gate.check(*points, times=[0.0, 1.0], state=(home, zero))
    assert unknown.safe
    assert "jerk at the first point is not checked" in " ".join(unknown.notes)


CART = """<robot name="cart"><link name="base"/><link name="tool"/><link name="cart"><collision><geometry>
<sphere radius="{radius!r}"/></geometry></collision></link>
<joint name="t" type="fixed"><parent link="cart"/><child link="tool"/></joint>
<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-5000" upper="5000" velocity="1" effort="1"/></joint></robot>"""


def touching(x: float, radius: float, kind: int, rng: np.random.Generator) -> tuple[Obstacle, Fraction]:
    """A shape at about its distance 0 from a ball about (x, 0, 0), and the square of their cores' exact distance.

    Cores are the middles of ball and capsule, the box itself, and the axis of the cylinder.
    """
    size, length, over = 10.0 ** rng.uniform(-1, 3), 10.0 ** rng.uniform(-1, 3), rng.choice([-1, 1]) * 3e-13
    d = rng.normal(size=3)
    d = d / np.linalg.norm(d) if kind != 3 else np.array([*d[:2], 0.0]) / np.linalg.norm(d[:2])
    shape: Shape = [Sphere(size), Capsule(size, length), Box((size, length, size)), Cylinder(size, length)][kind]
    half = [np.zeros(3), np.array([0, 0, length / 2]), np.array([size, length, size]) / 2, np.array([0, 0, length / 2])]
    rounded = 0.0 if kind == 2 else size
    at = np.array([x, 0.0, 0.0]) + d * (radius + rounded + over) + np.sign(d) * half[kind]
    away = [abs(Fraction(p) - Fraction(q)) - Fraction(h) for p, q, h in zip(at, (x, 0, 0), half[kind], strict=True)]
    turn = pose([0, 0, 0], rpy=rng.uniform(-3, 3, 3).tolist()) if kind == 0 else np.eye(4)
    placement = turn.copy()
    placement[:3, 3] = at
    return Obstacle(f"b{rng.integers(1 << 40)}", shape, placement), sum(max(a, Fraction(0)) ** 2 for a in away)


@pytest.mark.parametrize("kind", range(4), ids=["sphere", "capsule", "box", "cylinder"])
def test_no_bound_by_spheres_exceeds_the_exact_distance(kind: int, tmp_path: Path) -> None:
    rng, called_safe, overlapping, above = np.random.default_rng(kind), 0, 0, 0
    for case in range(4):
        radius, x = 10.0 ** rng.uniform(-1, 3), rng.choice([-1, 1]) * 10.0 ** rng.uniform(1, 3.6)
        (tmp_path / "cart.urdf").write_text(CART.format(radius=radius))
        robot = Robot.load(str(tmp_path / "cart.urdf"), tool="tool")
        made = [touching(x, radius, kind, rng) for _ in range(60)]
        bound = make_checker(robot, Scene("x", tuple(item for item, _ in made))).bound
        rotation, position = joint_placements(Chain.from_arm(robot), np.array([[x]]))
        for k, (item, square) in enumerate(made):
            sizes = Fraction(radius) + Fraction(getattr(item.shape, "radius", 0.0))
            least = Fraction(float(bound.coarse(rotation, position)[0, k])) + sizes
            above += least > 0 and least**2 > square
            if square < sizes**2 and case == 0:
                overlapping += 1
                called_safe += Gate(robot, Scene("x", (item,))).check([[x], [x]], times=TIMES, stop=False).safe
    assert (above, called_safe) == (0, 0)
    assert overlapping > 15
