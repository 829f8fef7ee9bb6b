"""The resolutions fit each other: a check samples no coarser than the checked motion."""

from planner.base import resolutions as r


def test_finer_where_it_is_final() -> None:
    assert r.W_AGAINST_FLOOR < r.W_ALONG_PATH < r.W_IN_GROWTH
    assert r.RECHECK < r.CLEARANCE_ALONG_PATH < r.CLEARANCE_FIRST
    assert r.RECHECK < r.FINEST_IN_FIRST_PATH < r.MOTION_IN_FIRST_PATH <= r.MOTION_IN_GROWTH
    assert r.PROOF < r.PROOF_OF_CHECK < r.EXTRA_CLEARANCE


def test_counts_allow_their_rules() -> None:
    assert r.W_STATES_PER_EDGE % 2 == 1, "Simpson's rule"
    assert r.SHOWN_STATES % 2 == 1, "every second state carries an ellipsoid, both ends included"
    assert (r.SHOWN_STATES - 1) % (r.CLEARANCES_OF_MOTION - 1) == 0
