"""``python -m reproduce example``: the facts of the nine-node graph, and verdicts that can say no."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner import gabf
from reproduce.example import CLAIMS, Example, nine_node, run_example
from reproduce.report import Report, judge, write_report


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


def test_optimal_paths_of_node_6() -> None:
    assert of(nine_node()).paths(6) == {(6, 8, 9), (6, 9)}


def test_a_doctored_graph_is_not_confirmed() -> None:
    network = nine_node()
    weight = network.weight.copy()
    weight[network.arcs_between(3, 1)] = 1.5  # node 4 reads node 2 at a higher price
    verdicts = {verdict.sentence: verdict for verdict in judge(CLAIMS, [of(replace(network, weight=weight))])}
    assert not verdicts["P(4) = {2, 3}."].holds
    assert not verdicts["x_4* = 7 is achievable via paths 4 -> 2 -> 1 or 4 -> 3 -> 1."].holds
    assert verdicts["6 is in F_2 but not in F_1."].holds


def test_a_flat_graph_is_judged_and_not_confirmed() -> None:
    all_sources = replace(nine_node(), sources=np.arange(9), source_values=np.ones(9))
    verdicts = judge(CLAIMS, [of(all_sources)])
    assert not any(v.holds for v in verdicts if "F_2" in v.sentence or "D(G)" in v.sentence)


def test_the_figure_is_written(report: Report, tmp_path: Path) -> None:
    write_report(report, tmp_path)
    assert (tmp_path / "example_graph.png").read_bytes()[:4] == b"\x89PNG"


def test_the_nine_node_example_is_what_the_text_says():
    """Section 2, in the paper's numbering: node k is index k - 1."""
    net = nine_node()
    found = gabf.structure(net)
    assert found.x_star[[0, 8]].tolist() == [1.0, 1.0]
    assert found.x_star[3] == 7.0
    assert (gabf.true_parents(net, found, 3) + 1).tolist() == [2, 3]
    assert found.diameter == 3
    assert found.x_star[5] == 7.0
    assert (gabf.true_parents(net, found, 5) + 1).tolist() == [8, 9]
    assert found.longest[5] == 2
    assert found.fewest[5] == 1
    assert (np.flatnonzero(found.longest == 0) + 1).tolist() == [1, 9]
    assert gabf.true_parents(net, found, 0).size == 0
    assert net.n_nodes == 9
    assert (net.weight < 0).any()


@pytest.mark.parametrize("law", [gabf.Nominal(), gabf.PrescribedTime(), gabf.FixedTime(), gabf.SingularityFree()])
def test_every_law_solves_the_nine_node_example(law):
    result = gabf.solve(nine_node(), law)
    assert result.x.tolist() == [1, 3, 3, 7, 5, 7, 4, 3, 1]
