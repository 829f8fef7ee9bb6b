"""Mesh files as shapes, read by trimesh: STL, OBJ, PLY, COLLADA (with pycollada) and GLB.

Numbers are used unchanged, as in MoveIt: notes name COLLADA files whose unit or up axis would change them.

Large link meshes are simplified: vertices of one grid cell become one (Rossignac and Borrel 1993). If no vertex moves
farther than r, no point of a triangle does, so the old surface lies within r of the new one, and a proof with the new
surface rounded by r holds for the old one. Beyond r inside and outside stay the same. Closed components stay closed,
because every edge follows its ends. A coarser grid simplifies meshes for display.
"""

import io
import logging
import os
import re
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from importlib.metadata import version
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.cache import load_or_compute
from planner.base.captured_output import PROCESS
from planner.base.errors import FileError, Note, choices
from planner.base.files import StrPath
from planner.base.yamlfile import quote
from planner.robot.shapes import Body, Mesh
from planner.robot.solids import component_of_vertices, is_closed

MANY = 2000  # triangles: larger meshes are simplified
CELL = 1e-3  # m: a cell of the grid
_MOST_COMPONENTS = 8  # of a mesh: each one adds a body and its pairs
DRAWN_MANY = 3000  # triangles of a displayed mesh, on the finest sufficient grid, or the last
DRAWN_CELLS = (0.5e-3, 1e-3, 2.1e-3)  # m: half a diagonal is below 2 mm
_CREASE = np.radians(35.0)  # an edge at which faces meet at a larger angle stays sharp
_WIDEST = 1000.0  # m: cell numbers of larger meshes would overflow
_WORTH = 0.75  # share of triangles above which simplification is not used
_ROUNDING = 1e-9  # m: rounding of a computed distance
_UNSUPPORTED = {  # lines and elements that the readers ignore or misread
    "obj": re.compile(
        rb"(?m)^(?:[VF] .*|f(?: \S+){1,2}$|f(?: \S+)* (?:-|0(?![.\d])).*|v(?: \S+){3} (?!1(?:\.0*)?$)\S+$"
        rb"|(?:call|cstype|curv2?|surf|csh|bzp|bsp|cd[pc]|res)\b.*)"
    ),
    "glb": re.compile(rb'"mode"\s*:\s*6|KHR_draco\w+|\w+_meshopt\w+'),  # fans, compressed parts
    "dae": re.compile(rb"<(?:\w+:)?(?:instance_controller|skew|ph|convex_mesh|spline|brep)\b"),
}
_LIBRARIES = ("effects", "materials", "images", "cameras", "lights", "animations", "controllers")
_UNNEEDED = {*(f"library_{name}" for name in _LIBRARIES), "bind_material", "instance_camera", "instance_light"}
_FACET = re.compile(rb"(?i)\bfacet\b")
_UNIT = re.compile(rb"<unit\b[^>]*?\bmeter\s*=\s*[\"']([^\"'<>]{1,40})")
_AXIS = re.compile(rb"<up_axis>\s*([XY]_UP)\b")


def read_mesh(path: StrPath, scale: float | Floats = 1.0) -> Mesh:
    """Return the triangles of a mesh file, in metres after ``scale``.

    Units and up axes of the file are ignored, and no other file is read. Raises :class:`FileError` for a file without a
    usable mesh.
    """
    path = Path(path)
    if not os.path.isfile(path):
        raise FileError(f"mesh file {path} not found: check 'file', which is relative to the scene file.")
    try:
        vertices, triangles = _triangles(path)
        mesh = Mesh(vertices * scale, triangles)
    except Exception as error:  # trimesh raises errors of every kind for damaged files
        reason = " ".join(str(error).split())[:160].rstrip(".") or type(error).__name__
        raise FileError(
            f"mesh file {path} cannot be read ({reason}): check 'scale', or export it again as STL, OBJ, PLY, DAE or "
            "GLB."
        ) from None
    return mesh.merge_vertices()


def read_vertices(path: Path) -> Floats:
    """Return the points (n, 3) of a PLY or XYZ file; it raises whatever trimesh raises."""
    import trimesh  # 0.4 s to load

    with PROCESS, np.errstate(all="ignore"):
        cloud: Any = trimesh.load(path, process=False)
        return np.asarray(cloud.vertices, dtype=float)


