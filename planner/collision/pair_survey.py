"""Which pairs of links need no self-collision check, by sampling and by proof: what a robot file is written from.

As MoveIt's setup assistant does, pairs are told apart that are adjacent, touch in nearly every random configuration, or
never did. Of the last a sample proves nothing, so a proof is tried: the box of the joints between the two links is
cut into smaller ones until, in the middle of each, the two are farther apart than its joints can move them (the idea
of :mod:`planner.collision.edge_prover`, in as many dimensions as there are joints between).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.products import product
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.collision.self_pairs import ALWAYS, adjacent_pairs
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.kinematics.reach import pair_reach
from planner.world.robot import Robot
from planner.world.scene import Scene
from planner.world.urdf import Description

_BATCH = 100  # configurations between two looks at which pairs are decided
# boxes of joint values that the proof of one pair may look at: with two joints between the links they suffice for a
# gap of some millimetres, with more joints for links that are well apart
_BOXES_OF_TWO, _BOXES = 200_000, 20_000
_ROUNDING = 1e-9  # m by which a computed bound may exceed the distance


class Reason(Enum):
    """Why a pair of links needs no check; ``SOMETIMES``: it does. The values are what a robot file says of them."""

    ADJACENT = "joined by one joint"
    ALWAYS = f"touch in at least {100 * ALWAYS:g} % of the random configurations"
    APART = "cannot touch within the joint limits, the other joints held as they are here: proven"
    NEVER = "never touched in the random configurations, which is no proof"
    SOMETIMES = "touch in some configurations"


@dataclass(frozen=True)
class Survey:
    """The reason found for every pair of links that a joint can move against each other, from ``samples`` samples."""

    reasons: Mapping[frozenset[str], Reason]
    samples: int

    def pairs(self, reason: Reason) -> list[tuple[str, str]]:
        """The pairs of one reason by name, sorted."""
        return sorted((min(pair), max(pair)) for pair, found in self.reasons.items() if found is reason)


def survey_pairs(
    robot: Robot, backend: type[CollisionChecker], samples: int, seed: int, progress: Progress = QUIET
) -> Survey:
    """Every pair of links that the robot's own files leave checked, with the reason not to; the same for a seed.

    Configurations are uniform within the limits. A pair of links has the strongest reason that holds for all its
    bodies, except that two links always touch if any two of their bodies do.
    """
    adjacent = adjacent_pairs(robot) & adjacent_links(robot.source, {body.link for body in robot.bodies})
    world = World.of(robot, Scene("none"), (robot.disabled_pairs or frozenset()) | robot.touching)
    links = [_links(world, pair) for pair in range(len(world.self_pairs))]
    asked = np.array([pair not in adjacent for pair in links], dtype=bool)
    touched = _touching(backend(world), asked, samples, np.random.default_rng(seed), progress)
    found: dict[frozenset[str], list[Reason]] = defaultdict(list)
    for pair, names in enumerate(links):
        progress("proofs", pair + 1, len(links))
        found[names].append(_reason(world, backend, pair, touched[pair] / samples) if asked[pair] else Reason.ADJACENT)
    return Survey({names: _of_links(reasons) for names, reasons in found.items()}, samples)


def adjacent_links(description: Description, with_bodies: Iterable[str]) -> frozenset[frozenset[str]]:
    """Pairs of links with nothing but joints and links without bodies between them."""
    above, solid = {child: parent for parent, child in description.joints.values()}, set(with_bodies)
    found = set()
    for link in solid:
        parent = above.get(link)
        while parent is not None and parent not in solid:
            parent = above.get(parent)
        if parent is not None:
            found.add(frozenset((link, parent)))
    return frozenset(found)


def _links(world: World, pair: int) -> frozenset[str]:
    first, second = world.self_pairs[pair]
    return frozenset((world.bodies[first].link, world.bodies[second].link))


def _touching(
    checker: CollisionChecker, asked: Bools, samples: int, rng: np.random.Generator, progress: Progress
) -> Ints:
    """(pairs,) in how many samples each touched, as far as it takes to tell never and nearly always from sometimes."""
    robot, touched = checker.robot, np.zeros(len(asked), dtype=np.int64)
    for first in range(0, samples, _BATCH):
        missed = first - touched
        pairs = np.flatnonzero(asked & ((touched == 0) | (missed <= (1 - ALWAYS) * samples)))
        q = rng.uniform(robot.lower, robot.upper, size=(min(_BATCH, samples - first), robot.dof))
        rotation, position = joint_placements(checker.chain, q)
        rows, near = np.nonzero(checker.bound.coarse(rotation, position)[:, pairs] <= 0)
        contacts = checker.bound.close(rotation, position, rows, pairs[near]) <= 0
        touched += np.bincount(pairs[near][contacts], minlength=len(touched))
        progress("samples", first + len(q), samples)
    return touched


def _reason(world: World, backend: type[CollisionChecker], pair: int, share: float) -> Reason:
    if share >= ALWAYS:
        return Reason.ALWAYS
    if share > 0:
        return Reason.SOMETIMES
    alone = backend(_alone(world, pair))
    middle = 0.5 * (world.robot.lower + world.robot.upper)
    if (alone.inside.pairs(middle[None]) >= 0).any():
        return Reason.ALWAYS  # one lies inside the other, and their surfaces never met
    return _apart(alone)


def _alone(world: World, pair: int) -> World:
    """The world of this pair only."""
    bodies = tuple(world.bodies[k] for k in world.self_pairs[pair])
    return World.of(replace(world.robot, bodies=bodies), world.scene, frozenset())


def _apart(checker: CollisionChecker) -> Reason:
    """Whether the only pair of the checker's world is apart in the whole box of joint values, by a proof."""
    robot, reach = checker.robot, pair_reach(checker.robot, *checker.world.bodies)
    centre, width = 0.5 * (robot.lower + robot.upper)[None], robot.upper - robot.lower
    width = np.where(robot.prismatic, width, np.minimum(width, 2 * np.pi))  # one turn is all there is
    half = np.where(reach > 0, 0.5 * width, 0.0)[None]
    boxes, most = 0, _BOXES_OF_TWO if (reach > 0).sum() <= 2 else _BOXES
    while len(centre):
        boxes += len(centre)
        if boxes > most:
            return Reason.NEVER
        need = product(half, reach[:, None])[:, 0]
        gap = _gaps(checker, centre, need)
        if (gap < 0).any():
            return Reason.SOMETIMES
        centre, half = _halved(centre[gap <= need], half[gap <= need], reach)
    return Reason.APART


