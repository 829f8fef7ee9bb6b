"""The lazy search: it ends on a path that is proven now, and proves little else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner import gabf
from planner.collision import make_checker
from planner.roadmap.roadmap import path_waypoints
from planner.robot.poses import pose
from planner.robot.shapes import Obstacle, Sphere
from planner.search.network import build_network
from planner.session.live_roadmap import LiveRoadmap
from planner.session.search import RoadmapNetwork, edges_of, search
from planner.trajectory.measure import path_contact
from tests.worlds import load, make_post, post_roadmap

ROBOT, LAW = load("planar_2r"), gabf.SingularityFree()


def live() -> LiveRoadmap:
    return LiveRoadmap.of(make_post()).with_roadmap(post_roadmap())


def network_of(world: LiveRoadmap) -> RoadmapNetwork:
    return RoadmapNetwork(world.roadmap, lambda roadmap: build_network(roadmap, 0.5))


def cost_over_proven_edges(world: LiveRoadmap) -> float:
    """After proving everything: Dijkstra's answer on what is free."""
    decided = world.proven(np.flatnonzero(world.proofs.open))
    network = build_network(decided.held(decided.proofs.free), 0.5)
    return float(gabf.oracle(network)[world.roadmap.starts].min())


def test_the_network_without_edges_is_that_of_the_smaller_roadmap() -> None:
    roadmap, drop = post_roadmap(), np.zeros(len(post_roadmap().edges), bool)
    drop[::3] = True
    mine = network_of(live()).without(drop)
    theirs = build_network(roadmap.part(np.ones(len(roadmap.nodes), bool), ~drop), 0.5)
    assert mine.indices.tolist() == theirs.indices.tolist()
    np.testing.assert_allclose(gabf.oracle(mine), gabf.oracle(theirs), rtol=1e-12)
    steps = np.concatenate([roadmap.edges[5], roadmap.edges[5, :1]])
    assert edges_of(live().roadmap, steps).tolist() == [5, 5]


def test_it_finds_the_cheapest_proven_path_and_leaves_most_edges_open() -> None:
    scene = make_post().world.scene
    ball = Obstacle("ball", Sphere(0.08), pose([-0.5, 0.5, 0]))
    world = live().in_world(make_checker(ROBOT, replace(scene, obstacles=(*scene.obstacles, ball))))
    opened = int(world.proofs.open.sum())
    found = search(world, network_of(world), np.zeros(len(world.roadmap.nodes)), LAW)
    assert len(found.steps)
    assert found.live.proofs.open.sum() > opened // 2
    path = path_waypoints(world.roadmap, ROBOT, found.steps)
    assert path_contact(make_checker(ROBOT, world.world.scene, "coal"), path) is None
    assert found.field.x[found.steps[0]] <= cost_over_proven_edges(world) + 1e-9
    rows = edges_of(world.roadmap, found.steps)
    assert found.live.proofs.free[rows].all()
    assert found.live.proofs.seen[rows].all()


def test_where_all_is_blocked_there_are_no_steps() -> None:
    world = live()
    proofs = world.proofs
    for row in range(len(world.roadmap.edges)):
        proofs = proofs.refused(row)
    found = search(replace(world, proofs=proofs), network_of(world), np.zeros(len(world.roadmap.nodes)), LAW)
    assert len(found.steps) == 0
    assert np.isinf(found.field.x[world.roadmap.starts]).all()
