"""The compiled code on valid input, on one thread and many, and on input that it refuses."""

import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from planner.base.errors import ArrayError
from planner.native.compiled import NativeArcs, NativeChain, NativeFlow, NativeWorld, cheapest_path, set_threads
from tests.native.door_cases import CASES, SIZES, Size, a_chain, a_world, bounds_of, tool_at

SEED = 5


@pytest.fixture(autouse=True)
def _as_many_threads_as_there_are() -> Iterator[None]:
    yield
    set_threads(0)


def answers(case: str, size: Size) -> list[np.ndarray]:
    return [np.asarray(found) for found in CASES[case](np.random.default_rng(SEED), size)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("case", CASES)
def test_answers_hold_and_are_the_same_bits_again_and_on_threads(case: str, size: str) -> None:
    set_threads(1)
    once, twice = answers(case, SIZES[size]), answers(case, SIZES[size])
    set_threads(3)
    for one, same, shared in zip(once, twice, answers(case, SIZES[size]), strict=True):
        np.testing.assert_array_equal(one, same)
        np.testing.assert_array_equal(one, shared)


@pytest.mark.parametrize("same", [True, False])
def test_several_threads_ask_at_once(same: bool) -> None:
    """Of one world and of several, all get what they get alone."""
    several = [a_world(np.random.default_rng(SEED if same else k), Size(rows=40)) for k in range(4)]
    if same:
        several = several[:1] * 4
    rng = np.random.default_rng(1)
    q, delta = rng.uniform(-2, 2, (2, 60, 3))
    curves = np.stack([q, 0.05 * delta], axis=1)

    def ask(k: int) -> list[Any]:
        chain, world = several[k]
        limits = np.full(3, -2.0), np.full(3, 2.0), np.zeros(3, dtype=bool)
        placed = chain.placements(q)
        return [
            *placed,
            world.coarse(*placed),
            world.first_near(q),
            *world.prove(bounds_of(world), curves, 1e-3),
            *world.first_proven(bounds_of(world), curves, *np.ones((2, 60), dtype=int), np.zeros(60, dtype=int), 1e-3),
            *chain.inverse(q, *HAND, np.eye(4)[None, None], limits, 10),
            chain.manipulability(q, tool_at(3, np.zeros(3))),
        ]

    alone, found = [ask(k) for k in range(4)], [[] for _ in range(4)]
    threads = [threading.Thread(target=lambda k=k: found[k].extend(ask(k) for _ in range(5))) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in range(4):
        assert len(found[k]) == 5
        for again in found[k]:
            for one, other in zip(alone[k], again, strict=True):
                np.testing.assert_array_equal(one, other)


CHAIN, WORLD = a_world(np.random.default_rng(SEED), Size())
_, ALONE = a_world(np.random.default_rng(SEED), Size(bodies=1, obstacles=0))
ARCS, FLOW = NativeArcs(np.array([0, 1]), np.array([2, 0]), None, np.ones(2)), NativeFlow(1.0, 1.0, 0.4, 0.3)
Q, POINT, BOUNDS, PAIR = np.zeros((4, 3)), np.zeros(3), bounds_of(WORLD), np.array([[0, 1]])
HAND = np.array([3]), np.eye(4)[None], np.array([6])
FREE, CURVES = (np.full(3, -1.0), np.ones(3), np.zeros(3, dtype=bool)), np.zeros((1, 2, 3))
TYPES: dict[str, Callable[[], object]] = {  # another type of numbers, number of axes, or length that is always the same
    "whole numbers": lambda: CHAIN.placements(Q.astype(int)),
    "numbers for flags": lambda: WORLD.set_pairs(PAIR, np.ones(1)),
    "floats for indices": lambda: cheapest_path(2, PAIR.astype(float), np.ones(1), PAIR[0, :1], PAIR[0, 1:]),
    "one axis": lambda: CHAIN.placements(Q[0]),
    "a point of two": lambda: CHAIN.points(Q, 0, np.zeros(2)),
    "a list": lambda: CHAIN.placements([[0.0, 0.0, 0.0]]),
    "no copy is written into": lambda: FLOW.sketch(None, np.ones(2), np.ones(2), 0.1, np.ones(4)[::2]),
}
VALUES: dict[str, Callable[[], object]] = {  # a length that does not fit, an index of nothing, what is no number
    "columns": lambda: CHAIN.placements(Q[:, :2]),
    "lengths": lambda: CHAIN.path_lengths(Q, Q[:1], np.ones(4, dtype=int), 0, POINT),
    "joint": lambda: CHAIN.points(Q, 4, POINT),
    "rows": lambda: CHAIN.manipulability(Q, tool_at(0, POINT, (3, 7))),
    "tools": lambda: CHAIN.manipulability(Q, (np.array([0, 1]), np.zeros((1, 3)), (0, 3))),
    "targets": lambda: CHAIN.inverse(Q, *HAND, np.zeros((3, 1, 4, 4)), FREE, 5),
    "targets of two tools": lambda: CHAIN.inverse(Q, *HAND, np.zeros((1, 2, 4, 4)), FREE, 5),
    "a parent behind": lambda: NativeChain(np.array([1]), FREE[2][:1], np.zeros((1, 3, 3, 3)), *np.zeros((3, 1, 3))),
    "margin": lambda: NativeWorld(CHAIN, np.nan),
    "a point that is no number": lambda: NativeWorld(CHAIN, 0.0).add_hull(1, np.full((1, 3), np.nan), 0.1),
    "another arm": lambda: NativeWorld(a_chain(np.random.default_rng(0), 2), 0.0).take(WORLD, 0),
    "configuration": lambda: WORLD.close(*CHAIN.placements(Q), np.array([4]), np.array([0])),
    "pair": lambda: WORLD.close(*CHAIN.placements(Q), np.array([0]), np.array([WORLD.pairs])),
    "bounds of another world": lambda: ALONE.prove(BOUNDS, CURVES, 1e-3),
    "looks by bounds of another world": lambda: ALONE.look(BOUNDS, 0.1),
    "reach": lambda: WORLD.bounds(np.ones((1, 3)), np.ones((3, 3)), np.zeros(WORLD.pairs, dtype=bool)),
    "a reach that is no number": lambda: WORLD.prove(_of_no_number(), CURVES, 1e-3),
    "degree": lambda: WORLD.prove(BOUNDS, np.zeros((1, 18, 3)), 1e-3),
    "room": lambda: WORLD.prove(BOUNDS, CURVES, np.nan),
    "spans": lambda: WORLD.prove(BOUNDS, CURVES, 1e-3, np.zeros((2, 3))),
    "alternatives": lambda: WORLD.first_proven(BOUNDS, CURVES, np.array([2]), np.array([1]), np.array([0]), 1e-3),
    "prices": lambda: WORLD.cheapest_chain(BOUNDS, Q, np.ones((4, 3)), 1e-3),
    "a node": lambda: cheapest_path(1, PAIR, np.ones(1), PAIR[0, :1], PAIR[0, :1]),
    "a negative cost": lambda: cheapest_path(2, PAIR, -np.ones(1), PAIR[0, :1], PAIR[0, :1]),
    "a head that is no state": lambda: ARCS.parent_values(None, np.ones(2)),
    "a row": lambda: ARCS.parent_values(np.array([2]), np.ones(3)),
    "room for states": lambda: FLOW.sketch(None, np.ones(3), np.ones(3), 0.1, np.ones(2)),
}


def _of_no_number() -> Any:
    return WORLD.bounds(np.full((WORLD.pairs, 3), np.nan), np.full((3, 3), np.nan), np.zeros(WORLD.pairs, dtype=bool))


@pytest.mark.parametrize("name", TYPES)
def test_another_type_is_refused(name: str) -> None:
    with pytest.raises(TypeError, match="incompatible function arguments"):
        TYPES[name]()


@pytest.mark.parametrize("name", VALUES)
def test_unusable_values_are_refused(name: str) -> None:
    with pytest.raises(ArrayError, match="the compiled code cannot use what it was given"):
        VALUES[name]()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e30])
