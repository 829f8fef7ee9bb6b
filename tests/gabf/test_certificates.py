import json
from dataclasses import replace

import numpy as np
import pytest

from planner import gabf
from planner.gabf import certificates

from .networks import chain, from_arcs, scattered, solve

NET = scattered(100, seed=6)
FINE = gabf.Splitting(0.005)


def by_name(certificates):
    return {(c.equation, c.ours): c for c in certificates}


@pytest.mark.parametrize("start", [None, 0.0, 50.0, "mixed"])
@pytest.mark.parametrize("law", [gabf.FixedTime(), gabf.SingularityFree()], ids=lambda law: law.name)
def test_fixed_time_certificates_hold(law, start):
    x0 = np.random.default_rng(1).uniform(-10, 40, 100) if start == "mixed" else start
    found = gabf.certify(NET, law, solve(NET, law, x0, FINE))
    assert len(found) == 7
    assert all(c.holds for c in found), [c.name for c in found if not c.holds]
    theorem = next(c for c in found if "corrected" in c.name)
    ours = min(c.bound for c in found if c.ours and c.quantity == "settling tau")
    assert ours < theorem.bound
    if law.prescribed_time:
        assert theorem.log10_remaining < np.log10(law.T)
    else:
        assert theorem.log10_remaining is None


@pytest.mark.parametrize("law", [gabf.Nominal(), gabf.PrescribedTime()], ids=lambda law: law.name)
def test_exponential_certificates_hold_along_the_whole_run(law):
    result = solve(NET, law, solver=FINE, save=gabf.EverySteps(1))
    found = gabf.certify(NET, law, result)
    equations = {c.equation for c in found}
    assert {"eq. (errorbound)", "lemma (over)", "eq. (boundt)"} <= equations
    if law.prescribed_time:
        assert {"eq. (lowerli)", "eq. (ute)"} <= equations
    assert all(c.holds for c in found), [c.name for c in found if not c.holds]


def test_theorems_whose_assumptions_fail_promise_nothing():
    result = solve(NET, gabf.Nominal(), x0=0.0)
    assert {c.equation for c in gabf.certify(NET, result.law, result)} == {
        "lemma (globalbound)",
        "lemma (globalexistence)",
    }


def test_a_certificate_can_be_stored():
    result = solve(NET)
    stored = json.loads(json.dumps([c.to_dict() for c in gabf.certify(NET, result.law, result)], allow_nan=False))
    for c in stored:
        settling = c["quantity"] == "settling tau"
        assert c["slack"] == pytest.approx(c["bound"] - c["measured"])
        assert not settling or c["earliest"] <= c["measured"] <= c["latest"]
    assert {c["ours"] for c in stored} == {True, False}
    assert all(a["holds"] for c in stored for a in c["assumptions"])


def numbers(*found: float | None) -> list[float]:
    """Those of a run that settled."""
    return [number for number in found if number is not None]


@pytest.mark.parametrize("share", [0.9, 0.999, 1.0, 1.001, 1.1])
def test_a_date_beside_a_bound_is_as_close_as_it_takes(share):
    """eq. (errorbound) is the date itself where a chain starts from equal errors; steps that are off change nothing."""
    net, law = chain(4), gabf.Nominal()
    result = solve(net, law, gabf.oracle(net) + 5.0)
    off = replace(result, dated_tau=share * result.dated_tau)
    found = [c for c in gabf.certify(net, law, off) if c.equation == "eq. (errorbound)"]
    assert len(found) == 2
    for c in found:
        assert c.holds
        low, date, high = numbers(c.earliest, c.measured, c.latest)
        assert low <= date <= min(c.bound, high)


@pytest.mark.parametrize("bound", ["below", "between", "above"])
def test_what_holds_is_what_the_numbers_say(bound):
    """A bound before the earliest date is broken, one after the latest holds; between both it is not told apart."""
    result = solve(NET, x0=3.0)
    earliest, latest = result.settling_within(0.01)
    asked = {"below": 0.99 * earliest, "between": 0.5 * (earliest + latest), "above": 1.01 * latest}[bound]
    date, low, high = numbers(*certificates._date(replace(result, dated_tau=2.0 * latest), asked))
    assert low <= date <= high
    assert (date <= asked) == (bound != "below")
    assert bound != "between" or (date == asked and high <= 1.01 * low)


def test_arcs_that_vanish_beside_the_field_are_no_progress():
    net = from_arcs(3, [(1, 0, 1.0), (2, 1, 1e-20)])
    result = solve(net)
    assert result.x.tolist() == [0.0, 1.0, 1.0]
    assert gabf.certify(net, result.law, result) == []


@pytest.mark.parametrize("arcs", [[(1, 0, 1e-20)], [(1, 0, 1e-20), (2, 0, 1.0)]])
@pytest.mark.parametrize("law", [gabf.PrescribedTime(), gabf.SingularityFree()], ids=lambda law: law.name)
def test_nor_are_those_that_vanish_beside_a_source(arcs, law):
    net = from_arcs(len(arcs) + 1, arcs, source_values=[1.0])
    assert gabf.certify(net, law, solve(net, law, save=gabf.EverySteps())) == []


@pytest.mark.parametrize(("stages", "tolerance"), [(100, 1e-10), (10, 1e-12)])
def test_paths_that_cost_more_by_next_to_nothing_are_no_optimal_ones(stages, tolerance):
    """Of two arcs and one past both, dearer by less than what counts as a tie: many such add up to the tolerance."""
    cost = 0.5 / stages
    arcs = [(i, i - 1, cost) for i in range(1, 2 * stages + 1)]
    arcs += [(2 * k, 2 * k - 2, 2.0 * cost + 0.9e-12) for k in range(1, stages + 1)]
    net = from_arcs(2 * stages + 1, arcs)
    start = gabf.oracle(net) + 3.0 * tolerance
    result = solve(net, gabf.Nominal(), start, FINE, settle_tolerance=tolerance)
    earliest, _ = result.settling_within(0.02)
    settling = [c for c in gabf.certify(net, result.law, result) if c.quantity == "settling tau"]
    assert min(c.bound for c in settling) >= earliest


def test_a_rise_at_no_pace_that_a_double_holds_has_no_end():
    net, law = chain(4, 1e-300), gabf.FixedTime(beta1=1e-150, beta2=1e-150)
    settling = [c for c in gabf.certify(net, law, solve(net, law)) if c.quantity == "settling tau"]
    assert all(c.holds for c in settling if c.proven)
    theorem, ours = settling[0], settling[-1]
    assert theorem.to_dict()["bound"] is None
    assert np.isfinite(ours.bound)


def test_a_run_that_did_not_settle_holds_no_certificate_on_its_settling():
    result = solve(NET, max_steps=2)
    settling = [c for c in gabf.certify(NET, result.law, result) if c.quantity == "settling tau"]
    assert settling
    assert not any(c.holds for c in settling)
    assert all(c.measured is None and c.to_dict()["slack"] is None for c in settling)
