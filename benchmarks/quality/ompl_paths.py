"""Paths by OMPL's planners under our motion check, to be compared with: the benchmark's door to OMPL."""

from __future__ import annotations

import time

from ompl import base as ob
from ompl import geometric as og

from planner.base.arrays import Floats
from planner.sampling.ompl_planners import TreePlanners

PLANNERS = {"RRTConnect": og.RRTConnect, "RRT*": og.RRTstar, "BIT*": og.BITstar}
_OPTIMISING = ("RRT*", "BIT*")


class OmplPaths(TreePlanners):
    """Single queries, each by one of :data:`PLANNERS`.

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
            with self._seeded():
                simplifier = og.PathSimplifier(self._info)
            simplifier.simplifyMax(found)
        return self._configurations(found)
