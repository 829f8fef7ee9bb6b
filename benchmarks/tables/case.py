"""One method of ``benchmarks tables`` on tasks of one scene, in a process of its own."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.looks import other_checker, path_contacts
from benchmarks.problems import read_request
from planner import gabf
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.batch.run import NO_PATH, REFUSED, SOLVED
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from planner.query.query import Query, make_query
from planner.roadmap.build import build_roadmap
from planner.roadmap.connect_endpoints import attach
from planner.roadmap.roadmap import path_waypoints
from planner.search.network import build_network
from planner.trajectory.measure import measure_path

SAVED = "saved roadmap"

Columns = dict[str, Any]
Answer = Callable[[Query], tuple[Floats, float]]
"""The path (k, dof), and the seconds of its set-up, which do not count."""


def measure(method: str, tasks: Sequence[tuple[str, str]], request: Columns) -> list[Columns]:
    """Return the columns of each task (start, goal); ``request`` holds the other options."""
    plain = read_request(request)
    requests = [plain.with_options(start=start, goal=goal) for start, goal in tasks]
    try:
        queries = [make_query(one.what) for one in requests]
        if method == SAVED:
            return _measure_on_saved_roadmap(plain, queries)
        return [
            _measure_query(query, lambda _, one=one: _plan(one)) for query, one in zip(queries, requests, strict=True)
        ]
    except PlannerError as error:
        return [{"outcome": REFUSED, "message": str(error)} for _ in tasks]


def _plan(request: PlanRequest) -> tuple[Floats, float]:
    result = plan(request=request, timing=None)
    return result.path, result.timings["setup"]


def _measure_on_saved_roadmap(request: PlanRequest, queries: Sequence[Query]) -> list[Columns]:
    """Return the columns of each query on one roadmap that was grown around the home configuration."""
    home = make_query(request.with_options(start="home", goal="home").what)
    checker, begin = home.checker, time.perf_counter()
    roadmap = build_roadmap(
        checker.robot, checker, home.starts, home.goals, request.quality.nodes, request.quality.seed
    )
    seconds = time.perf_counter() - begin

    def answer(query: Query) -> tuple[Floats, float]:
        joined = attach(roadmap, checker, query.starts, query.goals, request.quality.seed)
        network = build_network(joined, request.quality.beta)
        field = gabf.solve(network, law=gabf.SingularityFree())
        steps = gabf.cheapest_path(field, joined.starts[:1])
        return path_waypoints(joined, checker.robot, steps), 0.0

    return [_measure_query(query, answer) | {"build_s": seconds} for query in queries]


def _measure_query(query: Query, answer: Answer) -> Columns:
    """Seconds of the wall clock and of the processor to an answer, and the answer's measures."""
    begin, cpu = time.perf_counter(), time.process_time()
    path, setup = answer(query)
    columns: Columns = {"seconds": time.perf_counter() - begin - setup, "cpu_s": time.process_time() - cpu}
    if len(path) < 2:
        return {"outcome": NO_PATH, **columns}
    measures = measure_path(query.robot, path)
    other = other_checker(query.robot, query.scene, query.checker.name)
    return columns | {
        "outcome": SOLVED,
        "length_rad": measures.joint_length,
        "straight_rad": float(np.linalg.norm(query.robot.difference(path[0], path[-1]))),
        "w_min": measures.w_min,
        "w_mean": measures.w_mean,
        "contacts": len(path_contacts(other, path)),
    }
