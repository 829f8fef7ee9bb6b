"""How a tool path is followed: what plan.json and a page hold of it, and its motion in time.

The trajectory itself is proven inside the tube, and the tool goes no faster than it may.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planner.base.arrays import Bools, Floats, cumulative_sums, ranges
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.constraints.tool_bound import Frame, ToolBound
from planner.problem.options import TimeLaw
from planner.problem.outcome import Record, Rows
from planner.robot.robot import Robot
from planner.tool_paths.tool_path import TubeSize
from planner.tool_paths.tube import Deviation, Tube
from planner.trajectory.limits import MotionLimits
from planner.trajectory.proof import prove_motion
from planner.trajectory.timing import time_curve
from planner.trajectory.trajectory import Trajectory

_BESIDE = 2  # lines before and behind that a piece of a motion may be beside
_LOOKS = 8  # at the tool's speed between two waypoints
_FAST = 100.0  # m/s, where no speed is asked for
_SAMPLE = 1e-4  # s between the moments at which the tool's speed is looked at, at least 20 on every piece
_PACED, _BELOW = 3, 0.9995  # times that a motion is slowed down where it is too fast, a little more than needed
_PLATEAU = 0.2  # of the way at one speed
_WITHIN = 0.01  # of the speed that is asked for


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolSpeedRecord(Record):
    """How fast the tool goes along the path."""

    asked: float
    """m/s"""
    largest: float
    """m/s, of the tool along it"""
    share: float
    """of the path's length that it runs at the asked speed, within 1 %"""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPathRecord(Record):
    """How a tool path is followed; deviations are sampled, what is proven holds between samples."""

    followed: float
    """share of its length"""
    points: int
    """in its file"""
    largest_deviation: Deviation
    """of the path, and of the motion where there is one, which rounds the path's corners"""
    tube: TubeSize
    proven: bool
    """what is followed stays in the tube throughout, as does the motion where there is one"""
    first_unreachable: int | None
    """a point of its file, from 1"""
    speed: ToolSpeedRecord | None = None

    def rows(self, what: str) -> Rows:
        """How much is followed, how far ``what`` ("path", "path and motion") is off, and how fast the tool goes."""
        off, tube, speed = self.largest_deviation, self.tube, self.speed
        stops = "" if self.first_unreachable is None else f", not to point {self.first_unreachable}"
        text = f"{100 * self.followed:.1f} % of {self.points} points followed{stops}"
        if self.followed > 0:
            proof = "proven within" if self.proven else "NOT proven within"
            text += (
                f"; {what} at most {1e3 * off.position:.3g} mm and {off.angle:.2g} rad off where sampled, "
                f"{proof} {1e3 * tube.position:g} mm and {tube.angle:g} rad"
            )
        rows = [("tool path", text)]
        if speed is not None:
            share = f"{100 * speed.share:.1f} % of it at the {speed.asked:g} m/s asked for"
            rows.append(("tool speed", f"{share}, nowhere above {speed.largest:.6g} m/s"))
        return rows


@dataclass(frozen=True, kw_only=True, eq=False)
class LegRecord(Record):
    """A straight line of the tool at an end of a path, proven to stay in its tube; deviations are sampled."""

    leg: str
    """retreat or approach"""
    length: float
    """m"""
    largest_deviation: Deviation
    """of the path, and of the motion where there is one, which rounds the path's corners"""
    tube: TubeSize

    def text(self, what: str) -> str:
        """The line, and how far ``what`` ("path", "path and motion") is off it."""
        off, tube = self.largest_deviation, self.tube
        return (
            f"{self.length:.3g} m straight along the tool's z axis; {what} at most {1e3 * off.position:.3g} mm "
            f"off where sampled, proven within {1e3 * tube.position:g} mm and {tube.angle:g} rad"
        )


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """A tool path that was to be followed: its record, and what a page draws of it.

    Points (k, 3) m ``wanted``; ``rungs`` (m, dof): the solutions of inverse kinematics that were to choose from.
    """

    record: ToolPathRecord
    wanted: Floats
    rungs: Floats


def leg_line(robot: Robot, q: Floats, length: float) -> Floats:
    """(2, 3) m from where the tool is at ``q`` (dof,) to ``length`` m back along its z axis."""
    rotation, position = Frame.tool(robot).poses(robot, q[None])
    return position - np.array([[0.0], [length]]) * rotation[0, :, 2]


