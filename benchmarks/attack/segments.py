"""Whole segments that the prover calls free, against the true distance along them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.attack.cases import (
    KINDS,
    SEEN,
    change_shape,
    place_near,
    random_shape,
    random_turn,
    small_turn,
    spell,
)
from benchmarks.attack.climb import climb
from benchmarks.attack.true_distance import Placed, is_inside, nearest
from planner.base.arrays import Floats
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.clouds import Seen
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Body, Obstacle, Shape, corners

_LOOKS, _MORE = 13, 65  # places of a segment, and past a cloud, at which the true distance is computed first
_CLOSER = 14  # rounds of that search, each of which keeps two thirds
_LENGTHS = (-3.0, 0.0)  # decimal exponents of the motion of a segment (rad)


@dataclass(frozen=True, eq=False)
class Sweep:
    """A segment of a robot ``start`` + s ``delta`` past an obstacle, or past a shape that its first joint carries."""

    robot: Robot
    obstacle: Shape
    place: Floats  # (4, 4), in the world or in the first joint's frame
    linked: bool
    start: Floats
    delta: Floats
    margin: float = 0.0

    def describe(self) -> dict[str, Any]:
        """Enough to prove the segment again."""
        return {
            "robot": self.robot.name,
            "bodies": [[body.joint, spell(body.shape), body.placement.tolist()] for body in self.robot.bodies],
            "obstacle": spell(self.obstacle),
            "place": self.place.tolist(),
            "linked": self.linked,
            "start": self.start.tolist(),
            "delta": self.delta.tolist(),
            "margin": self.margin,
        }


@dataclass
class Proven:
    """Segments tried, called free, and of these with a contact; the largest clearance claimed minus the true (m)."""

    tried: int = 0
    free: int = 0
    false_free: int = 0
    over: float = -np.inf
    found: Sweep | None = None


def attack_segments(
    who: tuple[str, str], backend: str, tries: int, rng: np.random.Generator, progress: Progress
) -> Proven | None:
    """The worst of ``tries`` segments; None where stopped.

    ``who``: two kinds of shapes, the first carried by the second joint of an arm; or a robot and a kind of obstacle.
    """
    proven, arm = Proven(), Robot.load("planar_2r" if who[0] in KINDS else who[0])
    begin = lambda rng: random_sweep(arm, who, rng)  # noqa: E731
    done = climb(
        tries,
        rng,
        begin,
        _change_sweep,
        lambda sweeps: [judge_sweep(sweep, backend, proven) for sweep in sweeps],
        progress,
    )
    return proven if done else None


def random_sweep(arm: Robot, who: tuple[str, str], rng: np.random.Generator) -> Sweep:
    """A short or long segment, in the middle of which a body of the arm is close to the obstacle."""
    kinds = tuple(rng.permutation(who)) if who[0] in KINDS and who[1] not in SEEN else who
    if who[0] in KINDS:
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = random_turn(rng), 0.3 * rng.normal(size=3)
        arm = replace(arm, bodies=(Body("shape", "shape", 2, random_shape(kinds[0], rng), place),))
    middle = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
    seen = who[1] in SEEN
    linked = bool(who[0] in KINDS and not seen and rng.random() < 0.25)
    margin = float(10.0 ** rng.uniform(-4.0, -1.0)) if seen and rng.random() < 0.4 else 0.0
    moving = rng.random(arm.dof) < 0.6
    moving[1 if linked else int(rng.integers(arm.dof))] = True
    delta = rng.normal(size=arm.dof) * moving
    delta *= 10.0 ** rng.uniform(*_LENGTHS) / np.linalg.norm(delta)
    sweep = Sweep(arm, random_shape(kinds[1], rng), np.eye(4), linked, middle - rng.random() * delta, delta, margin)
    return _place_obstacle(sweep, random_turn(rng), middle, rng)


def _place_obstacle(sweep: Sweep, turn: Floats, middle: Floats, rng: np.random.Generator) -> Sweep:
    """With the obstacle close to a body where the arm stands at ``middle``."""
    frames = _frames(sweep.robot, middle)
    body = sweep.robot.bodies[int(rng.integers(len(sweep.robot.bodies)))]
    placed = frames[body.joint] @ body.placement
    place = place_near(body.shape, placed, sweep.obstacle, turn, rng)
    if isinstance(sweep.obstacle, Seen) and rng.random() < 0.1:  # the middle of a cell inside a link
        inside = placed[:3, 3] + placed[:3, :3] @ corners(body.shape)[0].mean(axis=0)
        place[:3, 3] = inside - place[:3, :3] @ sweep.obstacle.cells[0].mean(axis=0)
    return replace(sweep, place=np.linalg.inv(frames[1]) @ place if sweep.linked else place)


def _frames(robot: Robot, q: Floats) -> Floats:
    """(joints + 1, 4, 4) of every joint in the world, by the chain that the checkers use."""
    rotation, position = joint_placements(Chain.from_arm(robot), q[None])
    frames = np.tile(np.eye(4), (len(rotation), 1, 1))
    frames[:, :3, :3], frames[:, :3, 3] = rotation[:, 0], position[:, 0]
    return frames


def _change_sweep(sweep: Sweep, size: float, rng: np.random.Generator) -> Sweep:
    match rng.integers(5):
        case 0:
            return replace(sweep, obstacle=change_shape(sweep.obstacle, size, rng))
        case 1:
            place = np.array(sweep.place)
            place[:3, :3] = small_turn(size, rng) @ place[:3, :3]
            return replace(sweep, place=place)
        case 2:
            place = np.array(sweep.place)
            place[:3, 3] += 0.1 * size * rng.normal(size=3)
            return replace(sweep, place=place)
        case 3:
            return replace(sweep, delta=sweep.delta * (1.0 + size * rng.normal(size=sweep.robot.dof)))
    return _place_obstacle(sweep, sweep.place[:3, :3], sweep.start + rng.random() * sweep.delta, rng)


def judge_sweep(sweep: Sweep, backend: str, proven: Proven) -> float:
    """The claimed clearance minus the true one (m), of a segment that is called free."""
    proofs = EdgeProver(checker_of(sweep, backend)).prove(sweep.start, sweep.delta)
    proven.tried += 1
    if not proofs.free[0]:
        return -np.inf
    true = smallest_distance(sweep)
    proven.free += 1
    proven.false_free += true <= sweep.margin
    over = float(proofs.clearance[0]) + sweep.margin - true
    if over > proven.over:
        proven.over, proven.found = over, sweep
    return over


def checker_of(sweep: Sweep, backend: str) -> CollisionChecker:
    """A checker of the sweep's robot against its obstacle alone."""
    robot, count = sweep.robot, len(sweep.robot.bodies)
    items = () if sweep.linked else (Obstacle("obstacle", sweep.obstacle, sweep.place),)
    pairs = np.zeros((0, 2), dtype=np.int64)
    if sweep.linked:
        robot = replace(robot, bodies=(*robot.bodies, Body("obstacle", "obstacle", 1, sweep.obstacle, sweep.place)))
        pairs = np.array([(k, count) for k in range(count)], dtype=np.int64)
    checked = np.ones((len(robot.bodies), len(items)), dtype=bool)
    kind = type(make_checker(replace(robot, bodies=()), Scene("none"), backend))
    return kind(World(robot, Scene("attack", items), pairs, checked, sweep.margin))


