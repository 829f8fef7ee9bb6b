"""Solve a query of a session: link its ends, heal the field, and grow the roadmap if no path is found.

An edge that a change has opened is proven when the field's path uses it. If its proof fails, open edges at the nodes of
the path are proven too.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.errors import PlannerError
from planner.base.progress import QUIET, Progress
from planner.collision import coal_checker, second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.recheck import recheck_pieces, straight
from planner.planning.improvement import improve_roadmap
from planner.planning.result import Curve, Plan
from planner.planning.solve import find_earliest, require_earliest, time_plan, why_no_path
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, TimingRequest
from planner.query.query import Query
from planner.roadmap.build import build_roadmap
from planner.roadmap.connect_endpoints import attach
from planner.roadmap.grow import GrowthSettings
from planner.roadmap.infeasibility import explain_separation
from planner.roadmap.roadmap import path_waypoints
from planner.search.manipulability_floor import LayeredNetwork
from planner.search.network import build_network, edge_rows, path_cost
from planner.search.search import RoadmapPaths, SearchResult, search
from planner.session.live_roadmap import EdgeChanges, LiveRoadmap, clauses_of
from planner.trajectory.limits import MotionLimits

_GUESTS = 0.5  # largest share of nodes of old queries, relative to lasting nodes; the oldest are dropped
_MANY = 0.5  # share of the clauses beyond which a checker of these alone is not faster


@dataclass(frozen=True, eq=False, repr=False)
class SessionPlan(Plan):
    """A plan of a session; ``path_nodes`` are nodes of its whole roadmap, which can have open edges.

    ``edges`` counts the changes of edges during this plan, ``nodes_grown`` the nodes added to connect start and goal,
    ``rounds`` how often the field healed.
    """

    edges: EdgeChanges = field(default_factory=EdgeChanges)
    nodes_grown: int = 0
    rounds: int = 0


@dataclass(frozen=True)
class PlanningSettings:
    """Settings of a session: request, law of the field, growth, progress, and timing of motions.

    When ``progress`` requests a stop, the running call raises :class:`PlannerError`.
    """

    request: PlanRequest
    law: gabf.Law
    growth: GrowthSettings
    progress: Progress = QUIET
    timing: TimingRequest | None = None


def solve_query(live: LiveRoadmap, query: Query, planning: PlanningSettings) -> tuple[LiveRoadmap, SessionPlan]:
    """Solve a query; return the roadmap after it and the plan, with a motion or the reason of a failure."""
    begin, timing = time.perf_counter(), planning.timing
    limits = None if timing is None else MotionLimits.from_robot(live.checker.robot, timing)
    if limits is not None and live.world.scene.moving:
        require_earliest(planning.request, timing)
        live, plan = _find_earliest(live, query, planning, limits)
    else:
        live, plan = _find_path(live, query, planning)
        if not plan.solved:
            failed = replace(plan, roadmap=live.with_edges(live.proofs.free))
            plan = replace(plan, reason=why_no_path(failed, planning.progress))
            raise_if_stopped(planning.progress)
        elif timing is not None:
            plan = replace(plan, trajectory=time_plan(plan, timing, limits))
    return live, replace(plan, timings={"plan": time.perf_counter() - begin})


def _find_path(live: LiveRoadmap, query: Query, planning: PlanningSettings) -> tuple[LiveRoadmap, SessionPlan]:
    raise_if_stopped(planning.progress)
    may_grow = live.kept is not None
    live = _drop_old_guests(live if may_grow else _build_first_roadmap(live, query, planning))
    live, linked = _attach_ends(live, query, planning, join=False)
    nodes, searches = len(live.roadmap.nodes), [_search_from(live, planning)]
    edges = [linked, searches[-1].live.proofs.since(live.proofs)]
    if may_grow and not len(searches[-1].steps):
        before = _adopt_field(searches[-1])
        live = before.prove(np.flatnonzero(before.proofs.open))  # growth begins at nodes that are proven free
        live, grown = _attach_ends(live, query, planning, join=True)
        edges.append(grown)
        if live.with_edges(live.proofs.free).is_connected:
            searches.append(_search_from(live, planning))
            edges.append(searches[-1].live.proofs.since(live.proofs))
    nodes_grown, curve = len(live.roadmap.nodes) - nodes, ()
    if len(searches[-1].steps) and planning.request.quality.rounds:
        live, refined, curve = _refine(_adopt_field(searches[-1]), planning)
        edges.append(refined)
        searches.append(_search_from(live, planning))
    last, rounds = searches[-1], sum(each.rounds for each in searches)
    live = live if len(live.roadmap.nodes) > len(last.live.roadmap.nodes) else _adopt_field(last)
    of_session = {"edges": sum(edges, EdgeChanges()), "nodes_grown": nodes_grown, "rounds": rounds, "curve": curve}
    return live, replace(_make_plan(live, last, query, planning.request), **of_session)


def _make_plan(live: LiveRoadmap, last: LivePath, query: Query, request: PlanRequest) -> SessionPlan:
    """Return the result of the last search as a plan."""
    robot, solved = live.checker.robot, len(last.steps) > 0
    failed = Outcome.TOO_SINGULAR if request.quality.min_manipulability > 0 else Outcome.NO_PATH
    path = path_waypoints(live.roadmap, robot, last.nodes)
    return SessionPlan(
        request.with_options(robot=robot, scene=live.world.scene),
        Outcome.SOLVED if solved else failed,
        live.checker,
        live.with_edges(~live.proofs.blocked),
        layered=last.layered,
        cost_to_go=last.field,
        path=path,
        path_nodes=frozen(last.nodes, np.int64),
        goal=query.goal_at(path[-1]) if solved else None,
        end_notes=query.end_notes,
        cost=path_cost(last.layered.network, last.steps) if solved else None,
    )


def _refine(live: LiveRoadmap, planning: PlanningSettings) -> tuple[LiveRoadmap, EdgeChanges, Curve]:
    """Refine the best proven path as a plan does; return the roadmap, counts of edges, and best costs."""
    request, before = planning.request, live.with_edges(live.proofs.free)
    improvement = improve_roadmap(before, live.checker, request.quality, request.quality.beta, planning.progress)
    raise_if_stopped(planning.progress)
    changes = EdgeChanges(proven=len(improvement.roadmap.edges) - len(before.edges))
    return live.enlarge(improvement.roadmap), changes, improvement.curve


def _build_first_roadmap(live: LiveRoadmap, query: Query, planning: PlanningSettings) -> LiveRoadmap:
    quality, checker = planning.request.quality, live.checker
    how = quality.nodes, quality.seed, planning.progress, quality.min_manipulability
    roadmap = build_roadmap(checker.robot, checker, query.starts, query.goals, *how)
    raise_if_stopped(planning.progress)
    return live.with_roadmap(roadmap)


def _drop_old_guests(live: LiveRoadmap) -> LiveRoadmap:
    """Drop the oldest nodes of earlier queries if there are many."""
    n = len(live.roadmap.nodes)
    most, keep = int(_GUESTS * live.lasting), np.ones(n, dtype=bool)
    if n - live.lasting > most:
        keep[live.lasting : n - most // 2] = False
    return live if keep.all() else live.without_nodes(keep)


def _attach_ends(
    live: LiveRoadmap, query: Query, planning: PlanningSettings, join: bool
) -> tuple[LiveRoadmap, EdgeChanges]:
    """Link the query's ends to the roadmap, and with ``join`` grow it to connect them; count edges.

    Open edges count as free, as growth follows only after all edges are decided.
    """
    ends = (live.roadmap.starts, query.starts), (live.roadmap.goals, query.goals)
    if not join and all(np.array_equal(live.roadmap.nodes[nodes], q) for nodes, q in ends):
        return live, EdgeChanges()  # already linked
    before = live.with_edges(~live.proofs.blocked)
    how = planning.request.quality.seed, planning.growth, planning.progress
    after = attach(before, live.checker, query.starts, query.goals, *how, join=join)
    raise_if_stopped(planning.progress)  # an unfinished proof does not block an edge
    return live.enlarge(after), EdgeChanges(proven=len(after.edges) - len(before.edges))


def _search_from(live: LiveRoadmap, planning: PlanningSettings) -> LivePath:
    objective = planning.request.quality.objective
    network = build_network(live.roadmap, objective)
    return search_live(live, network, live.x, planning.law, objective.floor, planning.progress)


def _adopt_field(path: LivePath) -> LiveRoadmap:
    return replace(path.live, x=path.x)


def _find_earliest(
    live: LiveRoadmap, query: Query, planning: PlanningSettings, limits: MotionLimits
) -> tuple[LiveRoadmap, SessionPlan]:
    """Decide all edges; return the roadmap and the plan with the earliest motion among moving obstacles."""
    live, alone = _find_path(live, query, planning)
    live = live.prove(np.flatnonzero(live.proofs.open))
    alone = replace(alone, roadmap=live.with_edges(live.proofs.free))
    if not alone.solved:
        return live, replace(alone, outcome=Outcome.NO_PATH, reason=explain_separation(alone.roadmap, live.checker))
    earliest = find_earliest(alone, limits, planning.progress)
    raise_if_stopped(planning.progress)
    assert isinstance(earliest, SessionPlan)  # find_earliest replaces fields of the same plan
    return live, earliest


@dataclass(frozen=True, eq=False)
class LivePath(SearchResult):
    """The result of a search, and the roadmap with the proofs made for it; ``layered`` is its network."""

    live: LiveRoadmap
    layered: LayeredNetwork

    @property
    def nodes(self) -> Ints:
        """Nodes (k,) of the path in the roadmap."""
        return self.layered.roadmap_node[self.steps]

    @property
    def x(self) -> Floats:
        """Field (n,) over the roadmap's nodes, the initial field of the next search."""
        return self.field.x[: len(self.live.roadmap.nodes)]


