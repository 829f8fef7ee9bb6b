"""Declared contacts: only the pair may touch, only in time and only inside the region."""

import threading
from functools import cache

import numpy as np
import pytest

from benchmarks.gate.chunks import KINDS, Chunk, random_chunk
from benchmarks.gate.judge import Spline, motion_of, stops_of
from planner.base.errors import PlannerError, SceneError
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, contact_at
from planner.kinematics.forward import joint_placements, tool_pose
from planner.problem.request import WorldRequest
from planner.robot.clouds import Points
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle, Sphere, corners
from planner.session.gate import Gate
from planner.session.live_world import LiveWorld
from planner.session.session import Session
from planner.session.verdict import Verdict
from tests.worlds import load

READY = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.785])
FAR = Obstacle("far", Sphere(0.05), pose([0.0, 0.0, 3.0]))
PAIR = "link_2", "ball"


@cache
def ball() -> Obstacle:
    return Obstacle("ball", Sphere(0.05), pose(tool_pose(load("planar_2r"), np.array([0.5, 0.4])).translation))


def through_the_ball(seconds: float = 1.0) -> Chunk:
    """Past the ball: the second link touches it in the middle."""
    t = np.linspace(0.0, seconds, 21)
    knots = np.zeros((21, 3, 2))
    knots[:, 0] = np.array([0.5, 0.4]) + np.outer(t / seconds - 0.5, [1.0, 0.2])
    knots[:, 1] = np.array([1.0, 0.2]) / seconds
    return Chunk("cubics", t, knots)


def verdict_on(gate: Gate, chunk: Chunk, stop: bool = True) -> Verdict:
    columns, named = chunk.arguments()
    return gate.check(*columns, **named, stop=stop)  # pyright: ignore[reportArgumentType]


def contacts(curves: list[Spline], checker: CollisionChecker, count: int = 50) -> tuple[np.ndarray, np.ndarray]:
    """Times and states of contact on curves, by samples."""
    times = np.concatenate([one.begin + np.linspace(0.0, one.seconds, count) for one in curves])
    states = np.concatenate([one.at(np.linspace(0.0, one.seconds, count)) for one in curves])
    touching = np.array([contact_at(checker, q) is not None for q in states])
    return times[touching], states[touching]


def test_a_contact_for_a_time_ends_within_the_chunk() -> None:
    gate, chunk = Gate(load("planar_2r"), Scene("x", (ball(),))), through_the_ball()
    coal = make_checker(gate.robot, gate.scene, "coal")
    assert not verdict_on(gate, chunk).safe
    times, _ = contacts(motion_of(chunk), coal)
    first, last = times.min(), times.max()
    assert 0.2 < first < last < 0.8
    answers = []
    for seconds in np.linspace(0.1, 1.5, 11):
        gate.allow(*PAIR, seconds=seconds)
        alone, verdict = verdict_on(gate, chunk, stop=False), verdict_on(gate, chunk)
        assert any("may touch" in note for note in verdict.notes)
        assert alone.safe == (seconds > last) or abs(seconds - last) < 0.03
        answers.append(verdict.safe)
        if verdict.safe:
            curves = motion_of(chunk) + (stops_of(chunk, verdict) or [])
            assert contacts(curves, coal)[0].max() <= seconds
        else:
            assert verdict.reason is not None
            assert (verdict.reason.pair, verdict.reason.kind) == (PAIR, "contact")
    assert answers == sorted(answers)
    assert (answers[0], answers[-1]) == (False, True)


def test_a_contact_in_a_region_is_refused_where_any_part_of_the_link_is_outside() -> None:
    gate, chunk = Gate(load("planar_2r"), Scene("x", (ball(),))), through_the_ball()
    coal = make_checker(gate.robot, gate.scene, "coal")
    link = [body for body in gate.robot.bodies if body.link == "link_2"]
    rng, answers = np.random.default_rng(0), []
    for _ in range(24):
        low, high = rng.uniform(-0.7, 0.2, 3), rng.uniform(0.5, 2.2, 3)
        gate.allow(*PAIR, box=[*low, *high])
        verdict = verdict_on(gate, chunk)
        answers.append(verdict.safe)
        if not verdict.safe:
            continue
        _, states = contacts(motion_of(chunk) + (stops_of(chunk, verdict) or []), coal, 20)
        rotation, position = joint_placements(gate.checker.chain, states)
        for body in link:
            points, radius = corners(body.shape)
            points = points @ body.placement[:3, :3].T + body.placement[:3, 3]
            there = rotation[body.joint] @ points.T + position[body.joint][..., None]
            assert ((there - radius >= low[:, None]) & (there + radius <= high[:, None])).all()
    assert 2 < sum(answers) < 22
    gate.allow(*PAIR, box=[-9, -9, -9, 9, 9, 9])
    assert verdict_on(gate, chunk).safe


