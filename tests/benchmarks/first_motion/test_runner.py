"""Another planner on one problem: what it is asked and what it answers, with a double in its library's place."""

from __future__ import annotations

import ast
import json
import os
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.elsewhere import answer_of
from benchmarks.first_motion import runner
from benchmarks.first_motion.exchange import exchanged
from benchmarks.first_motion.runner import (
    HPP_TOLERANCES,
    STEP,
    _Clock,
    _HppArm,
    main,
    solve_by_hpp,
    solve_by_pyroboplan,
    solve_by_roboplan,
)
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


def hpp_doubles(monkeypatch: pytest.MonkeyPatch) -> tuple[MagicMock, MagicMock, list[tuple[str, str]]]:
    """HPP's core, its device with a model of Pinocchio, and the URDF and SRDF of all that is loaded into that."""
    core, robots, loaded = MagicMock(), MagicMock(), []
    device = robots.Device.return_value

    def load(where: Any, root: int, prefix: str, kind: str, urdf: str, srdf: str, placement: Any) -> None:
        assert where is device
        device.model.return_value = device.model.return_value if loaded else pin.buildModelFromXML(urdf)
        loaded.append((urdf, srdf))

    def remove(names: list[str], q: Any) -> None:
        model = device.model.return_value
        device.model.return_value = pin.buildReducedModel(model, [model.getJointId(name) for name in names], q)

    device.removeJoints.side_effect = remove
    loader = SimpleNamespace(loadModelFromString=load)
    for name, module in {"core": core, "pinocchio": robots, "pinocchio.urdf": loader}.items():
        monkeypatch.setitem(sys.modules, f"pyhpp.{name}", module)
    return core, device, loaded


def test_hpp_is_asked_with_our_numbers_and_proves(problem: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    core, device, loaded = hpp_doubles(monkeypatch)
    asked, planner = core.Problem.return_value, core.BiRRTPlanner.return_value
    pieces = [SimpleNamespace(initial=lambda k=k: PATH[k], end=lambda k=k: PATH[k + 1]) for k in range(2)]
    found = core.RandomShortcut.return_value.optimize.return_value
    found.numberPaths.return_value, found.pathAtRank.side_effect = 2, pieces.__getitem__
    answer = solve_by_hpp({**problem, "free_pairs": [["link1", "tip"]]})
    assert answer["path"] == [q.tolist() for q in PATH]
    assert answer["proven"]
    assert answer["first_s"] <= answer["path_s"]
    core.Dichotomy.assert_called_once_with(device, 0.0)
    asked.pathValidation.assert_called_once_with(core.Dichotomy.return_value)  # what is assigned is passed over
    planner.timeOut.assert_called_once_with(2.0)
    np.testing.assert_array_equal(asked.initConfig.call_args.args[0], problem["start"])
    np.testing.assert_array_equal(asked.addGoalConfig.call_args.args[0], problem["goal"])
    device.removeJoints.assert_not_called()
    assert [(urdf == problem["urdf"], 'link1="link1" link2="tip"' in srdf) for urdf, srdf in loaded] == [
        (True, True),
        (False, False),
    ]


def test_hpp_gets_the_obstacles_where_they_are(problem: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    turned = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.4, 2.5), np.array([0.1, -0.2, 0.3])).homogeneous
    problem["obstacles"][0]["placement"] = turned.tolist()
    _, _, loaded = hpp_doubles(monkeypatch)
    _HppArm(problem).add(problem["obstacles"])
    urdf = loaded[1][0]
    shapes = pin.buildGeomFromUrdfString(pin.buildModelFromXML(urdf), urdf, pin.GeometryType.COLLISION)
    box, ball, drum = (item.geometry for item in shapes.geometryObjects)
    np.testing.assert_allclose(2 * box.halfSide, problem["obstacles"][0]["size"])
    assert (ball.radius, drum.radius, 2 * drum.halfLength) == (0.1, 0.05, 0.2)
    for item, asked in zip(shapes.geometryObjects, problem["obstacles"], strict=True):
        np.testing.assert_allclose(item.placement.homogeneous, asked["placement"], atol=1e-12)


def test_joints_that_are_not_planned_are_held_in_hpp(problem: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    _, device, _ = hpp_doubles(monkeypatch)
    first, second = problem["joints"]
    arm = _HppArm({**problem, "joints": [second], "held": {first: 0.25}})
    names, q = device.removeJoints.call_args.args
    assert (names, q.tolist()) == ([first], [0.25, 0.0])
    assert arm.state([0.5]).tolist() == [0.5]
    hpp_doubles(monkeypatch)
    arm = _HppArm({**problem, "joints": [second, first]})  # our order is not HPP's
    assert arm.state([0.5, 0.25]).tolist() == [0.25, 0.5]
    assert arm.planned(np.array([0.25, 0.5])) == [0.5, 0.25]


@pytest.mark.skipif("HPP_PYTHON" not in os.environ, reason="HPP_PYTHON names no Python of an environment with HPP")
def test_hpp_itself_finds_a_path_and_refuses_what_touches(problem: dict[str, Any]) -> None:
    python = os.environ["HPP_PYTHON"]
    found = answer_of("hpp", python, runner.__file__, {**problem, "seconds": 20.0}, 60.0, ["hpp"])
    assert found["proven"]
    path = np.array(found["path"])
    np.testing.assert_allclose(path[[0, -1]], [problem["start"], problem["goal"]])
    through_the_post = [problem["start"], problem["goal"]]
    motions = [through_the_post, through_the_post[::-1], *np.stack([path[:-1], path[1:]], axis=1).tolist()]
    proofs = answer_of("hpp", python, runner.__file__, {**problem, "motions": motions}, 60.0, ["hpp proofs"])
    for method in HPP_TOLERANCES:
        assert proofs[method] == [False, False, *[True] * (len(path) - 1)]
