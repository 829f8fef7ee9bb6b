"""First paths of an arm whose joints turn freely: solved, and no library contradicts a proof."""

from __future__ import annotations

import logging

import pytest

from planner.planning.plan import plan
from planner.problem.outcome import Outcome


@pytest.mark.parametrize("scene", ["cage", "empty", "paper", "shelf", "table", "window"])
def test_every_seed_is_solved(scene: str, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        for seed in range(4):
            found = plan(robot="kinova", scene=scene, seed=seed, path_only=True, collision="coal")
            assert (found.outcome, found.edges_removed) == (Outcome.SOLVED, 0)
    assert not [record for record in caplog.messages if "against" in record]
