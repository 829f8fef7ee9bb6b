"""toppra's durations beside ours; what toppra sees of a curve is the curve."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.motion import toppra_law
from planner.trajectory.curve import rounded
from planner.trajectory.time_optimal import quickest

PATH = np.array([[0.0, 0.0], [0.8, 0.1], [0.9, 0.9], [0.2, 1.0]])
VELOCITY, ACCELERATION = np.array([1.0, 1.5]), np.array([4.0, 3.0])


def test_stops_part_the_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    """With one second per piece the duration is the number of pieces, whatever the stops."""
    parts: list[int] = []

    def counted(pieces: np.ndarray, *_: np.ndarray) -> float:
        parts.append(len(pieces))
        return float(len(pieces))

    monkeypatch.setattr(toppra_law, "_between_stops", counted)
    for widths, expected in (((1.0, 0.5), [5]), ((0.0, 0.5), [1, 3]), ((0.0, 0.0), [1, 1, 1])):
        parts.clear()
        curve = rounded(PATH, np.array(widths))
        assert toppra_law.toppra_duration(curve, VELOCITY, ACCELERATION) == len(curve.corner)
        assert parts == expected


@pytest.mark.skipif(not toppra_law.installed(), reason="toppra is not installed")
def test_it_takes_as_long_as_ours() -> None:
    curve = rounded(PATH, np.array([1.0, 0.5]))
    ours = quickest(curve, VELOCITY, ACCELERATION).duration
    assert toppra_law.toppra_duration(curve, VELOCITY, ACCELERATION) == pytest.approx(ours, rel=0.05)
