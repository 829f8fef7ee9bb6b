"""OMPL's planners, to be compared with: the benchmarks' door to OMPL."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError
from planner.roadmap.ompl_planners import TreePlanners
from planner.robot.robot import Robot

PLANNERS = {"RRTConnect": og.RRTConnect, "RRT*": og.RRTstar, "BIT*": og.BITstar}
_OPTIMISING = ("RRT*", "BIT*")
QUERY_SECONDS = 5.0  # a longer query counts as not solved


class OmplPrm:
    """A PRM with OMPL's defaults whose states are checked by ``is_free``; motions as OMPL's default resolution has it.

        prm = OmplPrm(robot, lambda q: is_free(checker, q), seed=0)
        prm.build(1000)
        path = prm.query(start, goal)          # (k, dof), empty where none was found

    Raises :class:`OptionError` for a robot with continuous joints.
    """

    def __init__(self, robot: Robot, is_free: Callable[[Floats], bool], seed: int) -> None:
        self._dof = robot.dof
        self._info, self._state_check = _sampled_space(robot, is_free, seed)
        self._prm = og.PRM(self._info)

    def build(self, nodes: int) -> None:
        """Grow until there are ``nodes`` nodes; OMPL alternates growing and expanding by the clock."""
        self._prm.setProblemDefinition(ob.ProblemDefinition(self._info))
        self._prm.setup()
        self._prm.constructRoadmap(ob.PlannerTerminationCondition(lambda: self._prm.milestoneCount() >= nodes))

    def graph(self) -> tuple[Floats, Ints]:
        """Nodes (n, dof) and edges (m, 2)."""
        data = ob.PlannerData(self._info)
        self._prm.getPlannerData(data)
        nodes = np.array([_read(data.getVertex(k).getState(), self._dof) for k in range(data.numVertices())])
        pairs = [(k, other) for k in range(len(nodes)) for other in data.getEdges(k)]
        return nodes, np.unique(np.sort(np.array(pairs, dtype=np.int64).reshape(-1, 2), axis=1), axis=0)

    def query(self, start: Floats, goal: Floats) -> Floats:
        """A path from ``start`` to ``goal`` on the kept roadmap, which grows where they are not joined."""
        problem = ob.ProblemDefinition(self._info)
        problem.setStartAndGoalStates(_state_of(self._info, start), _state_of(self._info, goal))
        self._prm.clearQuery()
        self._prm.setProblemDefinition(problem)
        # solve asks its condition from a second thread, where a Python callable would wait for ever: OMPL's own clock
        self._prm.solve(ob.timedPlannerTerminationCondition(QUERY_SECONDS))
        if not problem.hasExactSolution():
            return np.zeros((0, self._dof))
        return _configurations(problem.getSolutionPath(), self._dof)


class OmplConnect:
    """RRTConnect with OMPL's defaults; states are checked by ``is_free``, motions at OMPL's default resolution.

        connect = OmplConnect(robot, is_free, seed=0)
        connect.solve(start, goal, seconds=10.0)      # whether there is a path
        path = connect.simplify()                   # (k, dof)

    Raises :class:`OptionError` for a robot with continuous joints.
    """

    def __init__(self, robot: Robot, is_free: Callable[[Floats], bool], seed: int) -> None:
        self._dof = robot.dof
        self._info, self._state_check = _sampled_space(robot, is_free, seed)
        self._problem = ob.ProblemDefinition(self._info)

    def solve(self, start: Floats, goal: Floats, seconds: float) -> bool:
        """Search a path for at most ``seconds`` of the wall clock."""
        self._problem.setStartAndGoalStates(_state_of(self._info, start), _state_of(self._info, goal))
        planner = og.RRTConnect(self._info)
        planner.setProblemDefinition(self._problem)
        planner.setup()
        end = time.perf_counter() + seconds
        planner.solve(ob.PlannerTerminationCondition(lambda: time.perf_counter() >= end))
        return self._problem.hasExactSolution()

    def simplify(self) -> Floats:
        """The path (k, dof) that was found, simplified as far as OMPL does by default."""
        path = self._problem.getSolutionPath()
        og.PathSimplifier(self._info).simplifyMax(path)
        return _configurations(path, self._dof)


class OmplPaths(TreePlanners):
    """Single queries under our motion check, each by one of :data:`PLANNERS`.

    with OmplPaths(space, check) as planners:
        path = planners.path("RRT*", starts, goals, seconds=5.0)
    """

    def path(self, name: str, starts: Floats, goals: Floats, seconds: float) -> Floats | None:
        """A path (k, dof) after so much processor time; RRTConnect's ends when it is found, and is then simplified."""
        goal = ob.GoalStates(self._info)
        for q in goals:
            goal.addState(self._state(q))
        problem = self._problem(starts, goal)
        if name in _OPTIMISING:
            problem.setOptimizationObjective(ob.PathLengthOptimizationObjective(self._info))
        planner = self._planner(PLANNERS[name], problem)
        end = time.process_time() + seconds
        stopped = self._progress
        planner.solve(ob.PlannerTerminationCondition(lambda: time.process_time() >= end or stopped.stopped))
        if not problem.hasExactSolution():
            return None
        found = problem.getSolutionPath()
        if name not in _OPTIMISING:
            with self._seed_ompl():
                simplifier = og.PathSimplifier(self._info)
            simplifier.simplifyMax(found)
        return self._configurations(found)


def _sampled_space(
    robot: Robot, is_free: Callable[[Floats], bool], seed: int
) -> tuple[ob.SpaceInformation, ob.StateValidityChecker]:
    """The joint space of ``robot``, its states checked by ``is_free``, motions at OMPL's default resolution.

    The second has to be kept as long as the first. Raises :class:`OptionError` for a robot with continuous joints.
    """
    if robot.continuous.any():
        raise OptionError(f"{robot.name} has continuous joints, which this comparison leaves out.")
    ou.noOutputHandler()
    ou.RNG.setSeed(seed + 1)
    space = ob.RealVectorStateSpace(robot.dof)
    bounds = ob.RealVectorBounds(robot.dof)
    for k in range(robot.dof):
        bounds.setLow(k, float(robot.lower[k]))
        bounds.setHigh(k, float(robot.upper[k]))
    space.setBounds(bounds)
    info = ob.SpaceInformation(space)
    check = _StateCheck(info, is_free, robot.dof)
    info.setStateValidityChecker(check)
    info.setup()
    return info, check


def _state_of(info: ob.SpaceInformation, q: Floats) -> ob.State:
    """A configuration (dof,) as OMPL's state."""
    state = info.allocState()
    for k, value in enumerate(q):
        state[k] = float(value)
    return state


def _configurations(path: og.PathGeometric, dof: int) -> Floats:
    """The states of OMPL's path (k, dof)."""
    return np.array([_read(path.getState(k), dof) for k in range(path.getStateCount())])


class _StateCheck(ob.StateValidityChecker):
    """A class of Python's, and kept, for the reason that :mod:`planner.roadmap.ompl_planners` gives."""

    def __init__(self, info: ob.SpaceInformation, is_free: Callable[[Floats], bool], dof: int) -> None:
        super().__init__(info)
        self._is_free, self._dof = is_free, dof

    def isValid(self, state: ob.State) -> bool:
        return bool(self._is_free(_read(state, self._dof)))


def _read(state: ob.State, dof: int) -> Floats:
    return np.array([state[k] for k in range(dof)])
