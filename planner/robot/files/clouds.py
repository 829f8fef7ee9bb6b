"""Files of points, voxels and depth images.

Formats: NPY, NPZ, PLY, XYZ, PCD, PointCloud2 in MCAP, octomaps, 16-bit PNG.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import pydantic
from PIL import Image

from planner.base.arrays import Floats
from planner.base.errors import FileError, InstallationError, SceneError, choices, require_extra
from planner.base.files import StrPath
from planner.base.yamlfile import FARTHEST, Coordinate, Name, Number, Size
from planner.robot.clouds import Points, Voxels, require_few_cells, split_regions
from planner.robot.depth_image import DepthImage, Unknown
from planner.robot.files.meshes import read_vertices
from planner.robot.shapes import Obstacle

OCTOMAP = "<octomap>"  # its name in MoveIt's matrices
_POINTS = (".npy", ".npz", ".ply", ".xyz", ".pcd", ".mcap")
_VOXELS = (".npz", ".bt", ".ot")


_Length = Annotated[Number, pydantic.Field(ge=0, le=FARTHEST)]
_Scale = Annotated[Number, pydantic.Field(ge=1e-9, le=1e9)]


@dataclass(frozen=True, kw_only=True)
class SensorFile:
    """The keys of what a sensor saw: its frame, and the state of the robot then."""

    frame: str = Obstacle.frame
    seen_at: str = Obstacle.seen_at
    self_filter: _Length = Obstacle.self_filter


@dataclass(frozen=True)
class VoxelsFile(SensorFile):
    """The keys of voxels in a scene file."""

    file: str
    scale: _Scale = 1.0


@dataclass(frozen=True)
class PointsFile(SensorFile):
    """The keys of points in a scene file."""

    file: str
    scale: _Scale = 1.0
    radius: Size | None = None
    noise: _Length = 0.0
    calibration: _Length = 0.0
    regions: dict[Name, tuple[Coordinate, Coordinate, Coordinate, Coordinate, Coordinate, Coordinate]] | None = None


@dataclass(frozen=True)
class DepthFile(SensorFile):
    """The keys of a depth image in a scene file."""

    file: str
    intrinsics: tuple[Size, Size, Coordinate, Coordinate]
    scale: _Scale = 1e-3
    limits: tuple[Size, Size] = DepthImage.limits
    noise: _Length = DepthImage.noise
    calibration: _Length = DepthImage.calibration
    unknown: Unknown = DepthImage.unknown
    pitch: Size = DepthImage.pitch
    thinning: Size = DepthImage.thinning


SEEN = {"points": PointsFile, "voxels": VoxelsFile, "depth": DepthFile}


def read_cells(item: Any, folder: Path) -> Points | Voxels:
    """Return the points or voxels of an item, whose keys ``SEEN`` lists; its file is in ``folder``."""
    if item.type == "voxels":
        return read_voxels(folder / item.file, item.scale)
    return Points(read_points(folder / item.file, item.scale), item.radius, item.noise, item.calibration)


def read_seen(item: Any, folder: Path, pose: Floats) -> Sequence[Obstacle]:
    """Return the obstacles of an item at a ``pose`` (4, 4); a depth image has unknown space too."""
    if item.type == "depth":
        given = {field.name for field in fields(DepthFile)} & {field.name for field in fields(DepthImage)}
        settings = {name: getattr(item, name) for name in given - {"intrinsics"}}
        image = DepthImage(read_depth(folder / item.file, item.scale), item.intrinsics, pose, **settings)
        return image.obstacles(item.name)
    shape = read_cells(item, folder)
    if isinstance(shape, Points) and item.regions:
        return split_regions(item.name, shape, pose, item.regions)
    return [Obstacle(item.name, shape, pose)]


def read_points(path: StrPath, scale: float = 1.0) -> Floats:
    """Return the points (n, 3) of a file after ``scale``; NaN for missing measurements.

    An NPZ file has ``xyz``; of an MCAP file the first PointCloud2 is used. PCD and MCAP need an extra package. Raises
    :class:`FileError` for a file that cannot be read.
    """
    return _read(Path(path), _POINTS, "cloud", lambda file: _points(file) * scale)


def read_voxels(path: StrPath, scale: float = 1.0) -> Voxels:
    """Return the solid cells of a file: an NPZ with ``occupied``, ``pitch`` and ``origin``, or an octomap.

    Unknown cells of an octomap are free. Raises :class:`FileError` for a file that cannot be read.
    """
    return _read(Path(path), _VOXELS, "voxel", lambda file: _voxels(file, scale))


def read_depth(path: StrPath, scale: float = 1e-3) -> Floats:
    """Return the depths (h, w) m of a 16-bit PNG or an NPY file after ``scale`` (default: from mm)."""

    def depths(file: Path) -> Floats:
        if file.suffix.lower() == ".npy":
            return np.load(file, allow_pickle=False) * scale
        with Image.open(file) as image:
            if image.mode not in ("I;16", "I;16B", "I"):
                raise ValueError(f"its pixels are '{image.mode}', not 16-bit grey")
            return np.asarray(image, dtype=float) * scale

    return _read(Path(path), (".png", ".npy"), "depth", depths)


def _read(path: Path, endings: tuple[str, ...], kind: str, reader: Any) -> Any:
    if not os.path.isfile(path):
        raise FileError(f"{kind} file {path} not found: check 'file', which is relative to the scene file.")
    if path.suffix.lower() not in endings:
        raise FileError(f"{kind} file {path} must end in {', '.join(endings)}, got '{path.suffix}'.")
    try:
        return reader(path)
    except InstallationError:
        raise
    except Exception as error:  # libraries raise errors of every kind for damaged files
        reason = " ".join(str(error).split())[:160].rstrip(".") or type(error).__name__
        raise FileError(f"{kind} file {path} cannot be read ({reason}): export it again.") from None


def _points(path: Path) -> Floats:
    match path.suffix.lower():
        case ".npy":
            points = np.load(path, allow_pickle=False)
        case ".npz":
            with np.load(path, allow_pickle=False) as arrays:
                points = arrays["xyz"]
        case ".pcd":
            points = require_extra("pypcd4", "clouds").PointCloud.from_path(path).numpy(("x", "y", "z"))
        case ".mcap":
            points = _from_bag(path)
        case _:
            points = read_vertices(path)
    return np.asarray(points, dtype=float)


def _from_bag(path: Path) -> Floats:
    """Return the points of the first PointCloud2."""
    factory = require_extra("mcap_ros2.decoder", "mcap").DecoderFactory()
    with path.open("rb") as file:
        for schema, channel, message in require_extra("mcap.reader", "mcap").make_reader(file).iter_messages():
            if schema.name.split("/")[-1] == "PointCloud2":
                return read_message(factory.decoder_for(channel.message_encoding, schema)(message.data))
    raise ValueError("it holds no PointCloud2")


def read_message(cloud: Any) -> Floats:
    """Return the points (n, 3) of a decoded PointCloud2; NaN for missing measurements.

    Raises :class:`SceneError` unless its fields x, y and z are float32 or float64 and its data are whole.
    """
    kinds, order = {7: "f4", 8: "f8"}, ">" if cloud.is_bigendian else "<"
    used = [field for field in cloud.fields if field.name in "xyz" and field.datatype in kinds]
    fields = {field.name: (order + kinds[field.datatype], field.offset) for field in used}
    if len(fields) < 3:
        found = choices(f"{field.name} ({field.datatype})" for field in cloud.fields)
        raise SceneError(f"fields of a PointCloud2 must be x, y, z of kind 7 or 8, got {found}: publish these.")
    try:
        formats, offsets = zip(*(fields[name] for name in "xyz"), strict=True)
        layout = np.dtype({"names": list("xyz"), "formats": formats, "offsets": offsets, "itemsize": cloud.point_step})
        rows = np.frombuffer(bytes(cloud.data), dtype=np.uint8).reshape(cloud.height, cloud.row_step)
        points = np.ascontiguousarray(rows[:, : cloud.width * cloud.point_step]).view(layout)
    except ValueError:
        size = f"{cloud.height} rows of {cloud.row_step} bytes with {cloud.width} points of {cloud.point_step}"
        raise SceneError(f"data of a PointCloud2 must be {size}, got {len(cloud.data)} bytes: send it again.") from None
    return np.stack([points[name].ravel().astype(float) for name in "xyz"], axis=1)


def _voxels(path: Path, scale: float) -> Voxels:
    if path.suffix.lower() == ".npz":
        with np.load(path, allow_pickle=False) as arrays:
            return Voxels(arrays["occupied"], float(arrays["pitch"]) * scale, arrays["origin"] * scale)
    voxels = _voxels_of_tree(path, path.suffix.lower() == ".bt", scale)
    if voxels is None:
        raise ValueError("no cell is solid")
    return voxels


def _voxels_of_tree(path: Path, binary: bool, scale: float = 1.0) -> Voxels | None:
    """Return the solid cells of an octomap file, None where all are free."""
    tree = require_extra("pyoctomap", "clouds").OcTree(1.0)
    if not binary:
        tree = tree.read(str(path))
    elif not tree.readBinary(str(path)):
        raise ValueError("its tree is not whole")
    leaves = [(leaf.getCoordinate(), leaf.getSize()) for leaf in tree.begin_leafs() if tree.isNodeOccupied(leaf)]
    if not leaves:
        return None
    return voxels_of_leaves(leaves, tree.getResolution(), scale)


def decode_octomap(content: bytes, pitch: float, binary: bool, kind: str) -> Voxels | None:
    """Return the solid cells of an octomap_msgs/Octomap, None where all are free.

    Raises ValueError for bytes that are not a whole tree of ``kind`` OcTree.
    """
    if kind != "OcTree" or not pitch > 0:
        raise ValueError(f"id must be OcTree and resolution above 0, got '{kind}' and {pitch:g}")
    children = [byte >> shift & 3 for byte in content for shift in (0, 2, 4, 6)]  # 0 unknown, 3 with children
    if binary:
        nodes, length = 1 + sum(map(bool, children)), 2 + 2 * children.count(3)
    else:  # a float and a bit per child
        nodes = 1 + sum(byte.bit_count() for byte in content[4::5])
        length = 5 * nodes
    if len(content) != length:
        raise ValueError("its tree is not whole")
    head = f"# Octomap OcTree {'binary ' * binary}file\nid OcTree\nsize {nodes}\nres {pitch!r}\ndata\n"
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tree"
        path.write_bytes(head.encode() + content)
        return _voxels_of_tree(path, binary)


def voxels_of_leaves(leaves: list[tuple[Any, float]], pitch: float, scale: float = 1.0) -> Voxels:
    """Return the solid leaves of an octree, given by centres (3,) and sizes, as voxels."""
    middles, sizes = np.array([middle for middle, _ in leaves]), np.array([size for _, size in leaves])
    low = np.rint((middles - 0.5 * sizes[:, None]) / pitch).astype(int)
    count = np.maximum(1, np.rint(sizes / pitch)).astype(int)
    first = low.min(axis=0)
    size = (low + count[:, None]).max(axis=0) - first
    require_few_cells("its grid", size)
    occupied = np.zeros(size, dtype=bool)
    for (x, y, z), n in zip(low - first, count, strict=True):
        occupied[x : x + n, y : y + n, z : z + n] = True
    return Voxels(occupied, pitch * scale, first * pitch * scale)
