"""A world as Pinocchio's broadphase takes it, in parts that worlds share whose obstacles differ a little."""

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
_TOGETHER = 250  # obstacles: Pinocchio adds a shape in a time that grows with the square of those that are there
_SMALL, _MOST_SMALL = _TOGETHER // 2, 4  # obstacles of a part that is small; of those a world has no more
_MOST_GONE = 32  # obstacles: a part that lacks more is made anew
_FAR = pin.SE3(np.eye(3), np.array([0.0, 0.0, -1e6]))  # m: where obstacles are that are gone


class BroadPhase:
    """Pinocchio's managers of a world, which worlds share whose obstacles differ in their places only.

    What takes time is every pair, not where it stands: with a thousand obstacles half a second. Among many obstacles
    worlds that differ in some share the parts of the others.
    """

    def __init__(self, world: World, shapes: Sequence[Any], known: BroadPhase | None) -> None:
        """``known``: of a world with the same arm."""
        self._views = [] if known is None else _kept(known._views, world)
        seen = np.zeros(len(world.obstacles), dtype=bool)
        for view in self._views:
            seen[view.numbers[view.numbers >= 0]] = True
        left = np.flatnonzero(world.checked.any(axis=0) & ~seen)
        own = not any(view.part.own for view in self._views)
        if len(left) or own:
            groups = np.split(left, range(_TOGETHER, len(left), _TOGETHER))
            made = (_Part(world, shapes, group, own and k == 0) for k, group in enumerate(groups))
            self._views += [_View(part, world, group) for part, group in zip(made, groups, strict=True)]
        self._views = [view for view in self._views if len(view.pairs)]

    def first_touch(self, world: World, q: Floats) -> tuple[int, int] | None:
        """The first of the configurations (n, dof) that touches something in ``world``, and the first such pair."""
        hits = np.flatnonzero(self.touching(world, q))
        if not len(hits):
            return None
        pairs = np.concatenate([view.touching_pairs(world, q[hits[0]]) for view in self._views])
        return int(hits[0]), int(pairs.min())

    def touching(self, world: World, q: Floats, extra: Floats | None = None) -> Bools:
        """(n,) which configurations touch something, or come as near as the margin and ``extra`` (pairs,) m."""
        touching = np.zeros(len(q), dtype=bool)
        margins = world.margin + world.rounding + (0.0 if extra is None else extra)
        for view in self._views:
            free = np.flatnonzero(~touching)
            if not len(free):
                break
            touching[free] = view.touching(world, q[free], margins)
        return touching


class LazyBroadPhase:
    """The broadphase of a world, made when it is first asked: many a checker is made for its bounds alone."""

    def __init__(self, world: World, shapes: Sequence[Any], known: LazyBroadPhase | None) -> None:
        """``known``: of a world with the same arm."""
        if known is not None and known._made is None:
            known = known._known  # else a row of worlds that nobody asks would hold each other
        self._alone, self._known = threading.Lock(), known
        self._made: BroadPhase | None = None
        self._world, self._shapes = world, shapes

    @property
    def phase(self) -> BroadPhase:
        """The broadphase."""
        with self._alone:
            if self._made is None:
                self._made = BroadPhase(self._world, self._shapes, self._known and self._known._made)
                self._known = None
            return self._made


class _Part:
    """Bodies and some obstacles as Pinocchio's broadphase takes them: a pool for batches, and where all stand.

    ``rows`` (pairs, 2): a body and one of its obstacles, or -1 and a pair of bodies (``own``). Threads ask one after
    the other.
    """

    def __init__(self, world: World, shapes: Sequence[Any], obstacles: Ints, own: bool) -> None:
        self.alone, self.own, self._bodies = threading.Lock(), own, len(world.bodies)
        geometry, self.rows = extract_geometry(world, shapes, obstacles, own)
        self.placed: list[Obstacle | None] = [world.obstacles[k] for k in obstacles]
        pairs = _numbers(self.rows, world, obstacles)
        self.pool = Pool(
            world.robot.model, geometry, world.margin + world.rounding[pairs], min(threads(), _MOST_THREADS)
        )

    def place(self, row: int, obstacle: Obstacle | None) -> None:
        """Let the obstacle in a ``row`` stand where it stands in another world; far away where it is not there."""
        placement = _FAR if obstacle is None else se3(obstacle.placement)
        for model in self.pool.models:
            model.geometryObjects[self._bodies + row].placement = placement
        self.placed[row] = obstacle