def test_no_number_is_never_free(bad: float) -> None:
    """In a state, in any coefficient of a motion, in a time; where there is nothing to touch as well."""
    for size in (Size(), Size(obstacles=0, bodies=1)):
        _, world = a_world(np.random.default_rng(1), size)
        bounds = bounds_of(world)
        for degree in (1, 5):
            curves = np.repeat(np.zeros((1, degree + 1, 3)), 3 * (degree + 1), axis=0)
            curves.reshape(len(curves), -1)[np.arange(len(curves)), np.arange(len(curves))] = bad
            assert (world.prove(bounds, curves, 1e-3)[0] == 2).all()
            ones, begin = np.ones(len(curves), dtype=int), np.zeros(len(curves), dtype=int)
            spans = np.zeros((3, 3))
            np.fill_diagonal(spans, bad)
            assert (world.prove(bounds, np.zeros((3, degree + 1, 3)), 1e-3, spans)[0] == 2).all()
            if degree == 1:
                assert (world.first_proven(bounds, curves, ones, ones, begin, 1e-3)[0] == -1).all()
    state = np.zeros((1, 3))
    state[0, 1] = bad
    assert WORLD.first_near(state) == 0
    assert not WORLD.look(BOUNDS, 0.1)(state[0], Q[0])
    assert not WORLD.look(BOUNDS, 0.1)(Q[0], state[0])


def test_a_motion_that_takes_too_many_samples_to_hold_is_undecided() -> None:
    curves = np.stack([np.zeros((1, 3)), np.full((1, 3), 1e5)], axis=1)
    verdict, _, samples, *_ = WORLD.prove(BOUNDS, curves, 1e-3)
    assert (verdict.tolist(), samples.tolist()) == ([2], [0])
