"""The same path slower, the proven motion over time, and counts of verdicts."""

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from benchmarks.gate.chunks import KINDS, Chunk, clutter, random_chunk
from benchmarks.gate.judge import Spline, motion_of, stops_of, touches
from planner.base.errors import ArrayError, StateError
from planner.collision import second_checker
from planner.collision.coal import CoalChecker
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.session.gate import Gate
from planner.session.verdict import Verdict
from planner.trajectory.limits import MotionLimits
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load

READY = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.0, 0.785])
FIRST = np.eye(7)[0]


@cache
def walled() -> Gate:
    wall = Obstacle("wall", Box((0.5, 0.02, 1.0)), pose([0.6, 0.36, 0.4]))
    return Gate(load("panda"), Scene("x", (wall,)))


def towards_the_wall(kind: str, speed: float, turn: float, seconds: float = 0.6, count: int = 15) -> Chunk:
    """Even acceleration of the first joint from ``speed``."""
    t = np.linspace(0.0, seconds, count + 1)
    bend = 2.0 * (turn - speed * seconds) / seconds**2
    knots = np.stack([speed * t + 0.5 * bend * t**2, speed + bend * t, bend + 0.0 * t], axis=1)[..., None] * FIRST
    knots[:, 0] += READY
    return Chunk(kind, t, knots)


def verdict_on(gate: Gate, chunk: Chunk) -> Verdict:
    columns, named = chunk.arguments()
    return gate.check(*columns, **named)  # pyright: ignore[reportArgumentType]


def as_chunk(kind: str, motion: Trajectory) -> Chunk:
    return Chunk(kind, motion.times, np.stack([motion.knots(order) for order in range(3)], axis=1))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("speed", "turn"), [(0.0, 0.37), (-0.5, 0.36)])
def test_what_is_too_fast_to_stop_is_proven_slower_on_its_path(kind: str, speed: float, turn: float) -> None:
    gate, chunk = walled(), towards_the_wall(kind, speed, turn)
    verdict = verdict_on(gate, chunk)
    assert verdict.reason is not None
    assert verdict.reason.on == "stop"
    motion, slower, scale = verdict.slowed, verdict.slower, verdict.time_scale
    assert motion is not None
    assert slower is not None
    assert scale is not None
    assert motion.proven
    assert 0.9 * scale * 0.6 < motion.duration <= scale * 0.6 + 1e-6
    # the start, the end and everything between lie on the path, and the robot's velocity does not jump
    np.testing.assert_allclose(motion.knots()[[0, -1]], chunk.knots[[0, -1], 0], atol=1e-12)
    if kind != "lines":
        np.testing.assert_allclose(motion.knots(1)[0], chunk.knots[0, 1], atol=1e-12)
    if kind == "quintics":  # accelerations agree with cubics through the same positions and velocities
        cubics = Trajectory.from_points(motion.joints, motion.times, *motion.columns[:2])
        bend = motion.knots(2)
        np.testing.assert_allclose(cubics.knots(2)[1:-1], bend[1:-1], atol=0.05 * np.abs(bend).max())
    moved = motion.at(np.linspace(0.0, motion.duration, 300)) - READY
    assert np.abs(moved[:, 1:]).max() < 1e-9
    assert moved[:, 0].max() <= turn + 1e-9
    # limits by differences, and contacts by coal, of the motion and of all its stops
    copy = as_chunk(kind, motion)
    stops = stops_of(copy, slower)
    assert stops is not None
    pieces = motion_of(copy)
    for order, most in enumerate((gate.limits.velocity, gate.limits.acceleration, gate.limits.jerk), 1):
        for one in (*stops, *(pieces if order <= KINDS.index(kind) + 1 else ())):
            assert (differences(one, order) <= most * (1.0 + 1e-3)).all()
    coal = second_checker(gate.checker)
    assert isinstance(coal, CoalChecker)
    assert not touches([*pieces, *stops], (coal, gate.checker))[1]
    assert slower.stop is not None
    np.testing.assert_allclose(slower.stop.knots()[0], chunk.knots[-1, 0], atol=1e-12)


def differences(one: Spline, order: int) -> np.ndarray:
    """The largest derivative of the next lower one, by differences."""
    t = np.linspace(0.0, one.seconds, 60)
    return np.abs(np.diff(one.at(t, order - 1), axis=0)).max(axis=0) / (t[1] - t[0])


