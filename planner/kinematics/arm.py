"""An arm for kinematics: joints with limits, and a tool frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.errors import OptionError, RobotError, choices
from planner.base.yamlfile import quote
from planner.problem.options import Measure, Rows

HALF_TURN = np.pi - 1e-9
"""The largest turn (rad) of a continuous joint on a motion given by its ends; rounding is smaller."""


@dataclass(frozen=True)
class Mimic:
    """A joint whose value is ``multiplier`` times that of the joint ``leader``, plus ``offset`` (rad, m)."""

    joint: str
    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Arm:
    """The planned joints of a robot, their limits and its tools; configurations are (n, dof), rad.

    Prismatic joints are in m. A continuous joint is one angle like any other; ``continuous`` says which may wrap.
    ``tool`` is the main tool; a robot with several arms has ``other_tools`` too.
    """

    model: pin.Model
    joints: tuple[str, ...]
    lower: Floats  # (dof,)
    upper: Floats  # (dof,)
    continuous: Bools  # (dof,)
    tool: str
    other_tools: tuple[str, ...] = ()
    home: Floats  # (dof,)
    jacobian_rows: Rows  # the rows of the tool's Jacobian that w is computed from
    measure: Measure = "yoshikawa"
    followers: tuple[Mimic, ...] = ()  # the joints that follow planned ones, which ``model`` has too

    @property
    def dof(self) -> int:
        return len(self.joints)

    @property
    def prismatic(self) -> Bools:
        """(dof,) which joints are prismatic (in m)."""
        return sliding_joints(self.model)[self.rows]

    @cached_property
    def rows(self) -> Ints:
        """(dof,) the numbers of the planned joints among those of ``model``, which include followers."""
        return frozen([self.model.getJointId(joint) - 1 for joint in self.joints], np.int64)

    @cached_property
    def tool_id(self) -> int:
        return frame_id(self.model, self.tool)

    @property
    def tools(self) -> tuple[str, ...]:
        """The frames of all tools, the main one first."""
        return self.tool, *self.other_tools

    @property
    def tool_text(self) -> str:
        """All tools as people write them, with commas between."""
        return ",".join(self.tools)

    @cached_property
    def with_each_tool(self) -> tuple[Self, ...]:
        """The same arm once for each tool, with that tool only."""
        if not self.other_tools:
            return (self,)
        return tuple(replace(self, tool=tool, other_tools=()) for tool in self.tools)

    @cached_property
    def without_payload(self) -> Arm:
        """The arm without its payload: the cache key of all that depends on joints and limits only."""
        return self

    def difference(self, a: Floats, b: Floats) -> Floats:
        """Return the joint motion (..., dof) from a to b: continuous joints turn in the shorter direction."""
        return shorter_way(np.asarray(b) - np.asarray(a), self.continuous)

    def is_below_half_turn(self, delta: Floats) -> Bools:
        """Return which motions (..., dof) turn every continuous joint by less than half a turn."""
        return np.all(np.abs(delta[..., self.continuous]) < HALF_TURN, axis=-1)

    def unwound(self, path: Floats) -> Floats:
        """A path (k, dof) whose continuous joints are counted on from its first row, so that it has no jump.

        A path without whole turns stays the same to the last bit.
        """
        path = np.asarray(path)
        if not self.continuous.any():
            return np.array(path)
        turns = np.rint((self.difference(path[:-1], path[1:]) - np.diff(path, axis=0)) / (2 * np.pi))
        return path + 2 * np.pi * np.vstack([np.zeros(path.shape[1]), np.cumsum(turns, axis=0)])

    def normalise(self, q: Floats) -> Floats:
        """Return ``q`` with continuous joints in [-pi, pi)."""
        return np.where(self.continuous, in_one_turn(np.asarray(q) + np.pi) - np.pi, q)


def shorter_way(delta: Floats, turns: Bools) -> Floats:
    """Return joint motions (..., dof) in the shorter direction for the joints that ``turns`` marks.

    The way back is the exact opposite: a motion of half a turn, up to rounding, has the sign of ``delta``.
    """
    if not turns.any():
        return delta
    turned = np.mod(np.abs(delta) + np.pi, 2 * np.pi) - np.pi
    turned = np.where(turned < -HALF_TURN, turned + 2 * np.pi, turned)
    return np.where(turns, np.copysign(1.0, delta) * turned, delta)


def in_one_turn(angles: Floats) -> Floats:
    """Return angles in [0, 2 pi); mod twice, as rounding takes an angle just below 0 to 2 pi."""
    return np.mod(np.mod(angles, 2 * np.pi), 2 * np.pi)


def sliding_joints(model: pin.Model) -> Bools:
    """Return (joints,) which joints of ``model`` are prismatic (in m)."""
    return np.array([joint.shortname().startswith("JointModelP") for joint in list(model.joints)[1:]])


def tool_names(text: str) -> tuple[str, ...]:
    """Return the tools that a text names, with commas between; :class:`OptionError` unless they differ."""
    names = tuple(name.strip() for name in text.split(","))
    if not all(names) or len({*names}) < len(names):
        raise OptionError(f"tool must be a frame, or different frames with commas between, got {quote(text)}.")
    return names


def frame_id(model: pin.Model, name: str) -> int:
    """Return the index of the frame ``name``, the link where a joint has the same name."""
    matches = [k for k, frame in enumerate(model.frames) if frame.name == name]
    if not matches:
        raise RobotError(f"frame {quote(name)} not found; frames are {choices(frame.name for frame in model.frames)}.")
    return next((k for k in matches if model.frames[k].type == pin.FrameType.BODY), matches[0])
