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
