"""Robot, obstacles, roadmap and paths as objects on a canvas."""

from collections.abc import Collection, Sequence, Set
from dataclasses import replace
from functools import lru_cache
from itertools import cycle
from typing import Any, Literal, TypeAlias

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.constraints.tool_bound import Frame
from planner.kinematics.forward import Chain, joint_placements, tool_positions
from planner.native.compiled import group_rows
from planner.roadmap.roadmap import Roadmap
from planner.robot.clouds import Points
from planner.robot.poses import pose, quaternion_of
from planner.robot.robot import Robot, load_visuals
from planner.robot.scene import Scene
from planner.robot.shapes import Body, Sphere, bounding_box, corners
from planner.trajectory.measure import dense_path
from planner.view.canvas import Canvas
from planner.view.surfaces import smooth_mesh, tube

Kind: TypeAlias = Literal["visual", "collision"]  # of a robot's bodies

_OBSTACLES = (  # in turn: neighbours in the list differ, and none looks like a path or red
    (0.55, 0.60, 0.68, 0.85),
    (0.82, 0.72, 0.46, 0.85),
    (0.40, 0.63, 0.66, 0.85),
    (0.66, 0.55, 0.75, 0.85),
    (0.60, 0.66, 0.42, 0.85),
    (0.42, 0.53, 0.76, 0.85),
    (0.63, 0.51, 0.43, 0.85),
    (0.80, 0.62, 0.70, 0.85),
)
_WAY = (0.70, 0.74, 0.78, 0.6)
_COLLISION = (0.10, 0.55, 0.90, 0.6)
TOUCHING = (0.90, 0.12, 0.12, 0.9)
_RUNG, _RUNG_COLOUR = 0.025, (0.25, 0.30, 0.40)  # m from the tool's origin to either end
PATH, START, GOAL = (0.85, 0.25, 0.10, 1.0), (0.15, 0.65, 0.25, 1.0), (0.80, 0.10, 0.15, 1.0)
_DOT = 0.022  # m
_HEIGHTS = (0.15, 0.95), (0.35, 0.75), (0.75, 0.20)  # red, green and blue of the lowest and the highest point
_TUBE, _TUBE_STEP = 0.006, 0.08  # m, rad: between two rings the tool leaves the chord by less than a tube's radius
EDGE_PIECES = 4  # line segments that approximate an edge's curved path
MOST_EDGES = 8_000  # on a page: more make a black cloud of tens of megabytes


def draw_bodies(canvas: Canvas, kind: Kind, bodies: Sequence[Body], touching: Collection[str] = ()) -> dict[str, str]:
    """Draw bodies under one frame per joint (0: base), ``touching`` links red; return the links by path."""
    names: dict[str, str] = {}
    for k, body in enumerate(bodies):
        path = f"robot/{body.joint}/{kind}/{k}"
        rgba = TOUCHING if body.link in touching else body.color if kind == "visual" else _COLLISION
        canvas.shape(path, body.shape, body.placement, rgba, flat=kind == "collision")
        names[path] = body.link
    return names


def set_joints(canvas: Canvas, robot: Robot, q: Floats) -> None:
    """Place the frames of the joints at ``q`` (dof,)."""
    for joint, matrix in enumerate(joint_matrices(robot, q[None])[0], start=1):
        canvas.transform(f"robot/{joint}", matrix)


def obstacle_colours(scene: Scene) -> dict[str, tuple[float, float, float, float]]:
    """Return the colour of each static and moving obstacle by name: eight in turn, in the scene's order."""
    objects = dict.fromkeys([*(item.object for item in scene.obstacles), *(item.name for item in scene.moving)])
    return dict(zip(objects, cycle(_OBSTACLES), strict=False))


def draw_scene(canvas: Canvas, scene: Scene, touching: Collection[str] = ()) -> dict[str, str]:
    """Draw obstacles, ``touching`` ones red, and a background; return the obstacles' names by path.

    Moving obstacles are at time 0, each under a frame of its own with the frame's path.
    """
    names: dict[str, str] = {}
    colours = obstacle_colours(scene)
    for k, obstacle in enumerate(scene.obstacles):
        rgba = TOUCHING if obstacle.name in touching else colours[obstacle.object]
        if isinstance(obstacle.shape, Points):
            size, up = obstacle.shape.radius, obstacle.placement[2, :3]
            points = obstacle.shape.vertices
            points = points[group_rows(points, size)[0]]  # squares of that size hide the others
            canvas.points(f"obstacles/{k}", points, _colour_by_height(points @ up), size)
            canvas.transform(f"obstacles/{k}", obstacle.placement)
        else:
            canvas.shape(f"obstacles/{k}", smooth_mesh(obstacle.shape), obstacle.placement, rgba)
        names[f"obstacles/{k}"] = obstacle.name
    for k, item in enumerate(scene.moving):
        rgba = TOUCHING if item.name in touching else colours[item.name]
        canvas.shape(f"moving/{k}/shape", smooth_mesh(item.shape), np.eye(4), rgba)
        canvas.transform(f"moving/{k}", item.motion.poses[0])
        names[f"moving/{k}/shape"] = item.name
        way = item.motion.poses[:, :3, 3]
        if np.ptp(way, axis=0).any():
            canvas.shape(f"ways/{k}", tube(way, _TUBE, 8), np.eye(4), _WAY)
    canvas.set("Background", "top_color", [0.95, 0.96, 0.98])
    canvas.set("Background", "bottom_color", [0.82, 0.85, 0.89])
    for name in ("Axes", "Grid", "Lights"):  # the page has a grid and lights of its own
        canvas.set(name, "visible", False)
    return names


