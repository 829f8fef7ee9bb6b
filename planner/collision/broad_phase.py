"""Pinocchio's broadphase for a world; worlds with similar obstacles share its groups."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Mapping, Sequence
from functools import cache, cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, Ints
from planner.base.captured_output import PROCESS
from planner.collision.world import World
from planner.kinematics.forward import Chain
from planner.native.compiled import threads
from planner.robot.poses import se3
from planner.robot.shapes import Obstacle

_WORTH_THREADS = 2048  # states: for fewer, managers for every thread take longer to make than they save
_MOST_THREADS = 8  # each has a copy of the geometry
_GROUP_SIZE = 250  # obstacles: Pinocchio adds a shape in a time that grows with the square of those that are there
_SMALL, _MOST_SMALL = _GROUP_SIZE // 2, 4  # obstacles of a part that is small; of those a world has no more
_MOST_MISSING = 32  # obstacles: a group with more missing is rebuilt
_FAR = pin.SE3(np.eye(3), np.array([0.0, 0.0, -1e6]))  # m: where obstacles are that are gone


class BroadPhase:
    """Broadphase managers of a world, shared between worlds that differ in obstacle placements only.

    Creating every pair is slow (half a second for a thousand obstacles); moving obstacles is not. Worlds with many
    obstacles are divided into groups, and a new world reuses the groups that still fit.
    """

    def __init__(self, world: World, shapes: Sequence[Any], known: BroadPhase | None) -> None:
        """Build the groups that ``known``, the broadphase of a world with the same arm, lacks."""
        self._views = [] if known is None else _reuse_views(known._views, world)
        seen = np.zeros(len(world.obstacles), dtype=bool)
        for view in self._views:
            seen[view.numbers[view.numbers >= 0]] = True
        left = np.flatnonzero(world.checked.any(axis=0) & ~seen)
        own = not any(view.part.own for view in self._views)
        if len(left) or own:
            groups = np.split(left, range(_GROUP_SIZE, len(left), _GROUP_SIZE))
            new = (_ObstacleGroup(world, shapes, group, own and k == 0) for k, group in enumerate(groups))
            self._views += [_View(part, world, group) for part, group in zip(new, groups, strict=True)]
        self._views = [view for view in self._views if len(view.pairs)]

    def first_touch(self, world: World, q: Floats) -> tuple[int, int] | None:
        """Return the first of (n, dof) configurations with a contact, and its lowest pair; else None."""
        hits = np.flatnonzero(self.touching(world, q))
        if not len(hits):
            return None
        pairs = np.concatenate([view.touching_pairs(world, q[hits[0]]) for view in self._views])
        return int(hits[0]), int(pairs.min())

    def touching(self, world: World, q: Floats, extra: Floats | None = None) -> Bools:
        """Return which configurations (n,) bring a pair within the margin plus ``extra`` (pairs,) m."""
        touching = np.zeros(len(q), dtype=bool)
        margins = world.margin + world.rounding + (0.0 if extra is None else extra)
        for view in self._views:
            free = np.flatnonzero(~touching)
            if not len(free):
                break
            touching[free] = view.touching(world, q[free], margins)
        return touching


class LazyBroadPhase:
    """Broadphase that is built on first use: many checkers only compute bounds."""

    def __init__(self, world: World, shapes: Sequence[Any], known: LazyBroadPhase | None) -> None:
        if known is not None and known._phase is None:
            known = known._known  # else unused worlds would keep each other alive
        self._alone, self._known = threading.Lock(), known
        self._phase: BroadPhase | None = None
        self._world, self._shapes = world, shapes

    @property
    def phase(self) -> BroadPhase:
        """The broadphase, built on first access."""
        with self._alone:
            if self._phase is None:
                self._phase = BroadPhase(self._world, self._shapes, self._known and self._known._phase)
                self._known = None
            return self._phase


class _ObstacleGroup:
    """Bodies and a group of obstacles in Pinocchio's broadphase; one thread uses it at a time.

    ``rows`` (pairs, 2): a body and an obstacle of the group, or -1 and a self-collision pair (if ``own``).
    """

    def __init__(self, world: World, shapes: Sequence[Any], obstacles: Ints, own: bool) -> None:
        self.alone, self.own, self._bodies = threading.Lock(), own, len(world.bodies)
        geometry, self.rows = extract_geometry(world, shapes, obstacles, own)
        self.placed: list[Obstacle | None] = [world.obstacles[k] for k in obstacles]
        pairs = _pair_numbers(self.rows, world, obstacles)
        self.pool = Pool(
            world.robot.model, geometry, world.margin + world.rounding[pairs], min(threads(), _MOST_THREADS)
        )

    def place(self, row: int, obstacle: Obstacle | None) -> None:
        """Move the obstacle in ``row`` to its placement in another world; far away if absent there."""
        placement = _FAR if obstacle is None else se3(obstacle.placement)
        for model in self.pool.models:
            model.geometryObjects[self._bodies + row].placement = placement
        self.placed[row] = obstacle


class _View:
    """A group as one world numbers it; obstacles and pairs that the world lacks are -1."""

    def __init__(self, part: _ObstacleGroup, world: World, numbers: Ints) -> None:
        self.part, self.numbers, self.pairs = part, numbers, _pair_numbers(part.rows, world, numbers)
        self.of = [(world.obstacles[k], world.checked[:, k]) if k >= 0 else None for k in numbers]

    def elsewhere(self, world: World, place: Mapping[str, int]) -> _View:
        """Return the view of ``world``; ``place`` maps obstacle names to numbers in it."""
        numbers, last = np.full(len(self.of), -1), -1
        for row, known in enumerate(self.of):
            if known is None or (k := place.get(known[0].name, -1)) <= last:
                continue
            if known[0].shape == world.obstacles[k].shape and np.array_equal(known[1], world.checked[:, k]):
                numbers[row] = last = k
        return _View(self.part, world, numbers)

    def touching(self, world: World, q: Floats, margins: Floats) -> Bools:
        """Return which configurations (n,) bring a pair within its entry of ``margins`` (pairs,) m."""
        with self.part.alone:
            self._place(world)
            q = Chain.from_arm(world.robot).values(q)
            return self.part.pool.touching(q, np.where(self.pairs >= 0, margins[self.pairs], 0.0))

    def touching_pairs(self, world: World, q: Floats) -> Ints:
        """Return the numbers of the pairs in contact at a configuration (dof,)."""
        with self.part.alone:
            self._place(world)
            return self.pairs[self.part.pool.touching_rows(Chain.from_arm(world.robot).values(q))]

    def _place(self, world: World) -> None:
        for row, k in enumerate(self.numbers.tolist()):
            obstacle = world.obstacles[k] if k >= 0 else None
            if obstacle is not self.part.placed[row]:
                self.part.place(row, obstacle)


def _reuse_views(views: Sequence[_View], world: World) -> list[_View]:
    """Return the views that ``world`` can reuse: few missing obstacles, and few small groups."""
    if len(world.obstacles) <= _GROUP_SIZE:
        return []  # building is as fast
    place = {obstacle.name: k for k, obstacle in enumerate(world.obstacles)}
    candidates = [view.elsewhere(world, place) for view in views]
    lacking = [int((view.numbers < 0).sum()) for view in candidates]
    reusable = [view for view, gone in zip(candidates, lacking, strict=True) if gone <= _MOST_MISSING]
    small = [view for view in reusable if len(view.numbers) < _SMALL and not view.part.own]
    return reusable if len(small) <= _MOST_SMALL else [view for view in reusable if view not in small]


class Pool:
    """A robot's geometry in Pinocchio's broadphase, for batches on threads and for single states.

    ``models`` lists every copy of the geometry. Managers are built on demand; one thread uses a pool at a time.
    """

    def __init__(self, robot: pin.Model, geometry: pin.GeometryModel, margins: Floats, threads: int) -> None:
        """Store the default ``margins`` (pairs,) m: a closer pair is in contact."""
        self._robot, self._margins, self._threads = robot, margins, threads
        self._managers: dict[int, _Managers] = {}  # by their number of threads
        self.models = [geometry]

    def touching(self, q: Floats, margins: Floats) -> Bools:
        """Return which configurations (n, nq) bring a pair within ``margins`` (pairs,) m."""
        threads = self._threads if len(q) >= _WORTH_THREADS else 1
        if threads not in self._managers:
            self._managers[threads] = _Managers(self._robot, self.models[0], margins, threads)
            self.models += self._managers[threads].models
        return self._managers[threads].touching(q, margins)

    def touching_rows(self, q: Floats) -> Ints:
        """Return the rows of the pairs in contact at a configuration (nq,), with the default margins."""
        kinematics, data = self._single_state
        pin.computeCollisions(self._robot, kinematics, self.models[0], data, q, False)
        return np.array([k for k, result in enumerate(data.collisionResults) if result.isCollision()], dtype=np.int64)

    @cached_property
    def _single_state(self) -> tuple[pin.Data, pin.GeometryData]:
        data = pin.GeometryData(self.models[0])
        _set_margins(_make_requests([data]), self._margins)
        return self._robot.createData(), data


class _Managers:
    """Broadphase managers, one per thread, with their geometry ``models``."""

    def __init__(self, robot: pin.Model, geometry: pin.GeometryModel, margins: Floats, threads: int) -> None:
        self._threads, self._margins = threads, margins
        self._pool = pin.BroadPhaseManagerPool_DynamicAABBTreeCollisionManager(robot, geometry, threads)
        self.models = [manager.getGeometryModel() for manager in self._pool.getBroadPhaseManagers()]
        self._requests = _make_requests(self._pool.getGeometryDatas())
        _set_margins(self._requests, margins)

    def touching(self, q: Floats, margins: Floats) -> Bools:
        """See :meth:`Pool.touching`."""
        if not np.array_equal(margins, self._margins):
            _set_margins(self._requests, margins)
            self._margins = margins
        hits = pin.computeCollisionsInParallel(self._threads, self._pool, np.asfortranarray(q.T), True, False)
        return np.asarray(hits).ravel().astype(bool)


def _make_requests(geometries: Sequence[pin.GeometryData]) -> list[list[Any]]:
    """Replace and return the collision requests of every pair; valid while the data exist."""
    for data in geometries:
        if len(data.collisionRequests):
            requests = type(data.collisionRequests)()
            requests.extend([make_request(type(data.collisionRequests[0]))] * len(data.collisionRequests))
            data.collisionRequests = requests
    return [list(data.collisionRequests) for data in geometries]


@cache
def make_request(kind: type) -> Any:
    """Return a collision request with safe settings and no margin.

    Without contacts coal leaves the penetration open: it called a capsule 25 mm inside a box free when its axis was
    within 1e-6 m of the surface. With a cached GJK guess, verdicts within 1e-6 m of contact depend on earlier queries.
    """
    request = kind()
    request.enable_contact = True
    with PROCESS, warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the flag that coal names instead does not undo this one
        request.enable_cached_gjk_guess = False
    return request


def _set_margins(requests: Sequence[Sequence[Any]], margins: Floats) -> None:
    """Set the distance (pairs,) m below which each pair counts as a contact."""
    for of_pairs in requests:
        for request, margin in zip(of_pairs, margins.tolist(), strict=True):
            request.security_margin = margin


def _pair_numbers(rows: Ints, world: World, obstacles: Ints) -> Ints:
    """Return the numbers (pairs,) in ``world`` of a group's pairs; ``obstacles`` (k,) has -1 if absent."""
    if not len(rows):
        return np.zeros(0, dtype=np.int64)
    of = np.append(obstacles, 0)[rows[:, 1] * (rows[:, 0] >= 0)]
    scene = np.where(of >= 0, rows[:, 0] * len(world.obstacles) + of, -1)
    return np.where(rows[:, 0] >= 0, scene, world.checked.size + rows[:, 1])


