"""What a checker says about the distances of pairs, against the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from benchmarks.attack.cases import Case, change_case, random_case
from benchmarks.attack.climb import SLOTS, climb
from benchmarks.attack.true_distance import Gap, true_distance
from planner.base.arrays import Floats, Ints
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.robot.clouds import Voxels
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Body, Box, Capsule, Cylinder, Obstacle, Shape, Sphere

CALLS = ("distances", "coarse", "close", "verdict")
_AIMS = (0.4, 0.2, 0.4)  # how often each of the first three is aimed at
ROUNDING = 1e-9  # m: what a bound that has no error of its own may exceed the truth by
_Q = np.array([[0.7, -0.4]])  # where the arm stands that carries the shapes
_DEPTHS = (-5.5, -2.0)  # decimal exponents of by how much (m) a margin is not kept, or two shapes overlap


@dataclass
class Worst:
    """The largest claim minus truth (m) of every call and the cases of them; ``beyond``: and minus what it may err by.

    ``apart``: cases whose shapes do not touch. ``short``: the largest truth minus what ``distances`` says (m).
    ``open``: the widest doubt (m) about a truth.
    """

    tried: int = 0
    apart: int = 0
    over: dict[str, float] = field(default_factory=dict)
    beyond: float = -np.inf
    short: float = -np.inf
    open: float = 0.0
    found: dict[str, dict[str, Any]] = field(default_factory=dict)

    def note(self, case: Case, gap: Gap, said: dict[str, float], allowed: dict[str, float]) -> float:
        """Record the claims of one case, and return the claim minus truth (m) of its target call."""
        self.tried += 1
        self.apart += gap.low > 0.0
        self.open = max(self.open, gap.high - gap.low)
        short = gap.low - max(said["distances"], 0.0)
        if short > self.short:
            self.short, self.found["short"] = short, {"short_m": short, **case.describe()}
        for call, value in said.items():
            if value - gap.high > self.over.get(call, -np.inf):
                self.over[call] = value - gap.high
                self.found[call] = {"over_m": self.over[call], **case.describe()}
        self.beyond = max(self.beyond, *(value - gap.high - allowed[call] for call, value in said.items()))
        return said[case.aim] - gap.high


def attack_claims(
    kinds: tuple[str, str], backend: str, tries: int, rng: np.random.Generator, progress: Progress
) -> Worst | None:
    """The worst of ``tries`` pairs of shapes of two kinds; None where stopped."""
    worst, robot = Worst(), Robot.load("planar_2r")
    begin = lambda rng: random_case(kinds, str(rng.choice(CALLS[:3], p=_AIMS)), rng)  # noqa: E731
    done = climb(tries, rng, begin, change_case, lambda cases: judge(cases, backend, worst, robot, rng), progress)
    return worst if done else None


def judge(cases: Sequence[Case], backend: str, worst: Worst, robot: Robot, rng: np.random.Generator) -> list[float]:
    """The score of every case; the verdict on a state is asked for one of them only, as it takes a world of its own."""
    checker, pairs = world_of(cases, backend, robot)
    gaps = [true_distance((case.first, case.place_first), (case.second, case.place_second)) for case in cases]
    by_call, scores, drawn = claims(checker, pairs), [], int(rng.integers(SLOTS))
    for k, (case, gap) in enumerate(zip(cases, gaps, strict=True)):
        said = {call: float(values[k]) for call, values in by_call.items()}
        if isinstance(case.second, Voxels) and gap.high <= 0.0:  # libraries know the faces, containment the rest
            said["distances"] = 0.0
        if k == drawn and (value := _promised_distance(case, gap, backend, robot, rng)) is not None:
            said["verdict"] = value
        allowed = {call: checker.error(value) for call, value in said.items()}
        allowed |= {"coarse": ROUNDING, "close": ROUNDING}
        scores.append(worst.note(case, gap, said, allowed))
    return scores


def claims(checker: CollisionChecker, pairs: Ints) -> dict[str, Floats]:
    """What each call says about the ``pairs`` of a world that :func:`world_of` made."""
    rotation, position = joint_placements(checker.chain, _Q)
    placed = rotation[:, 0], position[:, 0]
    return {
        "distances": checker.distances(*placed, pairs),
        "coarse": checker.bound.coarse(rotation, position)[0, pairs],
        "close": checker.bound.close(rotation, position, np.zeros(len(pairs), dtype=np.int64), pairs),
    }


def world_of(cases: Sequence[Case], backend: str, robot: Robot, margin: float = 0.0) -> tuple[CollisionChecker, Ints]:
    """A checker of a world in which an arm carries the first shape of every case, and the numbers of the pairs.

    The second is an obstacle, or carried by the arm's second joint.
    """
    rotation, position = joint_placements(make_checker(replace(robot, bodies=()), Scene("none")).chain, _Q)
    bodies, obstacles, linked = [], [], []
    for k, case in enumerate(cases):
        bodies.append(_carry(f"first{k}", 1, case.first, case.place_first, rotation, position))
        if case.linked:
            linked.append(k)
        else:
            obstacles.append(Obstacle(f"second{k}", case.second, case.place_second))
    for k in linked:
        bodies.append(_carry(f"second{k}", 2, cases[k].second, cases[k].place_second, rotation, position))
    count, free = len(cases), [k for k in range(len(cases)) if k not in linked]
    checked = np.zeros((len(bodies), len(obstacles)), dtype=bool)
    checked[free, np.arange(len(free))] = True
    self_pairs = np.array([(k, count + i) for i, k in enumerate(linked)], dtype=np.int64).reshape(-1, 2)
    arm = replace(robot, bodies=tuple(bodies))
    base = make_checker(replace(robot, bodies=()), Scene("none"), backend)
    world = World(arm, Scene("attack", tuple(obstacles)), self_pairs, checked, margin)
    scene_pairs = len(bodies) * len(obstacles)
    numbers = [
        scene_pairs + linked.index(k) if k in linked else k * len(obstacles) + free.index(k) for k in range(count)
    ]
    return type(base)(world), np.array(numbers, dtype=np.int64)


def _carry(name: str, joint: int, shape: Any, place: Floats, rotation: Floats, position: Floats) -> Body:
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = rotation[joint, 0], position[joint, 0]
    return Body(name, name, joint, shape, np.linalg.inv(frame) @ place)


def _promised_distance(case: Case, gap: Gap, backend: str, robot: Robot, rng: np.random.Generator) -> float | None:
    """What distance (m) the verdict on a state promises that should not be free; None where it is not called free.

    Shapes that are apart get a margin that is a little wider. Shapes that touch get none, and are left out where they
    no longer touch once the first is a little smaller: a verdict may be wrong by the tolerance of a library.
    """
    depth = 10.0 ** rng.uniform(*_DEPTHS)
    if gap.high > 0.0:
        margin = promise = gap.high + depth
    else:
        smaller = _shrink(case.first, depth)
        if smaller is None or true_distance((smaller, case.place_first), (case.second, case.place_second)).high > 0.0:
            return None
        margin, promise = 0.0, depth
    checker, _ = world_of([case], backend, robot, margin)
    return promise if is_free(checker, _Q[0]) or checker.bound.is_clear(_Q) else None


def _shrink(shape: Shape, depth: float) -> Shape | None:
    """A shape whose points are all ``depth`` (m) inside a primitive; None for a mesh and where none are."""
    match shape:
        case Box(size) if min(size) > 2.0 * depth:
            return Box((size[0] - 2.0 * depth, size[1] - 2.0 * depth, size[2] - 2.0 * depth))
        case Sphere(radius) if radius > depth:
            return Sphere(radius - depth)
        case Cylinder(radius, length) if min(radius, 0.5 * length) > depth:
            return Cylinder(radius - depth, length - 2.0 * depth)
        case Capsule(radius, length) if radius > depth:
            return Capsule(radius - depth, length)
    return None
