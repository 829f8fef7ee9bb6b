"""MoveIt's files as they come: messages as YAML, scene text, requests; and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from planner.base.errors import PlannerError, SceneError, StateError
from planner.base.request import PlanRequest
from planner.collision import make_checker
from planner.collision.checker import contact_of
from planner.query.open import make_query
from planner.world.moveit.requests import LinkGoal, read_motion_plan_request
from planner.world.moveit.scene_text import scene_text
from planner.world.moveit.scenes import planning_scene
from planner.world.robot import Robot, with_carried
from planner.world.scene import Scene
from planner.world.shapes import Box, Carried, Cylinder, Mesh, Sphere

SAMPLE = Path(__file__).resolve().parents[4] / "shared" / "mbm-panda-sample"
PROBLEMS = sorted(SAMPLE.glob("*/scene*.yaml"))
HERE = Path("test.yaml")

BOX = {"id": "crate", "primitives": [{"type": "box", "dimensions": [0.1, 0.2, 0.3]}],
       "primitive_poses": [{"position": [1, 2, 3], "orientation": [0, 0, 0.5**0.5, 0.5**0.5]}]}  # fmt: skip


def scene(*objects: dict, **more: object) -> dict:
    return {"world": {"collision_objects": list(objects)}, **more}


def test_a_box_with_its_pose() -> None:
    (crate,) = planning_scene(scene(BOX), HERE).obstacles
    assert crate.name == crate.object == "crate"
    assert crate.shape == Box((0.1, 0.2, 0.3))
    np.testing.assert_allclose(crate.placement[:3, 3], [1, 2, 3])
    np.testing.assert_allclose(crate.placement[:3, 0], [0, 1, 0], atol=1e-12)


def test_height_comes_before_radius_and_types_may_be_numbers() -> None:
    shapes = [{"type": 3, "dimensions": [0.14, 0.03]}, {"type": "sphere", "dimensions": [0.2]}]
    places = [{}, {"position": {"x": 1, "y": 0, "z": 0}}]
    can = {"id": "can", "primitives": shapes, "primitive_poses": places, "pose": {"position": [0, 0, 1]}}
    first, second = planning_scene(scene(can), HERE).obstacles
    assert (first.name, second.name, first.object, second.object) == ("can.0", "can.1", "can", "can")
    assert (first.shape, second.shape) == (Cylinder(0.03, 0.14), Sphere(0.2))
    np.testing.assert_allclose(second.placement[:3, 3], [1, 0, 1])


def test_a_mesh_in_the_message() -> None:
    sheet = {"id": "sheet", "mesh_poses": [{}], "meshes": [
        {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [{"vertex_indices": [0, 1, 2]}]}]}  # fmt: skip
    (found,) = planning_scene(scene(sheet), HERE).obstacles
    assert isinstance(found.shape, Mesh)
    assert found.shape.triangles.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("bad", "part"),
    [
        ({"primitives": [{"type": "cone", "dimensions": [1, 1]}]}, "'cone' with 2 dimensions is not supported"),
        ({"primitives": [{"type": "box", "dimensions": [1, 1]}]}, "'box' with 2 dimensions"),
        ({"primitives": [{"type": "box", "dimensions": [1, 0, 1]}]}, "dimensions.1' is wrong: Input should be greater"),
        ({"primitive_poses": []}, "1 shapes and 0 poses"),
        ({"primitive_poses": [{"position": [0, float("nan"), 0]}]}, "position"),
        ({"meshes": [{"vertices": [], "triangles": [{"vertex_indices": [0, 1, 2]}]}], "mesh_poses": [{}]}, "vertices"),
    ],
)
def test_refused_objects(bad: dict, part: str) -> None:
    with pytest.raises(SceneError, match=r"test\.yaml") as caught:
        planning_scene(scene({**BOX, **bad}), HERE)
    assert part in str(caught.value)


OLD_TEXT = (
    "(noname)++\n* Box0\n1\nbox\n0.1 0.2 0.3\n1 2 3\n0 0 0 1\n0 0 0 0\n"
    "* Can\n1\ncylinder\n0.03 0.14\n0 0 1\n0 0 0 1\n0 0 0 0\n.\n"
)
NEW_TEXT = "(name)\n* Box0\n1 0 0\n0 0 0 1\n1\nbox\n0.1 0.2 0.3\n0 2 3\n0 0 0 1\n0 0 0 0\n0\n.\n"


def test_scene_text_of_both_ages() -> None:
    box, can = scene_text(OLD_TEXT, Path("a.scene")).obstacles
    assert (box.shape, can.shape) == (Box((0.1, 0.2, 0.3)), Cylinder(0.03, 0.14))
    np.testing.assert_allclose(box.placement[:3, 3], [1, 2, 3])
    (new,) = scene_text(NEW_TEXT, Path("a.scene")).obstacles
    np.testing.assert_allclose(new.placement[:3, 3], [1, 2, 3])


@pytest.mark.parametrize(
    "text", ["", OLD_TEXT[:40], OLD_TEXT.replace("box", "teapot"), OLD_TEXT.replace("0.1 0.2 0.3", "0.1 x")]
)
def test_broken_scene_text(text: str) -> None:
    with pytest.raises(SceneError, match=r"a\.scene"):
        scene_text(text, Path("a.scene"))


def test_a_scene_file_of_each_kind_loads(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(OLD_TEXT)
    (tmp_path / "b.yaml").write_text(yaml.safe_dump(scene(BOX)))
    assert [o.name for o in Scene.load(str(tmp_path / "a.scene")).obstacles] == ["Box0", "Can"]
    assert [o.name for o in Scene.load(str(tmp_path / "b.yaml")).obstacles] == ["crate"]


def test_the_matrix_allows_robot_against_object_only(tmp_path: Path) -> None:
    lump = {
        "id": "lump",
        "primitives": [{"type": "sphere", "dimensions": [0.2]}],
        "primitive_poses": [{"position": [0, 0, 1.3]}],
    }
    names = [f"iiwa14_link_{k}" for k in range(8)]
    everything = [[True] * 9 for _ in range(9)]
    allowing = scene(lump, allowed_collision_matrix={"entry_names": [*names, "lump"], "entry_values": everything})
    for message, touches in ((scene(lump), True), (allowing, False)):
        (tmp_path / "s.yaml").write_text(yaml.safe_dump(message))
        robot, world = Robot.load("iiwa14"), Scene.load(str(tmp_path / "s.yaml"))
        checker = make_checker(robot, world)
        assert (contact_of(checker, np.zeros(7)) is not None) == touches
        # what a matrix says of two robot links changes nothing
        assert len(checker.world.self_pairs) == len(make_checker(robot, Scene("none")).world.self_pairs)
    assert Scene.load(str(tmp_path / "s.yaml")).identity != Scene("x", world.obstacles).identity


def test_a_carried_box_collides_in_the_arms_stead(tmp_path: Path) -> None:
    robot = Robot.load("iiwa14")
    held = with_carried(robot, [Carried("flange", "parcel", Box((0.1, 0.1, 0.1)), np.eye(4), ("iiwa14_link_6",))])
    wall = scene({**BOX, "id": "wall", "primitive_poses": [{"position": [0, 0, 1.5]}]})
    (tmp_path / "s.yaml").write_text(yaml.safe_dump(wall))
    world = Scene.load(str(tmp_path / "s.yaml"))
    assert contact_of(make_checker(robot, world), np.zeros(7)) is None
    contact = contact_of(make_checker(held, world), np.zeros(7))
    assert contact is not None
    assert (contact.first, contact.second) == ("parcel", "wall")
    assert held.identity != robot.identity


def request_text(**goal: object) -> str:
    joints = [f"iiwa14_joint_{k}" for k in range(1, 8)]
    start = {"joint_state": {"name": joints, "position": [0, 0.5, 0, -1.2, 0, 0.8, 0]}}
    return yaml.safe_dump({"start_state": start, "goal_constraints": [goal]})


def test_a_request_gives_start_and_goal(tmp_path: Path) -> None:
    joints = [{"joint_name": f"iiwa14_joint_{k}", "position": 0.1 * k} for k in range(7, 0, -1)]
    (tmp_path / "r.yaml").write_text(request_text(joint_constraints=joints))
    query = make_query(PlanRequest(scene="empty", motion_plan_request=tmp_path / "r.yaml"))
    np.testing.assert_allclose(query.starts, [[0, 0.5, 0, -1.2, 0, 0.8, 0]])
    np.testing.assert_allclose(query.goals, [0.1 * np.arange(1, 8)])
    own = make_query(
        PlanRequest(scene="empty", motion_plan_request=tmp_path / "r.yaml", goal="xyz:0.5,0.1,0.6", ik_solutions=5)
    )
    assert len(own.goals) == 5


def test_a_request_with_a_pose_goal(tmp_path: Path) -> None:
    place = {"constraint_region": {"primitive_poses": [{"position": {"x": 0.5, "y": 0.1, "z": 0.6}}]}}
    turn = {"orientation": {"x": 0, "y": 1, "z": 0, "w": 0}}
    (tmp_path / "r.yaml").write_text(request_text(position_constraints=[place], orientation_constraints=[turn]))
    assert read_motion_plan_request(tmp_path / "r.yaml").goals == (
        LinkGoal("", (0.5, 0.1, 0.6), quaternion=(0.0, 1.0, 0.0, 0.0)),
    )
    assert len(make_query(PlanRequest(scene="empty", motion_plan_request=tmp_path / "r.yaml")).goals) == 8


@pytest.mark.parametrize(
    ("text", "part"),
    [
        (request_text(), "neither joint nor position"),
        (
            "start_state: {}\ngoal_constraints: [{joint_constraints: [{joint_name: a, position: 0}]}]",
            "no joint state to start from",
        ),
        ("goal_constraints: [{}]", "'start_state' is missing"),
        (request_text(joint_constraints=[{"joint_name": "elbow", "position": 1}]), "says nothing of iiwa14_joint_1"),
    ],
)
def test_refused_requests(tmp_path: Path, text: str, part: str) -> None:
    (tmp_path / "r.yaml").write_text(text)
    with pytest.raises(PlannerError) as caught:
        make_query(PlanRequest(scene="empty", motion_plan_request=tmp_path / "r.yaml"))
    assert part in str(caught.value)


def test_goals_are_distinct_and_all_reach_the_target() -> None:
    query = make_query(
        PlanRequest(goal="xyz:0.5,0.3,0.6", scene="empty", start="q:0,0.5,0,-1.2,0,0.8,0", ik_solutions=8)
    )
    from planner.kinematics.forward import tool_positions

    assert len(query.goals) == 8
    np.testing.assert_allclose(tool_positions(query.robot, query.goals), np.tile([0.5, 0.3, 0.6], (8, 1)), atol=1e-5)
    apart = np.abs(query.goals[:, None] - query.goals[None]).max(axis=2) + np.eye(8)
    assert apart.min() > 1e-3


def test_several_named_goals() -> None:
    query = make_query(PlanRequest(goal="home,goal", ik_solutions=2))
    assert len(query.goals) == 3


@pytest.mark.skipif(not PROBLEMS, reason="the sample of MotionBenchMaker problems is not here")
@pytest.mark.parametrize("path", PROBLEMS, ids=lambda path: f"{path.parent.name}-{path.stem[-1]}")
def test_every_sample_problem_is_read(path: Path) -> None:
    request = path.with_name(path.name.replace("scene", "request"))
    asked = PlanRequest(robot="panda", scene=str(path), motion_plan_request=request)
    if (path.parent.name, path.stem[-1]) == ("table_under_pick", "3"):
        with pytest.raises(StateError, match=r"'panda_joint4' at -0\.04.*outside its limits.*by 0\.027 rad"):
            make_query(asked)
        asked = PlanRequest(robot="panda", scene=str(path), motion_plan_request=request, widen_limits=True)
    query = make_query(asked)
    assert query.robot.fixed_joints["panda_finger_joint1"] == 0.065
    assert len(query.scene.obstacles) >= 5
    assert query.goals.shape == (1, 7)
