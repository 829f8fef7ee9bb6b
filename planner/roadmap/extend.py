"""Growing an existing roadmap: its nodes keep their numbers, its edges their proofs, its costs their scale."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.kinematics.manipulability import manipulability
from planner.roadmap.build import DENSITY
from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.grow import Growth, GrowthSettings, grow
from planner.roadmap.links import connect
from planner.roadmap.measure import measure_edges
from planner.roadmap.roadmap import EDGE_ARRAYS, Roadmap


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


def enlarged(roadmap: Roadmap, prover: RecordingProver, nodes: Floats, edges: Ints) -> Roadmap:
    """The roadmap with ``nodes`` (k, dof) after its own and those proven ``edges`` (j, 2) that it lacks.

    The margin is that of the weaker proofs; whatever was proven with a larger one has so much more clearance.
    """
    robot, everything = prover.robot, np.vstack([roadmap.nodes, nodes])
    edges, place = _lacking(roadmap.edges, edges, len(everything))
    clearance, samples = prover.certificates(everything, edges)
    margin = min(roadmap.origin.margin, prover.world.margin)
    fresh = {
        "edges": edges,
        "proven": np.ones(len(edges), dtype=bool),
        **measure_edges(robot, everything, edges),
        "clearance": clearance + (prover.world.margin - margin),
        "samples": samples,
    }
    old: dict[str, Any] = {name: getattr(roadmap, name) for name in EDGE_ARRAYS}
    old["clearance"] = old["clearance"] + (roadmap.origin.margin - margin)
    return replace(
        roadmap,
        nodes=everything,
        manipulability=np.concatenate([roadmap.manipulability, manipulability(robot, nodes)]),
        origin=replace(roadmap.origin, margin=margin),
        **{name: np.insert(old[name], place, fresh[name], axis=0) for name in EDGE_ARRAYS},
    )


def _lacking(known: Ints, edges: Ints, n: int) -> tuple[Ints, Ints]:
    """The ``edges`` that are not among the ``known`` ones, which are sorted, each once; and before which each goes."""
    there, keys = known[:, 0] * n + known[:, 1], np.unique(edges[:, 0] * n + edges[:, 1])
    place = np.searchsorted(there, keys)
    new = np.append(there, -1)[place] != keys
    return np.column_stack([keys[new] // n, keys[new] % n]), place[new]
