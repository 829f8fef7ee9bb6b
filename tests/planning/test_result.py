"""The files of plans of every outcome: whole or not there, read again, and copied with everything in memory."""

import copy
import errno
import json
import os
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.base.errors import FileError, PlannerError
from planner.base.progress import Progress, Stopwatch
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.options import Backend
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, TimingRequest
from planner.roadmap.storage import load_roadmap
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.tasks.check import check
from planner.trajectory.measure import path_manipulability, tool_path_length
from planner.trajectory.timing import time_path
from tests.planning.records import as_written

TINY = PlanRequest.from_options(robot="planar_2r", scene="empty", start="q:0,1", goal="q:1,1", nodes=20)


def test_the_record_holds_the_measures_of_the_plan(solved: Plan) -> None:
    record = solved.to_dict()
    assert (record["outcome"], record["message"]) == ("solved", Outcome.SOLVED.value)
    assert (record["robot"], record["scene"], record["seed"]) == ("iiwa14", "paper", 0)
    np.testing.assert_array_equal(record["path"], solved.path)
    assert record["path_nodes"] == solved.path_nodes.tolist()
    w = path_manipulability(solved.robot, solved.path)
    assert (record["manipulability"]["min"], record["manipulability"]["mean"]) == (w.min(), w.mean())
    worst = record["conditioning"]
    assert worst["w_min"] == w.min()
    assert worst["poor"] == (w.min() < 0.1 * worst["typical"]) == ("conditioning" in dict(solved.record.rows))
    assert record["path_length"]["workspace"] == tool_path_length(solved.robot, solved.path)
    roadmap = record["roadmap"]
    assert (roadmap["nodes"], roadmap["edges"]) == (150, len(solved.roadmap.edges))
    assert roadmap["edges_certified"] == roadmap["edges"]
    assert roadmap["sha256"] == solved.roadmap.sha256
    assert record["gabf"]["max_error_vs_oracle"] == 0.0
    assert record["gabf"]["settling_time"] < record["gabf"]["prescribed_time"]
    assert record["config"] == solved.request.config()


def test_the_files(solved: Plan, tmp_path: Path) -> None:
    folder, clock = tmp_path / "some" / "where", Stopwatch({"import": 0.5})
    record = solved.save_page(folder, solved.save_without_page(folder, clock), clock)
    assert json.loads((folder / "plan.json").read_text()) == json.loads(json.dumps(record.to_dict()))
    assert record.timings_s["import"] == 0.5
    assert {"setup", "roadmap", "costs", "gabf", "path", "files", "record", "page", "total"} <= set(record.timings_s)
    assert load_roadmap(folder / "roadmap.npz").sha256 == record.roadmap.sha256
    assert sorted(path.name for path in folder.iterdir()) == ["plan.html", "plan.json", "roadmap.npz"]
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be written"):
        solved.save(tmp_path / "file" / "no")


@pytest.mark.parametrize("name", ["roadmap.npz", "plan.json"])
def test_a_plan_that_cannot_be_written_leaves_the_one_that_is_there(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = (plan(request=TINY.with_options(seed=seed), timing=TimingRequest()) for seed in (0, 1))
    first.save(tmp_path, certificate=True)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    writes = iter(range(10))

    def full(handle: int) -> None:
        if next(writes) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr("planner.base.files.os.fsync", full)
        with pytest.raises(FileError, match=r"No space left on device; choose") as caught:
            second.save(tmp_path)
    assert "unfinished" not in str(caught.value)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    (tmp_path / name).unlink()
    (tmp_path / name).mkdir()
    with pytest.raises(FileError, match=f"{name} must be a file, got a folder"):
        second.save(tmp_path)
    left = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.name != name}
    assert left == {other: content for other, content in before.items() if other != name}


def test_interrupted_plans_and_those_without_a_path_are_saved_too(solved: Plan, tmp_path: Path) -> None:
    stopped = plan(request=TINY, progress=Progress(stop=lambda: True), timing=None)
    stopped.save(tmp_path)
    record = json.loads((tmp_path / "plan.json").read_text())
    assert record["outcome"] == "interrupted"
    assert [record[key] for key in ("cost", "manipulability", "gabf", "path_length")] == [None] * 4
    assert (record["path"], record["path_nodes"]) == ([], [])
    assert [name for name, _ in stopped.record.rows] == ["roadmap"]
    none = replace(solved, outcome=Outcome.NO_PATH, cost=None, path=np.zeros((0, 7)), path_nodes=solved.path_nodes[:0])
    none.save(tmp_path)
    record = json.loads((tmp_path / "plan.json").read_text())
    assert (record["outcome"], record["manipulability"]) == ("no_path", None)
    assert record["gabf"]["settling_time"] is not None
    names = {name for name, _ in none.record.rows}
    assert {"roadmap", "settled", "error against oracle"} <= names
    assert not {"cost", "path", "manipulability w"} & names


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_a_plan_can_be_copied_and_pickled(backend: Backend) -> None:
    """In memory, as processes exchange it; what it was made from comes along, and answers as before."""
    options: dict[str, Any] = {"scene": "window", "start": "start", "goal": "goal", "nodes": 60}
    found = plan(
        request=PlanRequest.from_options(robot="planar_2r", collision=backend, **options), timing=TimingRequest()
    )
    record, drawn, moved = found.to_dict(), found.page(), found.checker
    for other in (pickle.loads(pickle.dumps(found)), copy.copy(found), copy.deepcopy(found)):
        assert other.to_dict() == record
        assert other.page() == drawn
        assert other.robot.identity == found.robot.identity
        assert (other.checker.name, other.checker.world.margin) == (backend, moved.world.margin)
        again = time_path(other.path, other.checker)
        np.testing.assert_array_equal(again.coefficients, time_path(found.path, found.checker).coefficients)
        middle = 0.5 * (found.path[:-1] + found.path[1:])
        assert other.checker.first_contact(middle) == found.checker.first_contact(middle)


