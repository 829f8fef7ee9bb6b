"""Interface of collision backends; only a backend's own file imports its library."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np

from planner.base.arrays import Floats, Ints, numbers, plain_numbers
from planner.base.errors import StateError
from planner.base.polynomials import evaluate
from planner.base.yamlfile import FARTHEST
from planner.collision.bounds import ClearanceBound
from planner.collision.containment import Containment
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain, joint_placements
from planner.problem.conditions import Condition
from planner.robot.robot import Robot

APART = 1e-9  # m: no backend reports contact for pairs proven farther apart
_NEARER = 1e-4  # m: largest amount by which a library underestimates a proven distance


@dataclass(frozen=True, eq=False)
class CurveStates:
    """Configurations (n, dof) at ``s`` (n,) in [0, 1] on rows ``piece`` (n,) of ``coefficients``.

    Evaluated on indexing: ``states[rows]``.
    """

    coefficients: Floats
    piece: Ints
    s: Floats

    def __len__(self) -> int:
        return len(self.s)

    def __getitem__(self, rows: Ints | slice) -> Floats:
        return evaluate(self.coefficients[self.piece[rows]], self.s[rows])


class CollisionChecker(Protocol):
    """Exact collision queries for one robot in one scene.

    A backend moves its shapes, so threads that share a checker must take turns.
    """

    world: World
    chain: Chain
    bound: ClearanceBound  # cheap lower bounds on the same pairs
    name: str
    queries: int  # number of exact pair distances and state checks so far
    second: list[CollisionChecker]  # the latest by coal in a world of the same arm, of the checkers known to each other

    def __init__(self, world: World, known: Self | None = None) -> None:
        """Build a checker; shapes that ``known`` (another world of the same arm) has are shared."""
        ...

    def __reduce__(self) -> tuple[type[Self], tuple[World]]:
        """Pickle and copy the world only: objects of the libraries are rebuilt."""
        return type(self), (self.world,)

    @property
    def robot(self) -> Robot:
        return self.world.robot

    def make_ready(self) -> None:
        """Build lazily created objects now, so that no later query waits for them."""
        self.first_contact(np.zeros((1, self.robot.dof)))

    @cached_property
    def inside(self) -> Containment:
        """Queries whether one body or obstacle lies wholly inside another."""
        return Containment(self.world, self.chain)

    @cached_property
    def _wider(self) -> dict[float, CollisionChecker]:
        """Cache of :func:`with_extra_margin` by clearance."""
        return {}

    @cached_property
    def static_contact(self) -> Contact | None:
        """A contact within the margin of a pair that no joint moves (base and obstacle), or None."""
        world, enough = self.world, self.world.margin + _NEARER
        checked = np.append(world.checked.ravel(), np.ones(len(world.self_pairs), dtype=bool))
        pairs = np.flatnonzero(checked & ~world.moving)
        if not len(pairs):
            return None
        rotation, position = joint_placements(self.chain, np.zeros((1, self.robot.dof)))
        near = pairs[self.bound.close(rotation, position, np.zeros_like(pairs), pairs, enough) < enough]
        touching = near[self.distances(rotation[:, 0], position[:, 0], near) <= world.margin]
        return world.contact(int(touching[0])) if len(touching) else None

    def first_contact(self, q: Floats) -> tuple[int, Contact] | None:
        """Return the first of (n, dof) configurations that is not free, and its contact; else None.

        A configuration is free if every checked pair is farther apart than ``world.margin`` and no item encloses
        another. No bound is used, so this check is independent of the proofs. Raises :class:`StateError` for a wrong
        shape or values that are not finite.
        """
        q = as_configurations(self, "q", q)
        result = self.first_touch(q)
        pairs = self.inside.pairs(q if result is None else q[: result[0]])
        held = np.flatnonzero(pairs >= 0)
        if not len(held):
            return result
        return int(held[0]), replace(self.world.contact(int(pairs[held[0]])), enclosed=True)

    def first_contact_along(self, q: Floats | CurveStates, motion: Floats) -> tuple[int, Contact] | None:
        """Return :meth:`first_contact` for consecutive configurations (n, dof) on motions.

        ``motion`` (pairs,) bounds the change of each pair's distance (m) between neighbours. A backend may skip
        configurations that its own distances clear.
        """
        return self.first_contact(q[:] if isinstance(q, CurveStates) else q)

    def first_touch(self, q: Floats) -> tuple[int, Contact] | None:
        """Return :meth:`first_contact` of surfaces only: enclosed shapes do not count."""
        ...

    def distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Floats:
        """Return distances (k,) m of numbered pairs in one configuration; at most 0 in contact.

        ``rotation`` is (joints + 1, 3, 3), ``position`` (joints + 1, 3). They may exceed the true distance by
        :meth:`error`.
        """
        return self.distances_in(rotation[:, None], position[:, None], np.zeros_like(pairs), pairs)

    def distances_in(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        """Return distances (k,) m of ``pairs`` (k,) in configurations ``rows`` (k,).

        Values beyond ``enough`` (k,) m are lower bounds. ``rotation`` is (joints + 1, n, 3, 3), ``position`` (joints +
        1, n, 3).
        """
        ...

    def gaps(self, q: Floats, pairs: Ints) -> Floats:
        """Return :meth:`distances` (k,) m of numbered pairs in one configuration (dof,)."""
        rotation, position = joint_placements(self.chain, np.atleast_2d(q))
        return self.distances(rotation[:, 0], position[:, 0], pairs)

    def error(self, distance: float) -> float:
        """Return the most (m) by which a reported ``distance`` may exceed the true one."""
        ...


def with_extra_margin(checker: CollisionChecker, clearance: float) -> CollisionChecker:
    """Return a checker with ``clearance`` (m) added to the margin; ``checker`` itself for 0.

    Pairs that no joint moves are ignored. Cached per clearance.
    """
    if clearance <= 0:
        return checker
    if clearance not in checker._wider:
        wider = checker._wider[clearance] = type(checker)(checker.world.with_extra_margin(clearance), checker)
        wider.inside = checker.inside.among(checker.world.moving)
    return checker._wider[clearance]


def with_conditions(checker: CollisionChecker, conditions: tuple[Condition, ...]) -> CollisionChecker:
    """Return a checker of the same world with other path constraints."""
    return type(checker)(replace(checker.world, conditions=conditions), checker)


def as_configurations(checker: CollisionChecker, what: str, values: Floats) -> Floats:
    """Return ``values`` as configurations (n, dof); a single one (dof,) becomes a row."""
    rows = np.atleast_2d(plain_numbers(what, values, StateError))
    return numbers(what, rows, ("n", checker.robot.dof), StateError, FARTHEST)


def contact_at(checker: CollisionChecker, q: Floats) -> Contact | None:
    """Return the contact that makes one configuration (dof,) not free, or None."""
    result = checker.first_contact(q)
    return result[1] if result else None


def is_free(checker: CollisionChecker, q: Floats) -> bool:
    """Return whether one configuration (dof,) is free."""
    return contact_at(checker, q) is None
