"""Pages in a notebook cell."""

from __future__ import annotations

import html

import pytest

import planner
from planner.base.errors import OptionError
from planner.planning.result import Plan
from planner.tradeoff.result import Tradeoff


def test_show_puts_the_page_into_the_cell(made: Plan, tradeoff: Tradeoff) -> None:
    for shown in (planner.show(made), planner.show(tradeoff), planner.show(made.roadmap, made.checker, height=400)):
        cell = shown._repr_html_()
        assert cell.startswith('<iframe sandbox="allow-scripts"')
        assert html.unescape(cell.split('srcdoc="')[1].rsplit('"')[0]) == shown.html
        assert len(repr(shown)) < 50
    assert "height:400px" in cell
    with pytest.raises(OptionError, match="holds no geometry"):
        planner.show(made.roadmap)
    with pytest.raises(OptionError, match="grown with"):
        planner.show(made.roadmap, planner.make_checker(planner.Robot.load("ur5"), planner.Scene("none")))
    with pytest.raises(OptionError, match="leave the other one out"):
        planner.show(made, made.checker)
    for height in (0, -1, True):
        with pytest.raises(OptionError, match="height"):
            planner.show(made, height=height)
