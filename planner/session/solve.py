"""From a query to its plan: ends are linked, the field heals, and only if that is of no use the roadmap grows.

Edges that a change has opened are proven once the field's path uses them; with the first edge that fails those around
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
from planner.planning.result import Plan
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
from planner.search.search import Found, RoadmapPaths, search
from planner.session.live_roadmap import Edges, LiveRoadmap, clauses_of
from planner.trajectory.limits import MotionLimits

_GUESTS = 0.5  # nodes that came with queries, as a share of the lasting ones: beyond it the oldest ones go
_MANY = 0.5  # share of the clauses beyond which a checker of them alone gains nothing


@dataclass(frozen=True, eq=False, repr=False)
class SessionPlan(Plan):
    """A plan of a session; ``path_nodes`` are nodes of its whole roadmap, whose ``edges`` may be open.

    ``edges``: what became of them for this plan. ``nodes_grown``: by how many nodes the roadmap grew because start and
    goal had come apart. ``rounds``: how often the field healed.
    """

    edges: Edges = field(default_factory=Edges)
    nodes_grown: int = 0
    rounds: int = 0


@dataclass(frozen=True)
class PlanningSettings:
    """How a session plans: what it is asked for, the law of its field, its growth, and how a path becomes a motion.

    Once ``progress`` is asked to stop, whatever is under way raises :class:`PlannerError`.
    """

    request: PlanRequest
    law: gabf.Law
    growth: GrowthSettings
    progress: Progress = QUIET
    timing: TimingRequest | None = None


def solve_query(live: LiveRoadmap, query: Query, planning: PlanningSettings) -> tuple[LiveRoadmap, SessionPlan]:
    """The roadmap after a query, and the query's plan, with its motion or the reason why there is no path."""
    begin, timing = time.perf_counter(), planning.timing
    limits = None if timing is None else MotionLimits.from_robot(live.checker.robot, timing)
    if limits is not None and live.world.scene.moving:
        require_earliest(planning.request, timing)
        live, made = _find_earliest(live, query, planning, limits)
    else:
        live, made = _find_path(live, query, planning)
        if not made.solved:
            failed = replace(made, roadmap=live.with_edges(live.proofs.free))
            made = replace(made, reason=why_no_path(failed, planning.progress))
            raise_if_stopped(planning.progress)
        elif timing is not None:
            made = replace(made, trajectory=time_plan(made, timing, limits))
    return live, replace(made, timings={"plan": time.perf_counter() - begin})


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
        live, found, curve = _refine(_adopt_field(searches[-1]), planning)
        edges.append(found)
        searches.append(_search_from(live, planning))
    last, rounds = searches[-1], sum(each.rounds for each in searches)
    live = live if len(live.roadmap.nodes) > len(last.live.roadmap.nodes) else _adopt_field(last)
    of_session = {"edges": sum(edges, Edges()), "nodes_grown": nodes_grown, "rounds": rounds, "curve": curve}
    return live, replace(_make_plan(live, last, query, planning.request), **of_session)


def _make_plan(live: LiveRoadmap, last: LivePath, query: Query, request: PlanRequest) -> SessionPlan:
    """What the last search found, as a plan."""
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


def _refine(live: LiveRoadmap, planning: PlanningSettings) -> tuple[LiveRoadmap, Edges, tuple[tuple[int, float], ...]]:
    """With ``refinement_rounds``, as a plan has them, of the best path that is proven, and its best costs."""
    request, before = planning.request, live.with_edges(live.proofs.free)
    found = improve_roadmap(before, live.checker, request.quality, request.quality.beta, planning.progress)
    raise_if_stopped(planning.progress)
    return live.enlarge(found.roadmap), Edges(proven=len(found.roadmap.edges) - len(before.edges)), found.curve


def _build_first_roadmap(live: LiveRoadmap, query: Query, planning: PlanningSettings) -> LiveRoadmap:
    quality, checker = planning.request.quality, live.checker
    how = quality.nodes, quality.seed, planning.progress, quality.min_manipulability
    roadmap = build_roadmap(checker.robot, checker, query.starts, query.goals, *how)
    raise_if_stopped(planning.progress)
    return live.with_roadmap(roadmap)


