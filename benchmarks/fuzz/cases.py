"""The valid files that the fuzzer changes, and how; what is done with them is :mod:`uses`."""

from __future__ import annotations

import io
import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.fuzz import mesh_files, uses
from benchmarks.fuzz.mutations import as_json, mutated_bytes, mutated_text, mutated_tree, mutated_xml
from benchmarks.fuzz.uses import ARM, KERNEL, arm
from planner import gabf
from planner.base.arrays import frozen
from planner.base.errors import InstallationError
from planner.base.hashing import content_hash
from planner.base.resources import robots_folder, scenes_folder
from planner.base.yamlfile import parse_yaml
from planner.collision import make_checker
from planner.construction.build import build_roadmap
from planner.models.files.packages import example_robot_data
from planner.models.files.srdf import read_srdf
from planner.models.scene import Scene
from planner.roadmap.roadmap import DTYPES
from planner.roadmap.storage import save_roadmap
from planner.trajectory.ros_bag import write_bag


@dataclass(frozen=True)
class FileKind:
    """A kind of file: what its changed files end in, how one is made, and what is done with it."""

    suffix: str
    make: Callable[[np.random.Generator], bytes]
    use: Callable[[Path], object]


MOVEIT = {
    "name": "fuzzed",
    "robot_model_name": ARM,
    "robot_state": {
        "joint_state": {"name": ["joint_1"], "position": [0.1]},
        "attached_collision_objects": [
            {
                "link_name": "link_2",
                "object": {
                    "id": "held",
                    "primitives": [{"type": "sphere", "dimensions": [0.05]}],
                    "primitive_poses": [{"position": {"x": 0.1, "y": 0, "z": 0}}],
                },
                "touch_links": ["link_2"],
            }
        ],
    },
    "allowed_collision_matrix": {
        "entry_names": ["link_1", "crate"],
        "entry_values": [{"enabled": [True, False]}, {"enabled": [False, True]}],
    },
    "world": {
        "collision_objects": [
            {
                "id": "crate",
                "pose": {"position": [1.0, 2.0, 0.0], "orientation": [0, 0, 0, 1]},
                "primitives": [
                    {"type": 1, "dimensions": [0.1, 0.2, 0.3]},
                    {"type": "cylinder", "dimensions": [1, 0.2]},
                ],
                "primitive_poses": [{"position": [0, 0, 0]}, {"orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}],
                "meshes": [
                    {
                        "vertices": [[0, 0, 0], [1, 0, 0], {"x": 0, "y": 1, "z": 0}, [0, 0, 1]],
                        "triangles": [{"vertex_indices": row} for row in ([0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3])],
                    }
                ],
                "mesh_poses": [{"position": [3, 3, 0]}],
            }
        ]
    },
}
SCENE_TEXT = """(noname)+
* Box0
1
box
0.1 0.2 0.3
1 2 3
0 0 0 1
0 0 0 0
* Can
1 2 3
0 0 0 1
1
cylinder
0.03 0.14
0 0 0
0 0 0 1
0 0 0 0
0
.
"""
REQUEST = {
    "start_state": {"joint_state": {"name": ["joint_1", "joint_2"], "position": [0.1, 0.2]}},
    "goal_constraints": [
        {"joint_constraints": [{"joint_name": "joint_1", "position": 0.5}, {"joint_name": "joint_2", "position": 1}]},
        {
            "position_constraints": [{"constraint_region": {"primitive_poses": [{"position": [1, 0.2, 0]}]}}],
            "orientation_constraints": [{"orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}],
        },
    ],
}
PATH = {
    "outcome": "solved",
    "robot": ARM,
    "joints": ["joint_1", "joint_2"],
    "path": [[0.0, 0.5], [0.2, 0.4], [0.4, 0.1]],
}
_POINTS = [
    {"positions": [0.0, 0.5], "velocities": [0.0, 0.0], "accelerations": [0.5, 0.0], "time_from_start": {"sec": 0}},
    {"positions": [0.2, 0.4], "velocities": [0.2, -0.1], "time_from_start": {"sec": 0, "nanosec": 900000000}},
    {"positions": [0.4, 0.1], "velocities": [0.0, 0.0], "time_from_start": {"sec": 2, "nanosec": 5}},
]
MOVEIT_TRAJECTORY = {
    "joint_trajectory": {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "world"},
        "joint_names": ["joint_2", "joint_1"],
        "points": [{**point, "accelerations": [0.0, 0.0], "effort": []} for point in _POINTS],
    },
    "multi_dof_joint_trajectory": {"joint_names": [], "points": []},
}
OWN_TRAJECTORY = {
    "robot": ARM,
    "law": "shortcuts",
    "interpolation": "quintics",
    "joints": ["joint_1", "joint_2"],
    "limits": {
        **{kind: [2.0, 2.0] for kind in ("velocity", "acceleration", "jerk")},
        "source": {kind: "a file" for kind in ("velocity", "acceleration", "jerk")},
    },
    "proven": False,
    "points": [{"t": t, "q": [0.1 * t, 0.2], "qd": [0.1, 0.0], "qdd": [0.0, 0.0]} for t in (0.0, 1.0)]
    + [{"t": 2.5, "q": [0.3, 0.2], "qd": [0.0, 0.0], "qdd": [0.0, 0.0]}],
}
JOINT_LIMITS = {
    "default_velocity_scaling_factor": 0.1,
    "default_acceleration_scaling_factor": 0.5,
    "joint_limits": {
        "joint_1": {
            "has_velocity_limits": True,
            "max_velocity": 1.5,
            "has_acceleration_limits": True,
            "max_acceleration": 3.0,
        },
        "joint_2": {"has_velocity_limits": False, "max_velocity": 0, "has_jerk_limits": True, "max_jerk": 100},
    },
}
BATCH = {
    "plans": [
        {"name": "one", "robot": ARM, "scene": "empty", "beta": 0.2, "goal": "q:0,1"},
        {"name": "a/two", "nodes": 30, "seed": 3, "min-manipulability": 0.1, "widen_limits": False},
    ]
}
BATCH_CSV = f"name,robot,scene,beta,nodes\none,{ARM},empty,0.5,30\ntwo,{ARM},shelf,,40\n"
RECORD = {**PATH, "format_version": 1, "files": {"roadmap.npz": "0" * 64, "trajectory.json": "1" * 64}}
CSV = "time,joint_2,joint_1\n0.0,0.5,0.0\n0.5,0.4,0.2\n1.0,0.1,0.4\n"


def kinds() -> dict[str, FileKind]:
    """Every kind of file by its name."""
    return {
        "urdf": FileKind(".urdf", _urdf, uses.use_robot),
        "mesh urdf": FileKind(".urdf", _mesh_urdf, uses.use_robot),
        "srdf": FileKind(".srdf", _srdf, read_srdf),
        "scene": FileKind(".yaml", _scene, uses.use_scene),
        "moveit scene": FileKind(".yaml", lambda rng: as_json(mutated_tree(MOVEIT, rng), rng), uses.use_scene),
        "scene text": FileKind(".scene", lambda rng: mutated_text(SCENE_TEXT, rng), uses.use_scene),
        "request": FileKind(".yaml", _request, uses.use_request),
        "roadmap": FileKind(".npz", _roadmap, uses.use_roadmap),
        "path json": FileKind(".json", _path, uses.use_path),
        "moveit trajectory": FileKind(".yaml", lambda rng: _changed(MOVEIT_TRAJECTORY, rng), uses.use_trajectory),
        "trajectory.json": FileKind("-trajectory.json", lambda rng: _changed(OWN_TRAJECTORY, rng), uses.use_trajectory),
        "trajectory csv": FileKind(".csv", lambda rng: mutated_text(CSV, rng), uses.use_trajectory),
        "trajectory npz": FileKind(".npz", _trajectory_npz, uses.use_trajectory),
        "joint limits": FileKind(".yaml", lambda rng: _changed(JOINT_LIMITS, rng), uses.use_limits),
        "path csv": FileKind(".csv", lambda rng: mutated_text(CSV, rng), uses.use_path),
        "stl": FileKind(".stl", lambda rng: mutated_bytes(mesh_files.stl(), rng), uses.use_mesh),
        "stl text": FileKind(".stl", lambda rng: mutated_text(mesh_files.stl_text(), rng), uses.use_mesh),
        "obj": FileKind(".obj", lambda rng: mutated_text(mesh_files.obj(), rng), uses.use_mesh),
        "ply": FileKind(".ply", lambda rng: mutated_text(mesh_files.ply(), rng), uses.use_mesh),
        "ply of bytes": FileKind(".ply", lambda rng: mutated_bytes(mesh_files.ply_of_bytes(), rng), uses.use_mesh),
        "dae": FileKind(".dae", _dae, uses.use_mesh),
        "network": FileKind(".npz", _network, uses.use_network),
        "robot.yaml": FileKind(".yaml", lambda rng: mutated_text(_robot_text(), rng), uses.use_robot_file),
        "batch": FileKind(".yaml", lambda rng: _changed(BATCH, rng), uses.use_batch),
        "batch csv": FileKind(".csv", lambda rng: mutated_text(BATCH_CSV, rng), uses.use_batch),
        "record": FileKind("-plan.json", lambda rng: _changed(RECORD, rng), uses.use_record),
        "bag": FileKind(".mcap", lambda rng: mutated_bytes(_bag(), rng), uses.use_trajectory),
    }


def _arm_text() -> str:
    return (robots_folder() / ARM / f"{ARM}.urdf").read_text("utf-8")


def _urdf(rng: np.random.Generator) -> bytes:
    iiwa = (robots_folder() / "iiwa14" / "iiwa14.urdf").read_text("utf-8")
    text = iiwa if rng.random() < 0.3 else _arm_text()
    return mutated_text(text, rng) if rng.random() < 0.3 else mutated_xml(text, rng)


def _mesh_urdf(rng: np.random.Generator) -> bytes:
    return mutated_xml(mesh_files.robot_with_mesh("package://iiwa14/visual/link_0.stl"), rng)


@cache
def _srdf_text() -> str:
    return (example_robot_data() / "robots/panda_description/srdf/panda.srdf").read_text("utf-8")


def _srdf(rng: np.random.Generator) -> bytes:
    return mutated_text(_srdf_text(), rng) if rng.random() < 0.5 else mutated_xml(_srdf_text(), rng)


@cache
def _scene_text() -> str:
    text = (scenes_folder() / "shelf.yaml").read_text("utf-8")
    set_up = "base: {position: [0, 0, 0.1], rpy: [0, 0, 1.5708]}, tool: link_2, fixed_joints: {}"
    states = 'start: "q:0.1,0.2", goal: "xyz:1,0.5,0"'
    return f"{text}\n" if ARM in text else f"{text}  {ARM}: {{{states}}}\nrobots:\n  {ARM}: {{{set_up}}}\n"


def _scene(rng: np.random.Generator) -> bytes:
    if rng.random() < 0.5:
        return mutated_text(_scene_text(), rng)
    return as_json(mutated_tree(parse_yaml(_scene_text(), "the fuzzer's scene"), rng), rng)


def _request(rng: np.random.Generator) -> bytes:
    return (
        mutated_text(json.dumps(REQUEST, indent=1), rng)
        if rng.random() < 0.3
        else as_json(mutated_tree(REQUEST, rng), rng)
    )


def _path(rng: np.random.Generator) -> bytes:
    return _changed(PATH, rng)


def _changed(data: dict[str, Any], rng: np.random.Generator) -> bytes:
    """Plain data as JSON, changed as text or as a tree."""
    return (
        mutated_text(json.dumps(data, indent=1), rng) if rng.random() < 0.3 else as_json(mutated_tree(data, rng), rng)
    )


def _trajectory_npz(rng: np.random.Generator) -> bytes:
    """Bytes changed; or one of the arrays."""
    arrays = {"t": np.array([0.0, 1.0, 2.5]), "q": np.array([[0.0, 0.5], [0.2, 0.4], [0.4, 0.1]])}
    arrays["qd"] = np.zeros((3, 2))
    if whole := rng.random() < 0.5:
        name = str(rng.choice(list(arrays)))
        arrays[name] = _odd_array(arrays[name], rng)
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays, joints=np.array(["joint_1", "joint_2"]))
    return buffer.getvalue() if whole else mutated_bytes(buffer.getvalue(), rng)


@cache
def _bag() -> bytes:
    message: dict[str, Any] = MOVEIT_TRAJECTORY["joint_trajectory"]
    points = [{**point, "time_from_start": {"sec": k, "nanosec": 5}} for k, point in enumerate(message["points"])]
    try:
        return write_bag({**message, "points": points})
    except InstallationError:  # then all of them are refused with its sentence
        return b"no library for bags"


@cache
def _robot_text() -> str:
    return (robots_folder() / ARM / "robot.yaml").read_text("utf-8")


@cache
def _network_parts() -> tuple[bytes, dict[str, np.ndarray]]:
    """A small network as it is written, and its arrays."""
    tails, heads, weight = np.array([0, 1, 2]), np.array([1, 2, 1]), np.array([1.0, 2.0, 3.0])
    made = gabf.Network.from_arcs(tails, heads, weight, np.array([2]), 3, node_cost=np.ones(3), kernel=KERNEL)
    with tempfile.TemporaryDirectory() as folder:
        gabf.write_network(made, Path(folder) / "network.npz")
        data = (Path(folder) / "network.npz").read_bytes()
    with np.load(io.BytesIO(data), allow_pickle=False) as content:
        return data, {name: content[name] for name in content.files}


def _network(rng: np.random.Generator) -> bytes:
    """Bytes changed; or one of the arrays."""
    data, arrays = _network_parts()
    if rng.random() < 0.5:
        return mutated_bytes(data, rng)
    name = str(rng.choice(list(arrays)))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **{**arrays, name: _odd_array(arrays[name], rng)})
    return buffer.getvalue()


def _dae(rng: np.random.Generator) -> bytes:
    return mutated_text(mesh_files.dae(), rng) if rng.random() < 0.3 else mutated_xml(mesh_files.dae(), rng)


@cache
def _roadmap_parts() -> tuple[dict[str, Any], dict[str, np.ndarray], bytes]:
    """Header, arrays and bytes of a small roadmap."""
    checker = make_checker(arm(), Scene.load("empty"), "coal")
    made = build_roadmap(arm(), checker, start=[0.1, 0.2], goal=[0.9, -0.4], nodes=12, seed=0)
    with tempfile.TemporaryDirectory() as folder:
        save_roadmap(made, Path(folder) / "roadmap.npz")
        data = (Path(folder) / "roadmap.npz").read_bytes()
    with np.load(io.BytesIO(data), allow_pickle=False) as content:
        return json.loads(str(content["header"])), {name: content[name] for name in DTYPES}, data


def _roadmap(rng: np.random.Generator) -> bytes:
    """Bytes changed; or header and arrays, with hashes as whoever forges such a file would make them."""
    header, arrays, data = _roadmap_parts()
    if rng.random() < 0.2:
        return mutated_bytes(data, rng)
    arrays = dict(arrays)
    if rng.random() < 0.5:
        header = mutated_tree(header, rng)
    else:
        name = str(rng.choice(list(arrays)))
        arrays[name] = _odd_array(arrays[name], rng)
    header |= _hashes(header, arrays)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, header=np.array(json.dumps(header, sort_keys=True)), **arrays)
    return buffer.getvalue()


