"""Geometry of a robot's links as backend-neutral bodies, and its mesh files."""

import os
import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Literal

import coal
import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats, frozen
from planner.base.captured_output import CapturedOutput
from planner.base.errors import RobotError, SceneError
from planner.base.yamlfile import quote
from planner.robot.files import urdf
from planner.robot.files.meshes import read_display_mesh, read_link_mesh, simplify, split_into_components
from planner.robot.shapes import Body, Box, Capsule, Cylinder, Mesh, Shape, Sphere

Kind = Literal["collision", "visual"]


def read_bodies(
    description: urdf.Description,
    full: pin.Model,
    kind: Kind,
    moving: Collection[str],
    held: Mapping[str, float],
    base: Floats,
) -> tuple[pin.Model, tuple[Body, ...]]:
    """Return the ``full`` model without joints that do not move, and the bodies of one ``kind``."""
    geometry, meshes = read_geometry(description, full, kind)
    links = [full.frames[item.parentFrame].name for item in geometry.geometryObjects]
    model, placed = urdf.reduce_model(full, geometry, moving, held, base)
    try:
        bodies = [
            Body(
                name=item.name,
                link=link,
                joint=int(item.parentJoint),
                shape=meshes.get(item.name) or shape_of(item.geometry, kind),
                placement=frozen(item.placement.homogeneous),
                color=tuple(item.meshColor.tolist()),
            )
            for item, link in zip(placed.geometryObjects, links, strict=True)
            if kind == "visual" or not item.disableCollision
        ]
        whole = kind == "visual" or not description.pieces
        return model, tuple(bodies if whole else [piece for body in bodies for piece in split_into_components(body)])
    except SceneError as error:
        raise RobotError(f"the {kind} geometry of {description.path}: {error}") from None


def read_geometry(
    description: urdf.Description, model: pin.Model, kind: Kind
) -> tuple[pin.GeometryModel, dict[str, Mesh]]:
    """Return the geometry of one ``kind``, with a ball for each mesh, and the meshes by name."""
    if description.geometry:
        return description.geometry[kind].copy(), {}
    xml, meshes = _without_meshes(description, kind)
    printed = CapturedOutput()
    try:
        with printed:
            geometry = pin.buildGeomFromUrdfString(
                model, xml, pin.GeometryType.COLLISION if kind == "collision" else pin.GeometryType.VISUAL
            )
    except (ValueError, RuntimeError) as error:
        because = str(error).partition("\n")[0].rstrip(".")
        raise RobotError(f"the geometry of {description.path} cannot be read ({because}): mend the file.") from None
    if kind == "collision" and geometry.ngeoms < description.collision_elements:
        because = f" ({reason})" if (reason := printed.first_error()) else ""
        raise RobotError(
            f"only {geometry.ngeoms} of the {description.collision_elements} collision geometries of "
            f"{description.path} could be read{because}: use box, sphere, cylinder, capsule or mesh."
        )
    if not meshes.keys() <= {item.name for item in geometry.geometryObjects}:
        raise RobotError(f"not all meshes of {description.path} could be read: mend the file.")
    return geometry, meshes


def _without_meshes(description: urdf.Description, kind: Kind) -> tuple[str, dict[str, Mesh]]:
    """Return the URDF with a ball in place of each mesh of one ``kind``, and the meshes by name."""
    root, meshes = ET.fromstring(description.xml), dict[str, Mesh]()
    read: dict[tuple[str, str], Mesh] = {}
    for link in root.iterfind("link"):
        for number, element in enumerate(link.iterfind(kind)):
            geometry, mesh = element.find("geometry"), element.find("geometry/mesh")
            if geometry is None or mesh is None:
                continue
            key = mesh.get("filename", ""), mesh.get("scale", "1 1 1")
            if key not in read:
                read[key] = _read(description, *key, kind)
            meshes[f"{link.get('name')}_{number}"] = read[key]
            geometry.remove(mesh)
            ET.SubElement(geometry, "sphere", radius="1")
    return (ET.tostring(root, encoding="unicode") if meshes else description.xml), meshes


def _read(description: urdf.Description, name: str, scale: str, kind: Kind) -> Mesh:
    if (own := description.meshes.get(name)) is not None:
        return simplify(own) if kind == "collision" else read_display_mesh(own)
    file = next(_mesh_paths(description, name), None)
    if file is None:
        raise RobotError(
            f"mesh file {quote(name)} of {description.path} not found: put it where the URDF names it, or name the "
            "folder of its package in ROS_PACKAGE_PATH."
        )
    try:
        x, y, z = map(float, scale.split())
    except ValueError:
        raise RobotError(f"scale of {quote(name)} must be three numbers, got {quote(scale)}; mend the file.") from None
    return (read_link_mesh if kind == "collision" else read_display_mesh)(file, np.array([x, y, z]))


def mesh_files(description: urdf.Description, kind: Kind | None = None) -> list[Path]:
    """Return the existing mesh files of one ``kind`` or both, in a fixed order."""
    root, paths = ET.fromstring(description.xml), list[Path]()
    for each in (kind,) if kind else ("collision", "visual"):
        names = {mesh.get("filename", "") for element in root.iter(each) for mesh in element.iter("mesh")}
        paths += [path for name in sorted(names) for path in _mesh_paths(description, name)]
    return paths


def _mesh_paths(description: urdf.Description, name: str) -> Iterator[Path]:
    """Return the existing files that a mesh name may refer to."""
    place = name.removeprefix("file://")
    paths = (Path(folder) / place for folder in description.package_dirs)
    return (path for path in paths if os.path.isfile(path))


def shape_of(geometry: coal.CollisionGeometry, kind: Kind = "collision") -> Shape:
    """Return a coal geometry as a shape, collision meshes simplified; :class:`RobotError` if unsupported."""
    if isinstance(geometry, coal.ShapeBase) and geometry.getSweptSphereRadius() > 0:
        raise RobotError("a shape with a swept sphere radius is not supported: make the shape itself larger.")
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
        case coal.Convex():
            return _mesh(geometry.points(), map(geometry.polygons, range(geometry.num_polygons)), kind)
        case coal.BVHModelBase():
            return _mesh(geometry.vertices(), map(geometry.tri_indices, range(geometry.num_tris)), kind)
    raise RobotError(f"{type(geometry).__name__} is not supported: use box, sphere, cylinder, capsule or mesh.")


def _mesh(points: Floats, triangles: Iterable[coal.Triangle], kind: Kind) -> Mesh:
    mesh = Mesh(points, np.array([(each[0], each[1], each[2]) for each in triangles])).merge_vertices()
    return simplify(mesh) if kind == "collision" else mesh
