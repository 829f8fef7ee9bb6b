"""A roadmap from nothing: grow, link, pull strands, measure."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.request import PAPER_EDGES, PAPER_NODES, require_nodes
from planner.collision.checker import CollisionChecker
from planner.kinematics.manipulability import manipulability
from planner.roadmap.best_paths import add_strands
from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.grow import ROADMAP, GrowthSettings, grow
from planner.roadmap.links import connect
from planner.roadmap.measure import measure_edges
from planner.roadmap.roadmap import Origin, Roadmap
from planner.roadmap.scale import measure_scale
from planner.roadmap.world_record import record_of

_REST = 1_000_003  # added to the seed where the tree goes on: the same seed would draw the same samples again

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class RoadmapSettings:
    """Size and density. ``density`` is edges a node, the paper's by default; more means more choice and more proofs.

    ``strands``: the share of the nodes that is kept for strands, the pulled best paths.
    """

    nodes: int = PAPER_NODES
    density: float = PAPER_EDGES / PAPER_NODES
    strands: float = 0.1
    growth: GrowthSettings = field(default_factory=GrowthSettings)

    def __post_init__(self) -> None:
        require_nodes(self.nodes)


def grow_roadmap(
    checker: CollisionChecker,
    starts: Floats,
    goals: Floats,
    settings: RoadmapSettings,
    seed: int,
    progress: Progress = lambda stage, done, total: None,
    stop: Callable[[], bool] = lambda: False,
) -> Roadmap:
    """Proven edges all through, by counts: a first path, RRT around it, links up to the density, strands, more RRT."""
    robot, prover, growth = checker.world.robot, RecordingProver(checker), settings.growth

    def report(stage: str, done: int, total: int) -> None:
        progress(stage, done, settings.nodes if stage == ROADMAP else total)

    def link(nodes: Floats, edges: Ints) -> Ints:
        target = round(settings.density * len(nodes))
        return connect(robot, prover, nodes, edges, target, lambda done, total: progress("links", done, total), stop)

    room = round(settings.strands * settings.nodes)
    grown = grow(robot, prover, starts, goals, settings.nodes - room, seed, growth, report, stop)
    nodes, edges = grown.nodes, link(grown.nodes, grown.edges)
    if room and not stop():
        nodes, edges = add_strands(prover, nodes, edges, grown.starts, grown.goals, room, growth.floor, stop)
        # what the strands left of their room goes to the tree
        rest = grow(robot, prover, nodes, goals[:0], settings.nodes, seed + _REST, growth, report, stop)
        nodes, edges = rest.nodes, link(rest.nodes, np.concatenate([edges, rest.edges]))
    return _measured(prover, nodes, edges, grown.starts, grown.goals, seed)


def _measured(prover: RecordingProver, nodes: Floats, edges: Ints, starts: Ints, goals: Ints, seed: int) -> Roadmap:
    """The roadmap of proven ``edges`` (m, 2), in order, with its costs' makings and its certificates."""
    robot = prover.world.robot
    edges = edges[np.lexsort((edges[:, 1], edges[:, 0]))]
    w = manipulability(robot, nodes)
    measures = measure_edges(robot, nodes, edges)
    clearance, samples = prover.certificates(nodes, edges)
    return Roadmap(
        nodes=nodes,
        edges=edges,
        proven=np.ones(len(edges), dtype=bool),
        starts=starts,
        goals=goals,
        manipulability=w,
        **measures,
        clearance=clearance,
        samples=samples,
        scale=measure_scale(w, measures["joint_length"], measures["tool_length"]),
        origin=origin_of(prover.checker, seed),
    )


def origin_of(checker: CollisionChecker, seed: int) -> Origin:
    """Which robot and scene a roadmap grown with this checker belongs to."""
    world = checker.world
    return Origin(
        robot=world.robot.name,
        robot_identity=world.robot.identity,
        scene=world.scene.name,
        scene_identity=world.scene.identity,
        joints=world.robot.joints,
        tool=world.robot.tool,
        margin=world.margin,
        seed=seed,
        versions=versions(),
        world=record_of(world),
    )


def versions() -> dict[str, str]:
    """Versions of this package and of what decides its results."""
    names = ("gabf-planner", "ompl", "pin", "python-fcl", "coal", "numpy")
    return {name: importlib.metadata.version(name) for name in names}
