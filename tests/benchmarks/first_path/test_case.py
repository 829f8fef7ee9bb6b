"""One run: our path, OMPL's, and what another Python answers, which is looked at whatever it says of itself."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.first_path import case
from benchmarks.first_path.case import _FirstPath, main, measure
from benchmarks.first_path.report import OMPL, OURS
from planner.batch.outcomes import NO_PATH, REFUSED, SOLVED
from planner.collision import make_checker
from planner.problem.request import PlanRequest
from planner.sampling.first_path import FIRST_PATH
from tests.worlds import planar_trap

POST = "obstacles: [{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}]\n"
AROUND = [[-1.0, 0.8], [-1.0, 2.5], [1.0, 2.5], [1.0, -0.8]]
STRAIGHT = [AROUND[0], AROUND[-1]]
OTHER = "pyroboplan"


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


@pytest.mark.parametrize("method", [OURS, OMPL])
def test_a_path_is_found_and_looked_at(method: str, around_post: PlanRequest) -> None:
    columns = measure(method, "", around_post, 30.0)
    assert columns["outcome"] == SOLVED, columns
    assert columns["length_rad"] > np.hypot(2.0, 1.6)
    assert 0 < columns["first_s"] <= columns["path_s"]
    assert columns["corners"] >= 1
    assert columns["contacts"] == 0 or method == OMPL
    assert columns["version"]


def test_what_another_python_answers_is_looked_at(around_post: PlanRequest, tmp_path: Path) -> None:
    for path, touches in ((AROUND, False), (STRAIGHT, True)):
        says = f"reply(path={path}, version=method + ' 9', first_s=problem['seconds'] + problem['seed'])"
        columns = measure(OTHER, python_that(tmp_path, says), replace(around_post, seed=3), 2.0)
        assert (columns["outcome"], columns["version"], columns["first_s"]) == (SOLVED, "pyroboplan 9", 5.0)
        assert columns["length_rad"] == pytest.approx(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        assert (columns["contacts"], "post" in columns["message"]) == (int(touches), touches)


@pytest.mark.parametrize(("planned_with", "looks"), [("coal", "fcl"), ("fcl", "coal")])
def test_the_library_that_has_not_planned_looks(
    planned_with: str, looks: str, around_post: PlanRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    monkeypatch.setattr(case, "make_checker", lambda *args: made.append(args[2]) or make_checker(*args))
    request = replace(around_post, collision=planned_with)
    assert measure(OTHER, python_that(tmp_path, f"reply(path={STRAIGHT})"), request, 2.0)["contacts"] == 1
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
    columns = measure(OTHER, python, around_post, 1.0)
    assert columns.keys() == {"outcome", "message"}
    assert columns["outcome"] == REFUSED
    assert columns["message"].startswith(message.replace("PYTHON", python))


def test_another_python_that_does_not_end_is_a_row(
    around_post: PlanRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(case, "_WAIT", 0.0)
    columns = measure(OTHER, python_that(tmp_path, "import time; time.sleep(60)"), around_post, 0.2)
    assert columns["outcome"] == REFUSED
    assert "did not answer" in columns["message"]


def test_no_path_is_a_row(around_post: PlanRequest, tmp_path: Path) -> None:
    columns = measure(OTHER, python_that(tmp_path, "reply(path=None, setup_s=0.5)"), around_post, 1.0)
    assert columns == {"outcome": NO_PATH, "setup_s": 0.5}


def test_no_path_of_ours_is_a_row(around_post: PlanRequest, tmp_path: Path) -> None:
    apart = replace(around_post, scene=str(planar_trap(tmp_path)), start="q:0,0", goal="q:3.1,0")
    columns = measure(OURS, "", apart, 1.0)
    assert columns["outcome"] == NO_PATH
    assert "length_rad" not in columns


def test_what_cannot_be_asked_is_a_row(around_post: PlanRequest) -> None:
    columns = measure(OMPL, "", replace(around_post, start="q:0,99"), 1.0)
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
    options = {"method": OTHER, "python": python_that(tmp_path, "reply(path=None)"), "seconds": 1.0, "request": asked}
    main(str(tmp_path / "row.json"), json.dumps(options))
    assert json.loads((tmp_path / "row.json").read_text()) == {"outcome": NO_PATH}
