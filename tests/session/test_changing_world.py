"""The gate in a world that changes: as a new gate in that world; what may move by itself is given room."""

import threading
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np

from benchmarks.gate.chunks import KINDS, clutter, random_chunk
from planner.collision import make_checker
from planner.kinematics.forward import tool_pose
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle, Sphere
from planner.session.gate import Gate
from planner.session.verdict import Verdict
from tests.session.test_gate import HERE, STATE, STEP, TIMES, same, steps
from tests.worlds import load


def answers(gate: Gate, chunks: list[Any]) -> list[Verdict]:
    return [gate.check(*columns, **named) for columns, named in chunks]


def chunks_for(robot: Any, rng: np.random.Generator, count: int = 24) -> list[Any]:
    return [random_chunk(robot, KINDS[k % 3], 8, 0.6, rng).arguments() for k in range(count)]


def assert_as_new(gate: Gate, chunks: list[Any]) -> None:
    fresh = Gate(load("panda"), gate.scene)
    assert all(map(same, answers(gate, chunks), answers(fresh, chunks)))


def test_every_change_is_as_a_new_gate() -> None:
    rng, robot = np.random.default_rng(11), load("panda")
    gate = Gate(robot, Scene("x", clutter(6, rng)))
    chunks = chunks_for(robot, rng)
    before = answers(gate, chunks)
    for k in range(4):
        gate.world.put(f"box{k}", pose([0.5, 0.2 * k - 0.3, 0.5], rpy=[0.1 * k, 0.0, 0.3]))
        assert_as_new(gate, chunks)
    gate.world.add(Obstacle("more", Box((0.1, 0.3, 0.02)), pose([0.4, 0.1, 0.6])))
    assert_as_new(gate, chunks)
    gate.world.remove("box1")
    assert_as_new(gate, chunks)
    assert not all(map(same, before, answers(gate, chunks)))
    hold = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.8])
    at = tool_pose(robot, hold).homogeneous
    held = at @ pose([0.0, 0.0, 0.15])
    gate.world.add(Obstacle("held", Box((0.04, 0.04, 0.06)), held))
    gate.world.attach("held", robot.tool, hold)
    assert [item.name for item in gate.scene.carried] == ["held"]
    assert_as_new(gate, chunks)
    gate.world.detach("held", hold)
    np.testing.assert_allclose(gate.scene.obstacles[-1].placement, held, atol=1e-9)
    assert_as_new(gate, chunks)


def test_what_is_carried_is_proven_too() -> None:
    robot = load("panda")
    hold = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.8])
    frame = tool_pose(robot, hold).homogeneous
    turned = hold + np.array([0.4, 0, 0, 0, 0, 0, 0])
    way = tool_pose(robot, turned).homogeneous @ pose([0.0, 0.0, 0.3])
    rod = Obstacle("rod", Box((0.02, 0.02, 0.2)), frame @ pose([0.0, 0.0, 0.25]))
    ball = Obstacle("ball", Sphere(0.02), way)
    gate = Gate(robot, Scene("x", (rod, ball)), judged=())
    gate.world.attach("rod", robot.tool, hold, ["panda_hand", "panda_leftfinger", "panda_rightfinger"])
    found = gate.check(turned[None], times=[1.0], state=(hold, np.zeros(7)))
    assert found.reason is not None
    assert found.reason.pair == ("rod", "ball")
    assert Gate(robot, Scene("x", (ball,)), judged=()).check(turned[None], times=[1.0], state=(hold, 0 * hold)).safe


def beside_the_arm(limit: float) -> tuple[Gate, float]:
    """A ball with a speed limit above the arm, and how far it is from what the arm is on the way to."""
    robot = load("planar_2r")
    ball = Obstacle("child", Sphere(0.05), pose([0.0, 0.0, 1.0]), speed_limit=limit)
    judge = make_checker(robot, Scene("x", (ball,)), "coal")
    q = np.linspace(HERE, steps()[-1], 50)
    rotation, position = judge.chain.native.placements(q)
    pairs = np.arange(len(robot.bodies))
    return Gate(robot, judge.world.scene), min(
        float(judge.distances(rotation[:, k], position[:, k], pairs).min()) for k in range(50)
    )


def test_what_may_be_met_before_the_stop_ends_is_not_safe() -> None:
    _, away = beside_the_arm(0.0)
    chunk = {"times": TIMES, "state": STATE}
    slow, _ = beside_the_arm(0.9 * away / TIMES[-1])
    found = slow.check(steps(), **chunk, stop=False)
    assert found.safe
    ends = float(TIMES[-1]) + (found.stop.duration if found.stop else 0.0)
    just, _ = beside_the_arm(0.98 * away / ends)
    assert just.check(steps(), **chunk).safe
    late, _ = beside_the_arm(1.02 * away / ends)
    with_stops = late.check(steps(), **chunk)
    assert with_stops.reason is not None
    assert (with_stops.reason.kind, with_stops.reason.on) == ("reach", "stop")
    assert with_stops.reason.pair is not None
    assert with_stops.reason.pair[1] == "child"
    fast, _ = beside_the_arm(1.1 * away / TIMES[1])
    moving = fast.check(steps(), **chunk, stop=False)
    assert moving.reason is not None
    assert (moving.reason.kind, moving.reason.on) == ("reach", "motion")
    assert moving.safe_until == TIMES[0]


def test_checks_go_on_while_the_world_changes() -> None:
    """Every answer is that of the world before or of the one after."""
    tip = tool_pose(load("planar_2r"), HERE + 2 * STEP).translation
    box = Obstacle("box", Box((0.1, 0.1, 0.1)), pose(tip))
    gate = Gate(load("planar_2r"), Scene("x", (box,)), judged=())
    away = replace(box, placement=pose([0.0, 0.0, 3.0]))
    there = gate.check(steps(), times=TIMES)
    gate.world.put("box", away.placement)
    gone = gate.check(steps(), times=TIMES)
    assert (there.safe, gone.safe) == (False, True)
    found, done = [], threading.Event()

    def change() -> None:
        for k in count():
            gate.world.put("box", box.placement if k % 2 else away.placement)
            if done.is_set():
                return

    thread = threading.Thread(target=change)
    thread.start()
    while len(found) < 50 or (len({one.safe for one in found}) < 2 and len(found) < 5000):
        found.append(gate.check(steps(), times=TIMES))
    done.set()
    thread.join()
    assert all(same(one, there) or same(one, gone) for one in found)
    assert {one.safe for one in found} == {True, False}
