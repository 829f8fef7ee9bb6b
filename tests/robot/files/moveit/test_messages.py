"""Keys that no model names: refused by their place, or named in one note, where they hold a value; silent otherwise."""

import contextlib
import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planner.base.errors import PlannerError
from planner.robot.moveit.requests import (
    MotionPlanRequest,
    MotionPlanRequestMessage,
    goal_targets,
    path_conditions,
    read_motion_plan_request,
    with_path_limits,
)
from planner.robot.moveit.scenes import PlanningSceneMessage, parse_planning_scene
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from tests.any_data import data_of
from tests.refusals import refusal_of
from tests.robot.files.moveit.samples import REQUEST, SCENE, changed

CRATE, GOAL, STATE = "world.collision_objects.0", "goal_constraints.0", "start_state.joint_state"
BASE = "robot_state.multi_dof_joint_state"
PLACED = {"joint_names": ["virtual_joint"], "transforms": [{"translation": [0, 0, 0], "rotation": [0, 0, 0, 1]}]}
SHIFTED = {"joint_names": ["virtual_joint"], "transforms": [{"translation": {"x": 0.5, "y": 0, "z": 0}}]}
HELD = {"id": "rod", "primitives": [{"type": "sphere", "dimensions": [0.02]}], "primitive_poses": [{}]}
ATTACHED = "robot_state.attached_collision_objects"
RIGID = {"link_name": "panda_hand", "object": HELD}
TRIANGLE = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [{"vertex_indices": [0, 1, 2]}]}
POINT = {"primitives": [{"type": 2, "dimensions": [0.0]}], "primitive_poses": [{"position": [0.5, 0, 0.5]}]}
PLACE = {"link_name": "panda_hand", "constraint_region": POINT}
TURN = {"link_name": "panda_hand", "orientation": [1, 0, 0, 0]}
JOINT = {"joint_name": "panda_joint1", "position": 0.0}

OCTOMAP = {"header": {"frame_id": "map"}, "octomap": {"resolution": 0.1, "data": []}}
UNUSED = {"seq": 3, "stamp": {"secs": 1}, "frame_id": "panda_link0"}


def region(kind: int, *dimensions: float) -> dict[str, Any]:
    return {"constraint_region": {**POINT, "primitives": [{"type": kind, "dimensions": list(dimensions)}]}}


REFUSED_IN_SCENES = [
    ("wrold", {"a": 1}),
    ("world.octomap", {"octomap": {"resolution": 0.1, "data": [1, 2]}}),
    (f"{CRATE}.planes", [{"coef": [0, 0, 1, 0]}]),
    ("link_padding", [{"link_name": "panda_hand", "padding": 0.02}]),
    *((f"{CRATE}.operation", value) for value in (1, "REMOVE")),
    *((BASE, value) for value in (SHIFTED, {**PLACED, "twist": [{"linear": {"x": 0.2, "y": 0, "z": 0}}]})),
    ("robot_state.joint_state.velocity", [0.5]),
    ("allowed_collision_matrix", {"default_entry_names": ["a"], "default_entry_values": [True]}),
    *((ATTACHED, [{**RIGID, "object": thing}]) for thing in ({**HELD, "operation": 1}, {"id": "cup"})),
    ("world.collision_objects.1.id", "table"),
    (CRATE, {**HELD, "primitives": 2 * HELD["primitives"]}),
    (f"{CRATE}.pose.position", {"x": 1, "y": 2, "zz": 3}),
    (f"{CRATE}.pose.orientation", [0, 0, 0, 0]),
    (f"{CRATE}.primitives.0", {"type": "cone", "dimensions": [1, 1]}),
    (CRATE, {"id": "a", "meshes": [{**TRIANGLE, "vertices": []}], "mesh_poses": [{}]}),
    ("allowed_collision_matrix", {"entry_names": ["a"]}),
    (
        "allowed_collision_matrix",
        {"entry_names": ["a", "b"], "entry_values": [[False, True], {"enabled": [False, False]}]},
    ),
    ("fixed_frame_transforms", [{"child_frame_id": "a"}, {"child_frame_id": "b", "header": {"frame_id": "a"}}]),
]
SILENT_IN_SCENES = [
    *(("world.octomap", OCTOMAP), (BASE, PLACED), (f"{CRATE}.header", UNUSED)),
    *((f"{CRATE}.operation", value) for value in (0, "ADD", "\0", b"\0")),
    ("object_colors", [{"id": "table", "color": {"r": 1, "g": 0}}]),
]
REFUSED_IN_REQUESTS = [
    ("goal_constrains", [{"joint_constraints": [JOINT]}]),
    ("path_constraints.orientation_constraint", [TURN]),
    ("path_constraints.visibility_constraints", [{"target_radius": 0.1}]),
    ("trajectory_constraints", {"constraints": [{"position_constraints": [PLACE]}]}),
    ("max_cartesian_speed", 0.1),
    (f"{STATE}.velocity", [0.5] + 8 * [0.0]),
    ("start_state.multi_dof_joint_state", SHIFTED),
    (f"{GOAL}.position_constraints", [PLACE]),
    (f"{GOAL}.joint_constraints", [JOINT, JOINT]),
    (GOAL, {"position_constraints": [{"constraint_region": {"meshes": [TRIANGLE]}}]}),
    (GOAL, {}),
    *((GOAL, {"position_constraints": [solid]}) for solid in (region(5, 1), region(1, 1))),
    ("path_constraints", {"position_constraints": [PLACE | region(3, 1, 1)]}),
    ("path_constraints", {"orientation_constraints": [{**TURN, "parameterization": 2}]}),
    (f"{GOAL}.joint_constraints.0.tolerance_below", -0.1),
]
SILENT_IN_REQUESTS = [("trajectory_constraints", {"constraints": [{}]}), (f"{STATE}.velocity", [1e-3] + 8 * [0.0])]
NOTED_IN_REQUESTS = [  # one note names the key; the last two change the motion
    *(("cartesian_speed_limited_link", "panda_hand"), ("planner_id", "RRTConnect"), ("num_planning_attempts", 3)),
    *(("allowed_planning_time", 5.0), (f"{GOAL}.joint_constraints.0.weight", 0.5)),
    ("workspace_parameters", {"max_corner": [1, 1, 1]}),
    ("max_velocity_scaling_factor", 1.5),
    (f"{GOAL}.joint_constraints.0.tolerance_above", 0.01),
]