def _drop_old_guests(live: LiveRoadmap) -> LiveRoadmap:
    """Without the oldest nodes that came with queries, where these have become many."""
    n = len(live.roadmap.nodes)
    most, keep = int(_GUESTS * live.lasting), np.ones(n, dtype=bool)
    if n - live.lasting > most:
        keep[live.lasting : n - most // 2] = False
    return live if keep.all() else live.without_nodes(keep)


def _attach_ends(live: LiveRoadmap, query: Query, planning: PlanningSettings, join: bool) -> tuple[LiveRoadmap, Edges]:
    """With the query's ends linked, and where ``join`` with what grew to bring them together; what came of edges.

    Nothing grows before every edge is decided, so what is open counts as free.
    """
    ends = (live.roadmap.starts, query.starts), (live.roadmap.goals, query.goals)
    if not join and all(np.array_equal(live.roadmap.nodes[nodes], q) for nodes, q in ends):
        return live, Edges()  # linked already
    before = live.with_edges(~live.proofs.blocked)
    how = planning.request.quality.seed, planning.growth, planning.progress
    after = attach(before, live.checker, query.starts, query.goals, *how, join=join)
    raise_if_stopped(planning.progress)  # what is not proven in an attempt that was ended is not blocked
    return live.enlarge(after), Edges(proven=len(after.edges) - len(before.edges))


def _search_from(live: LiveRoadmap, planning: PlanningSettings) -> LivePath:
    objective = planning.request.quality.objective
    network = build_network(live.roadmap, objective)
    return search_live(live, network, live.x, planning.law, objective.floor, planning.progress)


def _adopt_field(found: LivePath) -> LiveRoadmap:
    return replace(found.live, x=found.x)


def _find_earliest(
    live: LiveRoadmap, query: Query, planning: PlanningSettings, limits: MotionLimits
) -> tuple[LiveRoadmap, SessionPlan]:
    """The roadmap after all its edges are decided, and the plan with the earliest motion among what moves."""
    live, alone = _find_path(live, query, planning)
    live = live.prove(np.flatnonzero(live.proofs.open))
    alone = replace(alone, roadmap=live.with_edges(live.proofs.free))
    if not alone.solved:
        return live, replace(alone, outcome=Outcome.NO_PATH, reason=explain_separation(alone.roadmap, live.checker))
    found = find_earliest(alone, limits, planning.progress)
    raise_if_stopped(planning.progress)
    assert isinstance(found, SessionPlan)  # it is the same plan with another path
    return live, found


@dataclass(frozen=True, eq=False)
class LivePath(Found):
    """What a search found, and the world with what was proven on the way; ``layered`` is its network."""

    live: LiveRoadmap
    layered: LayeredNetwork

    @property
    def nodes(self) -> Ints:
        """The path's nodes (k,) in the roadmap."""
        return self.layered.roadmap_node[self.steps]

    @property
    def x(self) -> Floats:
        """The field (n,) over the roadmap's nodes, for the next search to go on from."""
        return self.field.x[: len(self.live.roadmap.nodes)]


def raise_if_stopped(progress: Progress) -> None:
    """Raise :class:`PlannerError` where the session was closed meanwhile, or its call cancelled."""
    if progress.stopped:
        raise PlannerError("it was cancelled, or the session is closed: ask again, or make a new one.")


def search_live(
    live: LiveRoadmap,
    network: gabf.Network,
    x: Floats,
    law: gabf.Law,
    floor: float = 0.0,
    progress: Progress = QUIET,
) -> LivePath:
    """The cheapest path over edges that are proven now and hold a second look, from the field ``x`` (n,) on.

    ``network`` is of all the roadmap's edges. Raises :class:`PlannerError` once ``progress`` is asked to stop.
    """
    raise_if_stopped(progress)

    def prove(nodes: Ints) -> Ints:
        nonlocal live
        before = live.proofs.blocked
        live, _ = prove_path(live, nodes)
        return np.flatnonzero(live.proofs.blocked & ~before)

    paths = RoadmapPaths(live.roadmap, live.checker.robot, network, floor, prove)
    paths.remove(np.flatnonzero(live.proofs.blocked))
    found = search(paths, law, x, progress=progress)
    raise_if_stopped(progress)
    return LivePath(**vars(found), live=live, layered=paths.layered)


def prove_path(live: LiveRoadmap, steps: Ints, around_too: bool = True) -> tuple[LiveRoadmap, bool]:
    """The world after what was open of a path over nodes ``steps`` (k,) was proven, and whether all of it holds.

    Where it does not the edges around it are proven, too, unless nothing is to be found in its place.
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
    """A second checker that knows at least the pairs of some clauses, and is quicker for knowing few."""
    if clauses.mean() > _MANY or not clauses.any():
        return second_checker(live.checker)
    pairs = clauses[clauses_of(live.world)[1]]
    known = live.checker if live.checker.name == "coal" else None
    return coal_checker(live.world.only(pairs), known)
