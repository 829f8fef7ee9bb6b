"""Claims become verdicts, a report is written whole, and a stop keeps the cases that are complete."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from planner.base.errors import FileError
from planner.base.progress import QUIET, Progress
from reproduce.report import Claim, Report, collect, judge, write_report
from reproduce.verdict import Verdict, tally


class Torn(Figure):
    """A picture that fails to draw."""

    def savefig(self, *_, **__) -> None:
        raise RuntimeError("no ink")


def small(**more) -> Report:
    rows = ({"node": 1, "x": np.inf, "u": np.float64(0.25), "k": np.int64(3), "q": np.zeros(2)},)
    return Report("toy", {"seed": 0}, rows, (Verdict("It holds.", 2, 3, "twice"),), **more)


def test_a_claim_counts_its_cases_and_shows_its_values() -> None:
    claim: Claim[int] = Claim("even", lambda k: k % 2 == 0, "k {}, more {:.1f}", (float, lambda k: [k, 2.0 * k]))
    assert judge([claim], [2, 3, 4]) == (Verdict("even", 2, 3, "k 3 (2 to 4), more 4.0 (2.0 to 8.0)"),)
    assert judge([claim], []) == (Verdict("even", 0, 0, "k none, more none"),)


def test_a_verdict_holds_only_if_every_case_did() -> None:
    assert [tally("s", cases, "").holds for cases in ([True, True], [True, False], [])] == [True, False, False]


def test_a_report_is_written_with_its_figures(tmp_path: Path) -> None:
    paths = write_report(small(figures={"dot.png": Figure()}, more={"extra": [1, 2]}), tmp_path / "new")
    record = json.loads((tmp_path / "new" / "toy.json").read_text())
    assert [path.name for path in paths] == ["dot.png", "toy.json"]
    assert (tmp_path / "new" / "dot.png").read_bytes()[:4] == b"\x89PNG"
    assert record["verdicts"] == [{"sentence": "It holds.", "confirmed": 2, "of": 3, "note": "twice"}]
    assert record["table"] == [{"node": 1, "x": None, "u": 0.25, "k": 3, "q": [0.0, 0.0]}]
    assert record["figures"] == ["dot.png"]
    assert record["extra"] == [1, 2]
    assert record["complete"] is True
    assert set(record["versions"]) == {"python", "gabf-planner", "numpy", "scipy"}


def test_a_failure_leaves_the_old_report_and_no_scrap(tmp_path: Path) -> None:
    write_report(small(), tmp_path)
    before = (tmp_path / "toy.json").read_bytes()
    with pytest.raises(RuntimeError):
        write_report(small(figures={"torn.png": Torn()}, complete=False), tmp_path)
    assert (tmp_path / "toy.json").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["toy.json"]
    with pytest.raises(FileError, match="choose another place"):
        write_report(small(), tmp_path / "toy.json" / "below")


@pytest.mark.parametrize("jobs", [1, 2])
def test_cases_come_in_their_order_and_a_stop_keeps_the_complete_ones(jobs: int) -> None:
    assert collect(math.factorial, 5, jobs, "cases", QUIET) == [1, 1, 2, 6, 24]
    heard: list[int] = []
    progress = Progress(lambda _, done, total: heard.append(done), lambda: len(heard) > 2)
    some = collect(math.factorial, 400, jobs, "cases", progress)
    assert some == [math.factorial(k) for k in range(len(some))]
    assert 2 <= len(some) < 400
    assert heard == list(range(len(some) + 1))
