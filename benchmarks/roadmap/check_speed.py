"""How fast a checker answers: configuration by configuration, in batches, and along whole edges."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker, is_free
from planner.collision.looks import states_along

ROUNDS = 5
_SINGLES = 400
_EDGE_STEP = 0.02  # m of motion between the states of an edge
_EDGE_MOTION = 2.0  # m that a point moves at most on an edge


@dataclass(frozen=True)
class Speed:
    """Microseconds per state, medians of interleaved rounds: asked one by one, all at once, and edge by edge.

    ``edge`` counts free edges of about a hundred states each, so that every state of them had to be checked.
    """

    single: float
    batch: float
    edge: float | None


def measure_speed(checkers: Mapping[str, CollisionChecker], free: Floats) -> dict[str, Speed]:
    """The speed of each checker on the same free configurations (n, dof) and on the same free edges between them.

    The checkers take turns, round by round, so that a neighbour's load on the machine falls on all of them alike.
    """
    edges = free_edges(tuple(checkers.values()), free)
    singles = free[:_SINGLES]
    looks: dict[str, tuple[int, Callable[[CollisionChecker], None]]] = {
        "single": (len(singles), lambda checker: _each(checker, singles)),
        "batch": (len(free), lambda checker: _all_at_once(checker, free)),
        "edge": (sum(map(len, edges)), lambda checker: _edge_by_edge(checker, edges)),
    }
    seconds = {(name, look): [] for name in checkers for look in looks}
    for _ in range(ROUNDS):
        for look, (count, run) in looks.items():
            for name, checker in checkers.items():
                if count:
                    begin = time.perf_counter()
                    run(checker)
                    seconds[name, look].append((time.perf_counter() - begin) / count)
    return {
        name: Speed(**{look: _microseconds(seconds[name, look]) for look in looks})  # type: ignore[arg-type]
        for name in checkers
    }


def free_edges(checkers: Sequence[CollisionChecker], free: Floats, most: int = 20) -> list[Floats]:
    """The states (k, dof) along up to ``most`` edges that every checker finds free, between free configurations."""
    if not len(free):
        return []
    world = checkers[0].world
    edges: list[Floats] = []
    for a, b in zip(free[:200], np.roll(free[:200], -1, axis=0), strict=True):
        delta = world.robot.difference(a, b)
        motion = float(world.reach.motion(delta[None]).max(initial=0.0))
        share = min(1.0, _EDGE_MOTION / motion) if motion > 0 else 1.0
        states = states_along(a, share * delta, share * motion, _EDGE_STEP)
        if all(checker.first_touch(states) is None for checker in checkers):
            edges.append(states)
        if len(edges) == most:
            break
    return edges


def _each(checker: CollisionChecker, q: Floats) -> None:
    for row in q:
        is_free(checker, row)


def _all_at_once(checker: CollisionChecker, q: Floats) -> None:
    checker.first_touch(q)


def _edge_by_edge(checker: CollisionChecker, edges: Sequence[Floats]) -> None:
    for states in edges:
        checker.first_touch(states)


def _microseconds(seconds: Sequence[float]) -> float | None:
    return 1e6 * statistics.median(seconds) if seconds else None
