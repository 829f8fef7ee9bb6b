"""Wherever the library takes the place of a file, text will do as well as a path, and nothing else has a traceback."""

# pyright: reportArgumentType=false
from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planner
from planner import gabf
from planner.base.errors import FileError
from planner.models.files.meshes import read_mesh
from planner.models.files.moveit.requests import read_motion_plan_request
from planner.models.files.scene_writer import write_scene
from planner.paths.file import read_joint_path
from planner.problem import request
from planner.trajectory.file import load_trajectory, save_trajectory
from planner.trajectory.points import read_points
from tests.worlds import load, post_roadmap

ROBOT = load("planar_2r")
URDF = Path("robots/planar_2r/planar_2r.urdf").resolve()
MOTION = planner.Trajectory.through(ROBOT.joints, np.array([0.0, 1.0]), np.zeros((2, 2)), np.zeros((2, 2)))
NETWORK = gabf.Network.from_arcs([1], [0], [1.0], [0], 2, kernel=gabf.Additive())
CALLS: dict[str, Callable[[Any], object]] = {
    "Robot.load": planner.Robot.load,
    "Robot.load, srdf": lambda at: planner.Robot.load("planar_2r", srdf=at),
    "Scene.load": planner.Scene.load,
    "load_roadmap": planner.load_roadmap,
    "save_roadmap": lambda at: planner.save_roadmap(post_roadmap(), at),
    "Session": lambda at: planner.Session("planar_2r", "empty", at),
    "PlanRequest, roadmap": lambda at: planner.PlanRequest(roadmap=at),
    "PlanRequest, srdf": lambda at: planner.PlanRequest(srdf=at),
    "PlanRequest, message": lambda at: planner.PlanRequest(motion_plan_request=at),
    "LiveRequest": lambda at: request.LiveRequest(roadmap=at),
    "LimitsRequest": lambda at: planner.LimitsRequest(limits=at),
    "TimingRequest": lambda at: planner.TimingRequest(limits=at),
    "MotionLimits.of": lambda at: planner.MotionLimits.of(ROBOT, planner.LimitsRequest(limits=at)),
    "save_trajectory": lambda at: save_trajectory(MOTION, at),
    "load_trajectory": load_trajectory,
    "read_points": lambda at: read_points(at, ROBOT),
    "read_joint_path": lambda at: read_joint_path(at, ROBOT),
    "read_mesh": read_mesh,
    "read_motion_plan_request": read_motion_plan_request,
    "write_scene": lambda at: write_scene(planner.Scene("x"), at),
    "Plan.save": lambda at: planner.Plan.save(None, at),
    "Tradeoff.save": lambda at: planner.Tradeoff.save(None, at),
}
NONE_IS_FINE = ("PlanRequest", "LiveRequest", "LimitsRequest", "TimingRequest", "MotionLimits.of")


@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_place_is_refused_in_a_sentence(name: str) -> None:
    optional = name.startswith(NONE_IS_FINE) or name in ("Session", "Robot.load, srdf")
    for wrong in (3, b"x", *(() if optional else (None,))):
        with pytest.raises(FileError, match=r": give .*text,? or a (pathlib.Path|path)\.$"):
            CALLS[name](wrong)


def test_text_is_written_and_read_as_a_path_is(tmp_path: Path) -> None:
    file, text = tmp_path / "x.npz", str(tmp_path / "y.npz")
    for at in (file, text):
        planner.save_roadmap(post_roadmap(), at)
        assert planner.load_roadmap(at).sha256 == post_roadmap().sha256
    for at in (tmp_path / "x.json", str(tmp_path / "y.json")):
        save_trajectory(MOTION, at)
        np.testing.assert_array_equal(load_trajectory(at).nanoseconds, MOTION.nanoseconds)
    for at in (tmp_path / "x.yaml", str(tmp_path / "y.yaml")):
        write_scene(planner.Scene("x"), at)
        assert planner.Scene.load(at).name == "x"
    for at in (URDF, str(URDF)):
        assert planner.Robot.load(at, tool=ROBOT.tool).joints == ROBOT.joints
    limits = ", ".join(f"{joint}: {{max_velocity: 0.5}}" for joint in ROBOT.joints)
    (tmp_path / "l.yaml").write_text(f"joint_limits: {{{limits}}}")
    for at in (tmp_path / "l.yaml", str(tmp_path / "l.yaml")):
        assert planner.MotionLimits.of(ROBOT, planner.LimitsRequest(limits=at)).velocity[0] == 0.5


def _public() -> Iterator[tuple[str, Any]]:
    """Every public function, and method of a public class, by its name."""
    for module in (planner, gabf):
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.isclass(thing):
                yield from ((f"{name}.{k}", v) for k, v in vars(thing).items() if k == "__init__" or k[0] != "_")
            yield name, thing


def test_no_public_function_asks_for_a_path_alone() -> None:
    asked = {}
    for name, thing in _public():
        function = thing.__func__ if isinstance(thing, staticmethod | classmethod) else thing
        if inspect.isfunction(function) or (inspect.isclass(function) and is_dataclass(function)):
            kinds = inspect.signature(function).parameters.values()
            asked |= {f"{name}, {each.name}": str(each.annotation) for each in kinds}
    assert len(asked) > 200
    assert {where: kind for where, kind in asked.items() if re.search(r"\bPath\b", kind)} == {}
    assert asked["load_roadmap, path"] == "Place"
