"""The node: goals and chunks of targets come in, proven motions go out."""
# pyright: reportMissingImports=false

import threading
import traceback
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from planner.base.arrays import Floats
from planner.base.errors import OptionError, PlannerError, StateError
from planner.problem.request import PlanRequest, WorldRequest
from planner.robot.clouds import Points
from planner.robot.files.clouds import read_message
from planner.robot.robot import Robot
from planner.ros.messages import (
    find_frame,
    read_chunk,
    read_joints,
    read_pose,
    write_markers,
    write_trajectory,
)
from planner.ros.motion import Motion, check_rest, make_motion, stop_motion
from planner.session.gate import Gate
from planner.session.live_world import LiveWorld
from planner.session.session import Session
from planner.trajectory.trajectory import Trajectory

PARAMETERS: dict[str, tuple[Any, str]] = {
    "robot": ("", "name or file of the robot; without one the text on robot_description"),
    "scene": ("empty", "name or file of the scene"),
    "tool": ("", "frame that goals are for; without one that of the robot"),
    "margin": (0.005, "m around everything, for what the controller deviates"),
    "beta": (0.5, "weight of distance against manipulability, 0 to 1"),
    "on_unsafe": ("stop", "what follows an unproven chunk: stop, or slow (the same path, where it is proven then)"),
    "cloud_radius": (0.0, "m of solid around each point of a cloud; 0: estimated from the cloud"),
    "self_filter": (0.02, "m around the arm in which points of a cloud are left out"),
    "max_state_age": (0.5, "s after which a joint state is too old"),
    "joint_states": ("joint_states", "topic of the robot's state"),
    "points": ("~/points", "topic of point clouds"),
    "controller": ("~/trajectory", "topic of the motions that go to the controller"),
}
_LAST = QoSProfile(depth=1)  # a message that waits is replaced by the next one
_KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # those who come later get it too
_SENSOR = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class PlannerNode(Node):
    """Plan to goals, and let only proven motions pass to the controller.

    ``PARAMETERS`` are read once. Raises :class:`PlannerError` for unusable ones.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("planner", **options)
        self._turn = threading.Lock()  # who holds it decides what the controller gets
        self._world: tuple[Gate, Session] | None = None
        self._state: tuple[float, list[Floats]] | None = None
        self._shown: Trajectory | None = None
        self._running: tuple[float, Motion] | None = None
        self._last_words: dict[str, str] = {}  # by topic
        self._given = {name: self._read(name, *what) for name, what in PARAMETERS.items()}
        if self._given["on_unsafe"] not in ("stop", "slow"):
            raise OptionError(f"on_unsafe must be stop or slow, got '{self._given['on_unsafe']}': choose one.")
        PlanRequest.from_options(beta=self._given["beta"], margin=self._given["margin"])  # their ranges
        self._out = self.create_publisher(JointTrajectory, self._given["controller"], _LAST)
        self._reasons = self.create_publisher(String, "~/reason", 10)
        self._plans = self.create_publisher(JointTrajectory, "~/planned", _KEPT)
        self._markers = self.create_publisher(MarkerArray, "~/markers", _KEPT)
        quick, slow, seen = (MutuallyExclusiveCallbackGroup() for _ in range(3))
        self._listen(JointState, self._given["joint_states"], self._take_state, _SENSOR, quick)
        self._listen(JointTrajectory, "~/proposed", self._take_chunk, _LAST, quick)
        self._listen(PoseStamped, "~/goal_pose", self._take_pose, _LAST, slow)
        self._listen(JointState, "~/goal_joints", self._take_joints, _LAST, slow)
        self._listen(PointCloud2, self._given["points"], self._take_cloud, _SENSOR, seen)
        self.create_service(Trigger, "~/execute", self._execute, callback_group=quick)
        if self._given["robot"]:
            self._open(self._given["robot"])
        else:
            self._listen(String, "robot_description", self._take_description, _KEPT, slow)

    @property
    def gate(self) -> Gate | None:
        """The gate in the world that cameras see; None until the robot is known."""
        return None if self._world is None else self._world[0]

    def close(self) -> None:
        """End a running plan soon."""
        if self._world is not None:
            self._world[1].close()

    def _read(self, name: str, default: Any, text: str) -> Any:
        about = ParameterDescriptor(description=text, read_only=True)
        try:
            return self.declare_parameter(name, default, about).value
        except InvalidParameterTypeException as error:
            kind = {float: "a number with a point"}.get(type(default), "a text")
            raise OptionError(
                f"{name} must be {kind}, got another kind: give {name}:={default!r}, for example."
            ) from error

    def _listen(self, kind: Any, topic: str, act: Callable[[Any], str | None], quality: QoSProfile, group: Any) -> None:
        """Subscribe to a topic; ``act`` may return a sentence. Whatever a message holds, the node goes on."""

        def take(message: Any) -> None:
            try:
                sentence = act(message)
            except PlannerError as error:
                sentence = str(error)
            except Exception:
                self.get_logger().error(f"{topic}: the node failed on a message\n{traceback.format_exc()}")
                return
            if sentence is None:
                self._last_words.pop(topic, None)
            elif quality is not _SENSOR or sentence != self._last_words.get(topic):  # sensors repeat their faults
                self._say(topic, sentence)

        self.create_subscription(kind, topic, take, quality, callback_group=group)

    def _say(self, topic: str, sentence: str) -> None:
        """Publish a sentence, and log it unless it is the topic's last one."""
        self._reasons.publish(String(data=sentence))
        if sentence != self._last_words.get(topic):
            self.get_logger().warning(f"{topic}: {sentence}")
        self._last_words[topic] = sentence

    def _now(self) -> float:
        return self.get_clock().now().nanoseconds / 1e9

    def _open(self, robot: str | Robot) -> None:
        """Open the world; messages that need it were refused before."""
        tool = self._given["tool"] or None if isinstance(robot, str) else None
        world = LiveWorld(WorldRequest(robot, self._given["scene"], tool=tool, margin=self._given["margin"]))
        gate, session = Gate(world), Session(world)
        self._world = gate, session
        self.get_logger().info(f"{world.robot.name} in {world.scene.name}: ready for goals and chunks")

    def _require_world(self) -> tuple[Gate, Session]:
        if self._world is None:
            raise StateError("robot must come first, on robot_description or by the parameter robot: send it.")
        return self._world

    def _require_state(self) -> list[Floats]:
        """Return position and velocity of the robot (dof,)."""
        if self._state is None or self._now() - self._state[0] > self._given["max_state_age"]:
            age = "none" if self._state is None else f"one {self._now() - self._state[0]:.2f} s old"
            most = f"at most {self._given['max_state_age']:g} s old"
            raise StateError(f"joint state must be {most}, got {age}: start the robot's joint_state_broadcaster.")
        return self._state[1]

    def _take_description(self, message: String) -> None:
        if self._world is None:
            self._open(Robot.load(message.data, tool=self._given["tool"] or None))

    def _take_state(self, message: JointState) -> None:
        if self._world is None or not set(self._world[0].robot.joints) & set(message.name):
            return  # of a gripper
        self._state = self._now(), read_joints(message, self._world[0].robot, ("position", "velocity"))

    def _take_pose(self, message: PoseStamped) -> None:
        gate, _ = self._require_world()
        frame = find_frame(message.header, gate.robot, self._require_state()[0])
        self._plan(frame @ read_pose(message.pose))

    def _take_joints(self, message: JointState) -> None:
        self._plan(read_joints(message, self._require_world()[0].robot)[0])

    def _plan(self, goal: Floats) -> None:
        """Plan from the robot's state, and show the motion."""
        _, session = self._require_world()
        self._shown = None
        plan = session.plan(self._require_state()[0], goal, beta=self._given["beta"])
        motion = plan.trajectory
        if not plan.solved or motion is None or not motion.proven:
            raise PlannerError(plan.message if not plan.solved else "motion must be proven, got none: move the goal.")
        self._shown = motion
        self._plans.publish(write_trajectory(Motion((motion,), from_state=False)))
        self._markers.publish(write_markers(motion, plan.robot))
        self.get_logger().info(f"planned {motion.duration:.3f} s; the service ~/execute starts it")

    def _execute(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Start the motion that was shown last, if it is still proven and begins where the robot is."""
        try:
            gate, _ = self._require_world()
            with self._turn:
                motion = self._shown
                if motion is None:
                    raise StateError("a motion must be shown first, got none: send a goal.")
                verdict = gate.check(*motion.columns, times=motion.times, state=self._require_state(), stop=False)
                if not verdict:
                    raise StateError(f"{verdict}: send the goal again.")
                self._run(Motion((motion,), from_state=False))
                self._shown = None
            response.success, response.message = True, f"the motion takes {motion.duration:.3f} s"
        except PlannerError as error:
            response.success, response.message = False, str(error)
            self._say("~/execute", str(error))
        return response

    def _take_chunk(self, message: JointTrajectory) -> str | None:
        gate, _ = self._require_world()
        columns, times = read_chunk(message, gate.robot)
        with self._turn:
            state = self._require_state()
            verdict = gate.check(*columns, times=times, state=state)
            motion = make_motion(gate.robot.joints, columns, times, state, verdict, self._given["on_unsafe"] == "slow")
            if motion is not None:
                self._run(motion)
        if verdict:
            return None
        return str(verdict) if motion else f"{verdict}, and no stop is proven: nothing is sent"

    def _take_cloud(self, message: PointCloud2) -> str | None:
        """Put a cloud into the world, and check the rest of the motion under way in it."""
        gate, _ = self._require_world()
        q = self._require_state()[0]
        cloud = Points(read_message(message), self._given["cloud_radius"] or None)
        frame = find_frame(message.header, gate.robot, q)
        gate.world.see(
            f"cloud of {message.header.frame_id or 'the world'}", cloud, frame, q, self._given["self_filter"]
        )
        with self._turn:
            return self._check_again(gate)

    def _check_again(self, gate: Gate) -> str | None:
        """Stop the motion under way if its rest is not proven any more, and return the reason."""
        if self._running is None:
            return None
        begun, motion = self._running
        t = self._now() - begun
        verdict = check_rest(gate, motion, t)
        if verdict is None:
            return None
        stop = stop_motion(gate, motion, t)
        self._run(stop)
        return f"the world changed: {verdict}" + ("" if stop.proven else ", and no stop is proven")

    def _run(self, motion: Motion) -> None:
        self._out.publish(write_trajectory(motion))
        self._running = self._now(), motion