def test_only_the_pair_is_exempt() -> None:
    robot = load("panda")
    at = tool_pose(robot, READY).homogeneous
    cup = Obstacle("cup", Box((0.03, 0.2, 0.1)), at)
    gate = Gate(robot, Scene("x", (cup,)))
    chunk = Chunk("lines", np.array([0.0, 0.5]), np.zeros((2, 3, 7)))
    chunk.knots[:, 0] = READY, READY + 0.02
    fingers, seen = ["panda_leftfinger", "panda_rightfinger", "panda_hand"], set()
    for _ in range(4):
        verdict = verdict_on(gate, chunk)
        if verdict.safe:
            break
        assert verdict.reason is not None
        assert verdict.reason.pair is not None
        link, name = verdict.reason.pair
        assert name == "cup"
        assert link not in seen
        seen.add(link)
        gate.allow(link, "cup", seconds=60.0)
    assert seen <= {*fingers}
    assert len(seen) >= 2
    assert verdict_on(gate, chunk).safe
    gate.world.add(Obstacle("wall", Box((0.03, 0.03, 0.03)), at))
    verdict = verdict_on(gate, chunk)
    assert verdict.reason is not None
    assert verdict.reason.pair is not None
    assert verdict.reason.pair[1] == "wall"


def test_a_permission_ends_with_its_time_its_object_and_on_request(monkeypatch: pytest.MonkeyPatch) -> None:
    world = LiveWorld(WorldRequest(load("planar_2r"), Scene("x", (ball(),))))
    gate, chunk = Gate(world), through_the_ball()
    clock = [100.0]
    for module in ("gate", "permissions"):
        monkeypatch.setattr(f"planner.session.{module}.monotonic", lambda: clock[0])
    gate.allow(*PAIR, seconds=2.0)
    assert verdict_on(gate, chunk).safe
    clock[0] = 101.8
    assert not verdict_on(gate, chunk).safe
    clock[0] = 103.0
    late = verdict_on(gate, chunk)
    assert not late.safe
    assert not any("may touch" in note for note in late.notes)
    gate.allow(*PAIR, seconds=2.0)
    gate.forbid(*PAIR)
    assert not verdict_on(gate, chunk).safe
    with pytest.raises(SceneError, match="allow it first"):
        gate.forbid(*PAIR)
    gate.allow(*PAIR, seconds=2.0)
    world.remove("ball")
    world.add(ball())
    assert not verdict_on(gate, chunk).safe
    gate.allow(*PAIR)
    assert frozenset(PAIR) in world.scene.allowed
    assert verdict_on(gate, chunk).safe
    gate.allow(*PAIR, seconds=2.0)
    assert (frozenset(PAIR) in world.scene.allowed, len(world.permissions)) == (False, 1)
    gate.allow(*PAIR)
    assert (frozenset(PAIR) in world.scene.allowed, world.permissions) == (True, ())
    gate.forbid(*PAIR)
    assert not verdict_on(gate, chunk).safe


def test_sessions_plan_as_before_a_contact_for_a_time() -> None:
    world = LiveWorld(WorldRequest(load("planar_2r"), Scene("x", (ball(),))))
    gate, session = Gate(world), Session(world, nodes=60)
    gate.allow(*PAIR, seconds=60.0)
    middle = np.array([0.5, 0.4])
    assert verdict_on(gate, through_the_ball()).safe
    with pytest.raises(PlannerError, match="ball"):
        session.plan(middle, middle + 0.8)
    gate.allow(*PAIR)
    assert session.plan(middle, middle + 0.1).solved


