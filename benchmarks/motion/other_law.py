"""roboplan's time parametrization over the same path, in an environment of its own, and what its samples keep to."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.motion import runner
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.collision.checker import CollisionChecker
from planner.trajectory.check import sampled_contact
from planner.trajectory.limits import MotionLimits
from planner.trajectory.trajectory import Trajectory

_WAIT = 60.0  # s


def roboplan_law(python: str, path: Floats, judge: CollisionChecker, limits: MotionLimits, step: float) -> Any:
    """Columns of a row: its duration, its largest share of a limit at its own samples, and its first contact."""
    found = _answer(python, path, judge, limits)
    if "times" not in found:
        return {"roboplan_contact": f"not timed: {found['message']}"}
    columns = [np.array(found[key]) for key in ("q", "qd", "qdd")]
    shares = [np.abs(columns[1]) / limits.velocity, np.abs(columns[2]) / limits.acceleration]
    made = Trajectory.through(limits.joints, np.array(found["times"]), *columns[:2])
    contact = sampled_contact(made, judge, step)
    return {
        "roboplan_s": made.duration,
        "roboplan_share": float(np.max(shares)),
        "roboplan_contact": "" if contact is None else f"{contact.contact} at {contact.begin:.4f} s",
    }


def _answer(python: str, path: Floats, judge: CollisionChecker, limits: MotionLimits) -> dict[str, Any]:
    robot = judge.robot
    problem = {
        "urdf": robot.source.xml,
        "package_dirs": robot.source.package_dirs,
        "joints": list(robot.joints),
        "velocity": limits.velocity.tolist(),
        "acceleration": limits.acceleration.tolist(),
        "path": path.tolist(),
    }
    with tempfile.TemporaryDirectory() as folder:
        asked, answer = Path(folder) / "problem.json", Path(folder) / "answer.json"
        asked.write_text(json.dumps(problem))
        command = [python, "-I", runner.__file__, str(asked), str(answer)]
        try:
            ended = subprocess.run(command, capture_output=True, text=True, timeout=_WAIT, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PlannerError(f"{python} did not answer: {error}.") from None
        if ended.returncode:
            said = ended.stderr.strip().splitlines() or [f"exit code {ended.returncode}"]
            raise PlannerError(f"roboplan in {python}: {said[-1]}")
        return json.loads(answer.read_text())
