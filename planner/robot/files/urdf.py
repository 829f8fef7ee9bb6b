"""URDF as a Pinocchio model of the planned joints."""

import contextlib
import math
import xml.etree.ElementTree as ET
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats
from planner.base.captured_output import CapturedOutput
from planner.base.errors import Note, RobotError, choices
from planner.base.yamlfile import FARTHEST, number, quote, suggest_name
from planner.kinematics.arm import Mimic, frame_id
from planner.robot.files.mjcf import Sites, convert_mjcf
from planner.robot.files.packages import find_meshes, read_root
from planner.robot.files.planar import Area, VirtualJoint, limit_slides, split_planar_joints
from planner.robot.poses import se3
from planner.robot.shapes import Mesh

MJCF = "mujoco"  # the root element of MJCF files
_TOOLS = (  # usual names of the end frame, tools first
    *("tool0", "tcp", "tool_frame", "ee_link", "ee", "eef", "end_effector", "end_effector_link", "gripper_frame_link"),
    "flange",
)
_LINK = " (link)"
_MOST = 1000.0  # rad, m: largest value of a follower
_SAME = 1e-9  # rad, m: closer limits are equal


@dataclass(frozen=True)
class Description:
    """A URDF adapted for Pinocchio, with the names and files that it refers to."""

    path: Path
    name: str
    xml: str
    continuous: frozenset[str]
    collision_elements: int
    mimics: tuple[Mimic, ...] = ()
    bare: frozenset[str] = frozenset()  # links with visual and without collision geometry
    links: frozenset[str] = frozenset()
    unlimited: frozenset[str] = frozenset()  # slides without limits
    planar: frozenset[str] = frozenset()  # joints that stand for planar ones
    joints: Mapping[str, tuple[str, str]] = field(default_factory=dict)  # fixed ones too: (parent, child) link
    meshes: Mapping[str, Mesh] = field(default_factory=dict)  # of an MJCF, by their names in ``xml``
    sites: Sites = field(default_factory=dict)  # of an MJCF
    pieces: bool = False  # whether the connected pieces of a mesh that collides become a body each
    model: pin.Model | None = None  # where it is given as such, with its geometry by kind
    geometry: Mapping[str, pin.GeometryModel] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()

    @cached_property
    def package_dirs(self) -> list[str]:
        """Folders to which mesh paths may be relative."""
        return [str(folder) for folder in self.path.resolve().parents][:4]

    def mimic(self, joint: str, held: Collection[str] = ()) -> Mimic:
        """Return how ``joint`` follows its last leader, or the first leader in ``held``.

        A joint without a leader follows itself. Raises :class:`RobotError` for circular leaders.
        """
        own, mimic = {item.joint: item for item in self.mimics}, Mimic(joint, joint, 1.0, 0.0)
        for _ in range(len(own) + 1):
            if mimic.leader in held or mimic.leader not in own:
                return mimic
            above = own[mimic.leader]
            offset = mimic.multiplier * above.offset + mimic.offset
            mimic = Mimic(joint, above.leader, mimic.multiplier * above.multiplier, offset)
        raise RobotError(
            f"joint '{joint}' of {self.path} mimics '{own[joint].leader}', and their leaders form a circle: mend it."
        )


def read_description(
    path: Path,
    arguments: Mapping[str, str] | None = None,
    text: str | None = None,
    virtual: VirtualJoint | None = None,
    area: Area | None = None,
) -> Description:
    """Return the URDF at ``path`` or in ``text``; continuous joints become revolute within one turn.

    xacro is expanded with ``arguments``; MJCF is converted. The version becomes 1.1, below which readers drop capsules.
    Planar joints become three, and a base moves within an ``area``, see :mod:`planner.robot.files.planar`.
    """
    root = read_root(path, "URDF", arguments, text)
    meshes, sites, notes = {}, {}, ()
    if root.tag == MJCF:
        root, meshes, sites, notes = convert_mjcf(path, root.get("model") or path.stem)
    if root.tag != "robot":
        raise RobotError(f"root element of URDF {path} must be <robot>, got <{quote(root.tag)[1:-1]}>: choose a URDF.")
    root.set("version", "1.1")
    _require_known_words(root, path)
    find_meshes(root, path)
    planar = split_planar_joints(root, path, virtual)
    unlimited = limit_slides(root, path, area)
    links, joints = {_name(link): link for link in root.iterfind("link")}, root.findall("joint")
    if "universe" in {*links, *map(_name, joints)}:
        raise RobotError(f"URDF {path} calls a link or joint 'universe', as Pinocchio calls the world: rename it.")
    limits = [limit for joint in joints for limit in joint.iterfind("limit")]
    if lost := sorted({"acceleration", "deceleration", "jerk"} & {key for limit in limits for key in limit.attrib}):
        text = f"limits on {choices(lost)} in the URDF are not followed: give them with --limits, or in a robot.yaml."
        notes = (*notes, Note(text))
    for joint in joints:
        _apply_soft_limits(joint)
    continuous = frozenset(_make_revolute(joint) for joint in joints if joint.get("type") == "continuous")
    # talos_reduced leaves <mimic> in joints that it makes fixed: those follow no other
    moving = [joint for joint in joints if joint.get("type") != "fixed"]
    return Description(
        path=path,
        name=root.get("name") or path.stem,
        xml=ET.tostring(root, encoding="unicode"),
        continuous=continuous,
        collision_elements=sum(len(each.findall("geometry/*")) or 1 for each in root.iterfind("link/collision")),
        mimics=tuple(_mimic(joint, item) for joint in moving if (item := joint.find("mimic")) is not None),
        bare=frozenset(
            name
            for name, link in links.items()
            if link.find("visual/geometry") is not None and link.find("collision") is None
        ),
        links=frozenset(links),
        unlimited=unlimited,
        planar=planar,
        joints={_name(joint): (_end(joint, "parent"), _end(joint, "child")) for joint in joints},
        meshes=meshes,
        sites=sites,
        notes=notes,
    )


