"""MoveIt requests: the example with one field changed, and the query of the planner, measured."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import yaml
from scipy.spatial.transform import Rotation

from planner.base.errors import PlannerError
from planner.problem.conditions import AxisConstraint
from planner.problem.request import PlanRequest
from planner.query.query import Query, make_query
from planner.robot.moveit.requests import goal_targets, read_motion_plan_request
from planner.robot.robot import Robot
from planner.robot.robot_in_scene import notes
from planner.robot.scene import Scene
from tests.refusals import refusal_of
from tests.robot.files.moveit.samples import REQUEST, SCENE, changed

GOAL = "goal_constraints.0"
ROD = {
    "id": "rod",
    "primitives": [{"type": "box", "dimensions": [0.02, 0.02, 0.04]}],
    "primitive_poses": [{"position": [0, 0, 0.12]}],
}
ATTACHED = [{"link_name": "panda_hand", "object": ROD, "touch_links": ["panda_leftfinger", "panda_rightfinger"]}]


def asked(folder: Path, request: dict, scene: dict | None = None, **options: Any) -> Query:
    (folder / "r.yaml").write_text(yaml.safe_dump(request))
    (folder / "s.yaml").write_text(yaml.safe_dump(SCENE if scene is None else scene))
    options = {"robot": "panda", "collision": "coal", "ik_solutions": 1} | options
    return make_query(
        PlanRequest.from_options(scene=str(folder / "s.yaml"), motion_plan_request=folder / "r.yaml", **options).what
    )


def placement(robot: Robot, frame: str, q: np.ndarray) -> np.ndarray:
    """The placement (4, 4) of a frame by Pinocchio's own kinematics."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return data.oMf[robot.model.getFrameId(frame)].homogeneous


def notes_of(query: Query) -> str:
    return " ".join(note.text for note in notes(query.robot, query.scene))


def link_goal(link: str, **more: Any) -> dict:
    region = {
        "primitives": [{"type": 2, "dimensions": [1e-3]}],
        "primitive_poses": [{"position": [0.45, 0.25, 0.5]}],
    }
    place = {"link_name": link, "constraint_region": region} | more.pop("place", {})
    return changed(REQUEST, GOAL, {"position_constraints": [place], **more})


@pytest.mark.parametrize("link", ["panda_link7", "panda_hand", "panda_hand_tcp", "panda_link5", "panda_leftfinger"])
def test_a_goal_of_any_link_brings_that_link_there(link: str, tmp_path: Path) -> None:
    turn = [] if link == "panda_link5" else [{"link_name": link, "orientation": [1, 0, 0, 0]}]
    query = asked(tmp_path, link_goal(link, orientation_constraints=turn))
    reached = placement(query.robot, link, query.goals[0])
    np.testing.assert_allclose(reached[:3, 3], [0.45, 0.25, 0.5], atol=1e-3)
    if turn:
        np.testing.assert_allclose(reached[:3, :3], np.diag([1, -1, -1]), atol=1e-5)
    assert query.robot.tool == "panda_hand_tcp"
    assert (f" of {link}" in query.goal_names[0]) == (link != "panda_hand_tcp")


def test_a_goal_in_a_fixed_frame(tmp_path: Path) -> None:
    """A camera's frame, turned by a quarter about z: its x is the world's y."""
    quarter = [0, 0, 0.5**0.5, 0.5**0.5]
    transforms = [{"child_frame_id": "camera", "transform": {"translation": [0.7, 0, 0.4], "rotation": quarter}}]
    goal = link_goal("panda_hand", place={"header": {"frame_id": "camera"}})
    goal["goal_constraints"][0]["orientation_constraints"] = [
        {"header": {"frame_id": "/camera"}, "link_name": "panda_hand", "orientation": [1, 0, 0, 0]}
    ]
    region = goal["goal_constraints"][0]["position_constraints"][0]["constraint_region"]
    region["primitive_poses"][0]["position"] = [0.25, 0.25, 0.1]
    query = asked(tmp_path, goal, changed(SCENE, "fixed_frame_transforms", transforms))
    reached = placement(query.robot, "panda_hand", query.goals[0])
    np.testing.assert_allclose(reached[:3, 3], [0.45, 0.25, 0.5], atol=1e-3)
    np.testing.assert_allclose(reached[:3, 0], [0, 1, 0], atol=1e-5)


