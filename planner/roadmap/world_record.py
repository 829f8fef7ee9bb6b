"""What a roadmap remembers of the world it was proven in: enough to say later what has changed, and what that touches.

The world itself is not kept, only hashes of its parts: a body or an obstacle is the same if its shape and its
placement are the same to the bit, whatever it is called.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from functools import lru_cache

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.base.hashing import content_hash
from planner.base.records import dataclass
from planner.collision.world import World
from planner.kinematics.forward import Chain
from planner.models.shapes import Body


@dataclass(frozen=True)
class BodyRecord:
    """A body of the robot; ``content`` hashes its shape, its joint and its placement there."""

    name: str
    link: str
    content: str


@dataclass(frozen=True)
class ObstacleRecord:
    """An obstacle; ``shape`` and ``placement`` are hashes, ``unchecked`` the links that were allowed to touch it."""

    name: str
    shape: str
    placement: str
    unchecked: tuple[str, ...]


@dataclass(frozen=True)
class WorldRecord:
    """A world in short. ``kinematics`` hashes where a configuration puts the joints; limits in rad (m)."""

    kinematics: str
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    held: Mapping[str, float]  # joints that are not planned, rad (m)
    bodies: tuple[BodyRecord, ...]
    self_pairs: tuple[tuple[int, int], ...]  # of indices into bodies
    obstacles: tuple[ObstacleRecord, ...]


def record_of(world: World) -> WorldRecord:
    """The record of the world that a roadmap is being proven in."""
    chain, robot = Chain.of(world.robot), world.robot
    return WorldRecord(
        kinematics=_kinematics(chain),
        lower=tuple(robot.lower.tolist()),
        upper=tuple(robot.upper.tolist()),
        held=dict(robot.fixed_joints),
        bodies=tuple(_body_record(body) for body in world.bodies),
        self_pairs=tuple((i, k) for i, k in world.self_pairs.tolist()),
        obstacles=tuple(
            ObstacleRecord(
                name=item.name,
                shape=content_hash(item.shape.content()),
                placement=content_hash([item.placement]),
                unchecked=tuple(sorted({body.link for body, on in zip(world.bodies, row, strict=True) if not on})),
            )
            for item, row in zip(world.obstacles, world.checked.T.tolist(), strict=True)
        ),
    )


@lru_cache(maxsize=16)
def _kinematics(chain: Chain) -> str:
    followed = {"leader", "factor", "zero"}  # they tell nothing where no joint follows another
    names = [item.name for item in fields(chain) if chain.follows or item.name not in followed]
    return content_hash(_rounded(getattr(chain, name)) for name in names)


@lru_cache(maxsize=256)
def _body_record(body: Body) -> BodyRecord:
    """Of detailed meshes a hash takes milliseconds, and a session asks for it after every change."""
    return BodyRecord(body.name, body.link, content_hash([body.joint, body.placement, *body.shape.content()]))


def _rounded(array: np.ndarray) -> Floats:
    """Nine decimals: what differs less is another library's arithmetic."""
    return np.round(array.astype(np.float64), 9) + 0.0


def unproven_pairs(record: WorldRecord, world: World) -> tuple[Bools, Bools]:
    """Which pairs of ``world`` no proof in the recorded world has checked: (bodies, obstacles) and (self pairs,).

    A pair is known if two things of the same shape in the same place were checked against each other. Where the
    joints lie elsewhere nothing is known.
    """
    now = record_of(world)
    if now.kinematics != record.kinematics:
        return world.checked, np.ones(len(world.self_pairs), dtype=bool)
    scene = {
        (body.content, item.shape, item.placement)
        for item in record.obstacles
        for body in record.bodies
        if body.link not in item.unchecked
    }
    own = {frozenset((record.bodies[i].content, record.bodies[k].content)) for i, k in record.self_pairs}
    new_scene = [
        [(body.content, item.shape, item.placement) not in scene for body in now.bodies] for item in now.obstacles
    ]
    new_own = [frozenset((now.bodies[i].content, now.bodies[k].content)) not in own for i, k in now.self_pairs]
    unknown = np.array(new_scene, dtype=bool).reshape(len(now.obstacles), len(now.bodies)).T
    return world.checked & unknown, np.array(new_own, dtype=bool)


def holds_limits(record: WorldRecord, world: World) -> bool:
    """Whether every configuration within the recorded limits is within those of this world's robot."""
    robot = world.robot
    if len(record.lower) != robot.dof:
        return False
    return bool((robot.lower <= record.lower).all() and (robot.upper >= record.upper).all())


def changes(record: WorldRecord, world: World) -> list[str]:
    """What differs between the recorded world and this one, thing by thing: "obstacle 'shelf' moved"."""
    now = record_of(world)
    differences = []
    if now.kinematics != record.kinematics:
        differences.append("the robot's base or joints placed elsewhere")
    if (now.lower, now.upper) != (record.lower, record.upper):
        narrower = not holds_limits(record, world)
        differences.append("narrower joint limits, see --widen-limits" if narrower else "wider joint limits")
    if now.held != record.held:
        differences.append("joints that are not planned held elsewhere, see --joints and --request")
    bodies = [{body.name: body.content for body in each.bodies} for each in (record, now)]
    for name in _in_either(*bodies):
        differences += _one_change("body", name, bodies[0].get(name), bodies[1].get(name), "changed")
    if set(now.self_pairs) != set(record.self_pairs) and bodies[0] == bodies[1]:
        differences.append("other pairs of links checked")
    return differences + _obstacle_changes(record, now)


def _obstacle_changes(old: WorldRecord, now: WorldRecord) -> list[str]:
    differences = []
    before, after = ({item.name: item for item in each.obstacles} for each in (old, now))
    for name in _in_either(before, after):
        a, b = before.get(name), after.get(name)
        if a is None or b is None or a.shape != b.shape:
            differences += _one_change("obstacle", name, a and a.shape, b and b.shape, "of another shape")
        elif a.placement != b.placement:
            differences.append(f"obstacle '{name}' moved")
        elif a.unchecked != b.unchecked:
            differences.append(f"obstacle '{name}' may be touched by other links")
    return differences


def _one_change(kind: str, name: str, old: str | None, new: str | None, otherwise: str) -> list[str]:
    if old == new:
        return []
    return [f"{kind} '{name}' {'added' if old is None else 'removed' if new is None else otherwise}"]


def _in_either(a: dict, b: dict) -> list[str]:
    return [*a, *(name for name in b if name not in a)]
