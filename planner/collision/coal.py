"""Collision checks by coal through Pinocchio's broadphase: batches of states, on threads."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, lru_cache

import coal
import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, Ints
from planner.collision.bounding_volumes import widen_points, widen_triangles
from planner.collision.bounds import ClearanceBound
from planner.collision.broad_phase import (
    LazyBroadPhase,
    Pool,
    extract_geometry,
    has_same_arm,
    has_same_shapes,
    make_request,
)
from planner.collision.checker import CollisionChecker, CurveStates, as_configurations
from planner.collision.cloud_blocks import CloudLook, blocks_of
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain
from planner.robot.clouds import Points
from planner.robot.moving import KnownMotion
from planner.robot.poses import se3
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere, bounding_box

_THICKNESS = 1e-6  # m
# its GJK stops at 1e-6 m; of 50,000 pairs that benchmarks/attack tried, some a kilometre from the origin, it put none
# farther apart than 4.3e-6 m beyond the truth, curved shapes most
_ERROR = 1e-5  # m
_CLOSE = 0.05  # m
_STRETCHES = (45, 15, 5, 1)  # consecutive configurations that one query clears


class CoalChecker(CollisionChecker):
    """The second and faster checker: C++ checks a batch of states per call.

    Its GJK converges to 1e-6 m, so distances need little allowance.
    """

    name = "coal"

    def __init__(self, world: World, known: CoalChecker | None = None, bound: ClearanceBound | None = None) -> None:
        """Build a checker; ``bound`` may be that of another checker of this world."""
        self.world = world
        self.chain = Chain.from_arm(world.robot)
        self.bound = bound or ClearanceBound(world, known.bound if known else None)
        self.queries, self.second = 0, []
        self._trees: dict[int, coal.CollisionGeometry] = {}
        self._request, self._clouds = coal.DistanceRequest(), CloudLook(world)
        self._others = world  # less the pairs with clouds
        if len(self._clouds.numbers):
            checked = np.array(world.checked)
            checked[:, self._clouds.numbers] = False
            self._others = replace(world, checked=checked)
        is_cloud = np.isin(np.arange(len(world.items)), len(world.bodies) + self._clouds.numbers)
        geometries = [None if is_cloud[k] else _geometry(item.shape) for k, item in enumerate(world.items)]
        alike = known if known is not None and has_same_arm(known.world, world) else None
        if alike is not None and has_same_shapes(alike.world, world):
            self._broad = alike._broad
        else:
            self._broad = LazyBroadPhase(self._others, geometries, alike and alike._broad)

    @cached_property
    def _placements(self) -> list[coal.Transform3s]:
        return [coal.Transform3s(item.placement[:3, :3], item.placement[:3, 3]) for item in self.world.items]

    def _distance_geometry(self, k: int) -> coal.CollisionGeometry:
        """Return item ``k`` for distance queries, which box trees do not support; built on demand."""
        if k not in self._trees:
            self._trees[k] = _geometry(self.world.items[k].shape, coal.BVHModelOBBRSS)
        return self._trees[k]

    @property
    def geometry_model(self) -> pin.GeometryModel:
        """Pinocchio's geometry of the world, with every checked pair as a collision pair."""
        shapes = [_geometry(item.shape) for item in self.world.items]
        return extract_geometry(self.world, shapes, np.arange(len(self.world.obstacles)), own=True)[0]

    def first_touch(self, q: Floats) -> tuple[int, Contact] | None:
        q = np.atleast_2d(np.asarray(q, dtype=float))
        self.queries += len(q)
        result = self._broad.phase.first_touch(self._others, q)
        pairs = self._pairs_in_clouds(q if result is None else q[: result[0] + 1], self.world.margin)
        met = np.flatnonzero(pairs >= 0)
        if len(met) and (result is None or (met[0], pairs[met[0]]) < result):
            result = int(met[0]), int(pairs[met[0]])
        return None if result is None else (result[0], self.world.contact(result[1]))

    def _pairs_in_clouds(self, q: Floats, margins: Floats | float) -> Ints:
        """Return the first pair (n,) of a body and a cloud within its ``margins`` (pairs,) m, -1 without any.

        By boxes alone for large margins, with which coal's trees cut nothing.
        Coal gets trees of the blocks near bodies only: a tree of a million samples takes it 15 s.
        """
        pairs, reach = np.full(len(q), -1, dtype=np.int64), margins + self.world.rounding
        request, here = make_request(coal.CollisionRequest), coal.Transform3s.Identity()
        for near in self._clouds.near(q, reach):
            if reach[near.pair] > _CLOSE + self.world.margin + self.world.rounding[near.pair]:
                rows = near.rows[(pairs[near.rows] < 0) | (pairs[near.rows] > near.pair)]
                pairs[rows] = near.pair
                continue
            request.security_margin = reach[near.pair]
            body, cloud = (self.world.items[k].shape for k in self.world.items_of(near.pair))
            shape = _geometry(body)
            for row, block, turn, shift in zip(
                near.rows.tolist(), near.blocks.tolist(), near.turns, near.shifts, strict=True
            ):
                if 0 <= pairs[row] <= near.pair:
                    continue
                tree, at = _tree_of_block(cloud, block, coal.BVHModelOBB), coal.Transform3s(turn, shift)
                if coal.collide(shape, at, tree, here, request, coal.CollisionResult()):
                    pairs[row] = near.pair
        return pairs

    def first_contact_along(self, q: Floats | CurveStates, motion: Floats) -> tuple[int, Contact] | None:
        """See :class:`planner.collision.checker.CollisionChecker`.

        If every pair is farther apart in the middle of a stretch than it moves from there to the ends, the stretch has
        no contact, and enclosure in the middle holds on all of it.
        """
        q = q if isinstance(q, CurveStates) else as_configurations(self, "q", q)
        starts, first = np.arange(0, len(q), _STRETCHES[0]), len(q)
        for width, finer in zip(_STRETCHES, (*_STRETCHES[1:], 1), strict=True):
            if not len(starts):
                break
            middle = as_configurations(self, "q", q[np.minimum(starts + width // 2, len(q) - 1)])
            near = self.near(middle, (width // 2) * motion)
            apart = starts[~near]
            enclosed = self.inside.pairs(middle[~near]) >= 0
            first = min(first, int(apart[enclosed].min(initial=first)))
            if width == 1:
                first = min(first, int(starts[near].min(initial=first)))
            starts = (starts[near][:, None] + np.arange(0, width, finer)).ravel()
            starts = starts[starts < first]
        result = self.first_contact(q[first : first + 1]) if first < len(q) else None
        return None if result is None else (first, result[1])

    def near(self, q: Floats, apart: Floats) -> Bools:
        """Return which configurations (n,) bring a pair within the margin plus ``apart`` (pairs,) m.

        All pairs of the others are certainly farther apart.
        """
        extra = _with_error(apart)
        near = self._broad.phase.touching(self._others, q, extra)
        left = np.flatnonzero(~near)
        near[left] = self._pairs_in_clouds(q[left], self.world.margin + extra) >= 0
        return near

    def distances_in(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        self.queries += len(pairs)
        placed = {row: _Placed(self, rotation[:, row], position[:, row]) for row in set(rows.tolist())}
        each = zip(rows.tolist(), pairs.tolist(), strict=True)
        return np.array([placed[row].distance(pair) for row, pair in each], dtype=float) - self.world.rounding[pairs]

    def error(self, distance: float) -> float:
        return _ERROR


def _with_error(extra: Floats) -> Floats:
    """Return margins that guarantee distances above ``extra``; 0 stays 0, to detect contact."""
    return np.where(extra > 0, extra + _ERROR, 0.0)


class _Placed:
    """The shapes of a checker in one configuration."""

    def __init__(self, checker: CoalChecker, rotation: Floats, position: Floats) -> None:
        self._checker, self._rotation, self._position = checker, rotation, position
        self._transforms: dict[int, coal.Transform3s] = {}

    def distance(self, pair: int) -> float:
        """Return the distance (m) of a numbered pair."""
        a, b = self._checker.world.items_of(pair)
        if isinstance(self._checker.world.items[b].shape, Points):
            return self._distance_to_cloud(a, b)
        one, other = self._checker._distance_geometry(a), self._checker._distance_geometry(b)
        result = coal.DistanceResult()
        return coal.distance(one, self._at(a), other, self._at(b), self._checker._request, result)

    def _distance_to_cloud(self, a: int, b: int) -> float:
        """Return the distance (m) of a body and a cloud: block by block, the nearest box first."""
        cloud, shape = self._checker.world.items[b].shape, self._checker._distance_geometry(a)
        assert isinstance(cloud, Points)
        at, here, blocks = self._at(b).inverse() * self._at(a), coal.Transform3s.Identity(), blocks_of(cloud)
        low, high = bounding_box(self._checker.world.items[a].shape)
        middle = at.transform(0.5 * (low + high))
        apart = np.linalg.norm(np.maximum(np.abs(middle - blocks.middles) - blocks.halves, 0.0), axis=1)
        bounds, distance = apart - 0.5 * float(np.linalg.norm(high - low)) - _ERROR, np.inf
        for block in np.argsort(bounds, kind="stable").tolist():
            if bounds[block] >= distance or distance <= 0.0:
                break
            tree, result = _tree_of_block(cloud, block, coal.BVHModelOBBRSS), coal.DistanceResult()
            distance = min(distance, coal.distance(shape, at, tree, here, self._checker._request, result))
        return distance

    def _at(self, k: int) -> coal.Transform3s:
        bodies = self._checker.world.bodies
        if k >= len(bodies):
            return self._checker._placements[k]
        if k not in self._transforms:
            joint = bodies[k].joint
            moved = coal.Transform3s(self._rotation[joint], self._position[joint])
            self._transforms[k] = moved * self._checker._placements[k]
        return self._transforms[k]


def _thicken_flat_mesh(vertices: Floats, triangles: Ints) -> Floats:
    """Return the vertices (n, 3); in a flat mesh one corner moves a micrometre out of the plane.

    Coal's broadphase misses shapes whose bounding box has no thickness.
    """
    centred, thick = vertices - vertices.mean(axis=0), np.array(vertices)
    directions = np.linalg.svd(centred.T @ centred)[2]  # rows, the thinnest last
    if np.ptp(centred @ directions.T, axis=0)[-1] < _THICKNESS:
        thick[triangles[0, 0]] += _THICKNESS * directions[-1]
    return thick


@lru_cache(maxsize=1024)  # nothing changes them, and trees of triangles take time
def _geometry(shape: Shape, tree: type[coal.BVHModelBase] = coal.BVHModelOBB) -> coal.CollisionGeometry:
    """Return a shape as coal's; ``tree`` is the type of mesh tree.

    Boxes (OBB) are fastest for contact; rectangle-swept spheres (OBBRSS) are required for distances, and fitting them
    takes as long as comparing them.
    """
    match shape:
        case Box(size):
            return coal.Box(*size)
        case Sphere(radius):
            return coal.Sphere(radius)
        case Cylinder(radius, length):
            return coal.Cylinder(radius, length)
        case Capsule(radius, length):
            return coal.Capsule(radius, length)
        case Mesh():
            return _tree_of_triangles(widen_triangles(shape), tree)


@lru_cache(maxsize=4096)
def _tree_of_block(cloud: Points, block: int, tree: type[coal.BVHModelBase]) -> coal.CollisionGeometry:
    return _tree_of_triangles(widen_points(blocks_of(cloud).samples[block]), tree)


def _tree_of_triangles(solid: Mesh, tree: type[coal.BVHModelBase]) -> coal.CollisionGeometry:
    vertices, triangles = np.array(solid.vertices), np.array(solid.triangles)
    mesh = tree()
    mesh.beginModel(len(triangles), len(vertices))
    mesh.addVertices(_thicken_flat_mesh(vertices, triangles))
    mesh.addTriangles(triangles)
    mesh.endModel()
    return mesh


class CoalInTime:
    """Coal's contacts in configurations at given times, among obstacles with known motions.

    The obstacles hang on free joints in a copy of the robot's model, so one call checks a batch of times. Threads take
    turns.
    """

    def __init__(self, world: World, motions: Mapping[str, KnownMotion]) -> None:
        self.world, self._motions, self._alone = world, motions, threading.Lock()
        model, joints = pin.Model(world.robot.model), {}
        for name in motions:
            joints[name] = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name)
        geometry = pin.GeometryModel()
        for k, item in enumerate(world.items):
            joint = joints.get(item.name, 0) if k >= len(world.bodies) else world.bodies[k].joint
            placement = pin.SE3.Identity() if k >= len(world.bodies) and item.name in joints else se3(item.placement)
            geometry.addGeometryObject(pin.GeometryObject(f"{k}", joint, placement, _geometry(item.shape)))
        self._numbers = np.argwhere(world.checked)
        mask = np.zeros((geometry.ngeoms, geometry.ngeoms), dtype=bool)
        mask[: len(world.bodies), len(world.bodies) :] = world.checked
        geometry.setCollisionPairs(mask)  # in the order of their numbers
        numbers = self._numbers @ [len(world.obstacles), 1] if len(self._numbers) else np.zeros(0, dtype=np.int64)
        self._margins = world.margin + world.rounding[numbers]
        self._pool = Pool(model, geometry, self._margins, 1)

    def first_touch(self, q: Floats, t: Floats) -> tuple[int, Contact] | None:
        """Return the first of (n, dof) configurations at times (n,) s in contact, and the contact."""
        hits = np.flatnonzero(self.touching(q, t))
        if not len(hits):
            return None
        row = hits[:1]
        with self._alone:
            first = self._pool.touching_rows(self._full_configurations(q[row], t[row])[0])[0]
        body, obstacle = self._numbers[first]
        return int(row[0]), Contact(self.world.bodies[body].link, self.world.obstacles[obstacle].name)

    def touching(self, q: Floats, t: Floats, extra: float = 0.0) -> Bools:
        """Return which configurations at times (n,) s come within the margin plus ``extra`` (m).

        The others are certainly farther apart if ``extra`` is above 0.
        """
        if not len(self._numbers):
            return np.zeros(len(q), dtype=bool)
        margins, whole = self._margins + _with_error(np.array(extra)), self._full_configurations(q, t)
        with self._alone:
            return self._pool.touching(whole, margins)

    def _full_configurations(self, q: Floats, t: Floats) -> Floats:
        own = Chain.from_arm(self.world.robot).values(q)
        return np.hstack([own, *(_free_flyer(motion.at(t)) for motion in self._motions.values())])


def _free_flyer(poses: Floats) -> Floats:
    """Return poses (n, 4, 4) as configurations (n, 7) of Pinocchio's free joint."""
    return np.array([pin.SE3ToXYZQUAT(se3(placement)) for placement in poses])
