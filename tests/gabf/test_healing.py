"""A field that heals equals Dijkstra's answer after every change, and nothing is raised that still stands."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planner import gabf

from .networks import chain, from_arcs, scattered


def changed(net, rng: np.random.Generator):
    """The network with some arcs dearer, cheaper or gone; their numbers and sizes drawn over orders of magnitude."""
    few = rng.choice(net.n_arcs, size=1 + int(rng.integers(0, max(1, net.n_arcs // 4))), replace=False)
    kind = rng.integers(3)
    if kind == 0:
        return net.without_arcs(few)
    weight = np.array(net.weight)
    weight[few] *= np.exp(rng.uniform(0, 3, size=few.size) * (1 if kind == 1 else -1))
    return replace(net, weight=weight)


@pytest.mark.parametrize("seed", range(40))
def test_a_healed_field_is_dijkstras_after_every_change(seed: int) -> None:
    rng = np.random.default_rng(seed)
    whole = scattered(int(rng.integers(2, 80)), seed)
    x = gabf.solve(whole).x
    for _ in range(8):
        net = changed(whole, rng)  # often back, too: what vanished returns
        healed = gabf.heal(net, x)
        x = healed.cost_to_go.x
        x_star = gabf.oracle(net)
        assert gabf.max_error(x, x_star) <= 1e-12
        assert healed.error <= 1e-12
        assert all(
            certificate.holds
            for certificate in gabf.certify(net, healed.cost_to_go.law, healed.cost_to_go)
            if certificate.proven
        )


@pytest.mark.parametrize("seed", range(20))
def test_the_start_is_an_overestimate_that_keeps_what_stands(seed: int) -> None:
    rng = np.random.default_rng(seed)
    net = scattered(60, seed)
    x = gabf.oracle(net)
    np.testing.assert_array_equal(gabf.raise_start(net, x), x)
    after = changed(net, rng)
    start, x_star = gabf.raise_start(after, x), gabf.oracle(after)
    reached = np.isfinite(x_star)
    np.testing.assert_array_equal(np.isfinite(start), reached)
    assert (start[reached] >= x_star[reached] * (1 - 1e-12)).all()
    # where nothing became dearer or vanished, x stands as it is
    cheaper = replace(net, weight=0.5 * net.weight)
    np.testing.assert_array_equal(gabf.raise_start(cheaper, x), x)


def test_only_the_subtree_behind_a_lost_arc_is_raised() -> None:
    # 0 - 1 - 2 - 3 - 4 with a long way around from 3 to 0
    net = from_arcs(5, [(1, 0, 1.0), (2, 1, 1.0), (3, 2, 1.0), (3, 0, 9.0), (4, 3, 1.0)])
    x = gabf.solve(net).x
    healed = gabf.heal(net.without_arcs(net.arcs_between(3, 2)), x)
    assert healed.raised.tolist() == [3, 4]
    np.testing.assert_array_equal(healed.cost_to_go.x, [0, 1, 2, 9, 10])


def test_from_below_the_same_change_takes_many_times_the_steps() -> None:
    """A long way around at arcs of 0.01: x that starts too low counts up by them."""
    short = from_arcs(4, [(1, 2, 0.01), (2, 1, 0.01), (3, 0, 50.0), (1, 3, 1.0), (2, 3, 1.0)])
    x = np.array([0.0, 1.0, 1.0, 0.5])
    slow, quick = gabf.solve(short, x0=x), gabf.heal(short, x).cost_to_go
    np.testing.assert_allclose(slow.x, quick.x)
    assert quick.steps * 5 < slow.steps


def test_a_change_before_the_prescribed_time_acts_within_the_same_clock() -> None:
    law, net = gabf.SingularityFree(T=2.0), chain(30)
    first = gabf.solve(net, law, until_tau=3.0)
    dearer = replace(net, weight=2.0 * net.weight)
    same_clock: Any = gabf.heal(dearer, first.x, law, since_tau=first.end_tau)
    new_clock: Any = gabf.heal(dearer, first.x, law)
    np.testing.assert_allclose(same_clock.cost_to_go.x, 2.0 * np.arange(30))
    assert same_clock.settling_tau == pytest.approx(3.0 + new_clock.settling_tau)
    assert new_clock.settling_time < same_clock.settling_time < 2.0
