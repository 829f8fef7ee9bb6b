"""A roadmap improved for one objective: its best paths refined, and other ones searched where samples say they may be.

Work is counted in rounds, ``refinement_rounds`` of them at most: they end once two thirds have gained nothing. A round
refines the cheapest path that still gains. Every third one, or every second one where w counts, or where no path gains,
one adds informed samples and a path that RRTConnect finds where a cheaper one may pass, searches a cheaper path through
them or else one unlike those that were found before, and refines that. So paths of several homotopy classes are
refined, and as the effort grows the cheapest one converges to the optimum.
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
from planner.roadmap.informed import LazyRoadmap, informed_samples
from planner.roadmap.refine import PathRefiner, simplify
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.shortcuts import count_parts
from planner.robot.robot import Robot

IMPROVING = "improve"  # a stage of progress
_WORKING_ROOM = 1e-3  # m: motions that pass closer take long to prove; a path's last descent goes on from there
_GAIN = 3e-3  # relative: a round that gains less is a path's last one, until all are through
_HOPELESS = 1.25  # a path is left once it costs so many times the cheapest one after its first round
_EXPLORED_EVERY, _EXPLORED_EVERY_FOR_W = 3, 2  # rounds; where w counts there are more local optima
_JOIN_MOTIONS = 3000  # that RRTConnect may check in each of them
_LONGER = 2.0  # times the best path's length: where w counts a cheaper path may be longer, but rarely more
_PATIENCE, _SETTLED = 8, 1e-3  # two thirds of the rounds, these at least, that gain less than this are the last ones
_RESUMED = 4  # after so many searches the cheapest path is refined once more


@dataclass(frozen=True, eq=False)
class Improvement:
    """The ``roadmap`` with the refined paths as nodes and edges, and the best cost after each round.

    ``curve`` are pairs (rounds spent, cost of the cheapest path known), the cost as the network charges it; empty where
    no path was known. The last one is that after :func:`planner.roadmap.refine.simplify`, which may raise it.
    """

    roadmap: Roadmap
    curve: tuple[tuple[int, float], ...] = ()


@dataclass(eq=False)
class _Candidate:
    """A path that is being refined."""

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
        self.finisher, self.refiner = refiner, replace(refiner, resolution=max(refiner.resolution, _WORKING_ROOM))
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
        """Refine the cheapest path that still gains; where there is none, and every third time, search another one."""
        self._rounds += 1
        if self._rounds % self._every == self._every - 1 or not any(c.gains for c in self.candidates):
            newest = self._explore()
        else:
            newest = None
        open_ = [c for c in self.candidates if c.gains]
        if open_:
            self._refine(newest or min(open_, key=lambda c: c.cost))

    def take(self, path: Floats) -> _Candidate:
        """Add a path of proven motions, angles unwound, to those that are refined."""
        path = self._cut(path)
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
        """The last descent of the cheapest path, where rounds ended before it was through, and fewer corners of it."""
        if (best := self.best) is None:
            return
        if best.gains:
            best.path = self.finisher.finish(best.path, best.rounds)
        best.path = simplify(self.finisher, best.path, self._rng)
        best.cost = self.refiner.total(best.path)

    def _explore(self) -> _Candidate | None:
        """A cheaper path through more informed samples, or else one unlike those found before; None where none is."""
        best, self._explored = self.best, self._explored + 1
        around = self._around if best is None else best.path
        if around is not None:
            self.graph.add(informed_samples(self.refiner, around, self._rate, self._rng))
            if (joined := self._joined(around)) is not None:
                self.graph.add_path(joined)
        found = self.graph.cheapest_path()
        if best is not None:
            best.gains |= self._explored % _RESUMED == 0
            if found is None or self.refiner.total(self._cut(found)) >= best.cost * (1.0 - _GAIN):
                found = self.graph.cheapest_path(other=True)
        return None if found is None else self.take(found)

    def _joined(self, around: Floats) -> Floats | None:
        """A path that RRTConnect finds where one cheaper than the best, or ``around``, may pass; None if it fails."""
        refiner, cost, best = self.refiner, self.refiner.cost, self.best
        longest = _LONGER * float(np.linalg.norm(np.diff(around, axis=0), axis=1).sum())
        if best is not None and self._rate > 0:
            longest = min(longest, best.cost / self._rate)
        rng = np.random.default_rng([refiner.seed, self._explored])
        motions = MotionChecker(refiner.prover, cost.objective.floor)
        settings = join_settings(GrowthSettings(join_motions=_JOIN_MOTIONS), motions.robot)
        if cost.objective.beta < 1.0:  # a shorter path is no better one there, and refined as soon
            settings = replace(settings, shortcuts=0)
        ends = self.graph.starts, self.graph.goals
        return find_shorter_path(motions, settings, *ends, longest, rng, refiner.progress)[0]

    def _cut(self, path: Floats) -> Floats:
        """The path without motions that have no cost: those that are too long, or that their ends do not tell."""
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
    """At most ``refinement_rounds`` rounds for the objective ``cost``, from a ``path`` (k, dof) along edges of
    ``roadmap`` if any.

    With a floor of ``cost``, ``path`` must keep above it. Of the roadmap's edges those count that are certified to keep
    ``clearance`` (m) beyond its margin; new motions keep the margin of ``checker``. Nodes and edges of the roadmap
    stay, so no path on it becomes costlier. More effort gives cheaper paths.
    Without a ``path`` one is searched, through samples ``around`` another path (j, dof) where there is one.
    """
    prover = RecordingProver(checker, progress)
    refiner = PathRefiner(prover, cost, PROOF, seed, progress)
    starts, goals = roadmap.starts, roadmap.goals
    if path is not None and cost.objective.floor > 0:  # it may be part of one only
        starts, goals = (np.array([_nearest(checker.robot, roadmap.nodes, q)]) for q in path[[0, -1]])
    search = _Search(roadmap, refiner, starts, goals, around, clearance)
    first = search.graph.cheapest_path() if path is None else checker.robot.unwound(path)
    if first is not None:
        search.take(first)
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
    kept = [c.path for c in search.candidates if c.cost < _HOPELESS * search.best.cost]
    return Improvement(add_paths(roadmap, prover, kept), tuple(curve))


def _has_settled(curve: list[tuple[int, float]], refinement_rounds: int) -> bool:
    """Whether the last rounds of a ``curve`` gained next to nothing: more for more effort, so that it tries more."""
    before = -1 - max(_PATIENCE, 2 * refinement_rounds // 3)
    return len(curve) >= -before and curve[-1][1] > (1.0 - _SETTLED) * curve[before][1]


def _nearest(robot: Robot, nodes: Floats, q: Floats) -> int:
    return int(np.linalg.norm(robot.difference(q, nodes), axis=1).argmin())


def add_paths(roadmap: Roadmap, prover: RecordingProver, paths: list[Floats]) -> Roadmap:
    """The roadmap with ``paths`` of proven motions between its nodes as more nodes and edges."""
    robot: Robot = prover.robot
    forest = Forest(roadmap.nodes)
    for path in paths:
        rows = robot.normalise(path)
        for end in (0, -1):  # these are nodes already: the same to the last bit
            rows[end] = roadmap.nodes[_nearest(robot, roadmap.nodes, rows[end])]
        forest.add_path(rows)
    new, edges = forest.nodes()[len(roadmap.nodes) :], forest.edges()
    return enlarge_roadmap(roadmap, prover, new.reshape(-1, robot.dof), edges)


def remove_last_grown(roadmap: Roadmap, grown: int, nodes: int, path: Ints) -> Roadmap:
    """The roadmap with ``nodes`` nodes: as many as were added to the first ``grown`` ones go, the last grown first.

    It is as if the tree had stopped earlier: nodes before them do not need them. What refined paths and ``path`` (k,)
    consist of, starts and goals stay; more nodes are left only where these alone are more.
    """
    spare = len(roadmap.nodes) - nodes
    if spare <= 0:
        return roadmap
    kept = np.zeros(len(roadmap.nodes), dtype=bool)
    kept[roadmap.edges[(roadmap.edges >= grown).any(axis=1)]] = True
    kept[np.concatenate([roadmap.starts, roadmap.goals, path])] = True
    kept[np.flatnonzero(~kept)[:-spare]] = True
    return roadmap.part(kept, np.ones(len(roadmap.edges), dtype=bool))
