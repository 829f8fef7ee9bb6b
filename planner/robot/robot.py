"""A robot arm as the planner sees it: planned joints, limits, bodies, tool frame."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, Ints, frozen, placement
from planner.base.cache import content_hash
from planner.base.errors import FileError, Note, RobotError, choices
from planner.base.files import StrPath
from planner.base.yamlfile import FARTHEST
from planner.problem.targets import TURN
from planner.robot.files import urdf
from planner.robot.files.meshes import collada_notes
from planner.robot.files.robot_files import ALL_JOINTS, JointChoice, MotionFile, RobotFiles, Rows, read_robot
from planner.robot.files.srdf import states_of_joints
from planner.robot.files.urdf_geometry import mesh_files, read_bodies
from planner.robot.poses import pose
from planner.robot.shapes import Body, Carried

_log = logging.getLogger(__name__)

_MOST_TURNS = 4  # in either direction: limits of more are taken for degrees


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot arm with its planned joints; configurations are (n, dof) arrays of joint values, rad (m where prismatic).

    A continuous joint is one angle like any other; ``continuous`` says which may wrap. Load with :meth:`load`:

        robot = Robot.load("iiwa14")
        robot.joints, robot.lower, robot.upper

    It holds no state: where a configuration puts the links is asked of :mod:`planner.kinematics`.
    """

    name: str
    description: str
    model: pin.Model
    joints: tuple[str, ...]
    lower: Floats  # (dof,)
    upper: Floats  # (dof,)
    velocity: Floats  # (dof,) rad/s, m/s where it slides, 0 where the URDF says nothing
    continuous: Bools  # (dof,)
    tool: str
    home: Floats  # (dof,)
    manipulability: Rows  # rows of the tool's Jacobian that w is taken of
    bodies: tuple[Body, ...]
    disabled_pairs: frozenset[frozenset[str]] | None  # None: nobody has said
    fixed_joints: Mapping[str, float]
    base: Floats  # (4, 4)
    source: urdf.Description = field(repr=False)
    carried: tuple[Body, ...] = ()  # of ``bodies``, those that a link holds without being part of it
    touching: frozenset[frozenset[str]] = frozenset()  # what these may touch, by name
    states: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # named by its SRDF, of the planned joints
    motion: MotionFile | None = None  # of the planned joints, in their order; None: nobody has said
    shares: Mapping[str, float] = field(default_factory=dict)  # of its velocities and accelerations, as a request asks
    followers: tuple[urdf.Mimic, ...] = ()  # the joints that follow planned ones, which ``model`` has too
    world_frame: str = ""  # how its SRDF calls the frame that its base stands in
    notes: tuple[Note, ...] = ()  # of what was passed over in its files, or in a request to it

    def __repr__(self) -> str:
        return f"<Robot: {self.name}, {self.dof} joints, tool {self.tool}>"

    @staticmethod
    def load(
        name: StrPath,
        tool: str | None = None,
        fixed_joints: Mapping[str, float] | None = None,
        base: Floats | None = None,
        choice: JointChoice = ALL_JOINTS,
        srdf: StrPath | None = None,
    ) -> Robot:
        """A built-in robot by name, or any robot by the path of its robot.yaml or URDF.

        ``tool`` is a frame of the URDF (of a URDF by path with several tips: the one that
        is called so, as tool0, or that most joints move), ``fixed_joints``
        holds joints at values (rad, m), ``base`` places the robot in the world (4, 4), ``choice`` says which joints are
        planned, ``srdf`` is a file in place of the robot's own. Raises :class:`RobotError` naming the choices.
        """
        return assemble(read_robot(name, srdf), tool, choice, fixed_joints, base)

    @property
    def dof(self) -> int:
        return len(self.joints)

    @property
    def prismatic(self) -> Bools:
        """(dof,) which joints slide (their values are metres)."""
        return urdf.slides(self.model)[self.rows]

    @cached_property
    def rows(self) -> Ints:
        """(dof,) the numbers of the planned joints among those of ``model``, which followers belong to as well."""
        return frozen([self.model.getJointId(joint) - 1 for joint in self.joints], np.int64)

    @cached_property
    def tool_id(self) -> int:
        return urdf.frame_id(self.model, self.tool)

    @cached_property
    def arm(self) -> Robot:
        """The robot before it carried anything: what joints and their limits decide is worked out of it but once."""
        return self

    @cached_property
    def identity(self) -> str:
        """A hash of everything that decides where a configuration puts which geometry, and what is checked."""
        model, tool = self.model, self.model.frames[self.tool_id]
        disabled = None if self.disabled_pairs is None else sorted(sorted(pair) for pair in self.disabled_pairs)
        values: list[Any] = [self.joints, self.lower, self.upper, self.continuous, self.manipulability, disabled]
        values += [sorted(sorted(pair) for pair in self.touching)]
        values += [int(tool.parentJoint), np.array(tool.placement.homogeneous)]
        for joint in range(1, model.njoints):
            values += [int(model.parents[joint]), model.joints[joint].shortname()]
            values += [np.array(model.jointPlacements[joint].homogeneous)]
        # axes that are no coordinate axes show in where the joints are once all have moved
        data = model.createData()
        pin.forwardKinematics(model, data, np.full(model.nq, 0.5))
        values += [np.round(data.oMi[joint].homogeneous, 9) + 0.0 for joint in range(1, model.njoints)]
        values += [[item.joint, item.leader, item.multiplier, item.offset] for item in self.followers]
        for body in self.bodies:
            values += [body.link, body.joint, body.placement, *body.shape.content()]
        return content_hash(values)

    def difference(self, a: Floats, b: Floats) -> Floats:
        """The joint motion (..., dof) from a to b: continuous joints turn in the shorter direction."""
        return shorter_way(np.asarray(b) - np.asarray(a), self.continuous)

    def told_by_ends(self, delta: Floats) -> Bools:
        """(...,) which joint motions (..., dof) are those that angles of their ends tell: below half a turn."""
        return np.all(np.abs(delta[..., self.continuous]) < HALF_TURN, axis=-1)

    def unwound(self, path: Floats) -> Floats:
        """A path (k, dof) from its first row on with continuous joints counted on, so that following it is no jump.

        What takes no whole turns stays the same to the last bit.
        """
        path = np.asarray(path)
        if not self.continuous.any():
            return np.array(path)
        turns = np.rint((self.difference(path[:-1], path[1:]) - np.diff(path, axis=0)) / (2 * np.pi))
        return path + 2 * np.pi * np.vstack([np.zeros(path.shape[1]), np.cumsum(turns, axis=0)])

    def normalise(self, q: Floats) -> Floats:
        """Continuous joints brought into [-pi, pi)."""
        return np.where(self.continuous, in_one_turn(np.asarray(q) + np.pi) - np.pi, q)


