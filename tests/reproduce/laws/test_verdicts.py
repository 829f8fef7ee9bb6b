"""Verdicts on Section 4.1: ideal measurements confirm them, doctored ones do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planner.reproduce.laws.cases import CASES, FREE, PRESCRIBED, Measurement
from planner.reproduce.laws.verdicts import GraphFacts, law_verdicts
from planner.reproduce.report import Verdict
from tests.reproduce.laws.test_run import ideal

GRAPHS = 3


def facts(largest: float = 7.0) -> GraphFacts:
    return GraphFacts(500, 10.0, largest, 12, 0, 0, 11.0)


def judged(runs: list[Measurement], graphs: list[GraphFacts] | None = None) -> dict[str, Verdict]:
    verdicts = law_verdicts(graphs or [facts()] * GRAPHS, runs)
    assert len({verdict.sentence for verdict in verdicts}) == len(verdicts)
    return {verdict.sentence: verdict for verdict in verdicts}


def ideal_runs() -> list[Measurement]:
    return [ideal(graph, case) for graph in range(GRAPHS) for case in CASES]


def doctored(of_case, **changes) -> list[Measurement]:
    """The ideal runs with one graph's runs of the chosen cases changed."""
    return [replace(r, **changes) if r.graph == 1 and of_case(r.case) else r for r in ideal_runs()]


def test_ideal_measurements_confirm_every_sentence() -> None:
    for verdict in judged(ideal_runs()).values():
        assert verdict.holds, verdict
        assert verdict.of == GRAPHS


@pytest.mark.parametrize(
    ("broken", "changes", "sentence"),
    [
        (lambda c: c == PRESCRIBED[2], {"settling_time": 3.9}, "Larger h leads to faster"),
        (lambda c: c == PRESCRIBED[2], {"node_input": 1.0}, "... as the control effort increases (prescribed"),
        (lambda c: c == PRESCRIBED[0], {"settling_time": np.inf, "settling_tau": np.inf}, "All state errors converge"),
        (lambda c: c == PRESCRIBED[0], {"within_bounds": False}, "All the control inputs remain bounded (prescribed"),
        (lambda c: c == PRESCRIBED[0], {"largest_input": np.inf}, "All the control inputs remain bounded (prescribed"),
        (
            lambda c: c == FREE[5],
            {"settling_tau": 1.0},
            "Smaller p1/p2 yields faster convergence (singularity-free law, ",
        ),
        (
            lambda c: c == FREE[5],
            {"settling_tau": 1.0},
            "Smaller m1/m2 yields faster convergence (singularity-free law, ",
        ),
        (lambda c: c == FREE[5], {"error": 1e-3}, "The state error converges before"),
        (lambda c: c == FREE[5], {"last_input": 1.0}, "All the control inputs remain bounded (singularity-free"),
        (lambda c: c == FREE[5], {"largest_input": 1e6}, "(ours) No input grows beyond"),
        (lambda c: c == FREE[5], {"within_bounds": False}, "(ours) Every bound of the paper"),
    ],
)
def test_a_doctored_run_is_not_confirmed(broken, changes: dict, sentence: str) -> None:
    verdicts = judged(doctored(broken, **changes))
    hit = [verdict for text, verdict in verdicts.items() if text.startswith(sentence) and not verdict.holds]
    assert hit
    assert all(verdict.confirmed == GRAPHS - 1 for verdict in hit)


def test_a_start_below_is_no_overestimate() -> None:
    verdicts = judged(ideal_runs(), [facts(), facts(10.5), facts()])
    (verdict,) = (v for s, v in verdicts.items() if "overestimated" in s)
    assert (verdict.confirmed, verdict.of) == (2, 3)