def read_link_mesh(path: Path, scale: Floats) -> Mesh:
    """Return the simplified mesh of a link's file, in metres after ``scale`` (3,), from the cache.

    Raises :class:`FileError` as :func:`read_mesh`.
    """
    made_of = [*_content(path, scale), CELL, MANY]
    return _load_or_make_mesh("meshes", made_of, lambda: simplify(read_mesh(path, scale)))


def read_display_mesh(source: Path | Mesh, scale: float | Floats = 1.0) -> Mesh:
    """Return a mesh for display, from a mesh or file; surfaces differ by at most 2 mm.

    It has few triangles, and no shared vertices at sharp edges. Cached as :func:`read_link_mesh`.
    """
    read = (lambda: source) if isinstance(source, Mesh) else lambda: read_mesh(source, scale)
    content = source.content() if isinstance(source, Mesh) else _content(source, scale)
    return _load_or_make_mesh(
        "drawn", [*content, DRAWN_MANY, DRAWN_CELLS, _CREASE], lambda: _simplify_for_display(read())
    )


def _content(path: Path, scale: float | Floats) -> list[Any]:
    return [path.suffix.lower(), scale, np.frombuffer(path.read_bytes(), dtype=np.uint8), version("trimesh")]


def _load_or_make_mesh(kind: str, made_of: list[Any], make: Callable[[], Mesh]) -> Mesh:
    arrays = load_or_compute(kind, made_of, lambda: {k: np.asarray(v) for k, v in vars(make()).items()})
    return Mesh(arrays["vertices"], arrays["triangles"], float(arrays["radius"]))


def split_into_components(body: Body) -> list[Body]:
    """Return a body per connected component of the mesh: their hulls fit closer than one hull.

    At most ``_MOST_COMPONENTS``. A component inside the box of a larger one stays with it, so hollow bodies stay
    hollow.
    """
    mesh = body.shape
    if not isinstance(mesh, Mesh):
        return [body]
    number = component_of_vertices(mesh)[mesh.triangles].max(axis=1)
    rows = [np.flatnonzero(number == k) for k in np.unique(number)]
    corners = [mesh.vertices[mesh.triangles[own]] for own in rows]
    low, high = (np.array([end(each, axis=(0, 1)) for each in corners]) for end in (np.min, np.max))
    groups: list[list[int]] = []  # components of one body each, the largest first
    for k in np.argsort(-np.linalg.norm(high - low, axis=1), kind="stable").tolist():
        heads = [own[0] for own in reversed(groups)]
        outside = (np.maximum(high[k] - high[heads], 0.0) + np.maximum(low[heads] - low[k], 0.0)).sum(axis=1)
        if len(groups) < _MOST_COMPONENTS and outside.all():
            groups.append([k])
        else:
            groups[-1 - int(outside.argmin())].append(k)
    bodies = list[Body]()
    for own in groups:
        used, triangles = np.unique(mesh.triangles[np.concatenate([rows[k] for k in own])], return_inverse=True)
        shape = Mesh(mesh.vertices[used], triangles.reshape(-1, 3), mesh.radius)
        bodies.append(replace(body, name=f"{body.name}, piece {len(bodies) + 1}", shape=shape))
    return bodies if len(bodies) > 1 else [body]


def _simplify_for_display(mesh: Mesh) -> Mesh:
    simple = mesh
    for cell in DRAWN_CELLS if float(np.ptp(mesh.vertices, axis=0).max()) <= _WIDEST else ():
        if len(simple.triangles) <= DRAWN_MANY:
            break
        simple = _merge_for_display(mesh, cell)
    sharp = split_at_creases(simple)
    first = np.argmin(sharp.triangles, axis=1)[:, None]  # triangles in order: a page's gzip finds more to share
    triangles = np.take_along_axis(sharp.triangles, (first + np.arange(3)) % 3, axis=1)
    return Mesh(sharp.vertices, triangles[np.lexsort(triangles.T[::-1])])


