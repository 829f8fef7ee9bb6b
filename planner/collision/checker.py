"""What a collision backend must answer; each backend is one file, and only that file imports its library."""

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

APART = 1e-9  # m: what is proven to be so far apart touches for nobody
_NEARER = 1e-4  # m: by more than this no library calls a pair nearer than planes prove it


@dataclass(frozen=True, eq=False)
class CurveStates:
    """Configurations (n, dof) at ``s`` (n,) in [0, 1] on each its ``piece`` (n,) of ``coefficients``, ascending powers.

    As an array of them, but worked out where they are asked for: ``states[rows]``.
    """

    coefficients: Floats
    piece: Ints
    s: Floats

    def __len__(self) -> int:
        return len(self.s)

    def __getitem__(self, rows: Ints | slice) -> Floats:
        return evaluate(self.coefficients[self.piece[rows]], self.s[rows])


class CollisionChecker(Protocol):
    """Exact questions about configurations of one robot in one scene.

    A backend is stateful inside (it moves its shapes), so threads that share one ask it one after the other.
    """

    world: World
    chain: Chain
    bound: ClearanceBound  # cheap lower bounds on the same pairs
    name: str
    queries: int  # exact pair distances and state checks asked so far
    second: list[CollisionChecker]  # the latest by coal in a world of the same arm, of the checkers known to each other

    def __init__(self, world: World, known: Self | None = None) -> None:
        """``known``: a checker in another world of the same arm; shapes that are in both are shared with it."""
        ...

    def __reduce__(self) -> tuple[type[Self], tuple[World]]:
        """A copy, and one out of a pickle, is a checker of its own: the libraries' objects are made anew."""
        return type(self), (self.world,)

    @property
    def robot(self) -> Robot:
        return self.world.robot

    def make_ready(self) -> None:
        """Make now what is made when it is first needed: no check waits for it."""
        self.first_contact(np.zeros((1, self.robot.dof)))

    @cached_property
    def inside(self) -> Containment:
        """Which pairs lie one wholly inside the other, where no surfaces touch."""
        return Containment(self.world, self.chain)

    @cached_property
    def _wider(self) -> dict[float, CollisionChecker]:
        """What :func:`with_extra_margin` has made of it, by clearance."""
        return {}

    @cached_property
    def static_contact(self) -> Contact | None:
        """A pair that no joint can move (the base and an obstacle), if it touches or is within the margin."""
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
        """The first of the configurations (n, dof) that is not free, and why; None if all are free.

        Not free means that a checked pair touches, is no farther apart than ``world.margin``, or lies one inside the
        other. No cheap bound is consulted: this is the independent opinion on everything proven with one.
        :class:`StateError` for configurations with other joints, or with what is no finite number.
        """
        q = as_configurations(self, "q", q)
        found = self.first_touch(q)
        pairs = self.inside.pairs(q if found is None else q[: found[0]])
        held = np.flatnonzero(pairs >= 0)
        if not len(held):
            return found
        return int(held[0]), replace(self.world.contact(int(pairs[held[0]])), enclosed=True)

    def first_contact_along(self, q: Floats | CurveStates, motion: Floats) -> tuple[int, Contact] | None:
        """As :meth:`first_contact`, for configurations (n, dof) one after the other on motions.

        ``motion`` (pairs,): metres by which a pair's distance changes at most from one to the next. A backend whose own
        distances are quick may pass over configurations that they clear.
        """
        return self.first_contact(q[:] if isinstance(q, CurveStates) else q)

    def first_touch(self, q: Floats) -> tuple[int, Contact] | None:
        """As :meth:`first_contact`, for surfaces: what is wholly inside a mesh touches nothing."""
        ...

    def distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Floats:
        """Distances (k,) in metres of numbered pairs at one placement of the joints; 0 or less where they touch.

        ``rotation`` (joints + 1, 3, 3), ``position`` (joints + 1, 3). May exceed the truth by :meth:`error`.
        """
        return self.distances_in(rotation[:, None], position[:, None], np.zeros_like(pairs), pairs)

    def distances_in(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        """The same (k,) of ``pairs`` (k,) in configurations ``rows`` (k,); lower bounds beyond ``enough`` (k,) m.

        ``rotation`` (joints + 1, n, 3, 3), ``position`` (joints + 1, n, 3).
        """
        ...

    def gaps(self, q: Floats, pairs: Ints) -> Floats:
        """The :meth:`distances` (k,) of numbered pairs in one configuration (dof,)."""
        rotation, position = joint_placements(self.chain, np.atleast_2d(q))
        return self.distances(rotation[:, 0], position[:, 0], pairs)

    def error(self, distance: float) -> float:
        """How much a reported ``distance`` (m) may exceed the true one."""
        ...


def with_extra_margin(checker: CollisionChecker, clearance: float) -> CollisionChecker:
    """A checker by the same library that asks for so much ``clearance`` (m) beyond the margin; itself for none.

    Pairs that no joint can move play no part in it: they are as near as they are. The same one each time.
    """
    if clearance <= 0:
        return checker
    if clearance not in checker._wider:
        made = checker._wider[clearance] = type(checker)(checker.world.with_extra_margin(clearance), checker)
        made.inside = checker.inside.among(checker.world.moving)
    return checker._wider[clearance]


def with_conditions(checker: CollisionChecker, conditions: tuple[Condition, ...]) -> CollisionChecker:
    """A checker by the same library of the same world, whose motions keep other ``conditions``."""
    return type(checker)(replace(checker.world, conditions=conditions), checker)


def as_configurations(checker: CollisionChecker, what: str, values: Floats) -> Floats:
    """``values`` as configurations (n, dof) of the checker's robot; one alone (dof,) becomes a row."""
    rows = np.atleast_2d(plain_numbers(what, values, StateError))
    return numbers(what, rows, ("n", checker.robot.dof), StateError, FARTHEST)


def contact_at(checker: CollisionChecker, q: Floats) -> Contact | None:
    """Why one configuration (dof,) is not free, or None."""
    found = checker.first_contact(q)
    return found[1] if found else None


def is_free(checker: CollisionChecker, q: Floats) -> bool:
    """Whether one configuration (dof,) is free."""
    return contact_at(checker, q) is None