def _colour_by_height(height: Floats) -> Floats:
    """Return colours (n, 3) of the points of a cloud by ``height`` (n,): blue, grey, yellow."""
    share = (height - height.min()) / max(float(np.ptp(height)), 1e-9)
    return np.stack([np.interp(share, [0.0, 0.5, 1.0], [low, 0.55, high]) for low, high in _HEIGHTS], axis=1)


def moving_data(scene: Scene) -> list[dict[str, Any]]:
    """Return the moving obstacles for the page: poses at times (s), and halfway between any two.

    The extra poses keep every turn short enough to be unambiguous.
    """
    motions = []
    for item in scene.moving:
        times = item.motion.times
        times = np.unique(np.concatenate([times, 0.5 * (times[1:] + times[:-1])]))
        poses = item.motion.at(times)
        turns = [quaternion_of(placement[:3, :3]) for placement in poses]
        motions.append({"times": times.tolist(), "positions": poses[:, :3, 3].tolist(), "quaternions": turns})
    return motions


def select_part(roadmap: Roadmap) -> tuple[Bools, Bools]:
    """Return the nodes (n,) and edges (m,) that a page draws: at most ``MOST_EDGES`` edges and their ends."""
    n, m = len(roadmap.nodes), len(roadmap.edges)
    if m <= MOST_EDGES:
        return np.ones(n, dtype=bool), np.ones(m, dtype=bool)
    nodes, edges = np.zeros(n, dtype=bool), np.zeros(m, dtype=bool)
    edges[np.linspace(0, m - 1, MOST_EDGES).round().astype(np.int64)] = True
    for ends in (roadmap.edges[edges].ravel(), roadmap.starts, roadmap.goals):
        nodes[ends] = True
    return nodes, edges


def draw_roadmap(canvas: Canvas, roadmap: Roadmap, robot: Robot, drawn: tuple[Bools, Bools]) -> dict[str, Any]:
    """Draw the ``drawn`` nodes at their tool positions, the edges along the tool's path, starts and goals.

    ``drawn`` is from :func:`select_part`. It returns the data of the colours: w, components and edges.
    """
    nodes, edges = drawn
    component = roadmap.components[nodes]
    if not (nodes.all() and edges.all()):
        roadmap = roadmap.part(nodes, edges)
    positions, dot = tool_positions(robot, roadmap.nodes), _DOT * mark_scale(robot)
    canvas.points("roadmap/nodes", positions, np.zeros_like(positions), dot)
    a, b = roadmap.edges.T
    if len(a):
        q, delta = roadmap.nodes[a], robot.difference(roadmap.nodes[a], roadmap.nodes[b])
        s = np.linspace(0.0, 1.0, EDGE_PIECES + 1)
        along = tool_positions(robot, (q[:, None] + s[:, None] * delta[:, None]).reshape(-1, robot.dof))
        along = along.reshape(len(a), EDGE_PIECES + 1, 3)
        ends = np.stack([along[:, :-1], along[:, 1:]], axis=2).reshape(-1, 3)
        canvas.segments("roadmap/edges", ends, np.zeros_like(ends))
    for role, indices, colour in (("start", roadmap.starts, START), ("goal", roadmap.goals, GOAL)):
        for k, place in enumerate(positions[indices]):
            canvas.shape(f"{role}/{k}", Sphere(dot), pose(place.tolist()), colour)
    return {
        "w": np.round(roadmap.manipulability, 7).tolist(),
        "component": component.tolist(),
        "edges": roadmap.edges.tolist(),
        "pieces": EDGE_PIECES,
    }


def draw_path(
    canvas: Canvas, name: str, robot: Robot, path: Floats, rgba: tuple[float, float, float, float] = PATH
) -> None:
    """Draw the tool's path along a joint path as a tube."""
    along = tube(tool_positions(robot, dense_path(path, _TUBE_STEP)), _TUBE * mark_scale(robot), 8)
    canvas.shape(name, along, np.eye(4), rgba)


