"""Obstacles with known motions: timed poses, interpolated on a line and about one axis."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats, frozen, numbers, placement
from planner.base.errors import SceneError
from planner.base.yamlfile import FARTHEST
from planner.robot.shapes import Obstacle, Shape, as_shape, max_distance_from_origin

LONGEST = 1e5  # s: more than a day
SHORTEST = 1e-6  # s: planning does not resolve shorter intervals


def require_times(times: Sequence[float] | Floats) -> None:
    """Raise ValueError unless times (k,) s begin at 0 and increase by at least ``SHORTEST``."""
    if not len(times) or times[0] != 0 or (np.diff(times) < 0.999 * SHORTEST).any():  # sums of times are rounded
        raise ValueError(
            f"the times of a motion must begin at 0 s and increase by at least {SHORTEST:g} s each, got "
            f"{', '.join(f'{time:.12g}' for time in times[:10])}"
        )


@dataclass(frozen=True, eq=False)
class KnownMotion:
    """Poses (k, 4, 4) at ``times`` (k,) s, which begin at 0 and increase by at least a microsecond.

        KnownMotion([0, 4], [pose([1, -1, 0.5]), pose([1, 1, 0.5])])

    Between two poses the origin moves on a line and the frame turns about one axis, the shorter way, both at constant
    speed; after the last pose it stands still. Raises :class:`SceneError` for invalid times or poses.
    """

    times: Floats
    poses: Floats

    def __init__(self, times: Sequence[float] | Floats, poses: Sequence[Floats] | Floats) -> None:
        object.__setattr__(self, "times", frozen(numbers("KnownMotion.times", times, ("k",), SceneError, LONGEST)))
        try:
            require_times(self.times)
        except ValueError as error:
            raise SceneError(f"{error}: mend them.") from None
        poses_at_t = numbers("KnownMotion.poses", poses, (len(self.times), 4, 4), SceneError, FARTHEST)
        placed = [placement(f"KnownMotion.poses[{row}]", pose, SceneError) for row, pose in enumerate(poses_at_t)]
        object.__setattr__(self, "poses", frozen(placed))

    @property
    def end(self) -> float:
        """Time (s) of the last pose."""
        return float(self.times[-1])

    @cached_property
    def turns(self) -> Floats:
        """(k - 1, 3) rotation vectors (rad) from each pose to the next, in the moving frame."""
        turns = self.poses[:, :3, :3]
        return frozen([pin.log3(a.T @ b) for a, b in itertools.pairwise(turns)]).reshape(-1, 3)

    def at(self, t: Floats | float) -> Floats:
        """Return the poses (n, 4, 4) at times ``t`` (n,) s."""
        t = np.clip(numbers("t", np.atleast_1d(t), ("n",)), 0.0, self.end)
        if len(self.times) == 1:
            return np.repeat(self.poses, len(t), axis=0)
        k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.times) - 2)
        share = (t - self.times[k]) / np.diff(self.times)[k]
        poses_at_t = np.array(self.poses[k])
        poses_at_t[:, :3, 3] += share[:, None] * (self.poses[k + 1, :3, 3] - self.poses[k, :3, 3])
        if self.turns.any():
            parts = zip(poses_at_t[:, :3, :3], share[:, None] * self.turns[k], strict=True)
            poses_at_t[:, :3, :3] = [turn @ pin.exp3(part) for turn, part in parts]
        return poses_at_t

    def speeds(self, shape: Shape) -> Floats:
        """Return (k - 1,) m/s that no point of ``shape`` exceeds between two poses."""
        line = np.linalg.norm(np.diff(self.poses[:, :3, 3], axis=0), axis=1)
        return (line + np.linalg.norm(self.turns, axis=1) * max_distance_from_origin(shape, np.eye(4))) / np.diff(
            self.times
        )

    def speeds_at(self, t: Floats, shape: Shape) -> Floats:
        """Return :meth:`speeds` (n,) at times ``t`` (n,) s other than those of the poses; 0 after the last."""
        return np.concatenate([[0.0], self.speeds(shape), [0.0]])[np.searchsorted(self.times, t)]


@dataclass(frozen=True, eq=False)
class MovingObstacle:
    """A shape that moves through the scene along a known motion."""

    name: str
    shape: Shape
    motion: KnownMotion

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", as_shape(f"obstacle '{self.name}'", self.shape))

    def standing(self, t: float = 0.0) -> Obstacle:
        """Return the obstacle at time ``t`` (s)."""
        return Obstacle(self.name, self.shape, self.motion.at(t)[0])
