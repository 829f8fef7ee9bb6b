"""The live page on viser: a gizmo moves obstacles and the goal, and each change is planned at once."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import viser
import websockets.asyncio.server as websocket_server

from planner.base.arrays import Floats
from planner.base.errors import PlannerError, choices
from planner.constraints.tool_bound import Frame
from planner.kinematics.forward import tool_positions
from planner.planning.result import Plan
from planner.problem.targets import HOME, Pose, follow_names, joints_text, parse_target, parse_targets
from planner.query.query import states_of
from planner.robot.poses import pose, quaternion_of
from planner.robot.robot import Robot
from planner.robot.scene import Scene, write_scene
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.session.session import Session
from planner.trajectory.measure import clearance_text, dense_path
from planner.view.drawing import PATH, TOUCHING, extent, joint_matrices, load_drawn_bodies, obstacle_colours
from planner.view.motion import configurations_at, path_shares
from planner.view.surfaces import capsule_mesh, smooth_mesh

GOAL = "the goal"
HOST = "127.0.0.1"


@dataclass(frozen=True)
class Question:
    """Start and goal as text, and beta."""

    start: str
    goal: str
    beta: float


class Answer(NamedTuple):
    question: Question
    plan: Plan  # with the world at its time


class LivePage:
    """A session, its question, and the page that changes both; Save writes the scene to the file ``out``.

    Raises :class:`PlannerError` for a question that cannot be planned.
    """

    def __init__(self, session: Session, question: Question, out: Path) -> None:
        self._session, self._out = session, out
        self._lock = threading.Lock()  # viser calls from several threads
        self.answers = [self._plan(question)]
        self.server = start_server()
        q = self._start()
        self._picture = Picture(self.server, session.robot, session.scene, q)
        self._add_controls(self.server.gui, question)
        self._gizmo = self.server.scene.add_transform_controls("/gizmo", scale=0.4 * self._picture.radius)
        self._gizmo.on_update(self._drag)
        self._gizmo.on_update(self._drop)
        self._goal = self.server.scene.add_icosphere("/goal", 0.022, (204, 26, 38))
        self._show()

    @property
    def address(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self.server.get_port()}/"

    def close(self) -> None:
        """Stop planning, then the server."""
        self._session.close()
        with self._lock:
            self.server.stop()

    def plan(self) -> None:
        """Plan from the start in the page's field, with the slider's beta."""
        self._change(start=self.start.value, beta=float(self.beta.value))

    def undo(self) -> None:
        """Restore the answer before the last change."""
        with self._lock:
            if len(self.answers) > 1:
                self.answers.pop()
            self._show()

    def save(self) -> None:
        """Write the scene with its start and goal, for 'planner plan --scene FILE'."""
        with self._lock:
            robot, scene = self._session.robot, self._session.scene
            own = {"start": joints_text(self._start().tolist()), "goal": self._goal_text()}
            states = {**scene.states, robot.name: {**scene.states_of(robot.name), **own}}
            try:
                files = write_scene(replace(scene, name=self._out.stem, states=states), self._out)
                self.outcome.value = f"Written: {', '.join(map(str, files))}"
            except PlannerError as error:
                self.outcome.value = str(error)

    def move(self, name: str, position: Floats, quaternion: list[float]) -> None:
        """Move an obstacle, or GOAL, to a position (m) and a quaternion [x, y, z, w], then plan."""
        if name != GOAL:
            return self._change(lambda: self._session.move(name, position, quaternion=quaternion))
        numbers = [*position.tolist(), *(quaternion if isinstance(parse_target(self._goal_text()), Pose) else ())]
        kind = "xyz" if len(numbers) == 3 else "pose"
        return self._change(goal=f"{kind}:{','.join(map(repr, numbers))}")

    def _change(self, apply: Callable[[], object] = lambda: None, **changes: Any) -> None:
        """Apply a change and plan the changed question; on an error undo the change and show the reason."""
        with self._lock:
            self.outcome.value = "Planning ..."
            refusal = PlannerError("the planner failed: see the terminal.")
            try:
                apply()
                self.answers.append(self._plan(replace(self.answers[-1].question, **changes)))
                refusal = None
            except PlannerError as error:
                refusal = error
            finally:
                self._show(refusal)

    def _plan(self, question: Question) -> Answer:
        return Answer(question, self._session.plan(question.start, question.goal, beta=question.beta, timing=None))

    def _goal_text(self) -> str:
        """Return the goal that is reached, or the first one, in numbers."""
        answer, robot = self.answers[-1], self._session.robot
        known = {HOME: joints_text(robot.home), **states_of(robot, self._session.scene)}
        return follow_names(answer.plan.goal or parse_targets(answer.question.goal)[0].text, known)[0]

    def _start(self) -> Floats:
        """Return (dof,) the first configuration of the path, or of the roadmap's starts."""
        plan = self.answers[-1].plan
        return plan.path[0] if plan.solved else plan.roadmap.nodes[plan.roadmap.starts[0]]

    def _goal_placement(self) -> Floats:
        """Return (4, 4) the tool's pose at the goal that is reached, or at the first one."""
        plan, robot = self.answers[-1].plan, self._session.robot
        q = plan.path[-1] if plan.solved else plan.roadmap.nodes[plan.roadmap.goals[0]]
        rotation, position = Frame.tool(robot).poses(robot, q[None])
        return pose(position[0].tolist(), quaternion=quaternion_of(rotation[0]))

    def _add_controls(self, gui: viser.GuiApi, question: Question) -> None:
        self.outcome = gui.add_text("outcome", "", multiline=True, disabled=True)
        self.chosen = gui.add_dropdown("move", [GOAL, *self._picture.obstacles])
        self.start = gui.add_text("start", question.start)
        self.beta = gui.add_slider("beta", 0.0, 1.0, 0.01, question.beta, hint="0: manipulability, 1: distance")
        self.share = gui.add_slider("along the path", 0.0, 1.0, 0.005, 0.0)
        self.chosen.on_update(lambda _: self._place_gizmo())
        self.share.on_update(lambda _: self._show_robot())
        for name, act in (("Plan", self.plan), ("Undo", self.undo), ("Save", self.save)):
            gui.add_button(name).on_click(lambda _, act=act: act())

    async def _drag(self, event: viser.TransformControlsEvent) -> None:
        """Let the obstacle follow the gizmo; async, so that viser keeps the order of events."""
        if self.chosen.value != GOAL:
            handle = self._picture.obstacles[self.chosen.value]
            handle.position, handle.wxyz = event.target.position, event.target.wxyz

    def _drop(self, event: viser.TransformControlsEvent) -> None:
        if event.phase == "end":
            w, x, y, z = event.target.wxyz.tolist()
            self.move(self.chosen.value, event.target.position, [x, y, z, w])

    def _show(self, refusal: PlannerError | None = None) -> None:
        """Show the last answer, and restore its world."""
        answer = self.answers[-1]
        plan = answer.plan
        self._session.world.restore(plan.checker)
        reason = plan.reason if refusal is None else refusal.reason
        self._picture.show_scene(self._session.scene, frozenset() if reason is None else reason.names)
        self._picture.show_path(plan.path)
        set_pose(self._goal, self._goal_placement())
        self._place_gizmo()
        self._show_robot()
        self.start.value, self.beta.value = answer.question.start, answer.question.beta
        self.outcome.value = "\n".join(self._sentences(plan)) if refusal is None else str(refusal)

    def _sentences(self, plan: Plan) -> list[str]:
        """Return the outcome, the cost and the clearance of a plan."""
        rows = [plan.message]
        if plan.cost is not None:
            omega, distance = plan.cost.manipulability, plan.cost.distance
            rows.append(f"cost {plan.cost.total:.4f} (manipulability {omega:.4f}, distance {distance:.4f})")
        if plan.clearance is not None and plan.clearance.path is not None:
            rows.append(f"clearance {clearance_text(plan.clearance.path.min)}")
        if self._session.scene.moving:
            rows.append(f"Moving obstacles are ignored: {choices(o.name for o in self._session.scene.moving)}.")
        return [*rows, f"planned in {plan.seconds:.2f} s"]

    def _place_gizmo(self) -> None:
        chosen: Any = self.chosen.value
        obstacles = {item.name: item.placement for item in self._session.scene.obstacles}
        set_pose(self._gizmo, self._goal_placement() if chosen == GOAL else obstacles[chosen])

    def _show_robot(self) -> None:
        plan, share = self.answers[-1].plan, np.array([self.share.value])
        q = configurations_at(plan.path, path_shares(plan.path)[0], share)[0] if plan.solved else self._start()
        self._picture.show_robot(q)