_WORDS = {  # known words: readers skip others silently, so a <colision> would be lost
    "robot": "name version link joint material gazebo transmission",
    "link": "name inertial visual collision collision_checking",
    "joint": "name type origin parent child axis limit mimic dynamics calibration safety_controller",
    "collision": "name origin geometry",
    "geometry": "box sphere cylinder capsule mesh",
    "origin": "xyz rpy quat_xyzw",
    "axis": "xyz",
    "limit": "lower upper effort velocity gear_velocity",
    "mimic": "joint multiplier offset",
}


def _require_known_words(root: ET.Element, path: Path) -> None:
    """Raise :class:`RobotError` for misspelt elements and attributes, and for axes of zero length."""
    for element in root.iter():
        known = _WORDS.get(element.tag, "").split()
        for word in (*(child.tag for child in element), *element.attrib):
            if word not in known and (meant := suggest_name(str(word), known, 0.65)):
                raise RobotError(f"URDF {path}: <{element.tag}> holds {quote(word)}{meant}; mend the file.")
    for joint in root.iterfind("joint"):
        axis = joint.find("axis[@xyz]")
        if (
            axis is not None
            and joint.get("type") not in ("fixed", "floating")
            and not any(_floats(axis.get("xyz", "")))
        ):
            raise RobotError(f"URDF {path}: the axis of joint {quote(_name(joint))} has no direction; mend the file.")


def _floats(text: str) -> list[float]:
    """Return the numbers of a text, or none if it holds anything else."""
    with contextlib.suppress(ValueError):
        return [number(word) for word in text.split()]
    return []


def _name(element: ET.Element) -> str:
    return element.get("name", "")


def _end(joint: ET.Element, kind: str) -> str:
    """Return the name of a joint's parent or child link, empty without one."""
    element = joint.find(kind)
    return "" if element is None else element.get("link", "")


