"""What is known of edges, part by part: a change costs what it concerns, and comes back where it goes."""

from dataclasses import replace

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.collision.world import World
from planner.robot.poses import pose
from planner.robot.robot import with_carried
from planner.robot.shapes import Box, Capsule, Carried, Sphere
from planner.session.live_roadmap import ARM, EdgeProofs, clauses_of, measure_displacement
from tests.worlds import load, post_roadmap, scene_of

ROBOT = load("planar_2r")
POST = (Box((0.1, 0.02, 0.2)), pose([0.75, 0, 0]))


def world_of(*items, carried=()) -> World:
    robot = with_carried(ROBOT, carried) if carried else ROBOT
    return make_checker(robot, replace(scene_of(*items), carried=carried)).world


def test_only_what_is_open_is_proven_and_the_result_is_that_of_proving_all() -> None:
    checker = make_checker(ROBOT, scene_of(POST, (Sphere(0.08), pose([-0.5, 0.5, 0]))))
    roadmap = post_roadmap()
    rows = np.arange(0, len(roadmap.edges), 4)
    alone = world_of(POST)
    before = EdgeProofs.from_clearance(alone, roadmap.clearance).move_to_world(alone, checker.world)
    after = before.prove(EdgeProver(checker), roadmap, rows)
    a, b = roadmap.nodes[roadmap.edges[rows, 0]], roadmap.nodes[roadmap.edges[rows, 1]]
    free = EdgeProver(checker).prove(a, b - a).free
    assert not free.all()
    np.testing.assert_array_equal(after.free[rows], free)
    assert after.open.sum() == len(roadmap.edges) - len(rows)
    column = before.clauses.index((ARM, "thing0"))
    np.testing.assert_array_equal(after.known[rows][free, column], before.known[rows][free, column])


def test_every_pair_has_its_clause_and_what_is_carried_is_a_part() -> None:
    ball = Carried("link_2", "ball", Sphere(0.05), pose([0.45, 0, 0]), ("link_2",))
    world = world_of(POST, carried=(ball,))
    clauses, of_pair = clauses_of(world)
    assert len(of_pair) == len(world.pair_reach)
    assert {("ball", "thing0"), (ARM, "thing0")} <= set(clauses)
    for pair, clause in enumerate(of_pair):
        first, second = world.members(pair)
        names = {"ball" if world.bodies[first].name == "ball" else ARM}
        if world.is_scene_pair(pair):
            names |= {world.obstacles[second].name}
        else:
            names |= {"ball" if world.bodies[second].name == "ball" else ARM}
        assert set(clauses[clause]) == names


@pytest.mark.parametrize("shape", [Box((0.3, 0.1, 0.5)), Sphere(0.2), Capsule(0.1, 0.4)])
def test_no_point_moves_farther_than_the_displacement(shape) -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        before = pose(rng.normal(size=3).tolist(), rpy=rng.normal(size=3).tolist())
        after = pose(rng.normal(size=3).tolist(), rpy=rng.normal(size=3).tolist())
        points = rng.uniform(-0.5, 0.5, size=(3000, 3))
        inside = {
            Box: lambda p: (np.abs(p) <= [0.15, 0.05, 0.25]).all(axis=1),
            Sphere: lambda p: np.linalg.norm(p, axis=1) <= 0.2,
            Capsule: lambda p: np.hypot(np.hypot(p[:, 0], p[:, 1]), np.maximum(np.abs(p[:, 2]) - 0.2, 0)) <= 0.1,
        }[type(shape)](points)
        p = points[inside]
        moved = np.linalg.norm(p @ (after - before)[:3, :3].T + (after - before)[:3, 3], axis=1).max()
        most = measure_displacement(shape, before, after)
        assert moved <= most
        assert most <= moved + 0.35
    assert measure_displacement(shape, pose(), pose()) == 0.0
