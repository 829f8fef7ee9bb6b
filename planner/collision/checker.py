"""What a collision backend must answer; each backend is one file, and only that file imports its library."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.collision.bounds import ClearanceBound
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain
from planner.world.robot import Robot


class CollisionChecker(Protocol):
    """Exact questions about configurations of one robot in one scene.

    A backend is stateful inside (it moves its shapes), so one instance serves one thread.
    """

    world: World
    chain: Chain
    bound: ClearanceBound  # cheap lower bounds on the same pairs
    name: str
    queries: int  # exact pair distances and state checks asked so far

    def __init__(self, world: World) -> None: ...

    @property
    def robot(self) -> Robot:
        return self.world.robot

    def first_contact(self, q: Floats) -> tuple[int, Contact] | None:
        """The first of the configurations (n, dof) that is not free, and why; None if all are free.

        Not free means that a checked pair touches or is no farther apart than ``world.margin``. No cheap bound
        is consulted: this is the independent opinion on everything proven with one.
        """
        ...

    def all_free(self, q: Floats) -> bool:
        """Whether every configuration (n, dof) is free; quicker than :meth:`first_contact`, as no pair is named."""
        ...

    def distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Floats:
        """Distances (k,) in metres of numbered pairs at one placement of the joints; 0 or less where they touch.

        ``rotation`` (joints + 1, 3, 3), ``position`` (joints + 1, 3). May exceed the truth by :meth:`error`.
        """
        ...

    def bounding_distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Iterator[float]:
        """As :meth:`distances`, one after the other as they are asked for, and where much is left less may be reported.

        What is no farther apart than ``world.margin`` by this is so by :meth:`distances`.
        """
        ...

    def error(self, distance: float) -> float:
        """How much a reported ``distance`` (m) may exceed the true one."""
        ...


def contact_of(checker: CollisionChecker, q: Floats) -> Contact | None:
    """Why one configuration (dof,) is not free, or None."""
    found = checker.first_contact(np.atleast_2d(q))
    return found[1] if found else None


def is_free(checker: CollisionChecker, q: Floats) -> bool:
    """Whether one configuration (dof,) is free."""
    return contact_of(checker, q) is None
