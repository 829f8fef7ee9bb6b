"""Declared contacts: a pair that may touch for a time, or while a link is inside a region.

A permission for a time needs no proof before its end; behind it the pair is proven apart. In a region every part of a
curve is proven to keep the pair apart, or to keep the whole link inside, apart from six walls around the region. A part
with neither proof is halved a few times.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import monotonic
from typing import Any, TypeAlias

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, numbers
from planner.base.errors import OptionError
from planner.base.polynomials import evaluate, part
from planner.base.resolutions import PROOF
from planner.collision.checker import CollisionChecker
from planner.collision.world import World
from planner.native.compiled import NativeBounds
from planner.robot.poses import pose
from planner.robot.shapes import Box, Obstacle
from planner.session.reasons import Kind

_THICK, _FARTHEST = 1e3, 100.0  # m: walls of regions, thicker than any arm is long, and the farthest face of one
_HALVINGS = 5
_PAIR_FREE = 0

Broken: TypeAlias = tuple[int, Kind, tuple[str, str]]
"""A curve, the kind of violation, and the pair."""


@dataclass(frozen=True, eq=False)
class Permission:
    """A link and an object may touch ``until`` a time (s of ``time.monotonic``), inside ``box``.

    ``box`` (2, 3) m are two corners of a region in the world, None for everywhere.
    """

    link: str
    object: str
    until: float = np.inf
    box: Floats | None = None

    @staticmethod
    def from_now(
        link: str, object: str, seconds: float | None, box: Sequence[float] | Floats | None, tool: Floats
    ) -> Permission:
        """Return a permission with a box near ``tool`` (3,); :class:`OptionError` for invalid values."""
        if seconds is not None and not 0.0 < seconds < np.inf:
            raise OptionError(f"seconds must be above 0 and finite, got {seconds:g}: give the time of the contact.")
        region = None if box is None else np.reshape(numbers("box", box, (6,), OptionError), (2, 3))
        if region is not None and not ((region[0] < region[1]).all() and np.abs(region - tool).max() < _FARTHEST):
            text = f"box must be x0, y0, z0, x1, y1, z1 with x0 < x1 and so on, within {_FARTHEST:g} m of the robot"
            raise OptionError(f"{text}, got [{', '.join(f'{x:g}' for x in region.ravel())}]: give two corners.")
        return Permission(link, object, np.inf if seconds is None else monotonic() + seconds, region)

    def is_of(self, link: str, object: str) -> bool:
        """Whether the permission is that of a pair."""
        return (self.link, self.object) == (link, object)

    @cached_property
    def walls(self) -> tuple[Obstacle, ...]:
        """Six walls that leave the box free."""
        if self.box is None:
            return ()
        middle, size, walls = self.box.mean(axis=0), self.box[1] - self.box[0], []
        for k, side in itertools.product(range(3), (-1.0, 1.0)):
            extent, at = np.full(3, 2.0 * _THICK), middle.copy()
            extent[k], at[k] = _THICK, middle[k] + side * 0.5 * (size[k] + _THICK)
            walls.append(Obstacle(f"wall{len(walls)}", Box(tuple(extent.tolist())), pose(at.tolist())))
        return tuple(walls)

    def pairs_in(self, world: World) -> Bools:
        """Return the mask (bodies, obstacles) of the pairs that may touch."""
        objects = {item.name: item.object for item in world.scene.carried}
        links = np.array([objects.get(body.link, body.link) == self.link for body in world.bodies], dtype=bool)
        return links[:, None] & np.array([item.object == self.object for item in world.obstacles], dtype=bool)

    def text(self, now: float) -> str:
        """Return the permission as a note of a verdict."""
        left = "" if self.until == np.inf else f" for {self.until - now:.3g} s"
        there = "" if self.box is None else " inside a region"
        return f"'{self.link}' and '{self.object}' may touch{there}{left}: the contact is allowed"

    def to_dict(self, now: float) -> dict[str, Any]:
        """Return link, object, the seconds left and the box as plain data."""
        left = None if self.until == np.inf else self.until - now
        return {
            "link": self.link,
            "object": self.object,
            "seconds": left,
            "box": None if self.box is None else self.box.ravel().tolist(),
        }


class Prover:
    """Proofs that pairs of a world (``checked``, (bodies, obstacles)) stay apart on curves."""

    def __init__(self, checker: CollisionChecker, world: World) -> None:
        self.checker = type(checker)(world, checker)
        self.limited = np.array([item.speed_limit > 0 for item in world.obstacles], dtype=bool)
        self._bounds = motion_bounds(self.checker, self.limited)

    def prove(self, curves: Floats, spans: Floats) -> tuple[Bools, Ints, Floats]:
        """Return which curves (m, degree + 1, dof) are free; the pairs and s where the other proofs stopped."""
        curves, timed = np.ascontiguousarray(curves), np.ascontiguousarray(spans) if self.limited.any() else None
        native, bounds = self.checker.bound.native, self._bounds
        verdict, pair, where = native.prove_together(bounds, curves, PROOF, timed)
        k = int(np.argmax(verdict != _PAIR_FREE)) if verdict.any() else len(curves)  # it stops there
        if k < len(curves):
            again = native.prove(bounds, curves[k:], PROOF, None if timed is None else timed[k:])
            verdict[k:], pair[k:], where[k:] = again[0], again[1], again[4]
        inside = self.checker.inside.pairs(curves[:, 0])
        free = (verdict == _PAIR_FREE) & (inside < 0) if self.checker.static_contact is None else verdict < 0
        return free, np.where(inside >= 0, inside, pair), where


class Permit:
    """A permission in one world, with the provers of its pairs and of its region."""

    def __init__(self, permission: Permission, checker: CollisionChecker) -> None:
        world = checker.world
        self.permission, pairs = permission, permission.pairs_in(world)
        own = np.zeros(len(world.self_pairs), dtype=bool)
        self._apart = Prover(checker, world.only(np.append((world.checked & pairs).ravel(), own)))
        self._inside = None
        if permission.box is not None:
            walls = permission.walls
            checked = np.repeat(np.any(pairs, axis=1)[:, None], len(walls), axis=1)
            scene = replace(world.scene, obstacles=walls, carried=(), notes=())
            around = replace(world, scene=scene, self_pairs=world.self_pairs[:0], checked=checked, margin=0.0)
            self._inside = Prover(checker, replace(around, conditions=()))

    def first_broken(self, curves: Floats, spans: Floats, now: float) -> Broken | None:
        """Return the first of curves (m, degree + 1, dof) with a contact that is not allowed.

        ``spans`` (m, 3) are their times after ``now``: begin, duration, 0, s.
        """
        left, begin, seconds = self.permission.until - now, spans[:, 0], spans[:, 1]
        share = np.clip((left - begin) / np.where(seconds > 0.0, seconds, 1.0), 0.0, 1.0)
        share = np.where(begin + seconds <= left, 1.0, np.where(begin >= left, 0.0, share))
        late, early = np.flatnonzero(share < 1.0), np.flatnonzero(share > 0.0)
        broken = [self._prove_parts(curves, spans, late, share[late], np.ones(len(late)), None)]
        if self._inside is not None:
            broken.append(self._prove_parts(curves, spans, early, np.zeros(len(early)), share[early], self._inside))
        return min((found for found in broken if found), key=lambda found: found[0], default=None)

    def _prove_parts(
        self, curves: Floats, spans: Floats, rows: Ints, low: Floats, high: Floats, inside: Prover | None
    ) -> Broken | None:
        """Return the first part [low, high] of curves ``rows`` with no proof, apart or ``inside``."""
        for halving in range(_HALVINGS if inside else 1):
            parts, size = part(curves[rows], low, high), high - low
            times = np.column_stack([spans[rows, 0] + low * spans[rows, 1], size * spans[rows, 1], spans[rows, 2]])
            open: Ints = np.arange(len(rows))
            if inside and len(open):
                open = open[~inside.prove(parts, times)[0]]
            if not len(open):
                return None
            free, pair, where = self._apart.prove(parts[open], times[open])
            if free.all():
                return None
            open, pair, where = open[~free], pair[~free], where[~free]
            if halving == _HALVINGS - 1 or inside is None:
                return int(rows[open[0]]), *self._explain(parts[open[:1]], pair[:1], where[:1])
            middle = 0.5 * (low[open] + high[open])
            low, high = (np.ravel(ends, "F") for ends in ((low[open], middle), (middle, high[open])))
            rows = np.repeat(rows[open], 2)
        return None

    def _explain(self, curve: Floats, pair: Ints, where: Floats) -> tuple[Kind, tuple[str, str]]:
        """Return the kind of violation at ``where`` (1,) on a curve, and the pair."""
        checker = self._apart.checker
        if (contact := checker.static_contact) is not None:
            return "contact", (contact.first, contact.second)
        if pair[0] < 0:
            return "undecided", (self.permission.link, self.permission.object)
        contact = checker.world.contact(int(pair[0]))
        names = contact.first, contact.second
        if checker.gaps(evaluate(curve, where)[0], pair)[0] <= checker.world.margin:
            return "contact", names
        return "reach" if self._apart.limited[checker.world.members(int(pair[0]))[1]] else "undecided", names


def motion_bounds(checker: CollisionChecker, limited: Bools) -> NativeBounds:
    """Return bounds on motions; obstacles with a speed limit (o,) can reach links that no joint moves."""
    world = checker.world
    if not limited.any():
        return checker.bound.motion_bounds
    still = ~world.moving
    still[: world.checked.size] &= ~np.tile(limited, len(world.bodies))
    return checker.bound.native.bounds(world.pair_reach, world.reach.bodies, still)
