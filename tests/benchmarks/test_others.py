"""Other planners: each gets our problem and its answer is read, with a double in its library's place."""

import ast
import itertools
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import coal
import numpy as np
import pinocchio as pin
import pytest

from benchmarks.others import elsewhere, roboplan_runner, solver_runner
from benchmarks.others.exchange import describe_problem
from benchmarks.tool_paths.judge import deviations
from planner.base.errors import PlannerError
from planner.collision.checker import is_free
from planner.problem.request import PlanRequest
from planner.query.query import make_query
from tests.tool_paths.judge import line_of
from tests.worlds import random_q

PATH = [np.array([-1.0, 0.8]), np.array([-1.0, 2.5]), np.array([1.0, -0.8])]


@pytest.fixture
def problem(tmp_path: Path) -> dict[str, Any]:
    """planar_2r with one obstacle of each shape, seed 3, 2 s."""
    (tmp_path / "scene.yaml").write_text(
        "obstacles:\n"
        "  - {name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}\n"
        "  - {name: ball, type: sphere, radius: 0.1, position: [-0.7, 0, 0]}\n"
        "  - {name: drum, type: cylinder, radius: 0.05, length: 0.2, position: [0, 0.9, 0.5]}\n"
    )
    request = PlanRequest.from_options(
        robot="planar_2r", scene=str(tmp_path / "scene.yaml"), start="q:-1.0,0.8", goal="q:1.0,-0.8"
    )
    return describe_problem(make_query(request.what), 3, 2.0)


def pinocchio_world(data: dict[str, Any]) -> tuple[Any, Any]:
    """Model and collision geometry of the planned joints among the obstacles, out of the exchanged data alone."""
    whole = pin.buildModelFromXML(data["urdf"])
    kind, free = pin.GeometryType.COLLISION, {frozenset(pair) for pair in data["free_pairs"]}
    shapes = pin.buildGeomFromUrdfString(whole, data["urdf"], kind, package_dirs=data["package_dirs"])
    q = pin.neutral(whole)
    for name, value in data["held"].items():
        q[whole.joints[whole.getJointId(name)].idx_q] = value
    held = [whole.getJointId(name) for name in whole.names[1:] if name not in data["joints"]]
    model, geometry = pin.buildReducedModel(whole, shapes, held, q)
    links = [whole.frames[item.parentFrame].name for item in shapes.geometryObjects]
    joints = [item.parentJoint for item in geometry.geometryObjects]
    for i, k in itertools.combinations(range(geometry.ngeoms), 2):
        if joints[i] != joints[k] and frozenset((links[i], links[k])) not in free:
            geometry.addCollisionPair(pin.CollisionPair(i, k))
    makers = {"box": lambda item: coal.Box(*item["size"]), "sphere": lambda item: coal.Sphere(item["radius"])}
    makers["cylinder"] = lambda item: coal.Cylinder(item["radius"], item["length"])
    for item in data["obstacles"]:
        placement = pin.SE3(np.array(item["placement"]))
        added = pin.GeometryObject(item["name"], 0, 0, placement, makers[item["type"]](item))
        number = geometry.addGeometryObject(added)
        for i in range(len(links)):
            geometry.addCollisionPair(pin.CollisionPair(i, number))
    return model, geometry


@pytest.mark.parametrize(("robot", "scene"), [("panda", "shelf"), ("ur5", "window")])
def test_the_problem_that_others_get_is_ours(robot: str, scene: str) -> None:
    """Pinocchio's own collision pairs on the exchanged data, against our checker, on random configurations."""
    query = make_query(PlanRequest.from_options(robot=robot, scene=scene, collision="coal").what)
    data = describe_problem(query, 0, 1.0)
    model, geometry = pinocchio_world(data)
    held, found = model.createData(), geometry.createData()
    np.testing.assert_allclose(model.lowerPositionLimit, query.robot.lower)
    for q in [*random_q(query.robot, 60, 3), query.starts[0], query.goals[0]]:
        assert pin.computeCollisions(model, held, geometry, found, q, True) != is_free(query.checker, q)


