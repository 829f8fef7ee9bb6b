"""The door through which geometry read by coal enters: mesh files and URDF geometry as backend-neutral shapes."""

from __future__ import annotations

import os
import re
from operator import itemgetter
from pathlib import Path

import coal
import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.cache import cached
from planner.base.errors import FileError
from planner.base.files import StrPath
from planner.base.silenced import Silenced
from planner.base.yamlfile import FARTHEST, shown
from planner.models.files.dae import dae_fault
from planner.models.files.ply import ply_fault
from planner.models.files.thinned import CELL, MANY, thinned
from planner.models.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

_STL_HEADER, _STL_RECORD = 84, 50  # bytes before the triangles, and of each: normal, three corners, two bytes
_NUMBER = rb"[ \t]++[-+]?+\d++(?:\.\d*+)?+(?:[eE][-+]?\d++)?+"  # possessive: the time grows with the length alone
_ONE = rb"[ \t]++[+]?+1(?:\.0*+)?+(?![\d.eE])"  # a weight: by any other Assimp divides
_VERTEX = rb"v(?:" + _NUMBER + rb"){3}+(?:" + 3 * _NUMBER + rb"|" + _ONE + rb")?+[ \t]*+(?:#.*+)?+\r?$"
_CORNER = rb"[ \t]++[^\s#]++"
_SKIPPED = (  # lines that hold a part of the surface
    rb"^(?:(?!" + _VERTEX + rb")v[ \t].*+"
    rb"|(?!f(?:" + _CORNER + rb"){3})f(?:[ \t].*+)?$"
    rb"|[ \t]++[vf][ \t].*+|[VF][ \t].*+|(?:call|cstype|curv|curv2|surf|csh|bzp|bsp|cdp|cdc|res)[ \t].*+)"
)
_STL_NUMBER = _NUMBER.replace(rb"\d++(?:\.\d*+)?+", rb"(?:\d++(?:\.\d*+)?+|\.\d++)")
_STL_CORNER = rb"^(?![ \t]*+vertex(?:" + _STL_NUMBER + rb"){3}[ \t]*+\r?$)[ \t]*+vertex\b.*+"
_LARGEST = 512 << 20  # bytes of a mesh file
_MOST = 2_000_000  # triangles: collision checks of more take minutes to set up


def read_mesh(path: StrPath, scale: float | Floats = 1.0) -> Mesh:
    """The triangles of an STL, OBJ, DAE or PLY file, in metres after ``scale``; :class:`FileError` otherwise."""
    path = Path(path)
    if not os.path.isfile(path):
        raise FileError(f"mesh file {path} not found: check 'file', which is relative to the scene file.")
    require_readable_mesh(path)
    try:
        with Silenced():
            # boxes along the axes: fitting oriented ones, as is the default, prints for NaN and never ends for 1e300
            loaded = coal.MeshLoader(coal.NODE_TYPE.BV_AABB).load(str(path), np.full(3, scale, dtype=float))
    except (ValueError, RuntimeError) as error:
        raise FileError(
            f"mesh file {path} cannot be read ({reason(error)}): give an STL, OBJ, DAE or PLY file."
        ) from None
    try:
        mesh = shape_of(loaded)
    except MeshFault as error:
        raise FileError(f"mesh file {path} {error}: check 'scale', or export it again.") from None
    if not isinstance(mesh, Mesh):
        raise FileError(f"mesh file {path} holds no usable triangles: export it again.")
    return mesh


def link_mesh(path: Path, scale: Floats) -> Mesh:
    """The mesh file of a link, :func:`~planner.models.files.thinned.thinned`, in metres after ``scale`` (3,).

    It is made once: then it comes from the cache. :class:`FileError` as :func:`read_mesh`.
    """
    content = path.read_bytes()
    made_of = [path.suffix.lower(), scale, np.frombuffer(content, dtype=np.uint8), CELL, MANY]
    arrays = cached(
        "meshes", made_of, lambda: {k: np.asarray(v) for k, v in vars(_thin_mesh(path, content, scale)).items()}
    )
    return Mesh(arrays["vertices"], arrays["triangles"], float(arrays["radius"]))


def _thin_mesh(path: Path, content: bytes, scale: Floats) -> Mesh:
    corners = binary_stl(content) if path.suffix.lower() == ".stl" else None
    if corners is not None and len(corners) > MANY:
        vertices, triangles = (corners * scale).reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
        wrong = fault(vertices, triangles)
        if wrong:
            raise FileError(f"mesh file {path} {wrong}: check 'scale', or export it again.")
        found = thinned(Mesh(vertices, triangles))
        return found if found.radius else read_mesh(path, scale)  # with the vertices as the library joins them
    return thinned(read_mesh(path, scale))


