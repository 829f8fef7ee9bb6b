"""A robot in a scene: frames that the scene names, and warnings about the combination."""

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import Note, RobotError, SceneError, choices
from planner.base.yamlfile import quote, suggest_name
from planner.kinematics.forward import tool_pose
from planner.problem.targets import HOME, Joints, follow_names, joints_text, parse_target
from planner.robot.clouds import Seen, record_clouds
from planner.robot.files.clouds import OCTOMAP
from planner.robot.robot import Robot, frame_of_carried, with_tool
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Mesh, Obstacle, bounding_box
from planner.robot.solids import is_watertight

_SAME = 1e-6  # m, and of a matrix's entries
_FAR = 50.0  # times the arm's length: millimetres read as metres are 1000 times too large
_SHORT = 0.5  # m: minimum length in this test, because a hand may stand in a hall


def placement_of_frame(frame: str, robot: Robot, scene: Scene, what: str, at: Floats | None = None) -> Floats:
    """Return the placement (4, 4) of a frame in the scene's own frame.

    Searched in order: fixed frames of the scene, names of the scene's own frame, links of the robot that do not move. A
    parent that all fixed frames share is the scene's own frame unless a link has that name. In the state ``at`` (dof,)
    links that move have a placement too. Raises :class:`SceneError` about ``what`` for unknown frames.
    """
    fixed = {} if scene.message is None else scene.message.frames
    if frame in fixed:
        parent, placement = fixed[frame]
        return frozen(placement_of_frame(parent, robot, scene, what) @ placement)
    if frame in ("", "world", robot.world_frame):
        return frozen(np.eye(4))
    links = {each.name: each for each in reversed(list(robot.model.frames))}
    if frame in links and links[frame].parentJoint == 0:
        return frozen(links[frame].placement.homogeneous)
    here = f"frame '{robot.world_frame or 'world'}'"
    if frame in links and at is not None:
        return frozen(tool_pose(with_tool(robot, frame), at).homogeneous)
    if frame in links:
        raise SceneError(f"{what} is given in frame {quote(frame)}, which moves with the arm; give it in {here}.")
    if {parent for parent, _ in fixed.values()} - {"", *links} == {frame}:
        return frozen(np.eye(4))
    known = [*fixed, *(name for name, each in links.items() if each.parentJoint == 0 or at is not None)]
    raise SceneError(
        f"{what} is given in frame {quote(frame)}{suggest_name(frame, known)}, which neither the scene's "
        f"fixed_frame_transforms nor the robot place; give it in {here}."
    )


def resolve_frames(scene: Scene, robot: Robot) -> Scene:
    """Return the scene with obstacles in its own frame, and carried shapes in that of their link."""
    _require_consistent_frames(scene, robot)
    if not any(item.frame for item in (*scene.obstacles, *scene.carried)):
        return scene
    placed = {
        (item.frame, item.seen_at): placement_of_frame(
            item.frame,
            robot,
            scene,
            f"object {quote(item.object)} of scene {quote(scene.name)}",
            state_seen(item, robot, scene) if item.seen_at else None,
        )
        for item in scene.obstacles
    }
    return replace(
        scene,
        obstacles=tuple(
            replace(item, placement=frozen(placed[item.frame, item.seen_at] @ item.placement), frame="")
            if item.frame
            else item
            for item in scene.obstacles
        ),
        carried=tuple(_in_link(item, robot) for item in scene.carried),
    )


def state_seen(item: Obstacle, robot: Robot, scene: Scene) -> Floats:
    """Return the joint values (dof,) of ``item.seen_at``; :class:`SceneError` for another kind of state."""
    named = {name: joints_text(values) for name, values in robot.states.items()} | {HOME: joints_text(robot.home)}
    (text, *_) = follow_names(item.seen_at, {**named, **scene.states_of(robot.name)})
    target = parse_target(text)
    if not isinstance(target, Joints) or len(target.values) != robot.dof:
        raise SceneError(
            f"obstacle {quote(item.name)}: seen_at must be q: and {robot.dof} joint values, or a state of these, got "
            f"{quote(item.seen_at)}: give the state of '{robot.name}' when the sensor saw."
        )
    return np.array(target.values)


def _require_consistent_frames(scene: Scene, robot: Robot) -> None:
    """Raise :class:`SceneError` if a fixed frame of the scene is a link that moves or stands elsewhere."""
    fixed = {} if scene.message is None else scene.message.frames
    for each in robot.model.frames:
        if each.name not in fixed:
            continue
        placement = placement_of_frame(each.name, robot, scene, "a fixed frame")
        if each.parentJoint or np.abs(placement - each.placement.homogeneous).max() > _SAME:
            raise SceneError(
                f"the fixed_frame_transforms of scene {quote(scene.name)} place {quote(each.name)}, which is a link of "
                "the robot and not there: say where its base stands with --base, or take that transform out."
            )


def _in_link(item: Carried, robot: Robot) -> Carried:
    if not item.frame:
        return item
    link, frame = (frame_of_carried(robot, each).placement.homogeneous for each in (replace(item, frame=""), item))
    return replace(item, placement=frozen(np.linalg.inv(link) @ frame @ item.placement), frame="")


def require_bodies(robot: Robot) -> None:
    """Raise :class:`RobotError` for a robot without collision geometry."""
    if not robot.bodies:
        raise RobotError(
            f"robot '{robot.name}' has no collision geometry, so every path would be free: add <collision> elements "
            "to its URDF."
        )


