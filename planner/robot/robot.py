"""The robot arm: planned joints, limits, bodies and tool frame."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from planner.base.arrays import Floats, frozen, numbers, placement
from planner.base.cache import content_hash
from planner.base.errors import ArrayError, FileError, Note, OptionError, RobotError
from planner.base.files import StrPath
from planner.kinematics.arm import Arm, frame_id, tool_names
from planner.kinematics.forward import Chain, joint_placements
from planner.kinematics.inverse import TOLERANCE, Tolerance, solve
from planner.kinematics.manipulability import (
    full_jacobians,
    jacobians,
    least_of_tools,
    manipulability,
    measure_name,
)
from planner.robot.files import urdf
from planner.robot.files.meshes import collada_notes
from planner.robot.files.pinocchio_models import files_of_model, require_limits
from planner.robot.files.planar import REMEDY
from planner.robot.files.robot_files import ALL_JOINTS, JointChoice, MotionFile, RobotFiles, read_robot
from planner.robot.files.srdf import states_of_joints
from planner.robot.files.urdf_geometry import mesh_files, read_bodies
from planner.robot.poses import pose
from planner.robot.shapes import Body, Carried

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False, kw_only=True)
class Robot(Arm):
    """A robot arm; configurations are (n, dof) arrays of joint values in rad (m for sliding joints).

        robot = Robot.load("iiwa14")
        robot.joints, robot.lower, robot.upper
        robot.fk(robot.home), robot.jacobian(robot.home), robot.manipulability(robot.home)

    A continuous joint has one angle; ``continuous`` marks the joints that may wrap.
    """

    name: str
    description: str
    velocity: Floats  # (dof,) rad/s, m/s for sliding joints, 0 if the URDF has no limit
    bodies: tuple[Body, ...]
    disabled_pairs: frozenset[frozenset[str]] | None  # None: not specified
    fixed_joints: Mapping[str, float]
    base: Floats  # (4, 4)
    source: urdf.Description = field(repr=False)
    carried: tuple[Body, ...] = ()  # payload among ``bodies``
    touching: frozenset[frozenset[str]] = frozenset()  # allowed contacts of the payload, by name
    states: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # SRDF states of the planned joints
    motion: MotionFile | None = None  # of the planned joints, in their order; None: not specified
    shares: Mapping[str, float] = field(default_factory=dict)  # of its velocities and accelerations, as a request asks
    world_frame: str = ""  # the SRDF's name of the frame of the base
    notes: tuple[Note, ...] = ()  # on ignored content of its files and of a request
    parts: Mapping[str, Robot] = field(default_factory=dict, repr=False)  # of a composite robot, by prefix

    def __repr__(self) -> str:
        return f"<Robot: {self.name}, {self.dof} joints, tool {self.tool_text}>"

    @staticmethod
    def load(
        name: StrPath,
        tool: str | None = None,
        fixed_joints: Mapping[str, float] | None = None,
        base: Floats | None = None,
        choice: JointChoice = ALL_JOINTS,
        srdf: StrPath | None = None,
        base_limits: Sequence[float] | None = None,
    ) -> Robot:
        """Load a built-in robot by name, or any robot from a robot.yaml, a URDF path or URDF text.

        ``tool`` is a frame of the URDF (default: a usual tool name or the only tip), or several with commas between,
        the main one first; ``fixed_joints`` holds joints at values (rad, m), ``base`` (4, 4) places the robot in the
        world, ``choice`` selects the planned joints, ``srdf`` replaces the robot's own. ``base_limits`` are x0, y0, x1,
        y1 (m) of a base that moves in a plane. Raises :class:`RobotError` with the valid choices.
        """
        area = None if base_limits is None else tuple(map(float, base_limits))
        return assemble(read_robot(name, srdf, area), tool, choice, fixed_joints, base)

    @staticmethod
    def from_pinocchio(
        model: pin.Model,
        collision: pin.GeometryModel,
        visual: pin.GeometryModel | None = None,
        tool: str | None = None,
        fixed_joints: Mapping[str, float] | None = None,
        base: Floats | pin.SE3 | None = None,
        choice: JointChoice = ALL_JOINTS,
    ) -> Robot:
        """Return a robot from Pinocchio's model and its collision and visual geometry.

            Robot.from_pinocchio(*pinocchio.buildModelsFromUrdf("arm.urdf"), tool="tool0")

        Mimic joints follow. Collision pairs select the link pairs to check; without any, these are computed. Other
        arguments are as in :meth:`load`. Raises :class:`RobotError` for unsupported joints and shapes.
        """
        return assemble(files_of_model(model, collision, visual), tool, choice, fixed_joints, base)

    def fk(self, q: ArrayLike, frame: str | None = None) -> Floats:
        """Return the pose (..., 4, 4) of a frame (default: the tool) at configurations (..., dof).

            robot = planner.Robot.load("panda")
            robot.fk(robot.home)[:3, 3]                  # the tool's position, m
            robot.fk([robot.home, robot.home], "panda_link4").shape

        Raises :class:`RobotError` for an unknown frame, :class:`ArrayError` for other shapes.
        """
        rows, shape = self._configurations(q)
        at = self.model.frames[self._frame(frame)]
        rotation, position = (each[int(at.parentJoint)] for each in joint_placements(Chain.from_arm(self), rows))
        poses = np.tile(np.eye(4), (len(rows), 1, 1))
        poses[:, :3, :3] = rotation @ at.placement.rotation
        poses[:, :3, 3] = position + rotation @ at.placement.translation
        return poses.reshape(*shape, 4, 4)

    def jacobian(self, q: ArrayLike, frame: str | None = None) -> Floats:
        """Return the Jacobian (..., 6, dof) of a frame (default: the tool) at configurations (..., dof).

            robot.jacobian(q) @ qd                       # linear (m/s), then angular velocity (rad/s), world axes

        Linear rows are those of the frame's origin. Raises as :meth:`fk` does.
        """
        rows, shape = self._configurations(q)
        return full_jacobians(self, rows, self._frame(frame)).reshape(*shape, 6, self.dof)

    def ik(
        self,
        pose: ArrayLike | pin.SE3 | Mapping[str, ArrayLike | pin.SE3],
        near: ArrayLike | None = None,
        *,
        tolerance: Tolerance = TOLERANCE,
        starts: int = 50,
        seed: int = 0,
    ) -> Floats:
        """Return configurations (k, dof) within limits for a tool pose (4, 4) or position (3,), m.

            robot.ik(robot.fk(q), near=q)[0]             # q again
            robot.ik([0.5, 0.1, 0.4])                    # any orientation
            robot.ik({"panda_link4": robot.fk(q, "panda_link4")[:3, 3], "panda_hand": robot.fk(q, "panda_hand")})

        Damped least squares from ``starts`` seeds, to within ``tolerance`` (m, rad). Solutions are sorted by
        manipulability, or by distance from the configuration ``near`` (dof,). They may collide. The result is (0, dof)
        if no solution exists.
        """
        at_once = pose if isinstance(pose, Mapping) else {self.tool: pose}
        targets = [_pose_or_position(each) for each in at_once.values()]
        if not targets:
            raise OptionError("pose must have a frame or more, got none: give {frame: pose}, for example.")
        rng = np.random.default_rng(seed)
        begin = None if near is None else numbers("near", near, (self.dof,))[None]
        arm = with_tool(self, ",".join(at_once))
        solutions = solve(arm, targets, rng, starts, begin, tolerance).configurations
        if begin is None:
            return solutions[np.argsort(-manipulability(self, solutions), kind="stable")]
        return solutions[np.argsort(np.linalg.norm(self.difference(begin, solutions), axis=1), kind="stable")]

    def manipulability(self, q: ArrayLike) -> Floats:
        """Return Yoshikawa's w (...), or the robot's own measure, at configurations (..., dof).

            robot.manipulability(robot.home)

        w is the product of the singular values of the rows ``robot.jacobian_rows`` of the tool's Jacobian: m³ for
        "pose" and "translation", no unit for "rotation", m² for "planar"; 0 at singularities. With several tools it is
        the least w of any of them.
        """
        rows, shape = self._configurations(q)
        return manipulability(self, rows).reshape(shape)

    def condition_number(self, q: ArrayLike) -> Floats:
        """Return the condition number (...) of the rows ``robot.jacobian_rows``; inf at singularities.

        With several tools it is the largest of any of them.

            robot.condition_number(robot.home)

        "pose" mixes metres and radians, so its value depends on the unit of length.
        """
        rows, shape = self._configurations(q)

        def inverse(arm: Arm) -> Floats:
            values = np.linalg.svd(jacobians(arm, rows), compute_uv=False)
            largest, least = values[:, 0], values[:, -1]
            return -np.divide(largest, least, out=np.full(len(rows), np.inf), where=least > 0.0)

        return -least_of_tools(self, inverse).reshape(shape)

    def _frame(self, name: str | None) -> int:
        return self.tool_id if name is None else frame_id(self.model, name)

    def _configurations(self, q: ArrayLike) -> tuple[Floats, tuple[int, ...]]:
        """Return configurations (..., dof) as rows (n, dof), and the leading shape."""
        given = np.asarray(q, dtype=float)
        if given.ndim < 1 or given.shape[-1] != self.dof:
            text = f"q must be an array of shape (..., {self.dof}), got {given.shape}: give a value for each joint."
            raise ArrayError(text)
        return np.ascontiguousarray(given.reshape(-1, self.dof)), given.shape[:-1]

    @cached_property
    def identity(self) -> str:
        """A hash of everything that determines placed geometry and checked pairs."""
        model, tool = self.model, self.model.frames[self.tool_id]
        disabled = None if self.disabled_pairs is None else sorted(sorted(pair) for pair in self.disabled_pairs)
        values: list[Any] = [self.joints, self.lower, self.upper, self.continuous, self.jacobian_rows, disabled]
        values += [sorted(sorted(pair) for pair in self.touching)]
        if self.measure != "yoshikawa":
            values.append(measure_name(self.measure))
        values += [int(tool.parentJoint), np.array(tool.placement.homogeneous), *self.other_tools]
        for joint in range(1, model.njoints):
            values += [int(model.parents[joint]), model.joints[joint].shortname()]
            values += [np.array(model.jointPlacements[joint].homogeneous)]
        # joint placements after a motion of all joints identify axes that are not coordinate axes
        data = model.createData()
        pin.forwardKinematics(model, data, np.full(model.nq, 0.5))
        values += [np.round(data.oMi[joint].homogeneous, 9) + 0.0 for joint in range(1, model.njoints)]
        values += [[item.joint, item.leader, item.multiplier, item.offset] for item in self.followers]
        for body in self.bodies:
            values += [body.link, body.joint, body.placement, *body.shape.content()]
        return content_hash(values)


def with_carried(robot: Robot, carried: Sequence[Carried]) -> Robot:
    """Return the robot with payload shapes, each a link of its own name that may touch its holder.

    Raises :class:`RobotError` for an unknown frame or the name of a link.
    """
    bodies, touching = [], set(robot.touching)
    for item in carried:
        if item.name in {body.link for body in robot.bodies}:
            raise RobotError(f"the robot carries '{item.name}', but a link has that name: give it another one.")
        frame = frame_of_carried(robot, item)
        placement = frozen(frame.placement.homogeneous @ item.placement)
        bodies.append(Body(item.name, item.name, int(frame.parentJoint), item.shape, placement, (0.8, 0.6, 0.3, 1.0)))
        touching |= {frozenset((item.name, link)) for link in (item.link, *item.touch_links)}
    result = replace(
        robot,
        bodies=(*robot.bodies, *bodies),
        carried=(*robot.carried, *bodies),
        touching=frozenset(touching),
    )
    vars(result)["without_payload"] = robot.without_payload
    return result


def without_carried(robot: Robot, name: str) -> Robot:
    """Return the robot without the payload ``name``, or unchanged if it has none of that name."""
    if name not in {body.link for body in robot.carried}:
        return robot
    return replace(
        robot,
        bodies=tuple(body for body in robot.bodies if body.link != name),
        carried=tuple(body for body in robot.carried if body.link != name),
        touching=frozenset(pair for pair in robot.touching if name not in pair),
    )


def frame_of_carried(robot: Robot, item: Carried) -> pin.Frame:
    """Return the frame of a payload shape; :class:`RobotError` if it does not move with its link."""
    holder = robot.model.frames[frame_id(robot.model, item.link)]
    if item.frame in ("", item.link):
        return holder
    frames = [each for each in robot.model.frames if each.name == item.frame and each.parentJoint == holder.parentJoint]
    if not frames:
        raise RobotError(
            f"'{item.name}' is attached to link '{item.link}' and placed in frame '{item.frame}', which does not move "
            "with it; place it in the frame of its link."
        )
    return frames[0]


def _pose_or_position(given: ArrayLike | pin.SE3) -> pin.SE3 | Floats:
    """Return an SE3 for a (4, 4) array, and a position (3,) or an SE3 unchanged."""
    if isinstance(given, pin.SE3):
        return given
    array = np.asarray(given, dtype=float)
    if array.shape == (3,):
        return numbers("pose", array, (3,))
    return pin.SE3(placement("pose", array))


def with_tool(robot: Robot, tool: str | None) -> Robot:
    """Return the robot with other tools, with commas between, or unchanged for None."""
    if tool is None or tool == robot.tool_text:
        return robot
    first, *others = tool_names(tool)
    for name in (first, *others):
        frame_id(robot.model, name)
    return replace(robot, tool=first, other_tools=tuple(others))


def with_widened_limits(robot: Robot, configurations: Floats) -> Robot:
    """Return the robot with limits that include all ``configurations`` (n, dof)."""
    lower = np.minimum(robot.lower, np.min(configurations, axis=0))
    upper = np.maximum(robot.upper, np.max(configurations, axis=0))
    return replace(robot, lower=frozen(lower), upper=frozen(upper))


def part_bodies(parts: Mapping[str, Robot], bodies: Sequence[tuple[Body, ...]]) -> tuple[Body, ...]:
    """Return the ``bodies`` of parts as those of their composite, whose joints are counted on."""
    placed, joints = list[Body](), 0
    for (prefix, part), own in zip(parts.items(), bodies, strict=True):
        placed += [
            replace(b, name=prefix + b.name, link=prefix + b.link, joint=b.joint and b.joint + joints) for b in own
        ]
        joints += part.model.njoints - 1
    return tuple(placed)


def load_visuals(robot: Robot) -> tuple[Body, ...]:
    """Return the bodies to draw; slow for detailed meshes.

    Falls back to the collision bodies with a warning, so that a finished plan is not lost.
    """
    if robot.parts:
        return (*part_bodies(robot.parts, [load_visuals(part) for part in robot.parts.values()]), *robot.carried)
    full = urdf.build_model(robot.source)
    try:
        moving = tuple(robot.model.names)
        return (*read_bodies(robot.source, full, "visual", moving, robot.fixed_joints, robot.base)[1], *robot.carried)
    except (RobotError, FileError) as error:
        _log.warning("the page shows the collision shapes, because the visual shapes cannot be read: %s", error)
        return robot.bodies


def assemble(
    files: RobotFiles,
    tool: str | None = None,
    choice: JointChoice = ALL_JOINTS,
    fixed: Mapping[str, float] | None = None,
    base: Floats | None = None,
) -> Robot:
    """Return the robot of ``files``, with arguments as in :meth:`Robot.load`."""
    file, description, on_tool = files.file, files.description, files.notes_on_tool(tool, choice)
    tools, planned = files.tools(tool, choice), files.select_joints(tool, choice, fixed or {})
    for each in tools:
        files.require_moved(planned, each)
    if free := [joint for joint in planned if joint in description.unlimited]:
        text = f"joint '{free[0]}' slides without limits: give it limits in its file, or for a base"
        raise RobotError(f"{text} {REMEDY}.")
    fixed = {**file.fixed_joints, **(fixed or {})}
    # joints that are neither planned nor fixed stay at home, unless that is zero; mimic joints follow
    free = {*planned, *fixed, *(item.joint for item in description.mimics)}
    fixed = {joint: value for joint, value in files.home.items() if joint not in free and value} | fixed
    fewest = min(len(({*planned} & {*files.leaders(each, fixed)}) - description.planar) for each in tools)
    base = pose() if base is None else placement("base", base)
    held, followers = urdf.resolve_mimics(description, files.model, planned, fixed)
    moving = [*planned, *(item.joint for item in followers)]
    model, bodies = read_bodies(description, files.model, "collision", moving, held, base)
    require_limits(model)
    endless, limit_notes = urdf.narrow_limits(model, followers, description.continuous)
    rows = [model.getJointId(name) - 1 for name in planned]
    lower, upper = frozen(model.lowerPositionLimit[rows]), frozen(model.upperPositionLimit[rows])
    home = [files.home.get(name, at) for name, at in zip(planned, np.clip(0.0, lower, upper), strict=True)]
    return Robot(
        name=files.name,
        description=file.description or f"from {files.origin}",
        joints=tuple(planned),
        lower=lower,
        upper=upper,
        velocity=frozen(model.upperVelocityLimit[rows]),
        continuous=frozen([joint in endless for joint in planned], np.bool_),
        tool=tools[0],
        other_tools=tools[1:],
        home=frozen(home),
        jacobian_rows=file.manipulability or ("pose" if fewest >= 6 else "translation"),
        disabled_pairs=files.disabled_pairs,
        base=frozen(base),
        source=description,
        states=states_of_joints(files.srdf, planned) if files.srdf else {},
        motion=files.motion(planned),
        world_frame=files.srdf.world_frame if files.srdf else "",
        notes=(
            *files.notes,
            *on_tool,
            *collada_notes(mesh_files(description)),
            *limit_notes,
        ),
        model=model,
        bodies=bodies,
        fixed_joints=held,
        followers=followers,
    )
