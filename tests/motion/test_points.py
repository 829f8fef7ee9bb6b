"""Trajectories of any origin."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from planner.motion.export import export
from tests.motion.test_export import MADE, A, B, read_back


def test_columns_go_by_name_and_others_are_left_out(tmp_path: Path) -> None:
    message = json.loads(export(MADE, "ros-json"))
    message["joint_names"] = ["finger", B, A]
    for point in message["points"]:
        for key in ("positions", "velocities"):
            point[key] = [0.02, *point[key][::-1]]
    for wrapped in (message, {"trajectory": message}, {"goal": {"trajectory": message}}):
        found = read_back(json.dumps(wrapped).encode(), "ros-json", tmp_path)
        np.testing.assert_allclose(found.coefficients, MADE.coefficients, atol=1e-14)
