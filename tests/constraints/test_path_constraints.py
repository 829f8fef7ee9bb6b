"""Path constraints against Pinocchio, exact angles, and an optimiser that looks for a violation of a proven curve."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import minimize_scalar

from planner.base.errors import PlannerError
from planner.base.polynomials import evaluate
from planner.constraints.path_constraints import (
    _FINEST,
    FORGIVEN,
    PathConstraints,
    bind_to_start,
    relative_to_start,
    require_bound,
)
from planner.constraints.tool_bound import prove_along
from planner.problem.conditions import OrientationConstraint, PositionConstraint, parse_constraints
from planner.robot.robot import Robot
from tests.two_arms import load_two_arms

QUATERNION = "0.9,0.3,0.1,0.3"
TEXTS = [
    "axis:z,0,0,-1,0.0873",
    "axis:x,0.6,0,0.8,2.5",
    "box:-0.5,-0.5,0.3,0.5,0.5,0.6",
    "box:-0.5,-0.5,0.3,0.5,0.5,0.6 of panda_link5 at 0.1,0,0.05",
    "plane:0,0.6,0.8,0.4",
    f"turn:0.15,{QUATERNION}",
    f"axis:z,0,0,-1,0.2;plane:0,0,1,0.3;turn:1.5,{QUATERNION}",
    "near:0.1,0.2,-0.1,0.4 of panda_link7 in panda_link2 at 0.1,0,0",
    "keep:0.2,0.3 of right_tool in left_tool",
    "axis:z,0,0,-1,0.2 of left_tool in right_link2;box:-0.3,-0.3,0.3,0.3,0.3,0.6 of left_tool in right_link2",
]


@pytest.fixture(scope="module")
def panda():
    return Robot.load("panda")


@pytest.fixture
def robot(text, panda):
    """The robot whose frames a text names."""
    return load_two_arms() if "left" in text else panda


def read(text):
    """Constraints with a pose, also where the text has none."""
    given = {PositionConstraint: {"position": (0.2, 0.1, 0.3)}, OrientationConstraint: {"quaternion": (0.6, 0, 0, 0.8)}}
    return tuple(
        replace(each, **given[type(each)]) if relative_to_start([each]) else each for each in parse_constraints(text)
    )


def pose(robot, q, frame=None, point=(0.0, 0.0, 0.0), base=None):
    """Rotation and position by Pinocchio."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, np.asarray(q, dtype=float))
    placed = data.oMf[robot.model.getFrameId(frame or robot.tool)]
    placed = data.oMf[robot.model.getFrameId(base)].actInv(placed) if base else placed
    return placed.rotation, placed.rotation @ np.array(point) + placed.translation


def beyond(robot, condition, q):
    """By how much (rad, m) a state strays, from the condition's own words."""
    rotation, x = pose(robot, q, condition.frame, getattr(condition, "point", (0.0, 0.0, 0.0)), condition.base)
    kind, v = condition.kind, condition.values
    if kind == "axis":
        n = np.array(condition.direction) / np.linalg.norm(condition.direction)
        a = rotation[:, "xyz".index(condition.axis)]
        return math.atan2(np.linalg.norm(np.cross(a, n)), a @ n) - condition.angle
    if kind == "box":
        return max(max(np.subtract(v[:3], x)), max(np.subtract(x, v[3:])))
    if kind == "near":
        return np.linalg.norm(x - condition.position) - condition.radius
    if kind == "plane":
        return (condition.distance - np.dot(v[:3], x)) / np.linalg.norm(v[:3])
    off = pin.Quaternion(np.array(condition.quaternion)).normalized().matrix().T @ rotation
    return np.linalg.norm(pin.log3(off)) - condition.angle


def strays(robot, conditions, q):
    return max(beyond(robot, each, q) for each in conditions)


@pytest.mark.parametrize("text", TEXTS)
def test_states_satisfy_the_constraint_by_pinocchio(robot, text):
    constraints, rng = PathConstraints(robot, read(text)), np.random.default_rng(1)
    q = rng.uniform(robot.lower, robot.upper, size=(40, robot.dof))
    q = np.vstack([q, constraints.project(q, rng.uniform(-0.2, 0.9, size=40))[0]])
    truth = np.array([[beyond(robot, each, state) for each in constraints.conditions] for state in q])
    holds = constraints.holds(q)
    assert holds.any()
    assert not holds.all()
    assert not constraints.holds(np.full((1, robot.dof), np.nan)).any()
    assert (truth[holds] <= 1e-6).all()
    assert (truth[~holds].max(axis=1) > -1e-6).all()
    np.testing.assert_allclose(constraints.slacks(q), -truth, atol=2e-6)


