"""Runs drawn at random: exponents from 1/99 to 99, coefficients 10^4 apart, four kernels, starts on both sides."""

from __future__ import annotations

import numpy as np

from planner import gabf

from .networks import from_arcs

BELOW = [(3, 5), (5, 7), (1, 3), (1, 9), (9, 11), (99, 101), (1, 99), (1, 5)]
ABOVE = [(9, 7), (11, 7), (3, 1), (5, 1), (101, 99), (15, 7), (99, 1), (9, 1)]


def draw(seed, most_nodes=12):
    """(law, network, x0): the same for the same ``seed``."""
    rng = np.random.default_rng(seed)
    law = _law(rng)
    net = _network(rng, most_nodes)
    return law, net, _start(rng, net, law.needs_overestimate)


def draw_extreme(seed):
    """The same with costs and starts from 1e-30 to 1e30; what a run has to rise by is at most 100 of the least cost."""
    rng = np.random.default_rng(seed)
    powers = {"p": BELOW[rng.integers(len(BELOW))], "m": ABOVE[rng.integers(len(ABOVE))]}
    law = [gabf.Nominal, gabf.FixedTime, gabf.SingularityFree][rng.integers(3)]
    law = law() if law is gabf.Nominal else law(beta1=_scale(rng, 1e-6, 1e6), beta2=_scale(rng, 1e-6, 1e6), **powers)
    n, cost = int(rng.integers(2, 9)), _scale(rng, 1e-30, 1e30)
    ends = [(i, int(rng.integers(0, i))) for i in range(1, n)]
    ends += [(int(i), int(j)) for i, j in zip(rng.integers(1, n, n), rng.integers(0, n, n), strict=True) if i != j]
    kernel = [gabf.Additive(), gabf.TradeOff(), gabf.EdgeIntegral()][rng.integers(3)]
    costs = {"node_cost": cost * rng.uniform(0.1, 1.0, n), "arc_cost": cost * rng.uniform(0.1, 1.0, len(ends))}
    net = from_arcs(n, [(i, j, cost * rng.uniform(0.1, 1.0)) for i, j in ends], kernel=kernel, **costs)
    above = _scale(rng, 1e-30, 1e30) * rng.random(n) * (rng.random(n) < 0.7)
    return law, net, gabf.oracle(net) + above - 10.0 * cost * rng.random(n) * (rng.random() < 0.5)


def _scale(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _law(rng):
    kind = rng.choice([gabf.Nominal, gabf.PrescribedTime, gabf.FixedTime, gabf.SingularityFree])
    if kind is gabf.Nominal:
        return gabf.Nominal(eta=_scale(rng, 0.01, 100))
    if kind is gabf.PrescribedTime:
        return gabf.PrescribedTime(T=_scale(rng, 0.01, 100))
    powers = {"p": BELOW[rng.integers(len(BELOW))], "m": ABOVE[rng.integers(len(ABOVE))]}
    return kind(beta1=_scale(rng, 0.01, 100), beta2=_scale(rng, 0.01, 100), **powers)


def _network(rng, most_nodes):
    n, shortest = int(rng.integers(2, most_nodes + 1)), _scale(rng, 1e-3, 1.0)
    ends = [(i, int(rng.integers(0, i))) for i in range(1, n)]
    ends += [(int(i), int(j)) for i, j in zip(rng.integers(1, n, n), rng.integers(0, n, n), strict=True) if i != j]
    lengths = [_scale(rng, shortest, 1.0) for _ in ends]
    kernel = rng.choice([gabf.Additive, gabf.TradeOff, gabf.Multiplicative, gabf.NodeDependent])
    if kernel is gabf.Multiplicative:
        lengths = [0.05 + 0.9 * w / (1.0 + w) for w in lengths]
    more = {"node_cost": rng.uniform(0.01, 1.0, n)} if kernel is gabf.TradeOff else {}
    more |= {"source_values": np.ones(1)} if kernel is gabf.NodeDependent else {}
    return from_arcs(n, [(i, j, w) for (i, j), w in zip(ends, lengths, strict=True)], kernel=kernel(), **more)


def _start(rng, net, above):
    n, x_star = net.n_nodes, gabf.oracle(net)
    if above or rng.random() < 0.4:
        share = np.ones(n) if rng.random() < 0.5 else rng.uniform(0.01, 1.0, n)
        if isinstance(net.kernel, gabf.Multiplicative):
            return x_star + (1.0 - x_star) * 0.9 * share
        return x_star + _scale(rng, 1e-3, 1e3) * share
    low, high = {gabf.Multiplicative: (-3.0, 0.9), gabf.NodeDependent: (1.0, 30.0)}.get(type(net.kernel), (-5.0, 20.0))
    return np.full(n, low) if rng.random() < 0.4 else rng.uniform(low, high, n)
