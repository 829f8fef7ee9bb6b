"""Motions as tree planners check them."""

from __future__ import annotations

import numpy as np

from planner.collision import second_checker
from planner.collision.checker import is_free
from planner.collision.edge_prover import EdgeProver
from planner.collision.looks import recheck
from planner.kinematics.manipulability import manipulability
from planner.roadmap.straight_motions import Motions
from tests.worlds import checker_of, load, make_post


def test_motions_with_a_floor_refuse_what_dips() -> None:
    robot, prover = load("planar_2r"), EdgeProver(checker_of("planar_2r"))
    a, through_straight = np.array([0.0, 0.8]), np.array([0.0, -1.6])
    assert Motions(prover).proven(a, through_straight)
    assert not Motions(prover, 0.01).proven(a, through_straight)
    assert Motions(prover, 0.01).proven(a, np.array([1.0, 0.3]))
    assert not Motions(prover, 0.01).looks_free(0.05)(a, through_straight)
    assert manipulability(robot, a[None])[0] > 0.01


def test_the_shortest_way_turns_as_the_path_does() -> None:
    """A shortcut by half a turn or more would be told by its ends, and they tell the motion the other way round."""
    robot, prover = load("kinova"), EdgeProver(checker_of("kinova"))
    joint = int(np.flatnonzero(robot.continuous)[0])
    for turn in (1.0, np.pi, 1.5 * np.pi, -2.0 * np.pi, 7.0):
        path = np.repeat(robot.home[None], 41, axis=0)
        path[:, joint] += np.linspace(0.0, turn, len(path))
        path = robot.normalise(path)
        short = Motions(prover).shortest_way(path)
        assert len(short) < 10
        np.testing.assert_array_equal(short[[0, -1]], path[[0, -1]])
        np.testing.assert_allclose(robot.unwound(short)[-1] - path[0], robot.unwound(path)[-1] - path[0], atol=1e-9)


def test_what_looks_free_may_touch_and_what_is_proven_does_not() -> None:
    """Of random motions past the post, by coal every millimetre: proven ones are free, sampled ones nearly all."""
    checker = make_post()
    motions, rng = Motions(EdgeProver(checker)), np.random.default_rng(0)
    looks = motions.looks_free(0.05)
    starts = [q for q in rng.uniform(-2.5, 2.5, size=(60, 2)) if is_free(checker, q)]
    verdicts = []
    for q in starts:
        delta = rng.normal(size=2) * 0.6
        if (np.abs(q + delta) > 2.8).any():
            continue
        truth = recheck(second_checker(checker), q, delta, 1e-3) is None
        verdicts.append((truth, motions.proven(q, delta), looks(q, delta)))
    assert {truth for truth, _, _ in verdicts} == {True, False}
    for truth, proven, looked in verdicts:
        assert truth or not proven
        assert looked or not proven, "what is proven looks free, too"
    assert np.mean([truth == looked for truth, _, looked in verdicts]) > 0.9
