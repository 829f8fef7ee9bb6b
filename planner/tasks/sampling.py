"""Deterministic grasps from an object's shape, placements on a box, and the gripper of a robot."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats
from planner.base.errors import choices
from planner.base.yamlfile import suggest_name
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import tool_joint
from planner.robot.files import urdf
from planner.robot.poses import pose
from planner.robot.robot import Robot, with_carried
from planner.robot.shapes import Box, Capsule, Carried, Cylinder, Mesh, Obstacle, Shape, Sphere, corners
from planner.tasks.modes import HeldObject, Placement
from planner.tasks.task import Grasp, Gripper, Place, TaskError

MOST = 200  # grasps of an object
_SPARE = 2e-3  # m, smallest difference of opening and width of the object
_DEPTH, _ROUND = 0.02, 2.0  # m, largest depth of the tool's origin below the surface; factor for round sides
_ALONG = (0.0, 0.25, -0.25)  # of the object's length, from its middle
_TILTS = (0.0, 0.35, -0.35)  # rad about the axis along which the fingers close
_ABOUT = 16  # directions around an axis
_SPHERE, _TURNS = 24, 8  # directions towards a sphere, turns about each
_FREE_TURNS = 12  # of the tool about a free axis
_CONE_EDGE = 6  # directions on the edge of a cone
GAP = 1e-3  # m beyond the margin, between a sampled placement and the surface, so they do not touch
REST = 5e-3  # m, largest distance of an object to its support
_LEVEL = 1e-6  # of a direction's components
_TRIES = 50  # points per sample
_STEPS = np.array([1.2207440846057596**-k for k in (1, 2, 3)])  # of an additive low-discrepancy sequence (x, y, turn)


def tool_at(position: Floats, approach: Floats, closing: Floats) -> Floats:
    """Return the pose (4, 4) of a tool with z along ``approach`` and y along ``closing``, orthonormal."""
    matrix = np.array(pose(position.tolist()))
    matrix[:3, :3] = np.column_stack([np.cross(closing, approach), closing, approach])
    return matrix


def _turn_about(position: Floats, direction: Floats, turns: int) -> Iterator[Floats]:
    """Yield tool poses at ``position`` with z along a unit ``direction``, turned about it by equal steps."""
    for angle in np.arange(turns) * 2 * np.pi / turns:
        yield tool_at(position, direction, _across(direction, angle))


def _across(direction: Floats, angle: float) -> Floats:
    """Return the unit vector orthogonal to ``direction`` at an ``angle`` (rad) about it."""
    across = np.cross(direction, np.eye(3)[int(np.abs(direction).argmin())])
    side: Floats = np.asarray(across / np.linalg.norm(across), dtype=float)
    return math.cos(angle) * side + math.sin(angle) * np.cross(direction, side)


def tool_poses(grasp: Grasp) -> Iterator[Floats]:
    """Yield the pose (4, 4) of a grasp, or for an axis evenly spaced poses that it allows."""
    if grasp.axis is None:
        yield grasp.matrix()
        return
    axis = np.array(grasp.axis) / np.linalg.norm(grasp.axis)
    directions = [axis]
    if grasp.cone:
        edge = [_across(axis, angle) for angle in np.arange(_CONE_EDGE) * 2 * np.pi / _CONE_EDGE]
        directions += list(math.cos(grasp.cone) * axis + math.sin(grasp.cone) * np.array(edge))
    for direction in directions:
        yield from _turn_about(np.array(grasp.position), direction, _FREE_TURNS)


def generate_grasps(name: str, shape: Shape, opening: float | None) -> list[HeldObject]:
    """Return at most ``MOST`` grasps of a shape by a gripper of ``opening`` (m), None for a plain tool.

    Grasps of boxes are between two opposite faces, those of cylinders and capsules across their axis and from their
    ends, those of spheres from all directions. Raises :class:`TaskError` for wider shapes and for meshes.
    """
    if isinstance(shape, Mesh):
        raise TaskError(f"'{name}' must not be a mesh to generate grasps: give its 'grasps'.")
    widest, depth = (np.inf, 0.0) if opening is None else (opening - _SPARE, _DEPTH)
    grasps = [HeldObject(name, tool, width) for tool, width in _generate(shape, depth) if width <= widest]
    if not grasps:
        raise TaskError(f"'{name}' must be narrower than the gripper's opening of {opening:g} m: give its 'grasps'.")
    return [grasps[k] for k in np.linspace(0, len(grasps) - 1, min(MOST, len(grasps))).round().astype(int)]


def _generate(shape: Shape, deep: float) -> Iterator[tuple[Floats, float]]:
    """Yield tool poses (4, 4) with the opening of the gripper in each."""
    match shape:
        case Box(size):
            yield from _grasp_box(size, deep)
        case Sphere(radius):
            k = np.arange(_SPHERE) + 0.5  # Fibonacci lattice
            height, angle = 1 - 2 * k / _SPHERE, np.pi * (1 + np.sqrt(5)) * k
            across = np.sqrt(1 - height**2)
            for out in np.column_stack([across * np.cos(angle), across * np.sin(angle), height]):
                at = (radius - min(radius, _ROUND * deep)) * out
                yield from ((tool, 2 * radius) for tool in _turn_about(at, -out, _TURNS))
        case Cylinder(radius, length) | Capsule(radius, length):
            yield from ((tool, 2 * radius) for tool in _grasp_side(radius, length, _ROUND * deep))
            top = 0.5 * length + (radius if isinstance(shape, Capsule) else 0.0)
            for sign in (1.0, -1.0):
                out = np.array([0.0, 0.0, sign])
                yield from ((tool, 2 * radius) for tool in _turn_about((top - min(deep, top)) * out, -out, _ABOUT))


def _grasp_box(size: Sequence[float], deep: float) -> Iterator[tuple[Floats, float]]:
    axes = np.eye(3)
    for face in range(3):
        inside = 0.5 * size[face] - min(deep, 0.5 * size[face])
        for side in (1.0, -1.0):
            for closing in (k for k in range(3) if k != face):
                across = 3 - face - closing
                for share in _ALONG:
                    at = side * inside * axes[face] + share * size[across] * axes[across]
                    for tool in _tilt(at, -side * axes[face], axes[closing]):
                        yield tool, size[closing]


def _grasp_side(radius: float, length: float, deep: float) -> Iterator[Floats]:
    for angle in np.arange(_ABOUT) * 2 * np.pi / _ABOUT:
        out = np.array([math.cos(angle), math.sin(angle), 0.0])
        for share in _ALONG:
            at = (radius - min(radius, deep)) * out + np.array([0.0, 0.0, share * length])
            yield from _tilt(at, -out, np.array([-out[1], out[0], 0.0]))


def _tilt(at: Floats, approach: Floats, closing: Floats) -> Iterator[Floats]:
    """Yield the tool pose, tilted about the closing axis, with both orders of the fingers."""
    for tilt in _TILTS:
        tilted = math.cos(tilt) * approach + math.sin(tilt) * np.cross(closing, approach)
        for sign in (1.0, -1.0):
            yield tool_at(at, tilted, sign * closing)


def complete_gripper(robot: Robot, given: Gripper) -> Gripper:
    """Complete ``given`` from the robot: the fingers are fixed sliding joints behind the tool.

    Fingers close at their lower limits and open at their upper ones; the opening is the sum of their strokes. The links
    of the fingers may touch; without fingers, the links of the tool's last joint except the first.
    """
    model, (last, _) = urdf.build_model(robot.source), tool_joint(robot)
    joints = {name: model.getJointId(name) for name in robot.fixed_joints}
    ends = list(zip(model.lowerPositionLimit.tolist(), model.upperPositionLimit.tolist(), strict=True))
    limits = {name: ends[model.idx_qs[k]] for name, k in joints.items()}
    for name, value in [*(given.open or {}).items(), *(given.closed or {}).items()]:
        if name not in limits:
            held = choices(sorted(limits))
            raise TaskError(f"joint of the gripper must be a fixed joint of {robot.name}, {held}; got '{name}'.")
        low, high = limits[name]
        if not low - 1e-9 <= value <= high + 1e-9:
            raise TaskError(f"gripper joint '{name}' must be in [{low:g}, {high:g}], got {value:g}.")
    links = dict.fromkeys(body.link for body in robot.bodies)
    unknown = sorted(set(given.touch or ()) - set(links))
    if unknown:
        raise TaskError(f"link '{unknown[0]}' of 'touch' not found; links with shapes are {choices(links)}.")
    hand = model.getJointId(robot.model.names[last]) if last else 0
    slides = [name for name, k in joints.items() if model.joints[k].shortname().startswith("JointModelP")]
    fingers = [name for name in slides if hand in model.supports[joints[name]]]
    tight, wide = ({name: limits[name][end] for name in fingers} for end in (0, 1))
    frames = [(f.name, model.supports[f.parentJoint]) for f in model.frames if f.type == pin.FrameType.BODY]
    moved = [link for name in fingers for link, path in frames if joints[name] in path and link in links]
    at_tool = dict.fromkeys(body.link for body in robot.bodies if body.joint == last and body not in robot.carried)
    return Gripper(
        wide if given.open is None else given.open,
        tight if given.closed is None else given.closed,
        (sum(wide.values()) - sum(tight.values()) or None) if given.opening is None else given.opening,
        tuple(dict.fromkeys(moved) or [*at_tool][1:] or at_tool) if given.touch is None else given.touch,
    )


def extent(shape: Shape, rotation: Floats) -> tuple[Floats, Floats]:
    """Return the exact lowest and highest coordinates (3,) of a turned shape, about its own origin."""
    if isinstance(shape, Cylinder):
        axis = rotation[:, 2]
        half = 0.5 * shape.length * np.abs(axis) + shape.radius * np.sqrt(np.maximum(1 - axis**2, 0.0))
        return -half, half
    points, radius = corners(shape)
    turned = points @ rotation.T
    return turned.min(axis=0) - radius, turned.max(axis=0) + radius


def place_in_region(item: Obstacle, step: Place, boards: Iterable[Obstacle], margin: float) -> list[Placement]:
    """Return placements of an object on a box, upright as in the scene and turned about the vertical.

    The object lies within the region, ``GAP`` beyond the margin above the top. Raises :class:`TaskError` for a region
    that is not on a level top, or smaller than the object.
    """
    region = np.array(step.at, dtype=np.float64)
    low, high = region.min(axis=0), region.max(axis=0)
    top = _level_top(str(step.on), list(boards), low, high)
    upright, placements = item.placement[:3, :3], list[Placement]()
    for k in range(_TRIES * step.samples):
        at = np.mod(0.5 + (k + 1) * _STEPS, 1.0)
        turn = pose(rpy=(0.0, 0.0, 2 * np.pi * at[2]))[:3, :3] @ upright
        least, most = extent(item.shape, turn)
        spare = high - low - (most - least)[:2]
        if (spare < 0).any():
            continue
        matrix = np.eye(4)
        matrix[:3, :3] = turn
        matrix[:2, 3] = low - least[:2] + at[:2] * spare
        matrix[2, 3] = top - least[2] + margin + GAP
        placements.append(Placement(item.name, matrix, (str(step.on),)))
        if len(placements) == step.samples:
            break
    if not placements:
        size = " x ".join(f"{side:.3g}" for side in high - low)
        raise TaskError(f"the region on '{step.on}' must be larger than '{item.name}', got {size} m: enlarge it.")
    return placements


def _level_top(name: str, boards: list[Obstacle], low: Floats, high: Floats) -> float:
    """Return the height (m) of a box's top; :class:`TaskError` if not level, or smaller than the region."""
    board = next((each for each in boards if each.name == name), None)
    if board is None:
        names = [each.name for each in boards]
        raise TaskError(f"support '{name}'{suggest_name(name, names)} not found; fixed obstacles are {choices(names)}.")
    turn = board.placement[:3, :3]
    up = int(np.abs(turn[2]).argmax())
    if not isinstance(board.shape, Box) or abs(turn[2, up]) < 1.0 - _LEVEL:
        raise TaskError(f"'{name}' must be a box with a level top: give a 'pose' in place of 'on' and 'at'.")
    half = 0.5 * np.array(board.shape.size)
    region = np.array([[x, y, board.placement[2, 3]] for x in (low[0], high[0]) for y in (low[1], high[1])])
    if not (np.abs((region - board.placement[:3, 3]) @ turn) <= half + 1e-9).all():
        least, most = (end + board.placement[:3, 3] for end in extent(board.shape, turn))
        spans = f"x {least[0]:.3g} to {most[0]:.3g}, y {least[1]:.3g} to {most[1]:.3g}"
        raise TaskError(f"the region must be within the top of '{name}', {spans} m: make it smaller.")
    return float(board.placement[2, 3] + half[up])


