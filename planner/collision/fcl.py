"""Collision checks by FCL (python-fcl): exact collision checks and distances of primitives and meshes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import fcl
import numpy as np

from planner.base.arrays import Floats, Ints
from planner.collision.bounds import ClearanceBound
from planner.collision.checker import CollisionChecker
from planner.collision.mesh_gap import PlacedSolid, Solid, hull_gap, surface_gap
from planner.collision.needles import widened
from planner.collision.separating_plane import core_of, proven_gap
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain, joint_placements
from planner.world.shapes import Body, Box, Capsule, Cylinder, Mesh, Shape, Sphere

_NEAREST_POINTS = fcl.DistanceRequest(enable_nearest_points=True)
_COARSE = 0.05  # share of a distance that a quick one may fall short by
_ANY_CONTACT = fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)


@dataclass(frozen=True, eq=False)
class _Question:
    """Whether ``asked``, a body or a tree of bodies, touches anything in a tree."""

    asked: Any
    tree: fcl.DynamicAABBTreeCollisionManager
    moves: bool  # whether a tree holds bodies, which have moved since it was last asked


@dataclass
class _Hit:
    """What a callback leaves behind: the geometry objects of the pair, and for distances the nearest so far."""

    pair: tuple[fcl.CollisionGeometry, fcl.CollisionGeometry] | None = None
    nearest: float = np.inf


def _stop_at_contact(a: fcl.CollisionObject, b: fcl.CollisionObject, hit: _Hit) -> bool:
    result = fcl.CollisionResult()
    if fcl.collide(a, b, _ANY_CONTACT, result):
        hit.pair = result.contacts[0].o1, result.contacts[0].o2
        return True
    return False


def _update(question: _Question) -> None:
    if question.moves:
        question.tree.update()
        if not isinstance(question.asked, fcl.CollisionObject):
            question.asked.update()


class FclChecker(CollisionChecker):
    """Shapes are built once and moved per configuration; FCL's dynamic AABB trees keep far pairs cheap.

    python-fcl hands callbacks fresh wrapper objects, so a colliding pair is recognised by the geometry objects that
    its contact reports, and self-collision asks each body against a tree of just the bodies it is checked with.
    """

    name = "fcl"

    def __init__(self, world: World) -> None:
        self.world = world
        self.chain = Chain.of(world.robot)
        self.bound = ClearanceBound(world)
        self.queries = 0
        self._items = [*world.bodies, *world.obstacles]
        shapes = [_geometry(item.shape) for item in self._items]
        self._index = {id(shape): k for k, shape in enumerate(shapes)}
        self._solids = [Solid.of(item.shape) for item in self._items]
        self._hulls = [fcl.CollisionObject(_hull(solid)) for solid in self._solids]
        self._shapes = shapes  # contacts are told by these very objects: keep them alive
        count = len(world.bodies)
        self._bodies = [fcl.CollisionObject(shape) for shape in shapes[:count]]
        self._obstacles = [
            fcl.CollisionObject(shape, fcl.Transform(o.placement[:3, :3], o.placement[:3, 3]))
            for shape, o in zip(shapes[count:], world.obstacles, strict=True)
        ]
        self._poses = [(item.placement[:3, :3], item.placement[:3, 3]) for item in self._items]
        self._moving = [k for k, body in enumerate(world.bodies) if body.joint != 0]
        self._place_static()
        self._questions = self._build_questions()

    def _place_static(self) -> None:
        for item, body in zip(self._bodies, self.world.bodies, strict=True):
            if body.joint == 0:
                item.setTransform(fcl.Transform(body.placement[:3, :3], body.placement[:3, 3]))

    def _build_questions(self) -> list[_Question]:
        """Everything that has to be asked about one placement of the bodies."""
        questions = []
        scene = _tree(self._obstacles)
        if self.world.checked.all() and self._obstacles:
            questions.append(_Question(_tree(self._bodies), scene, True))
        else:
            for b, row in enumerate(self.world.checked):
                if row.any():
                    tree = scene if row.all() else _tree([self._obstacles[o] for o in np.nonzero(row)[0]])
                    questions.append(_Question(self._bodies[b], tree, False))
        for b in range(len(self._bodies)):
            others = self.world.self_pairs[self.world.self_pairs[:, 1] == b, 0]
            if len(others):
                questions.append(_Question(self._bodies[b], _tree([self._bodies[i] for i in others]), True))
        return questions

    def first_touch(self, q: Floats) -> tuple[int, Contact] | None:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        q = np.atleast_2d(np.asarray(q, dtype=float))
        rotation, position = joint_placements(self.chain, q)
        bodies = self.world.bodies
        placements = [(b, *_world_placement(bodies[b], rotation, position)) for b in self._moving]
        for row in range(len(q)):
            for b, turns, shifts in placements:
                self._put(b, turns[row], shifts[row])
            pair = self._touching_pair()
            if pair is not None:
                return row, self.world.contact(pair)
        return None

    def all_free(self, q: Floats) -> bool:
        """See :class:`planner.collision.checker.CollisionChecker`; FCL looks where the cheap bounds cannot tell."""
        rotation, position = joint_placements(self.chain, np.atleast_2d(np.asarray(q, dtype=float)))
        bounds = self.bound.coarse(rotation, position)
        rows, pairs = np.nonzero(bounds <= self.world.margin)
        self.queries += len(rows)
        return not any(
            self._touches(int(pairs[k]), rotation[:, rows[k]], position[:, rows[k]])
            for k in np.argsort(bounds[rows, pairs], kind="stable")
        )

    def _touches(self, pair: int, rotation: Floats, position: Floats) -> bool:
        first, second = self.world.members(pair)
        if self.world.margin > 0:
            return self.distances(rotation, position, np.array([pair]))[0] <= self.world.margin
        self._move(first, rotation, position, set())
        if not self.world.is_scene_pair(pair):
            self._move(second, rotation, position, set())
        return self._collide(*self._members(pair))

    def _put(self, b: int, turn: Floats, shift: Floats) -> None:
        self._poses[b] = turn, shift
        self._bodies[b].setTransform(fcl.Transform(turn, shift))

    def _touching_pair(self) -> int | None:
        self.queries += 1
        for question in self._questions:
            _update(question)
            if self.world.margin > 0:
                hit = _Hit(nearest=self.world.margin * (1 + 1e-12))  # the trees skip whatever is farther than this
                question.tree.distance(question.asked, hit, self._keep_nearest)
            else:
                hit = _Hit()
                question.tree.collide(question.asked, hit, _stop_at_contact)
            if hit.pair is not None:
                return self._pair_of(hit.pair)
        return None

    def _keep_nearest(self, a: fcl.CollisionObject, b: fcl.CollisionObject, hit: _Hit) -> tuple[bool, float]:
        result = fcl.DistanceResult()
        gap = fcl.distance(a, b, _NEAREST_POINTS, result)
        first, second = self._index[id(result.o1)], self._index[id(result.o2)]
        gap = self._mesh_distance(first, second) if self._is_mesh(first, second) else self._lowered(gap, result)
        if gap < hit.nearest:
            hit.nearest, hit.pair = gap, (result.o1, result.o2)
        return hit.nearest <= 0, hit.nearest

    def _is_mesh(self, first: int, second: int) -> bool:
        return any(isinstance(self._items[k].shape, Mesh) for k in (first, second))

    def _lowered(self, gap: float, result: fcl.DistanceResult, share: float = 0.0) -> float:
        """A distance that FCL reports of two primitives, brought down to what a plane between them proves.

        FCL stops its GJK early: between boxes, cylinders and capsules it was seen to report 20 mm where 0.7 mm were
        left, and 247 mm where 94 mm were.
        """
        if gap <= 1e-12:
            return -1.0
        first, second = self._index[id(result.o1)], self._index[id(result.o2)]
        a, b = self._items[first].shape, self._items[second].shape
        if _has_formula(a, b):
            return gap
        p, q = (np.asarray(point) for point in result.nearest_points)
        cores = core_of((a, *self._poses[first])), core_of((b, *self._poses[second]))
        return min(gap, max(proven_gap(cores[0], cores[1], q - p, share, gap).low, 1e-12))

    def _mesh_distance(self, first: int, second: int, quick: bool = False) -> float:
        """The distance of two shapes of which one is a mesh, proven by planes; FCL says only whether they touch.

        No distance that it reports of a mesh can be used: 18.5 mm where 4 mm were left between a box and a triangle, at
        which its GJK stops early, and 2.14 m where 0.62 m were left between two triangles with parallel sides.
        """
        a, b = (PlacedSolid(self._solids[k], *self._poses[k]) for k in (first, second))
        depth = a.solid.depth + b.solid.depth
        apart, length = self._guess(a, b, first, second)
        gap = hull_gap(a, b, apart, length, _COARSE) if quick else 0.0
        if gap > self.world.margin + depth:
            return gap
        gap = hull_gap(a, b, apart, length)
        if gap > 0.0 and depth == 0.0:
            return gap
        if self._collide(first, second):
            return -1.0
        return max(surface_gap(a, b, _COARSE if quick else 0.0), 1e-12)

    def _guess(self, a: PlacedSolid, b: PlacedSolid, first: int, second: int) -> tuple[Floats, float]:
        """The vector between two hulls' nearest points by FCL, and its length; between middles where they touch."""
        for placed, k in ((a, first), (b, second)):
            self._hulls[k].setTransform(fcl.Transform(placed.turn, placed.position))
        result = fcl.DistanceResult()
        length = fcl.distance(self._hulls[first], self._hulls[second], _NEAREST_POINTS, result)
        if length > 0.0:
            p, q = (np.asarray(point) for point in result.nearest_points)
            return q - p, length
        return b.hull.middle - a.hull.middle, np.inf

    def _pair_of(self, hit: tuple[fcl.CollisionGeometry, fcl.CollisionGeometry]) -> int:
        """The number of the pair whose two geometry objects a contact names, in either order."""
        first, second = sorted(self._index[id(shape)] for shape in hit)
        bodies, obstacles = len(self._bodies), len(self._obstacles)
        if second >= bodies:
            return first * obstacles + second - bodies
        row = np.nonzero((self.world.self_pairs == (first, second)).all(axis=1))[0][0]
        return bodies * obstacles + int(row)

    def distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Floats:
        """See :class:`planner.collision.checker.CollisionChecker`."""
        return np.fromiter(self._each_distance(rotation, position, pairs, False), float, len(pairs))

    def bounding_distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Iterator[float]:
        """See :class:`planner.collision.checker.CollisionChecker`: of a mesh's hull, as long as that is far enough."""
        return self._each_distance(rotation, position, pairs, True)

    def _each_distance(self, rotation: Floats, position: Floats, pairs: Ints, quick: bool) -> Iterator[float]:
        moved: set[int] = set()
        for pair in pairs.tolist():
            first, second = self.world.members(pair)
            self._move(first, rotation, position, moved)
            if not self.world.is_scene_pair(pair):
                self._move(second, rotation, position, moved)
            self.queries += 1
            yield self._pair_distance(pair, quick)

    def _move(self, b: int, rotation: Floats, position: Floats, moved: set[int]) -> None:
        if b not in moved:
            moved.add(b)
            body = self.world.bodies[b]
            turn = rotation[body.joint]
            self._put(b, turn @ body.placement[:3, :3], position[body.joint] + turn @ body.placement[:3, 3])

    def _pair_distance(self, pair: int, quick: bool) -> float:
        first, second = self._members(pair)
        if self._is_mesh(first, second):
            return self._mesh_distance(first, second, quick)
        result = fcl.DistanceResult()
        gap = fcl.distance(self._placed(first), self._placed(second), _NEAREST_POINTS, result)
        lowered = self._lowered(gap, result, _COARSE if quick else 0.0)
        return lowered if not quick or lowered > self.world.margin else self._lowered(gap, result)

    def _members(self, pair: int) -> tuple[int, int]:
        """The numbers of a pair's shapes in our lists, bodies first."""
        first, second = self.world.members(pair)
        return first, second + len(self._bodies) * self.world.is_scene_pair(pair)

    def _placed(self, k: int) -> fcl.CollisionObject:
        return self._bodies[k] if k < len(self._bodies) else self._obstacles[k - len(self._bodies)]

    def _collide(self, first: int, second: int) -> bool:
        return bool(fcl.collide(self._placed(first), self._placed(second), _ANY_CONTACT, fcl.CollisionResult()))

    def error(self, distance: float) -> float:
        # planes prove the distances, formulas are exact: in 30,000 attacked pairs, some a kilometre from the origin, no
        # more than 4e-13 m, see `planner bench attack`; a micrometre leaves room for rounding farther away
        return 1e-6


