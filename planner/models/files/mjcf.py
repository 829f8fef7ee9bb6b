"""MuJoCo's MJCF as a description of a robot, as far as Pinocchio reads it: bodies, hinges, slides, simple geometry."""

from __future__ import annotations

import contextlib
import math
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin

from planner.base.errors import RobotError, choices
from planner.base.files import write_whole
from planner.base.silenced import Silenced
from planner.base.yamlfile import FARTHEST, nearest, repeated, shown
from planner.models.files.urdf_rules import floats
from planner.models.files.xacro import read_root

IGNORED = ("contact", "equality", "tendon", "keyframe", "deformable")  # by which a robot may move, or be, otherwise
_SECTIONS = (  # of a model; what stands in those that are not read moves nothing
    *("compiler", "option", "size", "visual", "statistic", "default", "custom", "asset", "worldbody"),
    *("actuator", "sensor", "extension", *IGNORED),
)
_LOST = ("include", "frame", "replicate", "composite", "flexcomp", "attach")  # Pinocchio sees nothing of what they hold
_IN_A_BODY = ("body", "geom", "joint", "freejoint", "site", "inertial", "camera", "light", "plugin")
_TURNS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")  # the ways to say an orientation
_NUMBERS = {  # how many each has: of fewer, and of words, Pinocchio takes whatever the memory holds
    **{"pos": 3, "axis": 3, "zaxis": 3, "euler": 3, "scale": 3, "quat": 4, "axisangle": 4, "xyaxes": 6, "fromto": 6},
    "range": 2,
}
_NUMBERED = ("body", "geom", "joint", "site", "mesh")  # elements that have them
_DIRECTED, _SHORTEST = {"axis": 3, "quat": 4, "zaxis": 3, "axisangle": 3}, 1e-6  # numbers that say a direction
_PLACED = ("pos", *_TURNS)
_ATTRIBUTES = {  # that have a meaning here
    "body": ("name", "childclass", "mocap", "gravcomp", "sleep", *_PLACED),
    "joint": (
        *("name", "class", "type", "group", "pos", "axis", "range", "limited", "ref", "springref", "margin"),
        *("stiffness", "damping", "armature", "frictionloss", "springdamper", "actuatorfrcrange", "user"),
    ),
    "geom": (
        *("name", "class", "type", "mesh", "size", "fromto", "contype", "conaffinity", "condim", "group", "priority"),
        *("material", "rgba", "margin", "gap", "mass", "density", "hfield", "fitscale", "friction", "user", *_PLACED),
    ),
    "mesh": ("name", "class", "file", "scale", "vertex", "face", "normal", "texcoord", "refpos", "refquat", "inertia"),
}
_ALIKE = 0.7
_PROBE = """<mujoco><worldbody><body><joint name="joint"/><geom size="1"/><body pos="1 0 0"><geom size="1"/>
<body pos="1 0 0"><geom size="1"/><site name="site"/></body></body></body></worldbody></mujoco>"""
_AXES = {axis: np.eye(3)[k] for k, axis in enumerate("xyz")}
_LIMITED = ("true", "false", "auto")
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3}  # numbers that say how large a geom is

_Defaults = Mapping[str, Mapping[str, str]]  # attributes by the elements that have them where they say nothing


def require_readable(root: ET.Element, path: Path) -> None:
    """Refuse what Pinocchio passes over in silence, or takes for something else than MuJoCo does."""
    lost = next((element.tag for element in root.iter() if element.tag in _LOST), None)
    if lost is not None:
        raise RobotError(
            f"MJCF {path} holds <{lost}>, and what is in it would not be read: write it out into the bodies, as MuJoCo "
            "does where it saves a model (mj_saveLastXML)."
        )
    unknown = next((child.tag for body in root.iter("body") for child in body if child.tag not in _IN_A_BODY), None)
    if unknown is not None:
        meant = nearest(unknown, _IN_A_BODY)
        raise RobotError(f"MJCF {path} has a body with an unknown element {shown(unknown)}{meant}; mend the file.")
    if any(element.get("coordinate") == "global" for element in root.iter("compiler")):
        raise RobotError(f"MJCF {path} has global coordinates, which are not read: let MuJoCo save it with local ones.")
    if len(root.findall("worldbody")) != 1:
        raise RobotError(f"MJCF {path} has not one worldbody: put all bodies into one.")
    if len(root.findall("compiler")) > 1:
        raise RobotError(f"MJCF {path} has several compiler elements, of which one would count: put all into one.")
    sections = [child.tag for child in root if child.tag not in _SECTIONS]
    if sections:
        meant = nearest(sections[0], _SECTIONS)
        raise RobotError(f"MJCF {path} has an unknown element {shown(sections[0])}{meant}; mend the file.")
    _require_spelling(root, path)
    shifted = next((mesh for mesh in root.iter("mesh") if mesh.get("refpos") or mesh.get("refquat")), None)
    if shifted is not None:
        raise RobotError(
            f"MJCF {path}: mesh {shown(shifted.get('name'))} has a refpos or refquat, which is not read: place its "
            "geoms in its place."
        )
    if any(joint.get("ref", "0") not in ("0", "0.0") for joint in root.iter("joint")):
        raise RobotError(f"MJCF {path} has a joint whose values count from a ref, not from 0: take the ref away.")
    _require_numbers(root, path)
    for kind in ("body", "joint"):
        if twice := repeated(each.get("name", "") for each in root.iter(kind) if each.get("name")):
            raise RobotError(f"MJCF {path} has two {kind} elements called {shown(twice[0])}: rename one of them.")
    _require_one_robot(root, path)


