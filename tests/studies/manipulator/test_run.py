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
from planner.base.request import SweepRequest
from planner.kinematics.manipulability import manipulability
from planner.query.open import Query, make_query
from planner.roadmap.scale import manipulability_cost
from planner.studies.manipulator import run as experiment
from planner.studies.manipulator.case import (
    BETAS,
    RRT,
    SHORTENED,
    MeasuredPath,
    SeedStudy,
    SolveFacts,
    label_of,
    study_seed,
)
from planner.studies.manipulator.run import LABELS, run_manipulator, shown_case
from planner.studies.manipulator.verdicts import PAPER_COSTS, groups_text, manipulator_verdicts
from planner.studies.report import Report, Verdict, write_report

SEEDS = 3


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


def judged(cases: list[SeedStudy]) -> dict[str, Verdict]:
    verdicts = manipulator_verdicts(cases, 4.0)
    assert len({verdict.sentence for verdict in verdicts}) == len(verdicts)
    return {verdict.sentence: verdict for verdict in verdicts}


def test_ideal_cases_confirm_every_sentence() -> None:
    for verdict in judged([ideal(k) for k in range(SEEDS)]).values():
        assert verdict.holds, verdict
        assert verdict.of == (1 if "the paper prints" in verdict.sentence else SEEDS)


ZERO, THIRD, HALF, MOST, ONE = map(label_of, BETAS)
OTHER = np.array([[0.0], [4.5], [6.5], [9.0]])
RED_Q, BLUE_Q = ideal().ways[ZERO].q, ideal().ways[ONE].q


@pytest.mark.parametrize(
    ("case", "sentence"),
    [
        (changed(THIRD, nodes=OTHER), "GABF produces the same path for both"),
        (changed(HALF, nodes=OTHER), "... as well as a common path"),
        (changed(MOST, nodes=RED_Q), "... as well as a common path"),
        (changed(RRT, nodes=BLUE_Q), "Most segments"),
        (changed(ZERO, nodes=BLUE_Q), "Most segments"),
        (changed(ONE, tool=np.linspace([0, 0, 0.9], [1, 0, 0.9], 20)), "The trajectory generated with beta = 0.5"),
        (changed(HALF, distance_cost=1.0), "... since in this case the distance cost"),
        (changed(RRT, manipulability_cost=0.01), "The RRT algorithm only considers"),
        (changed(RRT, distance_cost=48.0), "The RRT algorithm only considers"),
        (changed(THIRD, distance_cost=40.0), "The path of beta = 0 or 0.3 prioritizes"),
        (changed(MOST, manipulability_cost=0.0), "The path of beta = 0 or 0.3 prioritizes"),
        (changed(ONE, manipulability_cost=0.05), "The red path achieves a significantly lower"),
        (changed(ZERO, distance_cost=60.0), "... at the expense of a slightly larger"),
        (changed(ZERO, distance_cost=46.0), "... at the expense of a slightly larger"),
        (changed(ZERO, workspace_length=1.2), "The red path does not appear significantly longer"),
        (changed(ZERO, turning=1.5), "It exhibits larger curvature"),
        (changed(ZERO, workspace_length=0.9), "... resulting in a longer actual"),
        (changed(ONE, kinks=np.radians([50.0, 40.0])), "The blue path exhibits a zigzag"),
        (changed(SHORTENED, turning=4.5), "This is mainly due to the non-uniform sampling"),
        (changed(ZERO, distance_cost=49.5), "For beta = 0 or 0.3 the total cost of the red path is lower"),
        (replace(ideal(), ways={}), "(ours) Start and goal are connected"),
        (changed(RRT, contact="'a' and 'b'"), "(ours) Every path is free"),
        (replace(ideal(), fields=(SolveFacts(0.0, 4.5, 0.0, 0.01, 1.0),)), "(ours) Every field settles"),
        (replace(ideal(), fields=(SolveFacts(0.0, None, 0.0, 0.01, 1.0),)), "(ours) Every field settles"),
        (replace(ideal(), fields=(SolveFacts(0.0, 1.0, 1e-3, 0.01, 1.0),)), "(ours) Every field settles"),
        (replace(ideal(), fields=(SolveFacts(0.0, 1.0, 0.0, 0.0, 1.0),)), "The kernel satisfies"),
        (replace(ideal(), roadmap=SimpleNamespace(nodes=[1], edges=[])), "We generate a network"),  # type: ignore[arg-type]
    ],
)
def test_a_doctored_case_is_not_confirmed(case: SeedStudy, sentence: str) -> None:
    verdicts = judged([ideal(0), case, ideal(2)])
    (verdict,) = (v for text, v in verdicts.items() if text.startswith(sentence) and "the paper prints" not in text)
    assert (verdict.confirmed, verdict.of) == (SEEDS - 1, SEEDS), verdict


