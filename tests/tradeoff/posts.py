"""A small sweep with several intervals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from planner.problem.request import SweepRequest

SCENE = """
obstacles: [{{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}}]
states: {{planar_2r: {{start: "{start}", goal: "q:1.0,-0.8"}}}}
"""


def asked(folder: Path, start: str = "q:-1.0,0.8", effort: int = 0, **more: Any) -> SweepRequest:
    """planar_2r round a post, on 150 nodes: several intervals, and paths between them that no beta reaches."""
    (folder / "post.yaml").write_text(SCENE.format(start=start))
    return SweepRequest.from_options(
        robot="planar_2r", scene=str(folder / "post.yaml"), nodes=150, seed=2, effort=effort, **more
    )
