"""What keeps start and goal apart: what is named suffices, by another roadmap in a world without it."""

import numpy as np
import pytest

from planner.collision import make_checker
from planner.problem.outcome import BudgetSpent, Separated
from planner.roadmap.build import build_roadmap
from planner.roadmap.grow import GrowthSettings
from planner.roadmap.infeasibility import explain_separation
from planner.roadmap.roadmap import Roadmap
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle, Sphere
from tests.worlds import load

WALL = Obstacle("wall", Box((0.02, 0.6, 0.4)), pose([0.0, 0.5, 0.0]))
BEHIND = Obstacle("behind", Box((0.02, 0.6, 0.4)), pose([0.0, -0.5, 0.0]))
SECOND = Obstacle("second wall", Box((0.02, 0.6, 0.4)), pose([-0.05, 0.5, 0.0]))
ASIDE = Obstacle("aside", Sphere(0.03), pose([0.9, 0.3, 0.0]))
START, GOAL = np.array([0.2, 0.3]), np.array([3.0, -0.3])
FEW = GrowthSettings(join_motions=600)


def grown(*obstacles: Obstacle, start: np.ndarray = START, goal: np.ndarray = GOAL) -> tuple[Roadmap, Scene]:
    robot, scene = load("planar_2r"), Scene("made", obstacles)
    return build_roadmap(robot, make_checker(robot, scene), start, goal, 60, growth=FEW), scene


def without(scene: Scene, *names: str) -> tuple[Obstacle, ...]:
    return tuple(obstacle for obstacle in scene.obstacles if obstacle.name not in names)


@pytest.mark.parametrize("others", [(), (ASIDE,)])
def test_a_wall_is_named_and_without_it_they_are_joined(others: tuple[Obstacle, ...]) -> None:
    roadmap, scene = grown(WALL, BEHIND, *others)
    assert not roadmap.is_connected
    reason = explain_separation(roadmap, make_checker(load("planar_2r"), scene))
    assert isinstance(reason, Separated)
    assert len(reason.obstacles) == 1
    assert reason.obstacles[0] in ("wall", "behind")
    assert f"'{reason.obstacles[0]}' separates them" in reason.sentence
    assert grown(*without(scene, *reason.obstacles))[0].is_connected
    for other in others:
        assert not grown(*without(scene, other.name))[0].is_connected
    assert reason.gap.between is not None
    assert reason.gap.between[1] in ("wall", "behind")


def test_two_that_stand_behind_each_other_are_named_together() -> None:
    """Behind the robot the way is shut by a wall at its joint limit."""
    shut = [Obstacle(f"behind {k}", Box((0.02, 0.6, 0.4)), pose([0.05 * k, -0.5, 0.0])) for k in range(3)]
    roadmap, scene = grown(WALL, SECOND, *shut)
    reason = explain_separation(roadmap, make_checker(load("planar_2r"), scene))
    assert isinstance(reason, Separated)
    assert set(reason.obstacles) == {"wall", "second wall"}
    assert grown(*without(scene, *reason.obstacles))[0].is_connected
    for name in reason.obstacles:
        assert not grown(*without(scene, name))[0].is_connected


def test_the_gap_is_the_shortest_motion_between_the_parts() -> None:
    roadmap, scene = grown(WALL, BEHIND)
    gap = explain_separation(roadmap, make_checker(load("planar_2r"), scene)).gap
    labels = roadmap.components
    mine, theirs = (roadmap.nodes[np.isin(labels, labels[ends])] for ends in (roadmap.starts, roadmap.goals))
    apart = np.linalg.norm(load("planar_2r").difference(mine[:, None], theirs[None]), axis=2)
    assert gap.joint_distance == pytest.approx(apart.min())
    i, j = np.unravel_index(apart.argmin(), apart.shape)
    np.testing.assert_array_equal(gap.start_side, mine[i])
    np.testing.assert_allclose(gap.goal_side, theirs[j], atol=1e-12)


def test_no_obstacle_is_blamed_where_the_budget_was_too_small() -> None:
    """Without its edges a roadmap is as many parts as it has nodes, and the way between them is free."""
    roadmap, scene = grown(ASIDE)
    parts = roadmap.part(np.ones(len(roadmap.nodes), dtype=bool), np.zeros(len(roadmap.edges), dtype=bool))
    reason = explain_separation(parts, make_checker(load("planar_2r"), scene))
    assert isinstance(reason, BudgetSpent)
    assert reason.nodes == len(roadmap.nodes)
    assert "no obstacle was found" in reason.sentence
