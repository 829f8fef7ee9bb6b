"""Messages of ROS 2 to arrays and back; frames are those of the robot, or the world."""
# pyright: reportMissingImports=false

from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, Pose, Vector3
from sensor_msgs.msg import JointState
from std_msgs.msg import ColorRGBA, Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

from planner.base.arrays import Floats
from planner.base.errors import ArrayError, OptionError, RobotError, StateError, choices
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.ros.motion import Motion
from planner.trajectory.trajectory import Trajectory

WORLD = ("", "world")  # names of the world's frame
_ARMS = 12  # of a motion, drawn as lines


def read_joints(message: JointState, robot: Robot, columns: Sequence[str] = ("position",)) -> list[Floats]:
    """Return positions, or other columns, (dof,) in the robot's order; :class:`StateError` if missing."""
    missing = [name for name in robot.joints if name not in message.name]
    if missing:
        raise StateError(f"joints of the message must include {choices(missing)}, got {choices(message.name)}.")
    order, rows = [list(message.name).index(name) for name in robot.joints], list[Floats]()
    for column in columns:
        values = np.array(getattr(message, column))
        if len(values) != len(message.name):
            raise StateError(f"{column} must have a value per name ({len(message.name)}), got {len(values)}: send all.")
        rows.append(values[order])
        if not np.isfinite(rows[-1]).all():
            raise StateError(f"{column} must be finite, got NaN or infinity: look at the sender.")
    return rows


def read_chunk(message: JointTrajectory, robot: Robot) -> tuple[list[Floats], Floats]:
    """Return the columns (k, dof) of a chunk in the robot's order, and its times (k,) s from now.

    Raises :class:`ArrayError` for other joints, for points of several kinds, and for a start at another time than now.
    """
    names = list(message.joint_names)
    if sorted(names) != sorted(robot.joints):
        raise ArrayError(f"joint_names must be {choices(robot.joints)}, got {choices(names) or 'none'}: send these.")
    if message.header.stamp.sec or message.header.stamp.nanosec:
        raise ArrayError("stamp must be 0, which starts the motion on arrival, got another time: leave it out.")
    order, columns = [names.index(name) for name in robot.joints], list[Floats]()
    for column in ("positions", "velocities", "accelerations"):
        rows = [getattr(point, column) for point in message.points]
        if column != "positions" and not any(map(len, rows)):
            break
        sizes = sorted({len(row) for row in rows} - {len(names)})
        if sizes:
            raise ArrayError(f"{column} of a point must have {len(names)} values, got {sizes[0]}: send whole points.")
        columns.append(np.array(rows).reshape(-1, len(names))[:, order])
    times = [point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec for point in message.points]
    return columns, np.array(times)


def read_pose(message: Pose) -> Floats:
    """Return the placement (4, 4) of a Pose; :class:`OptionError` for a quaternion of another length."""
    position, turn = message.position, message.orientation
    quaternion = np.array([turn.x, turn.y, turn.z, turn.w])
    if not abs(float(np.linalg.norm(quaternion)) - 1.0) < 1e-3:
        raise OptionError(f"quaternion must have length 1, got {np.linalg.norm(quaternion):g}: send a rotation.")
    return pose([position.x, position.y, position.z], quaternion=quaternion.tolist())


def find_frame(header: Header, robot: Robot, q: Floats) -> Floats:
    """Return the pose (4, 4) of a message's frame in the world, with the robot at ``q`` (dof,)."""
    if header.frame_id in (*WORLD, robot.world_frame):
        return np.eye(4)
    try:
        return robot.fk(q, header.frame_id)
    except RobotError as error:
        raise RobotError(f"{error} The node reads no TF; the world is '{WORLD[1]}'.") from None


def write_trajectory(motion: Motion) -> JointTrajectory:
    """Return the motion as a message for a controller, which begins on arrival."""
    names, points = list(motion.parts[0].joints), list[JointTrajectoryPoint]()
    for clock, columns in motion.points():
        fields = zip(("positions", "velocities", "accelerations"), map(np.ndarray.tolist, columns), strict=False)
        points.append(JointTrajectoryPoint(**dict(fields), time_from_start=Duration(**_split(clock))))
    return JointTrajectory(joint_names=names, points=points)


def write_markers(motion: Trajectory, robot: Robot) -> MarkerArray:
    """Return the line of the tool, and arms along the motion as lines through joints, in the robot's root."""
    root = robot.model.frames[1].name
    to_root = np.linalg.inv(robot.fk(robot.home, root))
    line, arms = (
        robot.fk(motion.sample(0.02).positions),
        motion.at(np.linspace(motion.times[0], motion.times[-1], _ARMS)),
    )
    bones = np.stack([robot.fk(arms, frame)[:, :3, 3] for frame in (root, *robot.joints, robot.tool)], axis=1)
    pairs = np.stack([bones[:, :-1], bones[:, 1:]], axis=2).reshape(-1, 3)
    shown = (("tool", Marker.LINE_STRIP, line[:, :3, 3], 0.006), ("arms", Marker.LINE_LIST, pairs, 0.01))
    markers = []
    for k, (name, kind, points, width) in enumerate(shown):
        color, header = ColorRGBA(r=0.1, g=0.5 + 0.4 * (1 - k), b=0.9 * k, a=1.0 - 0.6 * k), Header(frame_id=root)
        marker = Marker(header=header, ns=name, type=kind, action=Marker.ADD, color=color, scale=Vector3(x=width))
        marker.pose.orientation.w = 1.0
        rows = (points @ to_root[:3, :3].T + to_root[:3, 3]).tolist()
        marker.points = [Point(x=x, y=y, z=z) for x, y, z in rows]
        markers.append(marker)
    return MarkerArray(markers=markers)


def _split(clock: int) -> dict[str, int]:
    return dict(zip(("sec", "nanosec"), divmod(clock, 10**9), strict=True))
