"""The lazy search: it ends on a path that is proven now, and proves little else."""

from dataclasses import replace

import numpy as np

from planner import gabf
from planner.collision import make_checker
from planner.roadmap.roadmap import path_waypoints
from planner.robot.poses import pose
from planner.robot.shapes import Obstacle, Sphere
from planner.search.network import build_network, edge_rows
from planner.session.live_roadmap import LiveRoadmap
from planner.session.solve import LivePath, search_live
from planner.trajectory.measure import path_contact
from tests.worlds import load, make_post, post_roadmap

ROBOT, LAW = load("planar_2r"), gabf.SingularityFree()


def live() -> LiveRoadmap:
    return LiveRoadmap.from_checker(make_post()).with_roadmap(post_roadmap())


def found_in(world: LiveRoadmap) -> LivePath:
    return search_live(world, build_network(world.roadmap, 0.5), np.zeros(len(world.roadmap.nodes)), LAW)


def cost_over_proven_edges(world: LiveRoadmap) -> float:
    """After proving everything: Dijkstra's answer on what is free."""
    decided = world.prove(np.flatnonzero(world.proofs.open))
    network = build_network(decided.with_edges(decided.proofs.free), 0.5)
    return float(gabf.oracle(network)[world.roadmap.starts].min())


def test_it_finds_the_cheapest_proven_path_and_leaves_most_edges_open() -> None:
    scene = make_post().world.scene
    ball = Obstacle("ball", Sphere(0.08), pose([-0.5, 0.5, 0]))
    world = live().move_to_world(make_checker(ROBOT, replace(scene, obstacles=(*scene.obstacles, ball))))
    opened = int(world.proofs.open.sum())
    found = found_in(world)
    assert len(found.steps)
    assert found.live.proofs.open.sum() > opened // 2
    path = path_waypoints(world.roadmap, ROBOT, found.steps)
    assert path_contact(make_checker(ROBOT, world.world.scene, "coal"), path) is None
    assert found.field.x[found.steps[0]] <= cost_over_proven_edges(world) + 1e-9
    rows = edge_rows(world.roadmap, found.steps[:-1], found.steps[1:])
    assert found.live.proofs.free[rows].all()
    assert found.live.proofs.seen[rows].all()
