"""A roadmap with more nodes and proven edges: its own keep their numbers, proofs and cost scale."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Bools, Floats, Ints
from planner.kinematics.manipulability import node_manipulability
from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.measure import measure_edges
from planner.roadmap.node_checks import nobody, with_checked_nodes
from planner.roadmap.roadmap import EDGE_ARRAYS, Roadmap


def enlarged(
    roadmap: Roadmap, prover: RecordingProver, nodes: Floats, edges: Ints, ends: tuple[Ints, Ints] | None = None
) -> Roadmap:
    """The roadmap with ``nodes`` (k, dof) after its own and those proven ``edges`` (j, 2) that it lacks.

    ``ends``: its starts and goals from then on. The new nodes are checked as
    :func:`planner.roadmap.node_checks.with_checked_nodes` has it. The margin is that of the weaker proofs; whatever was
    proven with a larger one has so much more clearance.
    """
    robot, everything = prover.robot, np.vstack([roadmap.nodes, nodes])
    edges, place = _lacking(roadmap.edges, edges, len(everything))
    clearance, samples = prover.certificates(everything, edges)
    margin = min(roadmap.origin.margin, prover.world.margin)
    fresh = {
        "edges": edges,
        "proven": np.ones(len(edges), dtype=bool),
        **measure_edges(robot, everything, edges, roadmap.scale),
        "clearance": clearance + (prover.world.margin - margin),
        "samples": samples,
    }
    old: dict[str, Any] = {name: getattr(roadmap, name) for name in EDGE_ARRAYS}
    old["clearance"] = old["clearance"] + (roadmap.origin.margin - margin)
    is_old = np.ones(len(roadmap.edges) + len(edges), dtype=bool)
    is_old[place + np.arange(len(edges))] = False
    starts, goals = (roadmap.starts, roadmap.goals) if ends is None else ends
    bigger = replace(
        roadmap,
        nodes=everything,
        starts=starts,
        goals=goals,
        manipulability=np.concatenate([roadmap.manipulability, node_manipulability(robot, nodes)]),
        checked_by=np.concatenate([roadmap.checked_by, nobody(len(nodes))]),
        origin=replace(roadmap.origin, margin=margin),
        **{name: _merged(old[name], fresh[name], is_old) for name in EDGE_ARRAYS},
    )
    return with_checked_nodes(bigger, prover.checker, first=len(roadmap.nodes))


def _merged(old: NDArray[Any], fresh: NDArray[Any], is_old: Bools) -> NDArray[Any]:
    """The rows of two arrays in one that is not written to: row after row the next of ``old`` where ``is_old`` (m,)."""
    rows = np.empty((len(is_old), *old.shape[1:]), dtype=old.dtype)
    rows[is_old], rows[~is_old] = old, fresh
    rows.setflags(write=False)
    return rows


def _lacking(known: Ints, edges: Ints, n: int) -> tuple[Ints, Ints]:
    """The ``edges`` that are not among the ``known`` ones, which are sorted, each once; and before which each goes."""
    there, keys = known[:, 0] * n + known[:, 1], np.unique(edges[:, 0] * n + edges[:, 1])
    place = np.searchsorted(there, keys)
    new = np.append(there, -1)[place] != keys
    return np.column_stack([keys[new] // n, keys[new] % n]), place[new]