def _has_formula(a: Shape, b: Shape) -> bool:
    """Whether FCL computes a distance in closed form: exact to 4e-13 m in all cases of `planner bench attack`."""
    return isinstance(a, Sphere) or isinstance(b, Sphere) or (isinstance(a, Capsule) and isinstance(b, Capsule))


def _world_placement(body: Body, rotation: Floats, position: Floats) -> tuple[Floats, Floats]:
    turn = rotation[body.joint]
    return turn @ body.placement[:3, :3], position[body.joint] + turn @ body.placement[:3, 3]


def _hull(solid: Solid) -> fcl.CollisionGeometry:
    """The convex hull of a shape; a flat mesh, which has no volume, as it is."""
    hull = solid.hull_faces()
    if hull is None:
        return _geometry(solid.shape)
    corners, faces = hull
    return fcl.Convex(corners, len(faces), np.column_stack([np.full(len(faces), 3), faces]).ravel())


def _tree(items: list[fcl.CollisionObject]) -> fcl.DynamicAABBTreeCollisionManager:
    tree = fcl.DynamicAABBTreeCollisionManager()
    tree.registerObjects(items)
    tree.setup()
    return tree


def _geometry(shape: Shape) -> fcl.CollisionGeometry:
    match shape:
        case Box(size):
            return fcl.Box(*size)
        case Sphere(radius):
            return fcl.Sphere(radius)
        case Cylinder(radius, length):
            return fcl.Cylinder(radius, length)
        case Capsule(radius, length):
            return fcl.Capsule(radius, length)
        case Mesh():
            solid = widened(shape)
            vertices, triangles = np.array(solid.vertices), np.array(solid.triangles)
            mesh = fcl.BVHModel()
            mesh.beginModel(len(vertices), len(triangles))
            mesh.addSubModel(vertices, triangles)
            mesh.endModel()
            return mesh
