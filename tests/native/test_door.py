"""Every function of the compiled library on valid input; none reads, writes or believes what is not there."""

# pyright: reportArgumentType=false, reportCallIssue=false
from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planner.base.errors import ArrayError
from planner.native import dynamics, gate, graphs, library, loading, motions, refinement, tree_search, walk
from planner.native import world as worlds
from planner.native.dynamics import NativeArcs, NativeFlow, hops_to_source
from planner.native.library import Charge, KeptBounds, MotionPrices, NativeBoxes, NativeChain, NativeKeeping
from planner.native.refinement import Descent, EvenStretches, Judge, Step, descend, even_stretches
from planner.native.world import NativeWorld
from tests.native.door_cases import CASES, SIZES, Size, a_chain, a_gate, a_world, body_reach_of, bounds_of

SEED = 5


def answers(case: str, size: Size, seed: int = SEED) -> list[np.ndarray]:
    return [np.asarray(found) for found in CASES[case](np.random.default_rng(seed), size)]


def on_threads(patch: pytest.MonkeyPatch, count: int) -> None:
    for module in (library, worlds, graphs, dynamics):
        patch.setattr(module, "threads", lambda: count)
    patch.setattr(dynamics, "_SHARED_FROM", 1)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("case", CASES)
def test_answers_hold_and_are_the_same_bits_again_and_on_threads(
    monkeypatch: pytest.MonkeyPatch, case: str, size: str
) -> None:
    on_threads(monkeypatch, 1)
    once, twice = answers(case, SIZES[size]), answers(case, SIZES[size])
    on_threads(monkeypatch, 3)
    for one, same, shared in zip(once, twice, answers(case, SIZES[size]), strict=True):
        np.testing.assert_array_equal(one, same)
        np.testing.assert_array_equal(one, shared)


def test_no_function_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, whole = {"planner_version"}, loading.library

    class Noting:
        def __getattr__(self, name: str) -> Any:
            asked.add(name)
            return getattr(whole, name)

    for module in (gate, library, motions, refinement, tree_search, walk, worlds):
        monkeypatch.setattr(module, "_library", Noting())
    for module, name in ((graphs, "library"), (dynamics, "library")):
        monkeypatch.setattr(module, name, Noting())
    for case in CASES:
        answers(case, Size())
    made = {f"{name}_free" for name in loading._FREED}
    assert asked == {*loading._ARGUMENTS, *loading._RESULTS, *made}


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
            *world.first_proven(bounds_of(world), curves, *np.ones((2, 60), dtype=int), np.zeros(60), 1e-3),
            *chain.inverse(q, 3, np.eye(4), np.eye(4), True, limits, 10),
            chain.manipulability(q, 3, np.zeros(3), 3),
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
Q, BOUNDS, EYE, NO_INTS = np.zeros((4, 3)), bounds_of(WORLD), np.eye(4), np.zeros(0, dtype=np.int64)
REACH, BODY_REACH, MOVING = np.ones((WORLD.pairs, 3)), body_reach_of(WORLD), np.zeros(WORLD.pairs, dtype=bool)
CURVES, FREE = np.zeros((4, 2, 3)), (np.full(3, -1.0), np.ones(3), np.zeros(3, dtype=bool))


def fresh(bodies: int = 1) -> NativeWorld:
    world = NativeWorld(CHAIN, 0.0)
    for _ in range(bodies):
        world.add_spheres(world.add_hull(1, np.zeros((1, 3)), 0.1), np.zeros((1, 3)), np.ones(1))
    return world


def with_obstacle() -> NativeWorld:
    world = fresh()
    world.add_target(world.add_hull(-1, np.ones((1, 3)), 0.1), np.eye(3), np.ones(3), np.zeros(3), 0.1, False)
    return world


def moving(times: list[float], size: float = 0.1, **other: np.ndarray) -> Callable[[], object]:
    n = len(times)
    given = {"turns": np.array([np.eye(3)] * n), "shifts": np.zeros((n, 3)), "axes": np.zeros((n - 1, 3))}
    given |= {"rates": np.zeros(n - 1), "speeds": np.ones(n - 1)} | other
    return lambda: with_obstacle().set_motion(1, np.array(times), **given, size=size)


def chain_with(**other: Any) -> Callable[[], object]:
    given = {
        "parent": np.array([0, 1]),
        "prismatic": np.zeros(2, dtype=bool),
        "rotations": np.zeros((2, 3, 3, 3)),
        "offset": np.zeros((2, 3)),
        "slide": np.zeros((2, 3)),
        "axis": np.zeros((2, 3)),
    }
    return lambda: NativeChain(**(given | other))


def boxes_with(**other: np.ndarray) -> Callable[[], object]:
    vectors = {name: np.zeros((1, 3)) for name in ("points", "shifts", "low", "high")}
    given = {"inner": np.zeros(1), "outer": np.zeros(1), "turns": np.zeros((1, 3, 3))} | vectors
    return lambda: NativeBoxes(CHAIN, **(given | other))


