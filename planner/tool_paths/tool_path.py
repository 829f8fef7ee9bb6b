"""A tool path as arrays: straight lines of the tool between points, and its orientation along them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, cumulative_sums, frozen, numbers
from planner.base.errors import ArrayError

_TURN = 0.05  # rad: largest turn along one line, so that chords of rotations are near it
SAGITTA = 0.1  # of the tube: largest distance of arcs from their lines
_FARTHEST = 20.0  # m: beyond any arm, as points in millimetres are
_SAME = 1e-6  # m: closer points are the same
_WIDEST = 1.5708  # rad, of a cone
_TURNED = 1e-6  # tolerance of a rotation's entries
_SPUN = 1e-9  # rad: a smaller turn about the z axis is rounding error
_Z = np.array([0.0, 0.0, 1.0])
POINT_ARRAYS = ("positions", "turns", "free", "cones", "given")
_SIZES = {"position": (1e-6, 0.1, "m"), "angle": (1e-5, 0.5, "rad")}


@dataclass(frozen=True)
class TubeSize:
    """Tolerances of a tool path: ``position`` (m), and ``angle`` (rad) of the orientation or the z axis."""

    position: float = 0.001
    angle: float = 0.0087

    def __post_init__(self) -> None:
        for name, (least, most, unit) in _SIZES.items():
            if not least <= getattr(self, name) <= most:
                raise ArrayError(f"tube.{name} must be from {least:g} to {most:g} {unit}, got {getattr(self, name):g}.")


@dataclass(frozen=True, eq=False)
class ToolPath:
    """Lines of the tool between points: ``positions`` (k, 3) m and ``turns`` (k, 3, 3) in the world.

    Where ``free`` (k,) is true the tool may turn about its z axis, which has to be within ``cones`` (k,) rad of that of
    ``turns``; 0 is the tube's angle. Position and orientation change linearly between two points. The tool may turn
    freely on a line with a free end, its z axis along the great arc; the orientation at its other end binds at that
    point alone. ``given`` (k,) is the number in the file, from 1, of the point at which the line to each point ends;
    :func:`planner.read_tool_path` reads a file. ``bend`` (m) is the largest distance of arcs from their lines. Raises
    :class:`ArrayError` for arrays that are no path.
    """

    name: str
    positions: Floats
    turns: Floats
    free: Bools
    cones: Floats
    given: Ints
    tube: TubeSize = TubeSize()
    bend: float = 0.0

    def __post_init__(self) -> None:
        k = len(numbers("positions", self.positions, ("k", 3)))
        shapes = {"positions": (k, 3), "turns": (k, 3, 3), "free": (k,), "cones": (k,), "given": (k,)}
        for name, shape in shapes.items():
            values = np.asarray(getattr(self, name), dtype=float)
            dtype = {"free": bool, "given": int}.get(name, float)
            object.__setattr__(self, name, frozen(numbers(name, values, shape), dtype))
        if k < 2:
            raise ArrayError(f"a tool path must have two points or more, got {k}: add points.")
        off = np.abs(self.turns @ np.swapaxes(self.turns, 1, 2) - np.eye(3)).max(axis=(1, 2))
        faults = (
            (np.abs(self.positions).max(axis=1) > _FARTHEST, "point {} must be within 20 m: give metres, not mm."),
            (self.lengths < _SAME, "point {} must differ from the next one: leave one out."),
            (~((self.cones >= 0) & (self.cones <= _WIDEST)), "the cone of point {} must be from 0 to 1.5708 rad."),
            ((off > _TURNED) | (np.linalg.det(self.turns) < 0), "turns of point {} must be a right-handed rotation."),
        )
        for wrong, text in faults:
            if wrong.any():
                raise ArrayError(text.format(self.given[wrong.argmax()]))

    @cached_property
    def lengths(self) -> Floats:
        """(k - 1,) m of every line."""
        return np.linalg.norm(np.diff(self.positions, axis=0), axis=1)

    @property
    def along(self) -> Floats:
        """(k,) m from the first point to each."""
        return cumulative_sums(self.lengths)

    def rows(self, which: Ints | slice) -> dict[str, Any]:
        """Return the arrays of some of the points."""
        return {name: getattr(self, name)[which] for name in POINT_ARRAYS}

    @property
    def widths(self) -> Floats:
        """(k,) rad of tolerance of the z axis at each point with a free turn."""
        return np.where(self.cones > 0, self.cones, self.tube.angle)

    @property
    def backwards(self) -> ToolPath:
        """The path from its end to its start."""
        return replace(self, **self.rows(slice(None, None, -1)))

    def subdivide(self) -> ToolPath:
        """Return the path with points added, so that no line turns by more than 0.05 rad."""
        path = self._add_bound_lines()
        line, share = path.divide(path.turn_angles / _TURN)
        position, turn, free, cone = path.at(line, share)
        turn[(share == 0) | (share == 1)] = path.turns
        given = path.given[np.where(share > 0, line + 1, line)]
        return replace(path, positions=position, turns=turn, free=free, cones=cone, given=given)

    def _add_bound_lines(self) -> ToolPath:
        """Return the path with short bound lines at bound points between free ones; corners keep the turn."""
        k = 1 + np.flatnonzero(~self.free[1:-1] & self.free[:-2] & self.free[2:])
        line, point = np.append(k - 1, k), np.append(k, k)
        share = np.minimum(2.0 * self.tube.position / self.lengths[line], 0.5)
        position, turn, _, _ = self.at(line, np.where(line < point, 1.0 - share, share))
        turn = align_z(turn[:, :, 2], self.turns[point])
        new = dict(zip(POINT_ARRAYS, (position, turn, False, 0.0, self.given[line + 1]), strict=True))
        return replace(self, **{name: np.insert(getattr(self, name), line + 1, new[name], axis=0) for name in new})

    def divide(self, pieces: Floats) -> tuple[Ints, Floats]:
        """Return points, by line and share (n,), that cut the lines into at least ``pieces`` (k - 1,)."""
        count = np.maximum(np.ceil(pieces - 1e-9), 1).astype(np.int64)
        line = np.append(np.repeat(np.arange(len(count)), count), len(count) - 1)
        return line, np.append(np.concatenate([np.arange(n) / n for n in count]), 1.0)

    def at(self, line: Ints, share: Floats) -> tuple[Floats, Floats, Bools, Floats]:
        """Return positions (n, 3), turns (n, 3, 3), free turns (n,) and cones (n,) on lines at shares (n,)."""
        s, end, widths = share[:, None], line + 1, self.widths
        position = (1 - s) * self.positions[line] + s * self.positions[end]
        width = (1 - share) * widths[line] + share * widths[end]
        cone, free = np.where(self.cones[line] + self.cones[end] > 0, width, 0.0), self.free[line] | self.free[end]
        for rows, point in ((share == 0, line), (share == 1, end)):  # a point has its own tolerance
            free[rows], cone[rows] = self.free[point[rows]], self.cones[point[rows]]
        turns = self.turns[line] @ rotate_about(self._axes[line], share * self.turn_angles[line])
        return position, turns @ rotate_about(_Z, share * self._ends_and_spins[1][line]), free, cone

    @cached_property
    def turn_angles(self) -> Floats:
        """(k - 1,) rad by which the orientation turns along each line, or the z axis if turns are free."""
        return rotation_angles(self.turns[:-1], self._ends_and_spins[0])

    @cached_property
    def _ends_and_spins(self) -> tuple[Floats, Floats]:
        """Orientations (k - 1, 3, 3) at the ends of lines without the free turn about z; that turn (k - 1,)."""
        least = np.swapaxes(align_z(self.turns[1:, :, 2], self.turns[:-1]), 1, 2) @ self.turns[1:]
        spin = np.arctan2(least[:, 1, 0], least[:, 0, 0])
        spin = np.where((self.free[:-1] | self.free[1:]) & (np.abs(spin) > _SPUN), spin, 0.0)
        return self.turns[1:] @ rotate_about(_Z, -spin), spin

    @cached_property
    def _axes(self) -> Floats:
        """(k - 1, 3) axes of the turns, in the frame of each line's start."""
        relative = np.swapaxes(self.turns[:-1], 1, 2) @ self._ends_and_spins[0]
        ahead, behind = relative[:, [2, 0, 1], [1, 2, 0]], relative[:, [1, 2, 0], [2, 0, 1]]
        size = np.linalg.norm(ahead - behind, axis=1)[:, None]
        return np.where(size > 1e-12, (ahead - behind) / np.where(size > 1e-12, size, 1.0), half_turn_axes(relative))


