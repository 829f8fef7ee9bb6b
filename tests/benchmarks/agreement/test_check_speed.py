"""Speeds of state and edge checks."""

from __future__ import annotations

import numpy as np

from benchmarks.agreement.check_speed import free_edges, measure_speed
from planner.collision.checker import is_free
from tests.benchmarks.agreement.test_run import pair_of
from tests.worlds import load, random_q


def test_speeds_are_over_free_states_and_edges_only() -> None:
    fcl, coal = pair_of()
    q = random_q(load("planar_2r"), 200, seed=5)
    free = np.array([row for row in q if is_free(fcl, row)])
    edges = free_edges((fcl, coal), free, most=5)
    assert len(edges) == 5
    for states in edges:
        assert len(states) > 10
        assert fcl.first_contact(states) is None
    speed = measure_speed({"fcl": fcl, "coal": coal}, free)
    assert all(value and value > 0 for of in speed.values() for value in (of.single, of.batch, of.edge))
    nothing = measure_speed({"fcl": fcl}, free[:0])["fcl"]
    assert (nothing.single, nothing.batch, nothing.edge) == (None, None, None)
