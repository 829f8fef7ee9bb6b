"""From a target to configurations: their order, and refusals."""

import numpy as np
import pytest

from planner.base.errors import PlannerError, StateError
from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.problem.outcome import BeyondLimit, OutOfReach, Touching
from planner.problem.targets import Joints, Pose, Position, parse_target
from planner.query.resolve import (
    beyond_limits,
    looks_like_degrees,
    resolve,
    resolve_as_is,
)
from planner.robot.poses import pose
from planner.robot.shapes import Box
from tests.two_arms import load_two_arms
from tests.worlds import ROBOTS, checker_of, load, random_q, scene_of


@pytest.fixture(scope="module")
def paper():
    return checker_of("iiwa14", "paper")


def test_positions_come_best_manipulability_first(paper):
    target = Position((0.6, -0.2, 0.7))
    found = resolve(target, paper, {}, "goal", count=10)
    w = manipulability(load("iiwa14"), found)
    assert len(found) > 2
    assert (np.diff(w) <= 0).all()
    assert all(is_free(paper, q) for q in found)
    np.testing.assert_allclose(tool_positions(load("iiwa14"), found), np.tile(target.xyz, (len(found), 1)), atol=2e-6)
    np.testing.assert_array_equal(resolve(target, paper, {}, "goal"), found[:1])


@pytest.mark.parametrize("name", ["iiwa14", "kinova"])
def test_near_the_start_there_is_a_goal_and_so_is_the_best(name):
    """A straight motion of a few hundredths per joint ends at the goal: something as near is among the solutions."""
    checker = checker_of(name, "empty")
    robot, rng = checker.robot, np.random.default_rng(5)
    inner = 0.15 * (robot.lower + robot.upper) + 0.7 * random_q(robot, 30)  # away from the limits
    for start in [q for q in inner if is_free(checker, q)][:8]:
        there = start + rng.uniform(-0.1, 0.1, robot.dof)
        if not is_free(checker, there):
            continue
        target = Position(tuple(tool_positions(robot, there)[0]))
        found = resolve(target, checker, {}, "goal", 8, start[None])
        away = np.linalg.norm(robot.difference(start, found), axis=1)
        assert away.min() <= np.linalg.norm(robot.difference(start, there)) + 1e-3
        assert len(found) == 8
        old = manipulability(robot, resolve(target, checker, {}, "goal", 1))
        assert manipulability(robot, found[:1]) >= old - 1e-12
        np.testing.assert_array_equal(found, resolve(target, checker, {}, "goal", 8, start[None]))


def test_a_state_may_be_the_name_of_others(paper):
    """``start: home`` above all: the robot's own, where the scene has none of that name."""
    q = ",".join(map(str, load("iiwa14").home + 0.1))
    states = {"start": "home", "there": "xyz:0.5,0.1,0.8", "again": "start", "ends": "again, there", "here": f"q:{q}"}
    home = load("iiwa14").home
    for name in ("start", "again"):
        np.testing.assert_array_equal(resolve(parse_target(name), paper, states, "start"), home[None])
        np.testing.assert_array_equal(resolve_as_is(parse_target(name), paper, states, "start"), home)
    assert len(resolve(parse_target("ends"), paper, states, "goal")) == 2
    with pytest.raises(PlannerError, match="must be one state, got 2"):
        resolve_as_is(parse_target("ends"), paper, states, "start")
    own = states | {"home": "here"}
    np.testing.assert_allclose(resolve(parse_target("start"), paper, own, "start")[0], home + 0.1)
    with pytest.raises(PlannerError, match=r"start 'nowhere' not found; states of"):
        resolve(parse_target("start"), paper, {"start": "nowhere"}, "start")


# refusals; scenes of their own, so that they do not hang on the built-in ones

WALL = [(Box((0.2, 2, 2)), pose([0.5, 0, 0.5]))]


@pytest.fixture(scope="module")
def walled():
    return make_checker(load("iiwa14"), scene_of(*WALL))


