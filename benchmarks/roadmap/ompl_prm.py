"""OMPL's PRM with a Python callback, to be compared with: the benchmark's door to OMPL."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError
from planner.models.robot import Robot

QUERY_SECONDS = 5.0  # a query that is not answered by then counts as not solved


class OmplPrm:
    """A PRM with OMPL's defaults whose states are checked by ``is_free``; motions as OMPL's default resolution has it.

        prm = OmplPrm(robot, lambda q: is_free(checker, q), seed=0)
        prm.build(1000)
        path = prm.query(start, goal)          # (k, dof), empty where none was found

    Raises :class:`OptionError` for a robot with continuous joints.
    """

    def __init__(self, robot: Robot, is_free: Callable[[Floats], bool], seed: int) -> None:
        self._dof = robot.dof
        self._info, self._state_check = sampled_space(robot, is_free, seed)
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
        problem.setStartAndGoalStates(self._state(start), self._state(goal))
        self._prm.clearQuery()
        self._prm.setProblemDefinition(problem)
        # solve asks its condition from a second thread, where a Python callable would wait for ever: OMPL's own clock
        self._prm.solve(ob.timedPlannerTerminationCondition(QUERY_SECONDS))
        if not problem.hasExactSolution():
            return np.zeros((0, self._dof))
        return configurations(problem.getSolutionPath(), self._dof)

    def _state(self, q: Floats) -> ob.State:
        return state_of(self._info, q)


def sampled_space(
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


def state_of(info: ob.SpaceInformation, q: Floats) -> ob.State:
    """A configuration (dof,) as OMPL's state."""
    state = info.allocState()
    for k, value in enumerate(q):
        state[k] = float(value)
    return state


def configurations(path: og.PathGeometric, dof: int) -> Floats:
    """The states of OMPL's path (k, dof)."""
    return np.array([_read(path.getState(k), dof) for k in range(path.getStateCount())])


class _StateCheck(ob.StateValidityChecker):
    """A class of Python's, and kept, for the reason that :mod:`planner.sampling.ompl_planners` gives."""

    def __init__(self, info: ob.SpaceInformation, is_free: Callable[[Floats], bool], dof: int) -> None:
        super().__init__(info)
        self._is_free, self._dof = is_free, dof

    def isValid(self, state: ob.State) -> bool:
        return bool(self._is_free(_read(state, self._dof)))


def _read(state: ob.State, dof: int) -> Floats:
    return np.array([state[k] for k in range(dof)])
