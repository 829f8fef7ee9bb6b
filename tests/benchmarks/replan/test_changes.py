"""Seeded changes: the same for a seed, on the route where they should be, undone where they take start or goal."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.replan.changes import KINDS, Changer
from planner.kinematics.forward import tool_positions
from planner.session.session import Session
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap


def made(seed: int = 0) -> tuple[Session, Changer]:
    session = Session(load("planar_2r"), make_post().world.scene, post_roadmap())
    return session, Changer(session, session.plan(POST_START, POST_GOAL), seed)


def place_of_box(seed: int) -> list[float]:
    session, changer = made(seed)
    assert changer.step("added") is not None
    return session.scene.obstacles[-1].placement.ravel().tolist()


def test_a_seed_makes_one_world() -> None:
    assert place_of_box(0) == place_of_box(0) != place_of_box(1)


def test_a_box_on_the_route_is_on_the_route() -> None:
    session, changer = made()
    route = session.replan().path
    step = changer.step("blocking the route")
    assert step is not None
    box = session.scene.obstacles[-1]
    middle = tool_positions(session.robot, route)[len(route) // 2]
    assert np.abs(box.placement[:3, 3] - middle).max() <= 0.02


@pytest.mark.parametrize("kind", KINDS)
def test_after_every_step_start_and_goal_are_free_and_the_count_of_things_fits(kind: str) -> None:
    session, changer = made(3)
    assert changer.step("added") is not None
    before = len(session.scene.obstacles)
    for _ in range(2):
        step = changer.step(kind)
        if step is None:
            continue
        session.plan(POST_START, POST_GOAL)  # raises where one of them is not free
        after = len(session.scene.obstacles)
        allowed = {"moved": {0}, "added": {1}, "blocking the route": {1}, "removed": {-1, 1}}[kind]
        assert after - before in allowed
        before = after
