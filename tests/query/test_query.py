"""``--base`` replaces the base of the scene file."""

from pathlib import Path

import numpy as np

from planner.kinematics.forward import tool_positions
from planner.problem.request import WorldRequest
from planner.query.query import make_checker_for
from planner.robot.poses import pose

Q = np.array([[0.3, -1.2, 1.0, -1.0, -1.5, 0.0]])


def test_the_robot_stands_where_base_says() -> None:
    plain = make_checker_for(WorldRequest("ur5", "empty")).robot
    moved = make_checker_for(WorldRequest("ur5", "empty", base=(0.1, -0.2, 0.9144, 0, 0, 1.57))).robot
    there = pose((0.1, -0.2, 0.9144), (0.0, 0.0, 1.57))
    expected = tool_positions(plain, Q) @ there[:3, :3].T + there[:3, 3]
    np.testing.assert_allclose(tool_positions(moved, Q), expected, atol=1e-12)
    assert moved.identity != plain.identity  # so that no roadmap of the one passes for one of the other


def test_base_goes_before_the_scene(tmp_path: Path) -> None:
    scene = tmp_path / "cell.yaml"
    scene.write_text("robots: {ur5: {base: {position: [0, 0, 1]}}}\n")
    of_scene = make_checker_for(WorldRequest("ur5", str(scene))).robot.base
    given = make_checker_for(WorldRequest("ur5", str(scene), base=(0, 0, 2))).robot.base
    assert (of_scene[2, 3], given[2, 3]) == (1.0, 2.0)
