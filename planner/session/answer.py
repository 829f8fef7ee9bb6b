"""From a query to its plan: ends are linked, the field heals, and only if that is of no use the roadmap grows."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, frozen
from planner.base.progress import QUIET, Progress
from planner.planning.improvement import improved_roadmap
from planner.planning.replanned import Edges, Replanned
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.query.query import Query
from planner.roadmap.build import build_roadmap
from planner.roadmap.connect_endpoints import attach
from planner.roadmap.growth_settings import GrowthSettings
from planner.roadmap.node_checks import with_checked_nodes
from planner.roadmap.reprove import in_this_world
from planner.roadmap.roadmap import Roadmap, kept_part, path_waypoints
from planner.search.network import build_network, path_cost
from planner.session.live_world import LiveWorld
from planner.session.search import Found, RoadmapNetwork, go_on, search

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


@dataclass(frozen=True, eq=False)
class Moment:
    """The world, and the field ``x`` over the nodes of its roadmap that the last query left behind."""

    live: LiveWorld
    x: Floats


def adopted(live: LiveWorld, roadmap: Roadmap) -> LiveWorld:
    """With a kept roadmap, as far as it holds in this world."""
    roadmap = in_this_world(roadmap, live.checker)
    return live.with_roadmap(with_checked_nodes(kept_part(roadmap, live.checker.world.keeps), live.checker))


def answered(moment: Moment, query: Query, planning: Planning) -> tuple[Moment, Plan]:
    """The moment after a query, and its plan."""
    go_on(planning.progress)
    begin, may_grow = time.perf_counter(), moment.live.kept is not None
    moment = _without_old_guests(moment if may_grow else _with_first_roadmap(moment, query, planning))
    live, linked = _attached(moment.live, query, planning, join=False)
    edges, nodes = [linked], len(live.roadmap.nodes)
    searches = [_search(Moment(live, moment.x), planning)]
    edges.append(searches[-1].live.proofs.since(live.proofs))
    if may_grow and not len(searches[-1].steps):
        before = searches[-1].live
        live = before.proven(np.flatnonzero(before.proofs.open))  # growth begins at nodes that are proven free
        live, grown = _attached(live, query, planning, join=True)
        edges.append(grown)
        if live.held(live.proofs.free).connected:
            searches.append(_search(Moment(live, searches[-1].x), planning))
            edges.append(searches[-1].live.proofs.since(live.proofs))
    grown, curve = len(live.roadmap.nodes) - nodes, ()
    if len(searches[-1].steps) and planning.request.quality.rounds:
        live, found, curve = _refined(searches[-1].live, planning)
        edges.append(found)
        searches.append(_search(Moment(live, searches[-1].x), planning))
    last = searches[-1]
    live = live if len(live.roadmap.nodes) > len(last.live.roadmap.nodes) else last.live
    done = Replanned(
        sum(edges, Edges()),
        nodes_grown=grown,
        rounds=sum(each.rounds for each in searches),
        raised=sum(each.raised for each in searches),
        updates=sum(each.updates for each in searches),
    )
    made = _plan(live, last, query, planning.request)
    return Moment(live, last.x), replace(
        made, curve=curve, replanned=done, timings={"plan": time.perf_counter() - begin}
    )


def _plan(live: LiveWorld, last: Found, query: Query, request: PlanRequest) -> Plan:
    """What the last search found, as a plan."""
    robot, solved = live.checker.robot, len(last.steps) > 0
    failed = Outcome.TOO_SINGULAR if request.quality.min_manipulability > 0 else Outcome.NO_PATH
    path = path_waypoints(live.roadmap, robot, last.nodes)
    return Plan(
        request.with_options(robot=robot, scene=live.scene),
        Outcome.SOLVED if solved else failed,
        robot,
        live.scene,
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


def _refined(live: LiveWorld, planning: Planning) -> tuple[LiveWorld, Edges, tuple[tuple[int, float], ...]]:
    """With ``effort`` rounds of refinement, as a plan has them, of the best path that is proven, and its best costs."""
    request, before = planning.request, live.held(live.proofs.free)
    found = improved_roadmap(before, live.checker, request.quality, request.quality.beta, planning.progress)
    go_on(planning.progress)
    return live.enlarged(found.roadmap), Edges(proven=len(found.roadmap.edges) - len(before.edges)), found.curve


def _with_first_roadmap(moment: Moment, query: Query, planning: Planning) -> Moment:
    checker = moment.live.checker
    request = planning.request
    how = request.quality.nodes, request.quality.seed, planning.progress, request.quality.min_manipulability
    roadmap = build_roadmap(checker.robot, checker, query.starts, query.goals, *how)
    go_on(planning.progress)
    return replace(moment, live=moment.live.with_roadmap(roadmap))


def _without_old_guests(moment: Moment) -> Moment:
    """Without the oldest nodes that came with queries, where these have become many."""
    live, n = moment.live, len(moment.live.roadmap.nodes)
    most, keep = int(_GUESTS * live.lasting), np.ones(n, dtype=bool)
    if n - live.lasting > most:
        keep[live.lasting : n - most // 2] = False
    x = np.concatenate([moment.x, np.full(n - len(moment.x), np.inf)])
    return Moment(live if keep.all() else live.without_nodes(keep), x[keep])


def _attached(live: LiveWorld, query: Query, planning: Planning, join: bool) -> tuple[LiveWorld, Edges]:
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


def _search(moment: Moment, planning: Planning) -> Found:
    live, n = moment.live, len(moment.live.roadmap.nodes)
    objective = planning.request.quality.objective
    network = RoadmapNetwork(live.roadmap, lambda roadmap: build_network(roadmap, objective))
    x = np.concatenate([moment.x, np.full(n - len(moment.x), np.inf)])
    return search(live, network, x, planning.law, objective.floor, planning.progress)