def test_a_request_attaches_an_object_to_the_arm(tmp_path: Path) -> None:
    query = asked(tmp_path, changed(REQUEST, "start_state.attached_collision_objects", ATTACHED))
    (rod,) = query.robot.carried
    assert (rod.name, rod.joint) == ("rod", 7)
    assert query.robot.identity != asked(tmp_path, REQUEST).robot.identity
    assert frozenset(("rod", "panda_leftfinger")) in query.robot.touching
    long = changed(REQUEST, "start_state.attached_collision_objects", ATTACHED)
    long["start_state"]["attached_collision_objects"][0]["object"]["primitives"][0]["dimensions"] = [0.02, 0.02, 1.2]
    assert "start is in collision: 'rod'" in refusal_of(lambda: asked(tmp_path, long))


def test_a_start_that_is_a_difference_is_the_scenes_for_the_rest(tmp_path: Path) -> None:
    state = REQUEST["start_state"]["joint_state"]
    few = {"joint_state": {"name": state["name"][:1], "position": [-0.5]}, "is_diff": True}
    scene = changed(SCENE, "robot_state.joint_state", state)
    query = asked(tmp_path, changed(REQUEST, "start_state", few), scene)
    np.testing.assert_allclose(query.starts[0], [-0.5, *state["position"][1:7]])
    assert query.robot.fixed_joints["panda_finger_joint1"] == 0.03
    with pytest.raises(PlannerError, match="got none of panda_joint2"):
        asked(tmp_path, changed(REQUEST, "start_state", few))


def test_joints_that_are_held_must_be_where_a_goal_wants_them(tmp_path: Path) -> None:
    def closing(value: float, **more: float) -> dict:
        finger = {"joint_name": "panda_finger_joint1", "position": value, **more}
        goals = [*REQUEST["goal_constraints"][0]["joint_constraints"], finger]
        return changed(REQUEST, GOAL, {"joint_constraints": goals})

    held = asked(tmp_path, closing(0.03))
    np.testing.assert_array_equal(held.goals, asked(tmp_path, REQUEST).goals)
    asked(tmp_path, closing(0.02, tolerance_above=0.01))
    text = refusal_of(lambda: asked(tmp_path, closing(0.02)))
    assert "wants joint 'panda_finger_joint1' at 0.02, but it is not planned, and held at 0.03" in text
    lacking = changed(REQUEST, f"{GOAL}.joint_constraints.6.joint_name", "panda_joint_7")
    assert "got none of panda_joint7" in refusal_of(lambda: asked(tmp_path, lacking))


def kept(**constraints: Any) -> dict:
    return changed(REQUEST, "path_constraints", constraints)


TILT = {"link_name": "panda_hand", "orientation": [1, 0, 0, 0], "weight": 1.0}


def tolerances(x: float, y: float, z: float, **more: Any) -> dict:
    given = {f"absolute_{axis}_axis_tolerance": value for axis, value in (("x", x), ("y", y), ("z", z))}
    return {"orientation_constraints": [TILT | given | more]}


