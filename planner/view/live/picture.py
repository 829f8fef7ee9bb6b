"""A robot, obstacles and a path in viser's scene, and the server that shows them to this machine only."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import viser
import websockets.asyncio.server as websocket_server

from planner.base.arrays import Floats
from planner.kinematics.forward import tool_positions
from planner.robot.poses import quaternion_of
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.trajectory.measure import dense_path
from planner.view.drawing import PATH, TOUCHING, drawn_bodies, extent, joint_matrices, obstacle_colours
from planner.view.surfaces import capsule_mesh, smoothed

HOST = "127.0.0.1"


def start_server() -> viser.ViserServer:
    """A viser server on the loopback address; it answers only pages that come from itself."""
    origins: list[Any] = []
    serve = websocket_server.serve
    websocket_server.serve = partial(serve, origins=origins)  # viser has no option for it
    try:
        server = viser.ViserServer(host=HOST, verbose=False)
    finally:
        websocket_server.serve = serve
    origins += [f"http://{name}:{server.get_port()}" for name in (HOST, "localhost")]
    server.gui.configure_theme(show_share_button=False, show_logo=False)  # sharing would leave this machine
    return server


class Picture:
    """The objects of a viser scene: the robot at a configuration, the obstacles by name, a path of the tool."""

    def __init__(self, server: viser.ViserServer, robot: Robot, world: Scene, q: Floats) -> None:
        scene = server.scene
        self._scene, self._robot = scene, robot
        joints = range(len(joint_matrices(robot, q[None])[0]) + 1)
        self._frames = [scene.add_frame(f"/robot/{joint}", show_axes=False) for joint in joints]
        bodies = (*drawn_bodies(robot)[0], *robot.carried)
        for k, body in enumerate(bodies):
            _draw(scene, f"/robot/{body.joint}/{k}", body.shape, body.placement, body.color)
        self._colours = obstacle_colours(world)
        self.obstacles = {
            item.name: _draw(scene, f"/obstacles/{k}", smoothed(item.shape), item.placement, self._colours[item.object])
            for k, item in enumerate(world.obstacles)
        }
        for k, item in enumerate(world.moving):
            _draw(scene, f"/moving/{k}", smoothed(item.shape), item.motion.poses[0], self._colours[item.name])
        centre, self.radius = extent(robot, world, bodies, q[None], np.zeros((0, 3)))
        scene.add_grid("/ground", width=4 * self.radius, height=4 * self.radius)
        server.initial_camera.look_at = centre
        server.initial_camera.position = centre + self.radius * np.array([1.4, -1.0, 0.6])

    def show_robot(self, q: Floats) -> None:
        """Put the robot's joints to ``q`` (dof,)."""
        for frame, matrix in zip(self._frames[1:], joint_matrices(self._robot, q[None])[0], strict=True):
            place(frame, matrix)

    def show_path(self, path: Floats) -> None:
        """Draw the tool's way along a joint path (k, dof), in place of the last one; none where it is empty."""
        points = tool_positions(self._robot, dense_path(path, 0.05)) if len(path) > 1 else np.zeros((0, 3))
        ends = np.stack([points[:-1], points[1:]], axis=1)
        self._scene.add_line_segments("/path", ends, _rgb(PATH), thickness=0.01, visible=len(ends) > 0)

    def show_scene(self, scene: Scene, blamed: frozenset[str]) -> None:
        """Put the obstacles where ``scene`` has them; those ``blamed`` for the missing path are red."""
        for item in scene.obstacles:
            handle = self.obstacles[item.name]
            place(handle, item.placement)
            handle.color = _rgb(TOUCHING if item.name in blamed else self._colours[item.object])


def place(handle: viser.SceneNodeHandle, matrix: Floats) -> None:
    """Put a scene node to a placement (4, 4)."""
    x, y, z, w = quaternion_of(matrix[:3, :3])
    handle.position, handle.wxyz = matrix[:3, 3], (w, x, y, z)


def _draw(scene: viser.SceneApi, name: str, shape: Shape, placement: Floats, rgba: tuple[float, ...]) -> Any:
    colour, opacity = _rgb(rgba), rgba[3] if rgba[3] < 1 else None
    match shape:
        case Box(size):
            handle = scene.add_box(name, colour, size, opacity=opacity)
        case Sphere(radius):
            handle = scene.add_icosphere(name, radius, colour, opacity=opacity)
        case Cylinder(radius, length):
            handle = scene.add_cylinder(name, radius, length, colour, opacity=opacity)
        case Capsule() | Mesh():
            mesh = capsule_mesh(shape) if isinstance(shape, Capsule) else shape
            handle = scene.add_mesh_simple(
                name, mesh.vertices, mesh.triangles, color=colour, opacity=opacity, side="double"
            )
    place(handle, placement)
    return handle


def _rgb(rgba: tuple[float, ...]) -> tuple[int, int, int]:
    red, green, blue, *_ = (round(255 * value) for value in rgba)
    return red, green, blue