def start_server() -> viser.ViserServer:
    """Return a viser server on the loopback address; it accepts only pages of its own."""
    origins: list[Any] = []
    serve = websocket_server.serve
    websocket_server.serve = partial(serve, origins=origins)  # viser has no option for it
    try:
        server = viser.ViserServer(host=HOST, verbose=False)
    finally:
        websocket_server.serve = serve
    origins += [f"http://{name}:{server.get_port()}" for name in (HOST, "localhost")]
    server.gui.configure_theme(show_share_button=False, show_logo=False)  # sharing sends data off this machine
    return server


class Picture:
    """The objects of a viser scene: the robot, the obstacles by name, a path of the tool."""

    def __init__(self, server: viser.ViserServer, robot: Robot, world: Scene, q: Floats) -> None:
        scene = server.scene
        self._scene, self._robot = scene, robot
        joints = range(len(joint_matrices(robot, q[None])[0]) + 1)
        self._frames = [scene.add_frame(f"/robot/{joint}", show_axes=False) for joint in joints]
        bodies = (*load_drawn_bodies(robot)[0], *robot.carried)
        for k, body in enumerate(bodies):
            _draw(scene, f"/robot/{body.joint}/{k}", body.shape, body.placement, body.color)
        self._colours = obstacle_colours(world)
        self.obstacles = {
            item.name: _draw(
                scene, f"/obstacles/{k}", smooth_mesh(item.shape), item.placement, self._colours[item.object]
            )
            for k, item in enumerate(world.obstacles)
        }
        for k, item in enumerate(world.moving):
            _draw(scene, f"/moving/{k}", smooth_mesh(item.shape), item.motion.poses[0], self._colours[item.name])
        centre, self.radius = extent(robot, world, bodies, q[None], np.zeros((0, 3)))
        scene.add_grid("/ground", width=4 * self.radius, height=4 * self.radius)
        server.initial_camera.look_at = centre
        server.initial_camera.position = centre + self.radius * np.array([1.4, -1.0, 0.6])

    def show_robot(self, q: Floats) -> None:
        """Move the robot's joints to ``q`` (dof,)."""
        for frame, matrix in zip(self._frames[1:], joint_matrices(self._robot, q[None])[0], strict=True):
            set_pose(frame, matrix)

    def show_path(self, path: Floats) -> None:
        """Draw the tool's path along a joint path (k, dof) in place of the last one; none if it is empty."""
        points = tool_positions(self._robot, dense_path(path, 0.05)) if len(path) > 1 else np.zeros((0, 3))
        ends = np.stack([points[:-1], points[1:]], axis=1)
        self._scene.add_line_segments("/path", ends, _rgb(PATH), thickness=0.01, visible=len(ends) > 0)

    def show_scene(self, scene: Scene, blamed: frozenset[str]) -> None:
        """Move the obstacles to ``scene``; those ``blamed`` for the missing path are red."""
        for item in scene.obstacles:
            handle = self.obstacles[item.name]
            set_pose(handle, item.placement)
            handle.color = _rgb(TOUCHING if item.name in blamed else self._colours[item.object])


def set_pose(handle: viser.SceneNodeHandle, matrix: Floats) -> None:
    """Move a scene node to a placement (4, 4)."""
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
    set_pose(handle, placement)
    return handle


def _rgb(rgba: tuple[float, ...]) -> tuple[int, int, int]:
    red, green, blue, *_ = (round(255 * value) for value in rgba)
    return red, green, blue
