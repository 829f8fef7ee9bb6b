"""Collision checks by FCL (python-fcl): exact collision checks and distances of primitives and meshes."""

from __future__ import annotations

import threading
from functools import cached_property, lru_cache

import fcl
import numpy as np

from planner.base.arrays import Floats, Ints
from planner.collision.bounds import ClearanceBound
from planner.collision.boxes import Boxes
from planner.collision.checker import CollisionChecker
from planner.collision.degenerate_triangles import widened
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

_APART = 1e-12  # m: what no plane proves apart and FCL does not call touching
_ANY_CONTACT = fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)


class FclChecker(CollisionChecker):
    """Shapes are built once and moved where they are asked about; pairs are, whose boxes are not clearly apart."""

    name = "fcl"

    def __init__(self, world: World, known: FclChecker | None = None) -> None:
        self.world, self._alone = world, threading.Lock()
        self.chain = Chain.of(world.robot)
        self.bound = ClearanceBound(world, known.bound if known else None)
        self.queries = 0
        self.second = known.second if known else []
        self._place = fcl.Transform()  # one for all: making each anew takes as long as what FCL does with it
        self._objects: dict[int, fcl.CollisionObject] = {}  # of items by their number, those that were asked about

    @cached_property
    def _boxes(self) -> Boxes:
        return Boxes(self.world)

    def make_ready(self) -> None:
        """See :class:`planner.collision.checker.CollisionChecker`; nothing may be near where the joints are at 0."""
        with self._alone:
            for k in range(len(self.world.items)):
                self._object(k)
        super().make_ready()

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
        self.queries += len(q)
        first = self._first_touching if self.world.margin <= 0 else self._first_within_margin
        with self._alone:
            for rows, pairs in self._boxes.near(rotation, position, self.world.margin):
                found = first(rotation, position, rows, pairs)
                if found is not None:
                    return found[0], self.world.contact(found[1])
        return None

    def _first_touching(self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints) -> tuple[int, int] | None:
        """The first of the ``pairs`` in configurations ``rows``, (k,) each, that touches."""
        for row, pair in zip(rows.tolist(), pairs.tolist(), strict=True):
            if self._touches(pair, rotation[:, row], position[:, row]):
                return row, pair
        return None

    def _first_within_margin(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints
    ) -> tuple[int, int] | None:
        """The nearest pair in the first of the configurations ``rows`` in which one is within the margin."""
        enough = self.world.margin * (1 + 1e-12)
        starts = np.flatnonzero(np.diff(rows, prepend=-1))  # of each configuration's pairs
        ends = starts[2 ** np.arange(1, len(starts).bit_length()) - 1]  # one, two, four ... of them at a time
        for some in np.split(np.arange(len(rows)), ends):
            gaps = self._gaps(rotation, position, rows[some], pairs[some], 2.0 * enough)  # a bound of more is no gap
            near = np.flatnonzero(gaps <= enough)
            if len(near):
                at = near[rows[some[near]] == rows[some[near[0]]]]
                nearest = some[at[np.maximum(gaps[at], 0.0).argmin()]]
                return int(rows[nearest]), int(pairs[nearest])
        return None

    def distances_in(self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints) -> Floats:
        """See :class:`planner.collision.checker.CollisionChecker`: FCL says what touches, planes how far apart.

        No distance that FCL reports can be used as it is. Its GJK stops early: 20 mm where 0.7 mm were left between
        boxes, 2.14 m where 0.62 m were left between two triangles with parallel sides.
        """
        with self._alone:
            self.queries += len(pairs)
            return self._gaps(rotation, position, rows, pairs)

    def _gaps(self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: float = np.inf) -> Floats:
        gaps = self.bound.close(rotation, position, rows, pairs, enough)
        for k in np.flatnonzero(gaps <= 0.0).tolist():
            if self.world.rounding[pairs[k]] == 0:
                touches = self._touches(int(pairs[k]), rotation[:, rows[k]], position[:, rows[k]])
                gaps[k] = -1.0 if touches else _APART
        return gaps

    def _touches(self, pair: int, rotation: Floats, position: Floats) -> bool:
        first, second = (self._placed(k, rotation, position) for k in self.world.items_of(pair))
        return bool(fcl.collide(first, second, _ANY_CONTACT, fcl.CollisionResult()))

    def _placed(self, k: int, rotation: Floats, position: Floats) -> fcl.CollisionObject:
        """An item by its number: a body where the joints are, an obstacle where it stands."""
        made = self._object(k)
        if k < len(self.world.bodies):
            body = self.world.bodies[k]
            turn = rotation[body.joint]
            self._place.setRotation(turn @ body.placement[:3, :3])
            self._place.setTranslation(position[body.joint] + turn @ body.placement[:3, 3])
            made.setTransform(self._place)
        return made

    def _object(self, k: int) -> fcl.CollisionObject:
        """An item by its number, made once: an obstacle where it stands, a body anywhere."""
        if k not in self._objects:
            item = self.world.items[k]
            place = fcl.Transform(item.placement[:3, :3], item.placement[:3, 3])
            self._objects[k] = fcl.CollisionObject(_geometry(item.shape), place)
        return self._objects[k]

    def error(self, distance: float) -> float:
        # planes prove the distances, formulas are exact: in 30,000 attacked pairs, some a kilometre from the origin, no
        # more than 4e-13 m, see `python -m benchmarks attack`; a micrometre leaves room for rounding farther away
        return 1e-6


@lru_cache(maxsize=1024)  # nothing changes them, and trees of triangles take time
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