@pytest.mark.parametrize("runner", [solver_runner, roboplan_runner])
def test_a_runner_needs_nothing_of_this_package(runner: Any) -> None:
    tree = ast.parse(Path(runner.__file__).read_text())
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imported |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert imported - sys.stdlib_module_names - {"collections.abc", "importlib.metadata"} == {"numpy"}


def test_hpp_gets_obstacles_where_they_are_and_holds_joints(
    problem: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """HPP's device is a double with a model of Pinocchio."""
    robots, loaded = MagicMock(), []
    device = robots.Device.return_value

    def load_model(_: Any, root: int, prefix: str, kind: str, urdf: str, srdf: str, placement: Any) -> None:
        device.model.return_value = device.model.return_value if loaded else pin.buildModelFromXML(urdf)
        loaded.append(urdf)

    def remove(names: list[str], q: Any) -> None:
        model = device.model.return_value
        device.model.return_value = pin.buildReducedModel(model, [model.getJointId(name) for name in names], q)

    device.removeJoints.side_effect = remove
    monkeypatch.setitem(sys.modules, "pyhpp.pinocchio", robots)
    monkeypatch.setitem(sys.modules, "pyhpp.pinocchio.urdf", SimpleNamespace(loadModelFromString=load_model))
    turned = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.4, 2.5), np.array([0.1, -0.2, 0.3])).homogeneous
    problem["obstacles"][0]["placement"] = turned.tolist()
    first, second = problem["joints"]
    arm = solver_runner._HppArm({**problem, "joints": [second], "held": {first: 0.25}})
    arm.add(problem["obstacles"])
    names, q = device.removeJoints.call_args.args
    assert (names, q.tolist(), arm.state([0.5]).tolist()) == ([first], [0.25, 0.0], [0.5])
    shapes = pin.buildGeomFromUrdfString(pin.buildModelFromXML(loaded[1]), loaded[1], pin.GeometryType.COLLISION)
    for item, asked in zip(shapes.geometryObjects, problem["obstacles"], strict=True):
        np.testing.assert_allclose(item.placement.homogeneous, asked["placement"], atol=1e-12)


def test_a_script_elsewhere_finds_its_own_libraries_and_its_failure_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LD_LIBRARY_PATH", "/somewhere")
    own = tmp_path / "lib" / "python3.99" / "site-packages" / "cmeel.prefix" / "lib"
    own.mkdir(parents=True)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python").symlink_to(sys.executable)
    script = tmp_path / "script.py"
    script.write_text(
        "import json, os, sys\n*words, problem, answer = sys.argv[1:]\n"
        "json.dump([words, json.load(open(problem)), os.environ['LD_LIBRARY_PATH']], open(answer, 'w'))"
    )
    found = elsewhere.answer_of("hpp", str(tmp_path / "bin" / "python"), str(script), {"a": 1}, 30.0, ["x"])
    assert found == [["x"], {"a": 1}, f"{own}:/somewhere"]
    script.write_text("raise ValueError('no robot')")
    with pytest.raises(PlannerError, match=r"hpp in .*: ValueError: no robot"):
        elsewhere.answer_of("hpp", sys.executable, str(script), {}, 30.0)


def test_the_judge_of_tool_paths_sees_how_far_off_the_tool_is() -> None:
    path = line_of([[0, 0, 0], [1, 0, 0], [1, 1, 0]], axis=[0, 0, 1])
    lean = np.array([[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]])
    off, angle = deviations(path, np.array([np.eye(3), lean]), np.array([[0.5, 0.0, 0.01], [1.02, 0.5, 0.0]]))
    assert off == pytest.approx([0.01, 0.02])
    assert angle == pytest.approx([0.0, 0.2], abs=1e-12)
