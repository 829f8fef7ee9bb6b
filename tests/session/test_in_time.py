"""Planning in time: what is found is proven, touches at no sampled moment, waits, and says how long it holds."""

from dataclasses import replace

import numpy as np

from planner.collision.checker import CollisionChecker, is_free
from planner.collision.fcl import FclChecker
from planner.collision.timed_prover import moving_world
from planner.kinematics.forward import tool_positions
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.shapes import Box, Obstacle, Sphere
from planner.session.session import Session
from planner.trajectory.timing import time_path
from planner.trajectory.trajectory import Trajectory
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap

ACROSS = KnownMotion([0, 3, 6, 9], [pose(p) for p in ([1.2, 0.9, 0], [0.3, -0.5, 0], [0.3, -0.5, 0], [-1.5, -1.5, 0])])
CART = MovingObstacle("cart", Box((0.2, 0.2, 0.2)), ACROSS)
VAN = MovingObstacle("van", Box((0.2, 0.2, 0.2)), KnownMotion([0, 9], [pose([5.0, 5.0, 0.0])] * 2))  # out of reach
DOG = Obstacle("dog", Sphere(0.05), pose([-1.2, 1.2, 0]), speed_limit=0.2)


def fresh(*obstacles: Obstacle | MovingObstacle) -> Session:
    session = Session(load("planar_2r"), make_post().world.scene, roadmap=post_roadmap(), join_motions=300)
    for obstacle in obstacles:
        session.add(obstacle)
    return session


def clear(checker: CollisionChecker, obstacle: Obstacle, q: np.ndarray) -> bool:
    """Whether the arm does not touch the obstacle, by FCL."""
    return is_free(FclChecker(moving_world(checker.world, (obstacle,))), q)


def touched(session: Session, trajectory: Trajectory, moving: MovingObstacle) -> bool:
    """Whether FCL sees a contact at any of many moments."""
    times = np.linspace(0.0, trajectory.times[-1] + 3.0, 200)
    return not all(clear(session.checker, moving.standing(t), trajectory.at(t)[0]) for t in times)


def test_a_motion_among_what_moves_waits_is_proven_and_touches_at_no_moment() -> None:
    session = fresh(VAN)
    alone = session.plan(POST_START, POST_GOAL)
    assert alone.trajectory is not None
    assert alone.trajectory.proven
    assert alone.route is not None
    assert not alone.route.waits.any()
    assert touched(session, alone.trajectory, CART)
    session.add(CART)
    answer = session.replan()
    assert answer.trajectory is not None
    assert answer.trajectory.proven
    assert answer.trajectory.duration > alone.trajectory.duration
    assert answer.route is not None
    assert answer.route.waits.any()
    assert not touched(session, answer.trajectory, CART)
    assert answer.trajectory.proof["moving"]["obstacles"] == ["van", "cart"]
    np.testing.assert_array_equal(answer.trajectory.at(0.0)[0], POST_START)
    np.testing.assert_allclose(answer.trajectory.at(answer.route.arrivals[-1])[0], POST_GOAL, atol=1e-9)
    session.remove("cart")
    again = session.plan(POST_START, POST_GOAL)
    np.testing.assert_array_equal(again.path, alone.path)


def test_a_horizon_holds_whatever_the_obstacle_does_below_its_limit() -> None:
    session, rng, late = fresh(DOG), np.random.default_rng(0), 0
    path = session.plan(POST_START, POST_GOAL, timing=None).path
    trajectory = time_path(path, session.checker)
    until = trajectory.proof["horizon"]["free_until"]
    assert trajectory.proof["horizon"]["speed_limits"] == {"dog": 0.2}
    assert 0 < until < 20
    for run in range(20):
        place, motion = np.array(DOG.placement[:3, 3]), []
        for t in np.linspace(0, 1.5 * until, 25):
            motion.append((t, place.copy()))
            aim = rng.normal(size=3) if run % 2 else np.append(target(session, trajectory, until), 0.0) - place
            place += 0.2 * (1.5 * until / 24) * aim / max(np.linalg.norm(aim), 1e-9)
        there = [(t, replace(DOG, placement=pose(at))) for t, at in motion]
        contacts = [t for t, dog in there if not clear(session.checker, dog, trajectory.at(t)[0])]
        assert not contacts or min(contacts) >= until
        late += bool(contacts)
    assert late > 0  # those that come for the arm do touch it, later on


def target(session: Session, trajectory: Trajectory, t: float) -> np.ndarray:
    return tool_positions(session.robot, trajectory.at(t))[0, :2]
