"""roboplan's Cartesian planner on one tool path, run by the Python of its own environment.

Nothing of ours is imported.

python -I runner.py problem.json answer.json

The problem is that of :mod:`benchmarks.motion.runner`, with ``tool``, ``poses`` (k, 4, 4) in the world, ``start`` and
``tube`` in place of ``path``; the answer ``times``, ``q`` and ``qd`` of the samples, ``seconds`` of the wall clock, and
``version``, or a ``message`` where the path is not followed.
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


def follow_by_roboplan(problem: dict[str, Any]) -> dict[str, Any]:
    """Its time-optimal mode, with errors of the tube's size; obstacles are not among what it looks at."""
    core, cartesian = (importlib.import_module(f"roboplan.{name}") for name in ("core", "cartesian_planning"))
    scene = core.Scene("bench", core.loadUrdfSceneDescriptionFromXml(problem["urdf"], problem["package_dirs"]))
    joints, tube = problem["joints"], problem["tube"]
    limits = zip(joints, problem["velocity"], problem["acceleration"], strict=True)
    content = {"joint_limits": {name: {"max_velocity": [v], "max_acceleration": [a]} for name, v, a in limits}}
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(json.dumps(content))
        file.flush()
        scene.importJointLimitsFromConfig(core.loadJointLimitsConfig(file.name))
    scene.addGroup("arm", joints)
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
    order = [made.joint_names.index(name) for name in joints]
    columns = {"q": made.positions, "qd": made.velocities}
    rows = {key: [np.asarray(row)[order].tolist() for row in column] for key, column in columns.items()}
    return {"times": list(made.times), **rows, "seconds": seconds}


def main(problem: str, answer: str) -> None:
    """Follow the path and write the answer; what the planner itself refuses is an answer with a message."""
    try:
        found = follow_by_roboplan(json.loads(Path(problem).read_text()))
    except (RuntimeError, ValueError, MemoryError) as error:  # of a path that it cannot resolve, it says which share
        found = {"message": str(error)}
    Path(answer).write_text(json.dumps({"version": importlib.metadata.version("roboplan"), **found}))


if __name__ == "__main__":
    main(*sys.argv[1:])
