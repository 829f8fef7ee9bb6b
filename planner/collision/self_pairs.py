"""Link pairs that need no self-collision check, if neither SRDF nor robot file lists them."""

import numpy as np

from planner.base.cache import load_or_compute
from planner.collision.checker import APART, CollisionChecker
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.robot.composite import prefix_pairs
from planner.robot.robot import Robot
from planner.robot.scene import Scene

SAMPLES, FIRST = 500, 10  # a pair that rarely touches in the first few is not checked further
ALWAYS = 0.95  # share of random configurations in contact above which a pair is ignored


def adjacent_pairs(robot: Robot) -> frozenset[frozenset[str]]:
    """Return pairs of links that one planned joint connects: they touch by construction.

    Only joints and links without bodies may lie between them. A link fixed to one of them, such as a pedestal to the
    base, is not adjacent to the other.
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
    """Return adjacent links, and links in contact in nearly all of a fixed sample of configurations.

    Unlike MoveIt's setup assistant, it keeps pairs that never touched in the sample: a sample proves nothing, and
    distant pairs cost almost nothing. The result is cached. A composite robot has the pairs of its parts, so all pairs
    between two parts are checked.
    """
    if robot.parts:
        own = {prefix: part.disabled_pairs for prefix, part in robot.parts.items()}
        known = {p: generate_disabled_pairs(robot.parts[p], backend) if own[p] is None else own[p] for p in own}
        return frozenset().union(*(prefix_pairs(prefix, pairs or ()) for prefix, pairs in known.items()))
    disabled = adjacent_pairs(robot)

    def compute() -> dict[str, np.ndarray]:
        contacts = _frequent_contacts(backend(World.from_scene(robot, Scene("none"), disabled)))
        return {"pairs": np.array(contacts, dtype=np.str_).reshape(-1, 2)}

    neighbours = sorted(sorted(pair) for pair in disabled)
    result = load_or_compute("pairs", [robot.identity, neighbours, SAMPLES, FIRST, ALWAYS], compute)["pairs"]
    return disabled | frozenset(frozenset(pair) for pair in result.tolist())


def _frequent_contacts(checker: CollisionChecker) -> list[tuple[str, str]]:
    """Return the link pairs in contact in nearly all sampled configurations.

    Contact is decided by planes, so every backend ignores the same pairs.
    """
    robot, world = checker.robot, checker.world
    if not len(world.self_pairs):
        return []
    q = np.random.default_rng(0).uniform(robot.lower, robot.upper, size=(SAMPLES, robot.dof))
    pairs = np.arange(len(world.self_pairs))
    touching = np.zeros(len(pairs))
    for part in (q[:FIRST], q[FIRST:]):
        placed = joint_placements(checker.chain, part)
        rows, columns = np.divmod(np.arange(len(part) * len(pairs)), max(1, len(pairs)))
        contact = checker.bound.close(*placed, rows, pairs[columns], APART) <= 0
        touching[pairs] += np.bincount(columns[contact], minlength=len(pairs))
        pairs = pairs[touching[pairs] >= 0.8 * FIRST]
    names = [world.contact(int(pair)) for pair in np.nonzero(touching >= ALWAYS * SAMPLES)[0]]
    return [(name.first, name.second) for name in names]
