"""Answers that a change of the code is not to change: roadmap, path and intervals of beta of small plans.

``python -m tests.golden`` writes ``golden.json`` anew, for a change that means to: say so in its commit.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from planner.base.versions import versions
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from planner.tradeoff.sweep import sweep

FILE = Path(__file__).with_name("golden.json")
REQUESTS = {
    "iiwa14 in paper, FCL": PlanRequest(nodes=60),
    "iiwa14 in paper, coal, charged edges, floor": PlanRequest(
        nodes=80, collision="coal", charge="edges", min_manipulability=0.02
    ),
    "panda in shelf, FCL": PlanRequest(robot="panda", scene="shelf", nodes=60),
    "panda in shelf, coal": PlanRequest(robot="panda", scene="shelf", nodes=60, collision="coal", beta=0.2, seed=3),
    "ur5 in table, coal": PlanRequest(robot="ur5", scene="table", nodes=40, collision="coal"),
    "kinova in window, coal": PlanRequest(robot="kinova", scene="window", nodes=40, collision="coal"),
    "planar_2r in cage, FCL": PlanRequest(robot="planar_2r", scene="cage", nodes=40),
}
SWEPT = PlanRequest(nodes=80, collision="coal")


def answer(request: PlanRequest) -> dict[str, Any]:
    """What of a plan is kept: hashes of roadmap and path, and how it ended."""
    found = plan(request)
    path = hashlib.sha256(found.path.tobytes()).hexdigest()
    return {"outcome": found.outcome.key, "roadmap": found.roadmap.sha256, "path": path}


def intervals(request: PlanRequest) -> list[list[float]]:
    return [[found.beta_min, found.beta_max, found.w_min] for found in sweep(request).intervals]


def main() -> None:
    made = {"plans": {name: answer(request) for name, request in REQUESTS.items()}, "sweep": intervals(SWEPT)}
    FILE.write_text(json.dumps(made | {"versions": versions()}, indent=1) + "\n")


if __name__ == "__main__":
    main()
