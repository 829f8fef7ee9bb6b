"""One block: two rows under the linear law, whose solution is known, and the state that it receives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planner.gabf.arcmaps import AffineArcs
from planner.gabf.flows import LinearFlow
from planner.gabf.partitioned.block import Block
from planner.gabf.problem import Rows

RECEIVED = np.array([0.5])
DTAU = 0.1


def make_block() -> Block:
    """Row 0 at 5 reads row 1 at cost 1; row 1 at 3 reads what it receives at cost 2, and is read by others."""
    rows = Rows(np.array([0, 1]), np.array([1, 2]), AffineArcs(None, np.array([1.0, 2.0])))
    return Block(rows, np.array([5.0, 3.0, *RECEIVED]), np.array([1]), 1, LinearFlow())


@pytest.fixture
def block() -> Block:
    return make_block()


def test_the_report_is_of_the_own_rows(block: Block) -> None:
    """xhat = (5 - 4, 3 - 2.5), and the parent value of row 1 is the lowest that moves."""
    assert block.report()[2:] == (1.0, 3.0, 5.0, 2.5)


def test_a_step_follows_the_solution(block: Block) -> None:
    """y1 = 2.5 + e^-t / 2 exactly, as its parent stands still; y0 = 3.5 + (3 + t) e^-t / 2 to the third order."""
    (half,) = block.sketch(DTAU, 1.0, False)
    assert math.exp(-DTAU) < (half - 2.5) / 0.5 < math.exp(-0.5 * DTAU) + 1e-12
    share, (end,) = block.advance(DTAU, 1.0, RECEIVED)
    assert share > 0
    assert end == pytest.approx(2.5 + 0.5 * math.exp(-DTAU), abs=1e-15)
    report = block.accept(RECEIVED)
    first, second = block.states(1)
    assert second == end
    assert first == pytest.approx(3.5 + 0.5 * (3.0 + DTAU) * math.exp(-DTAU), abs=0.1 * DTAU**3)
    assert report[2:] == block.report()[2:] == (first - (second + 1.0), second, first, 2.5)


def test_what_is_received_half_way_is_the_parent_of_the_step_and_at_its_end_of_the_next(block: Block) -> None:
    block.sketch(DTAU, 1.0, False)
    _, (end,) = block.advance(DTAU, 1.0, np.array([0.8]))
    assert end == pytest.approx(2.8 + 0.2 * math.exp(-DTAU), abs=1e-15)
    report = block.accept(np.array([-7.0]))
    first, second = block.states(1)
    assert report.residual == second + 5.0 > first - second - 1.0
    assert report.lowest_moving == -5.0


def test_a_step_that_was_too_long_leaves_no_trace(block: Block) -> None:
    fresh = make_block()
    block.sketch(2.0, 1.0, False)
    block.advance(2.0, 1.0, np.array([9.0]))
    ends = []
    for each in (block, fresh):
        each.sketch(DTAU, 1.0, False)
        each.advance(DTAU, 1.0, RECEIVED)
        ends.append(each.accept(RECEIVED))
    assert ends[0] == ends[1]
    np.testing.assert_array_equal(block.states(1), fresh.states(1))


def test_earlier_states_are_kept_until_they_are_given_up(block: Block) -> None:
    for forget in (False, False, True):
        block.sketch(DTAU, 1.0, forget)
        block.advance(DTAU, 1.0, RECEIVED)
        block.accept(RECEIVED)
        if not forget:
            assert block.states(0).tolist() == [5.0, 3.0]
    assert block.states(2)[0] > block.states(3)[0]
    with pytest.raises(KeyError):
        block.states(1)