HALF_TURN = np.pi - 1e-9
"""The farthest (rad) that a joint without limits may turn on a motion told by its ends: rounding comes to less."""


def shorter_way(delta: Floats, turns: Bools) -> Floats:
    """Joint motions (..., dof) in the shorter direction for joints that turn freely; back is the exact opposite.

    What is half a turn but for rounding goes the way that ``delta`` does: so does a path of it however it is unwound.
    """
    if not turns.any():
        return delta
    turned = np.mod(np.abs(delta) + np.pi, 2 * np.pi) - np.pi
    turned = np.where(turned < -HALF_TURN, turned + 2 * np.pi, turned)
    return np.where(turns, np.copysign(1.0, delta) * turned, delta)


def in_one_turn(angles: Floats) -> Floats:
    """Angles brought into [0, 2 pi); twice, as what is below 0 by less than rounding comes to 2 pi."""
    return np.mod(np.mod(angles, 2 * np.pi), 2 * np.pi)


def with_carried(robot: Robot, carried: Sequence[Carried]) -> Robot:
    """The robot holding further shapes; each counts as a link of its own name that may touch the link that holds it.

    Raises :class:`RobotError` where a frame is not there, or a name is a link's.
    """
    bodies, touching = [], set(robot.touching)
    for item in carried:
        if item.name in {body.link for body in robot.bodies}:
            raise RobotError(f"the robot carries '{item.name}', but a link has that name: give it another one.")
        frame = held_in(robot, item)
        placement = frozen(frame.placement.homogeneous @ item.placement)
        bodies.append(Body(item.name, item.name, int(frame.parentJoint), item.shape, placement, (0.8, 0.6, 0.3, 1.0)))
        touching |= {frozenset((item.name, link)) for link in (item.link, *item.touch_links)}
    made = replace(
        robot,
        bodies=(*robot.bodies, *bodies),
        carried=(*robot.carried, *bodies),
        touching=frozenset(touching),
    )
    vars(made)["arm"] = robot.arm
    return made


def without_carried(robot: Robot, name: str) -> Robot:
    """The robot without one of the shapes that it holds; as it is where it holds none of that name."""
    if name not in {body.link for body in robot.carried}:
        return robot
    return replace(
        robot,
        bodies=tuple(body for body in robot.bodies if body.link != name),
        carried=tuple(body for body in robot.carried if body.link != name),
        touching=frozenset(pair for pair in robot.touching if name not in pair),
    )


