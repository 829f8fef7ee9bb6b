"""The one door to OMPL: RRTConnect joins start and goal, RRT grows the rest (Kuffner and LaValle 2000)."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from planner.arrays import Floats, Ints
from planner.collision.edges import EdgeProver
from planner.robot import Robot

_TRY = 3000  # motions that one try to join may check
_STEPS = (1.0, 2.0, 0.5)  # steps of the tries, in ranges
_GLANCES = np.array([1.0, 0.5])  # where a motion is looked at before it is proven


@dataclass(frozen=True)
class GrowthSettings:
    """How far a tree steps and how long it tries; counts, never clocks, so that a run can be repeated.

    ``range`` (rad): longer steps cross free space sooner, shorter ones enter narrow passages. ``join_motions``: motions
    that RRTConnect may check before it gives up; ``shortcuts``: attempts to shorten its path. ``motions_per_node``:
    motions that RRT may check for each node it is to add.
    """

    range: float = 0.8
    join_motions: int = 10_000
    shortcuts: int = 100
    motions_per_node: int = 20


@dataclass(frozen=True, eq=False)
class Growth:
    """A forest of proven motions: ``nodes`` (n, dof), starts first, then goals; ``edges`` (m, 2)."""

    nodes: Floats
    edges: Ints
    starts: Ints
    goals: Ints
    joined: bool  # a start and a goal, by RRTConnect
    motions: int  # motions checked


def grow(
    robot: Robot,
    prover: EdgeProver,
    starts: Floats,
    goals: Floats,
    nodes: int,
    seed: int,
    settings: GrowthSettings,
    progress: Callable[[int, int], None] = lambda done, total: None,
    stop: Callable[[], bool] = lambda: False,
) -> Growth:
    """Grow about ``nodes`` configurations around a first path from ``starts`` (s, dof) to ``goals`` (g, dof).

    Should the path itself need more than ``nodes``, all of it is kept. The same seed gives the same growth.
    """
    ou.noOutputHandler()
    ou.RNG.setSeed(seed + 1)  # OMPL turns seed 0 into 1, so pass on seed + 1 to keep them apart
    motions = _Motions(robot, prover, stop)
    try:
        forest = _Forest()
        first = np.array([forest.add(q) for q in starts], dtype=np.int64)
        last = np.array([forest.add(q) for q in goals], dtype=np.int64)
        spine = None if np.intersect1d(first, last).size else _join(motions, starts, goals, settings)
        if spine is not None:
            forest.add_path(spine)
        wanted = nodes - len(forest)
        if wanted > 0 and not stop():
            _grow_tree(motions, forest, wanted, settings, progress)
        return Growth(forest.nodes(), forest.edges(), first, last, spine is not None, motions.checked)
    finally:
        motions.release()


class _Forest:
    """Nodes by their exact values, so that what two planners share is one node."""

    def __init__(self) -> None:
        self._index: dict[bytes, int] = {}
        self._nodes: list[Floats] = []
        self._edges: list[tuple[int, int]] = []

    def __len__(self) -> int:
        return len(self._nodes)

    def add(self, q: Floats) -> int:
        index = self._index.setdefault(q.tobytes(), len(self._nodes))
        if index == len(self._nodes):
            self._nodes.append(q)
        return index

    def add_edge(self, a: Floats, b: Floats) -> None:
        i, j = self.add(a), self.add(b)
        if i != j:
            self._edges.append((min(i, j), max(i, j)))

    def add_path(self, path: Floats) -> None:
        for a, b in itertools.pairwise(path):
            self.add_edge(a, b)

    def nodes(self) -> Floats:
        return np.array(self._nodes)

    def edges(self) -> Ints:
        unique = dict.fromkeys(self._edges)
        return np.array(list(unique), dtype=np.int64).reshape(-1, 2)


class _Motions:
    """The configuration space as OMPL sees it; a motion is valid when it is proven."""

    def __init__(self, robot: Robot, prover: EdgeProver, stop: Callable[[], bool]) -> None:
        self.robot, self.prover, self.stop = robot, prover, stop
        self.checked = self.accepted = 0
        self.on_accept: Callable[[int], None] = lambda accepted: None
        self.space = _make_space(robot)
        self.info = ob.SpaceInformation(self.space)
        self.info.setStateValidityChecker(lambda state: True)  # a motion's proof includes its ends
        self._validator = _Validator(self.info, self)
        self.info.setMotionValidator(self._validator)
        self.info.setup()

    def release(self) -> None:
        """Break the cycle through C++ that Python's collector cannot see: OMPL would report leaks at exit."""
        self._validator.motions = None
        del self._validator, self.info, self.space

    def check(self, a: Any, b: Any) -> bool:
        """Whether the motion between two OMPL states is proven free."""
        self.checked += 1
        first = self.read(a)
        delta = self.robot.difference(first, self.read(b))
        # most refused motions end in collision: a look at the end costs a tenth of a proof
        if self.prover.checker.first_contact(first + np.outer(_GLANCES, delta)) is not None:
            return False
        free = bool(self.prover.prove(first[None], delta[None]).free[0])  # numpy.bool_ would end in std::bad_cast
        if free:
            self.accepted += 1
            self.on_accept(self.accepted)
        return free

    def read(self, state: Any) -> Floats:
        """The configuration (dof,) of an OMPL state of this space."""
        if not self.robot.continuous.any():
            return np.array([state[k] for k in range(self.robot.dof)])
        return np.array([state[k].value if wraps else state[k][0] for k, wraps in enumerate(self.robot.continuous)])

    def state(self, q: Floats) -> Any:
        """An OMPL state of this space at configuration ``q`` (dof,)."""
        state = self.info.allocState()
        for k, value in enumerate(q):
            if not self.robot.continuous.any():
                state[k] = float(value)
            elif self.robot.continuous[k]:
                state[k].value = float(value)
            else:
                state[k][0] = float(value)
        return state

    def problem(self, roots: Floats, goal: Any) -> Any:
        """OMPL's problem with every row of ``roots`` as a start."""
        problem = ob.ProblemDefinition(self.info)
        for q in roots:
            problem.addStartState(self.state(q))
        problem.setGoal(goal)
        return problem


