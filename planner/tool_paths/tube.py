"""The tube around a tool path: what a pose has to spare in it, and proofs that whole joint curves stay inside.

A pose is in the tube where some point of the path is within ``position`` of it and its orientation there within
``angle``: of the whole orientation, or of the tool's z axis where it may turn. Beside one line of the path that point
is the pose's own projection u on the line, which is affine in the position; so all conditions are concave in position
and rotation, and :func:`planner.constraints.tool_bound.prove_along` applies.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, cumulative_sums
from planner.constraints.tool_bound import Frame, ToolBound, prove_along
from planner.kinematics.inverse import ANGLE_TOLERANCE, POSITION_TOLERANCE
from planner.problem.outcome import Record
from planner.robot.robot import Robot
from planner.tool_paths.tool_path import ToolPath, rotation_angles
from planner.trajectory.trajectory import Trajectory

_BEYOND = 0.05  # of the tube's radius: so far may the projection lie beyond an end of the line
_FINEST = 1e-3  # of the tube: pieces that leave their chord by less are not halved again
_SAMPLES = 16  # poses looked at on each motion, or piece of one, for the largest deviation that is told
_AT_ONCE = 10_000  # poses whose deviations are measured together, which takes 10 kB for each
_OFF, _LEAN = 0.8, 0.65  # of the tube, for solutions inside: what is left has to do for the motions between
_INSIDE = 1e-12  # of a line: farther from its ends it allows what both allow together
_ARC = 0.1  # of the tube's radius is left to the arcs that lines stand for


@dataclass(frozen=True, kw_only=True)
class Deviation(Record):
    """How far the tool is off its path, or may be."""

    position: float
    """m"""
    angle: float
    """rad, of its orientation, or of its z axis where it may turn about that; beyond a cone where one is given"""

    def or_more(self, other: Deviation) -> Deviation:
        """The larger of both, each by itself."""
        return Deviation(position=max(self.position, other.position), angle=max(self.angle, other.angle))


NO_DEVIATION = Deviation(position=0.0, angle=0.0)


@dataclass(frozen=True, eq=False)
class Tube:
    """The tube around the lines of a ``path``, whose orientation changes little on each.

    ``all_of_it``: solutions of inverse kinematics may lie anywhere inside, and not on the path alone.
    """

    path: ToolPath
    all_of_it: bool = False

    def taken(self, free: Bools) -> Floats:
        """How far (n, 2) m and rad solutions may be off what is asked for, where the tool is ``free`` (n,) or not."""
        if not self.all_of_it:
            return np.full((len(free), 2), (POSITION_TOLERANCE, ANGLE_TOLERANCE))
        size = self.path.tube
        return np.where(free[:, None], (_OFF, _OFF - _LEAN), (_OFF, _OFF)) * (size.position, size.angle)

    @property
    def lean(self) -> float:
        """How far (rad) the z axis leans at most in what is asked for, where the tool may turn about it."""
        return _LEAN * self.path.tube.angle if self.all_of_it else 0.0

    @cached_property
    def _chord(self) -> Floats:
        """By what columns of rotations on a line are off their chord."""
        past = self._beyond / self.path.lengths
        return 0.5 * self.path.turned**2 * np.maximum(0.25, past * (1.0 + past)) + past * self.path.turned

    @property
    def _beyond(self) -> float:
        return _BEYOND * self.path.tube.position

    def _beside(self, lines: Ints, position: Floats) -> tuple[Floats, Floats]:
        """The shares of lines (n, a) at which positions (n, 3) lie beside them, and how far (n, a) m they are off."""
        begin, way = self.path.positions[lines], np.diff(self.path.positions, axis=0)[lines]
        u = ((position[:, None] - begin) * way).sum(axis=2) / self.path.lengths[lines] ** 2
        return u, np.linalg.norm(position[:, None] - begin - np.clip(u, 0.0, 1.0)[..., None] * way, axis=2)

    def spare(self, lines: Ints, rotation: Floats, position: Floats) -> Floats:
        """(n, a, 3) what poses have to spare beside lines (n, a): m, the length of a column's change, m along it."""
        path, length = self.path, self.path.lengths[lines]
        u, off = self._beside(lines, position)
        away = rotation[:, None] - (path.turns[lines] + u[..., None, None] * np.diff(path.turns, axis=0)[lines])
        free = path.free[lines] | path.free[lines + 1]
        column, whole = np.linalg.norm(away[..., 2], axis=2), np.sqrt((away**2).sum(axis=(2, 3)) / 2.0)
        angle = path.widths[lines] + u * np.diff(path.widths)[lines]
        most = np.where(free, 2.0 * np.sin(np.clip(angle, 0.0, np.pi) / 2.0), 2.0 * np.sin(path.tube.angle / 2.0))
        room = (1.0 - _ARC) * path.tube.position
        along = np.minimum(u * length, (1.0 - u) * length) + self._beyond
        return np.stack([room - off, most - self._chord[lines] - np.where(free, column, whole), along], axis=2)

    def prove(self, bound: ToolBound, coefficients: Floats, lines: Ints) -> Bools:
        """Which curves (m, degree + 1, dof) stay inside, (m,), each piece beside one of its ``lines`` (m, a)."""
        opens = float(np.max(np.abs(np.diff(self.path.widths)) / self.path.lengths, initial=0.0))
        rate = float(
            (self.path.turned / self.path.lengths).max()
        )  # the most that a column changes per metre along a line
        return prove_along(
            bound,
            coefficients,
            lambda curve, s, rotation, position: self.spare(lines[curve], rotation, position),
            np.array([1.0, rate + opens, 1.0]),
            np.array([0.0, 1.0, 0.0]),
            _FINEST * min(self.path.tube.position, self.path.tube.angle),
        )

    def largest_deviation(self, robot: Robot, path: Floats, along: Floats) -> Deviation:
        """How far the tool is off at most, sampled, on a joint path (k, dof) that is ``along`` (k,) m here.

        Off arcs by so much more as these may be off the lines for them.
        """
        shares = np.linspace(0.0, 1.0, _SAMPLES, endpoint=False)[:, None, None]
        q = (path[:-1] + shares * np.diff(path, axis=0)).swapaxes(0, 1).reshape(-1, robot.dof)
        places = np.append((along[:-1, None] + shares[:, 0, 0] * np.diff(along)[:, None]).ravel(), along[-1])
        rotation, position = Frame.tool(robot).poses(robot, np.concatenate([q, path[-1:]]))
        return self._off(rotation, position, places)

    def deviation_of(self, motion: Trajectory, robot: Robot, along: Floats) -> Deviation:
        """The same of a motion along a joint path that is ``along`` (k,) m here: corners are rounded."""
        begin, end = motion.times[[0, -1]]
        times = np.union1d(motion.times, np.linspace(begin, end, _SAMPLES * len(along)))
        rotation, position = Frame.tool(robot).poses(robot, motion.at(times))
        way, total = cumulative_sums(np.linalg.norm(np.diff(position, axis=0), axis=1)), along[-1] - along[0]
        places = along[0] + way * (total / way[-1] if way[-1] > 0 else 0.0)
        return self._off(rotation, position, places, abs(way[-1] - total) + self.path.tube.position)

    def _off(self, rotation: Floats, position: Floats, places: Floats, unsure: float = 0.0) -> Deviation:
        """How far poses are off at most at ``places`` (n,) m that are known to ``unsure`` m."""
        along, count = self.path.along, len(self.path.lengths)
        first, last = (np.searchsorted(along, places + side * unsure, side="right") for side in (-1, 1))
        largest = np.zeros(2)
        for rows in np.array_split(np.arange(len(places)), 1 + len(places) // _AT_ONCE):
            beside = np.arange(-1, 2 + int((last - first)[rows].max())) + first[rows, None] - 1
            off = self.deviations(np.clip(beside, 0, count - 1), rotation[rows], position[rows])
            largest = np.maximum(largest, np.max(off, axis=1))
        return Deviation(position=float(largest[0]) + self.path.bend, angle=float(largest[1]))

    def deviations(self, lines: Ints, rotation: Floats, position: Floats) -> tuple[Floats, Floats]:
        """How far (n,) m and rad poses are off one of their lines (n, a), the angle beyond a cone's.

        It is the line in whose tube they lie deepest: beside a bend the nearest one may turn otherwise.
        """
        u, off = self._beside(lines, position)
        _, turns, free, cones = self.path.at(lines.ravel(), np.clip(u, _INSIDE, 1.0 - _INSIDE).ravel())
        there = np.repeat(rotation, lines.shape[1], axis=0)
        column = 2.0 * np.arcsin(np.clip(np.linalg.norm(there[..., 2] - turns[..., 2], axis=1) / 2.0, 0.0, 1.0))
        angle = np.where(free, np.maximum(column - cones, 0.0), rotation_angles(there, turns)).reshape(lines.shape)
        size, rows = self.path.tube, np.arange(len(lines))
        deepest = np.maximum(off / size.position, angle / size.angle).argmin(axis=1)
        return off[rows, deepest], angle[rows, deepest]
