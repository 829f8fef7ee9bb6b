"""Signals are heard while the compiled library works: every call that can be long ends soon, or comes to an end."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from planner.base.interrupts import StopRequest, stop_requests
from planner.native import compiled
from planner.native.compiled import Charge, NativeChain, NativeConstraints, NativeWorld
from planner.native.refinement import Descent, EvenStretches, ProofSettings, Step, descend, even_stretches
from tests.native.sanitized import MODULE

SOON = 5.0 if MODULE in os.environ else 1.0  # s: sanitizers are slower, and look for something else
TURNS = np.eye(3)


class Rung(Exception):
    pass


@contextmanager
def asking(request: Callable[[], bool]) -> Iterator[None]:
    """While entered, long calls ask this too."""
    stop_requests.append(request)
    try:
        yield
    finally:
        stop_requests.remove(request)


def slider() -> NativeChain:
    """One joint that slides along x."""
    turns = np.stack([TURNS, 0 * TURNS, 0 * TURNS])[None]
    x = np.array([[1.0, 0, 0]])
    return NativeChain(np.zeros(1, dtype=int), np.ones(1, dtype=bool), turns, np.zeros((1, 3)), x, x)


def rail(chain: NativeChain) -> NativeWorld:
    """A ball on the slider, 2 cm from a rail two hundred kilometres long."""
    world = NativeWorld(chain, 0.0)
    world.add_spheres(world.add_hull(1, np.zeros((1, 3)), 0.01), np.zeros((1, 3)), np.full(1, 0.01))
    ends, half = np.array([[-1e5, 0, 0.03], [1e5, 0, 0.03]]), np.array([1e5, 0, 0])
    world.add_target(world.add_hull(-1, ends, 0.0), TURNS, np.array([0, 0, 0.03]), half, 0.0, False)
    world.set_pairs(np.array([[0, 1]]), np.ones(1, dtype=bool))
    return world


CHAIN = slider()
WORLD = rail(CHAIN)
BOUNDS = WORLD.bounds(np.ones((1, 1)), np.ones((1, 1)), np.zeros(1, dtype=bool))
ALONG = np.array([[[-9e4], [18e4]]])  # a million samples and more
ONE, NO, POINT = np.ones(1, dtype=np.int64), np.zeros(1, dtype=bool), np.zeros(3)
MANY = 1_000_000


KEEPING = NativeConstraints(  # of what no position has: x >= 1e5
    CHAIN, ONE, np.eye(4)[None], ONE, ONE, NO, np.eye(12)[:1], np.zeros(1), np.full(1, 1e5), np.ones(1),
    (np.full(1, -9.0), np.full(1, 9.0), NO), -ONE, np.eye(4)[None],
)  # fmt: skip


def far_away() -> tuple[object, ...]:
    limits, goal = (np.full(1, -9.0), np.full(1, 9.0), NO), np.eye(4)
    goal[1, 3] = 1.0
    tool = np.ones(1, dtype=int), np.eye(4)[None], np.array([6])
    return np.linspace(-9, 9, MANY // 2)[:, None], *tool, goal[None, None], limits, 1000


def curve(count: int = 1) -> np.ndarray:
    return np.tile([[0.0] * 9, [1.0] * 9, [0.1] * 9], (count, 1, 1))


def phases(count: int) -> np.ndarray:
    return np.tile([0.0, 0.0, 1.0, 0.0, 1.0], (count, 1))


def ramps() -> tuple[object, ...]:
    moments, bound = np.zeros((MANY, 2)), (np.ones(1), np.ones(1))
    return WORLD, BOUNDS, 1e-4, curve()[:, :, :1], phases(1), moments, np.ones(1000), bound, bound


def circle(ways: int, *ends: object) -> tuple[object, ...]:
    """A graph of many nodes in a circle, each joined to the next one and some others, with more arguments."""
    k, rng = np.arange(MANY), np.random.default_rng(0)
    others = [(k + 1) % MANY, *(rng.permutation(MANY) for _ in range(ways - 1))]
    arcs = np.vstack([np.column_stack([k, other]) for other in others])
    return MANY, arcs, rng.uniform(1, 2, len(arcs)), *ends


def zigzag() -> np.ndarray:
    return np.tile([[0.0], [1.0]], (MANY // 20 + 1, 1))[: MANY // 10 + 1]


TOOL = np.ones(1, dtype=int), POINT[None], (0, 6)
CHARGE = Charge(CHAIN, (0.1, 0.8, 0.01, 2.0, 0.4, 0.0, 9.0, 0.1, 0.0), 1, False, 9, NO, TOOL)
JUDGE = ProofSettings(WORLD, BOUNDS, 1e-4, CHARGE)


def long_descent() -> Descent:
    draws = np.zeros((2, MANY // 20, 9, 2))
    return Descent(zigzag(), 1, Step(0.1), 1e-9, 0.0, (-np.ones(1), np.ones(1)), np.ones((9, 2)), draws, 1)


def long_stretches() -> EvenStretches:
    k, end = 20, MANY // 10
    return EvenStretches(zigzag(), np.array([[[0, end]] * k]), np.ones((1, k, 1), dtype=bool), np.ones((1, k)), 0.0, 2)


ZERO, HALF = np.zeros(1, dtype=int), np.full(1, MANY // 2)
# what is called, and with what
LONG: dict[str, tuple[Callable[..., object], Callable[[], tuple[object, ...]]]] = {
    "path_lengths": (
        CHAIN.path_lengths,
        lambda: (np.zeros((1, 1)), np.ones((1, 1)), 2_000_000_000 * ONE, 1, POINT),
    ),
    "manipulability": (
        CHAIN.manipulability_along,
        lambda: (np.zeros((1, 1)), np.ones((1, 1)), np.zeros(2**25), TOOL),
    ),
    "motion_costs": (CHARGE.costs, lambda: (np.zeros((2**20, 1)), np.ones((2**20, 1)))),
    "descend": (descend, lambda: (JUDGE, long_descent())),
    "even_stretches": (even_stretches, lambda: (JUDGE, long_stretches())),
    "inverse": (CHAIN.inverse, far_away),
    "keeping": (KEEPING.projected, lambda: (np.zeros((MANY, 1)), np.ones(MANY), 0.0, 1000)),
    "close": (
        WORLD.close,
        lambda: (*CHAIN.placements(np.zeros((1, 1))), *np.zeros((2, 9 * MANY), dtype=np.int64)),
    ),
    "first_near": (WORLD.first_near, lambda: (np.zeros((9 * MANY, 1)),)),
    "look": (WORLD.look(BOUNDS, 2e-8), lambda: (np.zeros(1), np.full(1, 9.0))),
    "prove": (WORLD.prove, lambda: (BOUNDS, np.tile(ALONG, (2, 1, 1)), 1e-4)),
    "first_proven": (WORLD.first_proven, lambda: (BOUNDS, ALONG, ONE, ONE, 0 * ONE, 1e-4)),
    "cheapest_chain": (
        WORLD.cheapest_chain,
        lambda: (BOUNDS, np.array([[-9e4], [0.0], [9e4]]), np.triu(np.ones((3, 3))), 1e-4),
    ),
    "curve_next_ramp": (compiled.curve_next_ramp, ramps),
    "cheapest_costs": (compiled.cheapest_costs, lambda: circle(4, ZERO, np.zeros(1))),
    "cheapest_path": (compiled.cheapest_path, lambda: circle(6, HALF, ZERO)),
    "detours": (compiled.detours, lambda: circle(1, np.tile([0, MANY // 2], (50, 1)), np.full(50, np.inf))),
}


@pytest.mark.parametrize("name", LONG)
def test_an_exception_ends_a_long_call(name: str) -> None:
    asked_at = []

    def ring() -> bool:
        asked_at.append(time.process_time())
        raise Rung

    call, arguments = LONG[name]
    given = arguments()
    with asking(ring), pytest.raises(Rung):
        call(*given)
    assert time.process_time() - asked_at[0] < 2 * SOON  # on two processors
    assert len(asked_at) == 1
    assert WORLD.first_near(np.zeros((1, 1))) == 1  # and nothing is left of it


@pytest.mark.parametrize("name", ["prove", "first_proven", "cheapest_chain"])
def test_after_a_stop_unproven_motions_are_undecided(name: str) -> None:
    call, arguments = LONG[name]
    given = arguments()
    with StopRequest() as stop, asking(lambda: bool(stop() or signal.raise_signal(signal.SIGINT))):
        found = call(*given)
        assert stop()
    assert np.asarray(found[0]).tolist() == {"prove": [2, 2], "first_proven": [-1], "cheapest_chain": [0, 1, 2]}[name]


def test_a_thread_that_is_not_the_main_one_is_left_alone() -> None:
    found, asked = [], []
    worker = threading.Thread(target=lambda: found.append(WORLD.first_near(np.zeros((MANY, 1)))))
    with asking(lambda: bool(asked.append(1)) or True):
        worker.start()
        worker.join()
    assert (found, asked) == ([MANY], [])


def test_ctrl_c_is_heard_by_a_program_that_knows_nothing_of_it() -> None:
    # SIGINT may be ignored where tests run in the background
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    code += (
        "; from tests.native.test_interrupts import LONG; call, given = LONG['path_lengths']; print('go', flush=True)"
    )
    code += "; call(*given())"
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as run:
        assert run.stdout.readline() == "go\n"
        time.sleep(0.3)
        begin = time.perf_counter()
        os.kill(run.pid, signal.SIGINT)
        error = run.communicate(timeout=30)[1]
    assert "KeyboardInterrupt" in error
    assert time.perf_counter() - begin < 10  # a busy machine; alone it takes 0.2 s
