"""What the benchmark of motions says."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.motion.report import Row, aims


def test_aims_are_missed_where_something_touches_or_is_not_timed() -> None:
    asked = ("p", "k", 0, "panda", "coal", 60, "limits", "content", "software", "solved", "")
    good = Row(*asked, 1.0, 1.2, 2.0, 1.0, 3, 3, 1, True, 1.0, "", 50, 0.1)
    bad = Row(*asked, 1.9, 1.9, 2.0, 1.0, 3, 0, 0, False, 1.1, "'a' and 'b' at 0.1 s", 50, 0.3)
    assert all(verdict.holds for verdict in aims([good]))
    assert all(verdict.holds for verdict in aims([replace(good, contact=None)])), "as it comes back from a table"
    assert not any(verdict.holds for verdict in aims([bad])[1:])