class _View:
    """A part as worlds see it: ``numbers`` of its obstacles there, -1 for those that are gone, and of its ``pairs``."""

    def __init__(self, part: _Part, world: World, numbers: Ints) -> None:
        self.part, self.numbers, self.pairs = part, numbers, _numbers(part.rows, world, numbers)
        self.of = [(world.obstacles[k], world.checked[:, k]) if k >= 0 else None for k in numbers]

    def elsewhere(self, world: World, place: Mapping[str, int]) -> _View:
        """The view of a world with some of these obstacles, in their order, by name at their ``place`` in it."""
        numbers, last = np.full(len(self.of), -1), -1
        for row, known in enumerate(self.of):
            if known is None or (k := place.get(known[0].name, -1)) <= last:
                continue
            if known[0].shape == world.obstacles[k].shape and np.array_equal(known[1], world.checked[:, k]):
                numbers[row] = last = k
        return _View(self.part, world, numbers)

    def touching(self, world: World, q: Floats, margins: Floats) -> Bools:
        """(n,) which configurations (n, dof) bring a pair as near as its margin, of all ``margins`` (pairs,) m."""
        with self.part.alone:
            self._place(world)
            q = Chain.from_arm(world.robot).values(q)
            return self.part.pool.touching(q, np.where(self.pairs >= 0, margins[self.pairs], 0.0))

    def touching_pairs(self, world: World, q: Floats) -> Ints:
        """The numbers of the pairs that touch at a configuration (dof,)."""
        with self.part.alone:
            self._place(world)
            return self.pairs[self.part.pool.touching_rows(Chain.from_arm(world.robot).values(q))]

    def _place(self, world: World) -> None:
        for row, k in enumerate(self.numbers.tolist()):
            obstacle = world.obstacles[k] if k >= 0 else None
            if obstacle is not self.part.placed[row]:
                self.part.place(row, obstacle)


def _kept(views: Sequence[_View], world: World) -> list[_View]:
    """What of a broadphase another ``world`` takes over: parts that lack little, and not many that are small."""
    if len(world.obstacles) <= _TOGETHER:
        return []  # made anew as quickly
    place = {obstacle.name: k for k, obstacle in enumerate(world.obstacles)}
    found = [view.elsewhere(world, place) for view in views]
    lacking = [int((view.numbers < 0).sum()) for view in found]
    kept = [view for view, gone in zip(found, lacking, strict=True) if gone <= _MOST_GONE]
    small = [view for view in kept if len(view.numbers) < _SMALL and not view.part.own]
    return kept if len(small) <= _MOST_SMALL else [view for view in kept if view not in small]


class Pool:
    """A robot's geometry as Pinocchio's broadphase takes it: for batches, long ones on threads, and for one state.

    ``models``: every copy of the geometry that the broadphase keeps. What nobody asks for is not made. Stateful inside:
    one thread asks at a time.
    """

    def __init__(self, robot: pin.Model, geometry: pin.GeometryModel, margins: Floats, threads: int) -> None:
        """``margins`` (pairs,) m: what comes closer touches."""
        self._robot, self._margins, self._threads = robot, margins, threads
        self._managers: dict[int, _Managers] = {}  # by their number of threads
        self.models = [geometry]

    def touching(self, q: Floats, margins: Floats) -> Bools:
        """(n,) which configurations (n, nq) bring a pair as near as these ``margins`` (pairs,) m."""
        threads = self._threads if len(q) >= _WORTH_THREADS else 1
        if threads not in self._managers:
            self._managers[threads] = _Managers(self._robot, self.models[0], margins, threads)
            self.models += self._managers[threads].models
        return self._managers[threads].touching(q, margins)

    def touching_rows(self, q: Floats) -> Ints:
        """The rows of the pairs that touch at a configuration (nq,), by the margins that it was made with."""
        kinematics, data = self._of_one
        pin.computeCollisions(self._robot, kinematics, self.models[0], data, q, False)
        return np.array([k for k, result in enumerate(data.collisionResults) if result.isCollision()], dtype=np.int64)

    @cached_property
    def _of_one(self) -> tuple[pin.Data, pin.GeometryData]:
        data = pin.GeometryData(self.models[0])
        _keep(_settled([data]), self._margins)
        return self._robot.createData(), data


