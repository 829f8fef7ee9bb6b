"""MuJoCo's MJCF as a description of a robot, as far as Pinocchio reads it: bodies, hinges, slides, simple geometry."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin

from planner.base.errors import RobotError, choices
from planner.base.silenced import Silenced

IGNORED = ("contact", "equality", "tendon")  # elements that a robot may move otherwise by


def require_one_robot(root: ET.Element, path: Path) -> None:
    """Refuse a file with several bodies in its world: Pinocchio forgets where the first stands."""
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
        with printed:
            model = pin.buildModelFromMJCF(str(path))
    except (ValueError, RuntimeError) as error:
        said = " ".join((printed.complaint() or str(error)).split())[:200]
        raise RobotError(f"MJCF {path} cannot be read ({said}): export it again, or convert it to a URDF.") from None
    low, high, turning = model.lowerPositionLimit, model.upperPositionLimit, set[str]()
    for name, joint in zip(model.names[1:], list(model.joints)[1:], strict=True):
        k = joint.idx_q
        if joint.nq == 1 and joint.shortname().startswith("JointModelR") and not np.isfinite([low[k], high[k]]).all():
            low[k], high[k] = -np.pi, np.pi
            turning.add(name)
    return model, frozenset(turning)


def geometry_of(path: Path, model: pin.Model, kind: pin.GeometryType) -> pin.GeometryModel:
    """Pinocchio's geometry of the robot in an MJCF file, without what belongs to the world: the floor and the like."""
    geometry = pin.buildGeomFromMJCF(model, str(path), kind)
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
    compiler = root.find("compiler")
    folder = "" if compiler is None else compiler.get("meshdir") or compiler.get("assetdir") or ""
    return sorted(str(Path(folder) / mesh.get("file", "")) for mesh in root.iter("mesh") if mesh.get("file"))


def passed_over(root: ET.Element) -> list[str]:
    """Elements of the file that are not followed."""
    world = ["worldbody/geom"] if root.find("worldbody/geom") is not None else []
    first = root.find("worldbody/body")
    ways = ("pos", "quat", "euler", "axisangle", "xyaxes", "zaxis")
    posed = first is not None and any(first.get(name) for name in ways)
    placed = ["where its first body stands (see --base)"] if posed else []
    return [*(item.tag for item in root if item.tag in IGNORED and len(item)), *world, *placed]
