"""OMPL's RRTConnect and simplification with a Python callback, to be compared with: the benchmark's door to OMPL."""

from __future__ import annotations

import time
from collections.abc import Callable

from ompl import base as ob
from ompl import geometric as og

from benchmarks.roadmap.ompl_prm import configurations, sampled_space, state_of
from planner.base.arrays import Floats
from planner.models.robot import Robot


class OmplConnect:
    """RRTConnect with OMPL's defaults; states are checked by ``is_free``, motions at OMPL's default resolution.

        connect = OmplConnect(robot, is_free, seed=0)
        connect.solve(start, goal, seconds=10.0)      # whether there is a path
        path = connect.simplified()                   # (k, dof)

    Raises :class:`OptionError` for a robot with continuous joints.
    """

    def __init__(self, robot: Robot, is_free: Callable[[Floats], bool], seed: int) -> None:
        self._dof = robot.dof
        self._info, self._state_check = sampled_space(robot, is_free, seed)
        self._problem = ob.ProblemDefinition(self._info)

    def solve(self, start: Floats, goal: Floats, seconds: float) -> bool:
        """Search a path for at most ``seconds`` of the wall clock."""
        self._problem.setStartAndGoalStates(state_of(self._info, start), state_of(self._info, goal))
        planner = og.RRTConnect(self._info)
        planner.setProblemDefinition(self._problem)
        planner.setup()
        end = time.perf_counter() + seconds
        planner.solve(ob.PlannerTerminationCondition(lambda: time.perf_counter() >= end))
        return self._problem.hasExactSolution()

    def simplified(self) -> Floats:
        """The path (k, dof) that was found, simplified as far as OMPL does by default."""
        path = self._problem.getSolutionPath()
        og.PathSimplifier(self._info).simplifyMax(path)
        return configurations(path, self._dof)
