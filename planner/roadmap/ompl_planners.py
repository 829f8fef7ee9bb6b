"""OMPL's tree planners over joint values, with our motion check; the only module that imports OMPL."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from struct import Struct
from typing import Any, Self

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from planner.base.arrays import Bools, Floats, Ints, length
from planner.base.captured_output import PROCESS
from planner.base.progress import QUIET, Progress
from planner.constraints.path_constraints import PathConstraints
from planner.kinematics.arm import shorter_way
from planner.roadmap.edges import MotionCheck
from planner.roadmap.forest import Forest
from planner.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class JointSpace:
    """Joint values between ``lower`` and ``upper`` (dof,), rad; the joints that ``wrap`` are angles."""

    lower: Floats
    upper: Floats
    wrap: Bools

    @staticmethod
    def from_robot(robot: Robot) -> JointSpace:
        return JointSpace(robot.lower, robot.upper, robot.continuous)

    def contains(self, q: Floats) -> Bools:
        """Return which configurations of (n, dof) lie within; angles that wrap always do."""
        return np.all(self.wrap | ((self.lower <= q) & (q <= self.upper)), axis=1)

    def difference(self, a: Floats, b: Floats) -> Floats:
        """Return the joint motion from a to b: in the shorter direction where a joint wraps."""
        return shorter_way(b - a, self.wrap)


_ROUNDS = 100  # iterations of a planner per motion that it may check: some iterations check none
_ADVANCE = 0.1  # of a step: a projected step must be at least so long


@dataclass(frozen=True, eq=False)
class Tree:
    """The result of RRT: ``nodes`` (n, dof) and ``edges`` (m, 2), from a node to a later one."""

    nodes: Floats
    edges: Ints


class TreePlanners:
    """OMPL's planners in one space under one motion check; budgets are counts of iterations, not seconds.

        with TreePlanners(space, check, np.random.default_rng(0)) as planners:
            path = planners.rrt_connect(starts, goals, step=0.8, limit=5000)

    ``checked`` counts the motions that were checked, ``accepted`` those that passed. Each planner draws its seed from
    ``rng``, so that the same generator gives the same paths, in any thread. With ``inside`` only motions that end in
    that set are checked: the tree from the goals checks them backwards, from its new states, so it may leave the set
    where the other tree has to return from. Under path constraints trees grow on the allowed states: a state off them
    is projected before its motion is checked (as Berenson et al., 2009; the states of OMPL's own constrained spaces
    cannot be read from Python).
    """

    def __init__(
        self,
        space: JointSpace,
        check: MotionCheck,
        rng: np.random.Generator,
        progress: Progress = QUIET,
        constraints: PathConstraints | None = None,
        inside: Callable[[list[float]], bool] | None = None,
    ) -> None:
        self.checked = self.accepted = 0
        self._constraints, self._inside, self._limit = constraints or None, inside, math.inf
        self.on_accept: Callable[[int], None] = lambda accepted: None
        self._grown: list[bytes] | None = None  # both ends of each accepted motion
        self._space, self._check, self._rng, self._progress = space, check, rng, progress
        self._joints, self._wraps = range(len(space.lower)), space.wrap.tolist() if space.wrap.any() else None
        self._ends, self._both = Struct(f"{2 * len(space.lower)}d"), np.empty((2, len(space.lower)))
        self._buffer = self._both.data
        with self._seed_ompl():  # the setup of a space draws seeds for its projections
            self._ompl_space = _ompl_space(space)
            self._info = ob.SpaceInformation(self._ompl_space)
            self._state_check = _EveryState(self._info)
            self._info.setStateValidityChecker(self._state_check)
            self._validator = _Validator(self._info, self)
            self._info.setMotionValidator(self._validator)
            self._info.setup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Break the cycle through C++ that Python's collector cannot see: OMPL would report leaks at exit."""
        self._validator.planners = None
        del self._validator, self._state_check, self._info, self._ompl_space

    def rrt_connect(self, starts: Floats, goals: Floats, step: float, limit: int) -> Floats | None:
        """Return a path (k, dof) from one of ``starts`` to one of ``goals``, or None after ``limit`` motions.

        RRTConnect (Kuffner and LaValle 2000) with steps of ``step`` (rad).
        """
        goal = ob.GoalStates(self._info)
        for q in goals:
            goal.addState(self._state(q))
        problem = self._problem(starts, goal)
        planner = self._planner(og.RRTConnect, problem, step)
        planner.solve(self._make_termination(self.checked + limit))
        return self._configurations(problem.getSolutionPath()) if problem.hasExactSolution() else None

    def rrt(self, roots: Floats, step: float, count: int, limit: int) -> Tree:
        """Grow from every row of ``roots`` until ``count`` nodes are added or ``limit`` motions are checked.

        The nodes are the roots, then the added ones in order. RRT adds a node wherever it may move to, so the accepted
        motions are the tree: reading it from OMPL takes as long as growing it.
        """
        motions: list[bytes] = []
        self.accepted, self._grown = 0, motions
        planner = self._planner(og.RRT, self._problem(roots, _Nowhere(self._info)), step)
        planner.setGoalBias(0.0)
        planner.solve(self._make_termination(self.checked + limit, count))
        self._grown, grown = None, Forest(roots)
        grown.add_edges(np.frombuffer(b"".join(motions)).reshape(-1, *self._both.shape))
        return Tree(grown.nodes(), grown.edges())

    @contextmanager
    def _seed_ompl(self) -> Iterator[None]:
        """While entered, seed the random numbers of what OMPL makes in this thread from ``rng``.

        Each generator of OMPL draws its seed from the process's generator when it is made.
        """
        seed = int(self._rng.integers(1, 2**31))  # OMPL turns 0 into 1
        with PROCESS:
            ou.noOutputHandler()  # OMPL reports a second seed as an error
            ou.RNG.setSeed(seed)
            yield

    def _planner(self, kind: Any, problem: Any, step: float | None = None) -> Any:
        """Return a planner with a seed of its own, ready to solve ``problem`` in steps of ``step`` (rad)."""
        with self._seed_ompl():
            planner = kind(self._info)
            if step is not None:
                planner.setRange(step)
            planner.setProblemDefinition(problem)
            planner.setup()
            planner.solve(ob.PlannerTerminationCondition(lambda: True))  # a planner makes its sampler when it begins
        return planner

    def _accepts(self, a: Any, b: Any) -> bool:
        """Return whether OMPL may move between two of its states."""
        if self._progress.stopped:
            return False
        self.checked += 1
        end = self._values(b)
        if self._inside is not None and not self._inside(end):
            return False
        (first, second), delta = self._both, self._pack_motion(self._values(a), end)
        if self._constraints is not None:
            if not self._project_motion(first, second, delta, a, b):
                return False
            delta = self._pack_motion(self._values(a), self._values(b))
        free = bool(self._check(first, delta))  # a numpy.bool_ ends in bad_cast
        if free:
            self.accepted += 1
            if self._grown is not None:
                self._grown.append(self._both.tobytes())
            self.on_accept(self.accepted)
        return free

    def _project_motion(self, first: Floats, second: Floats, delta: Floats, a: Any, b: Any) -> bool:
        """Return whether both states satisfy the constraints, after a projection of the one that does not.

        OMPL adds its own state object to the tree, so the projection is written there. OMPL continues towards a state
        while it advances: the step must come nearer to it.
        """
        assert self._constraints is not None
        good = self._constraints.holds(np.stack([first, second]))
        if good.all():
            return True
        known, new, state = (first, first + delta, b) if good[0] else (second, second - delta, a)
        if not good.any() or self.checked >= self._limit:
            return False
        (there,), (success,) = self._constraints.project(new[None])
        step, wanted = there - known, new - known
        nearer = length(step) ** 2 < 2.0 * float(step @ wanted) and length(step) > _ADVANCE * length(wanted)
        if not (success and nearer and self._space.contains(there[None])[0]):
            return False
        self._write(state, shorter_way(there, self._space.wrap))
        return True

    def _pack_motion(self, start: list[float], end: list[float]) -> Floats:
        """Write both ends of a motion into ``_both``, the quickest way into an array; return their difference."""
        self._ends.pack_into(self._buffer, 0, *start, *end)
        first, second = self._both
        return second - first if self._wraps is None else self._space.difference(first, second)

    def _values(self, state: Any) -> list[float]:
        if self._wraps is None:
            return [state[k] for k in self._joints]
        return [state[k].value if wraps else state[k][0] for k, wraps in enumerate(self._wraps)]

    def _state(self, q: Floats) -> Any:
        state = self._info.allocState()
        self._write(state, q)
        return state

    def _write(self, state: Any, q: Floats) -> None:
        for k, value in enumerate(q.tolist()):
            if self._wraps is None:
                state[k] = value
            elif self._wraps[k]:
                state[k].value = value
            else:
                state[k][0] = value

    def _configurations(self, path: Any) -> Floats:
        return np.array([self._values(path.getState(k)) for k in range(path.getStateCount())])

    def _problem(self, roots: Floats, goal: Any) -> Any:
        problem = ob.ProblemDefinition(self._info)
        for q in roots:
            problem.addStartState(self._state(q))
        problem.setGoal(goal)
        return problem

    def _make_termination(self, limit: int, accepted: int | None = None) -> Any:
        """Return a termination condition that counts motions; OMPL's own conditions depend on the clock."""
        rounds, most = itertools.count(), _ROUNDS * (limit - self.checked)
        self._limit = limit
        return ob.PlannerTerminationCondition(
            lambda: (
                self.checked >= limit
                or next(rounds) >= most
                or self._progress.stopped
                or (accepted is not None and self.accepted >= accepted)
            )
        )


