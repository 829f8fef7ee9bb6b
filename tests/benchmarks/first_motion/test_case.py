"""One run: our motion, OMPL's path, and what another Python answers, which is looked at whatever it says of itself."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.first_motion import case
from benchmarks.first_motion.case import _FirstPath, main, measure
from benchmarks.first_motion.report import OMPL, OURS, ROBOPLAN, WHOLE
from planner.batch.outcomes import NO_PATH, REFUSED, SOLVED
from planner.collision import make_checker
from planner.planning.plan import plan
from planner.problem.request import LimitsRequest, PlanRequest
from planner.sampling.first_path import FIRST_PATH
from tests.worlds import load, planar_trap

POST = "obstacles: [{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}]\n"
AROUND = [[-1.0, 0.8], [-1.0, 2.5], [1.0, 2.5], [1.0, -0.8]]
STRAIGHT = [AROUND[0], AROUND[-1]]
OTHER = "pyroboplan"
LIMITS = LimitsRequest(acceleration=15.0, jerk=500.0)


@pytest.fixture
def around_post(tmp_path: Path) -> PlanRequest:
    (tmp_path / "post.yaml").write_text(POST)
    scene = str(tmp_path / "post.yaml")
    return PlanRequest("planar_2r", scene, start="q:-1.0,0.8", goal="q:1.0,-0.8", collision="coal", path_only=True)


def python_that(folder: Path, says: str) -> str:
    """A Python of another environment, which runs ``says`` in place of the runner."""
    file = folder / "python"
    file.write_text(
        f"#!{sys.executable}\nimport json, sys\n_, isolated, runner, method, problem, answer = sys.argv\n"
        "problem = json.load(open(problem))\n"
        f"def reply(**found): json.dump(found, open(answer, 'w'))\n{says}\n"
    )
    file.chmod(0o755)
    return str(file)


@pytest.mark.parametrize("method", [OURS, WHOLE, OMPL])
def test_a_path_is_found_and_looked_at(method: str, around_post: PlanRequest) -> None:
    columns = measure(method, "", around_post, LIMITS, 30.0)
    assert columns["outcome"] == SOLVED, columns
    assert columns["length_rad"] > np.hypot(2.0, 1.6)
    assert 0 < columns["first_s"] <= columns["path_s"]
    assert columns["corners"] >= 1
    assert columns["contacts"] == 0 or method == OMPL
    assert columns["version"]
    assert columns["proven"] == (method != OMPL)


def test_our_motion_is_measured_after_the_same_robot_was_planned_with(
    around_post: PlanRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr(case, "plan", lambda *args, **more: asked.append(args[0]) or plan(*args, **more))
    columns = measure(OURS, "", around_post, LIMITS, 1.0)
    warm, measured = asked
    assert warm.robot is measured.robot
    assert (warm.scene.name, warm.scene.obstacles, len(measured.scene.obstacles)) == ("empty", (), 1)
    assert (measured.start, measured.goal) == ("q:-1.0,0.8", "q:1.0,-0.8")
    whole = columns["ready_s"] + columns["path_s"] + columns["motion_s"]
    assert columns["total_s"] == pytest.approx(whole)
    assert (columns["motion_contact"], columns["proven"]) == ("", True)
    assert 0.5 < columns["largest_share"] <= 1.0
    quicker = measure(OURS, "", around_post, LimitsRequest(acceleration=15.0, jerk=5000.0), 1.0)
    assert quicker["duration_s"] < columns["duration_s"]


@pytest.mark.parametrize("path", [AROUND, STRAIGHT])
def test_the_motion_of_roboplan_is_looked_at(path: list[list[float]], around_post: PlanRequest, tmp_path: Path) -> None:
    """The first answer is a path, the second one, to the runner of motions, its samples: too quick by half."""
    python = tmp_path / "python"
    python.write_text(
        f"#!{sys.executable}\nimport json, sys\n*_, problem, answer = sys.argv\nasked = json.load(open(problem))\n"
        f"found = dict(path={path}, ready_s=1.0, path_s=2.0) if 'start' in asked else None\n"
        "if found is None:\n"
        "    assert asked['acceleration'] == [15.0, 15.0]\n"
        "    q = asked['path']\n"
        "    still = [[0.0] * 2] * len(q)\n"
        "    found = dict(times=list(range(len(q))), q=q, qd=still, qdd=still, motion_s=4.0)\n"
        "json.dump(found, open(answer, 'w'))\n"
    )
    python.chmod(0o755)
    columns = measure(ROBOPLAN, str(python), around_post, LIMITS, 2.0)
    assert (columns["motion_s"], columns["total_s"], columns["duration_s"]) == (4.0, 7.0, len(path) - 1.0)
    most = max(np.abs(np.diff(path, axis=0)).max(axis=0))  # the cubics' largest acceleration is 6 of it, velocity 1.5
    velocity = load("planar_2r").velocity.min()
    assert columns["largest_share"] == pytest.approx(max(1.5 * most / velocity, 6.0 * most / 15.0))
    assert ("post" in columns["motion_contact"]) == (path == STRAIGHT)


def test_what_roboplan_does_not_time_is_solved_without_a_motion(around_post: PlanRequest, tmp_path: Path) -> None:
    says = f"reply(path={AROUND}, ready_s=1.0, path_s=2.0) if method == 'roboplan' else None"
    python = Path(python_that(tmp_path, says))
    text = python.read_text().replace(
        "_, isolated, runner, method, problem, answer = sys.argv", "*_, method, problem, answer = sys.argv"
    )
    python.write_text(text.replace("else None", "else reply(message='no spline')"))
    columns = measure(ROBOPLAN, str(python), around_post, LIMITS, 2.0)
    assert (columns["outcome"], columns["message"]) == (SOLVED, "not timed: no spline")
    assert "total_s" not in columns


def test_what_another_python_answers_is_looked_at(around_post: PlanRequest, tmp_path: Path) -> None:
    for path, touches in ((AROUND, False), (STRAIGHT, True)):
        says = f"reply(path={path}, version=method + ' 9', first_s=problem['seconds'] + problem['seed'])"
        columns = measure(OTHER, python_that(tmp_path, says), replace(around_post, seed=3), LIMITS, 2.0)
        assert (columns["outcome"], columns["version"], columns["first_s"]) == (SOLVED, "pyroboplan 9", 5.0)
        assert columns["length_rad"] == pytest.approx(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        assert (columns["contacts"], "post" in columns.get("message", "")) == (int(touches), touches)


@pytest.mark.parametrize(("planned_with", "looks"), [("coal", "fcl"), ("fcl", "coal")])
def test_the_library_that_has_not_planned_looks(
    planned_with: str, looks: str, around_post: PlanRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    monkeypatch.setattr(case, "make_checker", lambda *args: made.append(args[2]) or make_checker(*args))
    request = replace(around_post, collision=planned_with)
    assert measure(OTHER, python_that(tmp_path, f"reply(path={STRAIGHT})"), request, LIMITS, 2.0)["contacts"] == 1
    assert made == [looks]


@pytest.mark.parametrize(
    ("says", "message"),
    [
        ("print('a\\nso it goes', file=sys.stderr); sys.exit(1)", f"{OTHER} in PYTHON: so it goes"),
        ("sys.exit(3)", f"{OTHER} in PYTHON: exit code 3"),
        (None, "PYTHON did not answer: "),
    ],
)
def test_another_python_that_fails_is_a_row(
    says: str | None, message: str, around_post: PlanRequest, tmp_path: Path
) -> None:
    python = str(tmp_path / "nowhere") if says is None else python_that(tmp_path, says)
    columns = measure(OTHER, python, around_post, LIMITS, 1.0)
    assert columns.keys() == {"outcome", "message"}
    assert columns["outcome"] == REFUSED
    assert columns["message"].startswith(message.replace("PYTHON", python))


def test_another_python_that_does_not_end_is_a_row(
    around_post: PlanRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(case, "_WAIT", 0.0)
    columns = measure(OTHER, python_that(tmp_path, "import time; time.sleep(60)"), around_post, LIMITS, 0.2)
    assert columns["outcome"] == REFUSED
    assert "did not answer" in columns["message"]


def test_no_path_is_a_row(around_post: PlanRequest, tmp_path: Path) -> None:
    columns = measure(OTHER, python_that(tmp_path, "reply(path=None, ready_s=0.5)"), around_post, LIMITS, 1.0)
    assert columns == {"outcome": NO_PATH, "ready_s": 0.5}


def test_no_path_of_ours_is_a_row(around_post: PlanRequest, tmp_path: Path) -> None:
    apart = replace(around_post, scene=str(planar_trap(tmp_path)), start="q:0,0", goal="q:3.1,0")
    columns = measure(OURS, "", apart, LIMITS, 1.0)
    assert columns["outcome"] == NO_PATH
    assert "length_rad" not in columns


def test_what_cannot_be_asked_is_a_row(around_post: PlanRequest) -> None:
    columns = measure(OMPL, "", replace(around_post, start="q:0,99"), LIMITS, 1.0)
    assert columns["outcome"] == REFUSED
    assert "limits" in columns["message"]


def test_the_first_path_is_noted_once() -> None:
    watch = _FirstPath()
    watch("links", 3, 3)
    watch(FIRST_PATH, 1, 2)
    assert watch.seconds is None
    watch(FIRST_PATH, 2, 2)
    noted = watch.seconds
    watch(FIRST_PATH, 2, 2)
    assert noted is not None
    assert watch.seconds == noted


def test_the_process_writes_its_columns(around_post: PlanRequest, tmp_path: Path) -> None:
    asked = {"scene": around_post.scene, "start": around_post.start, "goal": around_post.goal}
    asked |= {"robot": "planar_2r", "collision": "fcl", "path_only": True}
    options = {"method": OTHER, "python": python_that(tmp_path, "reply(path=None)"), "seconds": 1.0}
    options |= {"request": asked, "motion": {"jerk": 500.0}}
    main(str(tmp_path / "row.json"), json.dumps(options))
    assert json.loads((tmp_path / "row.json").read_text()) == {"outcome": NO_PATH}