def test_seeds_without_a_path_are_left_out_of_what_is_said_of_paths() -> None:
    bare = replace(ideal(1), ways={})
    verdicts = judged([ideal(0), bare])
    assert next(v for s, v in verdicts.items() if s.startswith("GABF")).of == 1
    assert next(v for s, v in verdicts.items() if s.startswith("We generate")).of == 2
    paths = ("GABF", "The red", "The blue", "It exhibits")
    assert {verdict.of for text, verdict in judged([bare]).items() if text.startswith(paths)} == {0}


def test_groups_are_the_betas_that_share_a_path() -> None:
    assert ideal().groups == ((0.0, 0.3), (0.5, 0.7, 1.0))
    assert groups_text(changed(HALF, nodes=OTHER).groups) == "0 0.3 | 0.5 | 0.7 1"


def test_the_drawn_case_is_one_that_falls_as_the_papers_does() -> None:
    odd, same = (
        changed(HALF, nodes=OTHER),
        replace(ideal(), ways={k: replace(w, nodes=BLUE_Q) for k, w in ideal().ways.items()}),
    )
    assert shown_case([same, odd, ideal(7)]).seed == 7
    assert shown_case([same, odd]) is odd
    assert shown_case([same]) is same


# a small whole run

SMALL = SweepRequest(nodes=80, collision="coal", seed=1)


@pytest.fixture(scope="module")
def query() -> Query:
    return make_query(SMALL, near_start=False)


@pytest.fixture(scope="module")
def case(query: Query) -> SeedStudy:
    found = study_seed(query, SMALL)
    assert found is not None
    assert found.ways
    return found


@pytest.fixture(scope="module")
def small() -> Report:
    return run_manipulator(2, SMALL.nodes, "coal", seed=1)


def test_costs_are_those_of_the_paths_configurations(case: SeedStudy, query: Query) -> None:
    """Omega over every node but the start, D over every edge: recomputed from joint values alone."""
    scale = case.roadmap.scale
    for measured in case.ways.values():
        omega = manipulability_cost(manipulability(query.robot, measured.q[1:]), scale)
        steps = np.linalg.norm(np.diff(measured.q, axis=0), axis=1) / scale.joint_length
        assert measured.manipulability_cost == pytest.approx(omega.sum(), rel=1e-9)
        assert measured.distance_cost == pytest.approx(np.maximum(steps, scale.zeta).sum(), rel=1e-9)


def test_no_beta_is_beaten_by_another_path_of_its_roadmap(case: SeedStudy) -> None:
    for beta in BETAS:
        least = case.ways[label_of(beta)].total(beta)
        assert all(least <= other.total(beta) + 1e-9 for label, other in case.ways.items() if label != RRT)
    assert all(field.error <= 1e-12 for field in case.fields)


def test_the_shortened_rrt_path_is_part_of_the_roadmap_and_the_raw_one_no_shorter(case: SeedStudy) -> None:
    known = {q.tobytes() for q in case.roadmap.nodes}
    assert all(q.tobytes() in known for q in case.ways[SHORTENED].nodes)
    assert case.ways[RRT].joint_length >= case.ways[SHORTENED].joint_length
    for rrt in (case.ways[RRT], case.ways[SHORTENED]):
        assert np.array_equal(rrt.nodes[0], case.roadmap.nodes[case.roadmap.starts[0]])
        assert any(np.array_equal(rrt.nodes[-1], goal) for goal in case.roadmap.nodes[case.roadmap.goals])


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


def test_strands_change_the_roadmap_and_not_its_size(case: SeedStudy, query: Query) -> None:
    pulled = study_seed(query, SMALL, 0.5)
    assert pulled is not None
    assert len(pulled.roadmap.nodes) == len(case.roadmap.nodes)
    assert pulled.roadmap.sha256 != case.roadmap.sha256
    assert np.array_equal(pulled.ways[RRT].nodes, case.ways[RRT].nodes)
