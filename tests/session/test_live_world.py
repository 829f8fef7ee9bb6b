"""Changes of a world: session and gate know each of them, and what a session knows then holds."""

from contextlib import suppress

import numpy as np
import pinocchio as pin
import pytest

from planner.base.errors import SceneError
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.forward import tool_pose
from planner.problem.request import WorldRequest
from planner.roadmap.roadmap import edge_motions
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.shapes import Box, Obstacle, Sphere
from planner.session.gate import Gate
from planner.session.live_world import LiveWorld
from planner.session.session import Session
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap

FAR = Obstacle("far", Sphere(0.1), pose([0.0, 0.0, 3.0]))
Q = np.array([0.5, 1.0])


def world() -> LiveWorld:
    return LiveWorld(WorldRequest(load("planar_2r"), make_post().world.scene))


def test_what_is_attached_moves_with_the_arm_and_is_put_down_where_it_is_held() -> None:
    live = world()
    live.add(FAR)
    live.attach("far", "link_2", Q)
    held = live.checker
    assert [obstacle.name for obstacle in live.scene.obstacles] == ["thing0"]
    assert [item.name for item in live.scene.carried] == ["far"]
    for turn in (0.0, 0.7):
        live.restore(held)
        live.detach("far", Q + np.array([turn, 0.0]))
        placement = pose(rpy=[0.0, 0.0, turn]) @ FAR.placement
        np.testing.assert_allclose(live.scene.obstacles[-1].placement, placement, atol=1e-12)


def test_a_gate_and_a_session_of_one_world_know_every_change() -> None:
    session = Session(load("planar_2r"), make_post().world.scene, roadmap=post_roadmap())
    gate = Gate(session.world)
    path = session.plan(POST_START, POST_GOAL, timing=None).path
    chunk = {"times": np.arange(len(path)) * 60.0, "stop": False}
    assert gate.check(path, **chunk).safe
    revision = gate.world.now[1]
    session.add(Obstacle("ball", Sphere(0.05), tool_pose(session.robot, path[1]).homogeneous))
    verdict = gate.check(path, **chunk)
    assert not verdict.safe
    assert verdict.revision == gate.world.now[1] > revision
    assert not session.holds()
    gate.world.remove("ball")
    np.testing.assert_array_equal(session.replan().path, path)
    gate.world.add(MovingObstacle("cart", Sphere(0.1), KnownMotion([0, 1], [pose(), pose()])))
    with pytest.raises(SceneError, match="known motion"):
        gate.check(path, **chunk)


@pytest.mark.parametrize("seed", range(4))
def test_a_session_that_looks_away_knows_what_one_that_looks_knows(seed: int) -> None:
    """Any changes, made behind its back: what is free then is what a prover of the whole world proves."""
    rng, session = (
        np.random.default_rng(seed),
        Session(load("planar_2r"), make_post().world.scene, roadmap=post_roadmap()),
    )
    live = session.world
    for _ in range(8):
        for _ in range(rng.integers(1, 6)):
            change_at_random(live, rng)
        known = session.live
        known = known.prove(np.flatnonzero(known.proofs.open))
        proofs = EdgeProver(make_checker(live.robot, live.scene)).prove(
            *edge_motions(known.roadmap, live.robot, np.arange(len(known.roadmap.edges)))
        )
        np.testing.assert_array_equal(known.proofs.free, proofs.free)
        if rng.integers(2):
            session._live = known


def change_at_random(live: LiveWorld, rng: np.random.Generator) -> None:
    names, carried = [item.name for item in live.scene.obstacles], [item.name for item in live.scene.carried]
    place, q = [*rng.uniform(-0.9, 0.9, 2), 0.0], rng.uniform(-2.0, 2.0, 2)
    with suppress(SceneError):
        match rng.integers(5):
            case 0:
                live.add(Obstacle(f"box {rng.integers(3)}", Box(tuple(rng.uniform(0.02, 0.15, 3))), pose(place)))
            case 1 if names:
                live.remove(str(rng.choice(names)))
            case 2 if names:
                live.attach(str(rng.choice(names)), "link_2", q, [["link_2"], ["link_1", "link_2"]][rng.integers(2)])
            case 3 if carried:
                live.detach(str(rng.choice(carried)), q)
            case _ if names:
                live.move(str(rng.choice(names)), place)


def test_a_gate_and_a_session_take_another_tool() -> None:
    assert Gate("planar_2r", None, tool="link_1").robot.tool == "link_1"
    assert Session("planar_2r", None, tool="link_1", nodes=4).robot.tool == "link_1"


def test_dicts_and_matrices_are_taken_as_obstacles_and_poses() -> None:
    session, one = Session("planar_2r", None, nodes=4), pose([0.0, 0.0, 3.0], rpy=[0.1, 0.2, 0.3])
    assert session.scene.name == Gate("planar_2r", None).scene.name == "empty"
    session.add({"name": "far", "type": "sphere", "radius": 0.1, "position": [0.0, 0.0, 3.0]})
    np.testing.assert_array_equal(session.scene.obstacles[0].placement, FAR.placement)
    for given in (one, pin.SE3(np.array(one))):
        session.move("far", [0.0, 1.0, 3.0])
        session.move("far", given)
        np.testing.assert_array_equal(session.scene.obstacles[0].placement, one)
    session.add({"type": "box", "size": [0.1, 0.1, 0.1], "motion": [{"t": 0, "position": [0, 0, 2]}, {"t": 1}]})
    assert [item.name for item in session.scene.moving] == ["box_0"]
    with pytest.raises(SceneError, match="got 'far'"):
        session.add({"name": "far", "type": "sphere", "radius": 0.1})
