"""Which pairs of links need no self-collision check, worked out where nobody has said so."""

import numpy as np

from planner.base.cache import load_or_compute
from planner.collision.checker import APART, CollisionChecker
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.robot.robot import Robot
from planner.robot.scene import Scene

SAMPLES, FIRST = 500, 10  # a pair that touches seldom in the first few is not asked about again
ALWAYS = 0.95  # share of random configurations in which a pair that is no true collision touches


def adjacent_pairs(robot: Robot) -> frozenset[frozenset[str]]:
    """Pairs of links that one planned joint joins: they touch there by construction.

    Only joints and links without bodies stand between them. A link that is fixed to one of the two, as a pedestal is to
    the base, is no neighbour of the other: it can be hit.
    """
    above = {child: parent for parent, child in robot.source.joints.values()}
    carrier, parents, pairs = {body.link: body.joint for body in robot.bodies}, robot.model.parents, set()
    for link, joint in carrier.items():
        parent = above.get(link)
        while parent is not None and parent not in carrier:
            parent = above.get(parent)
        if parent is not None and joint != 0 and parents[joint] == carrier[parent]:
            pairs.add(frozenset((link, parent)))
    return frozenset(pairs)


def generate_disabled_pairs(robot: Robot, backend: type[CollisionChecker]) -> frozenset[frozenset[str]]:
    """Adjacent links, and links that touch in nearly all of a fixed sample of random configurations.

    Unlike MoveIt's setup assistant, pairs that never touched in the sample are kept: a sample is no proof,
    and a pair that is far apart costs next to nothing.
    """
    return compute_disabled_pairs(robot, backend)[0]


def compute_disabled_pairs(
    robot: Robot, backend: type[CollisionChecker]
) -> tuple[frozenset[frozenset[str]], CollisionChecker | None]:
    """The same, from the cache where this robot was asked about before; else with the checker that was made for it."""
    disabled, made = adjacent_pairs(robot), list[CollisionChecker]()

    def always() -> dict[str, np.ndarray]:
        made.append(backend(World.of(robot, Scene("none"), disabled)))
        return {"pairs": np.array(_always(made[0]), dtype=np.str_).reshape(-1, 2)}

    neighbours = sorted(sorted(pair) for pair in disabled)
    found = load_or_compute("pairs", [robot.identity, neighbours, SAMPLES, FIRST, ALWAYS], always)["pairs"]
    return disabled | frozenset(frozenset(pair) for pair in found.tolist()), made[0] if made else None


def _always(checker: CollisionChecker) -> list[tuple[str, str]]:
    """The pairs of links of which two bodies touch in nearly all configurations of the sample.

    Those touch that no plane proves apart: so every backend leaves out the same, and makes no shapes to find them.
    """
    robot, world = checker.robot, checker.world
    if not len(world.self_pairs):
        return []
    q = np.random.default_rng(0).uniform(robot.lower, robot.upper, size=(SAMPLES, robot.dof))
    pairs = np.arange(len(world.self_pairs))
    touching = np.zeros(len(pairs))
    for part in (q[:FIRST], q[FIRST:]):
        placed = joint_placements(checker.chain, part)
        rows, asked = np.divmod(np.arange(len(part) * len(pairs)), max(1, len(pairs)))
        met = checker.bound.close(*placed, rows, pairs[asked], APART) <= 0
        touching[pairs] += np.bincount(asked[met], minlength=len(pairs))
        pairs = pairs[touching[pairs] >= 0.8 * FIRST]
    names = [world.contact(int(pair)) for pair in np.nonzero(touching >= ALWAYS * SAMPLES)[0]]
    return [(name.first, name.second) for name in names]
