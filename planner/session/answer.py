"""From a query to its plan: ends are linked, the field heals, and only if that is of no use the roadmap grows."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import frozen
from planner.base.progress import QUIET, Progress
from planner.planning.improvement import improved_roadmap
from planner.planning.result import Edges, Plan, Replanned
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.query.query import Query
from planner.roadmap.build import build_roadmap
from planner.roadmap.connect_endpoints import attach
from planner.roadmap.grow import GrowthSettings
from planner.roadmap.infeasibility import why_apart
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.search.network import build_network, path_cost
from planner.session.live_roadmap import LiveRoadmap
from planner.session.search import LiveFound, go_on, search_live
from planner.trajectory.earliest import earliest_motion, why_not_in_time
from planner.trajectory.limits import MotionLimits

_GUESTS = 0.5  # nodes that came with queries, as a share of the lasting ones: beyond it the oldest ones go


@dataclass(frozen=True)
class Planning:
    """How a session plans: what it is asked for but start, goal and beta, the law of its field, its growth.

    Once ``progress`` is asked to stop, whatever is under way raises :class:`PlannerError`.
    """

    request: PlanRequest
    law: gabf.Law
    growth: GrowthSettings
    progress: Progress = QUIET


def answered(live: LiveRoadmap, query: Query, planning: Planning) -> tuple[LiveRoadmap, Plan]:
    """The roadmap after a query, and the query's plan."""
    go_on(planning.progress)
    begin, may_grow = time.perf_counter(), live.kept is not None
    live = _without_old_guests(live if may_grow else _with_first_roadmap(live, query, planning))
    live, linked = _attached(live, query, planning, join=False)
    nodes, searches = len(live.roadmap.nodes), [_search(live, planning)]
    edges = [linked, searches[-1].live.proofs.since(live.proofs)]
    if may_grow and not len(searches[-1].steps):
        before = _after(searches[-1])
        live = before.proven(np.flatnonzero(before.proofs.open))  # growth begins at nodes that are proven free
        live, grown = _attached(live, query, planning, join=True)
        edges.append(grown)
        if live.held(live.proofs.free).connected:
            searches.append(_search(live, planning))
            edges.append(searches[-1].live.proofs.since(live.proofs))
    nodes_grown, curve = len(live.roadmap.nodes) - nodes, ()
    if len(searches[-1].steps) and planning.request.quality.rounds:
        live, found, curve = _refined(_after(searches[-1]), planning)
        edges.append(found)
        searches.append(_search(live, planning))
    last = searches[-1]
    live = live if len(live.roadmap.nodes) > len(last.live.roadmap.nodes) else _after(last)
    done = Replanned(
        sum(edges, Edges()),
        nodes_grown=nodes_grown,
        rounds=sum(each.rounds for each in searches),
        raised=sum(each.raised for each in searches),
        updates=sum(each.updates for each in searches),
    )
    made = _plan(live, last, query, planning.request)
    return live, replace(made, curve=curve, replanned=done, timings={"plan": time.perf_counter() - begin})


def _plan(live: LiveRoadmap, last: LiveFound, query: Query, request: PlanRequest) -> Plan:
    """What the last search found, as a plan."""
    robot, solved = live.checker.robot, len(last.steps) > 0
    failed = Outcome.TOO_SINGULAR if request.quality.min_manipulability > 0 else Outcome.NO_PATH
    path = path_waypoints(live.roadmap, robot, last.nodes)
    return Plan(
        request.with_options(robot=robot, scene=live.world.scene),
        Outcome.SOLVED if solved else failed,
        live.checker,
        live.held(~live.proofs.blocked),
        layered=last.layered,
        cost_to_go=last.field,
        path=path,
        path_nodes=frozen(last.nodes, np.int64),
        goal=query.goal_at(path[-1]) if solved else None,
        end_notes=query.end_notes,
        cost=path_cost(last.layered.network, last.steps) if solved else None,
    )


