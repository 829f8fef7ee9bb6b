"""The tube around a tool path: the slack of poses in it, and proofs that joint curves stay inside.

A pose is in the tube if some point of the path is within ``position`` of it and its orientation there within ``angle``:
the whole orientation, or the tool's z axis if it may turn. For one line of the path that point is the pose's own
projection u on the line, which is affine in the position; so all conditions are concave in position and rotation, and
:func:`planner.constraints.tool_bound.prove_along` applies.
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

_BEYOND = 0.05  # of the tube's radius: largest distance of the projection beyond an end of the line
_FINEST = 1e-3  # of the tube: pieces that leave their chord by less are not halved again
_SAMPLES = 16  # poses per motion, or piece of one, for the largest deviation
_AT_ONCE = 10_000  # poses per batch, at 10 kB each
_OFF, _LEAN = 0.8, 0.65  # of the tube, for solutions; the rest is for the motions between them
_INSIDE = 1e-12  # of a line: farther from its ends the tolerances of both apply
_ARC = 0.1  # of the tube's radius, for the arcs behind the lines


@dataclass(frozen=True, kw_only=True)
class Deviation(Record):
    """The distance of the tool from its path, or a bound on it."""

    position: float
    """m"""
    angle: float
    """rad, of the orientation, or of the z axis if the tool may turn about it; beyond a given cone"""

    def max_with(self, other: Deviation) -> Deviation:
        """Return the larger position and the larger angle of both."""
        return Deviation(position=max(self.position, other.position), angle=max(self.angle, other.angle))


NO_DEVIATION = Deviation(position=0.0, angle=0.0)


@dataclass(frozen=True, eq=False)
class Tube:
    """The tube around the lines of a ``path``, whose orientation changes little on each.

    With ``all_of_it`` solutions of inverse kinematics may lie anywhere inside, else on the path only.
    """

    path: ToolPath
    all_of_it: bool = False

    def tolerances(self, free: Bools) -> Floats:
        """Return the tolerances (n, 2) m and rad of solutions, for ``free`` (n,) turns or not."""
        if not self.all_of_it:
            return np.full((len(free), 2), (POSITION_TOLERANCE, ANGLE_TOLERANCE))
        size = self.path.tube
        return np.where(free[:, None], (_OFF, _OFF - _LEAN), (_OFF, _OFF)) * (size.position, size.angle)

    @property
    def lean(self) -> float:
        """The largest tilt (rad) of the z axis in targets with free turns."""
        return _LEAN * self.path.tube.angle if self.all_of_it else 0.0

    @cached_property
    def _chord(self) -> Floats:
        """The distances of columns of rotations on each line from their chord."""
        past = self._beyond / self.path.lengths
        return 0.5 * self.path.turn_angles**2 * np.maximum(0.25, past * (1.0 + past)) + past * self.path.turn_angles

    @property
    def _beyond(self) -> float:
        return _BEYOND * self.path.tube.position

    def _project(self, lines: Ints, position: Floats) -> tuple[Floats, Floats]:
        """Return shares of lines (n, a) of the projections of positions (n, 3), and distances (n, a) m."""
        begin, way = self.path.positions[lines], np.diff(self.path.positions, axis=0)[lines]
        u = ((position[:, None] - begin) * way).sum(axis=2) / self.path.lengths[lines] ** 2
        return u, np.linalg.norm(position[:, None] - begin - np.clip(u, 0.0, 1.0)[..., None] * way, axis=2)

    def slack(self, lines: Ints, rotation: Floats, position: Floats) -> Floats:
        """Return the slacks (n, a, 3) of poses at lines (n, a): m, length of a column's change, m along it."""
        path, length = self.path, self.path.lengths[lines]
        u, off = self._project(lines, position)
        away = rotation[:, None] - (path.turns[lines] + u[..., None, None] * np.diff(path.turns, axis=0)[lines])
        free = path.free[lines] | path.free[lines + 1]
        column, whole = np.linalg.norm(away[..., 2], axis=2), np.sqrt((away**2).sum(axis=(2, 3)) / 2.0)
        angle = path.widths[lines] + u * np.diff(path.widths)[lines]
        most = np.where(free, 2.0 * np.sin(np.clip(angle, 0.0, np.pi) / 2.0), 2.0 * np.sin(path.tube.angle / 2.0))
        radius = (1.0 - _ARC) * path.tube.position
        along = np.minimum(u * length, (1.0 - u) * length) + self._beyond
        return np.stack([radius - off, most - self._chord[lines] - np.where(free, column, whole), along], axis=2)

    def prove(self, bound: ToolBound, coefficients: Floats, lines: Ints) -> Bools:
        """Return which curves (m, degree + 1, dof) stay inside, each piece at one of its ``lines`` (m, a)."""
        opens = float(np.max(np.abs(np.diff(self.path.widths)) / self.path.lengths, initial=0.0))
        rate = float((self.path.turn_angles / self.path.lengths).max())  # a column's largest change per metre of a line
        return prove_along(
            bound,
            coefficients,
            lambda curve, s, rotation, position: self.slack(lines[curve], rotation, position),
            np.array([1.0, rate + opens, 1.0]),
            np.array([0.0, 1.0, 0.0]),
            _FINEST * min(self.path.tube.position, self.path.tube.angle),
        )

    def largest_deviation(self, robot: Robot, path: Floats, along: Floats) -> Deviation:
        """Return the tool's largest sampled deviation on a joint path (k, dof) at ``along`` (k,) m.

        It includes the distance of arcs from their lines.
        """
        shares = np.linspace(0.0, 1.0, _SAMPLES, endpoint=False)[:, None, None]
        q = (path[:-1] + shares * np.diff(path, axis=0)).swapaxes(0, 1).reshape(-1, robot.dof)
        places = np.append((along[:-1, None] + shares[:, 0, 0] * np.diff(along)[:, None]).ravel(), along[-1])
        rotation, position = Frame.tool(robot).poses(robot, np.concatenate([q, path[-1:]]))
        return self._largest_deviation(rotation, position, places)

    def deviation_of(self, motion: Trajectory, robot: Robot, along: Floats) -> Deviation:
        """Return the largest deviation of a motion along a joint path at ``along`` (k,) m."""
        begin, end = motion.times[[0, -1]]
        times = np.union1d(motion.times, np.linspace(begin, end, _SAMPLES * len(along)))
        rotation, position = Frame.tool(robot).poses(robot, motion.at(times))
        way, total = cumulative_sums(np.linalg.norm(np.diff(position, axis=0), axis=1)), along[-1] - along[0]
        places = along[0] + way * (total / way[-1] if way[-1] > 0 else 0.0)
        return self._largest_deviation(rotation, position, places, abs(way[-1] - total) + self.path.tube.position)

    def _largest_deviation(self, rotation: Floats, position: Floats, places: Floats, unsure: float = 0.0) -> Deviation:
        """Return the largest deviation of poses at ``places`` (n,) m of the path, known to ``unsure`` m."""
        along, count = self.path.along, len(self.path.lengths)
        first, last = (np.searchsorted(along, places + side * unsure, side="right") for side in (-1, 1))
        largest = np.zeros(2)
        for rows in np.array_split(np.arange(len(places)), 1 + len(places) // _AT_ONCE):
            lines = np.arange(-1, 2 + int((last - first)[rows].max())) + first[rows, None] - 1
            off = self.deviations(np.clip(lines, 0, count - 1), rotation[rows], position[rows])
            largest = np.maximum(largest, np.max(off, axis=1))
        return Deviation(position=float(largest[0]) + self.path.bend, angle=float(largest[1]))

    def deviations(self, lines: Ints, rotation: Floats, position: Floats) -> tuple[Floats, Floats]:
        """Return the deviations (n,) m and rad of poses from one of their lines (n, a), angles beyond a cone.

        It is the line in whose tube they lie deepest: at a bend the nearest line may have another orientation.
        """
        u, off = self._project(lines, position)
        _, turns, free, cones = self.path.at(lines.ravel(), np.clip(u, _INSIDE, 1.0 - _INSIDE).ravel())
        there = np.repeat(rotation, lines.shape[1], axis=0)
        column = 2.0 * np.arcsin(np.clip(np.linalg.norm(there[..., 2] - turns[..., 2], axis=1) / 2.0, 0.0, 1.0))
        angle = np.where(free, np.maximum(column - cones, 0.0), rotation_angles(there, turns)).reshape(lines.shape)
        size, rows = self.path.tube, np.arange(len(lines))
        deepest = np.maximum(off / size.position, angle / size.angle).argmin(axis=1)
        return off[rows, deepest], angle[rows, deepest]
