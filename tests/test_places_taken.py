"""Wherever the library takes the path of a file, text will do as well as a path object."""

# pyright: reportArgumentType=false
from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

import planner
from planner import gabf
from planner.robot.scene import write_scene
from planner.trajectory.file import load_trajectory, save_trajectory
from tests.worlds import load, post_roadmap

ROBOT = load("planar_2r")
URDF = Path("robots/planar_2r/planar_2r.urdf").resolve()
MOTION = planner.Trajectory.through(ROBOT.joints, np.array([0.0, 1.0]), np.zeros((2, 2)), np.zeros((2, 2)))
NETWORK = gabf.Network.from_arcs([1], [0], [1.0], [0], 2, kernel=gabf.Additive())


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
    assert asked["load_roadmap, path"] == "StrPath"
