"""The example for rosbridge: a server with its protocol gets a goal as the published definitions have it."""

import json
import re
import subprocess
import sys
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
from websockets.sync.server import ServerConnection, serve

import planner

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "howto" / "follow_by_rosbridge.py"
GOAL = {  # of control_msgs/action/FollowJointTrajectory, github.com/ros-controls/control_msgs, jazzy
    *("trajectory", "multi_dof_trajectory", "path_tolerance", "component_path_tolerance"),
    *("goal_tolerance", "component_goal_tolerance", "goal_time_tolerance"),
}


def published(name: str) -> set[str]:
    """The fields of a message, as its wheel has them."""
    folder = Path(sys.prefix) / "share" / "trajectory_msgs" / "msg"
    lines = re.sub("#.*", "", (folder / f"{name}.msg").read_text()).splitlines()
    return {line.split()[1] for line in lines if line.strip()}


def test_the_example_sends_a_goal_that_the_controller_knows(tmp_path: Path) -> None:
    goals: list[dict[str, Any]] = []

    def answer(client: ServerConnection) -> None:
        for frame in client:
            goals.append(json.loads(frame))
            done = {"op": "action_result", "action": goals[-1]["action"], "id": goals[-1]["id"], "result": True}
            client.send(json.dumps({**done, "status": 4, "values": {"error_code": 0}}))

    motion = planner.Trajectory.from_points(("a", "b"), np.array([0.0, 1.5]), np.eye(2), 0 * np.eye(2), 0 * np.eye(2))
    file = tmp_path / "trajectory-ros-json.json"
    file.write_bytes(planner.export(motion, "ros-json"))
    with serve(answer, "127.0.0.1", 0) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        command = [sys.executable, EXAMPLE, file, "/arm", "127.0.0.1", str(server.socket.getsockname()[1])]
        run = subprocess.run(command, capture_output=True, text=True, timeout=60)
        server.shutdown()
    assert run.returncode == 0, run.stderr
    (goal,) = goals
    assert goal["op"] == "send_action_goal"
    assert goal["action"] == "/arm/follow_joint_trajectory"
    assert goal["action_type"] == "control_msgs/action/FollowJointTrajectory"
    assert set(goal["args"]) <= GOAL
    message = goal["args"]["trajectory"]
    assert set(message) == published("JointTrajectory")
    assert set(message["points"][0]) == published("JointTrajectoryPoint")
    assert message["points"][1]["time_from_start"] == {"sec": 1, "nanosec": 500_000_000}
