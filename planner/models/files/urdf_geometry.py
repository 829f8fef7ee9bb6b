"""The geometry of a robot's links as backend-neutral bodies, its meshes out of the cache, and its mesh files."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pinocchio as pin

from planner.base.arrays import frozen
from planner.base.errors import RobotError, choices
from planner.base.silenced import Silenced
from planner.models.files.meshes import MeshFault, link_mesh, mesh_loader, reason, require_readable_mesh, shape_of
from planner.models.files.thinned import thinned
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
    xml, meshes = _without_meshes(description, kind, read)
    for file in mesh_files(description, kind):
        if file not in {path for path, _ in read}:
            require_readable_mesh(file)
    printed, loader = Silenced(), mesh_loader()
    try:
        with printed:
            geometry = pin.buildGeomFromUrdfString(model, xml, _KINDS[kind], None, description.package_dirs, loader)
    except (ValueError, RuntimeError) as error:
        raise RobotError(
            f"a mesh of {description.path} cannot be loaded ({reason(error)}): put the file where the URDF names it, "
            "or name the folder of its package in ROS_PACKAGE_PATH."
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


def _without_meshes(
    description: Description, kind: Kind, read: dict[tuple[Path, str], Mesh]
) -> tuple[str, dict[str, Mesh]]:
    """The URDF with a ball in place of meshes of a ``kind``, and these by their names in Pinocchio.

    Files of visual meshes are left to Pinocchio; ``read`` takes every other mesh by its file and scale.
    """
    root, found = ET.fromstring(description.xml), {}
    for link in root.iterfind("link"):
        for number, element in enumerate(link.iterfind(kind)):
            geometry, mesh = element.find("geometry"), element.find("geometry/mesh")
            if geometry is None or mesh is None:
                continue
            name, scale = mesh.get("filename", ""), mesh.get("scale", "1 1 1")
            own, file = description.meshes.get(name), next(_places(description, name), None)
            if own is not None:
                found[f"{link.get('name')}_{number}"] = thinned(own) if kind == "collision" else own
            elif kind == "collision" and file is not None and file.suffix.lower() in _ONE_FILE:
                if (file, scale) not in read:
                    read[file, scale] = link_mesh(file, np.array(scale.split(), dtype=float))
                found[f"{link.get('name')}_{number}"] = read[file, scale]
            else:
                continue
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
    found = (Path(folder) / place for folder in description.package_dirs)
    return (path for path in found if os.path.isfile(path))


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
