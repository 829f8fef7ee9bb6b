"""Blocks: the same bits as one process for every law, kernel and cut; halos against a count of crossing arcs."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError
from planner.gabf.partitioned.cut import Cut, bands
from planner.gabf.problem import reduce
from planner.studies.bench_gabf.case import geometric_network
from tests.gabf.networks import scattered, solve

KERNELS = (gabf.TradeOff(0.5), gabf.Multiplicative(K=20.0), gabf.UserKernel(lambda i, a, b: a + b + 0.1 * (i % 3)))
LAWS = (gabf.SingularityFree(T=4.0), gabf.FixedTime(p=(5, 7), m=(13, 7)), gabf.Nominal(), gabf.PrescribedTime())
_NOT_COMPARED = ("x", "x0", "network", "exchanged", "trajectory", "law")


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


def test_rows_that_rest_are_retired_and_the_bits_stay() -> None:
    """Large enough for blocks that group their rows by degree, until one of them rests as a whole, before the other."""
    network = geometric_network(12_000, 8, np.random.default_rng(0))
    assert_same(solve(network), solve(network, partition=gabf.Partition(2)))
    mixed = np.random.default_rng(1).uniform(0.0, 60.0, network.n_nodes)
    options = {"x0": mixed, "max_steps": 60}
    assert_same(solve(network, **options), solve(network, partition=gabf.Partition(2), **options))


def test_halos_are_what_is_read_across_the_cut(network: gabf.Network) -> None:
    problem = reduce(network)
    block = bands(problem, 4)
    cut = Cut.of(problem, block, 4)
    degree = np.diff(problem.starts, append=problem.heads.size)
    arcs = np.bincount(block, weights=degree)
    assert arcs.max() - arcs.min() <= 2 * degree.max()
    for k, halo in enumerate(cut.halos):
        read = {
            int(j)
            for i in np.flatnonzero(block == k)
            for j in problem.heads[problem.starts[i] : problem.starts[i] + degree[i]]
            if j < problem.n_rows and block[j] != k
        }
        assert set(cut.boundary[halo.wanted].tolist()) == read
        assert halo.wanted.size == len(read)
    found = solve(network, partition=gabf.Partition(4)).exchanged
    assert found is not None
    assert found.boundary == cut.boundary.size
    exchanges = found.states / sum(halo.wanted.size for halo in cut.halos)
    assert exchanges == round(exchanges)


def test_bands_tell_less_than_chance(network: gabf.Network) -> None:
    problem = reduce(network)
    chance = np.random.default_rng(0).integers(0, 4, problem.n_rows)
    assert 2 * Cut.of(problem, bands(problem, 4), 4).boundary.size < Cut.of(problem, chance, 4).boundary.size


@pytest.mark.parametrize(
    "options",
    [
        {"solver": gabf.BackwardEuler(0.1)},
        {"save": gabf.EverySteps()},
        {"partition": gabf.Partition(2, assignment=np.array([0, 5]))},
    ],
)
def test_what_blocks_cannot_do_is_refused(network: gabf.Network, options: dict) -> None:
    with pytest.raises(OptionError):
        solve(network, **{"partition": gabf.Partition(2)} | options)
    with pytest.raises(OptionError):
        gabf.Partition(0)


def test_blocks_on_a_cluster_give_the_same_bits(network: gabf.Network) -> None:
    pytest.importorskip("distributed")
    from planner.base.cluster import local_cluster

    with local_cluster(2) as scheduler:
        cut = solve(network, partition=gabf.Partition(3, scheduler))
    assert_same(solve(network), cut)
