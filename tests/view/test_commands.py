"""The viewer's commands against what meshcat's own Python package sends for the same objects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import meshcat.commands as theirs
import meshcat.geometry as g
import numpy as np
import pytest
import umsgpack
from meshcat.path import Path as ScenePath

from planner.view import commands

PLACE = ScenePath(("meshcat", "a", "b"))
CORNERS = np.array([[0.0, 0.1, 0.2], [1.0, 1.1, 1.2], [2.0, 2.1, 2.2], [3.0, 3.1, 3.2]])
FACES = np.array([[0, 1, 2], [2, 1, 3]])
SINGLE = CORNERS.astype(np.float32)
Geometry = Callable[[], Any]

GEOMETRIES: dict[str, tuple[dict[str, Any], Geometry]] = {
    "box": (commands.box((0.1, 0.2, 0.3)), lambda: g.Box([0.1, 0.2, 0.3])),
    "sphere": (commands.sphere(0.1), lambda: g.Sphere(0.1)),
    "cylinder": (commands.cylinder(0.1, 0.4), lambda: g.Cylinder(0.4, 0.1)),
    "triangles": (commands.triangles(CORNERS, FACES), lambda: g.TriangularMeshGeometry(CORNERS, FACES)),
    "points": (commands.coloured_points(CORNERS, CORNERS / 4), lambda: g.PointsGeometry(SINGLE.T, (SINGLE / 4).T)),
}


def same(ours: dict[str, Any], sent: Any) -> None:
    """Equal as the viewer reads them, whatever the parts are called by which they speak of each other."""
    assert renamed(ours) == renamed(sent.lower())


def renamed(command: dict[str, Any]) -> Any:
    names: dict[str, int] = {}

    def walk(value: Any) -> Any:
        if isinstance(value, dict):
            return {
                key: names.setdefault(item, len(names))
                if key in ("uuid", "geometry", "material") and isinstance(item, str)
                else walk(item)
                for key, item in value.items()
            }
        return [walk(item) for item in value] if isinstance(value, list) else value

    return walk(umsgpack.unpackb(umsgpack.packb(command)))


@pytest.mark.parametrize("name", GEOMETRIES)
@pytest.mark.parametrize("opacity", [1.0, 0.4])
def test_surfaces(name: str, opacity: float) -> None:
    ours, made = GEOMETRIES[name]
    material = g.MeshPhongMaterial(color=0x102030, opacity=opacity)
    sent = theirs.SetObject(made(), material, PLACE)
    same(commands.set_object("/meshcat/a/b", "Mesh", ours, commands.surface(0x102030, opacity)), sent)


def test_dots_and_lines() -> None:
    ours, made = GEOMETRIES["points"]
    dots: Any = g.PointsMaterial(size=0.02)
    same(
        commands.set_object("/meshcat/a/b", "Points", ours, commands.dots(0.02)),
        theirs.SetObject(g.Points(made(), dots), None, PLACE),
    )
    lines: Any = g.LineBasicMaterial(vertexColors=True, opacity=0.3)
    same(
        commands.set_object("/meshcat/a/b", "LineSegments", ours, commands.lines(0.3)),
        theirs.SetObject(g.LineSegments(made(), lines), None, PLACE),
    )


def test_places_properties_and_deletion() -> None:
    matrix = np.arange(16.0).reshape(4, 4)
    same(commands.set_transform("/meshcat/a/b", matrix), theirs.SetTransform(matrix, PLACE))
    same(commands.set_property("/meshcat/a/b", "visible", False), theirs.SetProperty("visible", False, PLACE))
    same(commands.delete("/meshcat/a/b"), theirs.Delete(PLACE))


def test_parts_of_two_objects_are_told_apart() -> None:
    ours = GEOMETRIES["box"][0]
    made = [commands.set_object(path, "Mesh", ours, commands.surface(0, 1.0))["object"] for path in ("/a", "/b")]
    names = [part["uuid"] for one in made for part in (one["object"], *one["geometries"], *one["materials"])]
    assert len(set(names)) == 6
