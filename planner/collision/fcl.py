"""Collision checks by FCL (python-fcl): exact collision checks and distances of primitives and meshes."""

from __future__ import annotations

import threading
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import fcl
import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.interrupts import signals_wait
from planner.base.records import dataclass
from planner.collision.bounds import ClearanceBound
from planner.collision.checker import CollisionChecker
from planner.collision.degenerate_triangles import widened
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain, joint_placements
from planner.models.shapes import Body, Box, Capsule, Cylinder, Mesh, Obstacle, Shape, Sphere

_NEAREST_POINTS = fcl.DistanceRequest(enable_nearest_points=True)
_APART = 1e-12  # m: what no plane proves apart and FCL does not call touching
_ANY_CONTACT = fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)


@dataclass(frozen=True, eq=False)
class _Question:
    """Whether ``asked``, a body or a tree of bodies, touches anything in a tree."""

    asked: Any
    tree: fcl.DynamicAABBTreeCollisionManager
    moves: bool  # whether a tree holds bodies, which have moved since it was last asked


@dataclass
class _Hit:
    """What callbacks leave behind: the number of the nearest pair so far, the lowest number where several are as near.

    In which order a tree asks depends on what it was asked before, so the first pair that touches would too.
    """

    nearest: float = np.inf
    pair: int | None = None
    failure: BaseException | None = None  # of a callback: who calls it, C++, swallows what it raises

    def take(self, gap: float, pair: int) -> None:
        if self.pair is None or (gap, pair) < (self.nearest, self.pair):
            self.nearest, self.pair = gap, pair


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

    def __init__(self, world: World, known: FclChecker | None = None) -> None:
        self.world, self._alone = world, threading.Lock()
        self.chain = Chain.of(world.robot)
        self.bound = ClearanceBound(world, known.bound if known else None)
        self.queries = 0
        self.second = known.second if known else []
        self._made = known.geometries if known else {}
        self._now = np.empty(0), np.empty(0)  # rotations and positions of the joints, where the bodies are
        self._moving = [k for k, body in enumerate(world.bodies) if body.joint != 0]

    @cached_property
    def _shapes(self) -> list[fcl.CollisionGeometry]:
        """Of all items; contacts are told by these very objects. Made when asked: trees of triangles take time."""
        made, world = self._made, self.world
        obstacles = [made[item] if item in made else _geometry(item.shape) for item in world.obstacles]
        return [*map(_body, world.bodies), *obstacles]

    @cached_property
    def _index(self) -> dict[int, int]:
        return {id(shape): k for k, shape in enumerate(self._shapes)}

    @cached_property
    def _bodies(self) -> list[fcl.CollisionObject]:
        bodies = self.world.bodies
        items = [fcl.CollisionObject(shape) for shape in self._shapes[: len(bodies)]]
        for item, body in zip(items, bodies, strict=True):
            if body.joint == 0:
                item.setTransform(fcl.Transform(body.placement[:3, :3], body.placement[:3, 3]))
        return items

    @cached_property
    def _obstacles(self) -> list[fcl.CollisionObject]:
        return [
            fcl.CollisionObject(shape, fcl.Transform(o.placement[:3, :3], o.placement[:3, 3]))
            for shape, o in zip(self._shapes[len(self.world.bodies) :], self.world.obstacles, strict=True)
        ]

    @property
    def geometries(self) -> dict[Obstacle, fcl.CollisionGeometry]:
        """What FCL has made of every obstacle so far."""
        if "_shapes" not in vars(self):
            return self._made
        return dict(zip(self.world.obstacles, self._shapes[len(self.world.bodies) :], strict=True))

    @cached_property
    def _questions(self) -> list[_Question]:
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
        """See :class:`planner.collision.checker.CollisionChecker`; within its rounding a thinned mesh is for planes."""
        q = np.atleast_2d(np.asarray(q, dtype=float))
        found = self._first_crossing(q)
        if not self.world.rounding.any():
            return found
        near = self.bound.first_near(q if found is None else q[: found[0]])
        return found if near is None else (near[0], self.world.contact(near[1]))

    def _first_crossing(self, q: Floats) -> tuple[int, Contact] | None:
        """The same for the shapes as FCL knows them, meshes without a rounding."""
        rotation, position = joint_placements(self.chain, q)
        bodies = self.world.bodies
        placements = [(self._bodies[b], *_world_placement(bodies[b], rotation, position)) for b in self._moving]
        place = fcl.Transform()  # one for all: making each anew takes longer than all that FCL does with it
        with self._alone, signals_wait() as heed:
            for row in range(len(q)):
                heed()
                self._now = rotation[:, row], position[:, row]
                for body, turns, shifts in placements:
                    place.setRotation(turns[row])
                    place.setTranslation(shifts[row])
                    body.setTransform(place)
                pair = self._touching_pair()
                if pair is not None:
                    return row, self.world.contact(pair)
        return None

    def _touching_pair(self) -> int | None:
        self.queries += 1
        for question in self._questions:
            _update(question)
            hit = _Hit()
            if self.world.margin > 0:
                hit.nearest = self.world.margin * (1 + 1e-12)  # the trees skip whatever is farther than this
                question.tree.distance(question.asked, hit, self._keep_nearest)
            if self.world.margin <= 0 or hit.nearest <= 0:
                question.tree.collide(question.asked, hit, self._keep_touching)
            if hit.failure is not None:
                raise hit.failure
            if hit.pair is not None:
                return hit.pair
        return None

    def _keep_touching(self, a: fcl.CollisionObject, b: fcl.CollisionObject, hit: _Hit) -> bool:
        try:
            result = fcl.CollisionResult()
            if fcl.collide(a, b, _ANY_CONTACT, result):
                hit.take(-1.0, self._pair_of((result.contacts[0].o1, result.contacts[0].o2)))
        except BaseException as error:  # raised where the tree was asked
            hit.failure = error
        return hit.failure is not None

    def _keep_nearest(self, a: fcl.CollisionObject, b: fcl.CollisionObject, hit: _Hit) -> tuple[bool, float]:
        try:
            result = fcl.DistanceResult()
            fcl.distance(a, b, _NEAREST_POINTS, result)
            pair = self._pair_of((result.o1, result.o2))
            gap = float(self._gaps(*self._now, np.array([pair]))[0])
            if gap <= hit.nearest:
                hit.take(gap, pair)
        except BaseException as error:  # as above
            hit.failure = error
        return hit.failure is not None or hit.nearest <= 0, hit.nearest

    def _pair_of(self, hit: tuple[fcl.CollisionGeometry, fcl.CollisionGeometry]) -> int:
        """The number of the pair whose two geometry objects a contact names, in either order."""
        first, second = sorted(self._index[id(shape)] for shape in hit)
        bodies, obstacles = len(self._bodies), len(self._obstacles)
        if second >= bodies:
            return first * obstacles + second - bodies
        row = np.nonzero((self.world.self_pairs == (first, second)).all(axis=1))[0][0]
        return bodies * obstacles + int(row)

    def distances(self, rotation: Floats, position: Floats, pairs: Ints) -> Floats:
        """See :class:`planner.collision.checker.CollisionChecker`: FCL says what touches, planes how far apart.

        No distance that FCL reports can be used as it is. Its GJK stops early: 20 mm where 0.7 mm were left between
        boxes, 2.14 m where 0.62 m were left between two triangles with parallel sides.
        """
        with self._alone:
            return self._gaps(rotation, position, pairs)

    def _gaps(self, rotation: Floats, position: Floats, pairs: Ints) -> Floats:
        self.queries += len(pairs)
        gaps = self.bound.close(rotation[:, None], position[:, None], np.zeros_like(pairs), pairs)
        for k in np.flatnonzero(gaps <= 0.0).tolist():
            if self.world.rounding[pairs[k]] == 0:
                gaps[k] = self._touch(int(pairs[k]), rotation, position)
        return gaps

    def _touch(self, pair: int, rotation: Floats, position: Floats) -> float:
        first, second = self.world.members(pair)
        is_scene = self.world.is_scene_pair(pair)
        other = self._obstacles[second] if is_scene else self._moved(second, rotation, position)
        touches = fcl.collide(self._moved(first, rotation, position), other, _ANY_CONTACT, fcl.CollisionResult())
        return -1.0 if touches else _APART

    def _moved(self, b: int, rotation: Floats, position: Floats) -> fcl.CollisionObject:
        """A body where the joints are."""
        body, item = self.world.bodies[b], self._bodies[b]
        turn = rotation[body.joint]
        shift = position[body.joint] + turn @ body.placement[:3, 3]
        item.setTransform(fcl.Transform(turn @ body.placement[:3, :3], shift))
        return item

    def error(self, distance: float) -> float:
        # planes prove the distances, formulas are exact: in 30,000 attacked pairs, some a kilometre from the origin, no
        # more than 4e-13 m, see `python -m benchmarks attack`; a micrometre leaves room for rounding farther away
        return 1e-6


def _world_placement(body: Body, rotation: Floats, position: Floats) -> tuple[Floats, Floats]:
    turn = rotation[body.joint]
    return turn @ body.placement[:3, :3], position[body.joint] + turn @ body.placement[:3, 3]


def _tree(items: list[fcl.CollisionObject]) -> fcl.DynamicAABBTreeCollisionManager:
    tree = fcl.DynamicAABBTreeCollisionManager()
    tree.registerObjects(items)
    tree.setup()
    return tree


# of bodies, for as long as somebody has them; those of one shape have one each, as contacts are told by it
_made: WeakKeyDictionary[Body, fcl.CollisionGeometry] = WeakKeyDictionary()


def _body(body: Body) -> fcl.CollisionGeometry:
    """The shape of a body, made once."""
    made = _made.get(body)
    return _made.setdefault(body, _geometry(body.shape)) if made is None else made


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
