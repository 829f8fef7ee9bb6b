"""The motion along a tool path: inside the tube, at a bounded tool speed; and the records of it."""

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

_NEIGHBOURS = 2  # lines before and after that a piece of a motion may follow
_SAMPLES = 8  # of the tool's speed between two waypoints
_FAST = 100.0  # m/s: without a requested speed
_SAMPLE = 1e-4  # s between samples of the tool's speed, at least 20 per piece
_ROUNDS, _BELOW = 3, 0.9995  # local slow-downs of a motion, each slightly more than needed
_PLATEAU = 0.2  # of the tool's path at one speed
_WITHIN = 0.01  # of the requested speed


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolSpeedRecord(Record):
    """The speed of the tool along the path."""

    asked: float
    """m/s"""
    largest: float
    """m/s, of the tool along it"""
    share: float
    """of the path's length at the requested speed, within 1 %"""


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPathRecord(Record):
    """The result of following a tool path; deviations are sampled, proofs hold between samples."""

    followed: float
    """share of its length"""
    points: int
    """in its file"""
    largest_deviation: Deviation
    """of the path and, if there is one, of the motion, which rounds the path's corners"""
    tube: TubeSize
    proven: bool
    """path and motion stay in the tube throughout"""
    first_unreachable: int | None
    """a point of its file, from 1"""
    speed: ToolSpeedRecord | None = None

    def rows(self, what: str) -> Rows:
        """Return rows on progress, on the deviation of ``what`` ("path", "path and motion"), and on speed."""
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
            share = f"{100 * speed.share:.1f} % of the path at {speed.asked:g} m/s"
            rows.append(("tool speed", f"{share}, at most {speed.largest:.6g} m/s"))
        return rows


@dataclass(frozen=True, kw_only=True, eq=False)
class LegRecord(Record):
    """A straight line of the tool at an end of a path, proven to stay in its tube; deviations are sampled."""

    leg: str
    """retreat or approach"""
    length: float
    """m"""
    largest_deviation: Deviation
    """of the path and, if there is one, of the motion, which rounds the path's corners"""
    tube: TubeSize

    def text(self, what: str) -> str:
        """Return the line, and the deviation of ``what`` ("path", "path and motion") from it."""
        off, tube = self.largest_deviation, self.tube
        return (
            f"{self.length:.3g} m straight along the tool's z axis; {what} at most {1e3 * off.position:.3g} mm "
            f"off where sampled, proven within {1e3 * tube.position:g} mm and {tube.angle:g} rad"
        )


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """A tool path to follow: its record, and the data for its picture.

    ``points`` (k, 3) m of the path; ``rungs`` (m, dof) are solutions of inverse kinematics along it.
    """

    record: ToolPathRecord
    points: Floats
    rungs: Floats


def leg_line(robot: Robot, q: Floats, length: float) -> Floats:
    """Return (2, 3) m: the tool's position at ``q`` (dof,), and ``length`` m back along its z axis."""
    rotation, position = Frame.tool(robot).poses(robot, q[None])
    return position - np.array([[0.0], [length]]) * rotation[0, :, 2]