def keeping_with(**other: Any) -> Callable[[], NativeKeeping]:
    vectors = {name: np.zeros(1) for name in ("centres", "limits", "depths")}
    given = {"joints": np.ones(1), "placements": EYE[None], "pieces": np.ones(1), "counts": np.ones(1)} | vectors
    given |= {"balls": np.zeros(1), "rows": np.zeros((1, 12)), "joint_limits": FREE}
    return lambda: NativeKeeping(CHAIN, **(given | other))


def keeping_proves(curves: np.ndarray, forgiven: float = 0.0, finest: float = 1e-9, **other: np.ndarray) -> object:
    given = KeptBounds(np.ones((1, 3)), np.ones((1, 3, 3)), np.ones((1, 3)), np.ones(1), np.ones(1))
    return keeping_with()().proven(curves, given._replace(**other), forgiven, finest)


PRICES = MotionPrices(np.ones(9), 0, False, 9, np.zeros(3), 0, np.zeros(3), 6)


def motion_costs(start: np.ndarray = Q, end: np.ndarray = Q, **other: Any) -> object:
    return Charge(CHAIN, PRICES._replace(**other)).costs(start, end)


def moves(begin: Any = (0,), prices: MotionPrices = PRICES, room: float = 1e-3, **other: Any) -> object:
    judge = Judge(WORLD, BOUNDS, room, Charge(CHAIN, prices))
    return descend(judge, DESCENT._replace(**other), np.array(begin))


def stretches(begin: int = 0, prices: MotionPrices = PRICES, room: float = 1e-3, **other: Any) -> object:
    judge = Judge(WORLD, BOUNDS, room, Charge(CHAIN, prices))
    return even_stretches(judge, STRETCHES._replace(**other), begin)


