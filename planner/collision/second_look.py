"""The second look at motions that are proven: two collision libraries sample them, without bounds or proofs."""

from __future__ import annotations

from collections.abc import Callable

from planner.base.arrays import Floats
from planner.base.resolutions import RECHECK, RECHECK_BY_BACKEND
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.looks import Seen, first_seen


def second_look(
    checker: CollisionChecker,
    coefficients: Floats,
    step: float = RECHECK,
    second: CollisionChecker | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> Seen | None:
    """The first contact on pieces (m, degree + 1, dof) that one of two libraries sees; None where both see none.

    The ``checker`` samples every ``RECHECK_BY_BACKEND`` (m) of motion, or every ``step`` where that is longer, and
    coal every ``step`` (m). ``second`` takes the place of coal's checker. ``progress`` is called with the number of
    pieces that have been sampled.
    """
    judges = dict([(checker, max(step, RECHECK_BY_BACKEND)), (second or second_checker(checker), step)])
    first = None
    for judge, apart in judges.items():
        before = coefficients if first is None else coefficients[: first.piece + 1]
        seen = first_seen(judge, before, apart, progress)
        if seen is not None and (first is None or (seen.piece, seen.s) < (first.piece, first.s)):
            first = seen
    return first