def raise_if_stopped(progress: Progress) -> None:
    """Raise :class:`PlannerError` if the session is closed or its call is cancelled."""
    if progress.stopped:
        raise PlannerError("the call was cancelled, or the session is closed: call again, or make a new session.")


def search_live(
    live: LiveRoadmap,
    network: gabf.Network,
    x: Floats,
    law: gabf.Law,
    floor: float = 0.0,
    progress: Progress = QUIET,
) -> LivePath:
    """Find the cheapest path over proven and rechecked edges, starting from the field ``x`` (n,).

    ``network`` has all edges of the roadmap. Raises :class:`PlannerError` when ``progress`` requests a stop.
    """
    raise_if_stopped(progress)

    def prove(nodes: Ints) -> Ints:
        nonlocal live
        before = live.proofs.blocked
        live, _ = prove_path(live, nodes)
        return np.flatnonzero(live.proofs.blocked & ~before)

    paths = RoadmapPaths(live.roadmap, live.checker.robot, network, floor, prove)
    paths.remove(np.flatnonzero(live.proofs.blocked))
    result = search(paths, law, x, progress=progress)
    raise_if_stopped(progress)
    return LivePath(**vars(result), live=live, layered=paths.layered)


def prove_path(live: LiveRoadmap, steps: Ints, around_too: bool = True) -> tuple[LiveRoadmap, bool]:
    """Prove open edges of a path over nodes ``steps`` (k,); return the roadmap and whether it is free.

    If a proof fails, ``around_too`` also proves the open edges at these nodes, for the next path.
    """
    rows = edge_rows(live.roadmap, steps[:-1], steps[1:])
    live = live.prove(rows[live.proofs.open[rows]])
    if live.proofs.blocked[rows].any():
        if not around_too:
            return live, False
        around = np.isin(live.roadmap.edges, steps).any(axis=1)
        return live.prove(np.flatnonzero(around & live.proofs.open)), False
    unseen = ~live.proofs.seen[rows]
    if not unseen.any():
        return live, True
    path = path_waypoints(live.roadmap, live.checker.robot, steps)
    new = np.flatnonzero(unseen.any(axis=1))
    second = _make_second_checker(live, np.asarray(unseen.any(axis=0)))
    contact = recheck_pieces(live.checker, straight(path[new], path[new + 1] - path[new]), second=second)
    if contact is not None:
        return replace(live, proofs=live.proofs.refuse(int(rows[new[contact.piece]]))), False
    return replace(live, proofs=live.proofs.confirm(rows)), True


def _make_second_checker(live: LiveRoadmap, clauses: Bools) -> CollisionChecker:
    """Return a second checker of at least the pairs of ``clauses``; fewer pairs are faster."""
    if clauses.mean() > _MANY or not clauses.any():
        return second_checker(live.checker)
    pairs = clauses[clauses_of(live.world)[1]]
    known = live.checker if live.checker.name == "coal" else None
    return coal_checker(live.world.only(pairs), known)
