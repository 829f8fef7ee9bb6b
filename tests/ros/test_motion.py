"""Motions that the node sends: the points of a message, replayed by scipy, are what the gate has proven."""

import numpy as np
import pytest

import planner
from planner.base.arrays import Floats
from planner.ros.motion import Motion, check_rest, make_motion, stop_motion
from tests.controller import follow

ROBOT = planner.Robot.load("planar_2r")


def make_chunk(seed: int, columns: int, first: float) -> tuple[list[Floats], Floats, list[Floats]]:
    """A smooth chunk from the state of the robot, whose first point is after ``first`` s."""
    rng = np.random.default_rng(seed)
    times, factors = first + 0.1 * np.arange(8), rng.uniform(-0.5, 0.5, (4, 2))
    factors[1] = np.copysign(1.0, factors[1])
    powers = np.arange(4)[:, None]

    def curve(t: Floats, order: int) -> Floats:
        scale = np.array([np.prod(k - np.arange(order)) for k in range(4)])[:, None]
        return sum(scale[k] * factors[k] * t[:, None] ** max(k - order, 0) for k in powers[order:, 0])

    state = [curve(np.zeros(1), order)[0] for order in range(2)]
    return [curve(times, order) for order in range(columns)], times, state


def open_gate(obstacle_at: Floats | None = None) -> planner.Gate:
    """A gate, with a disc where the tool is at a configuration."""
    limits = planner.MotionLimits.from_robot(ROBOT, planner.LimitsRequest(acceleration=50.0, jerk=5000.0))
    gate = planner.Gate(ROBOT, "empty", limits=limits)
    if obstacle_at is not None:
        put_disc(gate, obstacle_at)
    return gate


def put_disc(gate: planner.Gate, q: Floats) -> None:
    gate.world.add(planner.Obstacle("disc", planner.Cylinder(0.02, 0.2), ROBOT.fk(q)))


def replay(motion: Motion, state: list[Floats], times: Floats) -> Floats:
    return follow(list(motion.points()), state, times)


def end_of(motion: Motion) -> float:
    return float(motion.parts[-1].times[-1])


CASES = [(seed, columns, first) for seed in range(5) for columns in (1, 2, 3) for first in (0.0, 0.05)]
cases = pytest.mark.parametrize(("seed", "columns", "first"), CASES)


@cases
@pytest.mark.parametrize("blocked", [False, True])
def test_a_controller_runs_what_is_proven(seed: int, columns: int, first: float, blocked: bool) -> None:
    given, times, state = make_chunk(seed, columns, first)
    gate = open_gate(given[0][-1] if blocked else None)
    verdict = gate.check(*given, times=times, state=state)
    assert verdict.safe != blocked
    motion = make_motion(ROBOT.joints, given, times, state, verdict)
    assert motion is not None
    clock = np.linspace(0.0, end_of(motion) + 0.1, 400)
    assert np.allclose(replay(motion, state, clock), verdict.positions_at(clock), atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("columns", [1, 2, 3])
def test_a_slower_chunk_is_sent_with_its_stop(seed: int, columns: int) -> None:
    given, times, (q, qd) = make_chunk(seed, columns, first=0.05)
    state = [q, 0.7 * qd]  # within limits
    limits = planner.MotionLimits.from_robot(ROBOT, planner.LimitsRequest(velocity_scale=0.4))
    gate = planner.Gate(ROBOT, "empty", judged=["position", "velocity"], limits=limits)
    verdict = gate.check(*given, times=times, state=state)
    motion = make_motion(ROBOT.joints, given, times, state, verdict, slow=True)
    assert motion is not None
    assert motion.parts[0].duration > 1.05 * times[-1]
    clock = np.linspace(0.0, end_of(motion) + 0.1, 400)
    assert np.allclose(replay(motion, state, clock), verdict.slower.positions_at(clock), atol=1e-9)
    assert np.allclose(motion.parts[0].at(end_of(motion))[0], given[0][-1])


@cases
def test_the_rest_of_a_motion_is_checked_and_stopped_when_the_world_changes(
    seed: int, columns: int, first: float
) -> None:
    given, times, state = make_chunk(seed, columns, first)
    gate = open_gate()
    motion = make_motion(ROBOT.joints, given, times, state, gate.check(*given, times=times, state=state))
    assert motion is not None
    end, instants = end_of(motion), np.random.default_rng(seed).uniform(0.0, 0.4, 4)
    for t in [*instants, times[1] - 2e-9, times[1] - 1e-6, end - 1e-3]:
        assert check_rest(gate, motion, t) is None
    assert check_rest(gate, motion, end + 1.0) is None
    put_disc(gate, given[0][-1])
    judge = planner.make_checker(ROBOT, gate.scene, backend="coal")
    for t in instants:
        verdict = check_rest(gate, motion, t)
        assert verdict is not None
        stop = stop_motion(gate, motion, t)
        now = [replay(motion, state, t + np.array([0.0, 1e-6]))[0], motion_velocity(motion, t)]
        rows = replay(stop, now, np.linspace(0.0, end_of(stop), 500))
        assert np.allclose(rows[0], now[0], atol=1e-6)
        assert np.allclose(rows[-1], rows[-2], atol=1e-4)
        assert stop.proven == (judge.first_contact(rows) is None)


@pytest.mark.parametrize("columns", [1, 2, 3])
def test_a_stop_without_a_proof_follows_the_curve_and_says_so(columns: int) -> None:
    given, times, state = make_chunk(0, columns, first=0.0)
    limits = planner.MotionLimits.from_robot(ROBOT, planner.LimitsRequest(acceleration=8.0))
    gate, t = planner.Gate(ROBOT, "empty", judged=["position", "velocity", "acceleration"], limits=limits), 0.3
    motion = make_motion(ROBOT.joints, given, times, state, gate.check(*given, times=times, state=state))
    assert motion is not None
    put_disc(gate, replay(motion, state, np.array([t + 0.06]))[0])
    stop = stop_motion(gate, motion, t)
    assert not stop.proven
    curve = replay(motion, state, np.linspace(t, end_of(motion), 5000))
    rows = replay(stop, [curve[0], motion_velocity(motion, t)], np.linspace(0.0, end_of(stop), 100))
    assert np.abs(rows[:, None] - curve).max(axis=2).min(axis=1).max() < 1e-3
    assert np.allclose(rows[-1], rows[-2], atol=1e-3)


def motion_velocity(motion: Motion, t: float) -> Floats:
    return next(motion.rest(t))[2][1]
