"""Collision objects of a message as our obstacles and carried shapes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from planner.base.errors import SceneError
from planner.base.yamlfile import repeated, shown
from planner.models.files.moveit.messages import AttachedCollisionObject, CollisionObject, MeshMessage, SolidPrimitive
from planner.models.shapes import Box, Carried, Cylinder, Mesh, Obstacle, Shape, Sphere


def solid(primitive: SolidPrimitive, where: str) -> Shape:
    """A primitive as one of our shapes; SceneError, beginning with ``where``, for one that we do not have."""
    match primitive.kind, primitive.dimensions:
        case "box", [x, y, z]:
            return Box((x, y, z))
        case "sphere", [radius]:
            return Sphere(radius)
        case "cylinder", [height, radius]:
            return Cylinder(radius, height)
    raise SceneError(
        f"{where}: a primitive of type '{primitive.kind}' with {len(primitive.dimensions)} dimensions is not "
        "supported; use box [x, y, z], sphere [radius] or cylinder [height, radius]."
    )


def obstacles(item: CollisionObject, where: str) -> Iterator[Obstacle]:
    """Each shape as an obstacle, in the frame of its header (empty: the scene's), numbered where several."""
    where = f"{where}: object {shown(item.id)}"
    for shapes, poses in ((item.primitives, item.primitive_poses), (item.meshes, item.mesh_poses)):
        if len(shapes) != len(poses):
            raise SceneError(f"{where} has {len(shapes)} shapes and {len(poses)} poses; give one pose a shape.")
    shapes = [*(solid(each, where) for each in item.primitives), *(_mesh(each, where) for each in item.meshes)]
    if not shapes:
        raise SceneError(f"{where} has no shape; give it primitives or meshes, or take it out.")
    for k, (shape, placement) in enumerate(zip(shapes, [*item.primitive_poses, *item.mesh_poses], strict=True)):
        name = item.id if len(shapes) == 1 else f"{item.id}.{k}"
        frame = item.header.frame_id.removeprefix("/")  # tf's first releases wrote a slash before it
        yield Obstacle(name, shape, item.pose.matrix() @ placement.matrix(), item.id, frame=frame)


def _mesh(mesh: MeshMessage, where: str) -> Shape:
    triangles = np.array([t.vertex_indices for t in mesh.triangles], dtype=np.int64).reshape(-1, 3)
    if not len(triangles) or triangles.max() >= len(mesh.vertices):
        raise SceneError(f"{where}: its triangles do not fit its {len(mesh.vertices)} vertices; export it again.")
    return Mesh(np.array(mesh.vertices), triangles)


def carried(items: Sequence[AttachedCollisionObject], where: str) -> tuple[Carried, ...]:
    """The shapes of attached objects, each placed in the frame of its header, or in that of its link without one."""
    require_once([item.object.id for item in items], where)
    return tuple(
        Carried(
            item.link_name,
            shape.name,
            shape.shape,
            shape.placement,
            tuple(item.touch_links),
            shape.frame,
            part_of=shape.part_of,
        )
        for item in items
        for shape in obstacles(item.object, where)
    )


def require_once(names: Sequence[str], where: str) -> None:
    """Raise :class:`SceneError` where a message holds two objects of one name: MoveIt would keep the last only."""
    twice = repeated(names)
    if twice:
        raise SceneError(f"{where}: object {shown(twice[0])} is given twice; rename one, or take it out.")
