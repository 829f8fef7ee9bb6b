"""MuJoCo's MJCF, compiled by mujoco (an optional extra) and written as a URDF.

Each body is a link and each of its joints a URDF joint, with links without geometry between joints of one body. All
digits are kept, so bodies, sites and geoms stand where ``mj_forward`` puts them.
"""

import warnings
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from itertools import compress
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats
from planner.base.cache import content_hash
from planner.base.errors import Note, RobotError, choices, require_extra
from planner.robot.shapes import Mesh

_JOINTS = ("free", "ball", "slide", "hinge")  # in the order of mjtJoint
_GEOMS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf")  # of mjtGeom
_EQUALITIES = ("connect", "weld", "joint", "tendon", "flex", "flexvert", "flexstrain")  # of mjtEq
_COUNTED = {"npair": "pair", "nexclude": "exclude", "nkey": "key", "nflex": "flex", "nmocap": "mocap", "nu": "actuator"}
_REMEDIES = {"free": "leave it out and put what moves freely into a scene", "ball": "write it as three hinges"}
_DRAWN = 3  # MuJoCo draws geoms of lower groups; models keep geoms that only collide in higher ones
_GREY = [0.5, 0.5, 0.5, 1.0]  # the colour of a geom that has none of its own

_Model: TypeAlias = Any  # mujoco.MjModel
Sites: TypeAlias = dict[str, tuple[str, pin.SE3]]  # by name: the link that a site stands on, and its place there


def convert_mjcf(path: Path, name: str) -> tuple[ET.Element, dict[str, Mesh], Sites, tuple[Note, ...]]:
    """Return the robot of an MJCF file as a URDF named ``name``, its meshes, its sites, and notes.

    A note lists elements that URDF lacks. Raises :class:`RobotError` for invalid files and unsupported elements,
    :class:`InstallationError` without mujoco.
    """
    robot, meshes, lost = ET.Element("robot", name=name), dict[str, Mesh](), list[str]()
    try:
        model = _compile(path)
        followers = _followers(model, lost)
        for body in range(model.nbody):
            link = ET.SubElement(robot, "link", name=_name(model.body(body)))
            _add_geoms(link, model, body, meshes, lost)
            if body:  # the first one is the world
                _add_joints(robot, model, body, followers)
    except RobotError as error:
        raise RobotError(f"MJCF {path}: {error}") from None
    taken, sites = {element.get("name") for element in robot}, {}
    for k in range(model.nsite):
        site, link = _name(model.site(k)), _name(model.body(model.site_bodyid[k]))
        sites[f"{site}/site" if site in taken else site] = link, _placement(model.site_pos[k], model.site_quat[k])
    lost += [f"tendon '{_name(model.tendon(k))}'" for k in range(model.ntendon)]
    lost += [f"{number} <{tag}>" for count, tag in _COUNTED.items() if (number := getattr(model, count))]
    text = f"MJCF {path} has parts that are not followed: {choices(lost)}; home and pairs that need no check belong in "
    note = Note(f"{text}a robot.yaml ('planner robot-yaml'), the rest in a scene.", grave=len(lost) > (model.nu > 0))
    return robot, meshes, sites, (note,) if lost else ()


def _compile(path: Path) -> _Model:
    require_extra("mujoco", "mjcf")
    import mujoco

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)  # otherwise MuJoCo writes a file into the working directory
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        for geom in spec.geoms:  # shellinertia concerns masses alone, and MuJoCo 4 refuses it at meshes
            geom.typeinertia = mujoco.mjtGeomInertia.mjINERTIA_VOLUME
        with warnings.catch_warnings(action="ignore"):  # they are about masses
            return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        reason = " ".join(str(error).split()).removeprefix("Error: ")[:300]
        raise RobotError(f"MuJoCo cannot read it ({reason}); mend the file.") from None
    finally:
        mujoco.set_mju_user_warning(before)


def _name(item: Any) -> str:
    """Return the name of an element, or its kind and number without one."""
    return item.name or f"{type(item).__name__.removeprefix('_MjModel').removesuffix('Views').lower()}_{item.id}"


def _followers(model: _Model, lost: list[str]) -> dict[int, dict[str, str]]:
    """Return joints coupled by an equality as <mimic> attributes; other equalities go to ``lost``."""
    followers = dict[int, dict[str, str]]()
    for k in np.flatnonzero(model.eq_active0):
        kind, joint, leader = _EQUALITIES[model.eq_type[k]], model.eq_obj1id[k], model.eq_obj2id[k]
        if kind != "joint" or leader < 0 or joint in followers:
            lost.append(f"equality '{_name(model.equality(k))}' ({kind})")
            continue
        offset, factor, *curved = model.eq_data[k, :5].tolist()
        if any(curved):
            raise RobotError(
                f"joint '{_name(model.joint(joint))}' follows '{_name(model.joint(leader))}' by a polycoef with "
                f"{choices(curved)} after the second number; make these 0."
            )
        zero, leaders_zero = model.qpos0[model.jnt_qposadr[[joint, leader]]].tolist()
        offset += zero - factor * leaders_zero  # MuJoCo counts both joints from their ref
        followers[joint] = {"joint": _name(model.joint(leader)), "multiplier": repr(factor), "offset": repr(offset)}
    return followers


