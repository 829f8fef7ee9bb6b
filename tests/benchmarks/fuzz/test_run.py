"""Files of every kind, changed at random, load or are refused with one sentence; the judge sees what is otherwise."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz import run as fuzz
from benchmarks.fuzz.cases import kinds
from benchmarks.fuzz.run import bench_fuzz, judge, make
from planner.base.errors import FileError, OptionError

CASES = 320  # about 20 s on a loaded machine; 'python -m benchmarks fuzz' goes on


def test_changed_files_load_or_are_refused_with_a_sentence(tmp_path: Path) -> None:
    result = bench_fuzz(tmp_path, CASES, seed=3)
    assert result.complete
    assert not result.failures, result.report
    for kind in kinds():
        ended = {case.ended for case in result.cases if case.kind == kind}
        assert "refused" in ended, f"{kind}: nothing was changed enough to be refused"


def _refuse(text: str) -> Callable[[Path], None]:
    def use(path: Path) -> None:
        raise FileError(text)

    return use


def _overflow(path: Path) -> None:
    np.exp(np.array([1e4]))


@pytest.mark.parametrize(
    ("use", "ended"),
    [
        (lambda path: None, "loaded"),
        (_refuse("x is wrong: mend it."), "refused"),
        (_refuse("two\nlines."), "no one sentence"),
        (_refuse("no full stop"), "no one sentence"),
        (_refuse("x" * 5000 + "."), "no one sentence"),
        (lambda path: [][1], "IndexError"),
        (lambda path: os.write(2, b"raw text"), "printed"),
        (lambda path: os.system("echo raw text"), "printed"),
        (_overflow, "printed"),
    ],
)
def test_the_judge_sees_how_a_use_ends(use: Callable[[Path], object], ended: str, tmp_path: Path) -> None:
    assert judge(use, tmp_path)[0] == ended


def test_a_process_that_dies_is_a_failure_of_its_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And the cases behind it are tried all the same."""
    tried: list[str] = []

    def died(module: str, arguments: list[str], stop: Callable[[], bool], limit: float) -> fuzz.Ended:
        tried.append(arguments[1])
        if len(tried) > 1:
            seed, first, last = map(int, arguments[:3])
            fuzz._main(seed, first, last, Path(arguments[3]), arguments[4:])
        return fuzz.Ended(-11 if len(tried) == 1 else 0, 0.1, False, "")

    monkeypatch.setattr(fuzz, "run_module", died)
    monkeypatch.setattr(fuzz, "_MEMORY", -1)
    result = bench_fuzz(tmp_path, 3, only=["path csv"])
    assert tried == ["0", "1"]
    assert [case.ended for case in result.failures] == ["process ended with -11"]
    assert len(result.cases) == 3
    assert (tmp_path / "path-csv-0-0.csv").read_bytes() == make(0, 0, kinds()["path csv"])


def test_the_same_seed_makes_the_same_files() -> None:
    for name, kind in kinds().items():
        assert make(5, 7, kind) == make(5, 7, kind), name
        assert len({make(5, number, kind) for number in range(20)}) > 5, name


@pytest.mark.parametrize(("cases", "only"), [(0, ()), (10, ("video",))])
def test_refused(cases: int, only: tuple[str, ...], tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="kinds are urdf"):
        bench_fuzz(tmp_path, cases, only=only)