ONE, NAN3, NAN = np.ones(1), np.full(3, np.nan), np.nan
CURVE, AXES = np.ones((1, 3, 3)), np.ones(3)
LINE, PHASE = np.ones((1, 3, 2)), np.array([[0.0, 0.0, 1.0, 0.0, 1.0]])
LIMITS = np.ones(2), np.ones(2)
TWO_JOINTS = chain_with()()
DESCENT = Descent(Q, 1, Step(0.3), 0.1, 0.0, (-AXES, AXES), np.ones((2, 2)), np.ones((3, 1, 2, 4)), 3)
STRETCHES = EvenStretches(Q, np.array([[[0, 3]]]), np.ones((1, 1, 3), dtype=bool), np.ones((1, 1)), 0.0, 2)
STATES, BETWEEN = np.zeros((4, 3, 2)), (-np.ones(2), np.ones(2))
WRONG: dict[str, Callable[[], object]] = {
    "chain: a parent behind": chain_with(parent=np.array([0, 2])),
    "chain: a parent below 0": chain_with(parent=np.array([-1, 0])),
    "chain: no joint": chain_with(parent=NO_INTS),
    "chain: rotations of one": chain_with(rotations=np.zeros((1, 3, 3, 3))),
    "chain: an axis of two": chain_with(axis=np.zeros((2, 2))),
    "chain: an offset with NaN": chain_with(offset=np.full((2, 3), np.nan)),
    "chain: a leader below 0": chain_with(following=(np.array([-1, 0]), np.ones(2), np.zeros(2))),
    "chain: more leaders than joints": chain_with(following=(np.array([0, 2]), np.ones(2), np.zeros(2))),
    "chain: a factor with NaN": chain_with(following=(np.array([0, 0]), np.array([1.0, np.nan]), np.zeros(2))),
    "chain: zeros of one": chain_with(following=(np.array([0, 0]), np.ones(2), np.zeros(1))),
    "placements: columns": lambda: CHAIN.placements(Q[:, :1]),
    "points: columns": lambda: CHAIN.points(Q[:, :1], 0, np.zeros(3)),
    "points: joint": lambda: CHAIN.points(Q, 4, np.zeros(3)),
    "points: point": lambda: CHAIN.points(Q, 0, np.zeros(2)),
    "path lengths: delta": lambda: CHAIN.path_lengths(Q, Q[:1], np.ones(4), 0, np.zeros(3)),
    "path lengths: pieces": lambda: CHAIN.path_lengths(Q, Q, np.ones(3), 0, np.zeros(3)),
    "path lengths: no piece": lambda: CHAIN.path_lengths(Q, Q, np.zeros(4), 0, np.zeros(3)),
    "manipulability: columns": lambda: CHAIN.manipulability(Q[:, :2], 0, np.zeros(3), 3),
    "manipulability: joint": lambda: CHAIN.manipulability(Q, -1, np.zeros(3), 3),
    "manipulability: rows": lambda: CHAIN.manipulability(Q, 0, np.zeros(3), 7),
    "motion costs: columns": lambda: motion_costs(start=Q[:, :2]),
    "motion costs: ends": lambda: motion_costs(end=Q[:1]),
    "motion costs: joint": lambda: motion_costs(joint=5),
    "motion costs: rows": lambda: motion_costs(rows=7),
    "motion costs: numbers": lambda: motion_costs(numbers=np.ones(8)),
    "motion costs: kind": lambda: motion_costs(kind=3),
    "motion costs: even states": lambda: motion_costs(fewest=4),
    "motion costs: one state": lambda: motion_costs(fewest=1),
    "motion costs: a NaN price": lambda: motion_costs(numbers=np.array([1.0, 2, 1, 1, NAN, 0, 1, 1, 0])),
    "motion costs: lengths by 0": lambda: motion_costs(numbers=np.array([1.0, 2, 1, 0, 0.5, 0, 1, 1, 0])),
    "motion costs: wraps": lambda: motion_costs(wraps=np.ones(1)),
    "motion costs: point": lambda: motion_costs(point=np.ones(2)),
    "motion costs: too long": lambda: motion_costs(end=Q + 9e9),
    "moves: path": lambda: moves(path=Q[:, :2]),
    "moves: a NaN": lambda: moves(path=NAN * Q),
    "moves: an end": lambda: moves(first=0),
    "moves: no least step": lambda: moves(least=0.0),
    "moves: a step with NaN": lambda: moves(step=Step(NAN)),
    "moves: draws": lambda: moves(draws=np.ones((3, 2, 2, 4))),
    "moves: mixes": lambda: moves(mixes=np.ones((2, 3))),
    "moves: a NaN draw": lambda: moves(draws=NAN * DESCENT.draws),
    "moves: a NaN mix": lambda: moves(mixes=NAN * DESCENT.mixes),
    "moves: a NaN gain": lambda: moves(gain=NAN),
    "moves: a NaN limit": lambda: moves(limits=(NAN3, np.ones(3))),
    "moves: a NaN price": lambda: moves(prices=PRICES._replace(numbers=NAN * PRICES.numbers)),
    "moves: limits": lambda: moves(limits=(ONE, ONE)),
    "moves: prices": lambda: moves(prices=PRICES._replace(kind=-1)),
    "moves: begin": lambda: moves(begin=(-1,)),
    "moves: begins": lambda: moves(begin=(0, 0)),
    "moves: room": lambda: moves(room=-1.0),
    "moves: another arm": lambda: descend(
        Judge(WORLD, BOUNDS, 1e-3, Charge(TWO_JOINTS, PRICES._replace(wraps=np.zeros(2)))), DESCENT
    ),
    "stretches: a NaN": lambda: stretches(path=NAN * Q),
    "stretches: row": lambda: stretches(ends=[[[0, 4]]]),
    "stretches: backwards": lambda: stretches(ends=[[[2, 2]]]),
    "stretches: joints": lambda: stretches(joints=np.ones((1, 1, 2))),
    "stretches: shares": lambda: stretches(shares=np.ones((1, 2))),
    "stretches: a NaN share": lambda: stretches(shares=np.full((1, 1), NAN)),
    "stretches: a NaN gain": lambda: stretches(gain=NAN),
    "stretches: joint": lambda: stretches(prices=PRICES._replace(joint=4)),
    "stretches: begin": lambda: stretches(begin=-1),
    "stretches: room": lambda: stretches(room=NAN),
    "stretches: another arm": lambda: even_stretches(
        Judge(WORLD, BOUNDS, 1e-3, Charge(TWO_JOINTS, PRICES._replace(wraps=np.zeros(2)))), STRETCHES
    ),
    "inverse: columns": lambda: CHAIN.inverse(Q[:, :2], 0, EYE, EYE, True, FREE, 5),
    "inverse: tool": lambda: CHAIN.inverse(Q, 0, EYE[:3], EYE, True, FREE, 5),
    "inverse: targets": lambda: CHAIN.inverse(Q, 0, EYE, np.zeros((len(Q) + 1, 4, 4)), True, FREE, 5),
    "inverse: target": lambda: CHAIN.inverse(Q, 0, EYE, EYE[:3], True, FREE, 5),
    "inverse: limits": lambda: CHAIN.inverse(Q, 0, EYE, EYE, True, (np.ones(2), *FREE[1:]), 5),
    "inverse: joint": lambda: CHAIN.inverse(Q, 9, EYE, EYE, True, FREE, 5),
    "boxes: joint": boxes_with(inner=np.array([7])),
    "boxes: lengths": boxes_with(outer=np.zeros(2)),
    "boxes: NaN": boxes_with(low=np.full((1, 3), np.nan)),
    "boxes: columns": lambda: boxes_with()().hits(Q[:, :1]),  # type: ignore[attr-defined]
    "boxes: a NaN state": lambda: boxes_with()().hits(NAN3[None]),  # type: ignore[attr-defined]
    "keeping: joint": keeping_with(joints=np.array([9])),
    "keeping: rows of two": keeping_with(rows=np.zeros((2, 12))),
    "keeping: NaN": keeping_with(limits=np.full(1, np.nan)),
    "keeping: a half-space of two rows": keeping_with(
        counts=np.full(1, 2), rows=np.zeros((2, 12)), centres=np.zeros(2)
    ),
    "keeping: fewer pieces than rows": keeping_with(counts=np.full(1, -1)),
    "keeping: limits": keeping_with(joint_limits=(np.ones(2), *FREE[1:])),
    "keeping: columns": lambda: keeping_with()().projected(Q[:, :1], np.ones(4), 0.0, 1),
    "keeping: depths": lambda: keeping_with()().projected(Q, np.ones(3), 0.0, 1),
    "keeping: frame": lambda: keeping_with()().slack(0, np.zeros((1, 3, 2)), np.zeros((1, 3))),
    "keeping: columns of a curve": lambda: keeping_proves(np.zeros((1, 2, 2))),
    "keeping: a curve with NaN": lambda: keeping_proves(np.full((1, 2, 3), np.nan)),
    "keeping: a curve of no coefficient": lambda: keeping_proves(np.zeros((1, 0, 3))),
    "keeping: a curve of degree 17": lambda: keeping_proves(np.zeros((1, 18, 3))),
    "keeping: a reach of two": lambda: keeping_proves(np.zeros((1, 2, 3)), reach=np.ones((1, 2))),
    "keeping: a negative reach": lambda: keeping_proves(np.zeros((1, 2, 3)), reach=-np.ones((1, 3))),
    "keeping: rates with NaN": lambda: keeping_proves(np.zeros((1, 2, 3)), rates=np.full((1, 3, 3), np.nan)),
    "keeping: weights of two": lambda: keeping_proves(np.zeros((1, 2, 3)), per_turn=np.ones(2)),
    "keeping: nothing is finest": lambda: keeping_proves(np.zeros((1, 2, 3)), finest=0.0),
    "keeping: forgiven NaN": lambda: keeping_proves(np.zeros((1, 2, 3)), forgiven=NAN),
    "world: margin": lambda: NativeWorld(CHAIN, NAN),
    "world: no points": lambda: fresh().add_hull(1, np.zeros((0, 3)), 0.1),
    "world: points of two": lambda: fresh().add_hull(1, np.zeros((3, 2)), 0.1),
    "world: points with NaN": lambda: fresh().add_hull(1, NAN3[None], 0.1),
    "world: a negative radius": lambda: fresh().add_hull(1, np.zeros((1, 3)), -0.1),
    "world: no such joint": lambda: fresh().add_hull(4, np.zeros((1, 3)), 0.1),
    "world: a cylinder of two": lambda: fresh().add_cylinder(1, np.zeros(3), np.ones(3), np.ones((1, 3))),
    "world: no triangles": lambda: fresh().add_surface(1, np.zeros((1, 3)), np.zeros((0, 3, 3)), 0.1),
    "world: a NaN depth": lambda: fresh().add_surface(1, np.zeros((1, 3)), np.zeros((1, 3, 3)), NAN),
    "world: a body behind an obstacle": lambda: with_obstacle().add_hull(1, np.zeros((1, 3)), 0.1),
    "take: no such item": lambda: fresh().take(WORLD, 6),
    "take: a body behind an obstacle": lambda: with_obstacle().take(WORLD, 0),
    "take: another arm": lambda: NativeWorld(a_chain(np.random.default_rng(0), 2), 0.0).take(WORLD, 0),
    "spheres: none": lambda: NativeWorld(CHAIN, 0.0).add_spheres(0, np.zeros((0, 3)), np.zeros(0)),
    "spheres: of an obstacle": lambda: with_obstacle().add_spheres(1, np.zeros((1, 3)), ONE),
    "spheres: twice": lambda: fresh().add_spheres(0, np.zeros((1, 3)), ONE),
    "target: of a body": lambda: fresh().add_target(0, np.eye(3), np.zeros(3), np.zeros(3), 0.1, False),
    "target: turn": lambda: with_obstacle().add_target(1, np.eye(2), np.zeros(3), np.zeros(3), 0.1, False),
    "target: a NaN size": lambda: with_obstacle().add_target(1, np.eye(3), np.zeros(3), NAN3, 0.1, True),
    "speed limit: of a body": lambda: fresh().set_speed_limit(0, 1.0),
    "travel: NaN": lambda: with_obstacle().set_travel(NAN3),
    "travel: below 0": lambda: with_obstacle().set_travel(-np.ones(3)),
    "travel: joints": lambda: with_obstacle().set_travel(np.ones(2)),
    "speed limit: NaN": lambda: with_obstacle().set_speed_limit(1, NAN),
    "motion: times": moving([0.0, 0.0]),
    "motion: NaN": moving([0.0, NAN]),
    "motion: turns": moving([0.0, 1.0], turns=np.zeros((1, 3, 3))),
    "motion: a NaN speed": moving([0.0, 1.0], speeds=np.full(1, NAN)),
    "motion: a NaN size": moving([0.0, 1.0], size=NAN),
    "motion: of a body": lambda: fresh().set_motion(
        0, np.zeros(1), np.eye(3)[None], np.zeros((1, 3)), *np.zeros((2, 0, 3)), np.zeros(0), 0.1
    ),
    "pairs: too few": lambda: with_obstacle().set_pairs(np.zeros((0, 2)), np.zeros(0)),
    "pairs: no such": lambda: with_obstacle().set_pairs(np.array([[0, 1], [0, 3]]), np.ones(2)),
    "pairs: flags": lambda: with_obstacle().set_pairs(np.array([[0, 1]]), np.ones(2)),
    "pairs: no spheres": lambda: _without_spheres().set_pairs(NO_INTS.reshape(0, 2), NO_INTS),
    "coarse: joints": lambda: WORLD.coarse(np.zeros((3, 4, 3, 3)), np.zeros((3, 4, 3))),
    "coarse: rows": lambda: WORLD.coarse(np.zeros((4, 3, 3, 3)), np.zeros((4, 4, 3))),
    "close: row": lambda: WORLD.close(*CHAIN.placements(Q), np.array([4]), np.array([0])),
    "close: pair": lambda: WORLD.close(*CHAIN.placements(Q), np.array([0]), np.array([WORLD.pairs])),
    "close: lengths": lambda: WORLD.close(*CHAIN.placements(Q), np.zeros(2), np.zeros(1)),
    "first near: columns": lambda: WORLD.first_near(Q[:, :1]),
    "looks: delta": lambda: WORLD.look(BOUNDS, 0.1)(Q[0], Q[0, :2]),
    "looks: reach": lambda: WORLD.look(_of_no_number(), 0.1)(*_free_motion()),
    "looks: no step": lambda: WORLD.look(BOUNDS, 0.0)(*_free_motion()),
    "looks: a NaN step": lambda: WORLD.look(BOUNDS, NAN)(*_free_motion()),
    "looks: a body came later": lambda: _early_look(lambda world: world.add_hull(1, np.zeros((1, 3)), 0.1)),
    "looks: spheres came later": lambda: _early_look(lambda world: world.add_spheres(0, np.zeros((1, 3)), ONE)),
    "prove: columns": lambda: WORLD.prove(BOUNDS, CURVES[:, :, :1], 1e-3),
    "prove: degree": lambda: WORLD.prove(BOUNDS, np.zeros((1, 18, 3)), 1e-3),
    "prove: no coefficients": lambda: WORLD.prove(BOUNDS, np.zeros((1, 0, 3)), 1e-3),
    "bounds: body reach": lambda: WORLD.bounds(REACH, BODY_REACH[:, :1], MOVING),
    "bounds: static pairs": lambda: WORLD.bounds(REACH, BODY_REACH, MOVING[1:]),
    "bounds: reach": lambda: WORLD.bounds(REACH[1:], BODY_REACH, MOVING),
    "prove: a NaN reach": lambda: WORLD.prove(WORLD.bounds(NAN * REACH, BODY_REACH, MOVING), CURVES, 1e-3),
    "prove: a NaN body reach": lambda: WORLD.prove(WORLD.bounds(REACH, NAN * BODY_REACH, MOVING), CURVES, 1e-3),
    "prove: no room": lambda: WORLD.prove(BOUNDS, CURVES, 0.0),
    "prove: a NaN room": lambda: WORLD.prove(BOUNDS, CURVES, NAN),
    "prove: spans": lambda: WORLD.prove(BOUNDS, CURVES, 1e-3, np.zeros((3, 3))),
    "together: columns": lambda: WORLD.prove_together(BOUNDS, CURVES[:, :, :1], 1e-3),
    "together: degree": lambda: WORLD.prove_together(BOUNDS, np.zeros((1, 18, 3)), 1e-3),
    "together: no room": lambda: WORLD.prove_together(BOUNDS, CURVES, 0.0),
    "together: a NaN": lambda: WORLD.prove_together(BOUNDS, NAN * CURVES, 1e-3),
    "together: spans": lambda: WORLD.prove_together(BOUNDS, CURVES, 1e-3, np.zeros((3, 3))),
    "together: a NaN span": lambda: WORLD.prove_together(BOUNDS, CURVES, 1e-3, np.full((4, 3), NAN)),
    "together: a span before its begin": lambda: WORLD.prove_together(BOUNDS, CURVES, 1e-3, -np.ones((4, 3))),
    "gate: limits": lambda: a_gate(CHAIN, WORLD, (np.ones((2, 3)), -np.ones(3), np.ones(3))),
    "gate: a NaN limit": lambda: a_gate(CHAIN, WORLD, (np.full((3, 3), NAN), -np.ones(3), np.ones(3))),
    "gate: positions": lambda: a_gate(CHAIN, WORLD, (np.ones((3, 3)), np.ones(3), -np.ones(3))),
    "gate: apart": lambda: a_gate(CHAIN, WORLD, apart=NAN),
    "gate: lengths": lambda: a_gate(CHAIN, WORLD).check(2, 1, 0, np.zeros(7), True),
    "gate: columns": lambda: a_gate(CHAIN, WORLD).check(2, 4, 0, np.zeros(26), True),
    "gate: no points": lambda: a_gate(CHAIN, WORLD).check(0, 1, 0, np.zeros(0), True),
    "stops: columns": lambda: motions.stops_quickest(STATES, ONE, np.ones((3, 3)), LIMITS),
    "stops: a NaN": lambda: motions.stops_quickest(NAN * STATES, ONE, np.ones((3, 2)), BETWEEN),
    "stops: no times": lambda: motions.stops_quickest(STATES, ONE[:0], np.ones((3, 2)), BETWEEN),
    "stops: times": lambda: motions.stops_quickest(STATES, np.array([2.0, 1.0]), np.ones((3, 2)), BETWEEN),
    "stops: no time": lambda: motions.stops_quickest(STATES, 0 * ONE, np.ones((3, 2)), BETWEEN),
    "stops: a NaN limit": lambda: motions.stops_quickest(STATES, ONE, np.full((3, 2), NAN), BETWEEN),
    "stops: positions": lambda: motions.stops_quickest(STATES, ONE, np.ones((3, 2)), BETWEEN[::-1]),
    "curves: times": lambda: motions.chunk_curves(CURVES, np.ones(4), None, None),
    "curves: stops": lambda: motions.chunk_curves(CURVES, np.ones(5), (np.ones((4, 1, 5, 3)), np.ones((4, 2))), None),
    "curves: approach": lambda: motions.chunk_curves(CURVES, np.ones(5), None, np.ones((2, 2))),
    "curves: no degree": lambda: motions.chunk_curves(CURVES[:, :1], np.ones(5), None, None),
    "first proven: too many motions": lambda: WORLD.first_proven(BOUNDS, CURVES, [5], [1], [0], 1e-3),
    "first proven: too many alternatives": lambda: WORLD.first_proven(BOUNDS, CURVES, [4], [2], [0], 1e-3),
    "first proven: negative ones": lambda: WORLD.first_proven(BOUNDS, CURVES, [5, -1], [2], [0], 1e-3),
    "first proven: begin": lambda: WORLD.first_proven(BOUNDS, CURVES, [4], [1], [-1], 1e-3),
    "chain of motions: price": lambda: WORLD.cheapest_chain(BOUNDS, Q, np.ones((3, 3)), 1e-3),
    "chain of motions: no points": lambda: WORLD.cheapest_chain(BOUNDS, Q[:0], np.ones((0, 0)), 1e-3),
    "costs: kind": lambda: library.manipulability_costs(ONE, 0.1, 0.5, 0.1, 3),
    "cost sums: weights": lambda: library.manipulability_cost_sums(np.ones((2, 3)), np.ones((1, 3)), 0.1, 0.5, 0.1, 1),
    "phases: stops": lambda: motions.curve_phases(LINE, [0, 0], [3], *LIMITS),
    "phases: intervals": lambda: motions.curve_phases(LINE, [0], [0], *LIMITS),
    "phases: limits": lambda: motions.curve_phases(LINE, [0], [3], *np.ones((2, 1))),
    "phases: a limit of 0": lambda: motions.curve_phases(LINE, [0], [3], *np.zeros((2, 2))),
    "phases: a NaN": lambda: motions.curve_phases(NAN * LINE, [0], [3], *LIMITS),
    "phases: no pieces": lambda: motions.curve_phases(LINE[:0], [], [], *LIMITS),
    "phases: standstill": lambda: motions.curve_phases(0 * LINE[[0, 0]], [0, 0], [3, 3], *LIMITS),
    "knots: piece": lambda: motions.curve_knots(LINE, [0], [[1, 0, 0, 1, 1]], 1.0, 10, 10),
    "knots: no phases": lambda: motions.curve_knots(LINE, [0], np.ones((0, 5)), 1.0, 10, 10),
    "knots: a stretch of 0": lambda: motions.curve_knots(LINE, [0], PHASE, 0.0, 10, 10),
    "knots: no window": lambda: motions.curve_knots(LINE, [0], PHASE, 1.0, 0, 10),
    "knots: too long": lambda: motions.curve_knots(LINE, [0], PHASE, 1e10, 10, 10),
    "mean: one point": lambda: motions.motion_mean([0], np.ones((1, 2)), np.ones((1, 2)), 10, 10),
    "mean: times": lambda: motions.motion_mean([0, 0], *np.ones((2, 2, 2)), 10, 10),
    "mean: velocities": lambda: motions.motion_mean([0, 9], np.ones((2, 2)), np.ones((2, 1)), 10, 10),
    "ramp: states": lambda: motions.ramp_quickest((ONE, ONE), (ONE, np.ones(2)), ONE, ONE, ONE),
    "ramp: a limit of 0": lambda: motions.ramp_quickest((ONE, ONE), (ONE, ONE), ONE, 0 * ONE, ONE),
    "next ramp: piece": lambda: next_ramp(PHASE + 1),
    "next ramp: positions": lambda: next_ramp(positions=np.ones((2, 1))),
    "next ramp: a NaN": lambda: next_ramp(moments=[[NAN, 1.0]]),
    "next ramp: joints": lambda: next_ramp(curve=LINE),
    "next ramp: no room": lambda: next_ramp(room=0.0),
    "next ramp: reach": lambda: next_ramp(bounds=_of_no_number()),
    "chords: none a piece": lambda: motions.curve_chords(LINE, 0, 0.1),
    "chords: no length": lambda: motions.curve_chords(LINE, 9, 0.0),
    "chords: a NaN": lambda: motions.curve_chords(NAN * LINE, 9, 0.1),
    "shares: one point": lambda: motions.motion_shares([0], *np.ones((4, 1, 1, 2))[:3, 0], np.ones((3, 2))),
    "shares: times": lambda: motions.motion_shares([9, 9], *np.ones((3, 2, 2)), np.ones((3, 2))),
    "shares: a limit of 0": lambda: motions.motion_shares([0, 9], *np.ones((3, 2, 2)), np.zeros((3, 2))),
    "shares: a NaN": lambda: motions.motion_shares([0, 9], *np.full((3, 2, 2), NAN), np.ones((3, 2))),
    "ramp: a NaN": lambda: motions.ramp_quickest((ONE, NAN * ONE), (ONE, ONE), ONE, ONE, ONE),
    "mean: a NaN": lambda: motions.motion_mean([0, 9], NAN * np.ones((2, 2)), np.ones((2, 2)), 10, 10),
    "worst: no time": lambda: motions.polynomial_worst(LINE, 0 * ONE, 1, np.ones(2), 0.0),
    "worst: a NaN": lambda: motions.polynomial_worst(LINE, ONE, 1, NAN * np.ones(2), 0.0),
    "extrema: degree": lambda: motions.polynomial_extrema(np.ones((1, 18, 2))),
    "extrema: a NaN": lambda: motions.polynomial_extrema(np.full((1, 3, 2), NAN)),
    "worst: no pieces": lambda: motions.polynomial_worst(LINE[:0], ONE[:0], 1, ONE, 0.0),
    "worst: limits": lambda: motions.polynomial_worst(LINE, ONE, 1, ONE, 0.0),
    "detours: node": lambda: graphs.detours(2, np.array([[0, 2]]), ONE, np.array([[0, 1]]), ONE),
    "detours: pair": lambda: graphs.detours(2, np.array([[0, 1]]), ONE, np.array([[0, 2]]), ONE),
    "detours: a negative length": lambda: graphs.detours(2, np.array([[0, 1]]), -ONE, np.array([[0, 1]]), ONE),
    "cheapest: arc": lambda: graphs.cheapest_nodes(2, np.array([[0, -1]]), ONE, np.array([0]), np.array([1])),
    "cheapest: start": lambda: graphs.cheapest_nodes(2, np.array([[0, 1]]), ONE, np.array([2]), np.array([1])),
    "cheapest: a NaN cost": lambda: graphs.cheapest_nodes(2, np.array([[0, 1]]), NAN * ONE, np.zeros(1), np.ones(1)),
    "costs of nodes: values": lambda: graphs.cheapest_costs(2, np.array([[0, 1]]), ONE, np.array([1]), np.ones(2)),
    "costs of nodes: goal": lambda: graphs.cheapest_costs(2, np.array([[0, 1]]), ONE, np.array([-1]), ONE),
    "hops: offsets": lambda: hops_to_source(np.array([0, 2, 1]), np.array([0]), np.array([0])),
    "hops: head": lambda: hops_to_source(np.array([0, 1]), np.array([1]), np.array([0])),
    "hops: source": lambda: hops_to_source(np.array([0, 0]), NO_INTS, np.array([1])),
    "arcs: starts": lambda: NativeArcs(np.array([0, 3]), np.array([0]), None, ONE),
    "arcs: head": lambda: NativeArcs(np.array([0]), np.array([-1]), None, ONE),
    "arcs: offset": lambda: NativeArcs(np.array([0]), np.array([0]), None, np.ones(2)),
    "parents: states": lambda: ARCS.parent_values(None, np.ones(2)),
    "parents: row": lambda: ARCS.parent_values(np.array([2]), np.ones(3)),
    "standing: states": lambda: ARCS.standing(None, np.ones(2)),
    "step: xhat": lambda: ARCS.step(FLOW, None, np.ones(3), np.ones(3), 0.1, 0.1, 1.0),
    "step: row": lambda: ARCS.step(FLOW, np.array([-1]), np.ones(3), np.ones(2), 0.1, 0.1, 1.0),
    "flow: order": lambda: FLOW.moved(3, ONE, 0.1),
    "sketch: room": lambda: FLOW.sketch(None, np.ones(3), np.ones(3), 0.1, np.ones(2)),
    "sketch: states": lambda: FLOW.sketch(None, np.ones(2), np.ones(3), 0.1, np.ones(3)),
    "sketch: whole numbers": lambda: FLOW.sketch(None, np.ones(3), np.ones(3), 0.1, np.ones(3, dtype=np.int64)),
    "advance: parents": lambda: FLOW.advance(None, np.ones(2), np.ones(3), np.ones(3), 0.1, 1.0, np.ones(3)),
    "advance: row": lambda: FLOW.advance([3], ONE, np.ones(3), np.ones(3), 0.1, 1.0, np.ones(3)),
}