def rotation_angles(a: Floats, b: Floats) -> Floats:
    """Return the angles (n,) rad between rotations (n, 3, 3), accurate for small ones."""
    return 2.0 * np.arcsin(np.clip(np.sqrt(((a - b) ** 2).sum(axis=(1, 2)) / 8.0), 0.0, 1.0))


def half_turn_axes(turns: Floats) -> Floats:
    """Return the axes (n, 3) of rotations (n, 3, 3) that are half turns or identities."""
    spread = 0.5 * (turns + np.eye(3))
    column = np.argmax(np.einsum("nii->ni", spread), axis=1)
    axis = np.take_along_axis(spread, column[:, None, None], axis=2)[:, :, 0]
    return axis / np.maximum(np.linalg.norm(axis, axis=1), 1e-12)[:, None]


def rotate_about(axis: Floats, angle: Floats) -> Floats:
    """Return rotations (n, 3, 3) about unit axes (n, 3), or one (3,), by angles (n,) rad (Rodrigues)."""
    cross = np.zeros((len(angle), 3, 3))
    for i, j, k, sign in ((0, 1, 2, -1), (0, 2, 1, 1), (1, 0, 2, 1), (1, 2, 0, -1), (2, 0, 1, -1), (2, 1, 0, 1)):
        cross[:, i, j] = sign * axis[..., k]
    return np.eye(3) + np.sin(angle)[:, None, None] * cross + (1 - np.cos(angle))[:, None, None] * (cross @ cross)