class _Validator(ob.MotionValidator):
    def __init__(self, info: Any, motions: _Motions) -> None:
        super().__init__(info)
        self.motions: _Motions | None = motions

    def checkMotion(self, a: Any, b: Any, last_valid: Any = None) -> bool:
        motions = self.motions
        return motions is not None and not motions.stop() and motions.check(a, b)


class _Nowhere(ob.Goal):
    """A goal that is never met: RRT would stop growing as soon as it meets its goal."""

    def isSatisfied(self, *_: Any) -> bool:
        return False


def _make_space(robot: Robot) -> Any:
    if not robot.continuous.any():
        return _real_space(robot.lower, robot.upper)
    space = ob.CompoundStateSpace()
    for k, wraps in enumerate(robot.continuous):
        part = ob.SO2StateSpace() if wraps else _real_space(robot.lower[k : k + 1], robot.upper[k : k + 1])
        space.addSubspace(part, 1.0)
    space.lock()
    return space


def _real_space(lower: Floats, upper: Floats) -> Any:
    space = ob.RealVectorStateSpace(len(lower))
    bounds = ob.RealVectorBounds(len(lower))
    for k, (low, high) in enumerate(zip(lower, upper, strict=True)):
        bounds.setLow(k, float(low))
        bounds.setHigh(k, float(high))
    space.setBounds(bounds)
    return space


def _join(motions: _Motions, starts: Floats, goals: Floats, settings: GrowthSettings) -> Floats | None:
    """A path (k, dof) from a start to a goal, shortcut and cut into steps of the range; None if none was found.

    Tries with middling, long and short steps by turns: a long step leaves a narrow place seldom, a short one crosses
    the open slowly. Tries are long: trees that were cut off early found less than one that went on.
    """
    if not len(starts) or not len(goals):
        return None
    end = motions.checked + settings.join_motions
    for factor in itertools.cycle(_STEPS):
        limit = min(motions.checked + _TRY, end)
        path = _try_to_join(motions, starts, goals, factor * settings.range, limit)
        if path is not None:
            og.PathSimplifier(motions.info).partialShortcutPath(path, settings.shortcuts, settings.shortcuts, 1.0)
            return _subdivided(motions, path, settings.range)
        if motions.checked >= end or motions.stop():
            break
    return None


def _try_to_join(motions: _Motions, starts: Floats, goals: Floats, step: float, limit: int) -> Any | None:
    """One run of RRTConnect until ``limit`` motions have been checked in all: OMPL's path, or None."""
    goal = ob.GoalStates(motions.info)
    for q in goals:
        goal.addState(motions.state(q))
    problem = motions.problem(starts, goal)
    planner = og.RRTConnect(motions.info)
    planner.setRange(step)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(_until(motions, limit))
    return problem.getSolutionPath() if problem.hasExactSolution() else None


def _until(motions: _Motions, limit: int, accepted: int | None = None) -> Any:
    """A termination condition that counts; OMPL's own would look at the clock."""
    return ob.PlannerTerminationCondition(
        lambda: motions.checked >= limit or motions.stop() or (accepted is not None and motions.accepted >= accepted)
    )


def _subdivided(motions: _Motions, path: Any, step: float) -> Floats:
    """The path's states with no two further apart than ``step``: a piece of a proven motion is proven."""
    states = [motions.read(path.getState(k)) for k in range(path.getStateCount())]
    rows = [states[0]]
    for a, b in itertools.pairwise(states):
        delta = motions.robot.difference(a, b)
        pieces = max(1, int(np.ceil(np.linalg.norm(delta) / step)))
        rows += [motions.robot.normalise(a + k / pieces * delta) for k in range(1, pieces)]
        rows.append(b)
    return np.array(rows)


def _grow_tree(
    motions: _Motions,
    forest: _Forest,
    wanted: int,
    settings: GrowthSettings,
    progress: Callable[[int, int], None],
) -> None:
    """RRT from every node there is, until ``wanted`` more are added or too many motions were refused."""
    total = wanted + len(forest)
    before = len(forest)
    motions.accepted = 0
    motions.on_accept = lambda accepted: progress(before + accepted, total)
    planner = og.RRT(motions.info)
    planner.setRange(settings.range)
    planner.setGoalBias(0.0)
    planner.setProblemDefinition(motions.problem(forest.nodes(), _Nowhere(motions.info)))
    planner.setup()
    limit = motions.checked + settings.motions_per_node * wanted
    planner.solve(_until(motions, limit, wanted))
    data = ob.PlannerData(motions.info)
    planner.getPlannerData(data)
    states = [motions.read(data.getVertex(k).getState()) for k in range(data.numVertices())]
    for k, q in enumerate(states):
        forest.add(q)
        for child in data.getEdges(k):
            forest.add_edge(q, states[child])