def _early_look(add: Callable[[NativeWorld], object]) -> None:
    world = _without_spheres()
    look = world.look(world.bounds(np.zeros((0, 3)), np.ones((1, 3)), NO_INTS), 0.1)
    add(world)
    look(Q[0], Q[0])


def _without_spheres() -> NativeWorld:
    world = NativeWorld(CHAIN, 0.0)
    world.add_hull(1, np.zeros((1, 3)), 0.1)
    return world


def next_ramp(
    phases: object = PHASE,
    moments: object = ((0.0, 1.0),),
    curve: object = CURVE,
    positions: object = (-9 * AXES, 9 * AXES),
    room: float = 1e-3,
    bounds: worlds.NativeBounds = BOUNDS,
) -> object:
    return motions.curve_next_ramp(WORLD, bounds, room, curve, phases, moments, ONE, (AXES, AXES), positions)


def _of_no_number() -> worlds.NativeBounds:
    return WORLD.bounds(NAN * REACH, NAN * BODY_REACH, MOVING)


def _free_motion() -> np.ndarray:
    rng = np.random.default_rng(0)
    return next(q for q in rng.uniform(-2, 2, (500, 2, 3)) if WORLD.first_near(q.sum(axis=0) * [[1.0], [0.5]]) == 2)


@pytest.mark.parametrize("name", WRONG)
def test_what_the_library_cannot_hold_is_refused(name: str) -> None:
    with pytest.raises(ArrayError):
        WRONG[name]()


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
            ones, begin = np.ones(len(curves), dtype=int), np.zeros(len(curves))
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


