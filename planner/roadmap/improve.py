"""Improve a roadmap for one objective: refine its best paths and search others by informed samples.

Work is counted in ``rounds``: they end once two thirds have gained nothing. A round refines the cheapest path that
still gains. Every third one, or every second one where w counts, or where no path gains, a round adds informed samples
and a path of RRTConnect where a cheaper one may pass, searches a cheaper path through them or else one unlike those
before, and refines it. So paths of several homotopy classes are refined, and with the number of rounds the cheapest one
converges to the optimum.
"""

from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats, Ints, cut
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF
from planner.collision.checker import CollisionChecker
from planner.cost.motion_cost import MotionCost
from planner.roadmap.edges import MotionChecker, RecordingProver, enlarge_roadmap
from planner.roadmap.first_path import find_shorter_path
from planner.roadmap.forest import Forest
from planner.roadmap.grow import GrowthSettings, join_settings
from planner.roadmap.informed import LazyRoadmap, sample_informed_set
from planner.roadmap.refine import PathRefiner, simplify
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.shortcuts import count_parts
from planner.robot.robot import Robot

IMPROVING = "improve"  # a stage of progress
_WORKING_CLEARANCE = 1e-3  # m: proofs of closer motions take long; only a path's last descent allows them
_GAIN = 3e-3  # relative: a round that gains less is a path's last one, until all are refined
_HOPELESS = 1.25  # a path is dropped once it costs so many times the cheapest one after its first round
_EXPLORED_EVERY, _EXPLORED_EVERY_FOR_W = 3, 2  # rounds; where w counts there are more local optima
_JOIN_MOTIONS = 3000  # that RRTConnect may check in each of them
_LONGER = 2.0  # times the best path's length: where w counts a cheaper path may be longer, but rarely more
_PATIENCE, _SETTLED = 8, 1e-3  # rounds, at least, that gain less than this share before the search ends
_RESUMED = 4  # after so many searches the cheapest path is refined again


@dataclass(frozen=True, eq=False)
class Improvement:
    """The ``roadmap`` with the refined paths as nodes and edges, and the best cost after each round.

    ``curve`` are pairs (rounds spent, cost of the cheapest known path), the cost as the network charges it; empty
    without a path. The last one is that after :func:`planner.roadmap.refine.simplify`, which may raise it.
    """

    roadmap: Roadmap
    curve: tuple[tuple[int, float], ...] = ()


@dataclass(eq=False)
class _Candidate:
    """A path under refinement."""

    path: Floats
    cost: float
    gains: bool = True
    rounds: int = 0


