"""``planner reproduce manipulator``: the geometry of paths, the verdicts on doctored cases, and a small whole run."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.reproduce.manipulator import run as experiment
from planner.reproduce.manipulator.case import (
    BETAS,
    RRT,
    SHORTENED,
    MeasuredPath,
    SeedStudy,
    SolveFacts,
    label_of,
)
from planner.reproduce.manipulator.run import LABELS, run_manipulator, shown_case
from planner.reproduce.manipulator.verdicts import PAPER_COSTS
from planner.reproduce.report import Report, write_report
from planner.setup.open import Query
from tests.reproduce.manipulator.small import SMALL


def way(label: str, q: float, lift: float, costs: tuple[float, float], **more: Any) -> MeasuredPath:
    path = np.array([[0.0], [q], [q + 1], [9.0]])
    tool = np.linspace([0, 0, lift], [1, 0, lift], 20)
    plain: dict[str, Any] = {"w_min": 0.1, "w_mean": 0.2, "joint_length": 1.0, "workspace_length": 1.0, "turning": 2.0}
    plain |= {"kinks": np.radians([50.0, 60.0]), "tool": tool, "contact": None}
    return MeasuredPath(label, path, path, *costs, **plain | more)


def ideal(seed: int = 0) -> SeedStudy:
    """A case on which every sentence of the paper is true."""
    ways = {}
    for beta in BETAS:
        red = beta < 0.4
        shape = {"workspace_length": 1.05, "turning": 3.0, "joint_length": 1.1} if red else {}
        ways[label_of(beta)] = way(label_of(beta), 1.0 if red else 3.0, 0.5 if red else 0.1, PAPER_COSTS[beta], **shape)
    ways[RRT] = way(RRT, 5.0, 0.0, (1.2, 47.0), turning=4.0)
    ways[SHORTENED] = way(SHORTENED, 7.0, 0.05, (1.1, 46.2), turning=1.0)
    roadmap: Any = SimpleNamespace(nodes=np.zeros((1012, 7)), edges=np.zeros((2029, 2)))
    fields = tuple(SolveFacts(beta, 1.0, 0.0, 0.01, 1.0) for beta in BETAS)
    return SeedStudy(seed, roadmap, fields, ways)


def changed(label: str, **changes: Any) -> SeedStudy:
    """The ideal case with one way changed."""
    case = ideal(1)
    return replace(case, ways=case.ways | {label: replace(case.ways[label], **changes)})


ZERO, THIRD, HALF, MOST, ONE = map(label_of, BETAS)
OTHER = np.array([[0.0], [4.5], [6.5], [9.0]])
RED_Q, BLUE_Q = ideal().ways[ZERO].q, ideal().ways[ONE].q


def test_the_drawn_case_is_one_that_falls_as_the_papers_does() -> None:
    odd, same = (
        changed(HALF, nodes=OTHER),
        replace(ideal(), ways={k: replace(w, nodes=BLUE_Q) for k, w in ideal().ways.items()}),
    )
    assert shown_case([same, odd, ideal(7)]).seed == 7
    assert shown_case([same, odd]) is odd
    assert shown_case([same]) is same


# a small whole run


def test_a_small_run_is_whole_and_written(small: Report, tmp_path: Path) -> None:
    assert small.complete
    assert [row["path"] for row in small.table] == list(LABELS)
    assert small.table[0]["paper_omega"] == 0.0331
    assert small.table[-1]["paper_D"] is None
    write_report(small, tmp_path)
    record = json.loads((tmp_path / "manipulator.json").read_text())
    assert {"sentence", "confirmed", "of", "note"} == set(record["verdicts"][0])
    assert len(record["paths"]) == 2 * len(LABELS)
    assert [roadmap["seed"] for roadmap in record["roadmaps"]] == [1, 2]
    assert set(record["figures"]) == {p.name for p in tmp_path.iterdir()} - {"manipulator.json"}
    certain = ("(ours)", "The kernel satisfies", "The path of beta = 0 or 0.3 prioritizes")
    for verdict in small.verdicts:
        assert verdict.holds or not verdict.sentence.startswith(certain), verdict


def test_a_seed_does_not_depend_on_how_many_are_asked_for(small: Report, case: SeedStudy) -> None:
    rows = {row["path"]: row for row in small.more["paths"] if row["seed"] == 1}
    assert set(rows) == set(case.ways)
    for label, measured in case.ways.items():
        assert rows[label]["q"] == measured.q.tolist()


def test_a_stop_keeps_whole_seeds(monkeypatch: pytest.MonkeyPatch, case: SeedStudy, tmp_path: Path) -> None:
    given = itertools.chain([case], itertools.repeat(None))
    monkeypatch.setattr(experiment, "study_seed", lambda *_, **__: next(given))
    heard: list[tuple[str, int, int]] = []
    report = run_manipulator(5, SMALL.nodes, "coal", progress=Progress(lambda *word: heard.append(word)))
    assert not report.complete
    assert heard == [("seeds", 0, 5), ("seeds", 1, 5)]
    assert len(report.more["roadmaps"]) == 1
    assert "manipulator_costs.png" in report.figures


def test_a_stop_before_the_first_seed_leaves_an_empty_report(query: Query, tmp_path: Path) -> None:
    report = run_manipulator(1, SMALL.nodes, "coal", progress=Progress(stop=lambda: True))
    assert not report.complete
    assert report.table == ()
    assert report.figures == {}
    write_report(report, tmp_path)


@pytest.mark.parametrize(
    ("seeds", "nodes", "strands", "word"), [(0, 80, 0, "seeds"), (1, 1, 0, "nodes"), (1, 80, 1.5, "strands")]
)
def test_numbers_out_of_range_are_refused(seeds: int, nodes: int, strands: float, word: str) -> None:
    with pytest.raises(OptionError, match=word):
        run_manipulator(seeds, nodes, strands=strands)
