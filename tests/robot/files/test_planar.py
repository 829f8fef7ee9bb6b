"""A base that moves in a plane: planar joints of URDF and SRDF, slides of MJCF; limits are asked for, and hold."""

import json
from pathlib import Path

import numpy as np
import pytest

import planner
from planner.base.errors import PlannerError
from planner.cli.app import run
from planner.robot.files.robot_files import JointChoice
from planner.robot.robot import Robot
from tests.coal_judge import CoalWorld
from tests.worlds import joint_xml, link_xml

AREA = (-1.5, -1.0, 1.5, 1.0)
BASE = ["base/x", "base/y", "base/theta"]
ARM = ["turn", "lift", "bend"]
SRDF = """<robot name="cart"><virtual_joint name="base" type="planar" parent_frame="odom" child_link="cart"/>
<group name="arm"><chain base_link="cart" tip_link="tool"/></group>
<group name="all"><joint name="base"/><group name="arm"/></group>
<group_state name="there" group="all"><joint name="base" value="0.5 -0.2 1.5"/>
<joint name="turn" value="0"/><joint name="lift" value="0.1"/><joint name="bend" value="0.2"/></group_state></robot>"""
PLANAR = '<joint name="base" type="planar"><parent link="odom"/><child link="cart"/><origin xyz="0 0 0.1"/></joint>'
MJCF = """<mujoco><worldbody><body name="cart"><joint name="x" type="slide" axis="1 0 0"/>
<joint name="y" type="slide" axis="0 1 0"/><joint name="t" type="hinge" axis="0 0 1"/>
<geom type="box" size="0.2 0.15 0.1"/><body name="arm" pos="0 0 0.2">
<joint name="lift" type="hinge" axis="0 1 0" range="-1 1"/><geom type="capsule" size="0.03" fromto="0 0 0 0.4 0 0"/>
<body name="tool" pos="0.4 0 0"/></body></body></worldbody></mujoco>"""