STATES = {"here": "q:0,0,0,0,0,0,0", "round": "and", "and": "round"}
SEVEN = (0.0,) * 7
REFUSED: dict[str, tuple] = {  # a target, a part of the sentence, the kind of the reason
    "unknown name": (parse_target("goal"), "here, round, and, home", None),
    "a circle": (parse_target("round"), "must not refer to itself, got round, and", None),
    "too few joints": (Joints((0.0,) * 6), "start must have 7 joint values, got 6: planned joints of iiwa14", None),
    "NaN": (Joints((float("nan"), *SEVEN[1:])), "start must hold finite numbers", None),
    "infinite position": (Position((float("inf"), 0, 0)), "finite numbers", None),
    "above a limit": (Joints((0, 0, 0, 0, 0, 0, 3.2)), "by 0.146 rad", BeyondLimit),
    "below a limit": (Joints((0, -2.2, 0, 0, 0, 0, 0)), "by 0.106 rad", BeyondLimit),
    "in collision": (Joints((0, 1.0, 0, 0, 0, 0, 0)), "and 'thing0' touch", Touching),
    "zero quaternion": (Pose((0.5, 0, 0.5), (0, 0, 0, 0)), "must not be zero", None),
    "out of reach": (Position((0, 1.5, 0.36)), "0.554 m beyond the arm's reach", OutOfReach),
    "limits forbid it": (Position((0, 0, 0.4)), "joint limits or orientation forbid it", OutOfReach),
    "only in collision": (Position((0.5, 0, 0.5)), "configurations, all in collision", Touching),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(walled, case):
    target, part, kind = REFUSED[case]
    with pytest.raises(StateError) as caught:
        resolve(target, walled, STATES, "start")
    message, reason = str(caught.value), caught.value.reason
    assert part in message
    assert message.endswith(".")
    assert "\n" not in message
    assert caught.value.exit_code == 3
    assert reason is None if kind is None else isinstance(reason, kind)
    if isinstance(reason, BeyondLimit):
        k = walled.robot.joints.index(reason.joint)
        assert (reason.value, reason.upper) == (target.values[k], walled.robot.upper[k])


def test_a_goal_of_two_tools_is_reached_at_once_and_a_goal_of_both_names_what_cannot():
    robot = load_two_arms()
    checker = make_checker(robot, scene_of())
    goal = parse_target("left_tool xyz:0.3,0.2,0.7 & right_tool pose:0.3,-0.2,0.7,0,1,0,0")
    found = resolve(goal, checker, {}, "goal", 8, robot.home[None])
    assert len(found) >= 4
    for q in found:
        assert is_free(checker, q)
        np.testing.assert_allclose(robot.fk(q, "left_tool")[:3, 3], [0.3, 0.2, 0.7], atol=2e-6)
        placed = np.array([[-1, 0, 0, 0.3], [0, 1, 0, -0.2], [0, 0, -1, 0.7], [0, 0, 0, 1]])
        np.testing.assert_allclose(robot.fk(q, "right_tool"), placed, atol=5e-6)
    assert np.array_equal(resolve_as_is(goal, checker, {}, "goal"), found[0])
    for text, said in (
        ("left_tool xyz:0.3,0.2,0.7 & right_tool xyz:0.3,-1.2,0.7", "by frame 'right_tool'"),
        ("left_tool xyz:0.3,0.2,0.7 & left_link6 xyz:0.3,0.2,0.9", "left_tool, left_link6 at once, only by each"),
    ):
        with pytest.raises(StateError, match=said) as caught:
            resolve(parse_target(text), checker, {}, "goal")
        assert isinstance(caught.value.reason, OutOfReach)


@pytest.mark.parametrize("name", ROBOTS)
def test_degrees_are_recognised(name):
    """Configurations in degrees are recognised where a joint with limits shows it, those in rad never."""
    robot = load(name)
    q = random_q(robot, 300)
    degrees = np.where(robot.prismatic, q, np.degrees(q))
    shows = np.abs(degrees) * (beyond_limits(robot, degrees) > 0) * ~robot.prismatic > 2 * np.pi
    flags = [looks_like_degrees(robot, row) for row in degrees]
    assert flags == shows.any(axis=1).tolist()
    assert np.mean(flags) > 0.9
    assert looks_like_degrees(robot, degrees)
    assert not any(looks_like_degrees(robot, row) for row in (*q, *np.clip(1.5 * q, -2 * np.pi, 2 * np.pi)))
    assert not looks_like_degrees(robot, np.vstack([degrees, 400.0 + 0 * q[:1]])), "no limits hold as degrees either"
