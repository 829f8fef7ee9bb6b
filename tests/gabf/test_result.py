"""What a run hands back: an ending in words, and a proved bracket around its settling."""

import numpy as np

from planner import gabf
from planner.gabf.result import Ending

from .networks import chain, scattered, solve
from .random_runs import draw


def test_endings_have_keys_and_sentences():
    assert [ending.key for ending in Ending] == ["settled", "budget_spent"]
    assert all(ending.value.endswith(".") for ending in Ending)


def test_the_bracket_holds_the_closed_form_of_one_node():
    """dy/dtau = -(y - 1) from y - 1 = 8: within 1e-6 max(1, x*) from tau = log(8e6) on."""
    result = gabf.solve(chain(2), gabf.Nominal(), x0=np.array([0.0, 9.0]), settle_tolerance=1e-6)
    assert result.settling_tau_bracket is not None
    low, high = result.settling_tau_bracket
    assert low <= np.log(8e6) <= high
    assert high <= low * (1 + 1 / 8)


def test_the_date_that_is_told_lies_in_its_bracket():
    """The run's own steps leave it by up to 64 %; first the four of 300 drawn runs that are farthest off."""
    outside = 0
    for seed in (230, 53, 231, 88, *range(60)):
        law, net, x0 = draw(seed)
        result = solve(net, law, x0)
        earliest, latest = result.settling_tau_bracket
        assert earliest <= result.settling_tau <= latest, seed
        assert result.settling_time == law.clock.time(result.settling_tau)
        outside += not earliest <= result.dated_tau <= latest
        closer = result.settling_within(0.1)
        assert closer[0] <= result.dated_within(0.1) <= closer[1]
    assert outside >= 3


def test_a_run_that_did_not_settle_has_none():
    result = gabf.solve(scattered(30), max_steps=2)
    assert result.outcome is Ending.BUDGET_SPENT
    assert result.settling_tau is None
    assert result.settling_tau_bracket is None
