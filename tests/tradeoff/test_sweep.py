"""The sweep of a robot's roadmap: against the oracle on a grid, edges that fail, interrupted sweeps, files."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planner.tradeoff.sweep as module
from planner import gabf
from planner.base.errors import FileError, OptionError
from planner.base.progress import Progress
from planner.paths.measure import joint_path_length, path_contact, path_manipulability, tool_path_length
from planner.planning.healing import HealingNetwork
from planner.planning.network import build_network, path_cost
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, SweepRequest
from planner.roadmap.roadmap import path_waypoints
from planner.roadmap.storage import load_roadmap, save_roadmap
from planner.tradeoff.record import read_checkpoint, save_sweep, summary_lines, sweep_record
from planner.tradeoff.sweep import Interval, Tradeoff, range_text, reached_by_beta, sweep
from tests.random_shapes import QUICK
from tests.tradeoff.posts import asked


def least(tradeoff: Tradeoff, beta: float) -> float:
    """The least cost from a start by the oracle."""
    request, roadmap = tradeoff.request, tradeoff.roadmap
    network = build_network(roadmap, request.objective_at(beta))
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
    found = sweep(SweepRequest(roadmap=tmp_path / "r.npz"))
    assert_covers(found)
    assert_optimal_on_a_grid(found)


@pytest.mark.parametrize("law", ["nominal", "prescribed-time", "fixed-time"])
def test_every_law_finds_the_same(swept: Tradeoff, again: SweepRequest, law: Any) -> None:
    assert outline(sweep(replace(again, law=law))) == outline(swept)


def test_a_plan_at_any_beta_takes_the_path_of_its_interval(swept: Tradeoff, again: SweepRequest) -> None:
    for interval in swept.intervals[::2]:
        beta = 0.5 * (interval.beta_min + interval.beta_max)
        alone = plan(PlanRequest(**vars(again), beta=beta))
        np.testing.assert_array_equal(alone.path, interval.path)


@pytest.mark.parametrize("option", [{"metric": "workspace"}, {"manipulability_cost": "inverse"}])
def test_other_costs_have_other_intervals(swept: Tradeoff, again: SweepRequest, option: dict[str, Any]) -> None:
    other = sweep(replace(again, **option))
    assert_covers(other)
    assert outline(other) != outline(swept)
    assert cost(other.intervals[1], other.intervals[1].beta_max) == pytest.approx(
        least(other, other.intervals[1].beta_max), rel=1e-12
    )


# the front


def test_the_front_holds_every_interval_and_what_lies_between(swept: Tradeoff) -> None:
    front = swept.front
    assert front is not None
    assert front.complete
    reached = reached_by_beta(front.points, swept.intervals)
    lines = np.array([(i.manipulability_cost, i.distance_cost) for i in swept.intervals])
    np.testing.assert_allclose(front.points[reached], lines, rtol=1e-12)
    assert 0 < (~reached).sum() == len(front.points) - len(lines)
    for beta in np.linspace(0.0, 1.0, 101):
        assert ((front.points[~reached] @ [1.0 - beta, beta]) > least(swept, beta) * (1.0 + 1e-9)).all()
    assert (np.diff(front.points[:, 0]) > 0).all()
    assert (np.diff(front.points[:, 1]) < 0).all()
    network = build_network(swept.roadmap, 0.5)
    for nodes, point in zip(front.paths, front.points, strict=True):
        found = path_cost(network, nodes)
        np.testing.assert_allclose([found.manipulability, found.distance], point, rtol=1e-12)
        assert path_contact(swept.checker, path_waypoints(swept.roadmap, swept.robot, nodes)) is None


def test_which_points_a_beta_reaches(swept: Tradeoff) -> None:
    a, b = swept.intervals[:2]
    middle = np.array([[(x + y) / 2 for x, y in ((a.manipulability_cost, b.manipulability_cost),
                                                 (a.distance_cost, b.distance_cost))]])  # fmt: skip
    points = np.vstack([middle, middle + 1e-6, [[a.manipulability_cost, a.distance_cost + 0.5]]])
    # on the hull at one beta; just above it; as little Omega as the first, so optimal at beta = 0
    assert reached_by_beta(points, swept.intervals).tolist() == [True, False, True]


def test_a_front_that_is_cut_says_so(again: SweepRequest, tmp_path: Path) -> None:
    found = sweep(again, front=True, max_labels=60)
    assert found.front is not None
    assert (found.outcome, found.complete, found.front.complete) == (Outcome.SOLVED, True, False)
    record = save_sweep(found, tmp_path)
    assert record["front"]["complete"] is False
    assert any("stopped after" in line and "there may be more" in line for line in summary_lines(record))
    with pytest.raises(OptionError, match="0 labels make no search"):
        sweep(again, front=True, max_labels=0)


# edges that fail the second look


def failing(monkeypatch: pytest.MonkeyPatch, edges: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """These edges fail; returns the list of edges that were looked at."""
    seen: list[tuple[int, int]] = []

    def look(healing: HealingNetwork, asked: list[tuple[int, int]]) -> int:
        first = next((k for k, (i, j) in enumerate(asked) if (min(i, j), max(i, j)) in edges), len(asked))
        seen.extend(asked[: first + 1])
        return first

    monkeypatch.setattr(HealingNetwork, "_first_contact", look)
    return seen


def edges_of(nodes: np.ndarray) -> set[tuple[int, int]]:
    return {(min(pair), max(pair)) for pair in itertools.pairwise(nodes.tolist())}


def test_an_edge_that_fails_is_removed_and_the_sweep_starts_over(
    swept: Tradeoff, again: SweepRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    bad = sorted(edges_of(swept.intervals[2].path_nodes) - edges_of(swept.intervals[0].path_nodes))[0]
    grown = []
    real = module.obtain_roadmap
    monkeypatch.setattr(module, "obtain_roadmap", lambda *more: grown.append(1) or real(*more))
    seen = failing(monkeypatch, [bad])
    found = sweep(again)
    assert_covers(found)
    assert found.edges_removed == 1
    assert len(grown) == 1
    assert len(found.roadmap.edges) == len(swept.roadmap.edges) - 1
    assert all(bad not in edges_of(interval.path_nodes) for interval in found.intervals)
    assert len({frozenset(edge) for edge in seen}) == len(seen), "no edge is looked at twice"
    save_roadmap(found.roadmap, tmp_path / "smaller.npz")
    assert outline(sweep(replace(again, roadmap=tmp_path / "smaller.npz"))) == outline(found)


def test_an_edge_of_the_front_that_fails_is_removed_too(
    swept: Tradeoff, again: SweepRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert swept.front is not None
    used = set().union(*(edges_of(interval.path_nodes) for interval in swept.intervals))
    bad = sorted(set().union(*map(edges_of, swept.front.paths)) - used)[0]
    failing(monkeypatch, [bad])
    found = sweep(again, front=True)
    assert found.front is not None
    assert found.edges_removed == 1
    assert outline(found) == outline(swept)
    assert all(bad not in edges_of(nodes) for nodes in found.front.paths)


def test_when_every_way_fails_there_is_no_path(
    swept: Tradeoff, again: SweepRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    around = [(int(i), int(j)) for i, j in swept.roadmap.edges if j in swept.roadmap.goals or i in swept.roadmap.goals]
    failing(monkeypatch, around)
    found = sweep(again, front=True)
    assert (found.outcome, found.complete, found.front, found.intervals) == (Outcome.NO_PATH, False, None, ())
    assert found.edges_removed == len(around)
    record = save_sweep(found, tmp_path)
    assert (record["outcome"], record["intervals"], record["front"]) == ("no_path", [], None)
    assert (tmp_path / "sweep.csv").read_text().count("\n") == 1
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == record["roadmap"]["sha256"]
    assert sweep(again, earlier=read_checkpoint(again, tmp_path)).outcome is Outcome.NO_PATH


# interrupted, and gone on with


def after(reports: int, stage: str) -> Progress:
    """A progress that asks to stop after so many reports of a stage."""
    seen: list[str] = []
    return Progress(lambda name, done, total: seen.append(name), lambda: seen.count(stage) >= reports)


@pytest.mark.parametrize("steps", [1, 2, 3, 5])
def test_an_interrupted_sweep_goes_on(swept: Tradeoff, tmp_path: Path, steps: int) -> None:
    part = sweep(swept.request, after(steps, "beta"))
    assert (part.outcome, part.complete) == (Outcome.INTERRUPTED, False)
    assert outline(part) == outline(swept)[: len(part.intervals)], "only what is proven"
    assert len(part.intervals) < len(swept.intervals)
    record = save_sweep(part, tmp_path)
    assert record["complete"] is False
    rest = sweep(swept.request, front=True, earlier=read_checkpoint(swept.request, tmp_path))
    assert_covers(rest)
    whole, mended = (sweep_record(found) for found in (swept, rest))
    changes = {key for key in whole if whole[key] != mended[key]}
    assert changes <= {"timings_s", "solves"}
    for a, b in zip(rest.intervals, swept.intervals, strict=True):
        np.testing.assert_array_equal(a.cost_to_go.x, b.cost_to_go.x)


def test_some_of_these_interruptions_hold_intervals(swept: Tradeoff) -> None:
    words: list[str] = []
    sweep(swept.request, Progress(lambda stage, done, total: words.append(stage)))
    part = sweep(swept.request, after(words.count("beta") - 1, "beta"))
    assert len(part.intervals) >= 1
    lines = summary_lines(sweep_record(part))
    assert any(f"Proven up to beta = {part.intervals[-1].beta_max:.5g}" in line for line in lines)


def test_going_on_grows_nothing_and_can_be_interrupted_again(
    swept: Tradeoff, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    request = swept.request
    first = save_sweep(sweep(request, after(7, "beta")), tmp_path)
    monkeypatch.setattr(module, "obtain_roadmap", lambda *more: pytest.fail("the roadmap was grown again"))
    second = sweep(request, progress=Progress(stop=lambda: True), earlier=read_checkpoint(request, tmp_path))
    assert second.outcome is Outcome.INTERRUPTED
    assert sweep_record(second)["search"] == first["search"], "nothing is lost"
    save_sweep(second, tmp_path)
    third = sweep(request, earlier=read_checkpoint(request, tmp_path))
    assert outline(third) == outline(swept)
    save_sweep(third, tmp_path)
    calls: list[int] = []
    real = gabf.solve
    monkeypatch.setattr(gabf, "solve", lambda net, **more: calls.append(1) or real(net, **more))
    fourth = sweep(request, earlier=read_checkpoint(request, tmp_path))
    assert outline(fourth) == outline(swept)
    assert len(calls) == len(fourth.found), "one field a path, no search"


def test_a_roadmap_that_was_interrupted_is_grown_anew(swept: Tradeoff, tmp_path: Path) -> None:
    request = swept.request
    part = sweep(request, after(30, "roadmap"))
    assert (part.outcome, part.grown, part.intervals) == (Outcome.INTERRUPTED, False, ())
    assert 2 < len(part.roadmap.nodes) < 150
    save_sweep(part, tmp_path)
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == part.roadmap.sha256
    assert outline(sweep(request, earlier=read_checkpoint(request, tmp_path))) == outline(swept)


def test_a_front_that_is_interrupted_leaves_the_intervals_whole(again: SweepRequest) -> None:
    found = sweep(again, after(1, "front"), front=True)
    assert found.front is not None
    assert (found.outcome, found.complete, found.front.complete) == (Outcome.INTERRUPTED, True, False)


def test_edges_removed_are_counted_on(again: SweepRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    whole = sweep(again)
    one = min(edges_of(whole.intervals[0].path_nodes))
    failing(monkeypatch, [one])
    save_sweep(sweep(again, after(4, "beta")), tmp_path)
    failing(monkeypatch, [one, max(edges_of(whole.intervals[-1].path_nodes))])
    found = sweep(again, earlier=read_checkpoint(again, tmp_path))
    assert found.edges_removed == 2


# what does not belong


def refused(request: SweepRequest, folder: Path, text: str) -> None:
    before = {path: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(FileError, match=text) as caught:
        sweep(request, earlier=read_checkpoint(request, folder))
    assert str(caught.value).endswith(".")
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_a_world_that_has_changed_is_refused(tmp_path: Path) -> None:
    request = asked(tmp_path)
    save_sweep(sweep(request, after(4, "beta")), tmp_path)
    asked(tmp_path, start="q:-1.1,0.8")  # the scene's file again, with another start
    refused(request, tmp_path, "has another start than is asked for now")
    text = str(asked(tmp_path).scene)
    Path(text).write_text(Path(text).read_text().replace("0.75", "0.74"))
    refused(request, tmp_path, "is for a scene 'post' with other obstacles")


# files


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (0.0, 0.238, "0 to 0.238"),
        (0.99979, 1.0, "0.99979 to 1"),
        (0.9999999991, 1.0, "0.9999999991 to 1"),
        (0.25, 0.25, "0.25 to 0.25"),
        (0.12345678, 0.5, "0.123 to 0.5"),
        (0.4794, 0.47941, "0.4794 to 0.47941"),
    ],
)
def test_intervals_in_words_have_two_ends(low: float, high: float, text: str) -> None:
    assert range_text(low, high) == text


@QUICK
@given(st.floats(0, 1), st.floats(0, 1))
def test_intervals_in_words_are_true(low: float, high: float) -> None:
    low, high = sorted((low, high))
    first, last = range_text(low, high).split(" to ")
    apart = high - low
    allowed = max(0.1 * apart, 5.1e-13) if apart else 5.1e-4
    assert abs(float(first) - low) <= allowed
    assert abs(float(last) - high) <= allowed
    assert first != last or apart < 1e-11
