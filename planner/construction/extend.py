"""Growing an existing roadmap: its nodes keep their numbers, its edges their proofs, its costs their scale."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.construction.build import DENSITY
from planner.construction.enlarge import enlarged
from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.node_checks import with_checked_nodes
from planner.roadmap.roadmap import Roadmap
from planner.sampling.connections import connect
from planner.sampling.grow import Growth, grow
from planner.sampling.growth_settings import GrowthSettings


def extend(
    roadmap: Roadmap,
    checker: CollisionChecker,
    nodes: int,
    seed: int | None = None,
    settings: GrowthSettings | None = None,
    progress: Progress = QUIET,
) -> Roadmap:
    """About ``nodes`` more configurations, grown by RRT from all nodes and linked to the same density as before.

    Fewer come where too many motions are refused or it is asked to stop. Left out, ``seed`` follows from the roadmap: a
    seed that was used already would draw the same samples again. Raises :class:`OptionError` for less than one node.
    """
    if nodes < 1:
        raise OptionError(f"{nodes} nodes are no extension: give a whole number from 1.")
    roadmap = with_checked_nodes(roadmap, checker)
    robot, prover, n = checker.robot, RecordingProver(checker, progress), len(roadmap.nodes)
    growth = grow(
        prover,
        roadmap.nodes,
        np.zeros((0, robot.dof)),
        n + nodes,
        (roadmap.origin.seed + n) % 2**31 if seed is None else seed,
        settings or GrowthSettings(),
        progress,
    )
    new, edges = _renumbered(growth, np.arange(n), n)
    everything = np.vstack([roadmap.nodes, new])
    density = max(DENSITY, len(roadmap.edges) / n)
    linked = connect(
        prover,
        everything,
        np.concatenate([roadmap.edges, edges]),
        round(density * len(everything)),
        progress,
    )
    return enlarged(roadmap, prover, new, linked)


def _renumbered(growth: Growth, roots: Ints, n: int) -> tuple[Floats, Ints]:
    """What grew from nodes ``roots`` of ``n``: new nodes (k, dof), and edges (j, 2).

    In the edges the roots have the numbers given, the new nodes those from n on.
    """
    number = np.full(len(growth.nodes), -1, dtype=np.int64)
    number[growth.starts] = roots
    fresh = number < 0
    number[fresh] = n + np.arange(fresh.sum())
    return growth.nodes[fresh], np.sort(number[growth.edges], axis=1)
