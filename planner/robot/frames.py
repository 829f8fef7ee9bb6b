"""Where the frames are that a MoveIt scene or request names: the scene's own, fixed ones, and links that stand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import SceneError
from planner.base.yamlfile import nearest, shown
from planner.robot.robot import Robot, held_in
from planner.robot.scene import Scene
from planner.robot.shapes import Carried

_SAME = 1e-6  # m, and of a matrix's entries
_WORLD = ("", "world")  # what the scene's own frame is called


def placement_of(frame: str, robot: Robot, scene: Scene, what: str) -> Floats:
    """The placement (4, 4) of a frame in the scene's own; :class:`SceneError` says that of ``what`` it is unknown.

    Fixed frames of the scene come first, then the scene's own frame by the names that it has, then what stands of the
    robot. The one frame in which a scene places its fixed frames is its own, if no link has that name.
    """
    fixed = {} if scene.message is None else scene.message.frames
    if frame in fixed:
        parent, placement = fixed[frame]
        return frozen(placement_of(parent, robot, scene, what) @ placement)
    if frame in (*_WORLD, robot.world_frame):
        return frozen(np.eye(4))
    found = next((each for each in robot.model.frames if each.name == frame), None)
    here = f"frame '{robot.world_frame or 'world'}'"
    if found is not None and found.parentJoint == 0:
        return frozen(found.placement.homogeneous)
    if found is not None:
        raise SceneError(f"{what} is given in frame {shown(frame)}, which moves with the arm; give it in {here}.")
    if {parent for parent, _ in fixed.values()} - {"", *(each.name for each in robot.model.frames)} == {frame}:
        return frozen(np.eye(4))
    known = [each.name for each in robot.model.frames if each.parentJoint == 0]
    raise SceneError(
        f"{what} is given in frame {shown(frame)}{nearest(frame, [*fixed, *known])}, which neither the scene's "
        f"fixed_frame_transforms nor the robot place; give it in {here}."
    )


def in_world(scene: Scene, robot: Robot) -> Scene:
    """The scene with its obstacles in its own frame, and what is carried in that of its link."""
    _require_links_where_they_are(scene, robot)
    if not any(item.frame for item in (*scene.obstacles, *scene.carried)):
        return scene
    placed = {
        item.frame: placement_of(item.frame, robot, scene, f"object {shown(item.object)} of scene {shown(scene.name)}")
        for item in scene.obstacles
    }
    return replace(
        scene,
        obstacles=tuple(
            replace(item, placement=frozen(placed[item.frame] @ item.placement), frame="") if item.frame else item
            for item in scene.obstacles
        ),
        carried=tuple(_in_link(item, robot) for item in scene.carried),
    )


def _require_links_where_they_are(scene: Scene, robot: Robot) -> None:
    """Raise :class:`SceneError` where fixed frames of a scene are links of the robot that stand elsewhere, or move."""
    fixed = {} if scene.message is None else scene.message.frames
    for each in robot.model.frames:
        if each.name not in fixed:
            continue
        placement = placement_of(each.name, robot, scene, "a fixed frame")
        if each.parentJoint or np.abs(placement - each.placement.homogeneous).max() > _SAME:
            raise SceneError(
                f"the fixed_frame_transforms of scene {shown(scene.name)} place {shown(each.name)}, which is a link of "
                "the robot and not there: say where its base stands with --base, or take that transform out."
            )


def _in_link(item: Carried, robot: Robot) -> Carried:
    if not item.frame:
        return item
    link, frame = (held_in(robot, each).placement.homogeneous for each in (replace(item, frame=""), item))
    return replace(item, placement=frozen(np.linalg.inv(link) @ frame @ item.placement), frame="")
