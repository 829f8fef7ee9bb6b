"""What a command does first with a file of each kind."""

from __future__ import annotations

import json
import shutil
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.fuzz.mesh_files import robot_with_mesh
from planner import gabf
from planner.base.beside import mismatch
from planner.base.resources import robots_folder
from planner.batch.tasks import read_tasks
from planner.collision import BACKENDS, make_checker
from planner.collision.edge_prover import EdgeProver
from planner.construction.repair import verify
from planner.kinematics.manipulability import manipulability
from planner.models.files.moveit.requests import read_motion_plan_request
from planner.models.model_checks import notes
from planner.models.robot import Robot, with_carried
from planner.models.scene import Scene
from planner.paths.file import read_joint_path
from planner.problem.request import LimitsRequest, PlanRequest
from planner.problem.targets import parse_target
from planner.roadmap.storage import load_roadmap
from planner.setup.message import goals_of, joints_of
from planner.trajectory.check import check_trajectory
from planner.trajectory.export import export
from planner.trajectory.file import TRAJECTORY_NAME, load_trajectory
from planner.trajectory.limits import MotionLimits
from planner.trajectory.points import read_points
from planner.trajectory.report import report_record, report_rows

KERNEL = gabf.TradeOff(beta=0.5)  # of networks
ARM = "planar_2r"  # two joints: every use takes milliseconds


@cache
def arm() -> Robot:
    """The robot of all files that name none of their own."""
    return Robot.load(ARM)


def use_robot(path: Path) -> None:
    """A robot in the empty scene: a state is checked, a motion proven, w computed."""
    robot = Robot.load(str(path))
    _use(robot, Scene.load("empty"))


def use_scene(path: Path) -> None:
    """The scene around the planar arm; targets of named states are read."""
    scene = Scene.load(str(path))
    placement = scene.placement(ARM)
    robot = Robot.load(ARM, placement.tool, placement.fixed_joints, placement.base.matrix())
    for text in scene.states_of(ARM).values():
        parse_target(text)
    _use(with_carried(robot, scene.carried), scene)


def use_mesh(path: Path) -> None:
    """The mesh as an obstacle, and as a link."""
    scene = path.with_suffix(".yaml")
    scene.write_text(f"obstacles: [{{name: part, type: mesh, file: {path.name}}}]\n")
    use_scene(scene)
    urdf = path.with_suffix(".urdf")
    urdf.write_text(robot_with_mesh(path.name))
    use_robot(urdf)


def use_request(path: Path) -> None:
    """Start and goals, with the targets that they are to the arm."""
    message, scene = read_motion_plan_request(path), Scene.load("empty")
    joints_of(message, arm(), scene)
    goals_of(message, arm(), scene)


def use_path(path: Path) -> None:
    """The path in the arm's order of joints."""
    read_joint_path(path, arm())


def use_trajectory(path: Path) -> None:
    """The trajectory of the arm is checked in the empty scene, and ours is exported."""
    points = read_points(path, arm())
    if points is None:
        read_joint_path(path, arm())
        return
    own = points.limits or MotionLimits.of(arm())
    report = check_trajectory(make_checker(arm(), Scene.load("empty"), "coal"), points, own, step=0.05)
    report_rows(report)
    json.dumps(report_record(report), allow_nan=False)
    if path.name.endswith(TRAJECTORY_NAME):
        export(load_trajectory(path), "ros-json")


def use_limits(path: Path) -> None:
    """The arm's limits with those of the file."""
    MotionLimits.of(arm(), LimitsRequest(limits=path)).text()


def use_roadmap(path: Path) -> None:
    """The roadmap, held against a checker, its hash and components."""
    roadmap = load_roadmap(path)
    if roadmap.origin.joints == arm().joints:
        verify(roadmap, make_checker(arm(), Scene.load("empty"), "coal"))
    _ = roadmap.connected, roadmap.sha256


def use_network(path: Path) -> None:
    """The network under a kernel."""
    gabf.read_network(path, KERNEL)


def use_robot_file(path: Path) -> None:
    """The robot that a robot.yaml says, in a folder of its own as it is named there."""
    folder = path.with_name("robot")
    shutil.copytree(robots_folder() / ARM, folder, dirs_exist_ok=True)
    shutil.copy(path, folder / "robot.yaml")
    _use(Robot.load(str(folder / "robot.yaml")), Scene.load("empty"))


def use_batch(path: Path) -> None:
    """The plans that a batch would make."""
    read_tasks(path, PlanRequest(robot=ARM, scene="empty", nodes=20))


def use_record(path: Path) -> None:
    """A plan's record beside files: whether these fit, and the path in it."""
    record = path.with_name("plan.json")
    shutil.copy(path, record)
    record.with_name("roadmap.npz").write_bytes(b"")
    mismatch(record)
    mismatch(record.with_name("roadmap.npz"))
    read_joint_path(record, arm())


def _use(robot: Robot, scene: Scene) -> None:
    notes(robot, scene)
    _ = robot.identity, scene.identity
    q = np.array([robot.home, 0.5 * (robot.lower + robot.upper)])
    manipulability(robot, q)
    for checker in (make_checker(robot, scene, backend) for backend in BACKENDS):
        checker.first_contact(q)
        checker.bound.looks_free(q)
        EdgeProver(checker).prove(q[:1], 0.01 * np.ones_like(q[:1]))
