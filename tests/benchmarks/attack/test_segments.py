"""Segments that are called free."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.attack.segments import attack_segments
from planner.base.progress import QUIET
from planner.native.world import NativeWorld


def test_a_prover_that_looks_away_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    honest = NativeWorld.bounds
    monkeypatch.setattr(NativeWorld, "bounds", lambda self, reach, *asked: honest(self, 0.3 * reach, *asked))
    proven = attack_segments(("box", "sphere"), "fcl", 24, np.random.default_rng(0), QUIET)
    assert proven is not None
    assert proven.false_free > 0
    assert proven.found is not None
    assert proven.over > 1e-3
