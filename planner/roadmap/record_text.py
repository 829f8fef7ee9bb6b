"""A roadmap's record, and the same in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from planner.cost.scale import CostScale
from planner.problem.run_schema import Record


@dataclass(frozen=True, kw_only=True, eq=False)
class RoadmapRecord(Record):
    """Size, proofs and hash of the roadmap."""

    nodes: int
    nodes_checked: dict[str, int]
    """how many nodes each collision library has found free"""
    edges: int
    """counted undirected"""
    components: int
    edges_certified: int
    """edges that are proven free"""
    edges_removed: int
    """edges that failed the second check"""
    sha256: str
    scale: CostScale


def roadmap_text(roadmap: dict[str, Any]) -> str:
    """A roadmap's record as a line of a table."""
    return (
        f"{roadmap['nodes']} nodes ({checks_text(roadmap['nodes_checked'], roadmap['nodes'])}), "
        f"{roadmap['edges']} edges, {roadmap['edges_certified']} of them proven free, "
        f"{roadmap['components']} component{'s' if roadmap['components'] != 1 else ''}"
    )


def checks_text(checked: dict[str, int], nodes: int) -> str:
    """Who looked at how many of the ``nodes``, as words behind their number."""
    parts = [f"{'each' if count == nodes else count} checked by {name}" for name, count in checked.items() if count]
    return ", ".join(parts) or "checked by no library"