def _gaps(checker: CollisionChecker, q: Floats, need: Floats) -> Floats:
    """Lower bounds (n,) on the pair's distance, as close as it takes to exceed ``need``; below 0 where it touches."""
    rotation, position = joint_placements(checker.chain, q)
    gap, only = np.maximum(checker.bound.coarse(rotation, position)[:, 0], 0.0), np.zeros(1, dtype=np.int64)
    rows = np.flatnonzero(gap <= need)
    gap[rows] = np.maximum(gap[rows], checker.bound.close(rotation, position, rows, np.zeros_like(rows)) - _ROUNDING)
    for row in rows[gap[rows] <= 0]:
        if checker.distances(rotation[:, row], position[:, row], only)[0] <= 0:
            gap[row] = -1.0
    return gap


def _halved(centre: Floats, half: Floats, reach: Floats) -> tuple[Floats, Floats]:
    """Each box cut in two across the joint that can move the pair most in it."""
    rows, widest = np.arange(len(centre)), (half * reach).argmax(axis=1)
    half = half.copy()
    half[rows, widest] *= 0.5
    shift = np.zeros_like(half)
    shift[rows, widest] = half[rows, widest]
    return np.concatenate([centre - shift, centre + shift]), np.concatenate([half, half])


def _of_links(reasons: Iterable[Reason]) -> Reason:
    found = set(reasons)
    for reason in (Reason.ADJACENT, Reason.ALWAYS, Reason.SOMETIMES, Reason.NEVER):
        if reason in found:
            return reason
    return Reason.APART
