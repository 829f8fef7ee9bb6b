"""The optimiser of the attacks: it finds a peak, counts its tries, and stops when asked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.attack.climb import SLOTS, climb
from planner.base.progress import QUIET, Progress

PEAK = np.array([0.3, -0.7])


class Hill:
    """A narrow hill on a plain: random draws alone hardly ever come near its top."""

    def __init__(self) -> None:
        self.tried, self.best = 0, -np.inf

    def score(self, cases: Sequence[np.ndarray]) -> list[float]:
        assert len(cases) <= SLOTS
        self.tried += len(cases)
        values = [-float(np.linalg.norm(case - PEAK)) for case in cases]
        self.best = max(self.best, *values)
        return values


def run(hill: Hill, tries: int, progress: Progress = QUIET, steps: bool = True) -> bool:
    begin = lambda rng: rng.uniform(-100, 100, 2)  # noqa: E731
    step = (lambda case, size, rng: case + 100 * size * rng.normal(size=2)) if steps else (lambda *_: begin(_[2]))
    return climb(tries, np.random.default_rng(0), begin, step, hill.score, progress)


def test_it_climbs_far_higher_than_chance() -> None:
    climbing, drawing = Hill(), Hill()
    assert run(climbing, 2400)
    assert run(drawing, 2400, steps=False)
    assert -climbing.best < 0.1 * -drawing.best


@pytest.mark.parametrize("tries", [1, SLOTS + 1, 100])
def test_tries_are_counted(tries: int) -> None:
    hill = Hill()
    assert run(hill, tries)
    assert hill.tried == tries


def test_a_stop_is_told() -> None:
    hill = Hill()
    assert not run(hill, 10_000, Progress(stop=lambda: hill.tried >= 3 * SLOTS))
    assert hill.tried == 3 * SLOTS
