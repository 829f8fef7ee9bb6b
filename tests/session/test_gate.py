"""Verdicts: what a controller runs, limits, stops, bad input, threads."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import planner
from benchmarks.gate.chunks import KINDS, Chunk, clutter, random_chunk
from benchmarks.gate.judge import motion_of
from planner.base.errors import ArrayError, PlannerError, StateError
from planner.collision import make_checker
from planner.kinematics.forward import tool_pose
from planner.kinematics.manipulability import manipulability
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle, Sphere
from planner.session.gate import Gate
from planner.session.verdict import Verdict
from planner.trajectory.limits import MotionLimits
from tests.worlds import load

FAR = Obstacle("ball", Sphere(0.05), pose([0.0, 0.0, 3.0]))
TIMES = np.array([0.25, 0.5, 0.75])
HERE = np.array([0.3, 0.4])
STEP = np.array([0.02, -0.02])
STATE = HERE, np.zeros(2)


def gate_of(*obstacles: Obstacle, **options: Any) -> Gate:
    return Gate(load("planar_2r"), Scene("x", obstacles or (FAR,)), **options)


@cache
def gate() -> Gate:
    return gate_of()


def steps(step: np.ndarray = STEP, count: int = 3) -> np.ndarray:
    return HERE + np.arange(1, count + 1)[:, None] * step


def tip(q: np.ndarray) -> np.ndarray:
    return tool_pose(load("planar_2r"), q).translation


def test_lines_cubics_and_quintics_are_what_the_controller_runs() -> None:
    rng = np.random.default_rng(0)
    robot = load("panda")
    for kind in KINDS:
        chunk = random_chunk(robot, kind, 6, 0.7, rng)
        columns, named = chunk.arguments()
        judged = planner.Gate(robot, Scene("x", (FAR,)), judged=()).check(*columns, **named)._run()
        for k, one in enumerate(motion_of(chunk)):
            u = np.linspace(0.0, 1.0, 7)
            ours = np.vander(u, judged.coefficients.shape[1], increasing=True) @ judged.coefficients[k]
            np.testing.assert_allclose(ours, one.at(u * one.seconds), atol=1e-12)


def test_the_way_to_a_point_at_0_s_is_proven() -> None:
    """Where that may be far from the robot, what stands between is seen, and said to be there."""
    away = HERE + np.array([0.6, 0.0])
    ball = Obstacle("ball", Sphere(0.01), pose(tip(0.5 * (HERE + away))))
    chunk = np.vstack([away, away + STEP, away + 2 * STEP]), {"times": [0.0, 0.25, 0.5]}
    assert gate_of(ball).check(chunk[0], **chunk[1], state=(away, np.zeros(2))).safe
    found = gate_of(ball, start_tolerance=1.0).check(chunk[0], **chunk[1], state=STATE)
    assert found.reason is not None
    assert (found.reason.kind, found.reason.on, found.reason.pair) == ("contact", "start", ("link_2", "ball"))


@pytest.mark.parametrize(("kind", "order"), [("velocity", 1), ("acceleration", 2), ("jerk", 3)])
def test_limits_are_judged_by_exact_extrema_and_may_be_left_out(kind: str, order: int) -> None:
    robot = load("planar_2r")
    plain, zeros = MotionLimits.from_robot(robot), np.zeros((3, 2))
    chunk = {"times": TIMES, "state": (*STATE, np.zeros(2))}
    wide = replace(plain, **{name: 1e3 * getattr(plain, name) for name in ("velocity", "acceleration", "jerk")})
    for one in motion_of_quintics():
        peak = one.largest(order).max() if one.begin == 0.0 else None
        if peak is None:
            continue
        for share, safe in ((1.001, True), (0.999, False)):
            tight = replace(wide, **{kind: np.full(2, share * peak)})
            found = Gate(robot, Scene("x", (FAR,)), limits=tight).check(steps(), zeros, zeros, **chunk, stop=False)
            assert found.safe is safe
            if not safe:
                assert found.reason is not None
                assert (found.reason.kind, found.reason.on, found.reason.limit) == ("limit", "motion", kind)
                judged = [name for name in ("position", "velocity", "acceleration", "jerk") if name != kind]
                left_out = Gate(robot, Scene("x", (FAR,)), limits=tight, judged=judged)
                assert left_out.check(steps(), zeros, zeros, **chunk, stop=False).safe


def motion_of_quintics() -> list[Any]:
    knots = np.zeros((4, 3, 2))
    knots[:, 0] = np.vstack([HERE, steps()])
    return motion_of(Chunk("quintics", np.array([0.0, *TIMES]), knots))


def test_stops_keep_the_limits_exactly_end_at_rest_and_go_on_evenly() -> None:
    rng, robot = np.random.default_rng(3), load("panda")
    gate = Gate(robot, Scene("x", (FAR,)))
    stopped = 0
    for kind in KINDS * 4:
        chunk = random_chunk(robot, kind, 8, 0.5, rng)
        columns, named = chunk.arguments()
        found = gate.check(*columns, **named)
        stop = found.stop
        if stop is None:
            assert not found.safe
            continue
        stopped += 1
        k = int(np.searchsorted(chunk.times, found.safe_until - 1e-9))
        np.testing.assert_allclose(stop.columns[0][0], chunk.knots[k, 0])
        motion = motion_of(chunk)[max(k - 1, 0)]
        if k:
            end = np.array([motion.seconds])
            np.testing.assert_allclose(stop.columns[1][0], motion.at(end, 1)[0], atol=1e-9)
            if kind != "lines":
                np.testing.assert_allclose(stop.columns[2][0], motion.at(end, 2)[0], atol=1e-7)
        assert not stop.columns[1][-1].any()
        assert not stop.columns[2][-1].any()
        for order, most in enumerate((gate.limits.velocity, gate.limits.acceleration, gate.limits.jerk), 1):
            assert (stop.largest(order) <= most * (1.0 + 2e-6)).all()
        low, high = stop.extrema()
        assert (low >= robot.lower - 1e-8).all()
        assert (high <= robot.upper + 1e-8).all()
    assert stopped > 6


def brought_to(end: tuple[np.ndarray, np.ndarray, np.ndarray], gate: Gate, seconds: float = 0.02) -> Verdict:
    """The verdict on a chunk of one point that is reached at an even acceleration."""
    q, v, a = end
    begin = q - seconds * v + 0.5 * seconds**2 * a, v - seconds * a, a
    return gate.check(*(row[None] for row in end), times=[seconds], state=begin)


@pytest.mark.parametrize("near", ["positions", "jerk", "velocity"])
def test_no_stop_from_any_state_is_beyond_a_limit(near: str) -> None:
    """States from which that is a near thing: turning round before a limit, braking already, or nearly too fast."""
    rng, robot, eased, stopped = np.random.default_rng(8), load("planar_2r"), 0, 0
    limits = MotionLimits.from_robot(robot)
    if near == "jerk":
        limits = replace(limits, jerk=10.0 * limits.acceleration)
    gate = Gate(robot, Scene("x", (FAR,)), limits=limits)
    for _ in range(600):
        v = rng.uniform(-0.3, 0.3, 2) * limits.velocity
        a = -np.sign(v) * rng.uniform(0.0, 0.95, 2) * limits.acceleration
        q = np.array([0.3, 0.4])
        if near == "velocity":
            v[0], a[0] = 0.985 * limits.velocity[0], 0.6 * limits.acceleration[0]
            v[1] = a[1] * rng.uniform(-1.2, 0.0) * abs(a[0]) / limits.jerk[0]  # turns round while the other eases off
        if near != "jerk":  # where it turns round before that limit, or just behind
            side = np.where(v > 0, robot.upper, robot.lower)
            depth = 0.5 * v**2 / np.maximum(np.abs(a), 1e-3)
            k = 1 if near == "velocity" else int(rng.integers(2))
            q[k] = side[k] - np.sign(v[k]) * min(1.0, rng.uniform(0.3, 3.0) * depth[k])
        found = brought_to((q, v, a), gate)
        if not found.safe or found.stop is None:
            continue
        stopped, eased = stopped + 1, eased + (len(found.stop.seconds) == 2)
        for order, most in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1):
            assert (found.stop.largest(order) <= most * (1.0 + 2e-6)).all()
        low, high = found.stop.extrema()
        assert (low >= robot.lower - 1e-8).all()
        assert (high <= robot.upper + 1e-8).all()
    assert stopped > 20
    assert (eased > 20) == (near == "velocity")


def test_a_chunk_that_cannot_be_left_any_more_is_not_safe() -> None:
    """It ends at speed before a wall: the chunk is free, every stop from its last points is not."""
    step = np.array([0.1, 0.0])
    points = steps(step, 6)
    wall = Obstacle("wall", Sphere(0.03), pose(tip(points[-1] + 0.6 * step)))
    times = 0.1 * np.arange(1, 7)
    gate = gate_of(wall)
    alone = gate.check(points, times=times, state=(HERE, step / 0.1), stop=False)
    found = gate.check(points, times=times, state=(HERE, step / 0.1))
    assert alone.safe
    assert not found.safe
    assert found.reason is not None
    assert found.reason.on == "stop"
    assert found.stop is not None
    k = round(found.safe_until / 0.1)
    assert 0 < k < 6
    assert gate.check(points[:k], times=times[:k], state=(HERE, step / 0.1)).safe
    assert not gate.check(points[: k + 1], times=times[: k + 1], state=(HERE, step / 0.1)).safe
    assert str(found).startswith(f"unsafe at {found.first_bad:g} s")


def test_verdicts_agree_with_coal_in_clutter() -> None:
    rng, robot = np.random.default_rng(5), load("panda")
    gate = Gate(robot, Scene("x", clutter(10, rng)), judged=())
    judge, seen = make_checker(robot, gate.scene, "coal"), []
    for k in range(24):
        chunk = random_chunk(robot, KINDS[k % 3], 10, 1.0, rng)
        columns, named = chunk.arguments()
        seen.append(gate.check(*columns, **named, stop=False).safe)
        states = np.concatenate([one.at(np.linspace(0.0, one.seconds, 60)) for one in motion_of(chunk)])
        assert seen[-1] is (judge.first_contact(states) is None)
    assert 5 < sum(seen) < 20


def test_the_floor_is_kept_by_motion_and_stops() -> None:
    robot = load("planar_2r")
    bent, straight = np.array([0.3, 1.2]), np.array([0.3, 0.02])
    points = np.linspace(bent, straight, 9)
    w = manipulability(robot, points)
    floor = float(w[5])
    times = 0.5 * np.arange(1, 9)
    found = gate_of(min_manipulability=floor).check(points[1:], times=times, state=(bent, np.zeros(2)), stop=False)
    assert gate_of().check(points[1:], times=times, state=(bent, np.zeros(2))).safe
    assert found.reason is not None
    assert (found.reason.kind, found.reason.on) == ("floor", "motion")
    assert found.safe_until in (times[3], times[4])
    stops = gate_of(min_manipulability=floor).check(points[1:5], times=times[:4], state=(bent, np.zeros(2)))
    assert stops.safe
    ends = manipulability(robot, stops.stop.knots())[-1] if stops.stop else 0.0
    assert ends >= floor
    higher = gate_of(min_manipulability=float(ends) + 1e-4).check(
        points[1:5], times=times[:4], state=(bent, np.zeros(2))
    )
    assert higher.reason is not None
    assert higher.reason.kind == "floor"


BAD: dict[str, tuple[type[PlannerError], dict[str, Any], str]] = {
    "empty": (ArrayError, {"positions": np.zeros((0, 2)), "times": []}, "a point or more"),
    "a NaN": (ArrayError, {"positions": np.full((3, 2), np.nan)}, "finite"),
    "no velocities": (ArrayError, {"accelerations": np.zeros((3, 2))}, "need velocities"),
    "not increasing": (ArrayError, {"times": [0.1, 0.3, 0.2]}, r"times\[2\]"),
    "one point": (ArrayError, {"positions": np.zeros((1, 2)), "times": [0.1], "state": None}, "got one point"),
    "state shape": (StateError, {"state": (np.zeros(3), np.zeros(3))}, "state"),
    "state outside": (StateError, {"state": (np.array([50.0, 0.0]), np.zeros(2))}, "state of joint"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gets_one_sentence_and_the_gate_goes_on(case: str) -> None:
    error, changed, text = BAD[case]
    with pytest.raises(error, match=text) as caught:
        gate().check(**{"positions": steps(), "times": TIMES, "state": STATE, **changed})
    assert str(caught.value).endswith(".")
    assert "\n" not in str(caught.value)
    assert gate().check(steps(), times=TIMES, state=STATE).safe


@pytest.mark.parametrize("times", [TIMES, [0.0, 0.2, 0.4]])
def test_a_robot_that_is_too_fast_already_is_not_safe_on_lines_either(times: list[float]) -> None:
    """A line does not begin with the robot's velocity, but the robot does."""
    most = gate().limits.velocity
    points = HERE + np.array(times)[:, None] * 0.1
    for share, safe in ((0.99, True), (1.01, False), (-50.0, False)):
        found = gate().check(points, times=times, state=(HERE, share * most * [0, 1]), stop=False)
        assert found.safe == safe
        assert safe or found.safe_until == 0.0
    free = gate_of(FAR, judged=("position",))
    assert free.check(points, times=times, state=(HERE, 50.0 * most), stop=False).safe


