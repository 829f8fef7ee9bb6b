"""The content of a page, without a browser: paths, files and notebook cells."""

from __future__ import annotations

# the paths for all betas
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.planning.result import Plan
from planner.tradeoff.result import Tradeoff
from planner.view.motion import ShownPath
from tests.browser import page_data


def assert_same(mine: list[ShownPath], theirs: list[ShownPath]) -> None:
    for a, b in zip(mine, theirs, strict=True):
        assert a.interval == pytest.approx(b.interval, abs=1e-9)
        assert a.numbers == b.numbers
        np.testing.assert_array_equal(a.path, b.path)


def test_a_plan_and_a_sweep_show_the_same_paths(made: Plan, tradeoff: Tradeoff) -> None:
    (mine, current), theirs = made.page_paths(), tradeoff.page_paths()
    assert len(mine) >= 4
    assert_same(mine, theirs)
    assert mine[current].path is made.path
    for interval, shown in zip(tradeoff.intervals, theirs, strict=True):
        rows = dict(shown.numbers)
        assert rows["w mean (m²)"] == f"{interval.w_mean:.3g}"
        assert rows["tool's path"] == f"{interval.workspace_length:.3f} m"


def test_pages_are_the_same_bytes_twice_and_whole(made: Plan, tradeoff: Tradeoff, tmp_path: Path) -> None:
    for thing, name in ((made, "plan.html"), (tradeoff, "sweep.html")):
        thing.save(tmp_path / "a")
        thing.save(str(tmp_path / "b"))
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
        assert page_data(tmp_path / "a" / name)["paths"][0]["interval"][0] == 0.0
        (tmp_path / "file").write_text("")
        with pytest.raises(FileError, match="cannot be written"):
            thing.save(tmp_path / "file" / "a")
