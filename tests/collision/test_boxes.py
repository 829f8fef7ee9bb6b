"""Boxes leave no near pair out, and leave out most that are far; coal says how far, FCL what touches."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planner.collision import boxes, make_checker
from planner.collision.boxes import Boxes
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.poses import pose
from planner.robot.shapes import Mesh
from tests.coal_judge import CoalWorld
from tests.random_shapes import KINDS, random_pose, random_shape
from tests.worlds import body, checker_of, load, random_q, scene_of


def near(world: World, q: np.ndarray, reach: float) -> list[tuple[int, int]]:
    """(configuration, pair) of what boxes leave to be asked about."""
    found = Boxes(world).near(*joint_placements(Chain.of(world.robot), q), reach)
    return [pair for rows, pairs in found for pair in zip(rows.tolist(), pairs.tolist(), strict=True)]


def among_things(name: str, seed: int, regime: str = "normal") -> World:
    rng = np.random.default_rng(seed)
    things = [(random_shape(rng, KINDS[k % 5], regime), random_pose(rng, 0.8)) for k in range(12)]
    return make_checker(load(name), scene_of(*things)).world


@pytest.mark.parametrize(("name", "regime"), [("iiwa14", "normal"), ("panda", "thin"), ("ur5", "large")])
def test_no_pair_is_left_out_that_is_near(name: str, regime: str) -> None:
    """With a reach that is hardly that of the pair, for every fifth pair; and half of all pairs are left out."""
    world, count = among_things(name, 3, regime), 0
    judge, q = CoalWorld(world), random_q(load(name), 6, seed=4)
    for each in q:
        distances = judge.distances(each)
        for reach in [0.0, 0.1, *(distances[::5][distances[::5] > 0] + 1e-6)]:
            found = {pair for _, pair in near(world, each[None], reach)}
            assert found >= set(np.flatnonzero(distances <= reach).tolist())
        count += len(near(world, each[None], 0.0))
    assert 0 < count < 0.5 * len(q) * judge.count


@pytest.mark.parametrize("far", [0.0, 1000.0], ids=["here", "a kilometre away"])
@pytest.mark.parametrize(("first", "second"), list(itertools.combinations_with_replacement(KINDS, 2)))
def test_no_pair_of_shapes_is_left_out_that_is_near(first: str, second: str, far: float) -> None:
    rng, there = np.random.default_rng(5), pose([far, 0.0, 0.0])
    for regime in ("normal", "thin", "large") * 2:
        others = [(random_shape(rng, second, regime), there @ random_pose(rng, 1.0)) for _ in range(20)]
        placed = there @ random_pose(rng, 0.3)
        robot = replace(load("planar_2r"), bodies=(body(random_shape(rng, first, regime), placed),))
        world = World.of(robot, scene_of(*others), frozenset())
        for pair, distance in enumerate(CoalWorld(world).distances(np.zeros(2))):
            assert (0, pair) in near(world, np.zeros((1, 2)), max(distance, 0.0) + 1e-5)


@pytest.mark.parametrize("thinned", [0.0, 0.002])
def test_meshes_without_thickness_have_boxes(thinned: float) -> None:
    """A flat one, and one whose triangle has no area, which is asked about with a micrometre of width."""
    flat = Mesh(np.array([[0.0, 0, 0], [0.2, 0, 0], [0.2, 0.2, 0], [0, 0.2, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    line = Mesh(np.array([[0.0, 0, 0], [0.2, 0, 0], [0.1, 0, 0]]), np.array([[0, 1, 2]]))
    above = pose([0.0, 0.0, 0.1])
    robot = replace(load("planar_2r"), bodies=(body(replace(flat, radius=thinned)),))
    world = World.of(robot, scene_of((line, above), (flat, above)), frozenset())
    for pair in (0, 1):
        assert (0, pair) in near(world, np.zeros((1, 2)), 0.1 - thinned)
        assert (0, pair) not in near(world, np.zeros((1, 2)), 0.0998 - thinned)


def test_boxes_that_are_turned_are_told_apart_along_their_own_axes() -> None:
    """Two plates side by side, aslant: their boxes along the world's axes overlap."""
    turn = np.eye(4)
    turn[:2, :2] = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0)
    shape = random_shape(np.random.default_rng(0), "box")
    plate = replace(shape, size=(1.0, 0.02, 1.0))
    beside = turn.copy()
    beside[:3, 3] = turn[:3, 1] * 0.05
    robot = replace(load("planar_2r"), bodies=(body(plate, turn),))
    world = World.of(robot, scene_of((plate, beside)), frozenset())
    assert near(world, np.zeros((1, 2)), 0.0298) == []
    assert near(world, np.zeros((1, 2)), 0.03) == [(0, 0)]


