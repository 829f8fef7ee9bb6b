"""A scene in which an obstacle is taken into the hand, and one in which it is let go of again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.kinematics.forward import tool_pose
from planner.robot.robot import Robot, with_tool
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Obstacle


def taken(scene: Scene, item: Obstacle, robot: Robot, link: str, q: Floats, touch_links: tuple[str, ...] = ()) -> Scene:
    """The scene with its obstacle ``item`` carried by ``link``, as it stands to that in the configuration ``q``."""
    held = frozen(np.linalg.inv(_hand(robot, link, q)) @ item.placement)
    carried = Carried(link, item.name, item.shape, held, touch_links, speed_limit=item.speed_limit)
    obstacles = tuple(other for other in scene.obstacles if other is not item)
    return replace(scene, obstacles=obstacles, carried=(*scene.carried, carried))


def let_go(scene: Scene, item: Carried, robot: Robot, q: Floats) -> Scene:
    """The scene with what it carries, ``item``, standing where the arm holds it in the configuration ``q``."""
    put_down = Obstacle(item.name, item.shape, placement_of(item, robot, q), speed_limit=item.speed_limit)
    carried = tuple(other for other in scene.carried if other is not item)
    return replace(scene, obstacles=(*scene.obstacles, put_down), carried=carried)


def placement_of(item: Carried, robot: Robot, q: Floats) -> Floats:
    """Where (4, 4) something is that a link carries, in the configuration ``q`` (dof,)."""
    return frozen(_hand(robot, item.link, q) @ item.placement)


def _hand(robot: Robot, link: str, q: Floats) -> Floats:
    return tool_pose(with_tool(robot, link), q).homogeneous
