"""Pinocchio's models as robots: trees of joints with one value each."""

import itertools
from pathlib import Path

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats
from planner.base.errors import RobotError
from planner.base.yamlfile import FARTHEST
from planner.kinematics.arm import sliding_joints
from planner.problem.targets import TURN
from planner.robot.files.robot_files import RobotFile, RobotFiles, Source
from planner.robot.files.urdf import Description, Mimic

_UNLIMITED = 1e300  # Pinocchio writes inf or the largest double where there is no limit
_LINK = pin.FrameType.BODY
_TURNING = pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ, pin.JointModelRevoluteUnaligned
_SLIDING = pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ, pin.JointModelPrismaticUnaligned
_MOST_TURNS = 4  # in either direction: larger limits are probably degrees


def files_of_model(model: pin.Model, collision: pin.GeometryModel, visual: pin.GeometryModel | None) -> RobotFiles:
    """Return the robot of a model and its geometry, as if read from files.

    If ``collision`` has pairs, link pairs without one need no check. Raises :class:`RobotError` for unsupported joints.
    """
    single, continuous, mimics = _with_single_values(model)
    geometry = {"collision": _in_frames(collision, single)}
    geometry["visual"] = geometry["collision"] if visual is None else _in_frames(visual, single)
    named, visible = (
        [single.frames[item.parentFrame].name for item in each.geometryObjects] for each in geometry.values()
    )
    description = Description(
        path=Path("pinocchio.Model"),
        name=model.name,
        xml="<robot/>",
        continuous=frozenset(continuous),
        collision_elements=len(named),
        mimics=tuple(mimics),
        bare=frozenset(visible) - frozenset(named),
        links=frozenset(named).union(frame.name for frame in single.frames if frame.type == _LINK),
        joints=_links_at_joints(single),
        model=single,
        geometry=geometry,
        pieces=True,
    )
    pairs = {frozenset((named[pair.first], named[pair.second])) for pair in collision.collisionPairs}
    disabled = [pair for pair in itertools.combinations(sorted(set(named)), 2) if frozenset(pair) not in pairs]
    file = RobotFile(urdf=Source(file=""), disabled_pairs=disabled if pairs else None)
    return RobotFiles(model.name, "a pinocchio.Model", file, description, None)


def _with_single_values(model: pin.Model) -> tuple[pin.Model, list[str], list[Mimic]]:
    """Return the model with one-value joints, names of continuous joints, and how joints follow."""
    single, data, continuous, mimics = pin.Model(), model.createData(), list[str](), list[Mimic]()
    single.name = model.name
    pin.forwardKinematics(model, data, pin.neutral(model))
    leaders = dict(zip(model.mimicking_joints, model.mimicked_joints, strict=True))
    for k in range(1, model.njoints):
        name, joint, leader = model.names[k], model.joints[k], model.joints[leaders.get(k, k)]
        factor, offset = (joint.extract().scaling, joint.extract().offset) if k in leaders else (1.0, 0.0)
        if k in leaders:
            mimics.append(Mimic(name, model.names[leaders[k]], factor, offset))
        kind, turns = _joint_along(np.ravel(data.joints[k].S) / factor, name, joint.shortname())
        ends = [float(limits[leader.idx_q]) for limits in (model.lowerPositionLimit, model.upperPositionLimit)]
        if turns and (leader.nq == 2 or max(map(abs, ends)) >= _UNLIMITED):
            continuous.append(name)
            ends = [-np.pi, np.pi]
        else:
            ends = sorted(factor * end + offset for end in ends)
        velocity = abs(factor) * float(model.upperVelocityLimit[leader.idx_v])
        numbers = (0.0, velocity if velocity < _UNLIMITED else 0.0, *ends)
        single.addJoint(model.parents[k], kind, model.jointPlacements[k], name, *(np.array([each]) for each in numbers))
        single.inertias[k] = model.inertias[k]
    for frame in list(model.frames)[1:]:
        single.addFrame(frame, False)
    return single, continuous, mimics


def _joint_along(motion: Floats, name: str, kind: str) -> tuple[pin.JointModel, bool]:
    """Return the joint that moves along its Jacobian column (6,), and whether it turns."""
    if motion.shape != (6,) or (motion[:3].any() and motion[3:].any()) or kind == "JointModelComposite":
        raise RobotError(
            f"joint '{name}' of the pinocchio.Model is a {kind}: only revolute, continuous and prismatic joints are "
            "supported; lock it with pinocchio.buildReducedModel, or give each degree of freedom a joint of its own."
        )
    turns = bool(motion[3:].any())
    axis, kinds = (motion[3:], _TURNING) if turns else (motion[:3], _SLIDING)
    aligned = sorted(axis.tolist()) == [0.0, 0.0, 1.0]
    return (kinds[int(axis.argmax())]() if aligned else kinds[3](axis)), turns


def _in_frames(geometry: pin.GeometryModel, model: pin.Model) -> pin.GeometryModel:
    """Return a copy with items in frames of ``model``; adds a link for items that name only a joint."""
    single = geometry.copy()
    for item in single.geometryObjects:
        if item.parentFrame >= model.nframes:
            item.parentFrame = model.addFrame(pin.Frame(item.name, item.parentJoint, 0, pin.SE3.Identity(), _LINK))
    return single


def _links_at_joints(model: pin.Model) -> dict[str, tuple[str, str]]:
    """Return the links above and below each joint, also fixed ones; empty if missing."""
    links = {name: ("", name) for name in model.names[1:]}
    for link in model.frames:
        if link.type == _LINK and link.parentFrame:
            joint = model.frames[link.parentFrame]
            above = model.frames[joint.parentFrame]
            links[joint.name] = above.name if above.type == _LINK else "", link.name
    return links


def require_limits(model: pin.Model) -> None:
    """Raise :class:`RobotError` for a joint without finite limits of a plausible size."""
    limits = model.names[1:], model.lowerPositionLimit, model.upperPositionLimit, sliding_joints(model)
    for name, low, high, slides in zip(*limits, strict=True):
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            text = "give it finite limits, lower below upper, in the URDF."
        elif max(abs(low), abs(high)) <= (FARTHEST if slides else _MOST_TURNS * TURN):
            continue
        elif slides:
            text = "give it limits in metres in the URDF."
        else:
            text = "degrees? 180 degrees are 3.1416 rad; a joint that turns without end is of type continuous."
        raise RobotError(f"joint '{name}' has limits [{low:g}, {high:g}]: {text}")
