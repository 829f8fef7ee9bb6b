"""One run of ``benchmarks plan``, in a process of its own: plan, measure the path, write the results.

python -m benchmarks.plan.case out.json '{"robot": "panda", "scene": "shelf", "seed": 1}'
"""

from __future__ import annotations

import itertools
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import plan_request
from benchmarks.memory import peak_memory
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.base.progress import Progress
from planner.batch.outcomes import REFUSED
from planner.collision import BACKENDS, make_checker
from planner.collision.checker import CollisionChecker
from planner.paths.measure import path_clearance, path_contact
from planner.planning.plan import plan
from planner.planning.result import Plan, plan_record
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.sampling.first_path import FIRST_PATH

_STAGES = ("setup", "roadmap", "costs", "gabf", "path")


def measure(request: PlanRequest) -> dict[str, Any]:
    """Plan, and the columns of the row that came of it; input that the planner refuses is a row like any other."""
    first_path = _FirstPath()
    try:
        found = plan(request, Progress(first_path))
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    total = time.perf_counter() - first_path.begin
    columns = _columns(found) | {"total_s": total, "memory_mib": peak_memory()}
    if found.outcome is not Outcome.SOLVED:
        return columns
    return columns | {"first_path_s": first_path.seconds} | _along_path(found)


class _FirstPath:
    """Notes from the progress of a plan after how many seconds a first proven path was there."""

    def __init__(self) -> None:
        self.begin = time.perf_counter()
        self.seconds: float | None = None

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage == FIRST_PATH and done >= total and self.seconds is None:
            self.seconds = time.perf_counter() - self.begin


def _columns(found: Plan) -> dict[str, Any]:
    record = plan_record(found)
    roadmap, timings = record["roadmap"], record["timings_s"]
    return {
        "outcome": record["outcome"],
        "message": record["message"],
        "nodes": roadmap["nodes"],
        "edges": roadmap["edges"],
        "certified": roadmap["edges_certified"],
        **{f"{stage}_s": timings.get(stage) for stage in _STAGES},
        **_lengths(record),
    }


def _lengths(record: dict[str, Any]) -> dict[str, Any]:
    length, w = record["path_length"], record["manipulability"]
    if length is None or w is None:
        return {}
    return {
        "waypoints": len(record["path"]),
        "length_rad": length["joint"],
        "length_m": length["workspace"],
        "w_min": w["min"],
        "w_mean": w["mean"],
    }


def _along_path(found: Plan) -> dict[str, Any]:
    """Clearance by the library that planned, contacts by the other one, which shares no verdict with it."""
    other = next(name for name in BACKENDS if name != found.request.collision)
    contacts = path_contacts(make_checker(found.robot, found.scene, other), found.path)
    clearance = path_clearance(found.checker, found.path)[1].min(initial=np.inf)
    return {
        "clearance_m": float(clearance) if np.isfinite(clearance) else None,
        "contacts": len(contacts),
        "contact": contacts[0] if contacts else None,
    }


def path_contacts(checker: CollisionChecker, path: Floats) -> list[str]:
    """For each segment of the path that touches something at a millimetre of motion: where, and what."""
    segments = itertools.pairwise(path) if len(path) > 1 else [(path[0], path[0])]
    found = []
    for k, (a, b) in enumerate(segments):
        contact = path_contact(checker, np.array([a, b]))
        if contact is not None:
            found.append(f"segment {k} at {contact.share:.4f}: {contact.contact}")
    return found


def main(out: str, options: str) -> None:
    """What the process does: plan, measure, write."""
    found = measure(plan_request(json.loads(options)))
    write_whole(Path(out), json.dumps(found, allow_nan=False).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