def test_a_chain_with_a_price_that_is_no_number_is_not_taken() -> None:
    points, price = np.zeros((3, 3)), np.ones((3, 3))
    bounds = ALONE.bounds(np.zeros((0, 3)), np.ones((1, 3)), np.zeros(0, dtype=bool))
    assert ALONE.cheapest_chain(bounds, points, price, 1e-3)[0].tolist() == [0, 2]
    assert ALONE.cheapest_chain(bounds, points, np.nan * price, 1e-3)[0].tolist() == [0, 1, 2]


def test_a_motion_that_takes_too_many_samples_to_hold_is_undecided() -> None:
    curves = np.stack([np.zeros((1, 3)), np.full((1, 3), 1e5)], axis=1)
    verdict, _, samples, *_ = WORLD.prove(BOUNDS, curves, 1e-3)
    assert (verdict.tolist(), samples.tolist()) == ([2], [0])


def test_seeds_and_prices_in_another_order_are_read_as_they_stand() -> None:
    """Copies of arrays in Fortran's order keep it, unless they are told not to."""
    rng = np.random.default_rng(2)
    seeds, price, points = rng.uniform(-1, 1, (5, 3)), rng.uniform(0, 1, (6, 6)), np.zeros((6, 3))
    for one, same in zip(
        CHAIN.inverse(seeds, 3, EYE, EYE, False, FREE, 0),
        CHAIN.inverse(np.asfortranarray(seeds), 3, EYE, EYE, False, FREE, 0),
        strict=True,
    ):
        np.testing.assert_array_equal(one, same)
    first = WORLD.cheapest_chain(BOUNDS, points, price, 1e-3)[0]
    np.testing.assert_array_equal(first, WORLD.cheapest_chain(BOUNDS, points, np.asfortranarray(price), 1e-3)[0])


