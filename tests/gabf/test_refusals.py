"""Wrong input: what each public name refuses, and the sentence that says so."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array, csr_matrix

from planner import gabf
from planner.base.errors import ArrayError, AssumptionError, OptionError, StateError
from planner.gabf.learning import ErrorDriven, Hebbian
from planner.gabf.path import paths_from
from reproduce.example import nine_node

from .networks import Network, chain, from_arcs, solve

GRAPH: dict[str, Any] = {
    "indptr": [0, 0, 1, 2],
    "indices": [0, 1],
    "weight": [1.0, 2.0],
    "sources": [0],
    "kernel": gabf.Additive(),
}
ARCS: dict[str, Any] = {"tails": [1, 2, 2], "heads": [0, 0, 1], "weight": np.ones(3)}
CUT = from_arcs(4, [(1, 0, 1.0), (2, 3, 1.0), (3, 2, 1.0)])
TINY = from_arcs(3, [(1, 0, 9.0), (1, 2, 0.5), (2, 1, 0.5)])


def user(f):
    return solve(from_arcs(2, [(1, 0, 1.0), (1, 0, 2.0)], kernel=gabf.UserKernel(f)), x0=9.0)


NUMBERS = [
    (lambda: gabf.Nominal(eta=0), "eta must be a positive"),
    (lambda: gabf.PrescribedTime(T=-1), "T must be a positive"),
    (lambda: gabf.PrescribedTime(h=0), "h must be a positive"),
    (lambda: gabf.PrescribedClock(gamma=-1.0), "gamma must be a positive"),
    (lambda: gabf.SingularityFree(gamma=np.inf), "gamma must be a positive finite"),
    (lambda: gabf.SingularityFree(beta1=np.nan), "beta1 must be a positive"),
    (lambda: gabf.FixedTime(beta1=1e-260, beta2=1e-260), "bring both closer to 1"),
    (lambda: gabf.SingularityFree(p=(5, 3)), "p1 < p2"),
    (lambda: gabf.SingularityFree(m=(7, 9)), "m1 > m2"),
    (lambda: gabf.FixedTime(p=(2, 5)), "odd integers"),
    (lambda: gabf.FixedTime(m=(9, 7, 5)), "two positive odd integers"),
    (lambda: gabf.TradeOff(1.1), "beta must be"),
    (lambda: gabf.EdgeIntegral(np.nan), "beta must be"),
    (lambda: gabf.Multiplicative(K=0.0), "K must be a positive number"),
    (lambda: gabf.Splitting(0.0), "tolerance"),
    (lambda: gabf.Splitting(max_step=-1.0), "max_step"),
    (lambda: Hebbian(alpha=0.0), "alpha"),
    (lambda: ErrorDriven(beta=np.nan), "beta"),
    (lambda: solve(chain(3), settle_tolerance=0), "must be positive"),
    (lambda: solve(chain(3), max_steps=-1), "until_tau and save_every at least 0"),
    (lambda: solve(chain(3)).settling_within(1.5), "share of the latest"),
    (lambda: gabf.heal(chain(4), gabf.oracle(chain(4)), since_tau=np.nan), "since_tau"),
    (lambda: solve(chain(3), "nominl"), "'nominl' not found; laws are nominal, prescribed-time, fixed-time, sing"),
]
ASSUMPTIONS = [
    (lambda: Network(**GRAPH | {"indices": [0, 5]}), r"indices\[1\] must be a whole number from 0 to 2, got 5"),
    (lambda: Network(**GRAPH | {"indices": [0.0, 1.5]}), "whole number"),
    (lambda: Network(**GRAPH | {"indices": [0, 2]}), "node 2 reads itself"),
    (lambda: Network(**GRAPH | {"weight": [1.0, np.nan]}), r"weight\[1\] must be finite, got nan"),
    (lambda: Network(**GRAPH | {"weight": [1.0]}), "weight"),
    (lambda: Network(**GRAPH | {"indptr": [0, 2, 1, 2]}), "indptr"),
    (lambda: Network(**GRAPH | {"sources": []}), "sources must be distinct nodes, at least one"),
    (lambda: Network(**GRAPH | {"sources": [0, 0]}), "sources must be distinct nodes"),
    (lambda: Network(**GRAPH | {"source_values": [0.0, 1.0]}), "source_values"),
    (lambda: Network(**GRAPH | {"node_cost": [1.0]}), "node_cost"),
    (lambda: Network(**GRAPH | {"arc_cost": [1.0, np.nan]}), r"arc_cost\[1\] must be finite, got nan"),
    (
        lambda: Network.from_arcs(**ARCS | {"heads": [0, -1, 1]}, sources=[0], n_nodes=3),
        r"heads\[1\] must be a whole number .* got -1",
    ),
    (
        lambda: Network.from_arcs(**ARCS | {"tails": [1.0, 2.5, 2.0]}, sources=[0], n_nodes=3),
        r"tails\[1\] must be a whole number .* got 2.5",
    ),
    (lambda: Network.from_arcs(**ARCS | {"weight": np.ones(4)}, sources=[0], n_nodes=3), "weight"),
    (lambda: Network.from_scipy(csr_array([[0.0, 0.0], [1.0, 1.0]]), [0]), "node 1 reads itself"),
    (lambda: Network.from_scipy(csr_matrix([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]), [0]), r"got shape \(3, 2\)"),
    (lambda: chain(3).arcs_between(1, 3), "from 0 to 2"),
    (lambda: chain(3, kernel=gabf.TradeOff()), "TradeOff kernel needs node_cost"),
    (lambda: chain(3, kernel=gabf.EdgeIntegral()), "EdgeIntegral kernel needs arc_cost"),
    (lambda: chain(2, cost=1.5, kernel=gabf.Multiplicative()), r"arc \(1, 0\) has 1.5"),
    (lambda: chain(2, cost=3.0, kernel=gabf.Multiplicative(K=2.0)), r"arc \(1, 0\) has -0.5"),
    (lambda: solve(from_arcs(3, [(1, 0, 2.0), (2, 1, 0.0)])), r"0 on arc 1, by which node 2 reads node 1"),
    (lambda: gabf.oracle(from_arcs(3, [(1, 0, 2.0), (2, 1, -1.0)])), "node 2 would cost less than node 1"),
    (lambda: gabf.value_iteration(chain(7), np.full(7, 9.0), max_sweeps=3), "still moves after 3 sweeps"),
    (
        lambda: solve(chain(3, 0.5, kernel=gabf.Multiplicative()), x0=1.0),
        r"starts at 1, outside the domain \[-inf, 1\)",
    ),
    (lambda: solve(nine_node(), x0=0.5), r"starts at 0.5, outside the domain \[1, inf\]"),
    (lambda: solve(nine_node(), x0=1.7e308), "overflows"),
    (lambda: solve(chain(3), x0=np.zeros(2)), r"x0 must have shape \(3,\), one state per node, got \(2,\)"),
    (lambda: solve(chain(3), x0=np.array([0.0, 1.0, np.nan])), r"x0\[2\] must be finite, got nan"),
    (lambda: solve(chain(4), gabf.PrescribedTime(), x0=np.array([0.0, 2, 3, 3])), r"node 3 starts at 3 with x\* = 3"),
    (lambda: gabf.heal(chain(4), gabf.oracle(chain(4)), gabf.PrescribedTime()), "start again"),
    (lambda: solve(chain(4, kernel=gabf.UserKernel(lambda i, a, b: 20.0 - a)), x0=0.0), "does not increase"),
    (lambda: user(lambda i, a, b: max(a, b) + b), r"it gets arrays, so use np.maximum\(a, b\) for max"),
    (lambda: user(lambda i, a, b: math.sqrt(a) + b), "np.maximum"),
    (lambda: user(lambda i, a, b: float(a[0] + b[0])), r"shape \(2,\), got shape \(\)"),
    (lambda: gabf.UserLaw(lambda s: s + 1e-3), "sign of the error and be 0 at 0"),
    (lambda: gabf.UserLaw(lambda s: s**2), "sign of the error"),
    (lambda: gabf.UserLaw(lambda s: np.where(s == 0, np.nan, s)), r"rate\(0\) must"),
    (lambda: gabf.UserLaw(math.tanh), "arrays"),
    (lambda: gabf.UserLaw(lambda s: 1.0), r"shape \(\)"),
    (lambda: ErrorDriven(beta=0.1).target(np.array([0.5, 10.0])), "beta"),
    (lambda: gabf.extract_path(chain(4), np.zeros(3), 1), r"x must have shape \(4,\), one state per node, got \(3,\)"),
    (lambda: gabf.extract_path(chain(4), np.array([0.0, 1.0, np.inf, 3.0]), 1), r"x\[2\] must be finite, got inf"),
]
ARRAYS = [(lambda: gabf.true_parents(chain(3), gabf.structure(chain(3)), -1), "from 0 to 2")]
STATES = [
    (lambda: gabf.extract_path(CUT, solve(CUT), 2), "node 2 reaches no source"),
    (lambda: gabf.extract_path(CUT, solve(chain(4)), 3), "node 3 reaches no source"),
    (lambda: gabf.extract_path(CUT, solve(CUT), 4), "start must be a node from 0 to 3, got 4"),
    (lambda: gabf.extract_path(TINY, np.array([0.0, 1.5, 1.0]), 1), "has not settled"),
    (lambda: paths_from(CUT, solve(CUT), [-1]), "whole number"),
]
TYPES = [
    (lambda: solve(chain(3), 4.0), "a name or a law"),
    (lambda: gabf.UserLaw("tanh"), "a function and a clock"),
    (lambda: Network.from_scipy(np.eye(2), [0]), r"must be a SciPy sparse array, got ndarray"),
]


KINDS = (OptionError, AssumptionError, ArrayError, StateError, TypeError)


@pytest.mark.parametrize(
    ("kind", "call", "sentence"),
    [
        (kind, *row)
        for kind, rows in zip(KINDS, (NUMBERS, ASSUMPTIONS, ARRAYS, STATES, TYPES), strict=True)
        for row in rows
    ],
)
def test_wrong_input_is_one_sentence(kind, call, sentence):
    with pytest.raises(kind, match=sentence):
        call()