def _require_spelling(root: ET.Element, path: Path) -> None:
    """Raise where an attribute is nearly one that means something, which MuJoCo refuses and Pinocchio passes over."""
    for element in root.iter():
        known = _ATTRIBUTES.get(element.tag, ())
        for word in element.attrib if known else ():
            meant = nearest(word, known, _ALIKE) if word not in known else ""
            if meant:
                raise RobotError(f"MJCF {path}: a <{element.tag}> has an unknown {shown(word)}{meant}; mend the file.")


def _require_numbers(root: ET.Element, path: Path) -> None:
    for element in (each for each in root.iter() if each.tag in _NUMBERED):
        for name in element.attrib.keys() & _NUMBERS.keys():
            text, count = element.get(name, ""), _NUMBERS[name]
            values = list(floats(text))
            called = f" {shown(element.get('name'))}" if element.get("name") else ""
            quoted = f"MJCF {path}: {name}={shown(text)} of <{element.tag}>{called}"
            if len(values) != count or not all(abs(value) <= FARTHEST for value in values):
                raise RobotError(f"{quoted} is not {count} numbers of at most {FARTHEST:g}; mend the file.")
            if name in _DIRECTED and math.hypot(*values[: _DIRECTED[name]]) < _SHORTEST:
                raise RobotError(f"{quoted} has no direction; mend the file.")


def _require_one_robot(root: ET.Element, path: Path) -> None:
    """Refuse several bodies in the world: Pinocchio forgets where the first stands."""
    bodies = [body.get("name", "?") for body in root.iterfind("worldbody/body")]
    if len(bodies) > 1:
        raise RobotError(
            f"MJCF {path} has {len(bodies)} bodies in its world, {choices(bodies)}: keep the robot's, and put "
            "the others into a scene."
        )


def model_of(path: Path) -> tuple[pin.Model, frozenset[str]]:
    """Pinocchio's model of an MJCF file, and its hinges without a range: these get one turn, as continuous joints."""
    printed = Silenced()
    try:
        with printed, _written_out(path) as file:
            model = pin.buildModelFromMJCF(file)
    except (ValueError, RuntimeError, LookupError) as error:
        said = " ".join((printed.complaint() or str(error)).split())[:200]
        raise RobotError(f"MJCF {path} cannot be read ({said}): export it again, or convert it to a URDF.") from None
    if _misplaces_sites():
        _place_sites(model)
    low, high, turning = model.lowerPositionLimit, model.upperPositionLimit, set[str]()
    for name, joint in zip(model.names[1:], list(model.joints)[1:], strict=True):
        k = joint.idx_q
        if joint.nq == 1 and joint.shortname().startswith("JointModelR") and not np.isfinite([low[k], high[k]]).all():
            low[k], high[k] = -np.pi, np.pi
            turning.add(name)
    return model, frozenset(turning)


