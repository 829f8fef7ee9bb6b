"""Where a network is cut: bands of equal arcs, halos against a count of crossing arcs, parts against the whole."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.gabf.case import geometric_network
from planner import gabf
from planner.base.errors import OptionError
from planner.gabf.partitioned.cut import Cut, bands
from planner.gabf.problem import Problem, reduce


@pytest.fixture(scope="module")
def problem() -> Problem:
    return reduce(geometric_network(400, 6, np.random.default_rng(3)))


def test_bands_have_equal_arcs_and_tell_less_than_chance(problem: Problem) -> None:
    block, degree = bands(problem, 4), np.bincount(problem.owners)
    arcs = np.bincount(block, weights=degree)
    assert arcs.size == 4
    assert arcs.max() - arcs.min() <= 2 * degree.max()
    chance = np.random.default_rng(0).integers(0, 4, problem.n_rows)
    assert 2 * Cut.of(problem, block, 4).boundary.size < Cut.of(problem, chance, 4).boundary.size


def test_halos_are_what_is_read_across_the_cut(problem: Problem) -> None:
    block = bands(problem, 4)
    cut = Cut.of(problem, block, 4)
    read: list[set[int]] = [set() for _ in range(4)]
    for i, j in zip(problem.owners.tolist(), problem.heads.tolist(), strict=True):
        if j < problem.n_rows and block[i] != block[j]:
            read[block[i]].add(j)
    for k, halo in enumerate(cut.halos):
        assert halo.members.tolist() == np.flatnonzero(block == k).tolist()
        assert sorted(cut.boundary[halo.received].tolist()) == sorted(read[k])
    sent = [halo.members[halo.sent] for halo in cut.halos]
    assert np.concatenate(sent).tolist() == cut.boundary.tolist()
    assert set(cut.boundary.tolist()) == set().union(*read)


def test_every_part_reads_what_its_rows_read_in_the_whole(problem: Problem) -> None:
    rng = np.random.default_rng(1)
    y = problem.pack(rng.uniform(0.0, 20.0, problem.network.n_nodes))
    whole = problem.parent_values(y)
    cut = Cut.of(problem, rng.integers(0, 5, problem.n_rows), 5)
    for halo, (rows, part) in zip(cut.halos, cut.parts(y), strict=True):
        assert part.size < y.size
        np.testing.assert_array_equal(part[: rows.n_rows], y[halo.members])
        np.testing.assert_array_equal(rows.parent_values(part), whole[halo.members])


def test_blocks_without_rows_are_left_out(problem: Problem) -> None:
    cut = Cut.of(problem, np.where(np.arange(problem.n_rows) < 7, 1, 3), 5)
    assert [halo.members.size for halo in cut.halos] == [7, problem.n_rows - 7]
    assert Cut.of(problem, np.zeros(problem.n_rows, dtype=np.int64), 5).boundary.size == 0


def test_an_assignment_is_of_nodes(problem: Problem) -> None:
    given = np.random.default_rng(2).integers(0, 3, problem.network.n_nodes)
    block = gabf.Partition(3, assignment=given).block_of_row(problem)
    for node, found in zip(problem.rows, block, strict=True):
        assert found == given[node]


@pytest.mark.parametrize("bad", [np.zeros(3, dtype=int), np.zeros(400), np.full(400, 2), np.full(400, -1)])
def test_an_assignment_that_makes_no_sense_is_refused(problem: Problem, bad: np.ndarray) -> None:
    with pytest.raises(OptionError, match=r"\(400,\) whole numbers from 0 to 1"):
        gabf.Partition(2, assignment=bad).block_of_row(problem)


@pytest.mark.parametrize("blocks", [0, 100_001])
def test_a_number_of_blocks_that_makes_no_sense_is_refused(blocks: int) -> None:
    with pytest.raises(OptionError, match="from 1 to 100000"):
        gabf.Partition(blocks)