def read_number(element: ET.Element, key: str, default: float = math.nan) -> float:
    """Return the finite number in an attribute; :class:`RobotError` for other text."""
    text = element.get(key, repr(default))
    try:
        value = number(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RobotError(f"{key} of <{element.tag}> must be a finite number, got {quote(text)}; mend the file.")
    return value


def _mimic(joint: ET.Element, item: ET.Element) -> Mimic:
    factor, offset = read_number(item, "multiplier", 1.0), read_number(item, "offset", 0.0)
    return Mimic(_name(joint), item.get("joint", ""), factor, offset)


def _apply_soft_limits(joint: ET.Element) -> None:
    """Narrow a joint's limits to the soft limits of its safety controller."""
    limit, safety = joint.find("limit"), joint.find("safety_controller")
    if limit is None or safety is None or joint.get("type") not in ("revolute", "prismatic"):
        return
    low, high = (read_number(safety, f"soft_{side}_limit", 0.0) for side in ("lower", "upper"))
    if low == high == 0.0:
        return
    if not low < high:
        raise RobotError(
            f"joint {quote(_name(joint))} of the URDF has soft limits of {low:g} and {high:g} (0 where not given): "
            "give both, the lower one below the upper, or neither."
        )
    limit.set("lower", repr(max(read_number(limit, "lower", 0.0), low)))
    limit.set("upper", repr(min(read_number(limit, "upper", 0.0), high)))


def _make_revolute(joint: ET.Element) -> str:
    joint.set("type", "revolute")
    limit = joint.find("limit")
    if limit is None:
        limit = ET.SubElement(joint, "limit", effort="0", velocity="0")
    limit.set("lower", repr(-np.pi))
    limit.set("upper", repr(np.pi))
    return _name(joint)


def build_model(description: Description) -> pin.Model:
    """Return Pinocchio's model of all movable joints; :class:`RobotError` unless each has one value."""
    if description.model is not None:
        return description.model.copy()
    printed = CapturedOutput()
    try:
        with printed:
            model = pin.buildModelFromXML(description.xml)
    except (ValueError, RuntimeError) as error:
        reason = printed.first_error() or str(error).partition("\n")[0].rstrip(".")
        raise RobotError(f"URDF {description.path} cannot be built: {reason}; mend the file.") from None
    for name, joint in zip(model.names[1:], list(model.joints)[1:], strict=True):
        if joint.nv != 1 or joint.nq != 1:
            raise RobotError(
                f"joint '{name}' of {description.path} has {joint.nv} degrees of freedom: "
                "only revolute, continuous and prismatic joints are supported. Make it fixed, where --base places the "
                "robot, or give each degree of freedom a joint of its own."
            )
    _require_complete_model(model, description)
    for name, (link, place) in description.sites.items():
        holder = model.frames[on := frame_id(model, link)]
        model.addFrame(pin.Frame(name, holder.parentJoint, on, holder.placement * place, pin.FrameType.OP_FRAME))
    return model


def _require_complete_model(model: pin.Model, description: Description) -> None:
    """Raise :class:`RobotError` for links that Pinocchio dropped, and for frames without a placement."""
    if lost := description.links - {frame.name for frame in model.frames}:
        raise RobotError(f"links {choices(sorted(lost))} of {description.path} hang on no root; mend the file.")
    data = model.createData()
    pin.forwardKinematics(model, data, np.full(model.nq, 0.5))
    for frame in model.frames:
        placed = data.oMi[frame.parentJoint] * frame.placement
        if not np.abs(placed.homogeneous).max() <= FARTHEST:
            raise RobotError(
                f"'{frame.name}' of {description.path} is placed nowhere, or beyond {FARTHEST:g} m: mend its origin."
            )


def resolve_mimics(
    description: Description, model: pin.Model, planned: Sequence[str], fixed: Mapping[str, float]
) -> tuple[dict[str, float], tuple[Mimic, ...]]:
    """Return the values of all held joints, and the joints that follow ``planned`` ones.

    Joints are held if they are ``fixed``, or mimic a joint that does not move. Raises :class:`RobotError` for planned
    followers and for fixed followers of planned joints.
    """
    held, followers = dict(fixed), list[Mimic]()
    for own in description.mimics:
        if not (model.existJointName(own.leader) and model.existJointName(own.joint)):
            raise RobotError(
                f"joint '{own.joint}' of {description.path} mimics {quote(own.leader)}, but those are not two "
                "moving joints of which one leads: mend the file."
            )
        item = description.mimic(own.joint)
        if item.joint in planned:
            raise RobotError(
                f"joint '{item.joint}' mimics '{item.leader}' and cannot be planned by itself: plan '{item.leader}', "
                "or remove its <mimic>."
            )
        if item.joint in fixed and item.leader in planned:
            raise RobotError(
                f"joint '{item.joint}' mimics '{item.leader}', which is planned, so it cannot be held: take it out of "
                "fixed_joints, or remove its <mimic> from the URDF."
            )
        if item.leader in planned and item.multiplier:
            followers.append(item)
        elif item.joint not in fixed:
            item = description.mimic(own.joint, fixed)
            value = item.multiplier * fixed.get(item.leader, 0.0) + item.offset
            held |= {item.joint: value} if value else {}
    return held, tuple(followers)


def narrow_limits(
    model: pin.Model, followers: Sequence[Mimic], continuous: frozenset[str]
) -> tuple[set[str], list[Note]]:
    """Narrow limits in ``model`` so that followers stay within theirs; return endless joints and notes.

    Of the ``continuous`` joints, those stay endless whose followers are all continuous with integer multipliers.
    """
    endless, notes = set(continuous), list[Note]()
    lower, upper, velocity = model.lowerPositionLimit, model.upperPositionLimit, model.upperVelocityLimit
    for item in followers:
        leader, own = (model.getJointId(name) - 1 for name in (item.leader, item.joint))
        before, low, high, fast = (lower[leader], upper[leader], velocity[leader]), -np.inf, np.inf, np.inf
        if item.joint not in continuous:
            low, high = sorted((end - item.offset) / item.multiplier for end in (lower[own], upper[own]))
        if item.joint not in continuous or item.multiplier != round(item.multiplier):
            endless.discard(item.leader)
        if velocity[own] > 0:
            fast = velocity[own] / abs(item.multiplier)
        lower[leader] = low if low > before[0] + _SAME else before[0]
        upper[leader] = high if high < before[1] - _SAME else before[1]
        velocity[leader] = fast if fast < (before[2] or np.inf) - _SAME else before[2]
        farthest = max(abs(item.multiplier * end[leader] + item.offset) for end in (lower, upper))
        if not lower[leader] < upper[leader] or farthest > _MOST:
            raise RobotError(
                f"joint '{item.joint}' mimics '{item.leader}' and cannot follow it within its own limits: mend its "
                "<mimic> or the limits in the URDF."
            )
        if before != (lower[leader], upper[leader], velocity[leader]) or item.leader in continuous - endless:
            text = f"joint '{item.joint}' follows '{item.leader}', which is kept to [{lower[leader]:.6g}, "
            text += f"{upper[leader]:.6g}] and to a velocity of {velocity[leader]:.6g}, so that both keep their limits."
            notes.append(Note(text, grave=False))
    return endless, notes


def reduce_model(
    model: pin.Model,
    geometry: pin.GeometryModel,
    moving: Collection[str],
    fixed: Mapping[str, float],
    base: Floats,
) -> tuple[pin.Model, pin.GeometryModel]:
    """Return the model of ``moving`` joints, others held at ``fixed`` (else neutral), placed at ``base``."""
    reference = pin.neutral(model)
    for name, value in fixed.items():
        if not model.existJointName(name):
            raise RobotError(f"joint '{name}' not found; joints are {choices(model.names[1:])}.")
        if not abs(value) <= FARTHEST:
            raise RobotError(f"joint '{name}' cannot be held at {value:g}: give a value of at most {FARTHEST:g}.")
        reference[model.joints[model.getJointId(name)].idx_q] = value
    locked = [model.getJointId(name) for name in model.names[1:] if name not in moving]
    _rename(model, "", _LINK)  # for now: Pinocchio looks joints up among all frames
    try:
        reduced, geometry = pin.buildReducedModel(model, geometry, locked, reference)
    finally:
        _rename(model, _LINK, "")
    _rename(reduced, _LINK, "")
    _move_base(reduced, geometry, se3(base))
    return reduced, geometry


def _rename(model: pin.Model, old: str, new: str) -> None:
    """Replace the ending ``old`` of link names by ``new``; without ``old``, of links named like a joint."""
    joints = {frame.name for frame in model.frames if frame.type != pin.FrameType.BODY}  # of fixed ones too
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY and (frame.name.endswith(old) if old else frame.name in joints):
            frame.name = frame.name.removesuffix(old) + new


def _move_base(model: pin.Model, geometry: pin.GeometryModel, base: pin.SE3) -> None:
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = base * model.jointPlacements[joint]
    for frame in list(model.frames)[1:]:
        if frame.parentJoint == 0:
            frame.placement = base * frame.placement
    for item in geometry.geometryObjects:
        if item.parentJoint == 0:
            item.placement = base * item.placement


def find_tips(model: pin.Model) -> list[str]:
    """Return candidates for the tool: links without child joints, or their site if there is exactly one."""
    parents = {frame.parentFrame for frame in model.frames if frame.type != pin.FrameType.OP_FRAME}
    links = [k for k, f in enumerate(model.frames) if k not in parents and f.type == pin.FrameType.BODY]
    sites = [[f.name for f in model.frames if f.parentFrame == k and f.type == pin.FrameType.OP_FRAME] for k in links]
    return [own[0] if len(own) == 1 else model.frames[k].name for k, own in zip(links, sites, strict=True)]


def guess_tools(model: pin.Model) -> tuple[list[str], str]:
    """Return the likely tool frames and the reason: usual names, else the tips that most joints move."""
    kinds, frames = (pin.FrameType.BODY, pin.FrameType.OP_FRAME), model.frames
    moved = {f.name: len(model.supports[f.parentJoint]) for f in frames if f.type in kinds and f.parentJoint}
    for word in _TOOLS:
        if tools := [name for name in moved if name == word] or [name for name in moved if name.endswith(f"_{word}")]:
            return tools, "by its name"
    tips = [(moved[tip], tip) for tip in find_tips(model) if tip in moved]
    return [tip for count, tip in tips if count == max(tips)[0]], "as the tip that most joints move"
