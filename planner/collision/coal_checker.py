"""The door to coal through Pinocchio's broadphase managers: whole batches of configurations in one call, on threads."""

from __future__ import annotations

import os
import warnings

import coal
import numpy as np
import pinocchio as pin

from planner.arrays import Bools, Floats, Ints
from planner.collision.bounds import ClearanceBound
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain
from planner.poses import se3
from planner.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

_WORTH_THREADS = 128  # states: for fewer, threads that wait for each other on a busy machine cost more than they save


class CoalChecker(CollisionChecker):
    """The second opinion, and the faster one: state checks run in C++ for a whole batch.

    Same bodies, pairs and margin as any backend. Its GJK converges to 1e-6 m: distances need little room for error.
    """

    name = "coal"

    def __init__(self, world: World) -> None:
        self.world = world
        self.chain = Chain.of(world.robot)
        self.bound = ClearanceBound(world)
        self.queries = 0
        self._geometries = [_geometry(item.shape) for item in (*world.bodies, *world.obstacles)]
        self._local = [coal.Transform3s(item.placement[:3, :3], item.placement[:3, 3]) for item in world.bodies]
        self._fixed = [coal.Transform3s(item.placement[:3, :3], item.placement[:3, 3]) for item in world.obstacles]
        self._request = coal.DistanceRequest()
        self._model, self._pairs = self._geometry_model()
        self._data = pin.GeometryData(self._model)
        self._kinematics = world.robot.model.createData()
        self._threads = os.cpu_count() or 1
        self._pool = pin.BroadPhaseManagerPool_DynamicAABBTreeCollisionManager(
            world.robot.model, self._model, self._threads
        )
        for data in (self._data, *self._pool.getGeometryDatas()):
            for request in data.collisionRequests:
                request.security_margin = world.margin
                _settle(request)

    def _geometry_model(self) -> tuple[pin.GeometryModel, list[int]]:
        """Pinocchio's geometry of the world, and our number of each of its pairs."""
        world, model = self.world, pin.GeometryModel()
        joints = [body.joint for body in world.bodies] + [0] * len(world.obstacles)
        for k, (item, joint) in enumerate(zip((*world.bodies, *world.obstacles), joints, strict=True)):
            model.addGeometryObject(pin.GeometryObject(f"{k}", joint, se3(item.placement), self._geometries[k]))
        numbers = []
        for pair in range(len(world.pair_reach)):
            first, second = world.members(pair)
            if not world.is_scene_pair(pair):
                model.addCollisionPair(pin.CollisionPair(first, second))
            elif world.checked[first, second]:
                model.addCollisionPair(pin.CollisionPair(first, len(world.bodies) + second))
            else:
                continue
            numbers.append(pair)
        return model, numbers

    @property
    def geometry_model(self) -> pin.GeometryModel:
        """Pinocchio's geometry of the world: bodies and obstacles, and every checked pair as a collision pair."""
        return self._model

    def first_contact(self, q: Floats) -> tuple[int, Contact] | None:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        q = np.atleast_2d(np.asarray(q, dtype=float))
        self.queries += len(q)
        hits = np.nonzero(self._touching(q, False))[0]
        return (int(hits[0]), self.world.contact(self._touching_pair(q[hits[0]]))) if len(hits) else None

    def all_free(self, q: Floats) -> bool:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        q = np.atleast_2d(np.asarray(q, dtype=float))
        self.queries += len(q)
        return not self._touching(q, True).any()

    def _touching(self, q: Floats, stop_at_first: bool) -> Bools:
        """(n,) which configurations touch something; those after the first may be left out."""
        if not self._pairs:
            return np.zeros(len(q), dtype=bool)
        threads = self._threads if len(q) >= _WORTH_THREADS else 1
        hits = pin.computeCollisionsInParallel(threads, self._pool, np.asfortranarray(q.T), True, stop_at_first)
        return np.asarray(hits).ravel().astype(bool)

    def _touching_pair(self, q: Floats) -> int:
        """The first pair that touches at a configuration known to touch."""
        pin.computeCollisions(self.world.robot.model, self._kinematics, self._model, self._data, q, True)
        hits = [k for k, result in enumerate(self._data.collisionResults) if result.isCollision()]
        return self._pairs[hits[0]]

    def distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Floats:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        self.queries += len(pairs)
        placed: dict[int, coal.Transform3s] = {}
        result = np.empty(len(pairs))
        for k, pair in enumerate(pairs):
            first, second = self.world.members(int(pair))
            a = self._place(first, rotation, position, placed)
            if self.world.is_scene_pair(int(pair)):
                b, other = self._fixed[second], len(self._local) + second
            else:
                b, other = self._place(second, rotation, position, placed), second
            found = coal.DistanceResult()
            result[k] = coal.distance(self._geometries[first], a, self._geometries[other], b, self._request, found)
        return result

    def _place(
        self, b: int, rotation: Floats, position: Floats, placed: dict[int, coal.Transform3s]
    ) -> coal.Transform3s:
        if b not in placed:
            joint = self.world.bodies[b].joint
            placed[b] = coal.Transform3s(rotation[joint], position[joint]) * self._local[b]
        return placed[b]

    def error(self, distance: float) -> float:
        # its GJK stops at 1e-6 m; ten times that for the rounding of placements far from the origin
        return 1e-5


def _settle(request: coal.CollisionRequest) -> None:
    """What keeps a verdict from being wrong, or from depending on what was asked before.

    Without contacts coal leaves the penetration open, and called a capsule 25 mm inside a box free whose axis lay
    within 1e-6 m of the box's surface. And Pinocchio begins every GJK where the last one ended: within 1e-6 m of a
    contact the verdict then depends on earlier questions.
    """
    request.enable_contact = True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the flag that coal names instead does not undo this one
        request.enable_cached_gjk_guess = False


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
        case Mesh(vertices, triangles):
            mesh = coal.BVHModelOBBRSS()
            mesh.beginModel(len(triangles), len(vertices))
            mesh.addVertices(np.array(vertices))
            mesh.addTriangles(np.array(triangles))
            mesh.endModel()
            return mesh