def make_placement(item: Obstacle, at: Floats, among: CollisionChecker, others: tuple[Obstacle, ...] = ()) -> Placement:
    """Return the placement of an object at ``at`` (4, 4); supports touch it ``REST`` lower."""
    lower = np.array(at)
    lower[2, 3] -= REST + among.world.margin
    return Placement(item.name, np.array(at), _find_touching(item, lower, among, others))


def place_at(item: Obstacle, at: Floats, among: CollisionChecker) -> Placement:
    """Return the placement at a pose; :class:`TaskError` inside an obstacle, or without support."""
    where, placement = ", ".join(f"{value:g}" for value in at[:3, 3]), make_placement(item, at, among)
    lifted = np.array(at)
    lifted[2, 3] += GAP + among.world.margin
    hit = [
        name for name in _find_touching(item, lifted, among) if name in placement.supports
    ]  # obstacles above are not supports
    if hit:
        raise TaskError(f"'{item.name}' must be outside of '{hit[0]}', got ({where}) m inside: choose another pose.")
    if not placement.supports:
        raise TaskError(
            f"'{item.name}' must have a support within {1e3 * REST:g} mm beneath it, got ({where}) m without one: "
            "lower it."
        )
    return placement


def _find_touching(
    item: Obstacle, at: Floats, among: CollisionChecker, others: tuple[Obstacle, ...] = ()
) -> tuple[str, ...]:
    """Return fixed objects and ``others`` within the margin of an object at ``at``."""
    root = among.robot.model.frames[0]
    held = Carried(root.name, item.name, item.shape, np.linalg.inv(root.placement.homogeneous) @ at)
    robot = with_carried(among.robot, [held])
    scene = replace(among.world.scene, obstacles=(*among.world.obstacles, *others))
    checker = type(among)(among.world.among(scene, robot), among)
    count = len(scene.obstacles)
    near = checker.gaps(np.zeros(robot.dof), (len(robot.bodies) - 1) * count + np.arange(count)) <= among.world.margin
    return tuple(each.object for each, close in zip(scene.obstacles, near, strict=True) if close)
