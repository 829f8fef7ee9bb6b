"""Worlds from sensors: points with a radius, voxels, depth images.

    cloud = planner.Points(xyz, radius=0.01, noise=0.002)               # xyz (n, 3) m
    scene = planner.Scene("seen", [planner.Obstacle("table", cloud, np.eye(4))])

If every point of the true surface lies within the radius of a sample, then a motion that is free of the balls of that
radius is free of the surface.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from planner.base.arrays import Bools, Floats, Ints, column_bounds, frozen, numbers, placement, plain_numbers
from planner.base.errors import Note, SceneError
from planner.base.yamlfile import FARTHEST
from planner.native.compiled import group_rows
from planner.problem.outcome import Record
from planner.robot.shapes import CORNERS, Mesh, Obstacle

_NEIGHBOURS, _QUANTILE = 8, 0.99  # of a grid of points the 8th neighbour is twice the covering radius away
_LARGE = 50.0  # m: a cloud of more is likely in millimetres
_BLOCK = 0.25  # m: of a cloud that changes, what is proven again together
_STEP = 0.05  # of the depth: pixels that differ by more are of two surfaces
Unknown = Literal["free", "solid", "solid everywhere"]
Region = tuple[float, float, float, float, float, float]


class Seen(Mesh):
    """A union of convex ``cells`` (m, k, 3), each the hull of k points, rounded by ``radius`` (m).

    The cells are solid, so nothing can be enclosed. Vertices and triangles are for display.
    """

    cells: Floats

    @cached_property
    def representatives(self) -> Floats:
        """A point (k, 3) of every connected component, or of more cells."""
        return frozen(self.cells[:, 0])

    def _set(self, **values: Any) -> None:
        """Set attributes: the numbers are checked, and a million of them take long to check again."""
        for name, value in values.items():
            object.__setattr__(self, name, frozen(value, value.dtype) if isinstance(value, np.ndarray) else value)


class Points(Seen):
    """A surface sampled at ``xyz`` (n, 3), m: all points within a radius of a sample are solid.

    The radius is a sum: ``radius`` (m) is the covering radius, the largest distance of a surface point from its nearest
    sample (default: :func:`estimate_covering_radius`, marked by ``is_estimated``); ``noise`` bounds the error of a
    sample, ``calibration`` that of the sensor's pose. A larger radius closes narrow passages; with one that is too
    small, proofs hold for the balls only.

    Samples that are not finite are counted in ``dropped`` and those that equal another in ``merged``; both are left
    out. Raises :class:`SceneError` without samples and for a radius of 0.
    """

    covering: float
    noise: float
    calibration: float
    is_estimated: bool
    dropped: int
    merged: int

    def __init__(
        self,
        xyz: Any,
        radius: float | None = None,
        noise: float = 0.0,
        calibration: float = 0.0,
        is_estimated: bool = False,
    ) -> None:
        given = plain_numbers("Points.xyz", xyz, SceneError)
        finite = given if np.isfinite(given).all() or given.ndim != 2 else given[np.isfinite(given).all(axis=1)]
        points = numbers("Points.xyz", finite, ("n", 3), SceneError, FARTHEST)
        if not len(points):
            raise SceneError("Points.xyz must hold a finite point, got none.")
        first = group_rows(np.ascontiguousarray(points), 0.0)[0]
        count, points = len(points), points if len(first) == len(points) else points[first]
        terms = {
            "radius": estimate_covering_radius(points) if radius is None else radius,
            "noise": noise,
            "calibration": calibration,
        }
        for name, term in terms.items():
            if not numbers(f"Points.{name}", term, (), SceneError, FARTHEST) >= 0:
                raise SceneError(f"Points.{name} must be at least 0 m, got {term:g}.")
        total = float(sum(terms.values()))
        if not total > 0:
            raise SceneError("Points.radius must be above 0 m, got 0: give the covering radius of the samples.")
        self._set(vertices=points, radius=total, covering=float(terms["radius"]), noise=float(noise))
        self._set(calibration=float(calibration), is_estimated=is_estimated or radius is None)
        self._set(dropped=len(given) - count, merged=count - len(points), cells=self.vertices[:, None])

    @cached_property
    def triangles(self) -> Ints:  # type: ignore[override]
        """A degenerate triangle (n, 3) for each sample."""
        return frozen(np.repeat(np.arange(len(self.vertices)), 3).reshape(-1, 3), np.int64)

    @cached_property
    def tree(self) -> KDTree:
        """The samples in a tree for searches."""
        return _tree_of(self.vertices)

    def content(self) -> list[Any]:
        return [type(self).__name__, self.vertices, self.radius]

    def part(self, chosen: Bools) -> Points:
        """Return the samples in the mask ``chosen`` (n,), with the same radius."""
        return Points(self.vertices[chosen], self.covering, self.noise, self.calibration, self.is_estimated)

    def __repr__(self) -> str:
        return f"<Points: {len(self.vertices)} within {1e3 * self.radius:.3g} mm of a surface>"

    @cached_property
    def representatives(self) -> Floats:
        """A point (k, 3) of every connected component of the balls.

        Points in one grid cell, whose diagonal is the balls' diameter, are connected.
        """
        first = group_rows(self.vertices, 2.0 * self.radius / np.sqrt(3.0))[0]
        near = _tree_of(self.vertices[first]).query_pairs(2.0 * self.radius, output_type="ndarray")
        graph = coo_array((np.ones(len(near)), near.T), shape=(len(first), len(first)))
        component = connected_components(graph, directed=False)[1]
        return frozen(self.vertices[first[np.unique(component, return_index=True)[1]]])


class Voxels(Seen):
    """Solid cells of a grid: ``occupied`` (nx, ny, nz), cubes of ``pitch`` (m) from ``origin`` (3,).

    Neighbouring cubes are merged into cuboids. A cube exceeds its content by up to its diagonal.
    """

    occupied: Bools
    pitch: float
    origin: Floats

    def __init__(self, occupied: Any, pitch: float, origin: Any = (0.0, 0.0, 0.0)) -> None:
        solid = np.asarray(occupied, dtype=bool)
        if solid.ndim != 3 or not solid.any():
            raise SceneError(f"Voxels.occupied must be an array (nx, ny, nz) with a solid cell, got {solid.shape}.")
        if not numbers("Voxels.pitch", pitch, (), SceneError, FARTHEST) > 0:
            raise SceneError(f"Voxels.pitch must be above 0 m, got {pitch:g}.")
        corner = numbers("Voxels.origin", origin, (3,), SceneError, FARTHEST)
        cuboids = merge_cells(solid)
        low, high = corner + pitch * cuboids[:, :3], corner + pitch * cuboids[:, 3:]
        cells = 0.5 * (low + high)[:, None] + CORNERS * (high - low)[:, None]
        triangles = (8 * np.arange(len(cells))[:, None, None] + _FACES).reshape(-1, 3)
        self._set(vertices=cells.reshape(-1, 3), triangles=triangles, radius=0.0, cells=cells)
        self._set(occupied=solid, pitch=float(pitch), origin=corner)

    def __repr__(self) -> str:
        return f"<Voxels: {int(self.occupied.sum())} cubes of {1e3 * self.pitch:.3g} mm>"


# (12, 3) of the corners of a cube, seen from outside; a corner's number has the bits y, x, z
_FACES = np.array([*map(int, "310230764574540150732672620460751371")]).reshape(12, 3)


def merge_cells(occupied: Bools) -> Ints:
    """Return disjoint cuboids (k, 6) of cells, low then high corner, with the same union.

    Runs along z are merged to rectangles along y, and these to cuboids along x, if their ends agree.
    """
    flat = np.pad(occupied, ((0, 0), (0, 0), (1, 1))).astype(np.int8)
    change = np.diff(flat, axis=2)
    x, y, low = np.nonzero(change == 1)
    high = np.nonzero(change == -1)[2]
    rows = np.column_stack([x, y, low, x + 1, y + 1, high])
    for axis in (1, 0) if len(rows) else ():
        others = [k for k in range(6) if k % 3 != axis]
        rows = rows[np.lexsort([rows[:, axis], *(rows[:, k] for k in others)])]
        same = (rows[1:, others] == rows[:-1, others]).all(axis=1) & (rows[1:, axis] == rows[:-1, axis + 3])
        first = np.flatnonzero(np.append(True, ~same))
        last = np.append(first[1:], len(rows)) - 1
        merged = rows[first]
        merged[:, axis + 3] = rows[last, axis + 3]
        rows = merged
    return rows


def split_regions(name: str, cloud: Points, placement: Floats, regions: Mapping[str, Region]) -> list[Obstacle]:
    """Return the cloud as obstacles: one per region (x0, y0, z0, x1, y1, z1) m, and the rest.

    Regions are in the cloud's frame. Contact permissions can then name an object in the cloud.
    """
    rest, made = np.ones(len(cloud.vertices), dtype=bool), []
    for part, bounds in regions.items():
        low, high = np.reshape(bounds, (2, 3))
        inside = rest & ((cloud.vertices >= low) & (cloud.vertices <= high)).all(axis=1)
        if not inside.any():
            raise SceneError(f"'{name}': region '{part}' must hold a point, got none: check its bounds.")
        made.append(Obstacle(part, cloud.part(inside), placement))
        rest &= ~inside
    return [*([Obstacle(name, cloud.part(rest), placement)] if rest.any() else []), *made]


def split_blocks(name: str, cloud: Points, placement: Floats, known: Iterable[Obstacle] = ()) -> list[Obstacle]:
    """Return the cloud as obstacles of object ``name``, one per cube of a grid; reuse ``known`` blocks."""
    same = {(item.name, *_key(item.shape, item.placement)): item for item in known if isinstance(item.shape, Points)}
    cells = np.floor(cloud.vertices / _BLOCK).astype(np.int64)
    first, which = group_rows(cloud.vertices, _BLOCK)
    made = []
    for k, start in enumerate(first):
        block, part = f"{name}[{', '.join(map(str, cells[start].tolist()))}]", cloud.part(which == k)
        item = same.get((block, *_key(part, placement)))
        made.append(item or Obstacle(block, part, placement, object_id=name))
    return made


def _key(cloud: Points, placement: Floats) -> tuple[bytes, bytes, float]:
    return cloud.vertices.tobytes(), placement.tobytes(), cloud.radius


def _tree_of(points: Floats) -> KDTree:
    return KDTree(points, compact_nodes=False, balanced_tree=False)  # a balanced one takes three times as long


def estimate_covering_radius(points: Floats) -> float:
    """Return an estimate (m) of the largest distance of a surface point from the samples (n, 3).

    It is the distance from a sample to its 8th neighbour, at the 99 % quantile: twice the covering radius of a square
    grid, and about 1.3 times that of random samples. It misses holes much larger than the spacing. Raises
    :class:`SceneError` for fewer than nine samples.
    """
    if len(points) <= _NEIGHBOURS:
        raise SceneError(f"Points.radius must be given for {len(points)} points: an estimate needs at least 9.")
    some = points[:: max(1, len(points) // 20_000)]
    distance = _tree_of(points).query(some, k=_NEIGHBOURS + 1)[0][:, -1]
    return float(np.quantile(distance, _QUANTILE))


@dataclass(frozen=True, eq=False)
class DepthImage:
    """A depth image as obstacles: the visible surface, and the unknown space behind it.

        depth = np.full((48, 64), 1.2)                                  # (h, w) m along the optical axis
        image = planner.DepthImage(depth, (60, 60, 32, 24), planner.pose([0, 0, 0.5]))
        scene = planner.Scene("seen", image.obstacles("camera"))

    ``intrinsics`` of a pinhole camera are in pixels, also as a matrix (3, 3); ``pose`` (4, 4) places the camera in the
    world: x right, y down, z forwards. Depths of 0, NaN or below the near one of ``limits`` (m) are holes, and a ray
    through a hole crosses nothing; a ray with a depth beyond the far limit met nothing. ``unknown``: cells of ``pitch``
    (m) that no ray crossed, up to the far limit, are "solid" or "free"; cells outside the view are free, or solid
    within the far limit with "solid everywhere". Space that the robot hides stays unknown. One pixel is used per cube
    of ``thinning`` (m).
    """

    depth: Floats
    intrinsics: Any
    pose: Floats
    limits: tuple[float, float] = (0.1, 2.0)
    noise: float = 0.0
    calibration: float = 0.0
    unknown: Unknown = "solid"
    pitch: float = 0.025
    thinning: float = 0.005

    def __post_init__(self) -> None:
        depth = plain_numbers("DepthImage.depth", self.depth, SceneError)
        if depth.ndim != 2 or min(depth.shape) < 2:
            raise SceneError(f"DepthImage.depth must be an array (h, w), got {depth.shape}.")
        given = np.asarray(self.intrinsics, dtype=float)
        if given.shape == (3, 3):
            given = given[[0, 1, 0, 1], [0, 1, 2, 2]]
        focal = numbers("DepthImage.intrinsics", given, (4,), SceneError)
        near, far = self.limits
        if not (0 < near < far and (focal[:2] > 0).all() and self.pitch > 0 and self.thinning > 0):
            raise SceneError("DepthImage: focal lengths, pitch, thinning and limits must be above 0, near before far.")
        with np.errstate(invalid="ignore"):
            seen = np.where(depth >= near, np.where(depth <= far, depth, np.inf), 0.0)
        object.__setattr__(self, "depth", seen)
        object.__setattr__(self, "intrinsics", tuple(focal.tolist()))
        object.__setattr__(self, "pose", frozen(placement("DepthImage.pose", self.pose, SceneError, FARTHEST)))

    def obstacles(self, name: str = "camera") -> tuple[Obstacle, ...]:
        """Return the surface ``name`` and, if there is any, the unknown space ``name_unknown``."""
        made = [Obstacle(name, surface, self.pose)] if (surface := self.surface()) else []
        if self.unknown != "free" and (hidden := self.unknown_space()):
            made.append(Obstacle(f"{name}_unknown", hidden, self.pose))
        return tuple(made)

    def surface(self) -> Points | None:
        """Return the visible surface in the camera's frame, or None if all pixels are holes.

        Its covering radius is an estimate: half the diagonal of four neighbouring pixels of one surface, at the 99 %
        quantile, plus the largest distance of an unused pixel from its representative.
        """
        there = (self.depth > 0) & np.isfinite(self.depth)
        xyz = self.positions(np.where(there, self.depth, 0.0))
        if not there.any():
            return None
        corners = xyz[:-1, :-1], xyz[:-1, 1:], xyz[1:, :-1], xyz[1:, 1:]
        depths = np.stack([corner[..., 2] for corner in corners])
        whole = (depths.min(axis=0) > 0) & (np.ptp(depths, axis=0) < _STEP * depths.max(axis=0))
        sides = [np.linalg.norm(corners[a] - corners[b], axis=2)[whole] for a, b in ((0, 3), (1, 2))]
        gap = 0.5 * float(np.quantile(np.maximum(*sides), _QUANTILE)) if whole.any() else self.thinning
        points = xyz[there]
        first, which = group_rows(points, self.thinning)
        dropped = float(np.linalg.norm(points - points[first][which], axis=1).max())
        return Points(points[first], gap + dropped, self.noise, self.calibration, is_estimated=True)

    def positions(self, depth: Floats) -> Floats:
        """Return where pixels of ``depth`` (h, w) m are in the camera's frame (h, w, 3), m."""
        fx, fy, cx, cy = self.intrinsics
        row, column = np.indices(depth.shape)
        return np.stack([(column - cx) / fx * depth, (row - cy) / fy * depth, depth], axis=2)

    def unknown_space(self) -> Voxels | None:
        """Return the cells in the camera's frame that no ray crossed, or None without any."""
        fx, fy, cx, cy = self.intrinsics
        height, width = self.depth.shape
        _, far = self.limits
        everywhere = self.unknown == "solid everywhere"
        ends = np.array([[-cx / fx, (width - 1 - cx) / fx], [-cy / fy, (height - 1 - cy) / fy], [0.0, 1.0]])
        low, high = far * np.minimum(ends[:, 0], 0.0), far * np.maximum(ends[:, 1], 0.0)
        if everywhere:
            low, high = np.full(3, -far), np.full(3, far)
        first, last = np.floor(low / self.pitch).astype(int), np.ceil(high / self.pitch).astype(int)
        middle = [self.pitch * (np.arange(a, b) + 0.5) for a, b in zip(first, last, strict=True)]
        x, y, z = np.meshgrid(*middle, indexing="ij")
        ahead = z > 0
        depth = np.where(ahead, z, 1.0)
        column, row = np.rint(fx * x / depth + cx), np.rint(fy * y / depth + cy)
        in_view = ahead & (column >= 0) & (column < width) & (row >= 0) & (row < height)
        at = np.where(in_view, row, 0).astype(int), np.where(in_view, column, 0).astype(int)
        reach = np.where(in_view, self.depth[at], 0.0)
        solid = (reach < z - 0.5 * self.pitch) & in_view
        if everywhere:
            solid |= ~in_view & (x * x + y * y + z * z <= far * far)
        return Voxels(solid, self.pitch, self.pitch * first) if solid.any() else None


