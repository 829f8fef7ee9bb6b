"""Depth images: the surface that a camera saw, and the space that it did not see."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen, numbers, placement, plain_numbers
from planner.base.errors import SceneError
from planner.base.yamlfile import FARTHEST
from planner.native.compiled import group_rows
from planner.robot.clouds import QUANTILE, Points, Voxels, require_few_cells
from planner.robot.shapes import Obstacle

_FAR_PIXEL = 1e6  # beyond any image
_STEP = 0.05  # of the depth: pixels that differ by more are of two surfaces
Unknown = Literal["free", "solid", "solid everywhere"]


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
        if not there.any():
            return None
        points = self.positions(self.depth)[there]
        first, _, spread = group_rows(points, self.thinning)
        step = 0.1 * self.thinning  # images that differ a little have one radius
        radius = step * np.ceil((self._estimate_gap() + spread) / step)
        return Points(points[:1], radius, self.noise, self.calibration, True).with_samples(points[first])

    def _estimate_gap(self) -> float:
        """Return half the diagonal (m) of four neighbouring pixels of one surface, at the 99 % quantile."""
        step = max(1, min(self.depth.shape) // 160)  # a few thousand of them are enough
        rows, columns = (np.arange(0, count - 1, step) for count in self.depth.shape)
        at = [np.ix_(rows + i, columns + k) for i in (0, 1) for k in (0, 1)]
        depths = np.stack([self.depth[each] for each in at])
        low, high = depths.min(axis=0), depths.max(axis=0)
        with np.errstate(invalid="ignore"):
            whole = (low > 0) & (high < np.inf) & (high - low < _STEP * high)
        if not whole.any():
            return self.thinning
        depths = np.where(whole, depths, 0.0)  # an infinite one would make no number
        fx, fy, cx, cy = self.intrinsics
        corners = [
            np.stack([(k[whole] - cx) / fx * z[whole], (i[whole] - cy) / fy * z[whole], z[whole]], axis=-1)
            for (i, k), z in ((np.broadcast_arrays(*each), depth) for each, depth in zip(at, depths, strict=True))
        ]
        sides = [np.linalg.norm(corners[a] - corners[b], axis=1) for a, b in ((0, 3), (1, 2))]
        return 0.5 * float(np.quantile(np.maximum(*sides), QUANTILE))

    def positions(self, depth: Floats) -> Floats:
        """Return where pixels of ``depth`` (h, w) m are in the camera's frame (h, w, 3), m."""
        fx, fy, cx, cy = self.intrinsics
        height, width = depth.shape
        made = np.empty((height, width, 3))
        with np.errstate(invalid="ignore"):  # infinite depths
            made[..., 0] = (np.arange(width) - cx) / fx * depth
            made[..., 1] = ((np.arange(height) - cy) / fy)[:, None] * depth
        made[..., 2] = depth
        return made

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
        require_few_cells("DepthImage.pitch", last - first)
        x, y, z = (self.pitch * np.arange(a, b + 1) for a, b in zip(first, last, strict=True))  # of the cells' faces
        solid = np.zeros(last - first, dtype=bool)
        if everywhere:
            nearest = [np.maximum(0.0, np.maximum(axis[:-1], -axis[1:])) ** 2 for axis in (x, y, z)]
            solid |= nearest[0][:, None, None] + nearest[1][:, None] + nearest[2] <= far * far
        images = _halves(self.depth)
        for k in np.flatnonzero(z[:-1] >= 0):
            columns, rows = _footprints(x, z[k : k + 2], fx, cx), _footprints(y, z[k : k + 2], fy, cy)
            across, down = _meet(columns, width), _meet(rows, height)
            seen = _least_depths(images, columns[:, across], rows[:, down]) >= z[k + 1]
            if everywhere:
                seen &= _lie_in(columns[:, across], width)[:, None] & _lie_in(rows[:, down], height)
            solid[np.ix_(across, down, [k])] = ~seen[..., None]
        return Voxels(solid, self.pitch, self.pitch * first) if solid.any() else None


def _footprints(faces: Floats, z: Floats, focal: float, middle: float) -> Ints:
    """Return first and last pixels (2, n) over cells between ``faces`` (n + 1,), from z[0] to z[1]."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.nan_to_num(focal * (faces / z[:, None]) + middle, nan=middle, posinf=_FAR_PIXEL, neginf=-_FAR_PIXEL)
    ends = np.clip(ends, -_FAR_PIXEL, _FAR_PIXEL)
    return np.stack([np.floor(ends[:, :-1].min(axis=0)), np.ceil(ends[:, 1:].max(axis=0))]).astype(np.int64)


def _meet(pixels: Ints, count: int) -> Ints:
    """Return which first and last pixels (2, n) hold one of an image with ``count`` of them."""
    return np.flatnonzero((pixels[1] >= 0) & (pixels[0] < count))


def _lie_in(pixels: Ints, count: int) -> Bools:
    return (pixels[0] >= 0) & (pixels[1] < count)


def _halves(image: Floats) -> list[Floats]:
    """Return an image and halves of it, of the least depths; a row and a column of inf follow."""
    made = [image]
    while min(made[-1].shape) > 8:
        even = np.pad(made[-1], [(0, count % 2) for count in made[-1].shape], constant_values=np.inf)
        rows = np.minimum(even[::2], even[1::2])
        made.append(np.minimum(rows[:, ::2], rows[:, 1::2]))
    return [np.pad(each, [(0, 1), (0, 1)], constant_values=np.inf) for each in made]


def _least_depths(images: list[Floats], columns: Ints, rows: Ints) -> Floats:
    """Return the least depths (m, n) between first and last ``columns`` (2, m) and ``rows`` (2, n).

    Of an image and its halves that one is used in which the rectangles are at least four pixels wide: its pixels cover
    a rectangle and at most a quarter more at each end.
    """
    narrowest = min(int((last - first).min(initial=int(_FAR_PIXEL))) for first, last in (columns, rows))
    level = min(len(images) - 1, max(0, narrowest // 8).bit_length())
    image = images[level]
    for pixels in (rows, columns):
        low, high = np.clip(pixels >> level, 0, image.shape[0] - 2)
        least = np.minimum.reduceat(image, np.stack([low, high + 1], axis=1).ravel(), axis=0)[::2]
        image = np.ascontiguousarray(least.T)
    return image.T
