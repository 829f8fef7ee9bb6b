"""Another planner on one problem: what it is asked and what it answers, with a double in its library's place."""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest

from benchmarks.first_motion import runner
from benchmarks.first_motion.exchange import exchanged
from benchmarks.first_motion.runner import STEP, _Clock, main, solve_by_pyroboplan, solve_by_roboplan
from planner.problem.request import PlanRequest
from planner.setup.open import make_query

PATH = [np.array([-1.0, 0.8]), np.array([-1.0, 2.5]), np.array([1.0, -0.8])]
SHORT = [PATH[0], PATH[2]]


@pytest.fixture
def problem(tmp_path: Path) -> dict[str, Any]:
    """planar_2r with one obstacle of each shape, seed 3, 2 s."""
    (tmp_path / "scene.yaml").write_text(
        "obstacles:\n"
        "  - {name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}\n"
        "  - {name: ball, type: sphere, radius: 0.1, position: [-0.7, 0, 0]}\n"
        "  - {name: drum, type: cylinder, radius: 0.05, length: 0.2, position: [0, 0.9, 0.5]}\n"
    )
    request = PlanRequest("planar_2r", str(tmp_path / "scene.yaml"), start="q:-1.0,0.8", goal="q:1.0,-0.8")
    return exchanged(make_query(request), 3, 2.0)


def test_it_needs_nothing_of_this_package() -> None:
    tree = ast.parse(Path(runner.__file__).read_text())
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imported |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert imported - sys.stdlib_module_names - {"collections.abc", "importlib.metadata"} == {"numpy"}


@pytest.mark.parametrize("found", [PATH, None])
def test_pyroboplan_is_asked_with_our_numbers(
    found: Any, problem: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    rrt, short = MagicMock(), MagicMock()
    rrt.RRTPlanner.return_value.plan.return_value = found
    short.shortcut_path.return_value = SHORT
    monkeypatch.setitem(sys.modules, "pyroboplan.planning.rrt", rrt)
    monkeypatch.setitem(sys.modules, "pyroboplan.planning.path_shortcutting", short)
    answer = solve_by_pyroboplan(problem)
    options = rrt.RRTPlannerOptions.call_args.kwargs
    assert options["rrt_connect"]
    assert (options["rng_seed"], options["max_planning_time"], options["max_step_size"]) == (3, 2.0, STEP)
    model, geometry, _ = rrt.RRTPlanner.call_args.args
    assert model.nq == 2
    assert {item.name for item in geometry.geometryObjects} > {"post", "ball", "drum"}
    start, goal = rrt.RRTPlanner.return_value.plan.call_args.args
    np.testing.assert_allclose([start, goal], SHORT)
    assert answer["path"] == (None if found is None else [q.tolist() for q in SHORT])
    assert ("path_s" in answer) == (found is not None)


def test_roboplan_is_asked_with_our_numbers(problem: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    core, rrt = MagicMock(), MagicMock()
    monkeypatch.setitem(sys.modules, "roboplan.core", core)
    monkeypatch.setitem(sys.modules, "roboplan.rrt", rrt)
    scene = core.Scene.return_value
    scene.getCurrentJointPositions.return_value = np.zeros(3)
    scene.getJointPositionIndices.return_value = [2]
    reversed_ = SimpleNamespace(joint_names=problem["joints"][::-1], positions=[q[::-1] for q in SHORT])
    core.PathShortcutter.return_value.shortcut.return_value = reversed_
    answer = solve_by_roboplan({**problem, "held": {"finger": 0.25}, "free_pairs": [["link_0", "tip"]]})
    assert answer["path"] == [q.tolist() for q in SHORT]  # in the order of our joints
    core.Box.assert_called_once_with(0.1, 0.02, 0.2)
    core.Sphere.assert_called_once_with(0.1)
    core.Cylinder.assert_called_once_with(0.05, 0.2)
    placement = scene.addBoxGeometry.call_args.args[3]
    np.testing.assert_allclose(placement[:3, 3], [0.75, 0.0, 0.0])
    calls = [call.args for call in scene.setCollisions.call_args_list]
    assert [checked for _, checked in calls] == [False, False]
    assert {frozenset(pair) for allowed, _ in calls for pair in allowed} == {
        frozenset(pair) for pair in (("post", "ball"), ("post", "drum"), ("ball", "drum"), ("link_0", "tip"))
    }
    assert scene.setJointPositions.call_args.args[0].tolist() == [0.0, 0.0, 0.25]
    rrt.RRT.return_value.setRngSeed.assert_called_once_with(3)
    options = rrt.RRTOptions.call_args.kwargs
    assert (options["max_planning_time"], options["collision_check_step_size"]) == (2.0, STEP)


def test_seconds_count_from_the_moment_the_world_is_ready(monkeypatch: pytest.MonkeyPatch) -> None:
    readings = iter([10.0, 12.0, 15.0, 19.0])
    monkeypatch.setattr(runner, "time", SimpleNamespace(perf_counter=lambda: next(readings)))
    clock = _Clock()
    for name in ("ready_s", "first_s", "path_s"):
        clock.lap(name)
    assert clock.seconds == {"ready_s": 2.0, "first_s": 3.0, "path_s": 7.0}


def test_the_answer_is_a_file_and_the_planners_words_are_not_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def talks(problem: dict[str, Any]) -> dict[str, Any]:
        sys.stdout.write("iteration 1\n")
        if problem["seed"]:
            raise RuntimeError("failed to plan")
        return {"path": [[0.0]]}

    monkeypatch.setitem(runner.SOLVERS, "numpy", talks)  # a name whose version is known
    answers = []
    for seed in (0, 1):
        (tmp_path / "problem.json").write_text(json.dumps({"seed": seed}))
        main("numpy", str(tmp_path / "problem.json"), str(tmp_path / "answer.json"))
        answers.append(json.loads((tmp_path / "answer.json").read_text()))
    assert answers[0] == {"version": np.__version__, "proven": False, "path": [[0.0]]}
    assert answers[1] == {
        "version": np.__version__,
        "proven": False,
        "path": None,
        "message": "failed to plan",
    }
    assert capsys.readouterr().out == ""
