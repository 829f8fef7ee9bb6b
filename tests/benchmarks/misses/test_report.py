"""Misses are shouted."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.misses.report import Row, to_markdown


def test_misses_are_shouted() -> None:
    row = Row("panda", "wall", 1.0, 40, 0, 20, 22, 3, 20, 1, 0, 20, 0, 0, 1000, '[{"start": [1]}]', "here")
    text = to_markdown([row, replace(row, robot="ur5", fcl_missed=0, found="")], complete=True)
    assert "OMPL's default rule calls 44 free, of which **6 touch**" in text
    assert "40 with FCL, of which **1 touch**" in text
    assert '- Missed before panda: [{"start": [1]}]' in text
    assert "Missed before ur5" not in text
    assert "Software: here." in text
