"""What the attack's report says."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.attack.report import Row, to_markdown


def test_what_is_broken_is_in_the_report() -> None:
    empty = dict.fromkeys(Row.__annotations__)
    asked = {
        "attack": "segments",
        "first": "box",
        "second": "mesh",
        "library": "fcl",
        "tries": 5,
        "seed": 0,
        "tried": 5,
    }
    row = Row(**{**empty, **asked, "free": 3, "false_free": 1, "clearance_m": 2e-3, "found": "HERE", "software": "s"})
    text = to_markdown([row])
    assert "0 of 1: No segment that is called free touches" in text
    assert "HERE" in text
    assert "HERE" not in to_markdown([replace(row, false_free=0, clearance_m=-1e-3)])
