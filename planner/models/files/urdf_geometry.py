"""The geometry of a robot's links as backend-neutral bodies, its meshes out of the cache, and its mesh files."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pinocchio as pin

from planner.base.arrays import frozen
from planner.base.errors import RobotError, choices
from planner.base.files import is_file
from planner.base.silenced import Silenced
from planner.models.files import mjcf
from planner.models.files.meshes import MeshFault, link_mesh, mesh_loader, reason, require_readable_mesh, shape_of
from planner.models.files.urdf import Description
from planner.models.shapes import Body, Mesh, Shape

Kind = Literal["collision", "visual"]

_KINDS: dict[Kind, pin.GeometryType] = {
    "collision": pin.GeometryType.COLLISION,
    "visual": pin.GeometryType.VISUAL,
}
_ONE_FILE = (".stl", ".obj", ".dae", ".ply")  # kinds of which one file says all about the triangles


@dataclass(frozen=True, eq=False)
class Geometry:
    """Pinocchio's geometry, the link that each geometry hangs on, and the meshes that stand for some, by name."""

    model: pin.GeometryModel
    links: Mapping[str, str]
    meshes: Mapping[str, Mesh]


def read_geometry(description: Description, model: pin.Model, kind: Kind) -> Geometry:
    """The geometry of one ``kind``; meshes that collide are read by us, large ones thinned: none to Pinocchio."""
    read: dict[tuple[Path, str], Mesh] = {}
    xml, meshes = description.xml, {}
    if kind == "collision" and not description.is_mjcf:
        xml, meshes = _without_meshes(description, read)
    for file in mesh_files(description, kind):
        if file not in {path for path, _ in read}:
            require_readable_mesh(file)
    printed, loader = Silenced(), mesh_loader()
    try:
        with printed:
            if description.is_mjcf:
                geometry = mjcf.geometry_of(description.path, model, _KINDS[kind])
            else:
                geometry = pin.buildGeomFromUrdfString(model, xml, _KINDS[kind], None, description.package_dirs, loader)
    except (ValueError, RuntimeError) as error:
        raise RobotError(
            f"a mesh of {description.path} cannot be loaded ({reason(error)}): put it beside the URDF "
            "or set ROS_PACKAGE_PATH."
        ) from None
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


def _without_meshes(description: Description, read: dict[tuple[Path, str], Mesh]) -> tuple[str, dict[str, Mesh]]:
    """The URDF with a ball in place of every mesh that collides, and these meshes by their names in Pinocchio.

    ``read`` takes every mesh by its file and scale.
    """
    root, found = ET.fromstring(description.xml), {}
    for link in root.iterfind("link"):
        for number, collision in enumerate(link.iterfind("collision")):
            geometry, mesh = collision.find("geometry"), collision.find("geometry/mesh")
            if geometry is None or mesh is None:
                continue
            file, scale = next(_places(description, mesh.get("filename", "")), None), mesh.get("scale", "1 1 1")
            if file is None or file.suffix.lower() not in _ONE_FILE:
                continue
            if (file, scale) not in read:
                read[file, scale] = link_mesh(file, np.array(scale.split(), dtype=float))
            found[f"{link.get('name')}_{number}"] = read[file, scale]
            geometry.remove(mesh)
            ET.SubElement(geometry, "sphere", radius="1")
    return (ET.tostring(root, encoding="unicode") if found else description.xml), found


def mesh_files(description: Description, *kinds: Kind) -> Iterator[Path]:
    """The mesh files that the URDF names, of some ``kinds`` or of all, as far as they are found, in a fixed order."""
    for kind in kinds or _KINDS:
        for name in description.mesh_names[kind]:
            yield from _places(description, name)


def _places(description: Description, name: str) -> Iterator[Path]:
    """The files that a mesh of this ``name`` may be in."""
    place = name.removeprefix("file://")
    if place.startswith(("package://", "model://")):
        place = place.partition("://")[2].lstrip("/")  # talos writes package:///
    found = (Path(folder) / place for folder in description.package_dirs)
    return (path for path in found if is_file(path))


def bodies(placed: pin.GeometryModel, geometry: Geometry) -> tuple[Body, ...]:
    """Pinocchio's geometry objects, ``placed`` on a reduced model, as backend-neutral bodies, in their order."""
    return tuple(
        Body(
            name=item.name,
            link=geometry.links[item.name],
            joint=int(item.parentJoint),
            shape=geometry.meshes.get(item.name) or _shape(item),
            placement=frozen(item.placement.homogeneous),
            color=tuple(item.meshColor.tolist()),
        )
        for item in placed.geometryObjects
    )


def _shape(item: pin.GeometryObject) -> Shape:
    try:
        return shape_of(item.geometry)
    except MeshFault as wrong:
        raise RobotError(
            f"mesh {item.meshPath} of '{item.name}' {wrong}: check its scale, or export it again."
        ) from None
    except ValueError as error:
        raise RobotError(f"geometry '{item.name}': {error}; use box, sphere, cylinder, capsule or mesh.") from None
