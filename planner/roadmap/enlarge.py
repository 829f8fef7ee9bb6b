"""A roadmap with more nodes and proven edges: its own keep their numbers, proofs and cost scale."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.kinematics.manipulability import manipulability
from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.measure import measure_edges
from planner.roadmap.roadmap import EDGE_ARRAYS, Roadmap


def enlarged(roadmap: Roadmap, prover: RecordingProver, nodes: Floats, edges: Ints) -> Roadmap:
    """The roadmap with ``nodes`` (k, dof) after its own and those proven ``edges`` (j, 2) that it lacks.

    The margin is that of the weaker proofs; whatever was proven with a larger one has so much more clearance.
    """
    robot, everything = prover.robot, np.vstack([roadmap.nodes, nodes])
    edges = _lacking(roadmap.edges, edges, len(everything))
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
    merged = {name: np.concatenate([old[name], fresh[name]]) for name in EDGE_ARRAYS}
    order = np.lexsort((merged["edges"][:, 1], merged["edges"][:, 0]))
    return replace(
        roadmap,
        nodes=everything,
        manipulability=np.concatenate([roadmap.manipulability, manipulability(robot, nodes)]),
        origin=replace(roadmap.origin, margin=margin),
        **{name: array[order] for name, array in merged.items()},
    )


def _lacking(known: Ints, edges: Ints, n: int) -> Ints:
    """The ``edges`` that are not among the ``known`` ones, each once."""
    keys = np.unique(edges[:, 0] * n + edges[:, 1])
    keys = keys[~np.isin(keys, known[:, 0] * n + known[:, 1])]
    return np.column_stack([keys // n, keys % n])