def assert_loaded(made: Plan, folder: Path, again: Path, **world: Any) -> Plan:
    """Load what ``made`` saved: the same, saved again to the same bytes, judged as before."""
    made.save(folder)
    found = Plan.load(folder, **world)
    assert as_written(found.to_dict()) == json.loads((folder / "plan.json").read_text())
    assert (found.outcome, found.message, found.goal, found.cost) == (made.outcome, made.message, made.goal, made.cost)
    assert (found.curve, found.clearance_kept, found.edges_removed) == (
        made.curve,
        made.clearance_kept,
        made.edges_removed,
    )
    assert found.request.config() == made.request.config()
    assert found.robot.identity == made.robot.identity
    np.testing.assert_array_equal(found.path, made.path)
    np.testing.assert_array_equal(found.path_nodes, made.path_nodes)
    assert (found.cost_to_go, found.layered, found.bounds) == (None, None, ())
    found.save(again)
    assert {each.name for each in again.iterdir()} == {each.name for each in folder.iterdir()}
    for name in {"roadmap.npz", "trajectory.json"} & {each.name for each in folder.iterdir()}:
        assert (again / name).read_bytes() == (folder / name).read_bytes()
    first, second = (json.loads((place / "plan.json").read_text()) | {"timings_s": 0} for place in (folder, again))
    assert first == second
    return found


def test_a_plan_is_loaded_as_it_was_saved(solved: Plan, tmp_path: Path) -> None:
    """With a motion and without, judged as the plan itself is; a proof of it is the same."""
    timed = plan(request=TINY)
    found = assert_loaded(timed, tmp_path / "timed", tmp_path / "again")
    assert timed.trajectory is not None
    assert found.trajectory is not None
    np.testing.assert_array_equal(found.trajectory.coefficients, timed.trajectory.coefficients)
    assert check(found).to_dict() == check(timed).to_dict()
    ours, theirs = timed.certify(), found.certify()
    assert ours is not None
    assert theirs is not None
    assert {name: array.tobytes() for name, array in ours.arrays.items()} == {
        name: array.tobytes() for name, array in theirs.arrays.items()
    }
    assert_loaded(solved, tmp_path / "path", tmp_path / "path again")
    assert isinstance(found.request, PlanRequest)
    again = plan(request=found.request, roadmap=tmp_path / "timed" / "roadmap.npz", timing=None)
    np.testing.assert_array_equal(again.path[[0, -1]], timed.path[[0, -1]])


def test_plans_without_a_path_among_moving_obstacles_and_of_objects_are_loaded(tmp_path: Path) -> None:
    boxes = [Box((0.02, 0.2, 0.2)), Box((0.02, 0.2, 0.2))]
    walls = (Obstacle(f"wall {k}", box, pose([0.0, 0.5 - k, 0.0])) for k, box in enumerate(boxes))
    wall = Scene("wall", tuple(walls))
    shut: dict[str, Any] = {"robot": "planar_2r", "scene": wall, "start": [0.0, 0.1], "goal": [3.0, 0.1], "nodes": 30}
    none = plan(**shut, timing=None)
    assert none.reason is not None
    found = assert_loaded(none, tmp_path / "none", tmp_path / "none again", scene=wall)
    assert found.reason == none.reason
    with pytest.raises(PlannerError, match="scene 'wall' not found"):
        Plan.load(tmp_path / "none")
    with pytest.raises(FileError, match="proven for another robot or scene"):
        Plan.load(tmp_path / "none", scene="empty")
    cart = MovingObstacle("cart", Box((0.1, 0.1, 0.1)), KnownMotion([0, 9], [pose([3.0, 0.0, 0.0])] * 2))
    moving = plan(request=TINY, scene=Scene("cart", moving=(cart,)))
    found = assert_loaded(moving, tmp_path / "moving", tmp_path / "moving again", scene=moving.scene)
    assert found.record.in_time is not None
    assert check(found).ok


def test_what_is_no_plan_is_not_loaded(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="not found"):
        Plan.load(tmp_path)
    plan(request=TINY).save(tmp_path)
    whole = json.loads((tmp_path / "plan.json").read_text())
    for change, words in (
        ({"path": "x"}, "path"),
        ({"format_version": 99}, "must be 1 to 1, got 99"),
        ({"cost": 3}, "cost"),
    ):
        (tmp_path / "plan.json").write_text(json.dumps(whole | change))
        with pytest.raises(FileError, match=words):
            Plan.load(tmp_path)
