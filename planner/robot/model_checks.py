"""Models that load and still make little sense: what a user is told about them before a plan is believed."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from planner.base.errors import Note, RobotError, choices
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Mesh, Shape, extremes
from planner.robot.solids import is_watertight

_TOO_LARGE = 50  # times the arm's length: a part in millimetres that was read as metres is 1000 times too large
_TOO_SMALL = 1e-4  # of the arm's length
_OCTOMAP = "<octomap>"  # as MoveIt's matrices name one that is not there
_SHORTEST = 1e-3  # m: of an arm without length nothing can be said
_SHORT = 0.5  # m: a shorter arm, as a hand is, may well stand in a hall


def require_bodies(robot: Robot) -> None:
    """Raise :class:`RobotError` for a robot that can touch nothing."""
    if not robot.bodies:
        raise RobotError(
            f"robot '{robot.name}' has no collision geometry at all, so every path would be called free: add "
            "<collision> elements to its URDF."
        )


def notes(robot: Robot, scene: Scene) -> tuple[Note, ...]:
    """What is doubtful about a robot and a scene, and what of their files was passed over."""
    arm = _length(robot)
    models = (*_of_robot(robot), *_of_obstacles(scene, arm), *_far_away(robot, scene, arm))
    return (*models, *robot.notes, *scene.notes, *_names(robot, scene))


def _of_robot(robot: Robot) -> Iterator[Note]:
    """Links that are seen and that nothing can touch; meshes that are thinned, or not closed."""
    if bare := sorted(robot.source.bare):
        yield Note(
            f"robot '{robot.name}' has visual but no collision geometry on {choices(bare)}: contacts of these links "
            "are not seen; add <collision> elements to the URDF."
        )
    meshes = [(body.link, body.shape) for body in robot.bodies if isinstance(body.shape, Mesh)]
    if thin := {link: mesh.radius for link, mesh in meshes if mesh.radius}:
        text = f"meshes of {choices(thin)} are thinned to fewer triangles: what comes within "
        yield Note(f"{text}{1000 * max(thin.values()):.1f} mm of these counts as a contact.", grave=False)
    if open_ := dict.fromkeys(link for link, mesh in meshes if not is_watertight(mesh)):
        yield Note(f"meshes of {choices(open_)} are not closed: what is wholly inside them is not seen.", grave=False)


def _of_obstacles(scene: Scene, arm: float) -> Iterator[Note]:
    """Meshes that are far too small, or not closed; and what moves, which only what has times can see."""
    for item in scene.obstacles:
        if not isinstance(item.shape, Mesh):
            continue
        size = _size(item.shape)
        if arm > _SHORTEST and size < _TOO_SMALL * arm:
            across = f"mesh '{item.name}' is {size:.3g} m across, and the arm is {arm:.3g} m long"
            yield Note(f"{across}: if it is in metres, take its 'scale' away.")
        if not is_watertight(item.shape):
            yield Note(
                f"mesh '{item.name}' is not closed, or its triangles do not all face in one direction: only what "
                "crosses its surface is seen, not what is wholly inside."
            )
    if scene.moving:
        names = choices(item.name for item in scene.moving)
        yield Note(f"{names} move: motions in time are planned and checked among them, paths without times are not.")
    if scene.limited:
        text = "may leave their places: a trajectory's proof says until when nothing can touch."
        yield Note(f"{choices(item.name for item in scene.limited)} {text}", grave=False)


def _far_away(robot: Robot, scene: Scene, arm: float) -> Iterator[Note]:
    """Shapes that reach so far from the robot's base, or from the joint that moves them, that units are in doubt."""
    base = robot.base[:3, 3]
    placed = [(item.name, item.shape, item.placement[:3, 3] - base) for item in scene.obstacles]
    placed += [(item.name, item.shape, item.motion.poses[0, :3, 3] - base) for item in scene.moving]
    placed += [(b.link, b.shape, b.placement[:3, 3] - (b.joint == 0) * base) for b in robot.bodies]
    reach = {name: float(np.linalg.norm(at)) + _size(shape) for name, shape, at in placed}
    if far := {name: metres for name, metres in reach.items() if metres > _TOO_LARGE * max(arm, _SHORT)}:
        text = f"{choices(far)} would reach {max(far.values()):.0f} m far, and the arm is {arm:.3g} m long: if their "
        yield Note(f"{text}numbers are in millimetres, give metres, and scale meshes by 0.001.")


def _names(robot: Robot, scene: Scene) -> Iterator[Note]:
    """Names of a scene that fit another robot or nothing, and permissions that only the robot's SRDF can give."""
    message, where = scene.message, f"scene '{scene.name}'"
    if message is not None and message.robot not in ("", robot.name, robot.source.name):
        yield Note(f"{where} was made for robot '{message.robot}', and this one is '{robot.name}'.")
    if scene.robots and robot.name not in scene.robots:
        yield Note(f"{where} sets up {choices(scene.robots)}, not '{robot.name}', which stands as it is.", grave=False)
    links, standing = robot.source.links, {item.object for item in scene.obstacles}
    held = {item.name: item.object for item in scene.carried}
    allowed = {*itertools.chain(*scene.allowed)}
    if both := standing & links & allowed:
        text = "name obstacles and links of the robot alike: what is allowed of the one is allowed of the other"
        yield Note(f"{where}: {choices(sorted(both))} {text}; rename the obstacles.")
    known = {*links, *standing, *held.values(), *(body.link for body in robot.bodies), _OCTOMAP}
    known |= {item.name for item in (*scene.obstacles, *scene.moving)}
    if unknown := sorted({*allowed, *(link for item in scene.carried for link in item.touch_links)} - known):
        text = f"{where} allows contacts of {choices(unknown)}, which neither it nor the robot has."
        yield Note(text, grave=message is None)  # MoveIt's matrices name what came and went
    parts = {held.get(body.link, body.link) for body in robot.bodies}
    touching = {frozenset(held.get(name, name) for name in pair) for pair in robot.touching}
    own = robot.disabled_pairs or frozenset()
    other = {pair for pair in scene.allowed if pair <= parts and pair not in own | touching}
    other |= message.checked & own if message is not None else set()
    if other:
        pairs = choices(" and ".join(sorted(pair)) for pair in sorted(other, key=sorted))
        text = "says which links of the robot may touch, and is not followed, as the SRDF says otherwise"
        yield Note(f"{where} {text}: {pairs}.", grave=False)


def _length(robot: Robot) -> float:
    """How long the arm is (m) from its first planned joint to its tool, along the chain."""
    model = robot.model
    steps = [model.jointPlacements[joint].translation for joint in range(2, model.njoints)]
    return float(sum(map(np.linalg.norm, [*steps, model.frames[robot.tool_id].placement.translation])))


@lru_cache(maxsize=1024)  # of shapes that stay from one scene to the next
def _size(shape: Shape) -> float:
    """The longest side (m) of the box around a shape, along its own axes."""
    points = shape.vertices[shape.triangles].reshape(-1, 3) if isinstance(shape, Mesh) else np.array(extremes(shape))
    return float(np.ptp(points, axis=0).max())
