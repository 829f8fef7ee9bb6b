"""The geometry of a robot's links as backend-neutral bodies, its meshes out of the cache, and its mesh files."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import coal
import numpy as np
import pinocchio as pin

from planner.base.arrays import frozen
from planner.base.errors import RobotError, choices
from planner.base.silenced import Silenced
from planner.base.yamlfile import shown
from planner.robot.files.meshes import link_mesh, read_mesh, thinned
from planner.robot.files.urdf import Description
from planner.robot.shapes import Body, Box, Capsule, Cylinder, Mesh, Shape, Sphere

Kind = Literal["collision", "visual"]

_KINDS: dict[Kind, pin.GeometryType] = {
    "collision": pin.GeometryType.COLLISION,
    "visual": pin.GeometryType.VISUAL,
}


@dataclass(frozen=True, eq=False)
class Geometry:
    """Pinocchio's geometry, the link that each geometry hangs on, and the meshes that stand for some, by name."""

    model: pin.GeometryModel
    links: Mapping[str, str]
    meshes: Mapping[str, Mesh]


def read_geometry(description: Description, model: pin.Model, kind: Kind) -> Geometry:
    """The geometry of one ``kind``; Pinocchio places it and gets a ball for each mesh."""
    xml, meshes = _without_meshes(description, kind)
    printed = Silenced()
    try:
        with printed:
            geometry = pin.buildGeomFromUrdfString(model, xml, _KINDS[kind])
    except (ValueError, RuntimeError) as error:
        because = str(error).partition("\n")[0].rstrip(".")
        raise RobotError(f"the geometry of {description.path} cannot be read ({because}): mend the file.") from None
    if kind == "collision" and geometry.ngeoms < description.collision_elements:
        because = f" ({said})" if (said := printed.complaint()) else ""
        raise RobotError(
            f"only {geometry.ngeoms} of the {description.collision_elements} collision geometries of "
            f"{description.path} could be read{because}: use box, sphere, cylinder, capsule or mesh."
        )
    links = {item.name: model.frames[item.parentFrame].name for item in geometry.geometryObjects}
    if not meshes.keys() <= links.keys():
        lost = sorted(meshes.keys() - links.keys())
        raise RobotError(
            f"collision geometries of {description.path} are not found again: {choices(lost)}; mend the file."
        )
    return Geometry(geometry, links, meshes)


def _without_meshes(description: Description, kind: Kind) -> tuple[str, dict[str, Mesh]]:
    """The URDF with a ball in place of each mesh of a ``kind``, and the meshes by their names in Pinocchio.

    Meshes that collide are thinned; each file is read once for a scale.
    """
    root, found = ET.fromstring(description.xml), dict[str, Mesh]()
    read: dict[tuple[str, str], Mesh] = {}
    for link in root.iterfind("link"):
        for number, element in enumerate(link.iterfind(kind)):
            geometry, mesh = element.find("geometry"), element.find("geometry/mesh")
            if geometry is None or mesh is None:
                continue
            key = mesh.get("filename", ""), mesh.get("scale", "1 1 1")
            if key not in read:
                read[key] = _read(description, *key, kind)
            found[f"{link.get('name')}_{number}"] = read[key]
            geometry.remove(mesh)
            ET.SubElement(geometry, "sphere", radius="1")
    return (ET.tostring(root, encoding="unicode") if found else description.xml), found


def _read(description: Description, name: str, scale: str, kind: Kind) -> Mesh:
    if (own := description.meshes.get(name)) is not None:
        return thinned(own) if kind == "collision" else own
    file = next(_places(description, name), None)
    if file is None:
        raise RobotError(
            f"mesh file {shown(name)} of {description.path} not found: put it where the URDF names it, or name the "
            "folder of its package in ROS_PACKAGE_PATH."
        )
    return (link_mesh if kind == "collision" else read_mesh)(file, np.array(scale.split(), dtype=float))


def mesh_files(description: Description, *kinds: Kind) -> Iterator[Path]:
    """The mesh files that the URDF names, of some ``kinds`` or of all, as far as they are found, in a fixed order."""
    for kind in kinds or _KINDS:
        for name in description.mesh_names[kind]:
            yield from _places(description, name)


def _places(description: Description, name: str) -> Iterator[Path]:
    """The files that a mesh of this ``name`` may be in."""
    place = name.removeprefix("file://")
    found = (Path(folder) / place for folder in description.package_dirs)
    return (path for path in found if os.path.isfile(path))


def bodies(placed: pin.GeometryModel, geometry: Geometry) -> tuple[Body, ...]:
    """Pinocchio's geometry objects, ``placed`` on a reduced model, as backend-neutral bodies, in their order."""
    return tuple(
        Body(
            name=item.name,
            link=geometry.links[item.name],
            joint=int(item.parentJoint),
            shape=geometry.meshes.get(item.name) or shape_of(item.geometry),
            placement=frozen(item.placement.homogeneous),
            color=tuple(item.meshColor.tolist()),
        )
        for item in placed.geometryObjects
    )


def shape_of(geometry: coal.CollisionGeometry) -> Shape:
    """A coal geometry as a shape of ours; :class:`RobotError` for another kind."""
    match geometry:
        case coal.Box():
            x, y, z = (float(2 * half) for half in geometry.halfSide)
            return Box((x, y, z))
        case coal.Sphere():
            return Sphere(float(geometry.radius))
        case coal.Capsule():
            return Capsule(float(geometry.radius), float(2 * geometry.halfLength))
        case coal.Cylinder():
            return Cylinder(float(geometry.radius), float(2 * geometry.halfLength))
    raise RobotError(f"{type(geometry).__name__} is not supported: use box, sphere, cylinder, capsule or mesh.")
