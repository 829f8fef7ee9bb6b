"""Straight lines of the tool at a plan's ends: kept by path and motion, refused with the reason, by an own judge."""

import json
from pathlib import Path

import numpy as np
import pytest

from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.outcome import CannotFollow, Outcome
from planner.problem.request import TimingRequest
from planner.roadmap.storage import load_roadmap
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from tests.tool_paths.judge import line_of, outside, pose_of

DOWN = {"robot": "panda", "scene": "table", "start": "home", "goal": "xyz:0.45,0.2,0.9 & axis:z,0,0,-1"}


@pytest.fixture(scope="module")
def found() -> Plan:
    return plan(**DOWN, approach=0.1, retreat=0.05, path_only=True, timing=TimingRequest())


def leg_outside(found: Plan, length: float, at_end: bool) -> float:
    """By how much of a leg's tube, as its own judge sees it, the motion leaves it, where it is on it."""
    made, end = found.trajectory, found.path[-1 if at_end else 0]
    assert made is not None
    turn, position = pose_of(found.robot, end)
    line = line_of([position - length * turn[:, 2], position], quaternion=quaternion(turn))
    times = np.linspace(0, made.duration, 3000)
    q = made.at(times)
    tool = np.array([pose_of(found.robot, one)[1] for one in q])
    rest = int(np.linalg.norm(tool - line.positions[0], axis=1).argmin())
    assert np.linalg.norm(tool[rest] - line.positions[0]) < 2e-4
    return outside(line, found.robot, (q[rest:] if at_end else q[: rest + 1])[::4])


def quaternion(turn: np.ndarray) -> list[float]:
    import pinocchio as pin

    return pin.Quaternion(turn).coeffs().tolist()


def test_the_motion_keeps_to_both_lines(found: Plan, tmp_path: Path) -> None:
    assert found.outcome is Outcome.SOLVED
    assert found.trajectory is not None
    assert found.trajectory.proven
    assert leg_outside(found, 0.1, at_end=True) <= 1.0
    assert leg_outside(found, 0.05, at_end=False) <= 1.0
    assert found.goal == f"{DOWN['goal']},0"
    np.testing.assert_allclose(found.path[0], found.robot.home)
    found.save(tmp_path)
    record = json.loads((tmp_path / "plan.json").read_text())
    rows = dict(found.record.rows)
    assert rows["retreat"].startswith("0.05 m straight along the tool's z axis; path and motion at most 0.0")
    assert rows["approach"].endswith("proven within 1 mm and 0.0087 rad")
    said = record["legs"]
    assert [(leg["leg"], round(leg["length"], 9)) for leg in said] == [("retreat", 0.05), ("approach", 0.1)]
    assert all(0 < leg["largest_deviation"]["position"] <= leg["tube"]["position"] == 1e-3 for leg in said)
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == found.roadmap.sha256


def test_a_grown_roadmap_and_a_kept_one_serve_it(tmp_path: Path) -> None:
    grown = plan(**DOWN, nodes=60, refinement_rounds=1, approach=0.1, timing=None)
    assert grown.outcome is Outcome.SOLVED
    assert grown.max_error_vs_oracle == 0.0
    grown.save(tmp_path)
    kept = plan(**DOWN, roadmap=tmp_path / "roadmap.npz", approach=0.05, retreat=0.02, timing=None)
    assert kept.outcome is Outcome.SOLVED
    assert [leg.length for leg in kept.legs] == pytest.approx([0.02, 0.05])


def test_what_is_in_the_way_is_named_with_the_leg(tmp_path: Path) -> None:
    ceiling = Scene("low", (Obstacle("ceiling", Box((2.0, 2.0, 0.02)), pose([0.0, 0.0, 1.0])),))
    under = {
        "robot": "panda",
        "scene": ceiling,
        "start": "pose:0.45,-0.2,0.3,1,0,0,0",
        "goal": "pose:0.45,0.2,0.3,1,0,0,0",
    }
    assert plan(**under, path_only=True, timing=None).outcome is Outcome.SOLVED
    found = plan(**under, path_only=True, approach=0.5, timing=None)
    assert found.outcome is Outcome.NO_PATH
    assert isinstance(found.reason, CannotFollow)
    assert found.reason.leg == "approach"
    assert 0 < found.reason.followed < 1
    assert found.reason.cause in ("touching", "jump")
    assert found.message.startswith("The approach is possible over")
    found.save(tmp_path)
    assert json.loads((tmp_path / "plan.json").read_text())["reason"]["leg"] == "approach"
    far = plan(
        robot="panda", scene="empty", start="home", goal="xyz:0.4,0.2,0.6", path_only=True, retreat=1.0, timing=None
    )
    assert isinstance(far.reason, CannotFollow)
    assert far.reason.leg == "retreat"
