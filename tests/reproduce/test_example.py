"""``python -m reproduce example``: the facts of the nine-node graph, and verdicts that can say no."""

from dataclasses import replace

import pytest

from planner import gabf
from reproduce.example import CLAIMS, Example, nine_node, run_example
from reproduce.report import Report, judge


@pytest.fixture(scope="module")
def report() -> Report:
    return run_example(3)


def of(network: gabf.Network) -> Example:
    return Example(network, gabf.structure(network))


def test_every_sentence_is_confirmed(report: Report) -> None:
    assert len(report.verdicts) >= 10
    assert [verdict.sentence for verdict in report.verdicts if not verdict.holds] == []
    assert report.config == {"seed": 3}


def test_the_table_says_what_the_text_says(report: Report) -> None:
    rows = {row["node"]: row for row in report.table}
    assert rows[1]["x*"] == rows[9]["x*"] == 1.0
    assert rows[4]["x*"] == rows[6]["x*"] == 7.0
    assert rows[4]["parents"] == "{2, 3}"
    assert rows[6]["F"] == 2
    assert rows[1]["F"] == rows[9]["S"] == 0
    assert report.more["diameter"] == 3


def test_each_law_is_run_from_the_starts_that_it_allows(report: Report) -> None:
    runs = {(run["law"], run["start"]) for run in report.more["runs"]}
    above = {(law, "above") for law in ("nominal", "prescribed-time", "fixed-time", "singularity-free")}
    assert runs == above | {("fixed-time", "below"), ("singularity-free", "below")}


def test_a_doctored_graph_is_not_confirmed() -> None:
    network = nine_node()
    weight = network.weight.copy()
    weight[network.arcs_between(3, 1)] = 1.5  # node 4 reads node 2 at a higher price
    verdicts = {verdict.sentence: verdict for verdict in judge(CLAIMS, [of(replace(network, weight=weight))])}
    assert not verdicts["P(4) = {2, 3}."].holds
    assert not verdicts["x_4* = 7 is achievable via paths 4 -> 2 -> 1 or 4 -> 3 -> 1."].holds
    assert verdicts["6 is in F_2 but not in F_1."].holds
