"""The example robot with two arms of six joints on a torso, with grippers, and its SRDF."""

from pathlib import Path

from planner.robot.files.robot_files import JointChoice
from planner.robot.robot import Robot

_EXAMPLES = Path(__file__).parents[1] / "robots/examples"
BOTH = "left_tool,right_tool"


def two_arms() -> tuple[Path, Path]:
    """The URDF and the SRDF."""
    return _EXAMPLES / "two_arms.urdf", _EXAMPLES / "two_arms.srdf"


def load_two_arms(tool: str = BOTH) -> Robot:
    """The robot with both arms, without its torso."""
    urdf, srdf = two_arms()
    joints = tuple(f"{side}_{k}" for side in ("left", "right") for k in range(1, 7))
    return Robot.load(str(urdf), tool, choice=JointChoice(joints=joints), srdf=srdf)
