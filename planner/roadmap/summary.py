"""What a kept roadmap says of itself, as plain data."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.roadmap.roadmap import Roadmap

QUANTILES = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)


def summary(roadmap: Roadmap) -> dict[str, Any]:
    """Everything about ``roadmap`` that fits on a page; lengths in m, joint motion in rad, None for no finite number.

    ``components`` are sizes, largest first; ``clearance`` is what the certificates promise beyond the margin.
    """
    origin, n = roadmap.origin, len(roadmap.nodes)
    degree = np.bincount(roadmap.edges.ravel(), minlength=n)
    return {
        "robot": origin.robot,
        "scene": origin.scene,
        "joints": list(origin.joints),
        "limits": [list(pair) for pair in zip(origin.lower, origin.upper, strict=True)],
        "tool": origin.tool,
        "margin": origin.margin,
        "seed": origin.seed,
        "versions": dict(origin.versions),
        "nodes": n,
        "edges": len(roadmap.edges),
        "edges_certified": int(roadmap.proven.sum()),
        "nodes_checked": roadmap.nodes_checked,
        "starts": roadmap.starts.tolist(),
        "goals": roadmap.goals.tolist(),
        "connected": roadmap.connected,
        "components": sorted(np.bincount(roadmap.components).tolist(), reverse=True),
        "degree": {"min": int(degree.min()), "mean": float(degree.mean()), "max": int(degree.max())},
        "manipulability": {f"{q:g}": float(np.quantile(roadmap.manipulability, q)) for q in QUANTILES},
        "joint_length": _spread(roadmap.joint_length),
        "tool_length": _spread(roadmap.tool_length),
        "clearance": _spread(roadmap.clearance[roadmap.proven]),
        "samples": int(roadmap.samples.sum()),
        "scale": asdict(roadmap.scale),
        "robot_identity": origin.robot_identity,
        "scene_identity": origin.scene_identity,
        "sha256": roadmap.sha256,
    }


def _spread(values: Floats) -> dict[str, float | None]:
    if not len(values):
        return dict.fromkeys(("min", "median", "max"))
    ends = float(values.min()), float(np.median(values)), float(values.max())
    return {key: end if math.isfinite(end) else None for key, end in zip(("min", "median", "max"), ends, strict=True)}