@cache
def _misplaces_sites() -> bool:
    """Whether Pinocchio puts sites of bodies without joints to where they would be with the body above at its joint."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "probe.xml")
        write_whole(file, _PROBE.encode(), lasting=False)
        model = pin.buildModelFromMJCF(str(file))
    return float(model.frames[model.getFrameId("site")].placement.translation[0]) < 2.0


def _place_sites(model: pin.Model) -> None:
    """Put them to where they belong, which is all that is left out of their places."""
    for site in model.frames:
        above = model.frames[model.frames[site.parentFrame].parentFrame]  # of its body
        if site.type == pin.FrameType.OP_FRAME and above.type == pin.FrameType.FIXED_JOINT:
            site.placement = model.frames[above.parentFrame].placement * site.placement


def geometry_of(path: Path, model: pin.Model, kind: pin.GeometryType) -> pin.GeometryModel:
    """Pinocchio's geometry of the robot in an MJCF file, without what belongs to the world: the floor and the like."""
    with _written_out(path) as file:
        geometry = pin.buildGeomFromMJCF(model, file, kind)
    for name in [item.name for item in geometry.geometryObjects if item.parentFrame == 0]:
        geometry.removeGeometryObject(name)
    return geometry


def ends_of(model: pin.Model) -> dict[str, tuple[str, str]]:
    """By each joint's name the body that it hangs on, and the one that it moves."""
    bodies = [frame for frame in model.frames if frame.type == pin.FrameType.BODY]
    first = {int(frame.parentJoint): frame.name for frame in reversed(bodies)}
    return {
        model.names[k]: (first.get(int(model.parents[k]), model.frames[0].name), first.get(k, model.names[k]))
        for k in range(1, model.njoints)
    }


def mesh_files_of(root: ET.Element) -> list[str]:
    """The mesh files that the assets of an MJCF name, relative to its folder."""
    return sorted(str(_mesh_file(mesh, root.find("compiler"))) for mesh in root.iter("mesh") if mesh.get("file"))


def bare_links(path: Path) -> frozenset[str]:
    """The bodies that have geoms, and none that collides."""
    return frozenset(
        body.get("name", "")
        for body in _said_in_full(path).iterfind("worldbody//body")
        if (geoms := body.findall("geom"))
        and all(geom.get("contype", "1") == "0" and geom.get("conaffinity", "1") == "0" for geom in geoms)
    )


def passed_over(root: ET.Element) -> list[str]:
    """Elements of the file that are not followed."""
    world = ["worldbody/geom"] if root.find("worldbody/geom") is not None else []
    first = root.find("worldbody/body")
    ways = ("pos", "quat", "euler", "axisangle", "xyaxes", "zaxis")
    posed = first is not None and any(first.get(name) for name in ways)
    placed = ["where its first body stands (give it a base)"] if posed else []
    return [*(item.tag for item in root if item.tag in IGNORED and len(item)), *world, *placed]