@dataclass(frozen=True, eq=False)
class ToolGuide:
    """The tube as a motion keeps to it, and the speed ``fastest`` (m/s) of the tool along the path.

    ``places`` (k,) m: where the waypoints of the joint path are on the tool path. ``along`` (k,) grows as the tool goes
    where that is fastest between two waypoints, so that it nowhere exceeds the speed.
    """

    robot: Robot
    tube: Tube
    places: Floats
    along: Floats
    fastest: float = _FAST

    @staticmethod
    def of(path: Floats, places: Floats, robot: Robot, tube: Tube, speed: float | None) -> ToolGuide:
        """The guide of a joint path (k, dof)."""
        shares = np.linspace(0.0, 1.0, _LOOKS + 1)[:, None, None]
        q = path[:-1] + shares * np.diff(path, axis=0)
        position = Frame.tool(robot).poses(robot, q.reshape(-1, robot.dof))[1].reshape(*q.shape[:2], 3)
        fastest = _LOOKS * np.linalg.norm(np.diff(position, axis=0), axis=2).max(axis=0)
        return ToolGuide(robot, tube, places, cumulative_sums(np.maximum(fastest, np.diff(places))), speed or _FAST)

    def paced(self, way: Floats, excess: Floats) -> ToolGuide:
        """The same, slower by ``excess`` (n,) where that is above 1, of stretches of the tool's ``way`` (n,) m."""
        total = cumulative_sums(np.diff(self.places))
        here = np.cumsum(way) / way.sum() * total[-1]
        step = np.clip(np.searchsorted(total, here) - 1, 0, len(total) - 2)
        slower = np.ones(len(total) + 1)
        for beside in (0, 1, 2):  # a motion is smoothed over its neighbours
            np.maximum.at(slower, step + beside, excess / _BELOW)
        slower = np.where(slower > 1.0 / _BELOW, slower, 1.0)
        return replace(self, along=cumulative_sums(np.diff(self.along) * slower[1:-1]))

    @cached_property
    def _bound(self) -> ToolBound:
        return ToolBound(self.robot)

    def holds(self, coefficients: Floats, begin: Floats, end: Floats) -> Bools:
        """Which curves (m, degree + 1, dof) between places (m,) m along the path are proven to stay in the tube."""
        begin, end = (np.interp(place, self.along, self.places) for place in (begin, end))
        places, count = self.tube.path.along, len(self.tube.path.lengths)
        first = np.searchsorted(places, begin, side="right") - 1 - _BESIDE
        beside = 2 * _BESIDE + 1 + int((np.searchsorted(places, end) - np.searchsorted(places, begin)).max(initial=0))
        lines = np.clip(first[:, None] + np.arange(beside), 0, count - 1)
        return self.tube.prove(self._bound, coefficients, lines)


def time_tool_path(
    path: Floats,
    along: Floats,
    tube: Tube,
    checker: CollisionChecker,
    limits: MotionLimits,
    speed: float | None = None,
    floor: float = 0.0,
    time_law: TimeLaw = "blended",
) -> tuple[Trajectory, ToolSpeedRecord | None]:
    """The motion along a joint path (k, dof) that is ``along`` (k,) m on a tool path, and the tool's speed if asked.

    From rest to rest. Corners are rounded as far as the motion is proven to stay in the tube and free, and ``proven``
    says that all of it does; no shortcuts are taken under any ``time_law``.
    """
    guide = ToolGuide.of(path, along, checker.robot, tube, speed)

    def timed(guide: ToolGuide) -> Trajectory:
        return time_curve(path, checker, limits, time_law, floor, guide=guide)[0]

    def throughout(fast: Floats) -> ToolGuide:
        return replace(guide, fastest=guide.fastest * (speed or 0.0) / fast.max() * _BELOW)

    made = timed(guide)
    if speed is None:
        return made, None
    way, fast = _tool_speeds(made, checker.robot)
    if _share(way, fast, fast.max()) > _PLATEAU and fast.max() < speed * _BELOW:  # all is slowed down for a limit
        guide = throughout(fast)
        way, fast = _tool_speeds(made := timed(guide), checker.robot)
    for look in range(_PACED + 1):
        if fast.max() <= speed:
            break
        # slower where it is too fast; if that does not help, throughout
        guide = guide.paced(way, fast / speed) if look < _PACED else throughout(fast)
        way, fast = _tool_speeds(made := timed(guide), checker.robot)
    return made, ToolSpeedRecord(asked=speed, largest=float(fast.max()), share=_share(way, fast, speed))


def _share(way: Floats, fast: Floats, speed: float) -> float:
    """Of a way (n,) m, gone along at ``fast`` (n,) m/s, what is gone at a ``speed``, within 1 %."""
    return float(way[np.abs(fast / speed - 1.0) <= _WITHIN].sum() / way.sum())


def _tool_speeds(trajectory: Trajectory, robot: Robot) -> tuple[Floats, Floats]:
    """The ways (n,) m of the tool between samples of a motion, and how fast (n,) m/s it goes on each."""
    seconds = np.diff(trajectory.times)
    counts = np.maximum(np.ceil(seconds / _SAMPLE), 20).astype(np.int64).clip(max=200)
    shares = ranges(np.zeros(len(counts), dtype=np.int64), counts) / np.repeat(counts, counts)
    times = np.append(
        np.repeat(trajectory.times[:-1], counts) + shares * np.repeat(seconds, counts), trajectory.times[-1]
    )
    position = Frame.tool(robot).poses(robot, trajectory.at(times))[1]
    way = np.linalg.norm(np.diff(position, axis=0), axis=1)
    return way, way / np.diff(times)


def join_trajectories(
    first: Trajectory, second: Trajectory, checker: CollisionChecker, limits: MotionLimits, floor: float
) -> Trajectory:
    """One motion after another, from rest to rest each, proven as one; proven where both are."""
    shift = first.nanoseconds[-1] - second.nanoseconds[0]
    clock = np.concatenate([first.nanoseconds, second.nanoseconds[1:] + shift])
    columns = tuple(np.concatenate([a, b[1:]]) for a, b in zip(first.columns, second.columns, strict=True))
    made = Trajectory(first.joints, clock, columns, first.time_law, limits)
    proof = prove_motion(made, EdgeProver(checker), limits, floor)
    record = proof.to_dict(checker.world.margin, checker.name)
    for key in ("corners", "corners_blended", "shortcuts", "pieces_inside"):
        record[key] = first.proof.get(key, 0) + second.proof.get(key, 0)
    return replace(made, proven=proof.whole and first.proven and second.proven, proof=record)