def _merge_for_display(mesh: Mesh, cell: float) -> Mesh:
    """Return the mesh merged on a grid; triangles that would collapse out of sight stay."""
    middle, which, _ = _cells(mesh, None, cell)
    moved, count = which[mesh.triangles], len(middle)
    flat = np.diff(np.sort(moved, axis=1), axis=1).min(axis=1) == 0
    whole = moved[~flat]
    known = [np.minimum(a, b) * count + np.maximum(a, b) for a, b in combinations_with_replacement(whole.T, 2)]
    alone = flat & ~np.isin(moved.min(axis=1) * count + moved.max(axis=1), known)
    return Mesh(np.vstack([middle, mesh.vertices]), np.vstack([whole, mesh.triangles[alone] + count]))


def split_at_creases(mesh: Mesh) -> Mesh:
    """Return the mesh with shared vertices except at edges of more than 35 degrees.

    A viewer averages normals over shared vertices: separate triangles look faceted, merged ones look melted.
    """
    import trimesh

    welded = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    welded.merge_vertices()
    smooth = trimesh.graph.smooth_shade(welded, angle=_CREASE, facet_minarea=None)
    return Mesh(np.asarray(smooth.vertices), np.asarray(smooth.faces))


def _triangles(path: Path) -> tuple[Floats, Ints]:
    """Return vertices (n, 3) and triangles (m, 3) of a file; any exception of trimesh may pass."""
    import trimesh  # 0.4 s to load
    from trimesh.exchange.load import mesh_loaders

    kind = path.suffix.lower().removeprefix(".")
    if kind not in ("stl", "obj", "ply", "dae", "glb"):
        raise ValueError(f"no reader for '.{kind}'")
    content = path.read_bytes()
    if kind == "obj":
        content = re.sub(rb"\\\r?\n", b" ", content)
        content = b"\n".join(b" ".join(line.partition(b"#")[0].split()) for line in content.splitlines())
    if kind in _UNSUPPORTED and (wrong := _UNSUPPORTED[kind].search(content)):
        raise ValueError(f"{quote(wrong[0].decode(errors='replace'))} is not supported")
    if kind == "dae":
        content = _bare_collada(content)
    options: dict[str, Any] = {"dae": {"ignore_broken": False}}.get(kind, {"skip_materials": True})
    trimesh.util.log.setLevel(logging.ERROR)  # it warns with tracebacks
    with PROCESS, np.errstate(all="ignore"), warnings.catch_warnings():  # filters belong to the process
        warnings.filterwarnings("error", "string or file could not be read")  # NumPy's, of text that is not a number
        loaded: dict[str, Any] = mesh_loaders[kind](io.BytesIO(content), file_type=kind, resolver=None, **options)
        for part in loaded.get("geometry", {"": loaded}).values():
            part["process"] = False  # else it joins vertices and drops those that are not finite
        mesh = trimesh.load_scene(loaded).to_mesh()
    if kind == "ply":
        _require_complete_ply(loaded["metadata"]["_ply_raw"])
    if kind == "stl" and "face_attributes" not in loaded and len(_FACET.findall(content)) != len(mesh.faces):
        raise ValueError(f"{len(mesh.faces)} of {len(_FACET.findall(content))} facets are whole")
    return np.array(mesh.vertices, dtype=float), np.array(mesh.faces, dtype=np.int64)


def _bare_collada(content: bytes) -> bytes:
    """Return the file without materials, cameras, lights and animations, whose files are often missing."""
    root = ET.fromstring(content)
    for element in root.iter():
        for child in [child for child in element if child.tag.rpartition("}")[2] in _UNNEEDED]:
            element.remove(child)
    return ET.tostring(root)


def _require_complete_ply(elements: dict[str, Any]) -> None:
    """Raise ValueError for a PLY file with missing rows, or with binary lists that trimesh misreads."""
    for name, element in elements.items():
        data = element.get("data", {})
        for column in (data[key] for key in (data if isinstance(data, dict) else data.dtype.names)):
            if len(column) != element["length"]:
                raise ValueError(f"{len(column)} of {element['length']} rows of '{name}'")
            if column.dtype.names and np.ptp(column["f0"].astype(int)):
                raise ValueError(f"lists of '{name}' of different lengths are not supported in binary files")