def _hashes(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    """The two hashes of a roadmap's file, so that what is changed is not refused for them alone."""
    origin = header.get("origin") if isinstance(header.get("origin"), dict) else {}
    joints, tool = (origin or {}).get("joints"), (origin or {}).get("tool")
    graph = [frozen(arrays[name], arrays[name].dtype) for name in ("nodes", "edges", "proven", "starts", "goals")]
    sha256 = content_hash([*graph, tuple(joints) if isinstance(joints, list) else joints, tool])
    rest = {key: value for key, value in header.items() if key != "checksum"} | {"sha256": sha256}
    text = json.dumps(rest, sort_keys=True)
    return {"sha256": sha256, "checksum": content_hash([text, *(arrays[name] for name in DTYPES)])}


def _odd_array(array: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    odd = np.array(array)
    match int(rng.integers(5)):
        case 0:
            return odd[: int(rng.integers(len(odd) + 1))]
        case 1:
            return odd.astype(rng.choice(["f4", "i4", "?", "u8", "c16", "U8"]))
        case 2:
            return odd.reshape(-1, *([1] * int(rng.integers(3))))
        case 3:
            return odd[::-1]
    if odd.size:
        worst = (np.nan, np.inf, 1e308, -1e308, 1e20, -1.0) if odd.dtype.kind == "f" else (-1, 2**31, 2**62, 0)
        flat = odd.reshape(-1)
        flat[int(rng.integers(odd.size))] = worst[int(rng.integers(len(worst)))]
    return odd
