"""Verdicts on Section 4.2: ideal cases confirm them, doctored ones do not."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from reproduce.manipulator.case import BETAS, PAPER_COSTS, RRT, SHORTENED, MeasuredPath, SeedStudy, SolveFacts, label_of
from reproduce.manipulator.claims import NETWORK, PATHS, PRINTED
from reproduce.report import judge
from reproduce.verdict import Verdict

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


ZERO, THIRD, HALF, MOST, ONE = map(label_of, BETAS)
OTHER = np.array([[0.0], [4.5], [6.5], [9.0]])
RED_Q, BLUE_Q = ideal().ways[ZERO].q, ideal().ways[ONE].q


def judged(cases: list[SeedStudy]) -> dict[str, Verdict]:
    verdicts = (
        judge(NETWORK, cases) + judge(PATHS, [case for case in cases if case.ways]) + judge(PRINTED, [PAPER_COSTS])
    )
    assert len({verdict.sentence for verdict in verdicts}) == len(verdicts)
    return {verdict.sentence: verdict for verdict in verdicts}


def test_ideal_cases_confirm_every_sentence() -> None:
    for verdict in judged([ideal(k) for k in range(SEEDS)]).values():
        assert verdict.holds, verdict
        assert verdict.of == (1 if "the paper prints" in verdict.sentence else SEEDS)


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
        (replace(ideal(), roadmap=SimpleNamespace(nodes=[1], edges=[])), "We generate a network"),
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
    assert changed(HALF, nodes=OTHER).groups == ((0.0, 0.3), (0.5,), (0.7, 1.0))