def collada_notes(files: Iterable[Path]) -> Iterator[Note]:
    """Yield notes on COLLADA ``files`` whose unit or up axis is ignored."""
    read = {path: path.read_bytes() for path in files if path.suffix.lower() == ".dae" and os.path.isfile(path)}
    for path, content in read.items():
        unit = _UNIT.search(content)
        if unit and (metres := unit[1].decode(errors="replace").strip()).rstrip("0").rstrip(".") != "1":
            text = f"mesh file {path} says that its unit is {quote(metres)} m, which is not followed: its numbers are "
            yield Note(f"{text}metres, unless its 'scale' makes them so; give it that, or export the file in metres.")
    if turned := [path.name for path, content in read.items() if _AXIS.search(content)]:
        text = f"an up_axis other than Z_UP is not followed, as in MoveIt: of {choices(turned)} z stays z."
        yield Note(text, grave=False)


def simplify(mesh: Mesh) -> Mesh:
    """Return the mesh merged on a grid, with a radius; or itself if it has few triangles or gains little."""
    if len(mesh.triangles) <= MANY or mesh.radius or float(np.ptp(mesh.vertices.T.copy(), axis=1).max()) > _WIDEST:
        return mesh
    simple = _merge_on_grid(mesh, None)
    if not is_closed(simple.triangles):
        simple = _merge_on_grid(mesh, component_of_vertices(mesh))  # a closed component must not merge with an open one
    return simple if len(simple.triangles) <= _WORTH * len(mesh.triangles) else mesh


def _merge_on_grid(mesh: Mesh, apart: Ints | None) -> Mesh:
    """Return the mesh with one vertex per cell; vertices with different ``apart`` (n,) stay separate."""
    middle, which, radius = _cells(mesh, apart, CELL)
    used, triangles = np.unique(_drop_degenerate(which[mesh.triangles]), return_inverse=True)
    return Mesh(middle[used], triangles.reshape(-1, 3), radius)


def _cells(mesh: Mesh, apart: Ints | None, cell: float) -> tuple[Floats, Ints, float]:
    """Return cell centres (k, 3), the cell (n,) of each vertex, and the largest distance to a centre."""
    axes = np.ascontiguousarray(mesh.vertices.T)  # a tenth of the time along rows
    cells = ((axes - axes.min(axis=1, keepdims=True)) * (1 / cell)).astype(np.int64)
    _, wide, high = cells.max(axis=1) + 1
    order, which = _rank((cells[0] * wide + cells[1]) * high + cells[2])
    if apart is not None:
        order, which = _rank(which * (len(apart) + 1) + apart)
    axes, ranks = axes[:, order], which[order]
    first = np.flatnonzero(np.diff(ranks, prepend=-1))
    middle = 0.5 * (np.minimum.reduceat(axes, first, axis=1) + np.maximum.reduceat(axes, first, axis=1))
    moved = axes - middle[:, ranks]
    return middle.T, which, float(np.sqrt((moved * moved).sum(axis=0).max())) + _ROUNDING


def _rank(keys: Ints) -> tuple[Ints, Ints]:
    """Return the order (n,) that sorts ``keys`` (n,), and the rank (n,) of each among distinct keys."""
    order = np.argsort(keys, kind="stable")
    ranks = np.empty(len(keys), dtype=np.int64)
    ranks[order] = np.cumsum(np.diff(keys[order], prepend=keys[order[0]]) > 0)
    return order, ranks


def _drop_degenerate(triangles: Ints) -> Ints:
    """Return triangles (m, 3) of nonzero area, and otherwise uncovered edges and points of the others."""
    a, b, c = triangles.T
    has_area = (a != b) & (b != c) & (c != a)
    whole, flat = triangles[has_area], triangles[~has_area]
    count = int(triangles.max()) + 1
    sides = np.unique(flat.min(axis=1) * count + flat.max(axis=1))
    ends = np.concatenate([whole[:, [0, 1]], whole[:, [1, 2]], whole[:, [2, 0]]])
    sides = np.setdiff1d(sides, ends.min(axis=1) * count + ends.max(axis=1))
    low, high = np.divmod(sides, count)
    lines = np.column_stack([low, high, high])[low != high]
    points = np.setdiff1d(low[low == high], np.concatenate([whole.ravel(), lines.ravel()]))
    return np.concatenate([whole, lines, np.repeat(points[:, None], 3, axis=1)])
