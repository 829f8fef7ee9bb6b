"""Collision checks by coal through Pinocchio's broadphase managers: a batch of configurations per call, on threads."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from functools import cached_property, lru_cache

import coal
import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, Ints
from planner.collision.bounding_volumes import widen_triangles
from planner.collision.bounds import ClearanceBound
from planner.collision.broad_phase import LazyBroadPhase, Pool, extract_geometry, has_same_arm, has_same_shapes
from planner.collision.checker import CollisionChecker, CurveStates, as_configurations
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain
from planner.robot.moving import KnownMotion
from planner.robot.poses import se3
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

_BEND = 1e-6  # m
# its GJK stops at 1e-6 m; of 50,000 pairs that benchmarks/attack tried, some a kilometre from the origin, it put none
# farther apart than 4.3e-6 m beyond the truth, curved shapes most
_ERROR = 1e-5  # m
_STRETCHES = (45, 15, 5, 1)  # configurations that are cleared at once, of a motion


class CoalChecker(CollisionChecker):
    """The second checker, and the faster one: C++ checks a whole batch of states.

    Same bodies, pairs and margin as any backend. Its GJK converges to 1e-6 m: distances need little room for error.
    """

    name = "coal"

    def __init__(self, world: World, known: CoalChecker | None = None, bound: ClearanceBound | None = None) -> None:
        """``bound``: that of another checker in this world."""
        self.world = world
        self.chain = Chain.from_arm(world.robot)
        self.bound = bound or ClearanceBound(world, known.bound if known else None)
        self.queries, self.second = 0, []
        self._geometries = [_geometry(item.shape) for item in world.items]
        self._trees: dict[int, coal.CollisionGeometry] = {}
        self._request = coal.DistanceRequest()
        alike = known if known is not None and has_same_arm(known.world, world) else None
        if alike is not None and has_same_shapes(alike.world, world):
            self._broad = alike._broad
        else:
            self._broad = LazyBroadPhase(world, self._geometries, alike and alike._broad)

    @cached_property
    def _placements(self) -> list[coal.Transform3s]:
        """Of all items, in the frames of their joints."""
        return [coal.Transform3s(item.placement[:3, :3], item.placement[:3, 3]) for item in self.world.items]

    def _measured(self, k: int) -> coal.CollisionGeometry:
        """Item ``k``, as distances are asked of it: a tree of boxes alone has none. Few are ever asked for."""
        if k not in self._trees:
            self._trees[k] = _geometry(self.world.items[k].shape, coal.BVHModelOBBRSS)
        return self._trees[k]

    @property
    def geometry_model(self) -> pin.GeometryModel:
        """Pinocchio's geometry of the world: bodies and obstacles, and every checked pair as a collision pair."""
        return extract_geometry(self.world, self._geometries, np.arange(len(self.world.obstacles)), own=True)[0]

    def first_touch(self, q: Floats) -> tuple[int, Contact] | None:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        q = np.atleast_2d(np.asarray(q, dtype=float))
        self.queries += len(q)
        found = self._broad.phase.first_touch(self.world, q)
        return None if found is None else (found[0], self.world.contact(found[1]))

    def first_contact_along(self, q: Floats | CurveStates, motion: Floats) -> tuple[int, Contact] | None:
        """See :class:`planner.collision.checker.CollisionChecker`.

        Where every pair is farther apart in the middle of a stretch than it moves from there to the ends, by coal's own
        word, nothing of the stretch touches, and what lies inside something in the middle does so on all of it.
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
        found = self.first_contact(q[first : first + 1]) if first < len(q) else None
        return None if found is None else (first, found[1])

    def near(self, q: Floats, apart: Floats) -> Bools:
        """(n,) which configurations (n, dof) bring a pair as near as the margin and ``apart`` (pairs,) m.

        Where they do not, every pair is farther apart for certain.
        """
        return self._broad.phase.touching(self.world, q, _with_error(apart))

    def distances_in(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        self.queries += len(pairs)
        placed = {row: _Placed(self, rotation[:, row], position[:, row]) for row in set(rows.tolist())}
        each = zip(rows.tolist(), pairs.tolist(), strict=True)
        return np.array([placed[row].distance(pair) for row, pair in each], dtype=float) - self.world.rounding[pairs]

    def error(self, distance: float) -> float:
        return _ERROR


def _with_error(extra: Floats) -> Floats:
    """What has to be kept so that distances are larger than ``extra`` for certain; 0 stays, to ask what touches."""
    return np.where(extra > 0, extra + _ERROR, 0.0)


class _Placed:
    """The shapes of a checker at one placement of the joints."""

    def __init__(self, checker: CoalChecker, rotation: Floats, position: Floats) -> None:
        self._checker, self._rotation, self._position = checker, rotation, position
        self._transforms: dict[int, coal.Transform3s] = {}

    def distance(self, pair: int) -> float:
        """The distance (m) of a numbered pair."""
        a, b = self._checker.world.items_of(pair)
        one, other = self._checker._measured(a), self._checker._measured(b)
        found = coal.DistanceResult()
        return coal.distance(one, self._at(a), other, self._at(b), self._checker._request, found)

    def _at(self, k: int) -> coal.Transform3s:
        bodies = self._checker.world.bodies
        if k >= len(bodies):
            return self._checker._placements[k]
        if k not in self._transforms:
            joint = bodies[k].joint
            moved = coal.Transform3s(self._rotation[joint], self._position[joint])
            self._transforms[k] = moved * self._checker._placements[k]
        return self._transforms[k]


def _bent(vertices: Floats, triangles: Ints) -> Floats:
    """The vertices (n, 3) of a mesh; of a flat one a corner is moved by a micrometre out of the plane.

    Coal's broadphase overlooks whatever has a bounding box without thickness: a plate of triangles lying level.
    """
    extents, directions = _principal(vertices)
    bent = np.array(vertices)
    if extents[-1] < _BEND:
        bent[triangles[0, 0]] += _BEND * directions[-1]
    return bent


def _principal(points: Floats) -> tuple[Floats, Floats]:
    """Extents (3,) of points (n, 3) along their principal directions (3, 3), rows; the last is the thinnest."""
    centred = points - points.mean(axis=0)
    directions = np.linalg.svd(centred.T @ centred)[2]
    return np.ptp(centred @ directions.T, axis=0), directions


@lru_cache(maxsize=1024)  # nothing changes them, and trees of triangles take time
def _geometry(shape: Shape, tree: type[coal.BVHModelBase] = coal.BVHModelOBB) -> coal.CollisionGeometry:
    """A shape as coal knows it, a mesh as a ``tree``: of boxes (OBB) to ask what touches, with spheres swept by
    rectangles (OBBRSS) to measure distances. Fitting the latter to each shape that a mesh is compared with takes as
    long again as comparing them.
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
            solid = widen_triangles(shape)
            vertices, triangles = np.array(solid.vertices), np.array(solid.triangles)
            mesh = tree()
            mesh.beginModel(len(triangles), len(vertices))
            mesh.addVertices(_bent(vertices, triangles))
            mesh.addTriangles(triangles)
            mesh.endModel()
            return mesh