def _refined(live: LiveRoadmap, planning: Planning) -> tuple[LiveRoadmap, Edges, tuple[tuple[int, float], ...]]:
    """With ``effort`` rounds of refinement, as a plan has them, of the best path that is proven, and its best costs."""
    request, before = planning.request, live.held(live.proofs.free)
    found = improved_roadmap(before, live.checker, request.quality, request.quality.beta, planning.progress)
    go_on(planning.progress)
    return live.enlarged(found.roadmap), Edges(proven=len(found.roadmap.edges) - len(before.edges)), found.curve


def _with_first_roadmap(live: LiveRoadmap, query: Query, planning: Planning) -> LiveRoadmap:
    quality, checker = planning.request.quality, live.checker
    how = quality.nodes, quality.seed, planning.progress, quality.min_manipulability
    roadmap = build_roadmap(checker.robot, checker, query.starts, query.goals, *how)
    go_on(planning.progress)
    return live.with_roadmap(roadmap)


def _without_old_guests(live: LiveRoadmap) -> LiveRoadmap:
    """Without the oldest nodes that came with queries, where these have become many."""
    n = len(live.roadmap.nodes)
    most, keep = int(_GUESTS * live.lasting), np.ones(n, dtype=bool)
    if n - live.lasting > most:
        keep[live.lasting : n - most // 2] = False
    return live if keep.all() else live.without_nodes(keep)


def _attached(live: LiveRoadmap, query: Query, planning: Planning, join: bool) -> tuple[LiveRoadmap, Edges]:
    """With the query's ends linked, and where ``join`` with what grew to bring them together; what came of edges.

    Nothing grows before every edge is decided, so what is open counts as free.
    """
    if not join and _linked_already(live.roadmap, query):
        return live, Edges()
    before = live.held(~live.proofs.blocked)
    how = planning.request.quality.seed, planning.growth, planning.progress
    after = attach(before, live.checker, query.starts, query.goals, *how, join=join)
    go_on(planning.progress)  # what is not proven in an attempt that was ended is not blocked
    return live.enlarged(after), Edges(proven=len(after.edges) - len(before.edges))


def _linked_already(roadmap: Roadmap, query: Query) -> bool:
    """Whether the query's ends are the roadmap's own: the same question once more."""
    ends = (roadmap.starts, query.starts), (roadmap.goals, query.goals)
    return all(np.array_equal(roadmap.nodes[nodes], q) for nodes, q in ends)


def _search(live: LiveRoadmap, planning: Planning) -> LiveFound:
    objective = planning.request.quality.objective
    network = build_network(live.roadmap, objective)
    return search_live(live, network, live.x, planning.law, objective.floor, planning.progress)


def _after(found: LiveFound) -> LiveRoadmap:
    return replace(found.live, x=found.x)


def answered_in_time(
    live: LiveRoadmap, query: Query, planning: Planning, limits: MotionLimits
) -> tuple[LiveRoadmap, Plan]:
    """The roadmap after all its edges are decided, and the plan with the earliest motion among what moves."""
    live, alone = answered(live, query, planning)
    begin = time.perf_counter()
    live = live.proven(np.flatnonzero(live.proofs.open))
    roadmap, checker = live.held(live.proofs.free), live.checker
    found = earliest_motion(roadmap, checker, limits) if alone.solved else None
    if found is None:
        reason = why_not_in_time(roadmap, checker, limits) if alone.solved else why_apart(roadmap, checker)
        none = {"path": alone.path[:0], "path_nodes": alone.path_nodes[:0], "goal": None, "cost": None}
        timed = replace(alone, outcome=Outcome.NO_PATH, reason=reason, **none)
    else:
        assert alone.network is not None  # it was solved
        nodes = found.route.nodes
        timed = replace(
            alone,
            path=path_waypoints(roadmap, checker.robot, nodes),
            path_nodes=nodes,
            cost=path_cost(alone.network, nodes),
            trajectory=found.trajectory,
            route=found.route,
        )
    timings = alone.timings | {"timing": time.perf_counter() - begin}
    return live, replace(timed, roadmap=roadmap, timings=timings)
