"""The first path: tree planners on states, then proofs, repair where one fails, proven shortcuts.

A check of a state costs a tenth of a proof, and most motions that planners try are refused, so they search with states
only. Every motion of their path is then proven or replaced by proven ones.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, length
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import EXTRA_CLEARANCE, FINEST_IN_FIRST_PATH, MOTION_IN_FIRST_PATH, W_IN_GROWTH
from planner.cost.motion_cost import MotionCost
from planner.kinematics.manipulability import tools_and_rows
from planner.roadmap.edges import MotionChecker
from planner.roadmap.ompl_planners import JointSpace, TreePlanners
from planner.roadmap.refine import PathRefiner
from planner.roadmap.shortcuts import prove_straight_paths, split_motions
from planner.robot.robot import Robot

_THINNEST = 1e-9  # rad: in a box without any extent OMPL cannot sample
_ROUNDING = 1e-9  # relative: a straight path is as long as its ends are apart


class InformedSet:
    """The states that a path from a start to a goal no longer than ``longest`` (rad) may pass.

    Informed RRT* (Gammell, Srinivasa, Barfoot, 2014) samples it; a tree that must stay inside uses :meth:`contains` and
    samples ``space``, the least box around the set within joint limits.
    """

    def __init__(self, robot: Robot, starts: Floats, goals: Floats, longest: float) -> None:
        """Take ``starts`` (s, dof) and ``goals`` (g, dof); one pair is no farther apart than ``longest``."""
        self._robot, self._starts, self._goals = robot, starts, goals
        self._foci, self._wraps = (starts.tolist(), goals.tolist()), bool(robot.continuous.any())
        self.longest = (1.0 + _ROUNDING) * longest
        self.space = self._box()

    def contains(self, q: list[float]) -> bool:
        """Return whether ``q``, dof numbers, lies in the set."""
        if self._wraps:
            ends, robot = (self._starts, self._goals), self._robot
            near = [np.linalg.norm(robot.difference(rows, np.array(q)), axis=1).min() for rows in ends]
        else:  # called at every step of a tree: a quarter of the time that arrays take
            near = [min([math.dist(q, row) for row in rows]) for rows in self._foci]
        return near[0] + near[1] <= self.longest

    def _box(self) -> JointSpace:
        robot, longest = self._robot, self.longest
        if not math.isfinite(longest):
            return JointSpace.from_robot(robot)
        apart = robot.difference(self._starts[:, None], self._goals[None])
        middle, apart = (self._starts[:, None] + 0.5 * apart).reshape(-1, robot.dof), apart.reshape(-1, robot.dof)
        far = (apart * apart).sum(axis=1, keepdims=True)
        # half the box of an ellipsoid: its half axes, squared and projected on a joint
        along = apart * apart / np.maximum(far, 1e-300)
        half = 0.5 * np.sqrt(along * longest**2 + (1.0 - along) * np.maximum(longest**2 - far, 0.0))
        within = far[:, 0] <= longest**2
        half = half if half[within].max() > _THINNEST else np.full_like(half, _THINNEST)
        lower = np.maximum((middle - half)[within].min(axis=0), robot.lower)
        upper = np.minimum((middle + half)[within].max(axis=0), robot.upper)
        turns = robot.continuous  # these have no bounds
        return JointSpace(np.where(turns, robot.lower, lower), np.where(turns, robot.upper, upper), turns)


# steps in ranges and most motions to check, cyclically
_TRIES = ((1.0, 10_000), (2.0, 10_000), (0.5, 20_000))
_REPAIR_MOTIONS = 300
_REPAIR_BOX = (0.3, 1.0)  # rad beyond the ends of a refused motion: boxes in which a detour is searched
# (rad, motions) of the boxes around a gap: nine of ten gaps are bridged there, by a tenth of the motions
_GAP_BOXES = ((0.3, 500), (0.6, 1000), (1.0, 2000))
_REPORT_EVERY = 500
FIRST_PATH = "first path"  # a stage of progress


@dataclass(frozen=True)
class JoinSettings:
    """The budget of the search for a first path, in counts: so a run can be repeated on any load.

    ``range`` (rad): the path is split into motions no longer than this. ``motions``: the most that RRTConnect may
    check; ``shortcuts``: the number of partial shortcuts to try.
    """

    range: float
    motions: int
    shortcuts: int


class FirstPathSearch:
    """Searches a proven path between sets of configurations; ``checked`` counts the checked motions.

    With ``within`` RRTConnect stays in that set, in which a path may be shorter than the known one.
    """

    def __init__(
        self,
        motions: MotionChecker,
        settings: JoinSettings,
        rng: np.random.Generator,
        progress: Progress = QUIET,
        within: InformedSet | None = None,
    ) -> None:
        self._robot, self._motions, self._settings = motions.robot, motions, settings
        self._rng, self._progress, self._within = rng, progress, within
        self.checked = 0

    def find_straight(self, starts: Floats, goals: Floats) -> list[Floats]:
        """Return the proven straight motions from every row of ``starts`` to every row of ``goals``, split."""
        if not len(starts) or not len(goals):
            return []
        paths, total = list[Floats](), self.checked + len(starts) * len(goals)
        for start in starts:
            self._progress(FIRST_PATH, self.checked, total)
            paths += prove_straight_paths(self._motions, start[None], goals, self._settings.range)
            self.checked += len(goals)
        self._progress(FIRST_PATH, total, total)
        return paths

    def join(self, starts: Floats, goals: Floats) -> Floats | None:
        """Return a path (k, dof) of proven motions from a row of ``starts`` to a row of ``goals``, or None.

        Tries alternate between long and short steps: short ones leave narrow passages.
        """
        if not len(starts) or not len(goals):
            return None
        end, sample = self._settings.motions, MOTION_IN_FIRST_PATH
        space = JointSpace.from_robot(self._robot) if self._within is None else self._within.space
        for factor, most in itertools.cycle(_TRIES):
            left = end - self.checked
            if left <= 0 or self._progress.stopped:
                self._progress(FIRST_PATH, self.checked, self.checked)
                return None
            candidate = self._search(space, starts, goals, factor * self._settings.range, sample, min(most, left))
            if candidate is None:
                continue
            path = self._prove(candidate)
            if path is not None:
                return self._finish(path)
            sample = max(0.5 * sample, FINEST_IN_FIRST_PATH)

    def join_near(self, starts: Floats, goals: Floats, gap: Floats) -> Floats | None:
        """Return a path as :meth:`join`, searched in boxes around a ``gap`` (2, dof) between the two sets.

        Only states within a box count, where motions are short and most states are near the gap.
        """
        robot, middle = self._robot, gap[0] + 0.5 * self._robot.difference(gap[0], gap[1])

        def unwound(q: Floats) -> Floats:
            return np.where(robot.continuous, middle + robot.difference(middle, q), q)

        first, last, ends = unwound(starts), unwound(goals), unwound(gap)
        for beyond, limit in _GAP_BOXES:
            box = self._box(ends[0], ends[1], beyond)
            mine, theirs = box.contains(first), box.contains(last)
            step = self._settings.range
            candidate = self._search(box, first[mine], last[theirs], step, MOTION_IN_FIRST_PATH, limit)
            if candidate is None:
                continue
            a, b = (
                int(np.argmin(np.abs(q - end).max(axis=1))) for q, end in ((first, candidate[0]), (last, candidate[-1]))
            )
            path = self._prove(np.vstack([starts[a], robot.normalise(candidate[1:-1]), goals[b]]))
            if path is not None:
                return self._finish(path)
        return None

    def _finish(self, path: Floats) -> Floats:
        """Return a proven path after shortcuts, split."""
        self._progress(FIRST_PATH, self.checked, self.checked)
        return split_motions(self._motions.prover, self._shorten(path), self._settings.range)

    def _search(
        self, space: JointSpace, starts: Floats, goals: Floats, step: float, sample: float, limit: int
    ) -> Floats | None:
        """Return a path of motions that look free; by OMPL under constraints, as its wrapper projects states."""
        if not self._motions.constraints:
            self._progress(FIRST_PATH, self.checked, self._settings.motions)
            path, checked = self._search_native(space, starts, goals, step, sample, limit)
            self.checked += max(checked, 1)  # counts a try that could not begin, so that the loop ends
            return path

        look, inside = self._motions.make_state_check(sample), self._within and self._within.contains

        def check(first: Floats, delta: Floats) -> bool:
            if planners.checked % _REPORT_EVERY == 0:
                self._progress(FIRST_PATH, self.checked + planners.checked, self._settings.motions)
            return look(first, delta)

        with TreePlanners(space, check, self._rng, self._progress, self._motions.constraints, inside) as planners:
            path = planners.rrt_connect(starts, goals, self._motions.step(step), limit)
        self.checked += max(planners.checked, 1)
        return path

    def _search_native(
        self, space: JointSpace, starts: Floats, goals: Floats, step: float, sample: float, limit: int
    ) -> tuple[Floats | None, int]:
        """Return the path of ``NativeWorld.tree_path`` in ``space``, and the number of checked motions."""
        bound, seed = self._motions.prover.checker.bound, int(self._rng.integers(2**63))
        longest, tool = np.inf if self._within is None else self._within.longest, tools_and_rows(self._robot)
        limits, floor = (space.lower, space.upper), (self._motions.floor, W_IN_GROWTH)
        task = bound.motion_bounds, limits, space.wrap, longest, tool, *floor
        return bound.native.tree_path(*task, starts, goals, step, sample, seed, limit)

    def _prove(self, path: Floats) -> Floats | None:
        """Return the path with every motion proven or replaced by a proven detour; None without one."""
        delta = self._robot.difference(path[:-1], path[1:])
        free = self._motions.prover.free(path[:-1], delta)
        rows = [path[:1]]
        for k, proven in enumerate(free):
            piece = path[k : k + 2] if proven else self._detour(path[k], delta[k])
            if piece is None:
                return None
            rows += [piece[1:-1], path[k + 1 : k + 2]]
        return np.concatenate(rows)

    def _detour(self, first: Floats, delta: Floats) -> Floats | None:
        """Return proven motions (k, dof) from ``first`` by ``delta`` in a box around both ends, unwound."""

        robot, last = self._robot, first + delta
        for beyond in _REPAIR_BOX:
            box = self._box(first, last, beyond)
            with TreePlanners(
                box, self._motions.is_proven, self._rng, self._progress, self._motions.constraints
            ) as planners:
                step = self._motions.step(max(0.5 * length(delta), 0.1))
                path = planners.rrt_connect(first[None], last[None], step, _REPAIR_MOTIONS)
            self.checked += planners.checked
            if path is not None:
                return robot.normalise(path)
        return None

    def _box(self, first: Floats, last: Floats, beyond: float) -> JointSpace:
        """Return the joint values within limits and ``beyond`` (rad) of a box around two; no angle wraps."""
        robot = self._robot
        lower, upper = np.minimum(first, last) - beyond, np.maximum(first, last) + beyond
        lower = np.where(robot.continuous, lower, np.maximum(lower, robot.lower))
        upper = np.where(robot.continuous, upper, np.minimum(upper, robot.upper))
        return JointSpace(lower, upper, np.zeros(robot.dof, dtype=bool))

    def _shorten(self, path: Floats) -> Floats:
        """Return the path without needless states, before and after partial shortcuts."""
        if self._settings.shortcuts < 1:
            return path
        robot, prover, floor, longest = self._robot, self._motions.prover, self._motions.floor, self._settings.range
        motions, cost = MotionChecker(prover, floor, EXTRA_CLEARANCE), MotionCost.from_length(robot)
        tries, seed = self._settings.shortcuts, int(self._rng.integers(2**31))
        refiner = PathRefiner(prover, cost, EXTRA_CLEARANCE, seed, self._progress, tries, floor)
        path = motions.shorten_path(path)
        shorter = robot.normalise(refiner.partial_shortcuts(robot.unwound(path)))
        shorter[[0, -1]] = path[[0, -1]]  # the exact nodes
        return motions.shorten_path(split_motions(prover, shorter, longest))


def find_shorter_path(
    motions: MotionChecker,
    settings: JoinSettings,
    starts: Floats,
    goals: Floats,
    longest: float,
    rng: np.random.Generator,
    progress: Progress,
) -> tuple[Floats | None, int]:
    """Return a path that may be shorter than ``longest`` (rad), or None, and the checked motions.

    :meth:`FirstPathSearch.join` searches it in the informed set, without reports.
    """
    silent, within = progress.with_report(lambda *report: None), InformedSet(motions.robot, starts, goals, longest)
    search = FirstPathSearch(motions, settings, rng, silent, within)
    return search.join(starts, goals), search.checked