class CoalInTime:
    """Coal's opinion on configurations at times, among obstacles that move along known motions.

    The moving obstacles hang on joints of their own in a copy of the robot's model, so that a batch of moments is
    asked at once. Stateful inside, so threads ask one after the other.
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
        asked = np.zeros((geometry.ngeoms, geometry.ngeoms), dtype=bool)
        asked[: len(world.bodies), len(world.bodies) :] = world.checked
        geometry.setCollisionPairs(asked)  # in the order of their numbers
        numbers = self._numbers @ [len(world.obstacles), 1] if len(self._numbers) else np.zeros(0, dtype=np.int64)
        self._own_margins = world.margin + world.rounding[numbers]
        self._pool = Pool(model, geometry, self._own_margins, 1)

    def first_touch(self, q: Floats, t: Floats) -> tuple[int, Contact] | None:
        """The first of the configurations (n, dof) at times (n,) s that touches a moving obstacle, and which."""
        hits = np.flatnonzero(self.touching(q, t))
        if not len(hits):
            return None
        row = hits[:1]
        with self._alone:
            first = self._pool.touching_rows(self._whole(q[row], t[row])[0])[0]
        body, obstacle = self._numbers[first]
        return int(row[0]), Contact(self.world.bodies[body].link, self.world.obstacles[obstacle].name)

    def touching(self, q: Floats, t: Floats, extra: float = 0.0) -> Bools:
        """(n,) which configurations at times (n,) s touch a moving obstacle.

        Or come as near as the margin and ``extra`` m: where they do not, they are farther away for certain.
        """
        if not len(self._numbers):
            return np.zeros(len(q), dtype=bool)
        margins, whole = self._own_margins + _with_error(np.array(extra)), self._whole(q, t)
        with self._alone:
            return self._pool.touching(whole, margins)

    def _whole(self, q: Floats, t: Floats) -> Floats:
        own = Chain.from_arm(self.world.robot).values(q)
        return np.hstack([own, *(_free_flyer(motion.at(t)) for motion in self._motions.values())])


def _free_flyer(poses: Floats) -> Floats:
    """Poses (n, 4, 4) as configurations (n, 7) of Pinocchio's free joint: position, then quaternion x, y, z, w."""
    return np.array([pin.SE3ToXYZQUAT(se3(placement)) for placement in poses])
