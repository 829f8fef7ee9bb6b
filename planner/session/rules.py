"""What is asked of motions beside clearance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import OptionError, choices
from planner.query.resolve import position_bounds
from planner.robot.robot import Robot
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.violations import ROUNDING

RUNGS = frozen(np.round(2e7 * 1.2 ** np.arange(32)) / 1e9)  # s that a stop may take, to the nanosecond: up to 5.7
POSITION = "position"
JUDGED = (POSITION, *KINDS)


@dataclass(frozen=True, slots=True, eq=False)
class Rules:
    """Limits ``most`` (3, dof), with what rounding may add, infinite ones ask for nothing, and limits on positions.

    ``lower`` and ``upper`` (dof,) are those, infinite where they are not asked for.
    ``floor``: what manipulability keeps above, 0 for none; ``apart`` (rad, rad/s, rad/s²): of a point at 0 s from the
    state. Limits of kinds that are ``left`` are not asked for.
    """

    most: Floats
    lower: Floats
    upper: Floats
    floor: float
    apart: float
    left: tuple[str, ...]

    @staticmethod
    def of(
        robot: Robot, limits: MotionLimits, judged: Sequence[str] = JUDGED, floor: float = 0.0, apart: float = 0.0
    ) -> Rules:
        """The rules that ask for those limits that are ``judged``; :class:`OptionError` for what makes no sense."""
        judged = judged if isinstance(judged, str) else tuple(judged)  # looked through more than once
        unknown = sorted({str(kind) for kind in judged} - set(JUDGED))
        if isinstance(judged, str) or unknown:
            raise OptionError(f"judged names {choices(unknown) or repr(judged)}: give a list out of {choices(JUDGED)}.")
        for name, value in (("min_manipulability", floor), ("start_tolerance", apart)):
            if not 0.0 <= value < np.inf:
                raise OptionError(f"{name} is {value:g}: give a number from 0 on.")
        none = np.full(len(limits.joints), np.inf)
        most = np.array([getattr(limits, kind) if kind in judged else none for kind in KINDS])
        left = tuple(kind for kind in JUDGED if kind not in judged)
        lower, upper = position_bounds(robot) if POSITION in judged else (-none, none)
        return Rules(most * (1.0 + ROUNDING), lower, upper, float(floor), float(apart), left)