def test_a_wheel_that_controllers_may_turn_either_way_is_refused() -> None:
    """Some controllers take the short way round to the first point, others the one that is proven here."""
    robot = load("kinova")
    asked, joint = Gate(robot, Scene("x", (FAR,))), int(np.flatnonzero(robot.continuous)[0])
    here = 0.5 * (np.where(robot.continuous, 0.0, robot.lower) + np.where(robot.continuous, 0.0, robot.upper))
    there = here.copy()
    for here[joint], there[joint] in ((0.0, np.pi), (0.3 - np.pi, 0.3), (-3.1, 3.1)):
        with pytest.raises(StateError, match="less than half a turn"):
            asked.check(there[None], times=[5.0], state=(here, 0 * here))
    here[joint] += 2 * np.pi
    assert asked.check(there[None], times=[5.0], state=(here, 0 * here), stop=False).safe_until in (0.0, 5.0)


def same(one: Verdict, other: Verdict) -> bool:
    fields = ("safe", "safe_until", "reason", "first_bad", "notes")
    return all(getattr(one, name) == getattr(other, name) for name in fields)


def beside(gap: float) -> Gate:
    """A plate above the plane that the arm moves in, ``gap`` (m) away from its links all along."""
    robot = load("planar_2r")
    high = 1.0
    plate = Obstacle("plate", Box((3.0, 3.0, 0.02)), pose([0.0, 0.0, high]))
    judge = make_checker(robot, Scene("x", (plate,)), "coal")
    moving = np.flatnonzero([body.joint > 0 for body in robot.bodies])
    rotation, position = judge.chain.native.placements(np.array([[0.3, 0.4]]))
    away = judge.distances(rotation[:, 0], position[:, 0], moving).min()
    plate = Obstacle("plate", Box((3.0, 3.0, 0.02)), pose([0.0, 0.0, high - float(away) + gap]))
    allowed = frozenset(frozenset((body.link, "plate")) for body in robot.bodies if body.joint == 0)
    return Gate(robot, Scene("x", (plate,), allowed=allowed))


