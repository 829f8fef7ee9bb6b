"""Collision checks by coal through Pinocchio's broadphase managers: a batch of configurations per call, on threads."""

from __future__ import annotations

import os
import threading
import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

import coal
import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, Ints
from planner.base.process_lock import PROCESS
from planner.collision.bounds import ClearanceBound
from planner.collision.checker import CollisionChecker, configurations
from planner.collision.degenerate_triangles import widened
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain
from planner.models.moving import KnownMotion
from planner.models.poses import se3
from planner.models.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

_WORTH_THREADS = 128  # states: for fewer, threads that wait for each other on a busy machine cost more than they save
_BEND = 1e-6  # m
# its GJK stops at 1e-6 m; of 50,000 pairs that benchmarks/attack tried, some a kilometre from the origin, it put none
# farther apart than 4.3e-6 m beyond the truth, curved shapes most
_ERROR = 1e-5  # m
_TOGETHER = 250  # obstacles: Pinocchio adds a shape in a time that grows with the square of those that are there
_STRETCHES = (49, 7, 1)  # configurations that are cleared at once, of a motion


class CoalChecker(CollisionChecker):
    """The second checker, and the faster one: C++ checks a whole batch of states.

    Same bodies, pairs and margin as any backend. Its GJK converges to 1e-6 m: distances need little room for error.
    """

    name = "coal"

    def __init__(self, world: World, known: CoalChecker | None = None, bound: ClearanceBound | None = None) -> None:
        """``bound``: that of another checker in this world."""
        self.world = world
        self.chain = Chain.of(world.robot)
        self.bound = bound or ClearanceBound(world, known.bound if known else None)
        self.queries, self.second = 0, []
        self._geometries = [_geometry(item.shape) for item in world.items]
        self._local = [coal.Transform3s(item.placement[:3, :3], item.placement[:3, 3]) for item in world.bodies]
        self._fixed = [coal.Transform3s(item.placement[:3, :3], item.placement[:3, 3]) for item in world.obstacles]
        self._request = coal.DistanceRequest()
        shared = known is not None and _differ_in_places_only(known.world, world)
        self._broadphase = known._broadphase if known is not None and shared else _BroadPhase(world, self._geometries)

    @property
    def geometry_model(self) -> pin.GeometryModel:
        """Pinocchio's geometry of the world: bodies and obstacles, and every checked pair as a collision pair."""
        return _geometry_model(self.world, self._geometries, np.arange(len(self.world.obstacles)), True)[0]

    def first_touch(self, q: Floats) -> tuple[int, Contact] | None:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        q = np.atleast_2d(np.asarray(q, dtype=float))
        self.queries += len(q)
        found = self._broadphase.first_touch(self.world, q)
        return None if found is None else (found[0], self.world.contact(found[1]))

    def first_contact_along(self, q: Floats, motion: Floats) -> tuple[int, Contact] | None:
        """See :class:`planner.collision.checker.CollisionChecker`.

        Where every pair is farther apart in the middle of a stretch than it moves from there to the ends, by coal's own
        word, nothing of the stretch touches, and what lies inside something in the middle does so on all of it.
        """
        q = configurations(self, "q", q)
        starts, first = np.arange(0, len(q), _STRETCHES[0]), len(q)
        for width, finer in zip(_STRETCHES, (*_STRETCHES[1:], 1), strict=True):
            middle = np.minimum(starts + width // 2, len(q) - 1)
            near = self._broadphase.touching(self.world, q[middle], (width // 2) * motion)
            enclosed = ~near & (self.inside.pairs(q[middle]) >= 0)
            first = min(first, int(starts[enclosed].min(initial=first)))
            if width == 1:
                first = min(first, int(starts[near].min(initial=first)))
            starts = (starts[near][:, None] + np.arange(0, width, finer)).ravel()
            starts = starts[starts < first]
        found = self.first_contact(q[first : first + 1]) if first < len(q) else None
        return None if found is None else (first, found[1])

    def distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Floats:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        self.queries += len(pairs)
        placed = _Placed(self, rotation, position)
        return np.array([placed.distance(pair) for pair in pairs.tolist()], dtype=float) - self.world.rounding[pairs]

    def _members(self, pair: int) -> tuple[int, int]:
        """The numbers of a pair's shapes in our lists, bodies first."""
        first, second = self.world.members(pair)
        return first, second + len(self._local) * self.world.is_scene_pair(pair)

    def error(self, distance: float) -> float:
        return _ERROR


class _BroadPhase:
    """Pinocchio's managers of a world, which worlds share whose obstacles differ in their places only.

    What takes time is every pair, not where it stands: with a thousand obstacles half a second. Threads ask one after
    the other.
    """

    def __init__(self, world: World, shapes: Sequence[coal.CollisionGeometry]) -> None:
        self._alone, self._placed = threading.RLock(), list(world.items)
        everywhere = np.flatnonzero(world.checked.any(axis=0))
        groups = np.split(everywhere, range(_TOGETHER, len(everywhere), _TOGETHER))
        parts = [_Part(world, shapes, group, k == 0) for k, group in enumerate(groups)]
        self._parts = [part for part in parts if len(part.pairs)]

    def first_touch(self, world: World, q: Floats) -> tuple[int, int] | None:
        """The first of the configurations (n, dof) that touches something in ``world``, and the first such pair."""
        with self._alone:
            hits = np.flatnonzero(self.touching(world, q))
            if not len(hits):
                return None
            pairs = (part.touching_pair(q[hits[0]]) for part in self._parts)
            return int(hits[0]), min(pair for pair in pairs if pair is not None)

    def touching(self, world: World, q: Floats, extra: Floats | None = None) -> Bools:
        """(n,) which configurations touch something, or come as near as the margin and ``extra`` (pairs,) m."""
        touching = np.zeros(len(q), dtype=bool)
        margins = world.margin + world.rounding + (0.0 if extra is None else _with_error(extra))
        with self._alone:
            self._place(world)
            for part in self._parts:
                free = np.flatnonzero(~touching)
                touching[free] = part.touching(q[free], margins[part.pairs])
        return touching

    def _place(self, world: World) -> None:
        """Let obstacles stand where they stand in ``world``."""
        for k, item in enumerate(world.items):
            if item is not self._placed[k]:
                for part in self._parts:
                    part.place(k, se3(item.placement))
                self._placed[k] = item


class _Part:
    """Bodies and some obstacles as Pinocchio's broadphase takes them: a pool for batches, the numbers of its pairs."""

    def __init__(self, world: World, shapes: Sequence[coal.CollisionGeometry], obstacles: Ints, own: bool) -> None:
        """``own``: with the pairs of bodies."""
        geometry, self.pairs = _geometry_model(world, shapes, obstacles, own)
        self._rows = {k: row for row, k in enumerate(_members(world, obstacles))}
        margins = world.margin + world.rounding[self.pairs]
        self._pool = _Pool(world.robot.model, geometry, margins, os.cpu_count() or 1)

    def touching(self, q: Floats, margins: Floats) -> Bools:
        """(n,) which configurations (n, dof) bring a pair as near as its margin (pairs,) m."""
        return self._pool.touching(q, margins)

    def touching_pair(self, q: Floats) -> int | None:
        """The number of the first pair that touches at a configuration (dof,)."""
        row = self._pool.touching_row(q)
        return None if row is None else int(self.pairs[row])

    def place(self, item: int, placement: pin.SE3) -> None:
        """Let an item of the world, by its number, stand elsewhere, where it is one of these."""
        for model in self._pool.models if item in self._rows else ():
            model.geometryObjects[self._rows[item]].placement = placement


class _Pool:
    """A robot's geometry as Pinocchio's broadphase takes it: for batches on threads, and for one configuration.

    ``models``: every copy of the geometry that the broadphase keeps. Stateful inside: one thread asks at a time.
    """

    def __init__(self, robot: pin.Model, geometry: pin.GeometryModel, margins: Floats, threads: int) -> None:
        """``margins`` (pairs,) m: what comes closer touches."""
        self._robot, self._geometry, self._threads = robot, geometry, threads
        self._data, self._kinematics = pin.GeometryData(geometry), robot.createData()
        self._pool = pin.BroadPhaseManagerPool_DynamicAABBTreeCollisionManager(robot, geometry, threads)
        self.models = [geometry, *(manager.getGeometryModel() for manager in self._pool.getBroadPhaseManagers())]
        self._margins = margins  # of the batches
        _settle((self._data, *self._pool.getGeometryDatas()), margins)

    def touching(self, q: Floats, margins: Floats) -> Bools:
        """(n,) which configurations (n, nq) bring a pair as near as these ``margins`` (pairs,) m."""
        if not np.array_equal(margins, self._margins):
            _keep(self._pool.getGeometryDatas(), margins)
            self._margins = margins
        threads = self._threads if len(q) >= _WORTH_THREADS else 1
        hits = pin.computeCollisionsInParallel(threads, self._pool, np.asfortranarray(q.T), True, False)
        return np.asarray(hits).ravel().astype(bool)

    def touching_row(self, q: Floats) -> int | None:
        """The row of the first pair that touches at a configuration (nq,), by the margins that it was made with."""
        pin.computeCollisions(self._robot, self._kinematics, self._geometry, self._data, q, True)
        hits = [k for k, result in enumerate(self._data.collisionResults) if result.isCollision()]
        return hits[0] if hits else None


def _members(world: World, obstacles: Ints) -> list[int]:
    """The numbers of all bodies and of some obstacles among the world's items."""
    count = len(world.bodies)
    return [*range(count), *(count + obstacles).tolist()]


def _geometry_model(
    world: World, shapes: Sequence[coal.CollisionGeometry], obstacles: Ints, own: bool
) -> tuple[pin.GeometryModel, Ints]:
    """Pinocchio's geometry of the bodies and some obstacles, and the number (pairs,) of each of its pairs, ascending.

    ``shapes`` of all items; ``own``: with the pairs of bodies.
    """
    model, count = pin.GeometryModel(), len(world.bodies)
    for k in _members(world, obstacles):
        item, joint = world.items[k], world.bodies[k].joint if k < count else 0
        model.addGeometryObject(pin.GeometryObject(f"{k}", joint, se3(item.placement), shapes[k]))
    numbers = []
    for body, column in np.argwhere(world.checked[:, obstacles]).tolist():
        model.addCollisionPair(pin.CollisionPair(body, count + column))
        numbers.append(body * len(world.obstacles) + int(obstacles[column]))
    for k, (first, second) in enumerate(world.self_pairs.tolist() if own else []):
        model.addCollisionPair(pin.CollisionPair(first, second))
        numbers.append(world.checked.size + k)
    return model, np.array(numbers, dtype=np.int64)


def _differ_in_places_only(one: World, other: World) -> bool:
    """Whether all is the same in two worlds but where obstacles stand."""
    return (
        one.margin == other.margin
        and one.robot.model is other.robot.model
        and one.bodies == other.bodies
        and [item.shape for item in one.obstacles] == [item.shape for item in other.obstacles]
        and np.array_equal(one.checked, other.checked)
        and np.array_equal(one.self_pairs, other.self_pairs)
    )


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
        shapes = self._checker._geometries
        a, b = self._checker._members(pair)
        found = coal.DistanceResult()
        return coal.distance(shapes[a], self._at(a), shapes[b], self._at(b), self._checker._request, found)

    def _at(self, k: int) -> coal.Transform3s:
        bodies = self._checker.world.bodies
        if k >= len(bodies):
            return self._checker._fixed[k - len(bodies)]
        if k not in self._transforms:
            joint = bodies[k].joint
            moved = coal.Transform3s(self._rotation[joint], self._position[joint])
            self._transforms[k] = moved * self._checker._local[k]
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


def _keep(geometries: Iterable[pin.GeometryData], margins: Floats) -> None:
    """Let pairs that come closer than their ``margins`` (pairs,) m count as a contact."""
    for data in geometries:
        for request, margin in zip(data.collisionRequests, margins.tolist(), strict=True):
            request.security_margin = margin


def _settle(geometries: Iterable[pin.GeometryData], margins: Floats) -> None:
    """Settings without which a verdict could be wrong, or depend on earlier questions.

    Without contacts coal leaves the penetration open, and called a capsule 25 mm inside a box free whose axis lay
    within 1e-6 m of the box's surface. And Pinocchio begins every GJK where the last one ended: within 1e-6 m of a
    contact the verdict then depends on earlier questions.
    """
    geometries = list(geometries)
    _keep(geometries, margins)
    with PROCESS, warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the flag that coal names instead does not undo this one
        for data in geometries:
            for request in data.collisionRequests:
                request.enable_contact = True
                request.enable_cached_gjk_guess = False


@lru_cache(maxsize=1024)  # nothing changes them, and trees of triangles take time
def _geometry(shape: Shape) -> coal.CollisionGeometry:
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
            solid = widened(shape)
            vertices, triangles = np.array(solid.vertices), np.array(solid.triangles)
            mesh = coal.BVHModelOBBRSS()
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
        for body, obstacle in self._numbers.tolist():
            geometry.addCollisionPair(pin.CollisionPair(body, len(world.bodies) + obstacle))
        numbers = self._numbers @ [len(world.obstacles), 1] if len(self._numbers) else np.zeros(0, dtype=np.int64)
        self._own_margins = world.margin + world.rounding[numbers]
        self._pool = _Pool(model, geometry, self._own_margins, 1)

    def first_touch(self, q: Floats, t: Floats) -> tuple[int, Contact] | None:
        """The first of the configurations (n, dof) at times (n,) s that touches a moving obstacle, and which."""
        hits = np.flatnonzero(self.touching(q, t))
        if not len(hits):
            return None
        row = hits[:1]
        with self._alone:
            pair = self._pool.touching_row(self._whole(q[row], t[row])[0])
        assert pair is not None  # it touches
        body, obstacle = self._numbers[pair]
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
        return np.hstack([q, *(_free_flyer(motion.at(t)) for motion in self._motions.values())])


def _free_flyer(poses: Floats) -> Floats:
    """Poses (n, 4, 4) as configurations (n, 7) of Pinocchio's free joint: position, then quaternion x, y, z, w."""
    return np.array([pin.SE3ToXYZQUAT(se3(placement)) for placement in poses])
