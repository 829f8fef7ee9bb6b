"""The robot's bodies, the obstacles, and the pairs to check."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.constraints.path_constraints import PathConstraints
from planner.problem.conditions import Condition
from planner.robot.reach import Reach, pair_reach
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Body, Mesh, Obstacle


@dataclass(frozen=True)
class Contact:
    """A pair in contact or within the margin; the first is always a link of the robot.

    ``enclosed``: one lies wholly inside the other, a closed mesh, without contact of surfaces.
    """

    first: str
    second: str
    enclosed: bool = False

    def __str__(self) -> str:
        return f"'{self.first}' and '{self.second}'"

    def how(self, margin: float) -> str:
        """Return the predicate of a message after both names; ``margin`` is in metres."""
        if self.enclosed:
            return "lie one wholly inside the other, a closed mesh"
        return f"are closer than the margin of {margin:g} m" if margin else "touch"


@dataclass(frozen=True, eq=False)
class World:
    """A robot among obstacles, with one numbering of all pairs.

    Pairs 0 .. B O - 1 are body b and obstacle o (number b O + o); self-collision pairs follow. ``checked`` selects
    scene pairs. A configuration is free if every checked pair is farther apart than ``margin`` (m). ``conditions`` are
    the path constraints, see :class:`planner.constraints.path_constraints.PathConstraints`; ``disabled`` are link pairs
    without a check.
    """

    robot: Robot
    scene: Scene
    self_pairs: Ints  # (P, 2) indices into bodies
    checked: Bools  # (B, O)
    margin: float = 0.0
    conditions: tuple[Condition, ...] = ()
    disabled: frozenset[frozenset[str]] = frozenset()

    @staticmethod
    def from_scene(
        robot: Robot,
        scene: Scene,
        disabled: frozenset[frozenset[str]],
        margin: float = 0.0,
        conditions: tuple[Condition, ...] = (),
    ) -> World:
        """Return the world of a scene's obstacles and a robot, with all pairs that nothing permits to touch.

        Self-collision pairs in ``disabled`` (by link), the scene's permissions and those of the payload are left out.
        """
        checked = np.ones((len(robot.bodies), len(scene.obstacles)), dtype=bool)
        objects = {item.name: item.object for item in scene.carried}
        names = [objects.get(body.link, body.link) for body in robot.bodies]
        for i, k in np.ndindex(*checked.shape) if scene.allowed else ():
            checked[i, k] = frozenset((names[i], scene.obstacles[k].object)) not in scene.allowed
        own = _self_pairs(robot, disabled | robot.touching)
        return World(robot, scene, own, frozen(checked, np.bool_), margin, conditions, disabled)

    def among(self, scene: Scene, robot: Robot) -> World:
        """Return the world with another ``scene`` and a ``robot`` with another payload."""
        return World.from_scene(robot, scene, self.disabled, self.margin, self.conditions)

    def only(self, pairs: Bools) -> World:
        """Return the world restricted to ``pairs`` (pairs,), without obstacles that none of them needs."""
        scene = self.checked & pairs[: self.checked.size].reshape(self.checked.shape)
        touched = np.flatnonzero(scene.any(axis=0))
        return replace(
            self,
            scene=replace(self.scene, obstacles=tuple(self.obstacles[k] for k in touched)),
            self_pairs=frozen(self.self_pairs[pairs[self.checked.size :]], np.int64),
            checked=frozen(scene[:, touched], np.bool_),
        )

    def without(self, pairs: Bools) -> World:
        """Return the world without a check of scene ``pairs`` (bodies, obstacles)."""
        world = replace(self, checked=frozen(self.checked & ~pairs, np.bool_))
        vars(world).update(reach=self.reach, pair_reach=self.pair_reach, moving=self.moving)  # whatever is checked
        return world

    def with_placements(self, scene: Scene) -> World:
        """Return the world with the obstacle placements of ``scene``, which has the same shapes."""
        world = replace(self, scene=scene)
        vars(world).update(pair_reach=self.pair_reach, moving=self.moving)  # of the robot, wherever they stand
        return world

    def with_extra_margin(self, clearance: float) -> World:
        """Return the world with ``clearance`` (m) more margin, without pairs that no joint moves."""
        moving = self.moving
        scene, own = moving[: self.checked.size], moving[self.checked.size :]
        world = replace(
            self,
            checked=frozen(self.checked & scene.reshape(self.checked.shape), np.bool_),
            self_pairs=frozen(self.self_pairs[own], np.int64),
            margin=self.margin + clearance,
        )
        left = np.append(np.ones(scene.size, dtype=bool), own)
        vars(world).update(reach=self.reach, pair_reach=self.pair_reach[left])  # of the robot, whatever the margin
        return world

    @cached_property
    def constraints(self) -> PathConstraints:
        """``conditions`` on this robot."""
        return PathConstraints(self.robot, self.conditions)

    @cached_property
    def moving(self) -> Bools:
        """Mask (pairs,) of the pairs that a joint moves."""
        return np.any(self.pair_reach, axis=1)

    @property
    def bodies(self) -> tuple[Body, ...]:
        return self.robot.bodies

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        return self.scene.obstacles

    @cached_property
    def items(self) -> tuple[Body | Obstacle, ...]:
        """Bodies, then obstacles."""
        return (*self.bodies, *self.obstacles)

    @cached_property
    def reach(self) -> Reach:
        return Reach.from_robot(self.robot)

    @cached_property
    def pair_reach(self) -> Floats:
        """(pairs, joints) m: largest change of a pair's distance per unit of each joint."""
        scene = np.repeat(self.reach.bodies, len(self.obstacles), axis=0)
        own = [pair_reach(self.robot, self.bodies[i], self.bodies[k]) for i, k in self.self_pairs.tolist()]
        return np.vstack([scene, np.reshape(own, (len(own), scene.shape[1]))])

    @cached_property
    def rounding(self) -> Floats:
        """(pairs,) m: sum of the mesh radii, by which simplified meshes are closer than their triangles."""
        radii = np.array([item.shape.radius if isinstance(item.shape, Mesh) else 0.0 for item in self.items])
        count = len(self.bodies)
        scene = (radii[:count, None] + radii[None, count:]).ravel()
        return np.concatenate([scene, radii[self.self_pairs].sum(axis=1)])

    def members(self, pair: int) -> tuple[int, int]:
        """Return (body, obstacle) of a scene pair, else (body, body)."""
        scene = len(self.bodies) * len(self.obstacles)
        if pair < scene:
            return divmod(pair, len(self.obstacles))
        first, second = self.self_pairs[pair - scene]
        return int(first), int(second)

    def items_of(self, pair: int) -> tuple[int, int]:
        """Return the numbers of a pair's two members among ``items``."""
        first, second = self.members(pair)
        return first, second + len(self.bodies) * self.is_scene_pair(pair)

    def is_scene_pair(self, pair: int) -> bool:
        return pair < len(self.bodies) * len(self.obstacles)

    def contact(self, pair: int) -> Contact:
        """Return the names of a pair: links of the robot, obstacles of the scene."""
        first, second = self.members(pair)
        name = self.obstacles[second].name if self.is_scene_pair(pair) else self.bodies[second].link
        return Contact(self.bodies[first].link, name)


@lru_cache(maxsize=16)
def _self_pairs(robot: Robot, disabled: frozenset[frozenset[str]]) -> Ints:
    """Return the self-collision pairs, cached because worlds that change keep their robot."""
    pairs = [
        (i, k)
        for k, second in enumerate(robot.bodies)
        for i, first in enumerate(robot.bodies[:k])
        if first.joint != second.joint and frozenset((first.link, second.link)) not in disabled
    ]
    return frozen(np.array(pairs, dtype=np.int64).reshape(-1, 2), np.int64)
