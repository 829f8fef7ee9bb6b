"""Each number and word of a request or a scene, changed by itself: the answer changes, or it is noted, or refused."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from planner.base.errors import PlannerError
from planner.base.yamlfile import validate
from planner.models.files.moveit.requests import MotionPlanRequestMessage, read_motion_plan_request
from planner.models.files.moveit.scenes import PlanningSceneMessage
from planner.models.frames import in_world
from planner.models.model_checks import notes
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.models.shapes import Carried, Mesh, Obstacle, Sphere
from planner.setup.message import goals_of, in_request, kept_of, start_of
from tests.models.files.moveit.samples import REQUEST, changed

HEADER = {"seq": 1, "stamp": 2, "frame_id": "world"}
POSE = {"position": [0.1, 0.2, 0.3], "orientation": [0.5, 0.5, 0.5, 0.5]}
REGION = {"primitives": [{"type": 1, "dimensions": [0.1, 0.2, 0.3]}], "primitive_poses": [POSE]}
PLACE = {
    "header": HEADER,
    "link_name": "panda_hand",
    "target_point_offset": [0.1, 0.2, 0.3],
    "constraint_region": REGION,
    "weight": 1.0,
}
TURN = {
    "header": HEADER,
    "orientation": [0.5, 0.5, 0.5, 0.5],
    "link_name": "panda_hand",
    **{f"absolute_{axis}_axis_tolerance": 0.4 for axis in "xyz"},
    "parameterization": 0,
    "weight": 1.0,
}
JOINT = {"joint_name": "panda_joint1", "position": 0.1, "tolerance_above": 0.5, "tolerance_below": 0.5, "weight": 1.0}
TOOL = {"name": "a", "position_constraints": [PLACE], "orientation_constraints": [TURN]}
ROD = {
    "link_name": "panda_hand",
    "object": {
        "header": {**HEADER, "frame_id": "panda_hand"},
        "pose": POSE,
        "id": "rod",
        "type": {"key": "a", "db": "b"},
        "primitives": REGION["primitives"],
        "primitive_poses": [POSE],
    },
    "touch_links": ["panda_leftfinger"],
}
GRIPPED = changed(REQUEST, "start_state.attached_collision_objects", [ROD])
WHOLE = {
    "joints": {**GRIPPED, "path_constraints": {**TOOL, "joint_constraints": [JOINT]}},
    "tool": {**GRIPPED, "goal_constraints": [TOOL, TOOL]},
}
NARROW = {**TOOL, "orientation_constraints": [{**TURN, **{f"absolute_{axis}_axis_tolerance": 0.0 for axis in "xyz"}}]}
POINT = {"primitives": [{"type": 2, "dimensions": [0.001]}], "primitive_poses": [POSE]}
WHOLE["pose"] = {
    **REQUEST,
    "goal_constraints": [{**NARROW, "position_constraints": [{**PLACE, "constraint_region": POINT}]}],
}

MEANS_NOTHING = (
    ".name", "seq", "stamp", "type.key", "type.db", "polygon", "cartesian_speed_limited_link",
    "cartesian_speed_end_effector_link",
    "start_state.joint_state.header.frame_id", "start_state.multi_dof_joint_state.header.frame_id",
    "detach_posture.points",  # what lets go is noted where it names joints
    "detach_posture.header.frame_id", "workspace_parameters.header.frame_id",
)  # fmt: skip
OF_A_POINT = ("primitives.0.type", "parameterization", *(f"primitive_poses.0.orientation.{k}" for k in range(4)))

ITEMS = [0.5, "x", [0.5, 0, 0], POSE, {"linear": [1, 2, 3]}, {"force": [1, 2, 3]}]


def leaves(value: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Every list, number and word in a message with its place, those among them that the file leaves out."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, f"{place}.{key}" if place else key)
        return
    yield place, value
    if isinstance(value, list):
        for k, item in enumerate(value):
            yield from leaves(item, f"{place}.{k}")


def others(value: Any) -> list[Any]:
    """Other values of its kind; of what a list may hold one will do."""
    if isinstance(value, list):
        return [[*value, more] for more in (value[:1] or ITEMS)]
    if value is None or isinstance(value, str):
        return [f"{value or ''}x"]
    return [not value if isinstance(value, bool) else value + 1 if isinstance(value, int) else value + 0.0625]


def meaning(message: dict, folder: Path, robot: Robot) -> str:
    """All that comes out of a request, as text: what it starts from, reaches, keeps, carries, notes."""
    (folder / "r.yaml").write_text(yaml.safe_dump(message))
    read = read_motion_plan_request(folder / "r.yaml")
    held = Carried("panda_hand", "bar", Sphere(0.01), np.eye(4))
    scene = in_request(replace(Scene.load("empty"), carried=(held,)), read)
    said = (start_of(read, scene), goals_of(read, robot, scene), kept_of(read, robot, scene), read.shares, read.group)
    return repr((said, scene.carried, scene.notes))


@pytest.mark.parametrize("kind", WHOLE)
def test_no_field_is_dropped(kind: str, tmp_path: Path) -> None:
    robot, message = Robot.load("panda"), json.loads(json.dumps(WHOLE[kind]))  # whose parts stand for themselves
    filled = validate(MotionPlanRequestMessage, copy.deepcopy(message), "request").model_dump(mode="json")
    before, dropped, looked = meaning(message, tmp_path, robot), [], 0
    for place, new in ((place, new) for place, value in leaves(filled) for new in others(value)):
        looked += 1
        try:
            same = meaning(changed(message, place, new), tmp_path, robot) == before
        except PlannerError:
            continue
        if same and not place.endswith(MEANS_NOTHING) and not (kind == "pose" and place.endswith(OF_A_POINT)):
            dropped.append((place, new))
    assert looked > 100
    assert not dropped, "\n".join(map(str, dropped))


MESH = {
    "vertices": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    "triangles": [{"vertex_indices": [0, 1, 2]}, {"vertex_indices": [0, 1, 3]}],
}
NAMES = ["crate", "panda_link5", "panda_link6", "rod"]
PAIRS = [[False, True, False, True], [True, False, False, False], [False] * 4, [True, False, False, False]]
CRATE = {**ROD["object"], "header": HEADER, "id": "crate"}
SCENE_OF_ALL = {
    "name": "s",
    "robot_model_name": "panda",
    "robot_state": {
        "joint_state": {"header": HEADER, "name": ["panda_joint1"], "position": [0.5]},
        "attached_collision_objects": [ROD],
    },
    "fixed_frame_transforms": [
        {"child_frame_id": "cell", "transform": {"translation": [1.0, 2.0, 3.0], "rotation": [0.5, 0.5, 0.5, 0.5]}}
    ],
    "allowed_collision_matrix": {"entry_names": NAMES, "entry_values": PAIRS},
    "world": {
        "collision_objects": [
            CRATE,
            {"header": HEADER, "pose": POSE, "id": "part", "meshes": [MESH], "mesh_poses": [POSE]},
            {**CRATE, "id": "other", "header": {**HEADER, "frame_id": "cell"}},
        ]
    },
}
MEANS_NOTHING_IN_SCENES = (
    *("seq", "stamp", "type.key", "type.db", "polygon", "joint_state.header.frame_id"),
    *("detach_posture.header.frame_id", "robot_state.is_diff", *(f"entry_values.{k}.{k}" for k in range(4))),
    "fixed_frame_transforms.0.header.frame_id",  # the scene's own frame, whatever its name
    *(f"octomap.{name}" for name in ("header.frame_id", "binary", "id", "resolution")),  # of one that holds nothing
)


def meaning_of_scene(message: dict, folder: Path, robot: Robot) -> str:
    """All that comes out of a scene, as text."""
    (folder / "s.yaml").write_text(yaml.safe_dump(message))
    read = Scene.load(str(folder / "s.yaml"))
    assert read.message is not None
    world = in_world(read, robot)
    pairs = [sorted(map(sorted, some)) for some in (read.allowed, read.message.checked)]
    said = (read.name, read.message.state, pairs, [note.text for note in notes(robot, read)])
    return repr((said, [*map(_thing, world.obstacles)], [*map(_thing, world.carried)]))


def _thing(item: Obstacle | Carried) -> str:
    shape = item.shape
    size = (shape.vertices.tolist(), shape.triangles.tolist()) if isinstance(shape, Mesh) else shape
    held = (item.link, item.touch_links) if isinstance(item, Carried) else ()
    return repr((item.name, item.object, size, item.placement.tolist(), held))


def test_no_field_of_a_scene_is_dropped(tmp_path: Path) -> None:
    robot, message = Robot.load("panda"), json.loads(json.dumps(SCENE_OF_ALL))
    filled = validate(PlanningSceneMessage, copy.deepcopy(message), "scene").model_dump(mode="json")
    before, dropped, looked = meaning_of_scene(message, tmp_path, robot), [], 0
    for place, new in ((place, new) for place, value in leaves(filled) for new in others(value)):
        looked += 1
        try:
            same = meaning_of_scene(changed(message, place, new), tmp_path, robot) == before
        except PlannerError:
            continue
        if same and not place.endswith(MEANS_NOTHING_IN_SCENES):
            dropped.append((place, new))
    assert looked > 300
    assert not dropped, "\n".join(map(str, dropped))