def test_undecided_counts_as_unsafe_and_is_said() -> None:
    """A link passes 20 micrometres beside a wall: nearer than proofs resolve, without a contact."""
    found = beside(2e-5).check(steps(), times=TIMES, state=STATE)
    assert found.reason is not None
    assert (found.safe, found.reason.kind) == (False, "undecided")
    assert beside(2e-3).check(steps(), times=TIMES, state=STATE).safe
    touching = beside(-1e-3).check(steps(), times=TIMES, state=STATE)
    assert touching.reason is not None
    assert touching.reason.kind == "contact"


def test_what_is_kept_is_kept_by_the_motion_and_by_its_stops() -> None:
    """The tool of the arm, 1 m long each link, stays above a line; the stop of a fast chunk would cross it."""
    constraint = planner.PlaneConstraint((0.0, 1.0, 0.0), 0.0)
    gate, free = planner.Gate("planar_2r", "empty", constraint=constraint), planner.Gate("planar_2r", "empty")
    here, times = (np.array([0.5, 0.0]), np.zeros(2)), [2.0, 4.0]
    above, across = np.array([[0.4, 0.0], [0.3, 0.0]]), np.array([[0.2, 0.0], [-0.2, 0.0]])
    assert gate.check(above, np.zeros((2, 2)), times=times, state=here).safe
    assert free.check(across, np.zeros((2, 2)), times=times, state=here).safe
    verdict = gate.check(across, np.zeros((2, 2)), times=times, state=here)
    assert not verdict.safe
    assert not verdict
    assert len(repr(verdict)) < 300
    assert verdict.reason is not None
    assert (verdict.reason.kind, verdict.reason.on, verdict.safe_until) == ("constraint", "motion", 2.0)
    assert constraint.text in str(verdict)
    fast = np.array([[0.3, 0.0], [0.02, 0.0]]), np.array([[0.0, 0.0], [-1.0, 0.0]])
    assert free.check(*fast, times=times, state=here).safe
    verdict = gate.check(*fast, times=times, state=here)
    assert verdict.reason is not None
    assert (verdict.reason.kind, verdict.reason.on) == ("constraint", "stop")
