"""Proofs in time against dense sampling in time by collision libraries that know nothing of them."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import coal
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from planner.base.polynomials import evaluate
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalChecker, CoalInTime
from planner.collision.moving_prover import TimedProver, moving_world
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Mesh, Obstacle
from tests.random_shapes import KINDS, box_mesh, random_shape
from tests.worlds import joint_xml, link_xml, load

PIECES = 8


def moving(rng: np.random.Generator, kind: str) -> MovingObstacle:
    places = [[*rng.uniform(-1, 1, 2), rng.uniform(-0.05, 0.05)] for _ in range(3)]
    poses = [pose(place, rng.uniform(-2, 2, 3).tolist()) for place in places]
    return MovingObstacle("mover", random_shape(rng, kind), KnownMotion([0.0, 1.0, 2.5], poses))


def touches(checker: CollisionChecker, obstacle: MovingObstacle, q: np.ndarray, t: np.ndarray) -> bool:
    """Whether the robot touches the obstacle in any of the configurations at their times, by the checker's library."""
    known = checker
    for row, when in zip(q, t, strict=True):
        known = type(checker)(moving_world(checker.world, (obstacle.standing(when),)), known)
        if known.first_contact(row[None]) is not None:
            return True
    return False


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_proven_in_time_touches_at_no_sampled_moment(kind: str) -> None:
    rng, checker = np.random.default_rng(len(kind)), make_checker(load("planar_2r"), Scene("none"), "fcl")
    proven = touched = 0
    for _ in range(6):
        obstacle = moving(rng, kind)
        prover = TimedProver(checker, [obstacle])
        judge = CoalInTime(prover.world, prover.motions)
        coefficients = rng.uniform(-1, 1, (PIECES, 4, 2))
        spans = np.column_stack(
            [rng.uniform(0, 2.5, PIECES), rng.uniform(0.1, 1, PIECES), rng.choice([0.0, 0.1], PIECES)]
        )
        free = prover.free(coefficients, spans)
        for k in range(PIECES):
            s, (begin, takes, slack) = np.linspace(0, 1, 400), spans[k]
            q, t = evaluate(np.repeat(coefficients[k][None], 400, axis=0), s), begin + takes * s
            shift = slack * rng.uniform(-1, 1)
            if free[k]:
                assert judge.first_touch(q, t + shift) is None
                assert not touches(checker, obstacle, q[::40], t[::40] + shift)
                proven += 1
            elif slack == 0 and judge.first_touch(q, t) is not None:
                touched += 1
            else:
                assert slack > 0  # what is free of a piece begun on time is proven
    assert proven > 5
    assert touched > 1


def uneven(rng: np.random.Generator, kind: str) -> MovingObstacle:
    """One that stands, creeps, turns, and leaps within a millisecond or a microsecond, near the arm as often as not."""
    steps = rng.choice([1e-6, 1e-3, 0.02, 0.3, 1.0], 12)
    places = np.cumsum(rng.normal(size=(13, 2)) * rng.choice([0.0, 0.05, 0.5], (13, 1)), axis=0) + rng.uniform(-1, 1, 2)
    turns = np.cumsum(rng.normal(size=(13, 3)) * rng.choice([0.0, 0.3, 2.0], (13, 1)), axis=0)
    poses = [pose([*place, 0.0], turn.tolist()) for place, turn in zip(places, turns, strict=True)]
    return MovingObstacle("mover", random_shape(rng, kind), KnownMotion(np.append(0.0, np.cumsum(steps)), poses))