@pytest.mark.parametrize("text", TEXTS)
def test_proven_curves_do_not_stray(robot, text):
    """An optimiser climbs along each proven curve, and finds nowhere where it strays."""
    constraints, rng = PathConstraints(robot, read(text)), np.random.default_rng(2)
    start, good = constraints.project(rng.uniform(robot.lower, robot.upper, size=(60, robot.dof)), 0.8)
    start = start[good]
    curves = np.stack([start, *(rng.normal(size=start.shape) * size for size in (0.1, 0.08, 0.05))], axis=1)
    curves[:, 1:] *= rng.uniform(0.02, 2.0, size=(len(curves), 1, 1))
    proven = constraints.prove(curves)
    assert 2 < proven.sum() < len(curves)
    s = np.linspace(0.0, 1.0, 41)
    for curve, held in zip(curves, proven, strict=True):
        worst = [strays(robot, constraints.conditions, q) for q in evaluate(np.repeat(curve[None], 41, axis=0), s)]
        k = int(np.argmax(worst))
        if held:
            top: Any = minimize_scalar(
                lambda u, c=curve: -strays(robot, constraints.conditions, evaluate(c[None], np.array([u]))[0]),
                bounds=(s[max(k - 1, 0)], s[min(k + 1, 40)]), method="bounded", options={"xatol": 1e-9},
            )  # fmt: skip
            assert max(-top.fun, worst[k]) <= 2e-6
        else:
            assert worst[k] > -2e-2  # a proof is refused only of what strays, or nearly


def proven_in_python(constraints, curves, finest=_FINEST):
    """The same proof by arrays, frame by frame."""
    proven = np.ones(len(curves), dtype=bool)
    for k, group in enumerate(constraints._groups):
        metre, turn = (np.array([getattr(piece, per) for piece in group.pieces]) for per in ("per_metre", "per_turn"))

        def slack(_curve, _s, rotation, position, k=k):
            return constraints._native.slack(k, rotation, position)[:, None] + FORGIVEN

        proven &= prove_along(group.bound, curves, slack, metre, turn, finest)
    return proven


def grown(curves, factor):
    """Curves (m, degree + 1, dof) that go on from where they begin by ``factor`` (m,) as much."""
    return np.concatenate([curves[:, :1], factor[:, None, None] * curves[:, 1:]], axis=1)


@pytest.mark.parametrize("degree", [0, 3, 12])
@pytest.mark.parametrize("text", TEXTS[::2])
def test_the_compiled_proof_agrees_with_the_proof_by_arrays(robot, text, degree):
    """On random curves, and on curves scaled until the proof just holds or just fails."""
    constraints, rng = PathConstraints(robot, read(text)), np.random.default_rng(degree)
    start = rng.uniform(robot.lower, robot.upper, (150, robot.dof))
    start, _ = constraints.project(start, rng.uniform(0.0, 0.9, 150))
    start[::10] = rng.uniform(robot.lower, robot.upper, start[::10].shape)
    curves = np.concatenate([start[:, None], rng.normal(size=(len(start), degree, robot.dof))], axis=1)
    curves = grown(curves, 10.0 ** rng.uniform(-4.0, -0.3, len(curves)))
    proven = constraints.prove(curves)
    assert 10 < proven.sum() < len(curves)
    np.testing.assert_array_equal(proven, proven_in_python(constraints, curves))
    for finest in (_FINEST, 1e3) if degree else ():
        edge = curves[proven_in_python(constraints, curves, finest)][:15]
        low, high = np.ones(len(edge)), np.full(len(edge), 64.0)
        for _ in range(34):
            middle = 0.5 * (low + high)
            held = proven_in_python(constraints, grown(edge, middle), finest)
            low, high = np.where(held, middle, low), np.where(held, high, middle)
        for off in (-1e-6, -1e-9, 1e-9, 1e-6):
            near = grown(edge, low * (1.0 + off))
            found = constraints._native.proven(near, constraints._rates, FORGIVEN, finest)
            np.testing.assert_array_equal(found, proven_in_python(constraints, near, finest))


def test_a_motion_that_begins_on_the_edge_is_proven(panda):
    q = panda.home
    z = pose(panda, q)[1][2]
    constraints = PathConstraints(panda, parse_constraints(f"plane:0,0,1,{float(z)!r}"))
    inward = constraints.project(q[None] + 0.0, 0.5)[0][0]
    deeper = PathConstraints(panda, parse_constraints(f"plane:0,0,1,{float(z) + 0.05!r}")).project(inward[None], 0.5)[
        0
    ][0]
    assert constraints.prove(np.stack([q, deeper - q])[None])[0]


def test_a_turn_is_about_the_orientation_at_the_start(panda):
    (turn,) = bind_to_start(parse_constraints("turn:0.1"), panda, panda.home)
    assert beyond(panda, turn, panda.home) == pytest.approx(-0.1, abs=1e-7)
    with pytest.raises(PlannerError, match="must have an orientation here"):
        require_bound(parse_constraints("turn:0.1"), panda)