@pytest.fixture(scope="module")
def panda() -> Robot:
    return Robot.load("panda")


def read(message: dict[str, Any], folder: Path, robot: Robot) -> MotionPlanRequest:
    """A request, read and made use of."""
    (folder / "r.yaml").write_text(yaml.safe_dump(message))
    found, scene = read_motion_plan_request(folder / "r.yaml"), Scene("x")
    goal_targets(found, robot, scene)
    path_conditions(found, robot, scene)
    with_path_limits(robot, found, scene)
    return found


@pytest.mark.parametrize(("place", "value"), REFUSED_IN_SCENES)
def test_a_scene_with_a_key_that_is_not_followed_is_refused(place: str, value: Any) -> None:
    assert refusal_of(lambda: parse_planning_scene(changed(SCENE, place, value), Path("s.yaml")))


@pytest.mark.parametrize(("place", "value"), SILENT_IN_SCENES)
def test_a_scene_is_read_without_notes(place: str, value: Any) -> None:
    assert parse_planning_scene(changed(SCENE, place, value), Path("s.yaml")).notes == ()


@pytest.mark.parametrize(("place", "value"), REFUSED_IN_REQUESTS)
def test_a_request_with_a_key_that_is_not_followed_is_refused(
    place: str, value: Any, panda: Robot, tmp_path: Path
) -> None:
    assert refusal_of(lambda: read(changed(REQUEST, place, value), tmp_path, panda))


@pytest.mark.parametrize(("place", "value"), SILENT_IN_REQUESTS + NOTED_IN_REQUESTS)
def test_a_request_is_read_with_a_note_where_a_key_has_no_effect(
    place: str, value: Any, panda: Robot, tmp_path: Path
) -> None:
    notes = read(changed(REQUEST, place, value), tmp_path, panda).notes
    assert len(notes) == ((place, value) in NOTED_IN_REQUESTS)


def test_the_example_has_no_notes(panda: Robot, tmp_path: Path) -> None:
    assert parse_planning_scene(copy.deepcopy(SCENE), Path("s.yaml")).notes == ()
    assert read(REQUEST, tmp_path, panda).notes == ()


DEFAULTS = st.recursive(
    st.sampled_from([None, 0, 0.0, False, "", {"rotation": [0, 0, 0, 1]}, {"rotation": dict(x=0, y=0, z=0, w=1)}]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from("abc"), inner, max_size=3),
    max_leaves=6,
)
VALUES = st.sampled_from([1, -0.5, True, "word", float("inf"), float("nan"), b"\1"])
PLACES = [
    "",
    "robot_state.",
    "world.",
    f"{CRATE}.",
    f"{CRATE}.pose.",
    f"{CRATE}.primitives.0.",
    "robot_state.joint_state.",
]


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(PLACES), DEFAULTS, VALUES, st.lists(st.sampled_from("ab0"), max_size=3))
def test_an_unknown_key_counts_where_it_holds_a_value(at: str, default: Any, value: Any, path: list[str]) -> None:
    """However deep the value lies, among whatever ROS fills in."""
    key = f"{at}zzz"
    assert parse_planning_scene(changed(SCENE, key, default), Path("s.yaml")).notes == ()
    for step in path:
        value = [default, value] if step == "0" else {step: value, "c": default}
    assert f"'{key}" in refusal_of(lambda: parse_planning_scene(changed(SCENE, key, value), Path("s.yaml")))


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(scene=data_of(PlanningSceneMessage), request_=data_of(MotionPlanRequestMessage))
def test_any_message_of_known_keys_is_read_or_refused(
    scene: Any, request_: Any, panda: Robot, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("r")
    with contextlib.suppress(PlannerError):
        found = parse_planning_scene(scene, Path("s.yaml"))
        assert all(np.isfinite(item.placement).all() for item in (*found.obstacles, *found.carried))
    with contextlib.suppress(PlannerError):
        read({**REQUEST, **request_}, folder, panda)