def align_z(z: Floats, like: Floats) -> Floats:
    """Return the rotations (n, 3, 3) with z axes ``z`` (n, 3) that are nearest to ``like`` (n, 3, 3)."""
    old = like[:, :, 2]
    axis = np.cross(old, z)
    sine, cosine = np.linalg.norm(axis, axis=1), (old * z).sum(axis=1)
    unit = np.where(sine[:, None] > 1e-12, axis / np.where(sine > 1e-12, sine, 1.0)[:, None], like[:, :, 0])
    return rotate_about(unit, np.arctan2(sine, cosine)) @ like


def arc_points(through: Floats, tube: float) -> tuple[Floats, Floats]:
    """Return points (n, 3) on the arc through three points (3, 3), and the angles (n,) from the first.

    Lines between them are off the arc by at most a tenth of the tube; they include the middle point, and not the first.
    ``ValueError`` for three points on a line.
    """
    first, middle, last = through
    a, b = first - middle, last - middle
    normal = np.cross(a, b)
    if np.linalg.norm(normal) < 1e-6 * np.linalg.norm(a) * np.linalg.norm(b):
        raise ValueError("the three points of an arc lie on a line")
    centre = middle + np.cross((a @ a) * b - (b @ b) * a, normal) / (2.0 * normal @ normal)
    radius, axis = float(np.linalg.norm(middle - centre)), -normal / np.linalg.norm(normal)
    x = (first - centre) / radius
    y = np.cross(axis, x)

    def angle(point: Floats) -> float:
        return float(np.arctan2((point - centre) @ y, (point - centre) @ x) % (2 * np.pi))

    to_middle, to_last = angle(middle), angle(last)
    step = 2.0 * np.arccos(max(1.0 - SAGITTA * tube / radius, 0.5))
    counts = [max(1, int(np.ceil(part / step))) for part in (to_middle, to_last - to_middle)]
    before, behind = (np.arange(1, count + 1) for count in counts)
    angles = np.append(to_middle * before / counts[0], to_middle + (to_last - to_middle) * behind / counts[1])
    points = centre + radius * (np.cos(angles)[:, None] * x + np.sin(angles)[:, None] * y)
    points[counts[0] - 1], points[-1] = middle, last
    return points, angles