class _EveryState(ob.StateValidityChecker):
    """Every state is valid, as the check of a motion includes its ends.

    A class that we keep a reference to: at each garbage collection OMPL 2.0.1 asks for the Python half of a space's
    state checker, and if there is none (a plain function, or unset) it makes one, frees it, and then reads it.
    """

    def isValid(self, state: Any) -> bool:
        return True


class _Validator(ob.MotionValidator):
    def __init__(self, info: Any, planners: TreePlanners) -> None:
        super().__init__(info)
        self.planners: TreePlanners | None = planners

    def checkMotion(self, a: Any, b: Any, last_valid: Any = None) -> bool:
        return self.planners is not None and self.planners._accepts(a, b)


class _Nowhere(ob.Goal):
    """A goal that is never met: RRT would stop growing as soon as it meets its goal."""

    def isSatisfied(self, *_: Any) -> bool:
        return False


def _ompl_space(space: JointSpace) -> Any:
    if not space.wrap.any():
        return _real_space(space.lower, space.upper)
    compound = ob.CompoundStateSpace()
    for k, wraps in enumerate(space.wrap):
        part = ob.SO2StateSpace() if wraps else _real_space(space.lower[k : k + 1], space.upper[k : k + 1])
        compound.addSubspace(part, 1.0)
    compound.lock()
    return compound


def _real_space(lower: Floats, upper: Floats) -> Any:
    space = ob.RealVectorStateSpace(len(lower))
    bounds = ob.RealVectorBounds(len(lower))
    for k, (low, high) in enumerate(zip(lower, upper, strict=True)):
        bounds.setLow(k, float(low))
        bounds.setHigh(k, float(high))
    space.setBounds(bounds)
    return space
