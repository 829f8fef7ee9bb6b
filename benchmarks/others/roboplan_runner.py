"""roboplan's motion along a path or a tool path, run by the Python of its own environment.

Nothing of ours is imported.

python -I roboplan_runner.py time|follow problem.json answer.json

The problem holds ``urdf``, ``package_dirs``, ``joints``, ``velocity``, ``acceleration``, and ``path`` to time; or
``tool``, ``poses`` (k, 4, 4) in the world, ``start`` and ``tube`` to follow. The answer holds ``times``, ``q``, ``qd``
(and ``qdd``) of the samples, ``motion_s``, seconds of the wall clock, and ``version``, or a ``message`` of roboplan.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

_APART = 0.002  # s between two samples


def time_by_roboplan(problem: dict[str, Any]) -> dict[str, Any]:
    """TOPP-RA of roboplan along its default spline through the waypoints."""
    core, scene = _scene(problem)
    toppra = importlib.import_module("roboplan.toppra")
    path = core.JointPath()
    path.joint_names, path.positions = problem["joints"], [np.array(q) for q in problem["path"]]
    begin = time.perf_counter()
    made = toppra.PathParameterizerTOPPRA(scene, "arm").generate(path, toppra.TOPPRAOptions(dt=_APART))
    seconds = time.perf_counter() - begin
    return _samples(problem, made, qdd=made.accelerations) | {"motion_s": seconds}


def follow_by_roboplan(problem: dict[str, Any]) -> dict[str, Any]:
    """Its time-optimal Cartesian planner, with errors of the tube's size; it does not look at obstacles."""
    core, scene = _scene(problem)
    cartesian = importlib.import_module("roboplan.cartesian_planning")
    joints, tube = problem["joints"], problem["tube"]
    options = cartesian.CartesianPlannerOptions(
        group_name="arm",
        dt=_APART,
        speed_mode=cartesian.CartesianSpeedMode.TimeOptimal,
        max_position_error=tube["position"],
        max_orientation_error=tube["angle"],
    )
    poses = [np.asfortranarray(pose) for pose in problem["poses"]]
    path = core.CartesianPath(["universe"], [problem["tool"]], [poses])
    whole = scene.getCurrentJointPositions().copy()
    whole[scene.getJointPositionIndices(joints)] = problem["start"]
    start = core.JointConfiguration(scene.getJointNames(), whole)
    begin = time.perf_counter()
    made = cartesian.CartesianPathPlanner(scene, options).plan(path, start)
    seconds = time.perf_counter() - begin
    return _samples(problem, made) | {"motion_s": seconds}


def _scene(problem: dict[str, Any]) -> tuple[Any, Any]:
    """roboplan's core, and a scene of the robot with its limits."""
    core = importlib.import_module("roboplan.core")
    scene = core.Scene("bench", core.loadUrdfSceneDescriptionFromXml(problem["urdf"], problem["package_dirs"]))
    limits = zip(problem["joints"], problem["velocity"], problem["acceleration"], strict=True)
    content = {"joint_limits": {name: {"max_velocity": [v], "max_acceleration": [a]} for name, v, a in limits}}
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(json.dumps(content))
        file.flush()
        scene.importJointLimitsFromConfig(core.loadJointLimitsConfig(file.name))
    scene.addGroup("arm", problem["joints"])
    return core, scene


def _samples(problem: dict[str, Any], made: Any, **more: Any) -> dict[str, Any]:
    order = [made.joint_names.index(name) for name in problem["joints"]]
    columns = {"q": made.positions, "qd": made.velocities, **more}
    rows = {key: [np.asarray(row)[order].tolist() for row in column] for key, column in columns.items()}
    return {"times": list(made.times), **rows}


def main(task: str, problem: str, answer: str) -> None:
    """Write the answer; a refusal of roboplan is an answer with a message."""
    work = {"time": time_by_roboplan, "follow": follow_by_roboplan}[task]
    try:
        found = work(json.loads(Path(problem).read_text()))
    except (RuntimeError, ValueError, MemoryError) as error:  # of a path that it cannot resolve, it says which share
        found = {"message": str(error)}
    Path(answer).write_text(json.dumps({"version": importlib.metadata.version("roboplan"), **found}))


if __name__ == "__main__":
    main(*sys.argv[1:])
