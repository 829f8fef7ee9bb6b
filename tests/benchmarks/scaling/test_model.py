"""The model of a batch's time."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.scaling.model import drawn, makespan


def test_one_worker_does_one_after_the_other() -> None:
    assert makespan([1.0, 2.0, 3.0], 1, 0.0) == pytest.approx(6.0)
    assert makespan([1.0, 2.0, 3.0], 1, 0.5) == pytest.approx(6.5)  # handing out overlaps with the work


def test_a_free_worker_takes_the_next_task() -> None:
    assert makespan([4.0, 1.0, 1.0, 1.0], 2, 0.0) == pytest.approx(4.0)
    assert makespan([1.0, 1.0, 1.0, 4.0], 2, 0.0) == pytest.approx(5.0)


def test_handing_out_bounds_what_workers_gain() -> None:
    tasks = [1.0] * 1000
    assert makespan(tasks, 10, 0.01) == pytest.approx(100.0, rel=0.01)
    assert makespan(tasks, 1000, 0.01) == pytest.approx(11.0, rel=0.01)


def test_drawn_tasks_are_measured_ones() -> None:
    found = drawn([1.0, 2.0, 4.0], 3000, seed=1)
    assert set(found) == {1.0, 2.0, 4.0}
    assert np.mean(found) == pytest.approx(7 / 3, rel=0.05)