@dataclass(frozen=True, kw_only=True)
class CloudRecord(Record):
    """The points of an obstacle and the terms of its radius, m."""

    obstacle: str
    points: int
    radius: float
    """the sum of the three terms"""
    covering: float
    """covering radius of the samples"""
    estimated: bool
    """whether the covering radius is an estimate"""
    noise: float
    calibration: float
    dropped: int
    """samples that were not finite"""

    @property
    def text(self) -> str:
        """The record as a sentence without its full stop."""
        terms = {"covering radius": self.covering, "noise": self.noise, "calibration": self.calibration}
        words = [f"{term} {1e3 * value:.4g} mm" for term, value in terms.items()]
        words[0] += " (estimated)" if self.estimated else ""
        text = f"'{self.obstacle}' is solid within {1e3 * self.radius:.4g} mm of {self.points} points: "
        left_out = f"; {self.dropped} samples were not finite and are left out" if self.dropped else ""
        return text + ", ".join(words) + left_out


def record_clouds(obstacles: Iterable[Obstacle]) -> list[CloudRecord]:
    """Return a record of each cloud among ``obstacles``; the blocks of one object count together."""
    clouds: dict[str, list[Points]] = {}
    for item in obstacles:
        if isinstance(item.shape, Points):
            clouds.setdefault(item.object, []).append(item.shape)
    return [
        CloudRecord(
            obstacle=name,
            points=sum(len(part.vertices) for part in parts),
            radius=parts[0].radius,
            covering=parts[0].covering,
            estimated=parts[0].is_estimated,
            noise=parts[0].noise,
            calibration=parts[0].calibration,
            dropped=sum(part.dropped for part in parts),
        )
        for name, parts in clouds.items()
    ]


def notes_on_clouds(obstacles: Iterable[Obstacle]) -> tuple[Note, ...]:
    """Return a note on each cloud; grave where its radius is an estimate or its size is unlikely."""
    items = list(obstacles)
    large = {
        item.object
        for item in items
        if isinstance(item.shape, Points) and np.subtract(*column_bounds(item.shape.vertices)).min() < -_LARGE
    }
    hint = f". It is larger than {_LARGE:g} m: if its file is in millimetres, give scale: 0.001."
    return tuple(
        Note(each.text + hint) if each.obstacle in large else Note(f"{each.text}.", grave=each.estimated)
        for each in record_clouds(items)
    )