@dataclass(frozen=True, eq=False)
class ToolGuide:
    """The guide of a motion along a tool path: its tube, and the tool's speed limit ``fastest`` (m/s).

    ``places`` (k,) m are the waypoints of the joint path on the tool path. ``along`` (k,) grows with the tool's largest
    speed between two waypoints, so that the tool nowhere exceeds the speed.
    """

    robot: Robot
    tube: Tube
    places: Floats
    along: Floats
    fastest: float = _FAST

    @staticmethod
    def from_path(path: Floats, places: Floats, robot: Robot, tube: Tube, speed: float | None) -> ToolGuide:
        """Return the guide of a joint path (k, dof)."""
        shares = np.linspace(0.0, 1.0, _SAMPLES + 1)[:, None, None]
        q = path[:-1] + shares * np.diff(path, axis=0)
        position = Frame.tool(robot).poses(robot, q.reshape(-1, robot.dof))[1].reshape(*q.shape[:2], 3)
        fastest = _SAMPLES * np.linalg.norm(np.diff(position, axis=0), axis=2).max(axis=0)
        return ToolGuide(robot, tube, places, cumulative_sums(np.maximum(fastest, np.diff(places))), speed or _FAST)

    def slow_down(self, travel: Floats, excess: Floats) -> ToolGuide:
        """Return the guide slowed down by ``excess`` (n,), if above 1, on stretches ``travel`` (n,) m."""
        total = cumulative_sums(np.diff(self.places))
        here = np.cumsum(travel) / travel.sum() * total[-1]
        step = np.clip(np.searchsorted(total, here) - 1, 0, len(total) - 2)
        slower = np.ones(len(total) + 1)
        for offset in (0, 1, 2):  # smoothing spreads a motion over its neighbours
            np.maximum.at(slower, step + offset, excess / _BELOW)
        slower = np.where(slower > 1.0 / _BELOW, slower, 1.0)
        return replace(self, along=cumulative_sums(np.diff(self.along) * slower[1:-1]))

    @cached_property
    def _bound(self) -> ToolBound:
        return ToolBound(self.robot)

    def holds(self, coefficients: Floats, begin: Floats, end: Floats) -> Bools:
        """Return which curves (m, degree + 1, dof) are proven in the tube from ``begin`` to ``end`` (m,)."""
        begin, end = (np.interp(place, self.along, self.places) for place in (begin, end))
        places, count = self.tube.path.along, len(self.tube.path.lengths)
        first = np.searchsorted(places, begin, side="right") - 1 - _NEIGHBOURS
        width = (
            2 * _NEIGHBOURS + 1 + int((np.searchsorted(places, end) - np.searchsorted(places, begin)).max(initial=0))
        )
        lines = np.clip(first[:, None] + np.arange(width), 0, count - 1)
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
    """Return the motion along a joint path (k, dof) at ``along`` (k,) m of a tool path, and tool speeds.

    It runs from rest to rest. Corners are rounded as far as the motion is proven to stay in the tube and free, and
    ``proven`` covers both; no ``time_law`` takes shortcuts. Speeds are None without a requested ``speed`` (m/s).
    """
    guide = ToolGuide.from_path(path, along, checker.robot, tube, speed)

    def time_with(guide: ToolGuide) -> Trajectory:
        return time_curve(path, checker, limits, time_law, floor, guide=guide)[0]

    def scale_guide(speeds: Floats) -> ToolGuide:
        return replace(guide, fastest=guide.fastest * (speed or 0.0) / speeds.max() * _BELOW)

    motion = time_with(guide)
    if speed is None:
        return motion, None
    travel, speeds = _tool_speeds(motion, checker.robot)
    if (
        _share_at(travel, speeds, speeds.max()) > _PLATEAU and speeds.max() < speed * _BELOW
    ):  # a limit slows the whole motion down
        guide = scale_guide(speeds)
        travel, speeds = _tool_speeds(motion := time_with(guide), checker.robot)
    for number in range(_ROUNDS + 1):
        if speeds.max() <= speed:
            break
        # slower where the tool is too fast; after some rounds slower everywhere
        guide = guide.slow_down(travel, speeds / speed) if number < _ROUNDS else scale_guide(speeds)
        travel, speeds = _tool_speeds(motion := time_with(guide), checker.robot)
    return motion, ToolSpeedRecord(asked=speed, largest=float(speeds.max()), share=_share_at(travel, speeds, speed))


def _share_at(travel: Floats, speeds: Floats, speed: float) -> float:
    """Return the share of ``travel`` (n,) m, run at ``speeds`` (n,) m/s, within 1 % of ``speed``."""
    return float(travel[np.abs(speeds / speed - 1.0) <= _WITHIN].sum() / travel.sum())


def _tool_speeds(trajectory: Trajectory, robot: Robot) -> tuple[Floats, Floats]:
    """Return the tool's travel (n,) m between samples of a motion, and its speed (n,) m/s on each."""
    seconds = np.diff(trajectory.times)
    counts = np.maximum(np.ceil(seconds / _SAMPLE), 20).astype(np.int64).clip(max=200)
    shares = ranges(np.zeros(len(counts), dtype=np.int64), counts) / np.repeat(counts, counts)
    times = np.append(
        np.repeat(trajectory.times[:-1], counts) + shares * np.repeat(seconds, counts), trajectory.times[-1]
    )
    position = Frame.tool(robot).poses(robot, trajectory.at(times))[1]
    travel = np.linalg.norm(np.diff(position, axis=0), axis=1)
    return travel, travel / np.diff(times)


def join_trajectories(
    first: Trajectory, second: Trajectory, checker: CollisionChecker, limits: MotionLimits, floor: float
) -> Trajectory:
    """Return one motion after another, from rest to rest each, proven together; proven if both are."""
    shift = first.nanoseconds[-1] - second.nanoseconds[0]
    clock = np.concatenate([first.nanoseconds, second.nanoseconds[1:] + shift])
    columns = tuple(np.concatenate([a, b[1:]]) for a, b in zip(first.columns, second.columns, strict=True))
    motion = Trajectory(first.joints, clock, columns, first.time_law, limits)
    proof = prove_motion(motion, EdgeProver(checker), limits, floor)
    record = proof.to_dict(checker.world.margin, checker.name)
    for key in ("corners", "corners_blended", "shortcuts", "pieces_inside"):
        record[key] = first.proof.get(key, 0) + second.proof.get(key, 0)
    return replace(motion, proven=proof.whole and first.proven and second.proven, proof=record)
