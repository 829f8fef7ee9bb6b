"""``planner reproduce learning``: graphs, thresholds and a small whole run, and verdicts that can say no."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.studies.learning import robot as learning_robot
from planner.studies.learning import run as experiment
from planner.studies.learning import scan as learning_scan
from planner.studies.learning import study as learning_study
from planner.studies.learning.cases import ERROR_DRIVEN, HEBBIAN
from planner.studies.learning.figures import most_telling
from planner.studies.learning.robot import PRIORS, TASKS, RobotSettings
from planner.studies.learning.robot_report import robot_verdicts
from planner.studies.learning.run import run_learning, study_graph
from planner.studies.learning.study import GraphStudy
from planner.studies.learning.verdicts import learning_verdicts
from planner.studies.report import Report, write_report

ROBOT = RobotSettings("planar_2r", "empty", "q:0.5,0.5", "q:-2,1", roadmaps=1, nodes=40, executions=25)


@pytest.fixture(scope="module")
def report() -> Report:
    """A whole run, small: 3 graphs, one of them in turn, a scan of four trials, one roadmap."""
    patch = pytest.MonkeyPatch()
    patch.setattr(learning_study, "IN_TURN", 1)
    patch.setattr(learning_scan, "GRAPHS", 2)
    patch.setattr(learning_scan, "ALPHAS", (5.0,))
    patch.setattr(learning_scan, "BETAS", (0.001, 3.0))
    for module in (learning_scan, experiment):
        patch.setattr(module, "TRIALS", 4)
    try:
        return run_learning(graphs=3, iterations=6, seed=0, robot=ROBOT)
    finally:
        patch.undo()


@pytest.fixture(scope="module")
def study() -> GraphStudy:
    return study_graph(12, iterations=6, seed=0)


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


def test_doctored_stages_are_not_confirmed(study: GraphStudy) -> None:
    run = study.runs[ERROR_DRIVEN.name]
    facts = list(run.facts)
    facts[-1] = replace(facts[-1], optimal=False, off_target=0.1, product_error=1.0, path_error=1.0, settling_time=9.0)
    wrong = replace(study, runs={**study.runs, ERROR_DRIVEN.name: replace(run, facts=tuple(facts))})
    before, after = (learning_verdicts([graph]) for graph in (study, wrong))
    changed = {a.sentence.split(" (")[0] for a, b in zip(before, after, strict=True) if a.holds and not b.holds}
    assert {sentence[:32] for sentence in changed} == {
        "x_i(t) can be directly incorpora",
        "(ours) Eq.",
        "The law ensures convergence with",
        "The trained weights wbar_ij appr",
        "After the sixth training iterati",
    }


def test_fewer_iterations_are_not_judged_on_later_ones() -> None:
    verdicts = learning_verdicts([study_graph(20, iterations=1, seed=0)])
    assert not any("2 training iterations" in verdict.sentence for verdict in verdicts)
    assert any("the last (1) training iteration" in verdict.sentence for verdict in verdicts)
    assert learning_verdicts([]) == ()


def test_both_rules_start_from_the_same_field(study: GraphStudy) -> None:
    hebbian, error_driven = (study.runs[rule.name].stages[0].field.x for rule in (HEBBIAN, ERROR_DRIVEN))
    assert hebbian.tolist() == error_driven.tolist()


def test_the_graph_that_is_drawn_is_most_like_the_papers_figure(study: GraphStudy) -> None:
    run = study.runs[ERROR_DRIVEN.name]

    def off(*excess: float) -> GraphStudy:
        facts = tuple(replace(f, excess=e) for f, e in zip(run.facts, excess, strict=False))
        return replace(study, runs={ERROR_DRIVEN.name: replace(run, facts=facts)})

    at_once, stuck, improved = off(0.3, 0.5, 0.1, 0.0), off(0.3, 0.4, 0.4, 0.4), off(0.3, 0.2, 0.2, 0.1)
    assert most_telling([at_once, stuck, improved]) is improved
    assert most_telling([off(0.3, 0.1, 0.1, 0.05), improved]) is improved
    assert most_telling([stuck, at_once]) is at_once
    one_iteration = off(0.3, 0.2)
    assert most_telling([one_iteration]) is one_iteration


def test_robot_verdicts_say_no_where_regret_stays(report: Report) -> None:
    settings = replace(ROBOT, executions=3)
    [case] = [learning_robot.make_case(query_of(settings), settings.nodes, 0, 0)]
    assert case is not None
    good = learning_robot.campaign(case, "optimistic", "one start", 25, 0)
    stuck = replace(good, steps=(*good.steps[:-1], replace(good.steps[-1], regret=0.5)), costly=99)
    others = [replace(good, prior=prior, task=task) for prior in PRIORS for task in TASKS]
    assert robot_verdicts([stuck, *others[1:]])[0].confirmed == 0
    assert not robot_verdicts([stuck, *others[1:]])[3].holds
    assert good.last_regret <= learning_robot.LOSS
    assert robot_verdicts([]) == ()


def query_of(settings: RobotSettings):
    from planner.base.request import RoadmapRequest
    from planner.query.open import make_query

    request = RoadmapRequest(settings.robot, settings.scene, start=settings.start, goal=settings.goal)
    return make_query(request, near_start=False)


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
