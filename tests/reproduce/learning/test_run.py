"""``python -m reproduce learning``: a small whole run."""

import json
from pathlib import Path

from planner.base.progress import Progress
from reproduce.learning.run import run_learning
from reproduce.learning.study import GraphStudy
from reproduce.report import Report, write_report


def test_a_whole_run_keeps_the_contract(report: Report, tmp_path: Path) -> None:
    write_report(report, tmp_path)
    record = json.loads((tmp_path / "learning.json").read_text())
    assert record["graphs"] == 3
    assert set(record["share"]) == {"hebbian", "error_driven"}
    assert all(len(shares) == 6 and all(0.0 <= s <= 1.0 for s in shares) for shares in record["share"].values())
    assert record["share"]["error_driven"][-1] == 1.0
    assert record["complete"] is True
    assert {path.name for path in tmp_path.iterdir()} == {"learning.json", *record["figures"]}
    assert record["figures"] == ["learning_paths.png", "learning_share.png"]
    assert record["parameters"]["error_driven"] == {"alpha": 5.0, "beta": 0.001}
    assert [row["iteration"] for row in record["table"]] == [*range(7), *range(7)]
    assert len(record["in_turn"]) == 1
    assert len(record["stages"]) == 3 * 2 * 7


def test_what_must_hold_on_every_graph_holds(report: Report) -> None:
    certain = (
        "The resulting path",
        "(ours) f_i is",
        "x_i(t) can",
        "(ours) Eq. (wb)",
        "The law ensures",
        "GABF enables",
    )
    found = [verdict for verdict in report.verdicts if verdict.sentence.startswith(certain)]
    assert len(found) == len(certain)
    assert all(verdict.holds for verdict in found), found


def test_both_rules_start_from_the_same_field(study: GraphStudy) -> None:
    hebbian, error_driven = (course[0].field.x.tolist() for course in study.stages.values())
    assert hebbian == error_driven


def test_interrupted_runs_say_so() -> None:
    asked = iter([False, True])
    found = run_learning(graphs=5, iterations=1, progress=Progress(stop=lambda: next(asked, True)))
    assert found.complete is False
    assert found.more["graphs"] == 1
    nothing = run_learning(graphs=5, iterations=1, progress=Progress(stop=lambda: True))
    assert nothing.complete is False
    assert nothing.table == () == nothing.verdicts
