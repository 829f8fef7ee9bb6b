"""How long a batch takes on any number of workers, from the times of its tasks."""

from __future__ import annotations

import heapq
from collections.abc import Sequence

import numpy as np


def makespan(seconds: Sequence[float], workers: int, dispatch: float) -> float:
    """The time (s) until all tasks are done, each begun by the first worker that is free.

    Task k is handed out after (k + 1) ``dispatch`` at the earliest: whoever hands them out does one after the other, so
    that more than mean task time / ``dispatch`` workers gain nothing. What machines share (disks, memory) is left out.
    """
    free = [0.0] * workers
    for k, task in enumerate(seconds):
        begin = max(heapq.heappop(free), (k + 1) * dispatch)
        heapq.heappush(free, begin + task)
    return max(free)


def drawn(seconds: Sequence[float], count: int, seed: int) -> list[float]:
    """The times of ``count`` tasks like the measured ones: drawn from them, with replacement."""
    return np.random.default_rng(seed).choice(np.asarray(seconds), count).tolist()
