"""``python -m reproduce manipulator``: a small whole run, and which paths go into which figure."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from planner.base.progress import Progress
from planner.query.query import Query
from reproduce.manipulator import run as experiment
from reproduce.manipulator.case import LABELS, SeedStudy
from reproduce.manipulator.run import manipulator_figures, run_manipulator, shown_case
from reproduce.report import Report, write_report
from tests.figures.panels import lines
from tests.reproduce.manipulator.conftest import SMALL
from tests.reproduce.manipulator.test_claims import BLUE_Q, HALF, OTHER, changed, ideal


def test_the_drawn_case_is_one_that_falls_as_the_papers_does() -> None:
    odd, good = changed(HALF, nodes=OTHER), ideal()
    same = replace(good, ways={label: replace(way, nodes=BLUE_Q) for label, way in good.ways.items()})
    assert shown_case([same, odd, ideal(7)]).seed == 7
    assert shown_case([same, odd]) is odd
    assert shown_case([same]) is same


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
        np.testing.assert_array_equal(rows[label]["q"], measured.q)


def test_a_stop_keeps_whole_seeds_or_leaves_an_empty_report(tmp_path: Path) -> None:
    heard: list[int] = []
    progress = Progress(lambda _, done, total: heard.append(done), lambda: len(heard) > 1)
    report = run_manipulator(5, SMALL.quality.nodes, progress=progress)
    assert not report.complete
    assert heard == [0, 1]
    assert len(report.more["roadmaps"]) == 1
    nothing = run_manipulator(1, SMALL.quality.nodes, progress=Progress(stop=lambda: True))
    assert (nothing.complete, nothing.table, nothing.figures) == (False, (), {})
    write_report(nothing, tmp_path)


def test_one_curve_per_group_and_costs_of_every_seed(case: SeedStudy, query: Query) -> None:
    profiles = manipulator_figures(query, case, [case, case])["manipulator_w.png"]
    labels = [text.get_text() for text in profiles.legends[0].get_texts()]
    assert labels == [*("β = " + ", ".join(f"{beta:g}" for beta in group) for group in case.groups), "RRT"]
    costs = manipulator_figures(query, case, [case, case])["manipulator_costs.png"].axes[0]
    assert lines(costs)["GABF, median"][1].tolist() == [case.way(b).manipulability_cost for b in experiment.BETAS]
