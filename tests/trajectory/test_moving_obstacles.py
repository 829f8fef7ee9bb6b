"""Horizons and first contacts in time, where a formula says when."""

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.coal import CoalInTime
from planner.collision.timed_prover import TimedProver, moving_world
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle, Sphere
from planner.trajectory.moving_obstacles import first_touch_in_time, prove_in_time
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load

STILL = Trajectory.from_points(("joint_1", "joint_2"), np.array([0.0, 4.0]), np.zeros((2, 2)))


@pytest.mark.parametrize("limit", [0.1, 0.4, 2.0])
def test_the_horizon_of_a_standing_arm_is_distance_over_speed(limit: float) -> None:
    dog = Obstacle("dog", Sphere(0.1), pose([2.0, 0, 0]), speed_limit=limit)
    checker = make_checker(load("planar_2r"), Scene("dog", (dog,)))
    prover = TimedProver(checker, limited=[dog])
    gap = float(prover.gaps(np.zeros(2)).min())
    until = prove_in_time(STILL, checker).free_until
    assert 0.99 * gap / limit <= until <= gap / limit
    assert prove_in_time(STILL, checker).to_dict() == {"horizon": {"free_until": until, "speed_limits": {"dog": limit}}}


def test_coal_sees_a_ball_when_it_arrives() -> None:
    ball = MovingObstacle("ball", Sphere(0.1), KnownMotion([0, 4], [pose([2.0, 0, 0]), pose([0.8, 0, 0])]))
    checker = make_checker(load("planar_2r"), Scene("ball", moving=(ball,)))
    gap = float(TimedProver(checker, [ball]).gaps(np.zeros(2)).min())
    found = first_touch_in_time(STILL, checker, [ball], 1e-3)
    assert found is not None
    assert found[0] == pytest.approx(gap / 0.3, abs=0.01)
    assert not prove_in_time(STILL, checker).whole
    early = Trajectory.from_points(STILL.joints, np.array([0.0, 0.9 * gap / 0.3]), np.zeros((2, 2)))
    assert first_touch_in_time(early, checker, [ball], 1e-3) is None
    assert prove_in_time(early, checker).whole


@pytest.mark.parametrize("seed", range(8))
def test_the_first_contact_is_the_one_of_a_look_at_every_moment(seed: int) -> None:
    rng, checker = np.random.default_rng(seed), make_checker(load("planar_2r"), Scene("none"))
    times, places = np.array([0.0, 1.0, 1.001, 2.5, 4.0]), rng.uniform(-1.2, 1.2, (5, 2))
    ball = MovingObstacle("ball", Sphere(0.05), KnownMotion(times, [pose([*place, 0.0]) for place in places]))
    run = Trajectory.from_points(STILL.joints, np.array([0.0, 4.0]), rng.uniform(-2, 2, (2, 2)))
    looks = np.sort(np.concatenate([np.linspace(0, 4, 6001), np.linspace(1, 1.001, 3000)]))
    seen = CoalInTime(moving_world(checker.world, [ball.standing()]), {"ball": ball.motion}).first_touch(
        run.at(looks), looks
    )
    found = first_touch_in_time(run, checker, [ball], 1e-3)
    assert (found is None) == (seen is None)
    if found is not None and seen is not None:
        assert found[0] == pytest.approx(looks[seen[0]], abs=2e-3)
        assert found[1] == seen[1]
