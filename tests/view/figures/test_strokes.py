"""Line styles."""

from __future__ import annotations

from planner.view.figures.strokes import DASHES, MARKS, SHADES, marked, stroke


def test_the_first_lines_differ_in_dash_and_marker_and_all_in_shade() -> None:
    assert len(set(DASHES)) == len(set(MARKS)) == len(set(SHADES)) == 6
    assert stroke(1)["linestyle"] != stroke(2)["linestyle"]
    assert marked(1)["marker"] != marked(2)["marker"]