class _Managers:
    """Pinocchio's broadphase managers, one for each of some threads, and the geometry ``models`` of theirs."""

    def __init__(self, robot: pin.Model, geometry: pin.GeometryModel, margins: Floats, threads: int) -> None:
        self._threads, self._margins = threads, margins
        self._pool = pin.BroadPhaseManagerPool_DynamicAABBTreeCollisionManager(robot, geometry, threads)
        self.models = [manager.getGeometryModel() for manager in self._pool.getBroadPhaseManagers()]
        self._requests = _settled(self._pool.getGeometryDatas())
        _keep(self._requests, margins)

    def touching(self, q: Floats, margins: Floats) -> Bools:
        """See :meth:`Pool.touching`."""
        if not np.array_equal(margins, self._margins):
            _keep(self._requests, margins)
            self._margins = margins
        hits = pin.computeCollisionsInParallel(self._threads, self._pool, np.asfortranarray(q.T), True, False)
        return np.asarray(hits).ravel().astype(bool)


def _settled(geometries: Sequence[pin.GeometryData]) -> list[list[Any]]:
    """What coal is asked about every pair, once for each geometry; valid as long as that is there.

    With settings without which a verdict could be wrong, or depend on earlier questions.
    """
    for data in geometries:
        if len(data.collisionRequests):
            asked = type(data.collisionRequests)()
            asked.extend([_question(type(data.collisionRequests[0]))] * len(data.collisionRequests))
            data.collisionRequests = asked
    return [list(data.collisionRequests) for data in geometries]


@cache
def _question(kind: type) -> Any:
    """A question as it has to be put, without a margin.

    Without contacts coal leaves the penetration open, and called a capsule 25 mm inside a box free whose axis lay
    within 1e-6 m of the box's surface. And Pinocchio begins every GJK where the last one ended: within 1e-6 m of a
    contact the verdict then depends on earlier questions.
    """
    request = kind()
    request.enable_contact = True
    with PROCESS, warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the flag that coal names instead does not undo this one
        request.enable_cached_gjk_guess = False
    return request


def _keep(requests: Sequence[Sequence[Any]], margins: Floats) -> None:
    """Let pairs that come closer than their ``margins`` (pairs,) m count as a contact."""
    for of_pairs in requests:
        for request, margin in zip(of_pairs, margins.tolist(), strict=True):
            request.security_margin = margin


def _numbers(rows: Ints, world: World, obstacles: Ints) -> Ints:
    """The numbers (pairs,) in a world of a part's pairs; ``obstacles`` (k,) are the numbers of its own, -1 if gone."""
    if not len(rows):
        return np.zeros(0, dtype=np.int64)
    of = np.append(obstacles, 0)[rows[:, 1] * (rows[:, 0] >= 0)]
    scene = np.where(of >= 0, rows[:, 0] * len(world.obstacles) + of, -1)
    return np.where(rows[:, 0] >= 0, scene, world.checked.size + rows[:, 1])


def extract_geometry(world: World, shapes: Sequence[Any], obstacles: Ints, own: bool) -> tuple[pin.GeometryModel, Ints]:
    """Pinocchio's geometry of the bodies and some obstacles, and the rows (pairs, 2) of a :class:`_Part`.

    ``shapes`` of all items; ``own``: with the pairs of bodies.
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
    """Whether two worlds differ in obstacles at most."""
    return (
        one.margin == other.margin
        and one.robot.model is other.robot.model
        and one.bodies == other.bodies
        and np.array_equal(one.self_pairs, other.self_pairs)
    )


def has_same_shapes(one: World, other: World) -> bool:
    """Whether all is the same in two worlds of one arm but where obstacles stand."""
    shapes = [[item.shape for item in world.obstacles] for world in (one, other)]
    return shapes[0] == shapes[1] and np.array_equal(one.checked, other.checked)