def test_a_limit_that_is_exceeded_is_kept_slower_and_a_contact_is_not_ended() -> None:
    plain = MotionLimits.from_robot(load("panda"))
    gate = Gate(load("panda"), Scene("x", walled().scene.obstacles), limits=replace(plain, velocity=plain.velocity / 5))
    verdict = verdict_on(gate, towards_the_wall("quintics", 0.3, 0.3))
    assert verdict.reason is not None
    assert (verdict.reason.on, verdict.reason.limit) == ("motion", "velocity")
    assert verdict.slowed is not None
    assert (np.abs(np.diff(verdict.slowed.sample(1e-3).positions, axis=0)) <= plain.velocity / 5e3 + 1e-12).all()
    through = verdict_on(walled(), towards_the_wall("quintics", 0.5, 0.6))
    assert (through.safe, through.slowed, through.time_scale) == (False, None, None)
    safe = verdict_on(walled(), towards_the_wall("quintics", 0.5, 0.3))
    assert (safe.safe, safe.slowed, safe.time_scale) == (True, None, None)


@pytest.mark.parametrize("kind", KINDS)
def test_positions_follow_the_chunk_then_the_stop_then_rest(kind: str) -> None:
    chunk = towards_the_wall(kind, -0.5, 0.36)
    verdict = verdict_on(walled(), chunk)
    assert 0.0 < verdict.safe_until < 0.6
    pieces = motion_of(chunk)
    for piece, later in pairwise(pieces):
        t = np.linspace(piece.begin, later.begin, 5)
        if later.begin <= verdict.safe_until:
            np.testing.assert_allclose(verdict.positions_at(t), piece.at(t - piece.begin), atol=1e-9)
    stop = verdict.stop
    assert stop is not None
    since = np.linspace(0.0, stop.duration, 9)
    np.testing.assert_allclose(verdict.positions_at(verdict.safe_until + since), stop.at(since), atol=1e-9)
    rest = verdict.positions_at([verdict.safe_until + stop.duration, 100.0])
    np.testing.assert_allclose(rest, np.repeat(stop.knots()[-1:], 2, axis=0))
    with pytest.raises(ArrayError, match="at least 0 s"):
        verdict.positions_at(-0.1)


def test_no_positions_where_nothing_is_proven() -> None:
    wall = Obstacle("wall", Box((0.5, 0.02, 1.0)), pose([0.6, 0.0, 0.4]))
    verdict = verdict_on(Gate(load("panda"), Scene("x", (wall,))), towards_the_wall("cubics", 0.0, 0.3))
    assert verdict.stop is None
    with pytest.raises(StateError, match="proven stop"):
        verdict.positions_at([0.1])


def test_statistics_count_what_threads_check() -> None:
    rng = np.random.default_rng(4)
    gate = Gate(load("panda"), Scene("x", clutter(5, rng)))
    chunks = [random_chunk(gate.robot, KINDS[k % 3], 6, 0.5, rng, 0.25) for k in range(45)]
    with ThreadPoolExecutor(4) as pool:
        verdicts = list(pool.map(lambda chunk: verdict_on(gate, chunk), chunks))
    slowed = sum(verdict.slowed is not None for verdict in verdicts)
    counts, reasons = (gate.statistics.to_dict()[name] for name in ("verdicts", "reasons"))
    outcomes = Counter("safe" if v else "cut" if v.safe_until > 0 else "refused" for v in verdicts)
    assert counts == {**dict.fromkeys(("safe", "cut", "refused"), 0), **outcomes, "slowed": slowed}
    assert min(outcomes.values()) > 0
    texts = Counter(str(v.reason) for v in verdicts if v.reason)
    assert {item["text"]: item["count"] for item in reasons} == texts
    assert [item["count"] for item in reasons] == sorted(texts.values(), reverse=True)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("start", ["no state", "a first point at 0 s", "no acceleration"])
def test_a_slower_motion_starts_where_the_chunk_does(kind: str, start: str) -> None:
    chunk = towards_the_wall(kind, -0.5, 0.36)
    columns, named = [chunk.knots[:, order] for order in range(KINDS.index(kind) + 1)], {"times": chunk.times}
    if start == "a first point at 0 s":
        named["state"] = tuple(chunk.knots[0] + 1e-3)
    if start == "no acceleration":
        columns, named = [rows[1:] for rows in columns], {"times": chunk.times[1:], "state": tuple(chunk.knots[0, :2])}
    verdict = walled().check(*columns, **named)  # pyright: ignore[reportArgumentType]
    assert not verdict.safe
    slowed, slower = verdict.slowed, verdict.slower
    assert slowed is not None
    assert slower is not None
    np.testing.assert_allclose(slowed.knots()[[0, -1]], chunk.knots[[0, -1], 0], atol=1e-12)
    if kind != "lines":
        np.testing.assert_allclose(slowed.knots(1)[0], chunk.knots[0, 1], atol=1e-12)
    t = np.linspace(0.0, slowed.duration, 60)
    np.testing.assert_allclose(slower.positions_at(t), slowed.at(t), atol=1e-9)
    assert any("no acceleration" in note for note in slower.notes) is (
        kind == "quintics" and start == "no acceleration"
    )
