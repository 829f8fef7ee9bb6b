"""One plan of a batch, in a process of its own: plan, write the folder, and the columns of its row.

python -m planner.batch.case row.json FOLDER '{"robot": "panda", "scene": "shelf"}' page
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.batch.options import plan_request
from planner.batch.outcomes import REFUSED
from planner.planning.plan import plan
from planner.planning.result import save_plan, save_plan_without_page
from planner.problem.request import PlanRequest
from planner.tradeoff.alternatives import with_alternatives


def planned(request: PlanRequest, folder: Path, page: bool) -> dict[str, Any]:
    """Plan, write ``folder``, and the columns that came of it; what the planner refuses is a row like any other."""
    try:
        found = plan(request)
        record = save_plan(with_alternatives(found), folder) if page else save_plan_without_page(found, folder)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    return columns(record)


def columns(record: dict[str, Any]) -> dict[str, Any]:
    """The columns of a row out of a plan's record."""
    length, w, cost, roadmap = (record[key] or {} for key in ("path_length", "manipulability", "cost", "roadmap"))
    return {
        "outcome": record["outcome"],
        "message": record["message"],
        "goal_reached": record["goal"],
        "waypoints": len(record["path"]) or None,
        "cost": cost.get("total"),
        "w_min": w.get("min"),
        "w_mean": w.get("mean"),
        "length_rad": length.get("joint"),
        "length_m": length.get("workspace"),
        "nodes": roadmap["nodes"],
        "edges": roadmap["edges"],
        "edges_certified": roadmap["edges_certified"],
        "roadmap_sha256": roadmap["sha256"],
    }


def main(out: str, folder: str, options: str, page: str = "") -> None:
    """What the process does."""
    found = planned(plan_request(json.loads(options)), Path(folder), bool(page))
    write_whole(Path(out), json.dumps(found, allow_nan=False).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