class Nearest:
    """The distance (m) of an obstacle from the arm along a piece, by coal, when it is begun early or late."""

    def __init__(self, obstacle: MovingObstacle, world: World, coefficients: np.ndarray, span: np.ndarray) -> None:
        self.judge, self.looks = CoalChecker(world), CoalInTime(world, {obstacle.name: obstacle.motion})
        self.motion, self.coefficients, self.span = obstacle.motion, coefficients, span

    def __call__(self, s: float, late: float) -> float:
        begin, takes, slack = self.span
        place = self.motion.at(begin + takes * s + slack * late)[0]
        self.judge._placements[len(self.judge.world.bodies)] = coal.Transform3s(place[:3, :3], place[:3, 3])
        rotation, position = joint_placements(self.judge.chain, evaluate(self.coefficients[None], np.array([s])))
        pairs = np.flatnonzero(self.judge.world.checked.ravel())
        return float(self.judge.distances(rotation[:, 0], position[:, 0], pairs).min())

    def climbed(self, near: float) -> float:
        """The least that is found from a grid, which holds the times of the motion; inf beyond ``near``."""
        begin, takes, slack = self.span
        changes = self.motion.times - begin
        middles = np.concatenate([changes, 0.5 * (changes[1:] + changes[:-1])])
        late = np.repeat([-1.0, 0.0, 1.0] if slack else [0.0], 25 + len(middles))
        s = np.tile(np.append(np.linspace(0, takes, 25), middles), len(late) // (25 + len(middles)))
        s = np.clip((s - slack * late) / takes, 0, 1)
        q = evaluate(np.repeat(self.coefficients[None], len(s), axis=0), s)
        grid = np.flatnonzero(self.looks.touching(q, begin + takes * s + slack * late, near))[:8]
        return min((self.down(float(s[k]), float(late[k])) for k in grid), default=np.inf)

    def down(self, s: float, late: float) -> float:
        """The least that a climb ends at."""
        least, step = self(s, late), 0.05
        for _ in range(14):
            there = [(s + step, late), (s - step, late), (s, late + 4 * step), (s, late - 4 * step)]
            found = min((self(*here), *here) for here in np.clip(there, [0, -1], [1, 1]).tolist())
            if found[0] < least:
                least, s, late = found
            else:
                step *= 0.4
        return least


@pytest.mark.parametrize("kind", ["box", "capsule", "cylinder"])
def test_no_climb_finds_a_contact_on_what_is_proven_among_motions_that_leap(kind: str) -> None:
    rng, checker = np.random.default_rng(len(kind)), make_checker(load("planar_2r"), Scene("none"), "coal")
    nearest = []
    for _ in range(16):
        obstacle = uneven(rng, kind)
        prover = TimedProver(checker, [obstacle])
        coefficients = rng.uniform(-1, 1, (PIECES, 4, 2)) * rng.choice([0.0, 0.3, 1.0], (PIECES, 1, 1))
        coefficients[:, 0] = rng.uniform(-3, 3, (PIECES, 2))
        spans = np.column_stack([rng.uniform(0, prover.end, PIECES), rng.uniform(0.1, 2, PIECES), np.zeros(PIECES)])
        spans[::2, 2] = rng.choice([1e-6, 0.01, 0.1], len(spans[::2]))
        for k in np.flatnonzero(prover.free(coefficients, spans)):
            nearest.append(Nearest(obstacle, prover.world, coefficients[k], spans[k]).climbed(0.3))
    assert min(nearest) > 0
    assert min(nearest) < 0.1  # the attack comes near
    assert len(nearest) > 20


def dithering(rng: np.random.Generator) -> tuple[MovingObstacle, np.ndarray, np.ndarray]:
    """A long bar that turns to and fro, far and quickly, and hardly goes anywhere: how far it gets bounds it.

    With its middle in its frame, which need not be in it, and half its sides.
    """
    count = int(rng.integers(2, 14))
    turns = rng.choice([0.0, 0.4, 1.5, 3.1], count) * rng.choice([-1, 1], count)
    turns = np.cumsum(turns) if rng.random() < 0.3 else turns
    places = rng.normal(size=2) + rng.choice([0.0, 0.02, 0.3]) * rng.normal(size=(count, 2))
    poses = [pose([*place, 0.0], [0, 0, turn]) for place, turn in zip(places, turns.tolist(), strict=True)]
    times = np.append(0.0, np.cumsum(rng.choice([1e-3, 0.02, 0.1, 0.5], count - 1)))
    size = rng.uniform([0.3, 0.02, 0.02], [1.5, 0.1, 0.1])
    middle = rng.choice([0.0, 0.5, 0.9]) * np.array([size[0], 0.0, 0.0])
    bar = box_mesh(tuple(size.tolist()))
    shape = Mesh(bar.vertices + middle, bar.triangles) if middle.any() else Box(tuple(size.tolist()))
    return MovingObstacle("bar", shape, KnownMotion(times, poses)), middle, 0.5 * size


def test_no_bar_that_turns_to_and_fro_comes_nearer_than_was_proven(urdf_file: Callable[..., str]) -> None:
    """The margin is set a tenth of a millimetre above, and as much below, the least that an optimiser finds."""
    arm = link_xml("a") + link_xml("b", '<sphere radius="0.02"/>', '<origin xyz="0.3 0 0"/>') + joint_xml("j", "a", "b")
    robot, rng = Robot.load(urdf_file(arm)), np.random.default_rng(3)
    proven = 0
    for _ in range(100):
        (bar, centre, half), q = dithering(rng), rng.uniform(-1, 1)
        ball = np.array([0.3 * np.cos(q), 0.3 * np.sin(q), 0.0])
        begin, slack = rng.uniform(-0.1, 0.1), rng.choice([0.0, 0.05, 0.2])
        takes = float(bar.motion.times[-1]) * rng.choice([0.3, 1.0, 1.2]) + 1e-3

        def gap(t: np.ndarray, bar=bar, ball=ball, centre=centre, half=half) -> np.ndarray:
            place = bar.motion.at(np.maximum(t, 0.0))
            local = np.einsum("nji,nj->ni", place[:, :3, :3], ball - place[:, :3, 3]) - centre
            return np.linalg.norm(np.maximum(np.abs(local) - half, 0.0), axis=1) - 0.02

        low, high = begin - slack, begin + takes + slack
        t = np.unique(np.clip(np.concatenate([np.linspace(low, high, 4001), bar.motion.times]), low, high))
        k = int(gap(t).argmin())
        around = t[max(0, k - 1)], t[min(len(t) - 1, k + 1)]
        found: Any = minimize_scalar(lambda x, gap=gap: float(gap(np.array([x]))[0]), bounds=around)
        least = min(float(gap(t).min()), float(found.fun))
        if least < 1e-3:
            continue
        still, span = np.array([[[q], [0.0]]]), np.array([[begin, takes, slack]])
        for margin, must_not in ((least + 1e-4, True), (least - 1e-4, False)):
            free = TimedProver(make_checker(robot, Scene("none"), margin=margin), [bar]).free(still, span)[0]
            assert not (free and must_not)
            proven += bool(free)
    assert proven > 15, "what keeps clear is proven"


def test_coal_in_time_agrees_with_fcl_at_single_moments() -> None:
    rng, checker = np.random.default_rng(4), make_checker(load("planar_2r"), Scene("none"), "fcl")
    obstacle, verdicts = replace(moving(rng, "box"), shape=Box((0.5, 0.4, 0.2))), []
    prover = TimedProver(checker, [obstacle])
    judge = CoalInTime(prover.world, prover.motions)
    for q, t in zip(rng.uniform(-3, 3, (150, 2)), rng.uniform(0, 3, 150), strict=True):
        found = judge.first_touch(q[None], np.array([t]))
        assert (found is not None) == touches(checker, obstacle, q[None], np.array([t]))
        verdicts.append(found is not None)
        if found is not None:
            assert found[1].second == "mover"
    assert 5 < sum(verdicts) < 145


def test_the_margin_is_kept_and_permissions_hold() -> None:
    cart = MovingObstacle("cart", Box((0.1, 0.1, 0.1)), KnownMotion([0, 1], [pose([1.3, 0, 0]), pose([1.3, 1, 0])]))
    still, span = np.zeros((1, 2, 2)), np.array([[0.0, 1.0, 0.0]])
    gap = 1.25 - np.abs(TimedProver(make_checker(load("planar_2r"), Scene("none")), [cart]).gaps(np.zeros(2)).min())
    for margin, free in ((0.0, True), (0.5 * (1.25 - gap), True), (1.25 - gap + 0.01, False)):
        checker = make_checker(load("planar_2r"), Scene("none"), margin=margin)
        assert TimedProver(checker, [cart]).free(still, span)[0] == free
    links = {body.link for body in load("planar_2r").bodies}
    allowed = Scene("allowed", allowed=frozenset(frozenset((link, "cart")) for link in links))
    inside = MovingObstacle("cart", cart.shape, KnownMotion([0], [pose([0.5, 0, 0])]))
    prover = TimedProver(make_checker(load("planar_2r"), allowed), [inside])
    assert prover.free(still, span)[0]


def test_an_unknown_motion_is_kept_clear_of_as_long_as_it_cannot_have_come() -> None:
    checker = make_checker(load("planar_2r"), Scene("none"))
    dog = Obstacle("dog", Box((0.2, 0.2, 0.2)), pose([2.0, 0, 0]), speed_limit=0.5)
    prover = TimedProver(checker, limited=[dog])
    gap = prover.gaps(np.zeros(2)).min()
    still = np.zeros((2, 2, 2))
    spans = np.array([[0.0, 0.99 * gap / 0.5, 0.0], [0.0, 1.01 * gap / 0.5, 0.0]])
    np.testing.assert_array_equal(prover.free(still, spans), [True, False])
    late = np.array([[0.97 * gap / 0.5, 0.01, 0.01], [0.99 * gap / 0.5, 0.01, 0.01]])
    np.testing.assert_array_equal(prover.free(still, late), [True, False])
