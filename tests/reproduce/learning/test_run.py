"""``planner reproduce learning``: graphs, thresholds and a small whole run, and verdicts that can say no."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.reproduce.learning.robot import PRIORS, TASKS
from planner.reproduce.learning.run import run_learning
from planner.reproduce.learning.study import ERROR_DRIVEN
from planner.reproduce.report import Report, write_report
from tests.reproduce.learning.small import ROBOT


def test_a_whole_run_keeps_the_contract(report: Report, tmp_path: Path) -> None:
    write_report(report, tmp_path)
    record = json.loads((tmp_path / "learning.json").read_text())
    assert record["graphs"] == 3
    assert set(record["share"]) == {"hebbian", "error_driven"}
    assert all(len(shares) == 6 and all(0.0 <= s <= 1.0 for s in shares) for shares in record["share"].values())
    assert record["share"]["error_driven"][-1] == 1.0
    assert record["complete"] is True
    assert {path.name for path in tmp_path.iterdir()} == {"learning.json", *record["figures"]}
    assert len(record["figures"]) == 5
    assert len(record["scan"]) == 4
    assert record["parameters"]["error_driven"] == {"alpha": 5.0, "beta": 0.001}
    assert len(record["robot"]) == len(PRIORS) * len(TASKS)
    assert all(len(campaign["regret"]) == ROBOT.executions for campaign in record["robot"])
    iterations = [row["iteration"] for row in record["table"] if "graphs" in row["study"]]
    assert iterations == [*range(7), *range(7)]


def test_what_must_hold_on_every_graph_holds(report: Report) -> None:
    verdicts = {verdict.sentence: verdict for verdict in report.verdicts}
    for start in (
        "The resulting path remains the shortest path",
        "(ours) GABF's path is the shortest",
        "(ours) f_i is progressive",
        "x_i(t) can be directly",
        "(ours) Eq. (wb) is additive",
        "The law ensures convergence",
        "GABF enables simultaneous",
        "(ours) Optimism is bounded",
        "(ours) Every planning stage",
        f"After the sixth training iteration, GABF identifies and converges to the shortest path ({ERROR_DRIVEN.label}",
    ):
        [found] = [verdict for sentence, verdict in verdicts.items() if sentence.startswith(start)]
        assert found.holds, found
    for start in ("f_i maps", "f_i satisfies the progressive", "... larger weight updates"):
        [found] = [verdict for sentence, verdict in verdicts.items() if sentence.startswith(start)]
        assert found.confirmed == 0 < found.of


def test_interrupted_runs_say_so() -> None:
    asked = iter([False, True])
    found = run_learning(graphs=5, iterations=1, progress=Progress(stop=lambda: next(asked, True)))
    assert found.complete is False
    assert found.more["graphs"] == 1
    nothing = run_learning(graphs=5, iterations=1, progress=Progress(stop=lambda: True))
    assert nothing.complete is False
    assert nothing.table == () == nothing.verdicts


@pytest.mark.parametrize("bad", [{"graphs": 0}, {"iterations": 0}, {"seed": -1}])
def test_numbers_out_of_range_are_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(OptionError):
        run_learning(**bad)
