"""Which pairs of links need no self-collision check, worked out where nobody has said so."""

from __future__ import annotations

import numpy as np

from planner.collision.checker import CollisionChecker
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.world.robot import Robot
from planner.world.scene import Scene

SAMPLES, FIRST = 500, 10  # a pair that touches seldom in the first few is not asked about again
ALWAYS = 0.95  # share of random configurations in which a pair that is no true collision touches


def adjacent_pairs(robot: Robot) -> frozenset[frozenset[str]]:
    """Links joined by one joint: they touch there by construction."""
    parents = robot.model.parents
    return frozenset(
        frozenset((a.link, b.link))
        for a in robot.bodies
        for b in robot.bodies
        if b.joint != 0 and parents[b.joint] == a.joint
    )


def generate_disabled_pairs(robot: Robot, backend: type[CollisionChecker]) -> frozenset[frozenset[str]]:
    """Adjacent links, and links that touch in nearly all of a fixed sample of random configurations.

    Unlike MoveIt's setup assistant, pairs that never touched in the sample are kept: a sample is no proof,
    and a pair that is far apart costs next to nothing.
    """
    disabled = adjacent_pairs(robot)
    world = World.of(robot, Scene("none"), disabled)
    if not len(world.self_pairs):
        return disabled
    checker = backend(world)
    q = np.random.default_rng(0).uniform(robot.lower, robot.upper, size=(SAMPLES, robot.dof))
    rotation, position = joint_placements(checker.chain, q)
    pairs = np.arange(len(world.self_pairs))
    touching = np.zeros(len(pairs))
    for row in range(SAMPLES):
        touching[pairs] += checker.distances(rotation[:, row], position[:, row], pairs) <= 0
        if row == FIRST - 1:
            pairs = pairs[touching >= 0.8 * FIRST]
        if not len(pairs):
            break
    always = np.nonzero(touching >= ALWAYS * SAMPLES)[0]
    names = [world.contact(int(pair)) for pair in always]
    return disabled | frozenset(frozenset((name.first, name.second)) for name in names)