def arm() -> str:
    xml = link_xml("cart", '<box size="0.4 0.3 0.2"/>') + joint_xml(
        "turn", "cart", "post", limit="-3 3", xyz="0 0 0.15"
    )
    xml += link_xml("post") + joint_xml("lift", "post", "upper", axis="0 1 0", limit="-1.5 1.5", xyz="0 0 0.05")
    xml += link_xml("upper", '<cylinder radius="0.03" length="0.4"/>', '<origin xyz="0 0 0.2"/>')
    xml += joint_xml("bend", "upper", "fore", axis="0 1 0", limit="-2.5 2.5", xyz="0 0 0.4")
    xml += link_xml("fore", '<cylinder radius="0.03" length="0.3"/>', '<origin xyz="0 0 0.15"/>')
    return (
        xml + '<joint name="tip" type="fixed"><parent link="fore"/><child link="tool"/><origin xyz="0 0 0.3"/></joint>'
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("planar")
    (folder / "fixed.urdf").write_text(f'<robot name="cart">{arm()}{link_xml("tool")}</robot>')
    (folder / "planar.urdf").write_text(
        f'<robot name="cart">{link_xml("odom")}{PLANAR}{arm()}{link_xml("tool")}</robot>'
    )
    (folder / "cart.srdf").write_text(SRDF)
    (folder / "cart.xml").write_text(MJCF)
    return folder


def test_a_planar_joint_is_two_slides_and_a_turn(files: Path) -> None:
    robot = Robot.load(files / "planar.urdf", base_limits=AREA)
    assert list(robot.joints) == [*BASE, *ARM]
    assert robot.lower[:2].tolist() == [-1.5, -1.0]
    assert robot.upper[:2].tolist() == [1.5, 1.0]
    assert robot.continuous.tolist() == [False, False, True, False, False, False]
    q = np.array([0.7, -0.4, 0.9, 0.3, 0.5, -0.6])
    still = np.linalg.inv(Robot.load(files / "fixed.urdf").fk(q[3:])) @ np.eye(4)
    x, y, turn = q[:3]
    base = np.array(
        [[np.cos(turn), -np.sin(turn), 0, x], [np.sin(turn), np.cos(turn), 0, y], [0, 0, 1, 0.1], [0, 0, 0, 1]]
    )
    np.testing.assert_allclose(robot.fk(q) @ still, base, atol=1e-12)
    whole = robot.jacobian(q)[:, :3]
    np.testing.assert_allclose(whole[:, :2], [[1, 0], [0, 1], *[[0, 0]] * 4], atol=1e-12)
    w = Robot.load(files / "fixed.urdf").manipulability(q[3:])
    assert robot.manipulability(q) > w  # with the columns of the base it is more than that of the arm alone


def test_the_planar_joint_of_an_srdf_moves_the_root_only_with_limits(files: Path) -> None:
    given = {"srdf": files / "cart.srdf"}
    still = Robot.load(files / "fixed.urdf", **given)
    assert list(still.joints) == ARM
    assert any("--base-limits" in note.text for note in still.notes)
    for choice in (JointChoice(), JointChoice("all")):
        robot = Robot.load(files / "fixed.urdf", choice=choice, base_limits=AREA, **given)
        assert list(robot.joints) == [*BASE, *ARM]
        assert robot.states["there"] == (0.5, -0.2, 1.5, 0.0, 0.1, 0.2)
        assert robot.world_frame == "odom"
        assert not any("virtual_joint" in note.text for note in robot.notes)
    assert list(Robot.load(files / "fixed.urdf", choice=JointChoice("arm"), base_limits=AREA, **given).joints) == ARM


def test_slides_of_an_mjcf_take_the_limits(files: Path) -> None:
    pytest.importorskip("mujoco")
    robot = Robot.load(files / "cart.xml", tool="tool", base_limits=AREA)
    assert list(robot.joints) == ["x", "y", "t", "lift"]
    assert (robot.lower[:2].tolist(), robot.upper[:2].tolist()) == ([-1.5, -1.0], [1.5, 1.0])
    assert robot.continuous.tolist() == [False, False, True, False]


def test_a_base_drives_among_boxes_and_touches_none(files: Path) -> None:
    wall = [
        planner.Obstacle(f"wall{k}", planner.Box((0.1, 0.9, 0.8)), planner.pose([0, y, 0.4]))
        for k, y in enumerate((-0.75, 0.75))
    ]
    plan = planner.plan(
        files / "planar.urdf", planner.Scene("gap", tuple(wall)), start="q:-1,0.5,0,0,0.5,1", goal="xyz:1,-0.5,0.5",
        base_limits=AREA, nodes=150, refinement_rounds=2, timing=None,
    )  # fmt: skip
    assert plan.solved
    judge = CoalWorld(plan.checker.world)
    steps = zip(plan.path[:-1], plan.robot.difference(plan.path[:-1], plan.path[1:]), strict=True)
    assert min(judge.nearest_along(start, delta, 0.03, 0.001) for start, delta in steps) > 0.0
    assert (np.abs(plan.path[:, :2]) <= AREA[2:]).all()
    np.testing.assert_allclose(plan.robot.fk(plan.path[-1])[:3, 3], [1, -0.5, 0.5], atol=2e-6)


def test_the_limits_of_a_base_are_recorded_and_a_robot_file_may_have_them(files: Path, tmp_path: Path) -> None:
    how = [
        "--robot",
        str(files / "planar.urdf"),
        "--scene",
        "empty",
        "--start",
        "home",
        "--goal",
        "q:1,0.5,2,0,0.3,0.2",
    ]
    how += ["--path-only", "--no-page", "--out", str(tmp_path / "out")]
    assert run(["plan", *how, "--base-limits", "-1.5,-1,1.5,1"]) == 0
    assert json.loads((tmp_path / "out/plan.json").read_text())["config"]["base_limits"] == "-1.5,-1.0,1.5,1.0"
    assert run(["check", str(tmp_path / "out")]) == 0
    (tmp_path / "robot.yaml").write_text(f"urdf: {{file: {files / 'planar.urdf'}}}\nbase_limits: [-1.5, -1, 1.5, 1]\n")
    assert Robot.load(tmp_path / "robot.yaml").identity == Robot.load(files / "planar.urdf", base_limits=AREA).identity


REFUSED = {
    "no limits": ("planar.urdf", {}, "joint 'base/x' slides without limits: .* --base-limits x0,y0,x1,y1"),
    "a group without limits": (
        "fixed.urdf",
        {"srdf": "cart.srdf", "group": "all"},
        "moves the base by 'base'",
    ),
    "a base that stands": ("fixed.urdf", {"base_limits": AREA}, "base limits need a base that moves"),
    "the lesser corner last": ("planar.urdf", {"base_limits": (1, 1, 0, 0)}, "base limits must be x0,y0,x1,y1"),
    "words": ("planar.urdf", {"base_limits": "a,b"}, "base limits must be x0,y0,x1,y1"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(files: Path, case: str) -> None:
    name, given, said = REFUSED[case]
    given = {key: files / value if key == "srdf" else value for key, value in given.items()}
    with pytest.raises(PlannerError, match=said) as caught:
        planner.plan(files / name, "empty", start="home", goal="home", tool="tool", path_only=True, **given)
    assert "\n" not in str(caught.value)


def test_another_axis_is_refused(files: Path, tmp_path: Path) -> None:
    text = (
        (files / "planar.urdf").read_text().replace('<origin xyz="0 0 0.1"/></joint>', '<axis xyz="1 0 0"/></joint>', 1)
    )
    (tmp_path / "a.urdf").write_text(text)
    with pytest.raises(PlannerError, match="must have the axis 0 0 1"):
        Robot.load(tmp_path / "a.urdf", base_limits=AREA)
