"""Around a contact two checkers agree outside a narrow band, and one that is wrong is found."""

from __future__ import annotations

import pytest

from benchmarks.agreement.contact_band import crossing, disagreement
from planner.collision.checker import is_free
from tests.benchmarks.agreement.test_run import FREE, TOUCHING, pair_of


def test_around_a_contact_they_part_company_within_the_band() -> None:
    fcl, coal = pair_of()
    assert is_free(fcl, FREE)
    assert not is_free(fcl, TOUCHING)
    assert all(one.explained for one in crossing(fcl, coal, FREE, TOUCHING))


@pytest.mark.parametrize(("radius", "who"), [(0.1002, "fcl"), (0.0998, "coal")])
def test_a_library_that_is_wrong_is_found_around_a_contact(radius: float, who: str) -> None:
    """A ball that is 0.2 mm too large or too small for one of them: off by more than the band, and by that much."""
    fcl, coal = pair_of(radius)
    found = crossing(fcl, coal, FREE, TOUCHING)
    worst = max(found, key=lambda one: one.band_m)
    assert not worst.explained
    assert 0.00005 < worst.band_m <= 0.00021
    assert {one.touching_by for one in found} == {who}
    assert (worst.first, worst.second) == ("link_2", "ball")


def test_a_disagreement_names_its_pair_as_both_measure_it() -> None:
    fcl, coal = pair_of(0.15)
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_free(fcl, FREE + middle * (TOUCHING - FREE)) else (low, middle)
    q = FREE + (high + 1e-3) * (TOUCHING - FREE)
    one = disagreement(fcl, coal, q)
    assert one is not None
    assert (one.touching_by, one.second) == ("fcl", "ball")
    assert one.coal_m == pytest.approx(0.05, abs=0.005)
    assert one.fcl_m is not None
    assert one.fcl_m <= 0
    assert not one.explained
    assert disagreement(fcl, coal, FREE) is None
    assert disagreement(fcl, coal, TOUCHING) is None
