"""SRDF files: groups become joints, states become values."""

from pathlib import Path

import pytest

from planner.robot.files.robot_files import JointChoice, read_robot
from planner.robot.files.srdf import group_joints
from planner.robot.robot import Robot
from tests.two_arms import two_arms
from tests.worlds import joint_xml, link_xml

SRDF = """<robot name="arm">
  <group name="arm"><chain base_link="column" tip_link="hand"/></group>
  <group name="by_joints"><joint name="elbow"/><joint name="lift"/><joint name="weld"/></group>
  <group name="by_link"><link name="column"/></group>
  <group name="all"><group name="arm"/><group name="by_link"/></group>
  <group name="round"><group name="turn"/></group><group name="turn"><group name="round"/></group>
  <group name="welded"><joint name="weld"/></group>
  <group name="foreign"><joint name="nose"/></group>
  <group name="backwards"><chain base_link="hand" tip_link="column"/></group>
  <group_state name="home" group="all">
    <joint name="lift" value="0.3"/><joint name="shoulder" value="0.1"/><joint name="elbow" value="-0.2"/>
  </group_state>
  <group_state name="ready" group="arm">
    <joint name="shoulder" value="0.5"/><joint name="elbow" value="0.6"/>
  </group_state>
  <disable_collisions link1="column" link2="fore" reason="Never"/>
</robot>"""


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A column that lifts, two joints, and a hand welded on."""
    box = '<box size="0.1 0.1 0.1"/>'
    links = "".join(link_xml(name, box) for name in ("base", "column", "upper", "fore")) + link_xml("hand")
    joints = joint_xml("lift", "base", "column", "prismatic", limit="0 1")
    joints += joint_xml("shoulder", "column", "upper", xyz="0 0 0.3") + joint_xml(
        "elbow", "upper", "fore", xyz="0.4 0 0"
    )
    joints += joint_xml("weld", "fore", "hand", "fixed", xyz="0.3 0 0")
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>')
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path


def load(folder: Path, **options: str) -> Robot:
    choice = JointChoice(options.get("group"), tuple(options["joints"].split(",")) if "joints" in options else None)
    return Robot.load(str(folder / "arm.urdf"), choice=choice, srdf=folder / "arm.srdf")


@pytest.mark.parametrize(
    ("group", "joints"),
    [
        ("arm", ["shoulder", "elbow"]),
        ("by_joints", ["lift", "elbow"]),
        ("by_link", ["lift"]),
        ("all", ["lift", "shoulder", "elbow"]),
    ],
)
def test_groups(arm: Path, group: str, joints: list[str]) -> None:
    files = read_robot(str(arm / "arm.urdf"), arm / "arm.srdf")
    assert files.srdf is not None
    assert group_joints(files.srdf, group, files.description, files.model) == joints


def test_groups_of_groups_have_a_tool_for_each_arm() -> None:
    urdf, srdf = two_arms()
    arms = {side: [f"{side}_{k}" for k in range(1, 7)] for side in ("left", "right")}
    low = {side: (0.4 if side == "left" else -0.4, 0.3, -0.3, 0.3, -0.3, 0.3) for side in arms}
    for group, tool, joints, state in (
        ("left", "left_tool", arms["left"], low["left"]),
        ("both", "left_tool,right_tool", [*arms["left"], *arms["right"]], low["left"] + low["right"]),
        ("whole", "left_tool,right_tool", ["waist", *arms["left"], "left_finger", *arms["right"]], None),
    ):
        robot = Robot.load(str(urdf), choice=JointChoice(group), srdf=srdf)
        assert (robot.tool_text, list(robot.joints), robot.jacobian_rows) == (tool, joints, "pose")
        assert robot.states.get("low") == state
        assert robot.notes == () or all("two_arms" not in note.text for note in robot.notes)
    swapped = Robot.load(str(urdf), "right_tool,left_tool", choice=JointChoice("both"), srdf=srdf)
    assert swapped.tools == ("right_tool", "left_tool")


def test_a_group_holds_the_rest_where_home_has_it(arm: Path) -> None:
    whole, robot = load(arm), load(arm, group="arm")
    assert (robot.joints, robot.tool) == (("shoulder", "elbow"), "hand")
    assert robot.fixed_joints == {"lift": 0.3}
    assert robot.home.tolist() == [0.1, -0.2]
    assert whole.home.tolist() == [0.3, 0.1, -0.2]
    assert whole.identity != robot.identity
    assert load(arm, joints="elbow,shoulder").identity == robot.identity  # in whatever order they are named


UNREAD = [
    (
        '<disabel_collisions link1="base" link2="fore"/>',
        "skipped: disabel_collisions.",
    ),  # lines, and the end of the one note on them
    ('<others><disable_collisions link1="base" link2="fore"/></others>', "skipped: others."),
    ('<virtual_joint name="v" type="floating" child_link="base"/>', "give it a base: floating."),
    ('<passive_joint name="elbwo"/><disable_collisions link1="fore" link2="hnad"/>', "skipped: elbwo, hnad."),
    ('<group_state name="s" group="arm"><joint name="sholder" value="1"/></group_state>', "skipped: sholder."),
    ('<group_state name="s"><joint name="elbow" value="0.5 0.3"/></group_state>', "joint 'elbow' in state 's'."),
    ('<end_effector name="e" parent_link="fore" group="g"/>', None),
]


@pytest.mark.parametrize(("lines", "said"), UNREAD)
def test_the_parts_that_are_not_read_are_named(arm: Path, lines: str, said: str | None) -> None:
    """Neither do they count: the same joints are planned, the same pairs checked."""
    before = load(arm)
    (arm / "arm.srdf").write_text(SRDF.replace("</robot>", f"{lines}</robot>"))
    robot = load(arm)
    assert [note.text[note.text.rindex(said or "x") :] for note in robot.notes] == ([said] if said else [])
    assert robot.joints == before.joints
    more = (robot.disabled_pairs or frozenset()) - (before.disabled_pairs or frozenset())
    assert more <= {frozenset(("fore", "hnad"))}


def test_collisions_that_are_off_by_default(arm: Path) -> None:
    """Against every other link, but for the pairs that are enabled; a pair that is disabled stays so."""
    lines = '<disable_default_collisions link="fore"/><enable_collisions link1="fore" link2="base"/>'
    lines += '<enable_collisions link1="column" link2="fore"/>'
    (arm / "arm.srdf").write_text(SRDF.replace("</robot>", f"{lines}</robot>"))
    robot = load(arm)
    others = ("column", "upper", "hand")
    assert robot.disabled_pairs == {frozenset(("fore", other)) for other in others}
    assert robot.notes[0].grave
    assert robot.notes[0].text.endswith("checked against obstacles only: fore.")
    assert load(arm).identity != Robot.load(str(arm / "arm.urdf")).identity


# robot.yaml by path


def written(folder: Path, more: str) -> str:
    path = folder / "robot.yaml"
    path.write_text(f"urdf: {{file: arm.urdf}}\nsrdf: {{file: arm.srdf}}\ntool: hand\n{more}")
    return str(path)


def test_a_robot_file_by_path_or_by_its_folder(arm: Path) -> None:
    path = written(arm, "home: [0.2, 0, 0]\nfixed_joints: {lift: 0.7}")
    robot = Robot.load(path)
    assert (robot.name, robot.joints, robot.fixed_joints) == ("arm", ("shoulder", "elbow"), {"lift": 0.7})
    assert Robot.load(str(arm)).identity == robot.identity
    assert Robot.load(written(arm, "name: mine")).name == "mine"
