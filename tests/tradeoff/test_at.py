"""A plan at any beta of a sweep: the interval's path and motion, boundaries, the knee, and a sweep read back."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import FileError, OptionError
from planner.collision import make_checker
from planner.collision.recheck import sample_contacts
from planner.planning.plan import plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, SweepRequest
from planner.tradeoff.envelope import find_knee, front_shares
from planner.tradeoff.result import Tradeoff
from planner.tradeoff.sweep import sweep
from planner.trajectory.trajectory import Trajectory
from tests.random_shapes import QUICK

WORLDS = [("iiwa14", "paper"), ("panda", "shelf")]


@pytest.fixture(scope="module", params=WORLDS, ids=lambda world: "-".join(world))
def made(request: pytest.FixtureRequest) -> Tradeoff:
    robot, scene = request.param
    return sweep(request=SweepRequest.from_options(robot=robot, scene=scene, nodes=150, seed=1, refinement_rounds=4))


def test_a_plan_has_the_path_of_its_interval_at_its_cost(made: Tradeoff) -> None:
    assert len(made.intervals) > 1
    for item in made.intervals:
        found = made.at(item.beta)
        assert found.solved
        assert item.beta_min < item.beta < item.beta_max
        np.testing.assert_array_equal(found.path, item.path)
        assert found.cost is not None
        assert found.cost.total == (1 - item.beta) * item.manipulability_cost + item.beta * item.distance_cost
        assert found.cost_to_go is not None
        assert found.layered is not None
        start = found.path_nodes[0]
        assert found.layered.on_roadmap(found.cost_to_go.x)[start] == pytest.approx(found.cost.total, rel=1e-9)
        assert found.goal == "goal"
        record = found.record
        assert record.trajectory is not None
        assert record.trajectory.duration == item.duration
        assert item.clearance == min(near.min for near in (record.clearance.path, record.clearance.motion))


def test_each_motion_is_proven_and_the_other_library_finds_no_contact(made: Tradeoff) -> None:
    judge = make_checker(made.robot, made.scene, "coal")
    for item in made.intervals:
        motion = made.at(item.beta).trajectory
        assert motion is item.trajectory
        assert motion is not None
        assert motion.proven
        assert sample_contacts(judge, motion.coefficients, 1e-3) is None
        np.testing.assert_allclose(motion.at(motion.times[[0, -1]]), item.path[[0, -1]], atol=1e-9)


@pytest.mark.parametrize(("robot", "scene"), WORLDS)
def test_a_plan_costs_no_more_than_the_path_of_the_sweep(robot: str, scene: str) -> None:
    """For 20 seeds and the whole roadmap: python -m benchmarks tradeoff."""
    options = {"robot": robot, "scene": scene, "nodes": 150, "refinement_rounds": 4}
    whole = sweep(request=SweepRequest.from_options(**options), timing=None)
    for beta in (0.0, 0.2, 0.5, 0.85):
        alone, swept = plan(request=PlanRequest.from_options(**options, beta=beta), timing=None), whole.at(beta)
        assert alone.cost is not None
        assert swept.cost is not None
        assert alone.roadmap.scale == swept.roadmap.scale
        assert alone.cost.total <= (1 + 1e-12) * swept.cost.total


def test_where_two_intervals_meet_the_shorter_path_is_taken(swept: Tradeoff) -> None:
    for left, right in itertools.pairwise(swept.intervals):
        found = swept.at(left.beta_max)
        np.testing.assert_array_equal(found.path, right.path)
        assert right.distance_cost < left.distance_cost
        assert "takes the shorter one" in found.record.notes[-1]
        assert found.cost is not None
        assert found.cost.total == pytest.approx(left.at(left.beta_max), rel=1e-9)
    assert not any(swept.at(beta).end_notes for beta in (0.0, 0.001, 1.0))


def test_a_beta_without_a_path(swept: Tradeoff) -> None:
    part = replace(swept, intervals=swept.intervals[:1], complete=False, outcome=Outcome.INTERRUPTED)
    assert part.at(0.0).solved
    assert (part.at(1.0).outcome, len(part.at(1.0).path)) == (Outcome.INTERRUPTED, 0)
    assert part.knee is None
    for beta in (-0.1, 1.1):
        with pytest.raises(OptionError, match="beta"):
            swept.at(beta)


@QUICK
@given(st.lists(st.tuples(st.floats(0.01, 1), st.floats(0.01, 1)), min_size=2, max_size=8))
def test_the_knee_is_farthest_from_the_chord(steps: list[tuple[float, float]]) -> None:
    """Against the distance from a line through two points; a front is convex, and Omega grows as D falls."""
    slopes = sorted(steps, key=lambda step: step[0] / step[1])
    costs = np.cumsum([(1.0, 10.0), *((omega, -d) for omega, d in slopes)], axis=0)
    shares = front_shares(costs)
    assert shares[0].tolist() == [1.0, 1.0]
    assert shares[-1].tolist() == [0.0, 0.0]
    assert (np.diff(shares, axis=0) <= 0).all()
    scaled = (costs - costs.min(axis=0)) / np.ptp(costs, axis=0)
    chord = (scaled[-1] - scaled[0]) / np.linalg.norm(scaled[-1] - scaled[0])
    apart = np.abs(chord[0] * (scaled - scaled[0])[:, 1] - chord[1] * (scaled - scaled[0])[:, 0])
    knee = find_knee([(gain, added) for gain, added in shares.tolist()])
    assert knee is not None
    assert apart[knee] == pytest.approx(apart.max(), abs=1e-9)


def test_a_sweep_comes_back_from_its_folder(swept: Tradeoff, tmp_path: Path) -> None:
    (tmp_path / "trajectory-99.json").write_text("{}")
    swept.save(tmp_path)
    assert not (tmp_path / "trajectory-99.json").exists(), "of an earlier sweep"
    back = Tradeoff.load(tmp_path)
    assert [item.record("") for item in back.intervals] != []
    for old, new in zip(swept.intervals, back.intervals, strict=True):
        assert old.record("").to_dict() == new.record("").to_dict()
        assert old.trajectory is not None
        assert new.trajectory is not None
        np.testing.assert_array_equal(old.trajectory.times, new.trajectory.times)
    ours, theirs = swept.at(0.3).to_dict(), back.at(0.3).to_dict()
    different = {"timings_s", "config"}
    assert {key: ours[key] for key in ours.keys() - different} == {key: theirs[key] for key in ours.keys() - different}
    back.save(tmp_path / "again")
    assert Trajectory.load(tmp_path / "again" / "trajectory-1.json").duration == swept.intervals[0].duration


def test_a_folder_that_does_not_fit_is_refused(swept: Tradeoff, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"sweep .*sweep.json not found"):
        Tradeoff.load(tmp_path)
    swept.save(tmp_path)
    record = json.loads((tmp_path / "sweep.json").read_text())
    (tmp_path / "sweep.json").write_text(json.dumps(record | {"intervals": record["intervals"][1:]}))
    with pytest.raises(FileError, match="other paths than its roadmap gives now: sweep again"):
        Tradeoff.load(tmp_path)
