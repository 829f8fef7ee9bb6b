"""First paths of every arm in every scene: solved with every seed, and no library contradicts a proof."""

import logging

import pytest

from planner.base.resources import robot_names, scene_names
from planner.planning.plan import plan
from planner.problem.outcome import Outcome

SEEDS = {"kinova": 4}  # its joints turn freely


@pytest.mark.parametrize("robot", robot_names())
def test_every_seed_is_solved(robot: str, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        for scene in scene_names():
            for seed in range(SEEDS.get(robot, 1)):
                found = plan(robot=robot, scene=scene, seed=seed, path_only=True, collision="coal", timing=None)
                assert (found.outcome, found.edges_removed) == (Outcome.SOLVED, 0), (scene, seed)
    assert not [message for message in caplog.messages if "against" in message]
