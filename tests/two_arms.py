"""A small robot with two arms of six joints on a torso that turns, with grippers, and its SRDF."""

from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp

from planner.robot.files.robot_files import JointChoice
from planner.robot.robot import Robot
from tests.worlds import joint_xml, link_xml

BOTH = "left_tool,right_tool"
# axis and offset from the joint before, length of the link along z
_JOINTS = [("0 0 1", 0.0, 0.0), ("0 1 0", 0.1, 0.3), ("0 1 0", 0.3, 0.0), ("0 0 1", 0.1, 0.2), ("0 1 0", 0.2, 0.0)]
_JOINTS += [("0 0 1", 0.08, 0.0)]
_SRDF = """<robot name="two_arms">
<group name="left"><chain base_link="torso" tip_link="left_tool"/></group>
<group name="right"><chain base_link="torso" tip_link="right_tool"/></group>
<group name="waist"><joint name="waist"/></group>
<group name="hand"><joint name="left_finger"/></group>
<group name="both"><group name="left"/><group name="right"/></group>
<group name="whole"><group name="waist"/><group name="left"/><group name="right"/><group name="hand"/></group>
<group_state name="low" group="left"><joint name="left_1" value="0.4"/>{left}</group_state>
<group_state name="low" group="right"><joint name="right_1" value="-0.4"/>{right}</group_state>
<end_effector name="gripper" parent_link="left_tool" group="hand"/>
<passive_joint name="loose"/>
{pairs}</robot>"""


def _arm(side: str, y: float, spread: float) -> str:
    xml, parent = "", "torso"
    for k, (axis, along, length) in enumerate(_JOINTS, 1):
        at = {"xyz": f"0 0 {along}"} if k > 1 else {"xyz": f"0 {y} 0.4", "rpy": f"{spread} 0 0"}
        origin = f'<origin xyz="0 0 {length / 2}"/>'
        xml += joint_xml(f"{side}_{k}", parent, f"{side}_link{k}", axis=axis, limit="-2.6 2.6", **at)
        shape = f'<cylinder radius="0.03" length="{length}"/>' if length else ""
        xml += link_xml(f"{side}_link{k}", shape, origin)
        parent = f"{side}_link{k}"
    tip = f'<joint name="{side}_tip" type="fixed"><parent link="{parent}"/><child link="{side}_tool"/>'
    xml += f'{tip}<origin xyz="0.02 0 0.1"/></joint>{link_xml(f"{side}_tool")}'
    xml += joint_xml(f"{side}_finger", f"{side}_tool", f"{side}_tip", "prismatic", limit="0 0.02")
    return xml + link_xml(f"{side}_tip", '<sphere radius="0.02"/>')


def write_two_arms(folder: Path) -> tuple[Path, Path]:
    """Write the URDF and the SRDF; return their paths."""
    body = link_xml("base", '<box size="0.3 0.3 0.1"/>') + joint_xml("waist", "base", "torso", xyz="0 0 0.1")
    body += link_xml("torso", '<box size="0.12 0.2 0.6"/>', '<origin xyz="0 0 0.2"/>')
    body += joint_xml("loose", "torso", "flag", xyz="0 0 0.6") + link_xml("flag")
    urdf, srdf = folder / "two_arms.urdf", folder / "two_arms.srdf"
    urdf.write_text(f'<robot name="two_arms">{body}{_arm("left", 0.2, -0.6)}{_arm("right", -0.2, 0.6)}</robot>')
    state = {
        side: "".join(f'<joint name="{side}_{k}" value="{0.3 * (-1) ** k}"/>' for k in range(2, 7))
        for side in ("left", "right")
    }
    touching = [(f"{s}_link{k}", f"{s}_link{k + 1}") for s in ("left", "right") for k in range(1, 6)]
    touching += [
        (f"{s}_link{a}", b) for s in ("left", "right") for a, b in ((6, f"{s}_tip"), (2, "torso"), (4, f"{s}_tip"))
    ]
    pairs = "".join(f'<disable_collisions link1="{a}" link2="{b}"/>' for a, b in touching)
    srdf.write_text(_SRDF.format(**state, pairs=pairs))
    return urdf, srdf


@lru_cache(maxsize=1)
def two_arms() -> tuple[Path, Path]:
    """The same files, written once."""
    return write_two_arms(Path(mkdtemp()))


def load_two_arms(tool: str = BOTH) -> Robot:
    """The robot with both arms, without its torso."""
    urdf, srdf = two_arms()
    joints = tuple(f"{side}_{k}" for side in ("left", "right") for k in range(1, 7))
    return Robot.load(str(urdf), tool, choice=JointChoice(joints=joints), srdf=srdf)
