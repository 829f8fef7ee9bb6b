"""One run of ``benchmarks first-path``, in a process of its own: a path by one method, and a dense look at it.

python -m benchmarks.first_path.case out.json '{"method": "planner", "request": {"scene": "shelf"}, ...}'
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.first_path import runner
from benchmarks.first_path.exchange import exchanged
from benchmarks.first_path.ompl_connect import OmplConnect
from benchmarks.first_path.report import OMPL, OURS
from benchmarks.plan.case import path_contacts
from benchmarks.roadmap.case import plain_check
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.base.progress import Progress
from planner.batch.options import plan_request
from planner.batch.outcomes import NO_PATH, REFUSED, SOLVED
from planner.collision import BACKENDS, make_checker
from planner.paths.measure import corners, joint_path_length
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from planner.sampling.first_path import FIRST_PATH
from planner.setup.open import Query, make_query

_WAIT = 30.0  # s that a process of another environment may take beyond the time for its search

Columns = dict[str, Any]


def measure(method: str, python: str, request: PlanRequest, seconds: float) -> Columns:
    """The columns of one row; ``python`` runs methods of other environments."""
    try:
        query = make_query(request)
        if method == OURS:
            columns, path = _ours(request)
        elif method == OMPL:
            columns, path = _ompl(query, request.seed, seconds)
        else:
            columns, path = _other(method, python, query, request.seed, seconds)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    if path is None:
        return {"outcome": NO_PATH, **columns}
    return {"outcome": SOLVED, **columns, **_looked_at(query, path, request.collision)}


def _ours(request: PlanRequest) -> tuple[Columns, Floats | None]:
    """``planner plan --path-only`` without its motion and page; the libraries are loaded."""
    watch, begin, cpu = _FirstPath(), time.perf_counter(), time.process_time()
    found = plan(request, Progress(watch))
    total, setup = time.perf_counter() - begin, found.timings["setup"]
    first = total if watch.seconds is None else watch.seconds - begin
    columns = {"setup_s": setup, "first_s": first - setup, "path_s": total - setup, "cpu_s": time.process_time() - cpu}
    return {**columns, "version": importlib.metadata.version("gabf-planner")}, found.path if len(found.path) else None


class _FirstPath:
    """Notes from the progress of a plan when its first path is proven; shortcuts come after."""

    def __init__(self) -> None:
        self.seconds: float | None = None

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage == FIRST_PATH and done >= total and self.seconds is None:
            self.seconds = time.perf_counter()


def _ompl(query: Query, seed: int, seconds: float) -> tuple[Columns, Floats | None]:
    """RRTConnect with Pinocchio's loop over all pairs of coal as state check, as its documentation shows."""
    begin, cpu = time.perf_counter(), time.process_time()
    connect = OmplConnect(query.robot, plain_check(query.checker), seed)
    columns: Columns = {"setup_s": time.perf_counter() - begin, "version": importlib.metadata.version("ompl")}
    begin = time.perf_counter()
    solved = connect.solve(query.starts[0], query.goals[0], seconds)
    columns["first_s"] = time.perf_counter() - begin
    path = connect.simplified() if solved else None
    if solved:
        columns["path_s"] = time.perf_counter() - begin
    return columns | {"cpu_s": time.process_time() - cpu}, path


def _other(method: str, python: str, query: Query, seed: int, seconds: float) -> tuple[Columns, Floats | None]:
    """What :mod:`benchmarks.first_path.runner` answers, run by another Python."""
    with tempfile.TemporaryDirectory() as place:
        problem, answer = Path(place) / "problem.json", Path(place) / "answer.json"
        problem.write_text(json.dumps(exchanged(query, seed, seconds)))
        command = [python, "-I", runner.__file__, method, str(problem), str(answer)]
        try:
            ended = subprocess.run(command, capture_output=True, text=True, timeout=seconds + _WAIT, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PlannerError(f"{python} did not answer: {error}.") from None
        if ended.returncode:
            said = ended.stderr.strip().splitlines() or [f"exit code {ended.returncode}"]
            raise PlannerError(f"{method} in {python}: {said[-1]}")
        found = json.loads(answer.read_text())
    path = found.pop("path")
    return found, None if path is None else query.robot.unwound(np.array(path))


def _looked_at(query: Query, path: Floats, collision: str) -> Columns:
    """Length, corners, and what the library that has not planned finds at a millimetre of motion."""
    other = make_checker(query.robot, query.scene, next(name for name in BACKENDS if name != collision))
    contacts = path_contacts(other, path)
    return {
        "length_rad": joint_path_length(path),
        "corners": corners(path),
        "contacts": len(contacts),
        "message": contacts[0] if contacts else "",
    }


def main(out: str, options: str) -> None:
    """What the process does: plan, look, write."""
    importlib.import_module("scipy.sparse.csgraph")  # as the other planners' libraries: before a clock starts
    values = json.loads(options)
    asked = values.pop("request")
    request = plan_request(asked)
    write_whole(Path(out), json.dumps(measure(request=request, **values), allow_nan=False).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