def smallest_distance(sweep: Sweep) -> float:
    """The smallest true distance (m) found along a sweep, of what moves; no smaller than the smallest that there is."""
    if isinstance(sweep.obstacle, Seen) and _is_enclosed(sweep, sweep.obstacle):
        return 0.0
    at = np.linspace(0.0, 1.0, _MORE if isinstance(sweep.obstacle, Seen) else _LOOKS)
    seen = [_distance(sweep, s) for s in at]
    k = int(np.argmin(seen))
    low, high, best = at[max(k - 1, 0)], at[min(k + 1, len(at) - 1)], seen[k]
    for _ in range(_CLOSER):
        if best <= 0.0:
            break
        left, right = (low + share * (high - low) for share in (1 / 3, 2 / 3))
        a, b = _distance(sweep, left), _distance(sweep, right)
        low, high, best = (low, right, min(best, a)) if a < b else (left, high, min(best, b))
    return best


def _distance(sweep: Sweep, share: float) -> float:
    frames = _frames(sweep.robot, sweep.start + share * sweep.delta)
    place = frames[1] @ sweep.place if sweep.linked else sweep.place
    return nearest(_moving(sweep, frames), [(sweep.obstacle, place)]).high


def _moving(sweep: Sweep, frames: Floats) -> list[Placed]:
    """The placed bodies; the prover's clearance leaves out what no joint moves."""
    moving = [body for body in sweep.robot.bodies if body.joint > (1 if sweep.linked else 0)]
    return [(body.shape, frames[body.joint] @ body.placement) for body in moving]


def _is_enclosed(sweep: Sweep, seen: Seen) -> bool:
    """Whether the sweep starts with a part of a cloud inside a closed mesh: if nothing touches, it stays there."""
    points = seen.vertices @ sweep.place[:3, :3].T + sweep.place[:3, 3]
    return any(is_inside(placed, points) for placed in _moving(sweep, _frames(sweep.robot, sweep.start)))
