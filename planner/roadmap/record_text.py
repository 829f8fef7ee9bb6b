"""A roadmap's record, :meth:`planner.roadmap.roadmap.Roadmap.record`, in words."""

from __future__ import annotations

from typing import Any


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