def held_in(robot: Robot, item: Carried) -> pin.Frame:
    """The frame that a carried shape is placed in; :class:`RobotError` where it does not move with its link."""
    holder = robot.model.frames[urdf.frame_id(robot.model, item.link)]
    if item.frame in ("", item.link):
        return holder
    found = [each for each in robot.model.frames if each.name == item.frame and each.parentJoint == holder.parentJoint]
    if not found:
        raise RobotError(
            f"'{item.name}' is attached to link '{item.link}' and placed in frame '{item.frame}', which does not move "
            "with it; place it in the frame of its link."
        )
    return found[0]


def with_tool(robot: Robot, tool: str | None) -> Robot:
    """The robot with another tool frame, where one is named; :class:`RobotError` names the choices."""
    if tool is None or tool == robot.tool:
        return robot
    urdf.frame_id(robot.model, tool)
    return replace(robot, tool=tool)


def with_widened_limits(robot: Robot, configurations: Floats) -> Robot:
    """The robot with limits that hold all of ``configurations`` (n, dof), where its own do not."""
    lower = np.minimum(robot.lower, np.min(configurations, axis=0))
    upper = np.maximum(robot.upper, np.max(configurations, axis=0))
    return replace(robot, lower=frozen(lower), upper=frozen(upper))


def load_visuals(robot: Robot) -> tuple[Body, ...]:
    """The bodies that are drawn; slow for detailed meshes, so asked only when a picture is made.

    Where they cannot be read these are the collision bodies: by now a path has been planned, which is not to be lost.
    """
    full = urdf.build_model(robot.source)
    try:
        moving = tuple(robot.model.names)
        return (*read_bodies(robot.source, full, "visual", moving, robot.fixed_joints, robot.base)[1], *robot.carried)
    except (RobotError, FileError) as error:
        _log.warning("the page shows the shapes that collide, as those to look at cannot be read: %s", error)
        return robot.bodies


def assemble(
    files: RobotFiles,
    tool: str | None = None,
    choice: JointChoice = ALL_JOINTS,
    fixed: Mapping[str, float] | None = None,
    base: Floats | None = None,
) -> Robot:
    """The robot of ``files``, set up as :meth:`Robot.load` says."""
    file, description, on_tool = files.file, files.description, files.notes_on_tool(tool, choice)
    tool, planned = files.tool(tool, choice), files.planned_joints(tool, choice, fixed or {})
    _check_joints(files, planned, tool)
    fixed = {**file.fixed_joints, **(fixed or {})}
    # joints that are neither planned nor fixed are held, unless at zero, as home says; those that mimic follow
    free = {*planned, *fixed, *(item.joint for item in description.mimics)}
    fixed = {joint: value for joint, value in files.home.items() if joint not in free and value} | fixed
    base = pose() if base is None else placement("base", base)
    held, followers = urdf.follow(description, files.model, planned, fixed)
    moving = [*planned, *(item.joint for item in followers)]
    model, bodies = read_bodies(description, files.model, "collision", moving, held, base)
    _check_limits(model)
    endless, narrowed = urdf.narrow(model, followers, description.continuous)
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
        tool=tool,
        home=frozen(home),
        manipulability=file.manipulability or ("pose" if len(planned) >= 6 else "translation"),
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
            *narrowed,
        ),
        model=model,
        bodies=bodies,
        fixed_joints=held,
        followers=followers,
    )


def _check_joints(files: RobotFiles, planned: Sequence[str], tool: str) -> None:
    between = files.leaders(tool)
    if not between:
        raise RobotError(f"no movable joint lies between the base and frame '{tool}': choose another tool frame.")
    if not set(planned) & set(between):
        text = f"no joint that moves frame '{tool}' is planned: plan one of {choices(between)}, or choose another tool"
        raise RobotError(f"{text} frame.")


def _check_limits(model: pin.Model) -> None:
    limits = model.names[1:], model.lowerPositionLimit, model.upperPositionLimit, urdf.slides(model)
    for name, low, high, slides in zip(*limits, strict=True):
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            text = "give it finite limits, lower below upper, in the URDF."
        elif max(abs(low), abs(high)) <= (FARTHEST if slides else _MOST_TURNS * TURN):
            continue
        elif slides:
            text = "give it real ones, in metres, in the URDF."
        else:
            text = "degrees? 180 degrees are 3.1416 rad; a joint that turns without end is of type continuous."
        raise RobotError(f"joint '{name}' has limits [{low:g}, {high:g}]: {text}")
