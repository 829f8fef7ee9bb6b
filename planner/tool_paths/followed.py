"""How a line of the tool is followed, as ``plan.json`` and a table hold it, and what a page draws of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.kinematics.tool_bound import Frame
from planner.problem.outcome import Record, Rows
from planner.robot.robot import Robot
from planner.tool_paths.timing import ToolSpeedRecord
from planner.tool_paths.tool_path import TubeSize
from planner.tool_paths.tube import Deviation


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

    Points (k, 3) m ``wanted`` and (n, 3) m ``reached``; ``rungs`` (m, dof): the solutions of inverse kinematics that
    were to choose from.
    """

    record: ToolPathRecord
    wanted: Floats
    reached: Floats
    rungs: Floats


def leg_line(robot: Robot, q: Floats, length: float) -> Floats:
    """(2, 3) m from where the tool is at ``q`` (dof,) to ``length`` m back along its z axis."""
    rotation, position = Frame.tool(robot).poses(robot, q[None])
    return position - np.array([[0.0], [length]]) * rotation[0, :, 2]
