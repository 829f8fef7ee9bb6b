"""Another planner's time parametrization along a path, run by the Python of its own environment.

Nothing of ours is imported.

python -I runner.py problem.json answer.json

The problem holds ``urdf``, ``package_dirs``, ``joints``, ``velocity``, ``acceleration`` and ``path``; the
answer ``times``, ``q``, ``qd``, ``qdd`` of the samples, ``motion_s``, seconds of the wall clock that the motion took,
and ``version``.
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
    core, toppra = importlib.import_module("roboplan.core"), importlib.import_module("roboplan.toppra")
    scene = core.Scene("bench", core.loadUrdfSceneDescriptionFromXml(problem["urdf"], problem["package_dirs"]))
    joints = problem["joints"]
    limits = zip(joints, problem["velocity"], problem["acceleration"], strict=True)
    content = {"joint_limits": {name: {"max_velocity": [v], "max_acceleration": [a]} for name, v, a in limits}}
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(json.dumps(content))
        file.flush()
        scene.importJointLimitsFromConfig(core.loadJointLimitsConfig(file.name))
    scene.addGroup("arm", joints)
    path = core.JointPath()
    path.joint_names, path.positions = joints, [np.array(q) for q in problem["path"]]
    begin = time.perf_counter()
    made = toppra.PathParameterizerTOPPRA(scene, "arm").generate(path, toppra.TOPPRAOptions(dt=_APART))
    seconds = time.perf_counter() - begin
    order = [made.joint_names.index(name) for name in joints]
    columns = {"q": made.positions, "qd": made.velocities, "qdd": made.accelerations}
    rows = {key: [np.asarray(row)[order].tolist() for row in column] for key, column in columns.items()}
    return {"times": list(made.times), **rows, "motion_s": seconds}


def main(problem: str, answer: str) -> None:
    """Time the path and write the answer; what the planner itself refuses is an answer with a message."""
    try:
        found = time_by_roboplan(json.loads(Path(problem).read_text()))
    except (RuntimeError, ValueError) as error:
        found = {"message": str(error)}
    Path(answer).write_text(json.dumps({"version": importlib.metadata.version("roboplan"), **found}))


if __name__ == "__main__":
    main(*sys.argv[1:])
