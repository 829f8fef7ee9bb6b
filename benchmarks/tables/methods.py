"""What ``python -m benchmarks tables`` measures of ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from planner.problem.request import PlanRequest

PATH_ONLY, KEPT = "path only", "kept roadmap"


def asked_by(plain: PlanRequest, betas: Sequence[float], kept: bool) -> dict[str, PlanRequest]:
    """The request of every method, by its name; ``plain`` has the nodes of the roadmaps."""
    found = {PATH_ONLY: replace(plain, path_only=True, nodes=PlanRequest.nodes)}
    found |= {f"beta {beta:g}": replace(plain, beta=beta) for beta in betas}
    return found | ({KEPT: replace(plain, beta=1.0)} if kept else {})
