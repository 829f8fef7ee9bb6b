"""Cases measured at once."""

from __future__ import annotations

from planner.base.progress import Progress
from planner.studies.parallel import measured_cases


def test_cases_at_once_are_each_measured_once_and_none_after_a_stop() -> None:
    assert dict(measured_cases([3, 4, 5], lambda case: case**2, 2, Progress())) == {0: 9, 1: 16, 2: 25}
    measured: list[int] = []
    progress = Progress(stop=lambda: len(measured) >= 2)
    for _, case in measured_cases(range(50), lambda case: case, 1, progress):
        measured.append(case)
    assert measured == [0, 1]
