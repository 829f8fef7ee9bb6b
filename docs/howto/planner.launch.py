"""Start the planner for a robot whose description and joint states are published: ros2 launch planner.launch.py"""

import sys

from launch import LaunchDescription
from launch_ros.actions import Node

CONTROLLER = "/joint_trajectory_controller/joint_trajectory"


def generate_launch_description() -> LaunchDescription:
    planner = Node(
        executable=sys.executable,  # of the environment with gabf-planner and rclpy
        arguments=["-m", "planner.ros"],
        parameters=[{"scene": "table", "margin": 0.005, "on_unsafe": "slow", "controller": CONTROLLER}],
        remappings=[("~/points", "/camera/depth/points"), ("~/proposed", "/policy/chunk")],
        output="screen",
    )
    return LaunchDescription([planner])