class _Search:
    """The rounds of one improvement."""

    def __init__(
        self,
        roadmap: Roadmap,
        refiner: PathRefiner,
        starts: Ints,
        goals: Ints,
        around: Floats | None = None,
        clearance: float = 0.0,
    ) -> None:
        self._around = around
        self.finisher, self.refiner = refiner, replace(refiner, resolution=max(refiner.resolution, _WORKING_CLEARANCE))
        self._rng, cost = np.random.default_rng(refiner.seed + 1), refiner.cost
        whole = replace(refiner, cost=replace(cost, longest=np.inf))  # edges of any length stand in the roadmap
        edges = roadmap.edges[roadmap.clearance >= clearance]
        self.graph = LazyRoadmap(whole, roadmap.nodes, edges, starts, goals)
        objective = cost.objective
        unit = cost.scale.joint_length if objective.metric == "joint" else np.inf
        least = cost.scale.zeta if objective.cost_integration == "edges" else 0.0
        self._rate = objective.total(least, 1.0) / unit
        self._every = _EXPLORED_EVERY if objective.beta == 1.0 else _EXPLORED_EVERY_FOR_W
        self.candidates: list[_Candidate] = []
        self._rounds = self._explored = 0

    @property
    def best(self) -> _Candidate | None:
        return min(self.candidates, key=lambda c: c.cost, default=None)

    def round(self) -> None:
        """Refine the cheapest path that still gains, or search another one."""
        self._rounds += 1
        if self._rounds % self._every == self._every - 1 or not any(c.gains for c in self.candidates):
            newest = self._explore()
        else:
            newest = None
        open_ = [c for c in self.candidates if c.gains]
        if open_:
            self._refine(newest or min(open_, key=lambda c: c.cost))

    def add_candidate(self, path: Floats) -> _Candidate:
        """Add a path of proven motions, angles unwound, to the candidates."""
        path = self._split_costless(path)
        self.candidates.append(_Candidate(path, self.refiner.total(path)))
        self.graph.penalise(path)
        return self.candidates[-1]

    def _refine(self, candidate: _Candidate) -> None:
        before, candidate.path = candidate.cost, self.refiner.round(candidate.path, candidate.rounds)
        candidate.rounds += 1
        candidate.cost = self.refiner.total(candidate.path)
        least = min(c.cost for c in self.candidates)
        candidate.gains = candidate.cost < before * (1.0 - _GAIN) and candidate.cost < _HOPELESS * least
        if not candidate.gains:
            candidate.path = self.finisher.finish(candidate.path, candidate.rounds)
            candidate.cost = self.refiner.total(candidate.path)

    def finish(self) -> None:
        """Finish the last descent of the cheapest path and simplify it."""
        if (best := self.best) is None:
            return
        if best.gains:
            best.path = self.finisher.finish(best.path, best.rounds)
        best.path = simplify(self.finisher, best.path, self._rng)
        best.cost = self.refiner.total(best.path)

    def _explore(self) -> _Candidate | None:
        """Return a cheaper path through more informed samples, or one unlike those before; None without one."""
        best, self._explored = self.best, self._explored + 1
        around = self._around if best is None else best.path
        if around is not None:
            self.graph.add(sample_informed_set(self.refiner, around, self._rate, self._rng))
            if (joining := self._join_ends(around)) is not None:
                self.graph.add_path(joining)
        path = self.graph.cheapest_path()
        if best is not None:
            best.gains |= self._explored % _RESUMED == 0
            if path is None or self.refiner.total(self._split_costless(path)) >= best.cost * (1.0 - _GAIN):
                path = self.graph.cheapest_path(other=True)
        return None if path is None else self.add_candidate(path)

    def _join_ends(self, around: Floats) -> Floats | None:
        """Return a path of RRTConnect that may be cheaper than the best, or than ``around``; None on failure."""
        refiner, cost, best = self.refiner, self.refiner.cost, self.best
        longest = _LONGER * float(np.linalg.norm(np.diff(around, axis=0), axis=1).sum())
        if best is not None and self._rate > 0:
            longest = min(longest, best.cost / self._rate)
        rng = np.random.default_rng([refiner.seed, self._explored])
        motions = MotionChecker(refiner.prover, cost.objective.floor)
        settings = join_settings(GrowthSettings(join_motions=_JOIN_MOTIONS), motions.robot)
        if cost.objective.beta < 1.0:  # a shorter path need not be cheaper there
            settings = replace(settings, shortcuts=0)
        ends = self.graph.starts, self.graph.goals
        return find_shorter_path(motions, settings, *ends, longest, rng, refiner.progress)[0]

    def _split_costless(self, path: Floats) -> Floats:
        """Return the path without motions of infinite cost: too long, or half a turn."""
        cost = self.refiner.cost
        longest = cost.longest if cost.objective.beta < 1.0 else np.inf
        return cut(path, count_parts(cost.robot, np.diff(path, axis=0), longest))


