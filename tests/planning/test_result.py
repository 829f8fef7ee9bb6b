"""plan.json and the table: the contract's keys, from plans of every outcome."""

import copy
import errno
import itertools
import json
import os
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.base.progress import Progress, Stopwatch
from planner.planning import result
from planner.planning.plan import plan
from planner.planning.result import plan_record, save_plan
from planner.planning.summary import summary_rows
from planner.problem.options import Backend
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, TimingRequest
from planner.roadmap.simplify import TOLERANCE
from planner.roadmap.storage import load_roadmap
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.trajectory.measure import path_manipulability, tool_path_length
from planner.trajectory.timing import time_path

CONTRACT = {
    "": {"outcome", "robot", "scene", "seed", "config", "versions", "path", "path_nodes", "cost", "manipulability"}
    | {"roadmap", "gabf", "quality", "timings_s"},
    "quality": {"effort", "curve", "lower_bound", "gap", "manipulability_cost", "corners"},
    "cost": {"total", "manipulability", "distance", "beta"},
    "manipulability": {"min", "mean"},
    "roadmap": {"nodes", "edges", "components", "edges_certified", "sha256"},
    "gabf": {
        "law",
        "prescribed_time",
        "settling_time",
        "settling_tau",
        "settling_tau_bracket",
        "steps",
        "max_error_vs_oracle",
        "certificate",
    },
}


@pytest.mark.parametrize("part", CONTRACT)
def test_the_contracts_keys(solved, part):
    record = plan_record(solved)
    assert CONTRACT[part] <= set(record[part] if part else record)


def test_what_the_keys_hold(solved):
    record = plan_record(solved)
    assert record["outcome"] == "solved"
    assert record["message"] == Outcome.SOLVED.value
    assert (record["robot"], record["scene"], record["seed"]) == ("iiwa14", "paper", 0)
    np.testing.assert_array_equal(record["path"], solved.path)
    assert record["path_nodes"] == solved.path_nodes.tolist()
    w = path_manipulability(solved.robot, solved.path)
    assert record["manipulability"]["min"] == w.min()
    assert record["manipulability"]["mean"] == w.mean()
    worst = record["conditioning"]
    assert worst["w_min"] == w.min()
    assert worst["poor"] == (w.min() < 0.1 * worst["typical"]) == ("conditioning" in dict(summary_rows(record)))
    assert record["path_length"]["workspace"] == tool_path_length(solved.robot, solved.path)
    roadmap = record["roadmap"]
    assert (roadmap["nodes"], roadmap["edges"]) == (150, len(solved.roadmap.edges))
    assert roadmap["edges_certified"] == roadmap["edges"]
    assert roadmap["sha256"] == solved.roadmap.sha256
    assert set(roadmap["scale"]) == {"w_low", "w_high", "joint_length", "tool_length", "zeta"}
    assert record["gabf"]["max_error_vs_oracle"] == 0.0
    assert record["gabf"]["settling_time"] < record["gabf"]["prescribed_time"]
    assert record["config"]["nodes"] == 150


def test_the_bound_and_the_curve():
    solved = plan(PlanRequest.from_options(nodes=150, seed=2))  # whose first path leaves much to refine
    quality, cost = plan_record(solved)["quality"], solved.cost
    assert cost is not None
    roadmap = solved.roadmap
    apart = [np.linalg.norm(roadmap.nodes[goal] - solved.path[0]) for goal in roadmap.goals]
    share = 0.5 + 0.5 * roadmap.scale.zeta
    assert quality["lower_bound"] == pytest.approx(share * min(apart) / roadmap.scale.joint_length)
    assert quality["lower_bound"] <= cost.total
    assert quality["gap"] == pytest.approx(cost.total / quality["lower_bound"] - 1.0)
    costs = [point["cost"] for point in quality["curve"]]
    assert len(costs) == 1 + quality["effort"] == 1 + solved.request.quality.rounds
    # fewer corners may cost a bit
    assert all(later <= (1.0 + TOLERANCE) * before for before, later in itertools.pairwise(costs))
    assert cost.total < 0.9 * costs[0]