@contextlib.contextmanager
def _written_out(path: Path) -> Iterator[str]:
    """A file that says the same, as :func:`_said_in_full` has it."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, path.name)
        write_whole(file, ET.tostring(_said_in_full(path)), lasting=False)
        yield str(file)


def _said_in_full(path: Path) -> ET.Element:
    """What an MJCF says, with all attributes at the elements themselves.

    Of defaults Pinocchio does not follow places, orientations and scales, and it takes metres of sliding joints for
    degrees where angles are in these.
    """
    root = read_root(path, "MJCF")
    compiler, defaults = root.find("compiler"), _defaults(root)
    said = {} if compiler is None else compiler.attrib
    for world in root.iter("worldbody"):
        _write_out(world, defaults, "main", said)
    for classes in root.findall("default"):
        root.remove(classes)
    _write_turns(root, said)
    for mesh in root.iterfind("asset/mesh"):
        _say(mesh, defaults, "main")
        if mesh.get("file"):
            mesh.set("file", str(path.resolve().parent / _mesh_file(mesh, compiler)))
    for each in root.iter("compiler"):  # the files of meshes are whole by now
        for name in ("meshdir", "assetdir", "strippath"):
            each.attrib.pop(name, None)
    return root


def _write_out(
    body: ET.Element, defaults: Mapping[str, _Defaults], inherited: str, compiler: Mapping[str, str]
) -> None:
    """Give the elements of a body, and of those below it, what defaults say of them."""
    inherited = body.attrib.pop("childclass", inherited)
    for element in body:
        if element.tag == "body":
            _write_out(element, defaults, inherited, compiler)
            continue
        _say(element, defaults, inherited)
        if element.tag == "geom":
            _require_size(element)
        if element.tag == "joint":
            _write_range(element, compiler)


def _write_turns(root: ET.Element, compiler: Mapping[str, str]) -> None:
    """Write what Pinocchio would take for other orientations: axes of any length, and turns about fixed axes."""
    order, degrees = compiler.get("eulerseq", "xyz"), compiler.get("angle", "degree") == "degree"
    if len(order) != 3 or not set(order.lower()) <= set("xyz"):
        raise RobotError(f"the MJCF has a compiler with eulerseq={shown(order)}: give three of x, y, z, X, Y, Z.")
    for element in root.iter():
        if "axisangle" in element.attrib:
            *axis, angle = floats(element.attrib["axisangle"])
            length = math.hypot(*axis)
            element.set("axisangle", " ".join(map(repr, (*(part / length for part in axis), angle))))
        if "euler" in element.attrib and not order.islower():
            turn = np.eye(3)
            for angle, axis in zip(floats(element.attrib.pop("euler")), order, strict=True):
                step = pin.AngleAxis(math.radians(angle) if degrees else angle, _AXES[axis.lower()]).matrix()
                turn = turn @ step if axis.islower() else step @ turn
            x, y, z, w = pin.Quaternion(turn).coeffs().tolist()
            element.set("quat", " ".join(map(repr, (w, x, y, z))))


def _write_range(joint: ET.Element, compiler: Mapping[str, str]) -> None:
    """Leave a joint its range where that limits it, in the unit that Pinocchio takes it for."""
    limited = joint.attrib.pop("limited", "auto")
    without = " and no range" if limited == "true" and "range" not in joint.attrib else ""
    if without or limited not in _LIMITED:
        remedy = f"give {choices(_LIMITED)}, and a range where it is limited"
        raise RobotError(f"the MJCF has a <joint> with limited={shown(limited)}{without}: {remedy}.")
    if limited == "false" or (limited == "auto" and compiler.get("autolimits", "true") == "false"):
        joint.attrib.pop("range", None)
    if joint.get("type") == "slide" and compiler.get("angle", "degree") == "degree" and "range" in joint.attrib:
        ends = (math.degrees(float(end)) for end in joint.attrib["range"].split())
        joint.set("range", " ".join(map(repr, ends)))


def _say(element: ET.Element, defaults: Mapping[str, _Defaults], inherited: str) -> None:
    """Give an element what the defaults of its class, or of the one that it inherits, say of it."""
    name = element.attrib.pop("class", inherited)
    if name not in defaults:
        raise RobotError(f"the MJCF has no default of class {shown(name)}, which <{element.tag}> names: mend the file.")
    element.attrib.update(_over(defaults[name].get(element.tag, {}), element.attrib))


def _require_size(geom: ET.Element) -> None:
    """Refuse a geom with fewer sizes than its type has: Pinocchio takes whatever the memory holds for the others."""
    kind = geom.get("type", "sphere")
    if kind != "mesh" and geom.get("mesh"):
        raise RobotError(
            f"the MJCF has a <geom> of type {kind} fitted to mesh {shown(geom.get('mesh'))}: give its size."
        )
    count = 1 if geom.get("fromto") else _SIZES.get(kind, 0)
    sizes = [float(size) for size in geom.get("size", "").split()[:count]]
    if kind in _SIZES and (len(sizes) < count or not min(sizes) > 0):
        given = f"size {shown(geom.get('size'))}" if sizes else "no size"
        raise RobotError(f"the MJCF has a <geom> of type {kind} with {given}: give {count} above 0.")


def _defaults(root: ET.Element) -> dict[str, _Defaults]:
    """What every class of defaults says, with what those around it say; ``main`` is around all."""
    found: dict[str, _Defaults] = {"main": {}}
    waiting = [(each, "main") for each in root.iterfind("default")]
    for default, outer in waiting:  # the loop appends to it
        around = found.get(outer, {})
        own = {each.tag: _over(around.get(each.tag, {}), each.attrib) for each in default if each.tag != "default"}
        name = default.get("class", "main")
        found[name] = {**around, **own}
        if default in root:
            found["main"] = found[name]
        waiting += [(inner, name) for inner in default.iterfind("default")]
    return found


def _over(said: Mapping[str, str], own: Mapping[str, str]) -> dict[str, str]:
    """What defaults have ``said`` and, before that, an element's ``own`` attributes; one placement of the two."""
    turned = ("pos", *_TURNS) if "fromto" in own else _TURNS if any(name in own for name in _TURNS) else ()
    return {**{name: text for name, text in said.items() if name not in turned}, **own}


def _mesh_file(mesh: ET.Element, compiler: ET.Element | None) -> Path:
    """The file of a mesh, relative to the folder of the MJCF."""
    said: Mapping[str, str] = {} if compiler is None else compiler.attrib
    name = Path(mesh.get("file", ""))
    return Path(
        said.get("meshdir") or said.get("assetdir") or "", name.name if said.get("strippath") == "true" else name
    )
