"""Times that are proven against the times that they are made of, and against how many of them were asked for."""

from __future__ import annotations

import numpy as np
import pytest

from planner.trajectory.safe_intervals import CertifiedTimes, TimeGrid, certified_cells

BLOCKED = np.array([[1.1, 1.3], [4.0, 4.01], [9.0, 12.0]])


class Asked:
    """What is proven but where something is ``blocked`` (k, 2), and the latest time and the number of cells asked."""

    def __init__(self, blocked: np.ndarray) -> None:
        self.blocked, self.latest, self.count = blocked, 0.0, 0

    def __call__(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        self.latest, self.count = max(self.latest, high.max()), self.count + len(low)
        return np.asarray(~((low[:, None] <= self.blocked[:, 1]) & (self.blocked[:, 0] <= high[:, None])).any(axis=1))


def test_stretches_are_what_is_proven_and_no_more() -> None:
    proven = Asked(BLOCKED)
    found = CertifiedTimes(proven, TimeGrid(15.0)).within(0.0, np.inf)
    assert proven(found[:, 0], found[:, 1]).all()
    assert len(found) == 4
    assert found[0, 0] == 0.0
    assert found[-1, 1] == np.inf
    np.testing.assert_allclose(found[:-1, 1], BLOCKED[:, 0], atol=1 / 32)
    np.testing.assert_allclose(found[1:, 0], BLOCKED[:, 1], atol=1 / 32)


@pytest.mark.parametrize("end", [0.0, 0.3, 4.0, 6.1, 33.3])
def test_they_are_the_same_whether_asked_for_at_once_or_bit_by_bit_and_cells_are_halved_one_by_one(end: float) -> None:
    rng, grid = np.random.default_rng(3), TimeGrid(end)
    begins = rng.uniform(0, end, 6)
    proven = Asked(np.column_stack([begins, begins + rng.uniform(0, 1, 6)]))
    whole, parts = CertifiedTimes(proven, grid), CertifiedTimes(proven, grid)
    for high in np.sort(rng.uniform(0, end, 5)):
        known = parts.within(0.0, high)
        inside = known[(known[:, 0] <= high)]
        expected = whole.within(0.0, np.inf)
        expected = expected[expected[:, 0] <= high]
        np.testing.assert_array_equal(inside[:, 0], expected[:, 0])
        np.testing.assert_array_equal(np.minimum(inside[:, 1], high), np.minimum(expected[:, 1], high))
    singly = [certified_cells(proven, grid.corners[k : k + 2]) for k in range(len(grid.corners) - 1)]
    length = sum(float((cells[:, 1] - cells[:, 0]).sum()) for cells in singly)
    found = whole.within(0.0, np.inf)
    assert np.minimum(found[:, 1], end).sum() - np.minimum(found[:, 0], end).sum() == pytest.approx(length)
    since = whole.for_good_from()
    assert since == (found[-1, 0] if len(found) and found[-1, 1] == np.inf else np.inf)


def test_only_blocks_that_are_asked_for_are_looked_at() -> None:
    proven = Asked(BLOCKED)
    times = CertifiedTimes(proven, TimeGrid(6000.0))
    times.within(0.0, 6.0)
    assert proven.latest == 8.0
    count = proven.count
    times.within(1.0, 5.0)
    assert proven.count == count
    late = Asked(np.array([[5.0, 5990.0]]))
    times = CertifiedTimes(late, TimeGrid(6000.0))
    assert times.within(4000.0, 4001.0).tolist() == []
    assert times.for_good_from() == pytest.approx(5990.0, abs=1 / 32)


def test_the_first_time_is_that_of_all_stretches_and_asks_for_no_more() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        blocked = np.sort(rng.uniform(0, 900, 30)).reshape(-1, 2)
        whole = CertifiedTimes(Asked(blocked), TimeGrid(1000.0)).within(0.0, np.inf)
        times = CertifiedTimes(Asked(blocked), TimeGrid(1000.0))
        for low, longest in zip(rng.uniform(0, 1100, 30), rng.exponential(100.0, 30), strict=True):
            after = whole[whole[:, 1] >= low]
            expected = max(low, after[0, 0])
            assert times.first(low, low + longest) == (expected if expected <= low + longest else np.inf)
    late = Asked(np.array([[5.0, 790.0], [800.0, 990.0]]))
    assert CertifiedTimes(late, TimeGrid(1000.0)).first(700.0, np.inf) == pytest.approx(790.0, abs=1 / 32)
    everything = Asked(np.array([[5.0, 790.0], [800.0, 990.0]]))
    CertifiedTimes(everything, TimeGrid(1000.0)).within(700.0, 800.0)
    assert late.count < everything.count / 4


def test_what_is_free_as_a_whole_is_asked_for_as_a_whole() -> None:
    counts = []
    for end in (60.0, 60_000.0):
        proven = Asked(BLOCKED)
        times = CertifiedTimes(proven, TimeGrid(end))
        times.within(0.0, np.inf)
        assert times.for_good_from() == pytest.approx(12.0, abs=1 / 32)
        counts.append(proven.count)
    assert counts[1] < counts[0] + 60


def test_horizons_double() -> None:
    assert list(TimeGrid(30.0).horizons(5.0)) == [8.0, 16.0, 30.0, np.inf]
    assert list(TimeGrid(30.0).horizons(31.0)) == [np.inf]
    assert list(TimeGrid(0.0).horizons(2.0)) == [np.inf]
