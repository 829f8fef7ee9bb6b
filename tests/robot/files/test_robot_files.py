"""A robot's files: planned joints, the tool, and robots of robot_descriptions."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from planner.base.errors import InstallationError, RobotError
from planner.robot.files import robot_files
from planner.robot.robot import Robot
from tests.worlds import joint_xml, link_xml


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """Three joints, the last one held by the robot file."""
    links = "".join(link_xml(name, '<sphere radius="0.01"/>') for name in "abcd")
    joints = joint_xml("j1", "a", "b") + joint_xml("j2", "b", "c", xyz="1 0 0") + joint_xml("j3", "c", "d", xyz="1 0 0")
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>')
    (tmp_path / "robot.yaml").write_text(
        "name: mine\nurdf: {file: arm.urdf}\ntool: d\nmanipulability: planar\nfixed_joints: {j3: 0.2}\n"
    )
    return tmp_path / "robot.yaml"


MODULES = {  # of a package that has what the package robot_descriptions has
    "__init__": "",
    "arm_description": "URDF_PATH = FOLDER + '/arm.urdf'\nSRDF_PATH = FOLDER + '/arm.srdf'\n",
    "built_description": "XACRO_PATH = FOLDER + '/arm.xacro'\nXACRO_ARGS = {'kind': 'x'}\n",
    "bare_description": "",
    "far_description": "raise OSError('no network')",
}


def test_robots_of_the_package_robot_descriptions(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_files, "_DESCRIPTIONS", "robot_descriptions_that_is_not_installed")
    with pytest.raises(InstallationError, match=r"pip install 'gabf-planner\[descriptions\]'"):
        Robot.load("arm_description")
    monkeypatch.setattr(robot_files, "_DESCRIPTIONS", "descriptions_of_a_test")
    folder = arm.parent / "site" / "descriptions_of_a_test"
    folder.mkdir(parents=True)
    for name, text in MODULES.items():
        (folder / f"{name}.py").write_text(text.replace("FOLDER", repr(str(arm.parent))))
    (arm.parent / "arm.srdf").write_text('<robot name="arm"><disable_collisions link1="a" link2="b"/></robot>')
    monkeypatch.syspath_prepend(str(folder.parent))
    robot = Robot.load("arm_description")
    assert (robot.name, robot.disabled_pairs) == ("arm_description", {frozenset("ab")})
    _, built = robot_files.find_robot("built_description")
    assert (built.urdf.file, built.urdf.args) == (str(arm.parent / "arm.xacro"), {"kind": "x"})
    for name, said in (("bare", "cannot be loaded"), ("far", "no network"), ("none", "cannot be loaded")):
        with pytest.raises(RobotError, match=said):
            Robot.load(f"{name}_description")
    assert "descriptions_of_a_test.arm_description" in sys.modules


TIPS = {  # the links at the end of an arm of two joints, each with how many of these move it
    "a name that is usual": ({"base": 0, "left_tool0": 2, "ee_link": 2}, "left_tool0", "by its name"),
    "a whole name before the end of one": ({"tcp": 1, "camera_tcp": 2}, "tcp", "by its name"),
    "the farthest tip": ({"camera": 1, "hand": 2, "stand": 0}, "hand", "as the tip that most joints move"),
    "one tip": ({"hand": 2}, "hand", None),
    "two hands": ({"left": 2, "right": 2}, None, None),
    "two tools": ({"left_tool0": 2, "right_tool0": 2, "hand": 2}, None, None),
}


@pytest.mark.parametrize(("tips", "tool", "why"), TIPS.values(), ids=TIPS)
def test_a_tool_is_chosen_where_one_is_likely(
    tips: dict[str, int], tool: str | None, why: str | None, urdf_file: Callable[..., str]
) -> None:
    ball = '<sphere radius="0.01"/>'
    arm = "".join(link_xml(f"l{k}", ball) for k in range(3))
    arm += joint_xml("j1", "l0", "l1", xyz="0.3 0 0") + joint_xml("j2", "l1", "l2", xyz="0.3 0 0", axis="0 1 0")
    ends = "".join(link_xml(name) + joint_xml(f"to {name}", f"l{k}", name, "fixed") for name, k in tips.items())
    file = urdf_file(arm + ends)
    if tool is None:
        with pytest.raises(RobotError, match=f"the robot has {len(tips)} tips: name one as its tool; tips are "):
            Robot.load(file)
        return
    robot = Robot.load(file)
    assert robot.tool == tool
    notes = [note.text for note in robot.notes if "taken as the tool" in note.text]
    assert [why is not None and f"'{tool}' is taken as the tool, {why}" in note for note in notes] == [True] * bool(why)
    assert not [note for note in Robot.load(file, tool=tool).notes if "taken as the tool" in note.text]
