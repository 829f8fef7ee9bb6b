"""One method of ``benchmarks roadmap``, in a process of its own: build a roadmap, query it, check it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.looks import path_contacts
from benchmarks.memory import peak_memory
from benchmarks.roadmap.report import MEASURED, OMPL_PLAIN, OURS, PLAN
from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.errors import SceneError
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.recheck import sample_segment
from planner.gabf.path import paths_from
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, WorldRequest
from planner.query.query import make_checker_for
from planner.roadmap.build import build_roadmap
from planner.roadmap.connect_endpoints import attach
from planner.roadmap.measure import check_nodes
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.search.network import build_network

_MOST_DRAWS = 20_000
_EDGES_LOOKED_AT = 200

Columns = dict[str, Any]
Answer = Callable[[Floats, Floats], Floats]
"""From a start and a goal (dof,) to a path (k, dof), empty where there is none."""


def measure(method: str, robot: str, scene: str, collision: str, nodes: int, queries: int, seed: int) -> Columns:
    """Return the columns of the row of ``method``."""
    if method == PLAN:
        return _plan(PlanRequest.from_options(robot=robot, scene=scene, collision=collision, nodes=nodes, seed=seed))  # type: ignore[arg-type]
    checker = make_checker_for(WorldRequest(robot, scene, collision=collision))  # type: ignore[arg-type]
    pairs = random_pairs(checker, queries + 1, seed)
    if method == OURS:
        return _ours(checker, pairs, nodes, seed)
    free = plain_check(checker) if method == OMPL_PLAIN else lambda q: is_free(checker, q)
    return _ompl(checker, free, pairs, nodes, seed)


def random_pairs(checker: CollisionChecker, count: int, seed: int) -> Floats:
    """Free configurations (count, 2, dof): starts and goals; :class:`SceneError` where hardly any is free."""
    robot, rng = checker.robot, np.random.default_rng(seed)
    found: list[Floats] = []
    for _ in range(_MOST_DRAWS):
        q = rng.uniform(robot.lower, robot.upper)
        if is_free(checker, q):
            found.append(q)
        if len(found) == 2 * count:
            return np.array(found).reshape(count, 2, robot.dof)
    raise SceneError(
        f"of {_MOST_DRAWS} random configurations of {robot.name} only {len(found)} are free in scene "
        f"'{checker.world.scene.name}': choose another scene."
    )


def _ours(checker: CollisionChecker, pairs: Floats, nodes: int, seed: int) -> Columns:
    begin, cpu = time.perf_counter(), time.process_time()
    roadmap = build_roadmap(checker.robot, checker, pairs[0, 0], pairs[0, 1], nodes, seed)
    seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
    begin = time.perf_counter()
    check_nodes(replace(roadmap, checked_by=np.zeros(len(roadmap.nodes), dtype=np.int8)), checker)
    checks = time.perf_counter() - begin
    columns = _measure_queries(checker, pairs[1:], lambda start, goal: answer(roadmap, checker, start[None], goal)[0])
    begin = time.perf_counter()
    answer(roadmap, checker, pairs[1:, 0], pairs[1, 1])
    many = 1e3 * (time.perf_counter() - begin) / len(pairs[1:])
    graph = _count_touching(checker, roadmap.nodes, roadmap.edges, seed)
    built = {"build_s": seconds, "node_checks_s": checks, "proven": int(roadmap.proven.sum()), "cpu_s": cpu}
    return columns | graph | built | {"many_ms": many}


def _plan(request: PlanRequest) -> Columns:
    """A whole plan, refined as by default, in a process that has done nothing else: its time and its peak memory."""
    begin, cpu = time.perf_counter(), time.process_time()
    found = plan(request=request, timing=None)
    seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
    columns = {"nodes": len(found.roadmap.nodes), "edges": len(found.roadmap.edges), "cpu_s": cpu}
    return {"outcome": MEASURED, "plan_s": seconds, "memory_mib": peak_memory(), **columns}


def answer(roadmap: Roadmap, checker: CollisionChecker, starts: Floats, goal: Floats) -> list[Floats]:
    """The path from each of ``starts`` (s, dof) to ``goal`` (dof,) off one field; empty where there is none."""
    joined = attach(roadmap, checker, starts, goal[None])
    network = build_network(joined)
    field = gabf.solve(network, law=gabf.SingularityFree())
    return [path_waypoints(joined, checker.robot, steps) for steps in paths_from(network, field, joined.starts)]


def plain_check(checker: CollisionChecker) -> Callable[[Floats], bool]:
    """Whether a configuration (dof,) is free, by Pinocchio's loop over all pairs of the same world with coal."""
    import pinocchio as pin

    from planner.collision.coal import CoalChecker

    model, geometry = checker.robot.model, CoalChecker(checker.world).geometry_model
    data, found = model.createData(), geometry.createData()
    return lambda q: not pin.computeCollisions(model, data, geometry, found, q, True)


def _ompl(checker: CollisionChecker, free: Callable[[Floats], bool], pairs: Floats, nodes: int, seed: int) -> Columns:
    from benchmarks.others.ompl import OmplPrm

    prm = OmplPrm(checker.robot, free, seed)
    return _peer(checker, pairs, seed, lambda: prm.build(nodes), prm.graph, prm.query)


def _peer(
    checker: CollisionChecker,
    pairs: Floats,
    seed: int,
    build: Callable[[], None],
    graph: Callable[[], tuple[Floats, Ints]],
    query: Answer,
) -> Columns:
    begin = time.perf_counter()
    build()
    seconds = time.perf_counter() - begin
    columns = _count_touching(checker, *graph(), seed)  # before the queries, which may add to it
    return columns | {"build_s": seconds} | _measure_queries(checker, pairs[1:], query)


def _measure_queries(checker: CollisionChecker, pairs: Floats, query: Answer) -> Columns:
    """How long the queries take, one by one, and whether their answers touch anything at a millimetre of motion."""
    seconds, paths = [], []
    for start, goal in pairs:
        begin = time.perf_counter()
        path = query(start, goal)
        seconds.append(time.perf_counter() - begin)
        if len(path):
            paths.append(path)
    coal = _with(checker, "coal")
    return {
        "outcome": MEASURED,
        "query_ms": 1e3 * float(np.median(seconds)),
        "query_worst_ms": 1e3 * max(seconds),
        "solved": len(paths),
        "contacts": sum(len(path_contacts(coal, checker.robot.unwound(path))) for path in paths),
    }


def _with(checker: CollisionChecker, backend: str) -> CollisionChecker:
    """A checker of the same robot and scene by ``backend``."""
    return make_checker(checker.robot, checker.world.scene, backend)


def _count_touching(checker: CollisionChecker, nodes: Floats, edges: Ints, seed: int) -> Columns:
    """The size of the roadmap, and how many of its edges touch something at a millimetre of motion."""
    coal, rng = _with(checker, "coal"), np.random.default_rng(seed)  # FCL would take minutes
    rows = rng.permutation(len(edges))[:_EDGES_LOOKED_AT]
    a, b = nodes[edges[rows, 0]], nodes[edges[rows, 1]]
    touching = sum(sample_segment(coal, q, d) is not None for q, d in zip(a, coal.robot.difference(a, b), strict=True))
    return {"nodes": len(nodes), "edges": len(edges), "looked_at": len(rows), "touching": touching}