def notes(robot: Robot, scene: Scene) -> tuple[Note, ...]:
    """Return warnings about a robot in a scene, and notes on ignored content of their files."""
    doubts = (*_robot_notes(robot), *_scene_notes(scene), *_distance_notes(robot, scene))
    return (*doubts, *robot.notes, *scene.notes, *_name_notes(robot, scene))


def _robot_notes(robot: Robot) -> Iterator[Note]:
    """Yield notes on links without collision geometry and on simplified or open meshes."""
    if bare := sorted(robot.source.bare):
        yield Note(
            f"robot '{robot.name}' has visual but no collision geometry on {choices(bare)}: contacts of these links "
            "are not detected; add <collision> elements to the URDF."
        )
    meshes = [(body.link, body.shape) for body in robot.bodies if isinstance(body.shape, Mesh)]
    if thin := {link: mesh.radius for link, mesh in meshes if mesh.radius}:
        text = f"meshes of {choices(thin)} are simplified to fewer triangles: a distance below "
        yield Note(f"{text}{1000 * max(thin.values()):.1f} mm counts as a contact.", grave=False)
    if open_ := dict.fromkeys(link for link, mesh in meshes if not is_watertight(mesh)):
        yield Note(f"meshes of {choices(open_)} are not closed: objects inside them are not detected.", grave=False)


def _scene_notes(scene: Scene) -> Iterator[Note]:
    """Yield notes on open meshes, points that may be touched, and obstacles that move."""
    for item in scene.obstacles:
        if isinstance(item.shape, Mesh) and not isinstance(item.shape, Seen) and not is_watertight(item.shape):
            yield Note(
                f"mesh '{item.name}' is not closed, or its triangles do not all face in one direction: contacts of "
                "its surface are detected, objects inside it are not."
            )
    for cloud in record_clouds(scene.obstacles):
        touching = {name for pair in scene.allowed if cloud.obstacle in pair for name in pair - {cloud.obstacle}}
        if touching:
            text = f"{choices(sorted(touching))} may touch the {cloud.points} points of '{cloud.obstacle}'."
            yield Note(text, grave=False)
    if scene.moving:
        names = choices(item.name for item in scene.moving)
        yield Note(f"{names} move: timed motions are planned and checked among them, paths without times are not.")
    if scene.limited:
        text = "may move: the proof of a trajectory gives the time until which no contact is possible."
        yield Note(f"{choices(item.name for item in scene.limited)} {text}", grave=False)


def _distance_notes(robot: Robot, scene: Scene) -> Iterator[Note]:
    """Yield a note on shapes so far from the base, or from their joint, that units are in doubt."""
    model, base = robot.model, robot.base[:3, 3]
    steps = [model.jointPlacements[joint].translation for joint in range(2, model.njoints)]
    arm = sum(map(np.linalg.norm, [*steps, model.frames[robot.tool_id].placement.translation]))
    placed = [(item.name, item.shape, item.placement[:3, 3] - base) for item in scene.obstacles]
    placed += [(item.name, item.shape, item.motion.poses[0, :3, 3] - base) for item in scene.moving]
    placed += [(b.link, b.shape, b.placement[:3, 3] - (b.joint == 0) * base) for b in robot.bodies]
    reach = {name: float(np.linalg.norm(at) + np.ptp(bounding_box(shape), axis=0).max()) for name, shape, at in placed}
    if far := {name: metres for name, metres in reach.items() if metres > _FAR * max(arm, _SHORT)}:
        text = f"{choices(far)} would reach {max(far.values()):.0f} m far, and the arm is {arm:.3g} m long: if their "
        yield Note(f"{text}numbers are in millimetres, give metres, and scale meshes by 0.001.")


def _name_notes(robot: Robot, scene: Scene) -> Iterator[Note]:
    """Yield notes on names that fit another robot, or nothing, and on permissions that the SRDF overrides."""
    message, where = scene.message, f"scene '{scene.name}'"
    if message is not None and message.robot not in ("", robot.name, robot.source.name):
        yield Note(f"{where} is for robot '{message.robot}', but this robot is '{robot.name}'.")
    allowed, held = {*itertools.chain(*scene.allowed)}, {item.name: item.object for item in scene.carried}
    parts = {held.get(body.link, body.link) for body in robot.bodies}
    known = {*robot.source.links, *parts, *held, *held.values(), OCTOMAP}
    known |= {name for item in scene.obstacles for name in (item.name, item.object)}
    known |= {item.name for item in scene.moving}
    if unknown := sorted({*allowed, *(link for item in scene.carried for link in item.touch_links)} - known):
        text = f"{where} allows contacts of {choices(unknown)}, which neither it nor the robot has."
        yield Note(text, grave=message is None)  # MoveIt's matrices also name removed objects
    touching = {frozenset(held.get(name, name) for name in pair) for pair in robot.touching}
    own = robot.disabled_pairs or frozenset()
    other = {pair for pair in scene.allowed if pair <= parts and pair not in own | touching}
    other |= message.checked & own if message is not None else set()
    if other:
        pairs = choices(" and ".join(sorted(pair)) for pair in sorted(other, key=sorted))
        text = "allows contacts of links of the robot, but the SRDF overrides it"
        yield Note(f"{where} {text}: {pairs}.", grave=False)