def binary_stl(content: bytes) -> Floats | None:
    """The corners (m, 3, 3) of the triangles of a binary STL file, in the file's own unit; None for any other file.

    A large one is read in a hundredth of the time that Assimp takes.
    """
    if len(content) < _STL_HEADER:
        return None
    count = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    if not count or len(content) != _STL_HEADER + _STL_RECORD * count:
        return None
    records = np.frombuffer(content, dtype=np.uint8, offset=_STL_HEADER).reshape(count, _STL_RECORD)
    return np.ascontiguousarray(records[:, 12:48]).view("<f4").reshape(count, 3, 3).astype(np.float64)


def mesh_loader() -> coal.MeshLoader:
    """What reads the meshes of one URDF, each once."""
    return coal.CachedMeshLoader(coal.NODE_TYPE.BV_OBBRSS)  # Pinocchio knows no other kind by its name


def require_readable_mesh(path: Path) -> None:
    """Raise :class:`FileError` for a mesh file that its reader would not survive."""
    if path.stat().st_size > _LARGEST:
        raise FileError(f"mesh file {path} is larger than {_LARGEST >> 20} MiB: simplify the mesh.")
    looked_through = _LOOKED_THROUGH.get(path.suffix.lower())
    wrong = looked_through(path.read_bytes()) if looked_through else None
    if wrong:
        raise FileError(f"mesh file {path} {wrong}: export it again.")


def obj_fault(content: bytes) -> str | None:
    """The first vertex or face of an OBJ file that Assimp skips, or cuts off; None where there is none.

    It takes three numbers that begin with a digit, or six, with a colour, in lines that are not indented, and a comma
    for an end. Vertices behind one that is skipped would get the numbers of others. By a fourth number, a weight, it
    divides, which of polygons nobody means. Faces have three corners; free forms, and other files, are not read.
    """
    wrong = re.search(_SKIPPED, content, re.MULTILINE)  # compiled where it is asked for
    return None if wrong is None else f"has a line {shown(wrong[0].strip().decode(errors='replace'))} that is skipped"


def stl_fault(content: bytes) -> str | None:
    """The first corner in the text of an STL file that is not three numbers, of which Assimp takes what it can."""
    wrong = re.search(_STL_CORNER, content, re.MULTILINE) if binary_stl(content) is None else None
    return None if wrong is None else f"has a line {shown(wrong[0].strip().decode(errors='replace'))} of no 3 numbers"


_LOOKED_THROUGH = {".ply": ply_fault, ".dae": dae_fault, ".obj": obj_fault, ".stl": stl_fault}


class MeshFault(ValueError):
    """What makes a mesh unusable, as the words after its name."""


def fault(vertices: Floats, triangles: Ints) -> str | None:
    """What makes a mesh unusable, as the words after its name; None where nothing does."""
    if not len(triangles) or not np.isfinite(vertices).all():
        return "holds no usable triangles"
    if len(triangles) > _MOST:
        return f"has {len(triangles)} triangles, more than {_MOST}"
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        return "has triangles of vertices that are not there"
    largest = float(np.abs(vertices).max())
    if largest > FARTHEST:
        return f"reaches {largest:g} m far"
    if float(np.ptp(vertices.T.copy(), axis=1).max()) < 1e-6:
        return "is smaller than a micrometre"
    return None


def reason(error: Exception) -> str:
    """The line of coal's report on a mesh file that says what is wrong, without the places in its source."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    after = [k for k, line in enumerate(lines) if "Could not load resource" in line]
    found = lines[after[0] + 1 :] if after else lines
    return (found[0].rstrip(".") if found else "no reason is known")[:200]


def shape_of(geometry: coal.CollisionGeometry) -> Shape:
    """A coal geometry as one of our shapes; ValueError names a kind that we do not have, MeshFault what is wrong."""
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
        case coal.BVHModelBase():
            rows = map(itemgetter(0, 1, 2), map(geometry.tri_indices, range(geometry.num_tris)))  # no iterables
            triangles = np.array(list(rows), dtype=np.int64).reshape(-1, 3)
            vertices = np.array(geometry.vertices(), dtype=float).reshape(-1, 3)
            wrong = fault(vertices, triangles)
            if wrong:
                raise MeshFault(wrong)
            return Mesh(vertices, triangles)
    raise ValueError(f"geometry of type {type(geometry).__name__} is not supported")