def test_an_obstacle_in_the_base_is_refused_as_before() -> None:
    gate = Gate(load("panda"), Scene("x", (FAR,)))
    gate.allow("panda_link0", "far", seconds=9.0)
    with pytest.raises(SceneError, match="panda_link0"):
        gate.world.put("far", pose([0.0, 0.0, 0.1]))
    gate.allow("panda_link0", "far")
    gate.allow("panda_link1", "far")
    gate.world.put("far", pose([0.0, 0.0, 0.1]))
    with pytest.raises(SceneError, match="panda_link0"):
        gate.forbid("panda_link0", "far")
    assert frozenset(("panda_link0", "far")) in gate.scene.allowed


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"seconds": -1.0}, "seconds must be above 0"),
        ({"seconds": np.nan}, "seconds must be above 0"),
        ({"box": [0.0, 1.0]}, "box must have shape"),
        ({"box": [0, 0, 0, 1, 1, 0]}, "box must be x0"),
        ({"box": [0, 0, 0, 1, 1, 1e4]}, "within 100 m"),
        ({"link": "nose"}, "link 'nose' not found"),
        ({"object": "nose"}, "object 'nose' not found"),
    ],
)
def test_bad_permissions_get_one_sentence_and_change_nothing(options: dict, error: str) -> None:
    gate = Gate(load("planar_2r"), Scene("x", (ball(),)))
    with pytest.raises(PlannerError, match=error):
        gate.allow(**{"link": "link_2", "object": "ball"} | options)
    assert gate.world.permissions == ()


def test_points_and_a_box_in_the_hand_are_attached_in_one_call() -> None:
    robot, rng = load("panda"), np.random.default_rng(0)
    gate = Gate(robot, Scene("x", (FAR,)))
    hand = tool_pose(robot, READY).homogeneous
    points = rng.uniform(-0.02, 0.02, (50, 3))
    fingers = ["panda_leftfinger", "panda_rightfinger"]
    for shape, name in ((Points(points, 0.002), "cloud"), (Box((0.04, 0.04, 0.2)), "box")):
        gate.world.attach(Obstacle(name, shape, hand @ pose([0, 0, 0.12])), "panda_hand", READY, fingers)
    gate.world.attach(Obstacle("own", Sphere(0.01), pose([0, 0, 0.5]), frame="panda_hand"), "panda_hand", READY)
    assert [item.name for item in gate.scene.carried] == ["cloud", "box", "own"]
    assert [item.name for item in gate.scene.obstacles] == ["far"]
    there = READY + 0.3
    turned = tool_pose(robot, there).homogeneous @ np.linalg.inv(hand)
    gate.world.detach("cloud", there)
    cloud = next(item for item in gate.scene.obstacles if item.name == "cloud")
    np.testing.assert_allclose(cloud.placement, turned @ hand @ pose([0, 0, 0.12]), atol=1e-9)
    before = gate.scene
    for wrong in (
        Obstacle("own", Sphere(0.01), pose([0, 0, 1])),
        Obstacle("b", Sphere(0.01), pose([0, 0, 1]), frame="x"),
    ):
        with pytest.raises(SceneError):
            gate.world.attach(wrong, "panda_hand", READY)
    assert gate.scene is before


@pytest.mark.parametrize("kind", KINDS)
def test_slowed_chunks_keep_the_permission_too(kind: str) -> None:
    """A slower motion is in contact for longer: the time of the permission still ends it."""
    rng = np.random.default_rng(3)
    gate = Gate(load("planar_2r"), Scene("x", (ball(),)))
    coal = make_checker(gate.robot, gate.scene, "coal")
    for _ in range(40):
        chunk = random_chunk(gate.robot, kind, 5, 1.0, rng, 0.6)
        chunk.knots[:, 0] += np.array([0.5, 0.4]) - chunk.knots[2, 0]
        gate.allow(*PAIR, seconds=float(rng.uniform(0.2, 2.0)))
        verdict = verdict_on(gate, chunk)
        slowed = verdict.slowed
        if slowed is None:
            continue
        until = gate.world.permissions[0].until - verdict._guard.now
        t = np.linspace(0.0, slowed.duration, 200)
        touching = np.array([contact_at(coal, q) is not None for q in slowed.at(t)])
        assert not touching[t > until].any()


def test_threads_check_while_another_allows_and_forbids() -> None:
    gate, chunk = Gate(load("planar_2r"), Scene("x", (ball(),))), through_the_ball()
    stop = threading.Event()

    def change() -> None:
        while not stop.is_set():
            gate.allow(*PAIR, seconds=60.0)
            gate.forbid(*PAIR)

    thread = threading.Thread(target=change)
    thread.start()
    try:
        verdicts = [verdict_on(gate, chunk) for _ in range(150)]
    finally:
        stop.set()
        thread.join()
    for verdict in verdicts:
        assert verdict.safe is any("may touch" in note for note in verdict.notes)
    assert sum(gate.statistics.to_dict()["verdicts"].values()) == len(verdicts)
