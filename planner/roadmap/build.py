"""A roadmap from nothing: grow, link, measure."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from planner.arrays import Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.collision.edges import EdgeProver
from planner.kinematics.forward import Chain, tool_positions
from planner.kinematics.manipulability import manipulability
from planner.request import PAPER_EDGES, PAPER_NODES, require_nodes
from planner.roadmap.connect import connect
from planner.roadmap.grow import GrowthSettings, grow
from planner.roadmap.roadmap import CostScale, Origin, Roadmap
from planner.robot import Robot

_TOOL_STEP = 0.05  # rad of joint motion between the points that the length of the tool's way is summed over

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class RoadmapSettings:
    """Size and density. ``density`` is edges a node, the paper's by default; more means more choice and more proofs."""

    nodes: int = PAPER_NODES
    density: float = PAPER_EDGES / PAPER_NODES
    growth: GrowthSettings = field(default_factory=GrowthSettings)

    def __post_init__(self) -> None:
        require_nodes(self.nodes)


def grow_roadmap(
    checker: CollisionChecker,
    starts: Floats,
    goals: Floats,
    settings: RoadmapSettings,
    seed: int,
    measure: Callable[[Floats, Floats, Floats], CostScale],
    progress: Progress = lambda stage, done, total: None,
    stop: Callable[[], bool] = lambda: False,
) -> Roadmap:
    """Proven edges all through: RRTConnect and RRT by counts, then links between neighbours up to the density.

    ``measure`` turns manipulability and the two lengths into the cost scale that is kept with the roadmap.
    """
    robot, prover = checker.world.robot, EdgeProver(checker)
    growth = grow(
        robot,
        prover,
        starts,
        goals,
        settings.nodes,
        seed,
        settings.growth,
        lambda done, total: progress("roadmap", done, total),
        stop,
    )
    target = round(settings.density * len(growth.nodes))
    edges = connect(
        robot,
        prover,
        growth.nodes,
        growth.edges,
        target,
        lambda done, total: progress("links", done, total),
        stop,
    )
    edges = edges[np.lexsort((edges[:, 1], edges[:, 0]))]
    return measured(checker, growth.nodes, edges, growth.starts, growth.goals, origin_of(checker, seed), measure)


def measured(
    checker: CollisionChecker,
    nodes: Floats,
    edges: Ints,
    starts: Ints,
    goals: Ints,
    origin: Origin,
    measure: Callable[[Floats, Floats, Floats], CostScale],
) -> Roadmap:
    """A roadmap of proven ``edges`` with its manipulability and lengths."""
    robot = checker.world.robot
    w = manipulability(robot, nodes)
    joint, tool = edge_lengths(robot, nodes, edges)
    proven = np.ones(len(edges), dtype=bool)
    return Roadmap(nodes, edges, proven, starts, goals, w, joint, tool, measure(w, joint, tool), origin)


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
    )


def versions() -> dict[str, str]:
    """Versions of this package and of what decides its results."""
    names = ("gabf-planner", "ompl", "pin", "python-fcl", "coal", "numpy")
    return {name: importlib.metadata.version(name) for name in names}


def edge_lengths(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, Floats]:
    """Joint motion (m,) rad and length of the tool's way (m,) metres of every edge."""
    delta = robot.difference(nodes[edges[:, 0]], nodes[edges[:, 1]]).reshape(-1, robot.dof)
    joint = np.linalg.norm(delta, axis=1)
    pieces = np.maximum(1, np.ceil(np.abs(delta).sum(axis=1) / _TOOL_STEP)).astype(np.int64)
    row = np.repeat(np.arange(len(edges)), pieces + 1)
    first = np.concatenate([[0], np.cumsum(pieces + 1)[:-1]]).astype(np.int64)
    s = (np.arange(len(row)) - first[row]) / pieces[row] if len(row) else np.zeros(0)
    tool = tool_positions(robot, nodes[edges[row, 0]] + s[:, None] * delta[row], Chain.of(robot))
    steps = np.linalg.norm(np.diff(tool, axis=0), axis=1)
    steps[first[1:] - 1] = 0.0  # from one edge's end to the next one's start
    length = np.add.reduceat(np.concatenate([steps, [0.0]]), first) if len(edges) else np.zeros(0)
    return joint, length
