"""The gate as steps of LeRobot's processors, with the gate in this process or behind a server.

Only ``planner.lerobot.steps`` imports lerobot. With the gate behind ``planner serve`` nothing here loads a robot
library.
"""

from planner.lerobot.action_filter import ActionFilter, Filtered
from planner.lerobot.gates import LocalGate, ServedGate
from planner.lerobot.joint_map import JointMap

__all__ = ["ActionFilter", "Filtered", "JointMap", "LocalGate", "ServedGate"]
