"""A node of the planner with its users: a robot that reports its state, a person, a policy, a camera."""

import time
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState, PointCloud2, PointField
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import MarkerArray

import planner
from planner.base.arrays import Floats
from planner.ros.node import PlannerNode
from tests.controller import Point, follow

KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ROOT = Path(__file__).resolve().parents[2]
PLANAR = ROOT / "robots" / "planar_2r"
ROBOT = planner.Robot.load("panda")
START = np.array([0.0, 0.0, 0.0, -1.571, 0.0, 1.571, 0.785])
BOARD = np.array([0.0, 1.2, 0.0, -0.6, 0.0, 1.571, 0.785])  # towards the shelf


class Cell:
    """A node of the planner in a namespace of its own, and a node that talks to it and remembers what it hears."""

    def __init__(self, name: str, **parameters: Any) -> None:
        self.q, self.qd, self.joints = START, 0 * START, ROBOT.joints
        self.heard: dict[str, list[Any]] = {"trajectory": [], "planned": [], "markers": [], "reason": []}
        self.executor, self.senders = MultiThreadedExecutor(4), dict[str, Any]()
        slow = {"max_state_age": 20.0} | parameters  # reports may wait on a loaded machine
        given = [Parameter(key, value=value) for key, value in slow.items()]
        self.planner = PlannerNode(namespace=name, parameter_overrides=given)
        self.user = Node("user", namespace=name)
        kinds = (JointTrajectory, JointTrajectory, MarkerArray, String)
        for (topic, messages), kind in zip(self.heard.items(), kinds, strict=True):
            quality = KEPT if topic in ("planned", "markers") else 10
            self.user.create_subscription(kind, f"planner/{topic}", messages.append, quality)
        self.executor.add_node(self.planner)
        self.executor.add_node(self.user)
        self.user.create_timer(0.02, self.report)
        self.execution = self.user.create_client(Trigger, "planner/execute")
        self.thread = Thread(target=self.executor.spin)
        self.thread.start()
        assert self.execution.wait_for_service(10.0)
        time.sleep(0.3)

    def report(self) -> None:
        self.send("joint_states", make_state(self.joints, self.q, self.qd))

    def send(self, topic: str, message: Any, quality: Any = 10) -> None:
        if topic not in self.senders:
            self.senders[topic] = self.user.create_publisher(type(message), topic, quality)
            wait(lambda: self.senders[topic].get_subscription_count() > 0)
        self.senders[topic].publish(message)

    def ask(self, topic: str, message: Any, answer: str, quality: Any = 10) -> Any:
        """Send a message; return the next message of the topic ``answer``."""
        before = len(self.heard[answer])
        self.send(topic, message, quality)
        wait(lambda: len(self.heard[answer]) > before)
        return self.heard[answer][before]

    def execute(self) -> Trigger.Response:
        answer = self.execution.call_async(Trigger.Request())
        wait(answer.done)
        return answer.result()

    def close(self) -> None:
        self.planner.close()
        self.executor.shutdown(5.0)
        self.thread.join()
        self.planner.destroy_node()
        self.user.destroy_node()


def wait(is_over: Callable[[], bool], seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not is_over():
        assert time.monotonic() < end, "nothing came"
        time.sleep(0.005)


def make_state(joints: Any, q: Floats, qd: Floats | None = None) -> JointState:
    velocity = [] if qd is None else [*qd[::-1], 0.0]
    return JointState(name=[*joints[::-1], "finger"], position=[*q[::-1], 0.02], velocity=velocity)


def make_chunk(columns: list[Floats], times: Floats, joints: Any = ROBOT.joints) -> JointTrajectory:
    """A chunk with its joints in the opposite order."""
    points = []
    for k, t in enumerate(times):
        clock = dict(zip(("sec", "nanosec"), divmod(round(1e9 * t), 10**9), strict=True))
        given = [column[k][::-1].tolist() for column in columns]
        rows = dict(zip(("positions", "velocities", "accelerations"), given, strict=False))
        points.append(JointTrajectoryPoint(**rows, time_from_start=Duration(**clock)))
    return JointTrajectory(joint_names=list(joints)[::-1], points=points)


def make_cloud(points: Floats, frame: str = "world") -> PointCloud2:
    fields = [PointField(name=name, offset=4 * k, datatype=7, count=1) for k, name in enumerate("xyz")]
    cloud = PointCloud2(height=1, width=len(points), fields=fields, point_step=16, row_step=16 * len(points))
    cloud.data = np.pad(points.astype("<f4"), ((0, 0), (0, 1))).tobytes()
    cloud.header.frame_id = frame
    return cloud


def make_pose(placement: Floats, frame: str) -> PoseStamped:
    message, turn = PoseStamped(), Rotation.from_matrix(placement[:3, :3]).as_quat()
    message.header.frame_id = frame
    for name, value in zip("xyz", placement[:3, 3], strict=True):
        setattr(message.pose.position, name, float(value))
    for name, value in zip("xyzw", turn, strict=True):
        setattr(message.pose.orientation, name, float(value))
    return message


def turn(length: float) -> PoseStamped:
    message = make_pose(np.eye(4), "world")
    message.pose.orientation.w = length
    return message


def cut(cloud: PointCloud2) -> PointCloud2:
    cloud.data = cloud.data[:-4]
    return cloud


def read(message: JointTrajectory) -> list[Point]:
    points = []
    for point in message.points:
        columns = [np.array(row) for row in (point.positions, point.velocities, point.accelerations) if len(row)]
        points.append((point.time_from_start.sec * 10**9 + point.time_from_start.nanosec, columns))
    return points


def play(message: JointTrajectory, state: list[Floats]) -> Floats:
    """Return the positions of a controller that gets the message, every 2 ms."""
    points = read(message)
    return follow(points, state, np.append(np.arange(0.0, points[-1][0] * 1e-9, 0.002), points[-1][0] * 1e-9))


def is_free(rows: Floats, scene: Any = "shelf") -> bool:
    """Whether coal, which the node does not use, finds no contact."""
    return planner.make_checker(ROBOT, scene, backend="coal").first_contact(rows) is None


def make_box(centre: Floats, half: float = 0.1) -> Floats:
    """Points on the surface of a cube."""
    line = np.linspace(-half, half, 6)
    rows = np.array([[x, y, z] for x in line for y in line for z in line if max(map(abs, (x, y, z))) > 0.99 * half])
    return centre + rows