def extract_geometry(world: World, shapes: Sequence[Any], obstacles: Ints, own: bool) -> tuple[pin.GeometryModel, Ints]:
    """Return Pinocchio's geometry of bodies and some obstacles, and the group's pairs.

    ``shapes`` are those of all items; ``own`` includes the self-collision pairs. The pairs are the rows of an
    :class:`_ObstacleGroup`.
    """
    model, count = pin.GeometryModel(), len(world.bodies)
    for k in [*range(count), *(count + obstacles).tolist()]:
        item, joint = world.items[k], world.bodies[k].joint if k < count else 0
        model.addGeometryObject(pin.GeometryObject(f"{k}", joint, se3(item.placement), shapes[k]))
    number = np.full((model.ngeoms, model.ngeoms), -1)
    number[:count, count:][world.checked[:, obstacles]] = 0
    if own:
        number[world.self_pairs[:, 0], world.self_pairs[:, 1]] = np.arange(len(world.self_pairs))
    model.setCollisionPairs(number >= 0)  # in this order
    first, second = np.nonzero(number >= 0)
    of_obstacle = second >= count
    rows = np.where(of_obstacle, first, -1), np.where(of_obstacle, second - count, number[first, second])
    return model, np.stack(rows, axis=1)


def has_same_arm(one: World, other: World) -> bool:
    """Return whether two worlds differ at most in their obstacles."""
    return (
        one.margin == other.margin
        and one.robot.model is other.robot.model
        and one.bodies == other.bodies
        and np.array_equal(one.self_pairs, other.self_pairs)
    )


def has_same_shapes(one: World, other: World) -> bool:
    """Return whether two worlds of one arm differ at most in obstacle placements."""
    shapes = [[item.shape for item in world.obstacles] for world in (one, other)]
    return shapes[0] == shapes[1] and np.array_equal(one.checked, other.checked)