def draw_rungs(canvas: Canvas, robot: Robot, q: Floats) -> None:
    """Draw solutions (n, dof) along a tool path, each as a bar along the tool's x axis."""
    rotation, position = Frame.tool(robot).poses(robot, q[:MOST_EDGES])
    ends = position[:, None] + np.array([[-_RUNG], [_RUNG]]) * rotation[:, None, :, 0]
    canvas.segments("tool_path/rungs", ends.reshape(-1, 3), np.tile(_RUNG_COLOUR, (2 * len(ends), 1)))


def joint_matrices(robot: Robot, q: Floats) -> Floats:
    """Return placements (n, joints, 4, 4) of every joint's frame, followers included."""
    rotation, position = joint_placements(Chain.from_arm(robot), q)
    matrices = np.zeros((*position.shape[:2], 4, 4))
    matrices[..., :3, :3], matrices[..., :3, 3], matrices[..., 3, 3] = rotation, position, 1.0
    return matrices[1:].transpose(1, 0, 2, 3)


def joint_line(robot: Robot, q: Floats) -> Floats:
    """Return points (k, 3) from the base over every joint to the tool at ``q`` (dof,)."""
    return np.vstack([robot.base[:3, 3], joint_matrices(robot, q[None])[0][:, :3, 3], tool_positions(robot, q)])


def mark_scale(robot: Robot) -> float:
    """Return the scale of marks: 1 for an arm of 1.3 m or more from base to tool, less for a smaller one."""
    length = float(np.linalg.norm(np.diff(joint_line(robot, np.asarray(robot.home)), axis=0), axis=1).sum())
    return min(1.0, max(0.2, length / 1.3))


def extent(robot: Robot, scene: Scene, bodies: Sequence[Body], q: Floats, points: Floats) -> tuple[Floats, float]:
    """Return the centre (3,) and radius (m) of a ball around the robot and its surroundings.

    It holds the robot's ``bodies`` at all of ``q`` (n, dof), near obstacles and ``points`` (n, 3). Obstacles far larger
    than the arm (a floor, a wall) do not count: they would make all else small.
    """
    line = joint_line(robot, q[0])
    reach = 1.3 * float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())  # the arm stretched out
    near = [line, points, swept_corners(robot, bodies, q)]
    passing = [item.standing(t) for item in scene.moving for t in item.motion.times]
    for obstacle in (*scene.obstacles, *passing):
        hull, _ = corners(obstacle.shape)
        placed = hull @ obstacle.placement[:3, :3].T + obstacle.placement[:3, 3]
        if np.linalg.norm(placed - robot.base[:3, 3], axis=1).max() < reach:
            near.append(placed)
    everything = np.vstack(near)
    centre = 0.5 * (everything.min(axis=0) + everything.max(axis=0))
    return centre, max(0.2, float(np.linalg.norm(everything - centre, axis=1).max()))


def swept_corners(robot: Robot, bodies: Sequence[Body], q: Floats) -> Floats:
    """Return the corners (k, 3) of boxes around the bodies at each of ``q`` (n, dof)."""
    matrices = joint_matrices(robot, q)
    rows = [np.zeros((0, 3))]
    for body in bodies:
        low, high = bounding_box(body.shape)
        box = np.array(np.meshgrid(*np.column_stack([low, high]))).reshape(3, -1).T
        # in its joint's frame, or for the base the world
        still = box @ body.placement[:3, :3].T + body.placement[:3, 3]
        if body.joint == 0:
            rows.append(still)
            continue
        frames = matrices[:, body.joint - 1]
        rows.append((still @ frames[:, :3, :3].transpose(0, 2, 1) + frames[:, None, :3, 3]).reshape(-1, 3))
    return np.vstack(rows)


def draw_robot(
    canvas: Canvas, robot: Robot, q: Floats, touching: Set[str] = frozenset()
) -> tuple[dict[str, str], tuple[Body, ...]]:
    """Draw the robot at ``q`` (dof,), ``touching`` links red; return links by path, and visual bodies.

    Collision bodies are drawn under the same frames.
    """
    carried = tuple(replace(body, shape=smooth_mesh(body.shape)) for body in robot.carried)
    visual, colliding = ((*bodies, *carried) for bodies in load_drawn_bodies(robot))
    names = draw_bodies(canvas, "visual", visual, touching)
    names |= draw_bodies(canvas, "collision", colliding, touching)
    set_joints(canvas, robot, q)
    return names, visual


@lru_cache(maxsize=8)
def load_drawn_bodies(robot: Robot) -> tuple[tuple[Body, ...], tuple[Body, ...]]:
    """Return the visual bodies of ``robot``, and its collision bodies, without carried ones.

    See :func:`planner.robot.robot.load_visuals`.
    """
    carried = {body.link for body in robot.carried}
    own = tuple(body for body in robot.bodies if body.link not in carried)
    return load_visuals(replace(robot, carried=())), own
