"""The example's files with one field changed at a time: each is refused by its name, noted, or of no meaning.

What is honoured is measured in tests/setup/test_message.py and tests/models/test_frames.py.
"""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from planner.base.notes import Note
from planner.models.files.moveit.requests import read_motion_plan_request
from planner.models.files.moveit.scenes import planning_scene
from tests.models.files.moveit.samples import REQUEST, SCENE, changed
from tests.refusals import refusal_of

CRATE = "world.collision_objects.0"
GOAL = "goal_constraints.0"
HELD = {"id": "rod", "primitives": [{"type": "sphere", "dimensions": [0.02]}], "primitive_poses": [{}]}
ATTACHED = [{"link_name": "panda_hand", "object": HELD}]
TURNED = {"rotation": [0, 0, 1, 0], "translation": [0, 0, 0]}
JOINT = {"joint_name": "panda_joint1", "position": 0.1}
REGION = {"primitives": [{"type": 2, "dimensions": [0.0]}], "primitive_poses": [{"position": [0.5, 0, 0.5]}]}
PLACE = {"link_name": "panda_hand", "constraint_region": REGION}
TURN = {"link_name": "panda_hand", "orientation": [1, 0, 0, 0]}

REFUSED_IN_SCENE = {
    "a misspelt field": ("wrold", {}, "unknown key 'wrold' (did you mean 'world'?)"),
    "a misspelt field deep inside": (f"{CRATE}.primitve_poses", [], "(did you mean 'primitive_poses'?)"),
    "octomap": ("world.octomap", {"octomap": {"resolution": 0.1, "data": [1, 2]}}, "'world.octomap' is not read"),
    "octomap of zeros": ("world.octomap", {"octomap": {"data": [0, 0, 0, 0, 0]}}, "'world.octomap' is not read"),
    "plane": (f"{CRATE}.planes", [{"coef": [0, 0, 1, 0]}], f"'{CRATE}.planes' is a plane without end"),
    "padding": ("link_padding", [{"link_name": "panda_hand", "padding": 0.02}], "'link_padding' is not 0"),
    "scale": ("link_scale", [{"link_name": "panda_hand", "scale": 1.1}], "'link_scale' is not 1"),
    "REMOVE": (f"{CRATE}.operation", 1, f"'{CRATE}.operation' is not ADD"),
    "APPEND": (f"{CRATE}.operation", 2, "removes, moves or appends"),
    "MOVE": (f"{CRATE}.operation", 3, "export the whole scene"),
    "an object twice": ("world.collision_objects.1.id", "table", "object 'table' is given twice"),
    "an object without shapes": ("world.collision_objects.0", {"id": "ghost", "type": {"key": "cup"}}, "no shape"),
    "a shape without its own pose": (
        "world.collision_objects.0",
        {
            "id": "mixed",
            "primitives": HELD["primitives"] * 2,
            "primitive_poses": [{}],
            "meshes": [{"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [{"vertex_indices": [0, 1, 2]}]}],
            "mesh_poses": [{}, {}],
        },
        "2 shapes and 1 poses",
    ),
    "an axis that no vector has": (f"{CRATE}.pose.position", {"x": 1, "y": 2, "zz": 3}, "pose.position"),
    "a base elsewhere": (
        "robot_state.multi_dof_joint_state",
        {"joint_names": ["virtual_joint"], "transforms": [TURNED]},
        "'robot_state.multi_dof_joint_state.transforms' moves the robot's base",
    ),
    "a base whose joints have no places": (
        "robot_state.multi_dof_joint_state",
        {"joint_names": ["a", "b"], "transforms": [{}]},
        "2 joint_names and 1 transforms",
    ),
    "contacts allowed by default": (
        "allowed_collision_matrix",
        {"default_entry_names": ["table"], "default_entry_values": [True]},
        "'allowed_collision_matrix.default_entry_values' allows contacts",
    ),
    "a matrix with a row too few": (
        "allowed_collision_matrix",
        {"entry_names": ["a"]},
        "1 entry_names and 0 entry_values",
    ),
    "a matrix with a short row": (
        "allowed_collision_matrix",
        {"entry_names": ["a", "b"], "entry_values": [[False, True], [True]]},
        "the row of 'b' has 1 values for 2 names",
    ),
    "a matrix in one order only": (
        "allowed_collision_matrix",
        {"entry_names": ["a", "b"], "entry_values": [[False, True], {"enabled": [False, False]}]},
        "allows 'a' and 'b' in one order only",
    ),
    "an attached object without shapes": (
        "robot_state.attached_collision_objects",
        [{"link_name": "panda_hand", "object": {"id": "cup"}}],
        "object 'cup' has no shape",
    ),
    "a detached object": (
        "robot_state.attached_collision_objects",
        [{"link_name": "panda_hand", "object": {**HELD, "operation": 1}}],
        "'robot_state.attached_collision_objects.0.object.operation' is not ADD",
    ),
    "frames in a chain": (
        "fixed_frame_transforms",
        [{"child_frame_id": "a"}, {"child_frame_id": "b", "header": {"frame_id": "a"}}],
        "fixed_frame_transforms place a frame twice, or in one another",
    ),
}

REFUSED_IN_REQUEST = {
    "a misspelt field": ("goal_constraint", [], "(did you mean 'goal_constraints'?)"),
    "a misspelt tolerance": (f"{GOAL}.joint_constraints.0.tolerance_abov", 1, "(did you mean 'tolerance_above'?)"),
    "a misspelt constraint on the path": (
        "path_constraints",
        {"orientation_constraint": [TURN]},
        "unknown key 'path_constraints.orientation_constraint'",
    ),
    "a cylinder on the path": (
        "path_constraints",
        {
            "position_constraints": [
                {**PLACE, "constraint_region": {**REGION, "primitives": [{"type": 3, "dimensions": [1, 1]}]}}
            ]
        },
        "path_constraints has a position constraint on a region that is no single box or sphere",
    ),
    "a box with one size": (
        GOAL,
        {"position_constraints": [{"constraint_region": {**REGION, "primitives": [{"type": 1, "dimensions": [1]}]}}]},
        "a box has 3 dimensions, this one 1",
    ),
    "visibility on the path": (
        "path_constraints",
        {"visibility_constraints": [{"target_radius": 0.1}]},
        "'path_constraints.visibility_constraints' is not kept",
    ),
    "another parameterization": (
        "path_constraints",
        {"orientation_constraints": [{**TURN, "parameterization": 2}]},
        "'path_constraints.orientation_constraints.0.parameterization' is wrong",
    ),
    "trajectory_constraints": (
        "trajectory_constraints",
        {"constraints": [{"position_constraints": [PLACE]}]},
        "'trajectory_constraints' is not kept",
    ),
    "visibility_constraints": (
        f"{GOAL}.visibility_constraints",
        [{"target_radius": 0.1}],
        f"'{GOAL}.visibility_constraints' is not kept",
    ),
    "speed of a link": ("max_cartesian_speed", 0.1, "'max_cartesian_speed' limits the speed of a link"),
    "a start that moves": (
        "start_state.joint_state.velocity",
        [0.5] + 8 * [0.0],
        "'start_state.joint_state.velocity' is above 0.01",
    ),
    "names without positions": ("start_state.joint_state.position", [0.0], "9 names and 1 positions"),
    "a joint named twice": ("start_state.joint_state.name", 9 * ["panda_joint1"], "'panda_joint1' is named twice"),
    "a base that moves": (
        "start_state.multi_dof_joint_state",
        {"joint_names": ["v"], "transforms": [{}], "twist": [{"linear": {"x": 0.2, "y": 0, "z": 0}}]},
        "'start_state.multi_dof_joint_state.twist' is not 0",
    ),
    "joints and a place at once": (f"{GOAL}.position_constraints", [PLACE], "constrains joints and a link at once"),
    "a joint constrained twice": (f"{GOAL}.joint_constraints", [JOINT, JOINT], "constrains a joint twice"),
    "a mesh as goal region": (
        GOAL,
        {"position_constraints": [{"constraint_region": {**REGION, "meshes": [{"vertices": [], "triangles": []}]}}]},
        "constraint_region.meshes' is a goal region without a centre",
    ),
    "a prism as goal region": (
        GOAL,
        {
            "position_constraints": [
                {"constraint_region": {"primitives": [{"type": 5, "dimensions": [1]}], "primitive_poses": [{}]}}
            ]
        },
        "a goal region of type 'prism' is not supported",
    ),
    "a negative tolerance": (f"{GOAL}.joint_constraints.0.tolerance_below", -0.1, "tolerance_below' is wrong"),
}

NOTED_IN_SCENE = {
    "a difference": ("is_diff", True, "is a difference to a scene that is not here", True),
    "subframes": (f"{CRATE}.subframe_names", ["edge"], "frames on objects are passed over", False),
    "weight": (
        "robot_state.attached_collision_objects",
        [{**ATTACHED[0], "weight": 0.5}],
        "weights of attached objects",
        False,
    ),
    "detach posture": (
        "robot_state.attached_collision_objects",
        [{**ATTACHED[0], "detach_posture": {"joint_names": ["panda_finger_joint1"], "points": [{}]}}],
        "how a gripper lets go",
        False,
    ),
}
NOTED_IN_REQUEST = {
    "planner_id": ("planner_id", "RRTConnect", "planner_id", False),
    "pipeline_id": ("pipeline_id", "chomp", "pipeline_id", False),
    "num_planning_attempts": ("num_planning_attempts", 3, "num_planning_attempts", False),
    "allowed_planning_time": ("allowed_planning_time", 5.0, "allowed_planning_time", False),
    "workspace": ("workspace_parameters", {"max_corner": [1, 1, 1]}, "workspace_parameters", False),
    "reference": (
        "reference_trajectories",
        [{"joint_trajectory": [{"points": [{}]}]}],
        "reference_trajectories",
        False,
    ),
    "tolerance of a joint": (
        f"{GOAL}.joint_constraints.0.tolerance_above",
        0.01,
        "the centre of their tolerances",
        False,
    ),
    "weight of a constraint": (f"{GOAL}.joint_constraints.0.weight", 0.5, "whatever their weights", False),
    "effort": ("start_state.joint_state.effort", [1.0] + 8 * [0.0], "efforts at the start", False),
    "encoders' noise": ("start_state.joint_state.velocity", [1e-3] + 8 * [0.0], "taken for rest", False),
    "a share above 1": ("max_velocity_scaling_factor", 1.5, "taken as 1, as MoveIt does", True),
    "a share below 0": ("max_acceleration_scaling_factor", -0.5, "taken as 1, as MoveIt does", True),
}

SILENT_IN_SCENE = {
    "header": (f"{CRATE}.header", {"seq": 3, "stamp": {"secs": 1, "nsecs": 2}, "frame_id": "panda_link0"}),
    "colours": ("object_colors", [{"id": "table", "color": {"r": 1, "g": 0, "b": 0, "a": 1}}]),
    "type": (f"{CRATE}.type", {"key": "table", "db": ""}),
    "ADD": (f"{CRATE}.operation", 0),
    "an empty octomap": ("world.octomap", {"header": {"frame_id": "map"}, "octomap": {"resolution": 0.1, "data": []}}),
    "no padding": ("link_padding", [{"link_name": "panda_hand", "padding": 0.0}]),
    "no scale": ("link_scale", [{"link_name": "panda_hand", "scale": 1.0}]),
    "no contacts by default": (
        "allowed_collision_matrix",
        {"default_entry_names": ["a"], "default_entry_values": [False]},
    ),
    "a base where it is": ("robot_state.multi_dof_joint_state", {"joint_names": ["v"], "transforms": [{}]}),
}
SILENT_IN_REQUEST = {
    "nothing on the path": ("path_constraints", {"name": "none", "joint_constraints": []}),
    "nothing on the trajectory": ("trajectory_constraints", {"constraints": [{}]}),
    "factors of 0, which are 1": ("max_velocity_scaling_factor", 0.0),
    "no speed of a link": ("cartesian_speed_limited_link", "panda_hand"),
    "its name before": ("cartesian_speed_end_effector_link", "panda_hand"),
    "weight 1": (f"{GOAL}.joint_constraints.0.weight", 1.0),
}


def of_scene(place: str, value: Any) -> Any:
    return planning_scene(changed(SCENE, place, value), Path("s.yaml"))


def of_request(place: str, value: Any, folder: Path) -> Any:
    (folder / "r.yaml").write_text(yaml.safe_dump(changed(REQUEST, place, value)))
    return read_motion_plan_request(folder / "r.yaml")


def test_the_example_itself_is_honoured_whole(tmp_path: Path) -> None:
    assert planning_scene(copy.deepcopy(SCENE), Path("s.yaml")).notes == ()
    assert of_request("group_name", "panda_arm", tmp_path).notes == ()


@pytest.mark.parametrize("name", REFUSED_IN_SCENE)
def test_what_changes_a_scene_is_refused_by_its_name(name: str) -> None:
    place, value, part = REFUSED_IN_SCENE[name]
    text = refusal_of(lambda: of_scene(place, value))
    assert text.startswith("MoveIt scene s.yaml: ")
    assert part in text


@pytest.mark.parametrize("name", REFUSED_IN_REQUEST)
def test_what_changes_a_request_is_refused_by_its_name(name: str, tmp_path: Path) -> None:
    place, value, part = REFUSED_IN_REQUEST[name]
    text = refusal_of(lambda: of_request(place, value, tmp_path))
    assert text.startswith("MotionPlanRequest ")
    assert part in text


@pytest.mark.parametrize("name", NOTED_IN_SCENE)
def test_what_does_not_change_a_scene_is_noted(name: str) -> None:
    place, value, part, grave = NOTED_IN_SCENE[name]
    _has_one(of_scene(place, value).notes, part, grave)


@pytest.mark.parametrize("name", NOTED_IN_REQUEST)
def test_what_does_not_change_a_request_is_noted(name: str, tmp_path: Path) -> None:
    place, value, part, grave = NOTED_IN_REQUEST[name]
    _has_one(of_request(place, value, tmp_path).notes, part, grave)


def _has_one(notes: tuple[Note, ...], part: str, grave: bool) -> None:
    (note,) = notes
    assert part in note.text
    assert note.grave == grave


@pytest.mark.parametrize("name", SILENT_IN_SCENE)
def test_labels_and_what_ros_fills_in_say_nothing_in_a_scene(name: str) -> None:
    assert of_scene(*SILENT_IN_SCENE[name]).notes == ()


@pytest.mark.parametrize("name", SILENT_IN_REQUEST)
def test_labels_and_what_ros_fills_in_say_nothing_in_a_request(name: str, tmp_path: Path) -> None:
    place, value = SILENT_IN_REQUEST[name]
    found = of_request(place, value, tmp_path)
    assert found.notes == ()
    assert found.shares == {}