def test_what_is_taken_from_another_world_moves_as_it_did_there() -> None:
    """A ball comes to where the arm's only body is: the motion is refused at that time, and free before it."""
    chain = chain_with()()
    assert isinstance(chain, NativeChain)

    def finished(world: NativeWorld) -> NativeWorld:
        world.set_pairs(np.array([[0, 1]]), np.ones(1))
        return world

    there, here = NativeWorld(chain, 0.0), NativeWorld(chain, 0.0)
    there.add_spheres(there.add_hull(1, np.zeros((1, 3)), 0.1), np.zeros((1, 3)), np.full(1, 0.1))
    there.add_target(there.add_hull(-1, np.zeros((1, 3)), 0.1), np.eye(3), np.zeros(3), np.zeros(3), 0.1, False)
    poses = np.array([np.eye(3)] * 2), np.array([[5.0, 0, 0], [0.0, 0, 0]])
    there.set_motion(1, np.array([0.0, 5.0]), *poses, np.zeros((1, 3)), np.zeros(1), np.ones(1), 0.1)
    for item in range(2):
        here.take(there, item)
    spans = np.array([[0.0, 0.1, 0.0], [4.9, 0.1, 0.0]])
    for world in (finished(there), finished(here)):
        bounds = world.bounds(np.ones((1, 2)), np.ones((1, 2)), np.zeros(1, dtype=bool))
        verdict = world.prove(bounds, np.zeros((2, 2, 2)), 1e-3, spans)[0]
        assert verdict.tolist() == [0, 2]