def test_the_files(solved, tmp_path):
    record = save_plan(solved, tmp_path, Stopwatch({"import": 0.5}))
    assert json.loads((tmp_path / "plan.json").read_text()) == json.loads(json.dumps(record))
    assert record["timings_s"]["import"] == 0.5
    assert {"setup", "roadmap", "costs", "gabf", "path", "files", "settling", "page", "total"} <= set(
        record["timings_s"]
    )
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == record["roadmap"]["sha256"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan.html", "plan.json", "roadmap.npz"]


def test_the_total_is_the_sum_of_the_stages_where_nothing_else_takes_time(tmp_path, monkeypatch):
    """The clock moves only in the certificate of settling, in the motion's file and on the page."""
    found, now = plan(robot="planar_2r", scene="empty", start="q:0,1", nodes=20), [0.0]

    def taking(seconds, work):
        def slow(*given):
            now[0] += seconds
            return work(*given)

        return slow

    monkeypatch.setattr("planner.base.progress.time.perf_counter", lambda: now[0])
    monkeypatch.setattr(result.gabf, "certify", taking(100.0, result.gabf.certify))
    monkeypatch.setattr(result, "save_parts", taking(10.0, result.save_parts))
    monkeypatch.setattr(result, "plan_page", taking(1.0, result.plan_page))
    timings = save_plan(replace(found, timings={"gabf": 0.25}), tmp_path)["timings_s"]
    assert timings == {"gabf": 0.25, "files": 10.0, "settling": 100.0, "record": 0.0, "page": 1.0, "total": 111.25}


@pytest.mark.parametrize("name", ["roadmap.npz", "trajectory.json", "proof.npz", "plan.html", "plan.json"])
def test_a_plan_that_cannot_be_written_leaves_the_one_that_is_there(name, tmp_path, monkeypatch):
    request = PlanRequest.from_options(robot="planar_2r", scene="empty", start="q:0,1", goal="q:1,1", nodes=20)
    first, second = (plan(request.with_options(seed=seed), timing=TimingRequest()) for seed in (0, 1))
    save_plan(first, tmp_path, certificate=True)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    writes = iter(range(10))

    def full(handle):
        if next(writes) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr("planner.base.files.os.fsync", full)
        with pytest.raises(FileError, match=r"No space left on device; choose") as caught:
            save_plan(second, tmp_path)
    assert "unfinished" not in str(caught.value)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    (tmp_path / name).unlink()
    (tmp_path / name).mkdir()
    with pytest.raises(FileError, match=f"{name} is a folder"):
        save_plan(second, tmp_path)
    left = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.name != name}
    assert left == {other: content for other, content in before.items() if other != name}


def test_a_folder_that_is_not_there(solved, tmp_path):
    solved.save(tmp_path / "some" / "where")
    assert (tmp_path / "some" / "where" / "plan.json").is_file()
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be made"):
        solved.save(tmp_path / "file" / "no")


def test_interrupted_plans_are_saved_too(tmp_path):
    request = PlanRequest.from_options(robot="planar_2r", scene="empty", start="q:0,1", goal="q:1,1", nodes=20)
    found = plan(request, progress=Progress(stop=lambda: True))
    record = save_plan(found, tmp_path)
    assert record["outcome"] == "interrupted"
    assert [record[key] for key in ("cost", "manipulability", "gabf", "path_length")] == [None] * 4
    assert (record["path"], record["path_nodes"]) == ([], [])
    assert json.loads((tmp_path / "plan.json").read_text())["outcome"] == "interrupted"
    assert [name for name, _ in summary_rows(record)] == ["roadmap"]


def test_no_path_is_saved_too(solved, tmp_path):
    found = replace(solved, outcome=Outcome.NO_PATH, cost=None, path=np.zeros((0, 7)), path_nodes=solved.path_nodes[:0])
    record = save_plan(found, tmp_path)
    assert record["outcome"] == "no_path"
    assert record["gabf"]["settling_time"] is not None
    assert record["manipulability"] is None
    names = [name for name, _ in summary_rows(record)]
    assert {"roadmap", "settled", "error against oracle"} <= set(names)
    assert not {"cost", "path", "manipulability w"} & set(names)


def test_the_table(solved):
    rows = dict(summary_rows(plan_record(solved)))
    assert {"roadmap", "cost", "manipulability w", "path", "settled", "error against oracle"} <= set(rows)
    assert "150 nodes" in rows["roadmap"]
    assert solved.cost is not None
    assert f"{solved.cost.total:.4f} = 0.5 x {solved.cost.manipulability:.4f} manipulability" in rows["cost"]
    assert "of T_p = 4 s" in rows["settled"]
    assert rows["error against oracle"].startswith("0.0e+00")
    assert f"{len(solved.path)} waypoints" in rows["path"]


def test_a_field_that_did_not_settle_says_so(solved):
    record = plan_record(solved)
    record["gabf"]["settling_time"] = None
    assert dict(summary_rows(record))["settled"] == "not within the budget"


@pytest.mark.parametrize("outcome", list(Outcome))
def test_outcomes_are_sentences_with_keys_and_codes(outcome):
    assert outcome.value.endswith(".")
    assert outcome.key == outcome.name.lower()
    codes = {"solved": 0, "no_path": 4, "too_singular": 4, "partly_followed": 4, "interrupted": 130}
    assert outcome.exit_code == codes[outcome.key]


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_a_plan_can_be_copied_and_pickled(backend: Backend) -> None:
    """In memory, as processes exchange it; what it was made from comes along, and answers as before."""
    options: dict[str, Any] = {"scene": "window", "start": "start", "goal": "goal", "nodes": 60}
    found = plan(PlanRequest.from_options(robot="planar_2r", collision=backend, **options), timing=TimingRequest())
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


def test_a_plan_that_failed_and_one_with_meshes_can_be_pickled() -> None:
    found = plan(PlanRequest.from_options(robot="panda", scene="shelf", nodes=12, effort=0))
    other = pickle.loads(pickle.dumps(found))
    assert other.to_dict() == found.to_dict()
    assert other.checker.first_contact(found.path) is None
    wall = Scene("shut", (Obstacle("wall", Box((0.02, 2.0, 0.2)), pose([0.6, 0, 0])),))
    failed = plan(
        PlanRequest.from_options(robot="planar_2r", scene=wall, start=[1.2, 1.0], goal=[-1.2, -1.0], nodes=20, effort=0)
    )
    assert pickle.loads(pickle.dumps(failed)).to_dict() == failed.to_dict()
