"""Robots, scenes, checkers and small plans, made once for all tests."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from planner.base.resources import robot_names, scene_names
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.request import PlanRequest
from planner.roadmap.build import build_roadmap
from planner.roadmap.roadmap import Roadmap
from planner.robot.files.packages import example_robot_data
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Body, Box, Capsule, Cylinder, Obstacle, Shape, Sphere

ROBOTS = robot_names()


SCENES = scene_names()

UR3 = str(example_robot_data() / "robots/ur_description/urdf/ur3_robot.urdf")  # no SRDF; links of several pieces


@cache
def load(name: str) -> Robot:
    return Robot.load(name)


@cache
def checker_of(robot: str, scene: str = "empty", margin: float = 0.0) -> CollisionChecker:
    return make_checker(load(robot), Scene.load(scene), margin=margin)


@cache
def small_plan() -> Plan:
    return plan(request=PlanRequest.from_options(nodes=150), timing=None)


def joint_xml(name: str, parent: str, child: str, kind: str = "revolute", axis: str = "0 0 1", **more: str) -> str:
    """A joint's URDF; ``xyz``, ``rpy`` and ``limit`` ("lower upper") may be given."""
    lower, upper = more.get("limit", "-1 1").split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
        f'<origin xyz="{more.get("xyz", "0 0 0")}" rpy="{more.get("rpy", "0 0 0")}"/>'
        f'<limit lower="{lower}" upper="{upper}" velocity="1" effort="1"/></joint>'
    )


def link_xml(name: str, geometry: str = "", origin: str = "") -> str:
    """A link's URDF, with one collision geometry if given."""
    body = f"<collision>{origin}<geometry>{geometry}</geometry></collision>" if geometry else ""
    return f'<link name="{name}">{body}</link>'


def geometry_xml(shape: Shape) -> str:
    match shape:
        case Box(size):
            return f'<box size="{size[0]!r} {size[1]!r} {size[2]!r}"/>'
        case Sphere(radius):
            return f'<sphere radius="{radius!r}"/>'
        case Cylinder(radius, length):
            return f'<cylinder radius="{radius!r}" length="{length!r}"/>'
        case Capsule(radius, length):
            return f'<capsule radius="{radius!r}" length="{length!r}"/>'
    raise TypeError(shape)


def random_q(robot: Robot, n: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(robot.lower, robot.upper, size=(n, robot.dof))


def body(shape: Shape, placement: np.ndarray | None = None, joint: int = 0) -> Body:
    return Body("body", "link", joint, shape, np.eye(4) if placement is None else placement)


def scene_of(*items: tuple[Shape, np.ndarray]) -> Scene:
    return Scene("made", tuple(Obstacle(f"thing{k}", shape, place) for k, (shape, place) in enumerate(items)))


@cache
def make_post() -> CollisionChecker:
    """planar_2r with a post in its way: it has to fold to get from one side to the other."""
    return make_checker(load("planar_2r"), scene_of((Box((0.1, 0.02, 0.2)), pose([0.75, 0, 0]))))


POST_START, POST_GOAL = np.array([-1.0, 0.8]), np.array([1.0, -0.8])


@cache
def post_roadmap(nodes: int = 60, seed: int = 0) -> Roadmap:
    """A small roadmap of planar_2r around the post."""
    return build_roadmap(load("planar_2r"), make_post(), POST_START, POST_GOAL, nodes, seed)


def planar_trap(folder: Path) -> Path:
    """Two posts next to the planar arm's first link: it cannot turn from one side to the other."""
    path = folder / "trap.yaml"
    path.write_text(
        "obstacles:\n"
        "  - {name: left, type: box, size: [0.02, 0.6, 0.4], position: [0.0, 0.5, 0.0]}\n"
        "  - {name: right, type: box, size: [0.02, 0.6, 0.4], position: [0.0, -0.5, 0.0]}\n"
    )
    return path


# arms of four and five axes, with right angles as URDFs round them

UP, DOWN = "1.5708 0 0", "3.1416 0 0"
FEW_AXES: dict[str, list[tuple[str, str, str, str]]] = {  # kind, limits, and where the joint is in the one before
    "five axes": [
        ("revolute", "-2 2", "0 0 0.09", "0 0 0"),
        ("revolute", "-1.8 1.8", "0 0 0.05", f"-{UP}"),
        ("revolute", "-2.6 2.6", "0 -0.15 0", "0 0 0"),
        ("revolute", "-2 2", "0 -0.15 0", "0 0 0"),
        ("revolute", "-3 3", "0 -0.05 0", UP),
    ],
    "scara": [
        ("revolute", "-2.5 2.5", "0 0 0.3", "0 0 0"),
        ("revolute", "-2.5 2.5", "0.3 0 0", DOWN),
        ("prismatic", "0 0.2", "0.25 0 0", "0 0 0"),
        ("revolute", "-3 3", "0 0 0", "0 0 0"),
    ],
    "four that turn": [
        ("revolute", "-2 2", "0 0 0.3", "0 0 0"),
        ("revolute", "-1.8 1.8", "0.1 0 0.05", f"-{UP}"),
        ("revolute", "-2.6 2.6", "0.4 0 0", "0 0 0"),
        ("revolute", "-3 3", "0.3 0 0.1", UP),
    ],
}


def arm_of_few_axes(name: str, urdf_file: Callable[..., str], exact: bool = False) -> Robot:
    """One of ``FEW_AXES``, with right angles as its URDF rounds them, or as ``exact`` as doubles are."""
    links = [link_xml("l0"), *(link_xml(f"l{k}", '<sphere radius="0.01"/>') for k in range(1, 6)), link_xml("tcp")]
    joints, last = "", len(FEW_AXES[name])
    for k, (kind, limit, xyz, rpy) in enumerate(FEW_AXES[name]):
        for rounded, angle in (("1.5708", np.pi / 2), ("3.1416", np.pi)) if exact else ():
            rpy = rpy.replace(rounded, repr(float(angle)))
        joints += joint_xml(f"j{k}", f"l{k}", f"l{k + 1}", kind, limit=limit, xyz=xyz, rpy=rpy)
    tip = (
        f'<joint name="tip" type="fixed"><parent link="l{last}"/><child link="tcp"/><origin xyz="0.02 0 0.05"/></joint>'
    )
    return Robot.load(urdf_file("".join([*links[: last + 1], links[-1]]) + joints + tip, f"arm{exact}"), tool="tcp")