@pytest.mark.parametrize(
    ("constraints", "texts"),
    [
        (tolerances(3.0, 3.0, 3.2), ["axis:z,0,0,-1,1.5707963267948966"]),
        (tolerances(3.2, 1.4, 1.5), ["axis:x,1,0,0,1.4"]),
        (tolerances(1.5, 1.4, 3.14), ["axis:z,0,0,-1,1.4", "turn:1.5707963267948966,1,0,0,0"]),
        (tolerances(1.4, 1.4, 1.4), ["turn:1.4,1,0,0,0"]),
        (tolerances(1.4, 4.0, 1.3, parameterization=1), [f"axis:y,0,-1,0,{2 * math.asin(1.3 / math.pi)!r}"]),
        (tolerances(3.2, 1.6, 3.2), []),
    ],
)
def test_three_tolerances_become_a_cone_an_axis_or_both(constraints: dict, texts: list[str], tmp_path: Path) -> None:
    """Written by hand from the docs: the hand of the panda points down at the request's start."""
    query = asked(tmp_path, kept(**constraints))
    assert list(query.checker.world.constraints.texts) == [f"{text} of panda_hand" for text in texts]
    assert "inside them is followed: path_constraints." in notes_of(query)


@pytest.mark.parametrize("parameterization", [0, 1])
def test_states_within_the_constraint_lie_inside_the_tolerances(parameterization: int, tmp_path: Path) -> None:
    """SciPy's angles and rotation vectors of thousands of orientations, many of them just inside the cone."""
    robot, rng, inside = Robot.load("panda"), np.random.default_rng(parameterization), 0
    for _ in range(40):
        most = rng.choice([0.0, 0.02, 0.3, 1.0, 1.5, 1.6, 2.5, 3.0, 3.14, 3.2], 3) * rng.uniform(0.98, 1.0)
        about = Rotation.from_quat(rng.normal(size=4))
        turn = tolerances(*most, orientation=about.as_quat().tolist(), parameterization=parameterization)
        (tmp_path / "r.yaml").write_text(yaml.safe_dump(json.loads(json.dumps(changed(REQUEST, GOAL, turn)))))
        if min(most[0], most[2], 2 * most[1]) >= np.pi:
            continue
        (target,) = goal_targets(read_motion_plan_request(tmp_path / "r.yaml"), robot, Scene("x"))
        size = np.minimum(rng.choice([0.05, 0.5, 1.0, 2.0, 4.0], 3000), np.pi)
        axes = rng.normal(size=(3000, 3)) * (most + 1e-3) ** rng.choice([0, 1, 2], (3000, 1))
        off = Rotation.from_rotvec(size[:, None] * axes / np.linalg.norm(axes, axis=1)[:, None])
        turned = (about * off).as_matrix()
        for each in target.conditions:
            if isinstance(each, AxisConstraint):
                cosine = np.einsum("ni,i->n", turned[:, :, "xyz".index(each.axis)], each.direction)
                holds = np.arccos(np.clip(cosine, -1, 1)) <= each.angle
            else:
                holds = (
                    Rotation.from_quat(each.quaternion).inv() * Rotation.from_matrix(turned)
                ).magnitude() <= each.angle
            off, turned = off[holds], turned[holds]
        inside += len(off)
        if len(off):
            angles = off.as_rotvec() if parameterization else off.as_euler("XYZ")
            assert (np.abs(angles) <= most + 1e-6).all()
    assert inside > 2000


def test_tolerances_of_a_goal_are_met_and_used(tmp_path: Path) -> None:
    """Within them, but all over them: a goal that may turn about its axis is reached in many turns."""
    goal = link_goal("panda_hand", **tolerances(0.05, 0.1, 4))
    query, turns = asked(tmp_path, goal, ik_solutions=8), []
    assert "inside them is followed: goal 1." in notes_of(query)
    for q in query.goals:
        reached = placement(query.robot, "panda_hand", q)
        assert np.linalg.norm(reached[:3, 3] - [0.45, 0.25, 0.5]) <= 1e-3 + 2e-6
        off = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]) @ reached[:3, :3]).as_euler("XYZ")
        assert (np.abs(off[:2]) <= [0.05 + 2e-6, 0.1 + 2e-6]).all()
        turns.append(off[2])
    assert np.ptp(turns) > 1.0