def test_many_configurations_are_answered_as_each_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    world, q = among_things("panda", 6), random_q(load("panda"), 30, seed=7)
    one_by_one = [(k, pair) for k in range(len(q)) for _, pair in near(world, q[k : k + 1], 0.02)]
    assert near(world, q, 0.02) == one_by_one == sorted(one_by_one)
    monkeypatch.setattr(boxes, "_AT_ONCE", 1000)
    assert near(world, q, 0.02) == one_by_one


def test_pairs_that_are_not_checked_are_not_asked_about() -> None:
    world = among_things("iiwa14", 8)
    q, some = random_q(load("iiwa14"), 20, seed=9), np.arange(world.checked.size) % 3 > 0
    left = replace(world, checked=some.reshape(world.checked.shape), self_pairs=world.self_pairs[:0])
    scene = [(k, pair) for k, pair in near(world, q, 0.1) if pair < world.checked.size]
    assert near(left, q, 0.1) == [(k, pair) for k, pair in scene if some[pair]]


@pytest.mark.parametrize("margin", [0.0, 0.01])
@pytest.mark.parametrize(("name", "scene"), [("panda", "shelf"), ("iiwa14", "paper"), ("ur5", "shelf")])
def test_verdicts_are_those_of_all_pairs(name: str, scene: str, margin: float) -> None:
    checker, verdicts = checker_of(name, scene, margin), []
    everything = np.append(checker.world.checked.ravel(), np.ones(len(checker.world.self_pairs), dtype=bool))
    pairs = np.flatnonzero(everything)
    for q in random_q(load(name), 120, seed=11):
        touching = checker.gaps(q, pairs) <= margin
        found = checker.first_touch(q)
        assert (found is not None) == touching.any()
        verdicts.append(found is not None)
        if found is not None and not margin:
            assert found[1] == checker.world.contact(int(pairs[touching][0]))
    assert 0.1 < np.mean(verdicts) < 0.98


@pytest.mark.parametrize("margin", [0.0, 0.02])
def test_no_more_is_looked_at_than_a_few_times_what_the_first_contact_needs(
    margin: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of a thousand were looked at where the first touches: up to two hundred times as much work as was needed."""
    checker = checker_of("ur5", "shelf", margin)
    q, asked, honest = random_q(load("ur5"), 1000, seed=1), [], boxes._overlapping
    q = q[next(k for k in range(len(q)) if checker.first_touch(q[k]) is not None) :]

    def close(*placed: np.ndarray) -> np.ndarray:
        asked.append(len(placed[2]))
        return type(checker.bound).close(checker.bound, *placed)

    def overlapping(*pairs: Any) -> tuple[np.ndarray, np.ndarray]:
        asked.append(max(pairs[0].turns.shape[1], pairs[2].turns.shape[1]))
        return honest(*pairs)

    monkeypatch.setattr(checker.bound, "close", close)
    monkeypatch.setattr(boxes, "_overlapping", overlapping)
    found = checker.first_touch(q)
    assert found is not None
    assert found[0] == 0
    assert max(asked) < 100
