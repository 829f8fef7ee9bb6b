"""One run of ``benchmarks quality``, in a process of its own: find a path, measure it, write the results.

python -m benchmarks.quality.case out.json '{"method": "RRT*", "seconds": 5, "request": {"scene": "shelf"}}'
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import plan_request
from benchmarks.quality.ompl_paths import OmplPaths
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.batch.outcomes import NO_PATH, REFUSED, SOLVED
from planner.collision.edge_prover import EdgeProver
from planner.models.robot import Robot
from planner.paths.measure import corners, measure_path, path_manipulability
from planner.planning.plan import plan
from planner.planning.result import plan_record
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.roadmap.straight_motions import Motions
from planner.sampling.joint_space import JointSpace
from planner.setup.open import Query, make_query

OURS = "planner"
_STEP = 0.02  # m of motion between two states that OMPL's planners check


def measure(method: str, request: PlanRequest, seconds: float) -> dict[str, Any]:
    """The columns of one row: the path by ``method``, ours or OMPL's, which gets ``seconds`` of processor time."""
    try:
        return _ours(request) if method == OURS else _ompl(method, make_query(request), request.seed, seconds)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}


def _ours(request: PlanRequest) -> dict[str, Any]:
    plan(replace(request, nodes=2, effort=0))  # so that the time is without the loading of libraries
    begin = time.process_time()
    found = plan(request)
    spent = time.process_time() - begin
    if found.outcome is not Outcome.SOLVED:
        return {"outcome": NO_PATH, "cpu_s": spent}
    record = plan_record(found)
    more = {"cost": record["cost"]["total"], "lower_bound": record["quality"]["lower_bound"]}
    return {"outcome": SOLVED, "cpu_s": spent, **more, **_along(found.robot, found.path)}


def _ompl(method: str, query: Query, seed: int, seconds: float) -> dict[str, Any]:
    robot, check = query.robot, Motions(EdgeProver(query.checker)).looks_free(_STEP)
    begin = time.process_time()
    with OmplPaths(JointSpace.of(robot), check, np.random.default_rng(seed)) as planners:
        path = planners.path(method, query.starts, query.goals, seconds)
    spent = time.process_time() - begin
    if path is None:
        return {"outcome": NO_PATH, "cpu_s": spent}
    return {"outcome": SOLVED, "cpu_s": spent, **_along(robot, robot.unwound(path))}


def _along(robot: Robot, path: Floats) -> dict[str, Any]:
    measures, w = measure_path(robot, path), path_manipulability(robot, path)
    return {
        "length_rad": measures.joint_length,
        "straight_rad": float(np.linalg.norm(path[-1] - path[0], axis=0)),
        "corners": corners(path),
        "w_min": measures.w_min,
        "w_mean": measures.w_mean,
        "dips": bool(w.min() < (1.0 - 1e-6) * min(w[0], w[-1])),
    }


def main(out: str, options: str) -> None:
    """What the process does: plan, measure, write."""
    values = json.loads(options)
    asked = values["request"]
    request = plan_request(asked)
    columns = measure(values["method"], request, values["seconds"])
    write_whole(Path(out), json.dumps(columns, allow_nan=False).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