def improve(
    roadmap: Roadmap,
    checker: CollisionChecker,
    cost: MotionCost,
    path: Floats | None,
    rounds: int,
    seed: int = 0,
    progress: Progress = QUIET,
    around: Floats | None = None,
    clearance: float = 0.0,
) -> Improvement:
    """Improve ``roadmap`` for the objective of ``cost`` in at most ``rounds`` rounds.

    ``path`` (k, dof) leads along edges of ``roadmap``; without one it is searched, through samples ``around`` another
    path (j, dof) if given. With a floor of ``cost``, ``path`` must stay above it. Only edges certified to have
    ``clearance`` (m) beyond the roadmap's margin count; new motions have the margin of ``checker``. Nodes and edges of
    the roadmap stay, so no path on it becomes costlier. More rounds give cheaper paths.
    """
    prover = RecordingProver(checker, progress)
    refiner = PathRefiner(prover, cost, PROOF, seed, progress)
    starts, goals = roadmap.starts, roadmap.goals
    if path is not None and cost.objective.floor > 0:  # it may be only a section of a path from a start to a goal
        starts, goals = (np.array([_nearest(checker.robot, roadmap.nodes, q)]) for q in path[[0, -1]])
    search = _Search(roadmap, refiner, starts, goals, around, clearance)
    first = search.graph.cheapest_path() if path is None else checker.robot.unwound(path)
    if first is not None:
        search.add_candidate(first)
    curve = [] if search.best is None else [(0, search.best.cost)]
    progress(IMPROVING, 0, rounds)
    for spent in range(1, rounds + 1):
        if progress.stopped:
            break
        if _has_settled(curve, rounds):
            progress(IMPROVING, rounds, rounds)
            break
        search.round()
        if search.best is not None:
            curve.append((spent, search.best.cost))
        progress(IMPROVING, spent, rounds)
    if search.best is None:
        return Improvement(roadmap)
    search.finish()
    curve[-1] = (curve[-1][0], search.best.cost)
    paths = [c.path for c in search.candidates if c.cost < _HOPELESS * search.best.cost]
    return Improvement(add_paths(roadmap, prover, paths), tuple(curve))


def _has_settled(curve: list[tuple[int, float]], rounds: int) -> bool:
    """Return whether the last two thirds of all ``rounds`` gained less than ``_SETTLED``."""
    before = -1 - max(_PATIENCE, 2 * rounds // 3)
    return len(curve) >= -before and curve[-1][1] > (1.0 - _SETTLED) * curve[before][1]


def _nearest(robot: Robot, nodes: Floats, q: Floats) -> int:
    return int(np.linalg.norm(robot.difference(q, nodes), axis=1).argmin())


def add_paths(roadmap: Roadmap, prover: RecordingProver, paths: list[Floats]) -> Roadmap:
    """Return the roadmap with ``paths`` of proven motions between its nodes as more nodes and edges."""
    robot: Robot = prover.robot
    forest = Forest(roadmap.nodes)
    for path in paths:
        rows = robot.normalise(path)
        for end in (0, -1):  # the exact nodes
            rows[end] = roadmap.nodes[_nearest(robot, roadmap.nodes, rows[end])]
        forest.add_path(rows)
    new, edges = forest.nodes()[len(roadmap.nodes) :], forest.edges()
    return enlarge_roadmap(roadmap, prover, new.reshape(-1, robot.dof), edges)


def drop_last_nodes(roadmap: Roadmap, grown: int, nodes: int, path: Ints) -> Roadmap:
    """Return the roadmap with ``nodes`` nodes: it drops the last ones of its first ``grown`` nodes.

    The tree might have stopped earlier: nodes before them do not need them. The nodes of refined paths and of ``path``
    (k,), starts and goals stay; more nodes remain only where these alone are more.
    """
    excess = len(roadmap.nodes) - nodes
    if excess <= 0:
        return roadmap
    used = np.zeros(len(roadmap.nodes), dtype=bool)
    used[roadmap.edges[(roadmap.edges >= grown).any(axis=1)]] = True
    used[np.concatenate([roadmap.starts, roadmap.goals, path])] = True
    used[np.flatnonzero(~used)[:-excess]] = True
    return roadmap.part(used, np.ones(len(roadmap.edges), dtype=bool))
