"""Run an exported trajectory on a robot with ROS 2 and rosbridge, from a machine without ROS.

python follow_by_rosbridge.py trajectory-ros-json.json [CONTROLLER [HOST [PORT]]]
"""

import json
import sys
from pathlib import Path

import roslibpy

DEFAULTS = ["/joint_trajectory_controller", "127.0.0.1", "9090"]


def main(file: str, controller: str, host: str, port: str) -> int:
    """Send the goal, wait for the result, and return 0 if the controller has reached it."""
    goal = {"trajectory": json.loads(Path(file).read_text()), "goal_time_tolerance": {"sec": 1, "nanosec": 0}}
    ros, results = roslibpy.Ros(host=host, port=int(port)), []
    ros.run(timeout=10)
    name = f"{controller}/follow_joint_trajectory"
    client = roslibpy.ActionClient(ros, name, "control_msgs/action/FollowJointTrajectory")
    number = client.send_goal(roslibpy.Goal(goal), results.append, lambda feedback: None, results.append)
    client.wait_goal(number)
    ros.terminate()
    print(results[0])
    return 0 if results[0].get("status") == roslibpy.GoalStatus.SUCCEEDED else 1


if __name__ == "__main__":
    given = sys.argv[1:]
    sys.exit(main(*given, *DEFAULTS[len(given) - 1 :]))
