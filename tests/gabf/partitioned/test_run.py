"""Runs on blocks: the same bits as one process for every law, kernel and cut, here and on a cluster."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from benchmarks.gabf.case import geometric_network
from planner import gabf
from planner.base.errors import OptionError
from planner.gabf.partitioned.cut import Cut, bands
from planner.gabf.partitioned.run import partitioned_field
from planner.gabf.problem import reduce
from tests.gabf.networks import from_arcs, scattered, solve

KERNELS = (gabf.TradeOff(0.5), gabf.Multiplicative(K=20.0), gabf.UserKernel(lambda i, a, b: a + b + 0.1 * (i % 3)))
LAWS = (gabf.SingularityFree(T=4.0), gabf.FixedTime(p=(5, 7), m=(13, 7)), gabf.Nominal(), gabf.PrescribedTime())
_NOT_COMPARED = ("x", "x0", "problem", "exchanged", "history", "law")


def assert_same(one: gabf.CostToGo, other: gabf.CostToGo) -> None:
    """Every number of the two results, to the bit."""
    assert np.array_equal(one.x, other.x)
    for name in one.__dataclass_fields__:
        if name not in _NOT_COMPARED:
            assert getattr(one, name) == getattr(other, name), name


@pytest.fixture(scope="module")
def network() -> gabf.Network:
    return geometric_network(400, 6, np.random.default_rng(3))


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
@pytest.mark.parametrize("blocks", [1, 2, 7])
def test_every_law_gives_the_same_bits(network: gabf.Network, law: gabf.Law, blocks: int) -> None:
    whole, cut = solve(network, law), solve(network, law, partition=gabf.Partition(blocks))
    assert_same(whole, cut)
    assert [asdict(c) for c in gabf.certify(network, law, whole)] == [
        asdict(c) for c in gabf.certify(network, law, cut)
    ]
    assert gabf.max_error(cut, gabf.oracle(network)) <= 1e-12


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: type(kernel).__name__)
def test_every_kernel_and_any_assignment_give_the_same_bits(kernel: gabf.Kernel) -> None:
    network = scattered(120, kernel=kernel)
    scrambled = np.random.default_rng(1).integers(0, 5, network.n_nodes)
    whole = solve(network)
    assert_same(whole, solve(network, partition=gabf.Partition(5, assignment=scrambled)))
    assert_same(whole, solve(network, partition=gabf.Partition(400)))


@pytest.mark.parametrize("arcs", [[], [(1, 2), (2, 1)], [(0, 1), (0, 2)], [(1, 0)], [(1, 0), (2, 3), (3, 2)]], ids=str)
@pytest.mark.parametrize("sources", [(0,), (0, 3), (0, 1, 2, 3)], ids=str)
def test_nodes_that_reach_no_source_cost_infinity(arcs: list, sources: tuple[int, ...]) -> None:
    """Nothing to move at all, nodes apart, sources only, more blocks than rows."""
    network = from_arcs(4, [(i, j, 1.0) for i, j in arcs], sources)
    whole = solve(network)
    assert np.array_equal(whole.x, gabf.oracle(network))
    for blocks in (1, 2, 9):
        cut = solve(network, partition=gabf.Partition(blocks))
        assert_same(whole, cut)
        assert gabf.certify(network, cut.law, cut) == gabf.certify(network, whole.law, whole)


def test_rows_that_rest_are_retired_and_the_bits_stay() -> None:
    """Large enough for blocks that group their rows by degree, until one of them rests as a whole, before the other."""
    network = geometric_network(12_000, 8, np.random.default_rng(0))
    assert_same(solve(network), solve(network, partition=gabf.Partition(2)))
    mixed = np.random.default_rng(1).uniform(0.0, 60.0, network.n_nodes)
    options = {"x0": mixed, "max_steps": 60}
    assert_same(solve(network, **options), solve(network, partition=gabf.Partition(2), **options))


def test_what_is_exchanged_is_counted(network: gabf.Network) -> None:
    """Every exchange tells every halo once; a step that is tried again takes one exchange more than its two."""
    problem = reduce(network)
    cut = Cut.of(problem, bands(problem, 4), 4)
    found = solve(network, partition=gabf.Partition(4))
    assert (found.exchanged.blocks, found.exchanged.boundary) == (4, cut.boundary.size)
    exchanges, rest = divmod(found.exchanged.states, sum(halo.received.size for halo in cut.halos))
    assert rest == 0
    assert found.exchanged.calls > exchanges >= 2 * found.steps


def test_states_are_fetched_only_if_they_are_needed(network: gabf.Network) -> None:
    problem, flow = reduce(network), gabf.SingularityFree().flow
    y0 = problem.pack(gabf.overestimate(network))
    with partitioned_field(problem, flow, y0, gabf.Partition(3), clear_above=np.inf) as field:
        calls = field.exchanged.calls
        state = field.state(0.0, 1)
        assert state.standing[3:5] == (y0[: problem.n_rows].min(), y0[: problem.n_rows].max())
        assert state.residual == np.abs(problem.disequilibrium(y0)).max()
        assert field.exchanged.calls == calls
        field.attempt(0.01, state.residual)
        field.accept()
        np.testing.assert_array_equal(state.y, y0)  # asked for a step later
        assert not np.array_equal(field.state(0.01, 2).y, y0)


@pytest.mark.parametrize(
    "options",
    [
        {"solver": gabf.BackwardEuler(0.1)},
        {"save": gabf.EverySteps()},
    ],
)
def test_what_blocks_cannot_do_is_refused(network: gabf.Network, options: dict) -> None:
    with pytest.raises(OptionError):
        solve(network, partition=gabf.Partition(2), **options)


def test_blocks_on_a_cluster_give_the_same_bits(network: gabf.Network, scheduler: str) -> None:
    assert_same(solve(network), solve(network, partition=gabf.Partition(3, scheduler)))
