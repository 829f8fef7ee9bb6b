"""The sweep of a robot's roadmap: against the oracle on a grid, edges that fail, interrupted sweeps, files."""

import itertools
from pathlib import Path

import numpy as np
import pytest

import planner.tradeoff.sweep as module
from planner import gabf
from planner.base.progress import Progress
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.request import SweepRequest
from planner.roadmap.roadmap import path_waypoints
from planner.roadmap.storage import load_roadmap, save_roadmap
from planner.search.network import at_beta, build_network, path_cost
from planner.tradeoff.result import Interval, Tradeoff
from planner.tradeoff.sweep import add_alternatives, sweep
from planner.trajectory.measure import joint_path_length, path_contact, path_manipulability, tool_path_length
from tests.search.failing import collide


def least(tradeoff: Tradeoff, beta: float) -> float:
    """The least cost from a start by the oracle."""
    request, roadmap = tradeoff.request, tradeoff.roadmap
    network = build_network(roadmap, request.quality.objective_at(beta))
    return float(gabf.oracle(network)[roadmap.starts].min())


def cost(interval: Interval, beta: float) -> float:
    return (1.0 - beta) * interval.manipulability_cost + beta * interval.distance_cost


def outline(tradeoff: Tradeoff) -> list[tuple[float, float, list[int]]]:
    return [(interval.beta_min, interval.beta_max, interval.path_nodes.tolist()) for interval in tradeoff.intervals]


def assert_covers(tradeoff: Tradeoff) -> None:
    intervals = tradeoff.intervals
    assert tradeoff.outcome is Outcome.SOLVED
    assert tradeoff.complete
    assert [intervals[0].beta_min, intervals[-1].beta_max] == [0.0, 1.0]
    assert all(a.beta_max == b.beta_min for a, b in itertools.pairwise(intervals))
    assert all(interval.beta_min < interval.beta_max for interval in intervals)


def test_the_intervals_cover_all_betas(swept: Tradeoff) -> None:
    assert_covers(swept)
    assert len(swept.intervals) >= 3
    assert swept.max_error_vs_oracle == 0.0
    assert swept.solves <= 2 * len(swept.intervals) + 3
    assert swept.edges_removed == 0


def test_each_interval_says_what_its_path_is(swept: Tradeoff) -> None:
    roadmap, robot = swept.roadmap, swept.robot
    for interval in swept.intervals:
        nodes, path = interval.path_nodes, interval.path
        assert nodes[0] in roadmap.starts
        assert nodes[-1] in roadmap.goals
        np.testing.assert_array_equal(path, path_waypoints(roadmap, robot, nodes))
        found = path_cost(build_network(roadmap, 0.25), nodes)
        assert (interval.manipulability_cost, interval.distance_cost) == (found.manipulability, found.distance)
        w = path_manipulability(robot, path)
        assert (interval.w_min, interval.w_mean) == (w.min(), w.mean())
        assert interval.joint_length == joint_path_length(path)
        assert interval.workspace_length == tool_path_length(robot, path)
        assert path_contact(swept.checker, path) is None
        field = interval.cost_to_go
        kernel = field.network.kernel
        assert isinstance(kernel, gabf.EdgeIntegral)
        assert interval.beta_min <= kernel.beta <= interval.beta_max
        assert field.outcome is gabf.Ending.SETTLED
        assert field.x[nodes[0]] == pytest.approx(cost(interval, kernel.beta), rel=1e-12)


def assert_optimal_on_a_grid(tradeoff: Tradeoff) -> None:
    for beta in np.linspace(0.0, 1.0, 1001):
        here = [interval for interval in tradeoff.intervals if interval.beta_min <= beta <= interval.beta_max]
        assert here
        for interval in here:
            assert cost(interval, beta) == pytest.approx(least(tradeoff, beta), rel=1e-9)


def test_no_beta_of_a_thousand_finds_a_cheaper_path(swept: Tradeoff) -> None:
    assert_optimal_on_a_grid(swept)


def test_nor_on_the_papers_scenario(solved: Plan, tmp_path: Path) -> None:
    save_roadmap(solved.roadmap, tmp_path / "r.npz")
    found = sweep(request=SweepRequest.from_options(roadmap=tmp_path / "r.npz"))
    assert_covers(found)
    assert_optimal_on_a_grid(found)


# edges that fail the second look


def edges_of(nodes: np.ndarray) -> set[tuple[int, int]]:
    return {(min(pair), max(pair)) for pair in itertools.pairwise(nodes.tolist())}


def test_an_edge_that_fails_is_removed_and_the_sweep_starts_over(
    swept: Tradeoff, again: SweepRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    bad = sorted(edges_of(swept.intervals[2].path_nodes) - edges_of(swept.intervals[0].path_nodes))[0]
    grown = []
    real = module.load_or_build_roadmap
    monkeypatch.setattr(module, "load_or_build_roadmap", lambda *more: grown.append(1) or real(*more))
    collide(monkeypatch, swept.roadmap, np.array([bad]))
    found = sweep(request=again)
    assert_covers(found)
    assert found.edges_removed == 1
    assert len(grown) == 1
    assert len(found.roadmap.edges) == len(swept.roadmap.edges) - 1
    assert all(bad not in edges_of(interval.path_nodes) for interval in found.intervals)
    save_roadmap(found.roadmap, tmp_path / "smaller.npz")
    assert outline(sweep(request=again.with_options(roadmap=tmp_path / "smaller.npz"))) == outline(found)


def test_when_every_way_fails_there_is_no_path(
    swept: Tradeoff, again: SweepRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    around = [(int(i), int(j)) for i, j in swept.roadmap.edges if j in swept.roadmap.goals or i in swept.roadmap.goals]
    collide(monkeypatch, swept.roadmap, np.array(around))
    found = sweep(request=again)
    assert (found.outcome, found.complete, found.intervals) == (Outcome.NO_PATH, False, ())
    assert found.edges_removed == len(around)
    found.save(tmp_path)
    assert (tmp_path / "sweep.csv").read_text().count("\n") == 1
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == found.roadmap.sha256


# interrupted


def after(reports: int, stage: str) -> Progress:
    """A progress that asks to stop after so many reports of a stage."""
    seen: list[str] = []
    return Progress(lambda name, done, total: seen.append(name), lambda: seen.count(stage) >= reports)


@pytest.mark.parametrize("steps", [1, 2, 3, 5])
def test_an_interrupted_sweep_keeps_what_is_proven(swept: Tradeoff, steps: int) -> None:
    part = sweep(request=swept.request, progress=after(steps, "beta"))
    assert (part.outcome, part.complete) == (Outcome.INTERRUPTED, False)
    assert outline(part) == outline(swept)[: len(part.intervals)], "only what is proven"
    assert len(part.intervals) < len(swept.intervals)


def test_each_interval_has_its_optimum_and_together_they_are_all_of_it(solved: Plan) -> None:
    assert solved.layered is not None
    layered = solved.layered
    shown = add_alternatives(solved).alternatives
    ends = [path.interval for path in shown if path.interval]
    assert (ends[0][0], ends[-1][1]) == (0.0, 1.0)
    assert [low for low, _ in ends[1:]] == pytest.approx([high for _, high in ends[:-1]])
    for path, (low, high) in zip(shown, ends, strict=True):
        beta = 0.5 * (low + high)
        x = gabf.oracle(at_beta(layered.network, beta))
        assert path.costs is not None
        omega, distance = path.costs
        assert (1 - beta) * omega + beta * distance == pytest.approx(x[layered.starts].min(), rel=1e-9)
        np.testing.assert_allclose(path.path[0], solved.path[0], atol=1e-12)