def _add_joints(robot: ET.Element, model: _Model, body: int, followers: Mapping[int, dict[str, str]]) -> None:
    """Connect a body to its parent by its joints, and by a fixed one if none ends in its frame."""
    name, parent = _name(model.body(body)), _name(model.body(model.body_parentid[body]))
    place, first = _placement(model.body_pos[body], model.body_quat[body]), int(model.body_jntadr[body])
    joints = range(first, first + int(model.body_jntnum[body]))
    for k in joints:
        kind, joint = _JOINTS[model.jnt_type[k]], _name(model.joint(k))
        if kind in _REMEDIES:
            raise RobotError(f"joint '{joint}' of body '{name}' is {kind} and has several axes; {_REMEDIES[kind]}.")
        axis, zero, about = model.jnt_axis[k], model.qpos0[model.jnt_qposadr[k]], model.jnt_pos[k]
        if kind == "slide":
            about, place = np.zeros(3), place * pin.SE3(np.eye(3), -zero * axis)
        else:
            place = place * pin.SE3(pin.AngleAxis(-zero, axis).matrix(), about)
        child = name
        if k != joints[-1] or about.any():
            child = f"{name}/{joint}"
            ET.SubElement(robot, "link", name=child)
        limited = bool(model.jnt_limited[k])
        kind = "prismatic" if kind == "slide" else "revolute" if limited else "continuous"
        element = _add_joint(robot, joint, kind, parent, child, place)
        ET.SubElement(element, "axis", xyz=_text(axis))
        limit = ET.SubElement(element, "limit", effort="0", velocity="0")
        if limited:
            limit.attrib |= zip(("lower", "upper"), map(repr, model.jnt_range[k].tolist()), strict=True)
        if k in followers:
            ET.SubElement(element, "mimic", followers[k])
        parent, place = child, pin.SE3(np.eye(3), -about)
    if parent != name:
        _add_joint(robot, f"{name}/fixed", "fixed", parent, name, place)


def _add_joint(robot: ET.Element, name: str, kind: str, parent: str, child: str, place: pin.SE3) -> ET.Element:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    _add_origin(joint, place)
    return joint


def _add_geoms(link: ET.Element, model: _Model, body: int, meshes: dict[str, Mesh], lost: list[str]) -> None:
    """Add a body's geoms to its link; unsupported visual geoms and grounds go to ``lost``."""
    first = int(model.body_geomadr[body])
    for k in range(first, first + int(model.body_geomnum[body])):
        type_, collides = _GEOMS[model.geom_type[k]], bool(model.geom_contype[k] or model.geom_conaffinity[k])
        called, shape = f"geom '{_name(model.geom(k))}' ({type_})", _shape(type_, model, k, meshes)
        if shape is None and collides and type_ not in ("plane", "hfield"):
            text = f"{called} of body '{link.get('name')}' collides and has no equal in a URDF"
            raise RobotError(f"{text}; make it a box, sphere, capsule, cylinder or mesh.")
        if shape is None:
            lost.append(called)
            continue
        drawn = not collides or model.geom_group[k] < _DRAWN
        for kind in compress(("collision", "visual"), (collides, drawn)):
            element = ET.SubElement(link, kind)
            _add_origin(element, _placement(model.geom_pos[k], model.geom_quat[k]))
            ET.SubElement(element, "geometry").append(shape)
            if kind == "visual":
                painted = model.geom_matid[k] >= 0 and np.allclose(model.geom_rgba[k], _GREY)
                color = model.mat_rgba[model.geom_matid[k]] if painted else model.geom_rgba[k]
                ET.SubElement(ET.SubElement(element, "material", name=""), "color", rgba=_text(color))


def _shape(type_: str, model: _Model, geom: int, meshes: dict[str, Mesh]) -> ET.Element | None:
    """Return the URDF element of a geom, or None; meshes go to ``meshes`` under their hash."""
    size = model.geom_size[geom]
    match type_:
        case "box":
            return ET.Element("box", size=_text(2 * size))
        case "sphere":
            return ET.Element("sphere", radius=_text(size[:1]))
        case "capsule" | "cylinder":
            return ET.Element(type_, radius=_text(size[:1]), length=_text(2 * size[1:2]))
        case "mesh":
            k = model.geom_dataid[geom]
            first, face = model.mesh_vertadr[k], model.mesh_faceadr[k]
            vertices = model.mesh_vert[first : first + model.mesh_vertnum[k]].astype(float)
            mesh = Mesh(vertices, model.mesh_face[face : face + model.mesh_facenum[k]].astype(int))
            name = content_hash(mesh.content())
            meshes[name] = mesh
            return ET.Element("mesh", filename=name)
    return None


def _placement(position: Floats, quaternion: Floats) -> pin.SE3:
    """Return a placement from MuJoCo's numbers, w first."""
    return pin.SE3(pin.Quaternion(*quaternion.tolist()), np.array(position))


def _add_origin(element: ET.Element, place: pin.SE3) -> None:
    turn = pin.Quaternion(place.rotation).coeffs()  # of roll, pitch and yaw digits would be lost
    ET.SubElement(element, "origin", xyz=_text(place.translation), quat_xyzw=_text(turn))


def _text(numbers: Floats) -> str:
    return " ".join(map(repr, np.asarray(numbers).tolist()))
