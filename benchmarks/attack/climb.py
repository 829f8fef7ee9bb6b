"""Hill climbing from many starts at once: the optimiser of every attack, stopped on counts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from planner.base.progress import Progress

C = TypeVar("C")

SLOTS = 12  # climbs side by side: what is asked about many cases at once is asked about these
_PATIENCE = 12  # steps without an improvement after which a climb restarts
_SCALES = (-5.0, 0.0)  # decimal exponents between which a step's size is drawn: a climb needs small ones and large ones


def climb(
    tries: int,
    rng: np.random.Generator,
    begin: Callable[[np.random.Generator], C],
    step: Callable[[C, float, np.random.Generator], C],
    score: Callable[[Sequence[C]], Sequence[float]],
    progress: Progress,
) -> bool:
    """Search for cases of high ``score``, ``tries`` of them; False where it was stopped.

    A climb takes a random case and keeps a random ``step`` from it (of a size, 1 the largest) whenever the score is no
    lower; after some steps without result it restarts. ``score`` itself stores results.
    """
    best: list[tuple[float, C] | None] = [None] * SLOTS
    failed = np.zeros(SLOTS, dtype=int)
    while tries > 0 and not progress.stopped:
        slots = range(min(SLOTS, tries))
        cases = [_next(best[k], begin, step, rng) for k in slots]
        tries -= len(cases)
        for k, (case, value) in enumerate(zip(cases, score(cases), strict=True)):
            old = best[k]
            failed[k] = 0 if old is None or value > old[0] else failed[k] + 1
            if old is None or value >= old[0]:
                best[k] = value, case
            if failed[k] > _PATIENCE:
                best[k], failed[k] = None, 0
    return tries <= 0


def _next(
    old: tuple[float, C] | None,
    begin: Callable[[np.random.Generator], C],
    step: Callable[[C, float, np.random.Generator], C],
    rng: np.random.Generator,
) -> C:
    return begin(rng) if old is None else step(old[1], 10.0 ** rng.uniform(*_SCALES), rng)
