"""An optimiser against the gate: nothing that it calls safe touches, and it finds what is not proven."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.gate.attack import Attack
from planner.gate.guard import Guard
from planner.gate.judging import Judged
from tests.worlds import load


def attacked(robot: str, tries: int, seed: int = 1) -> Attack:
    attack = Attack(load(robot))
    attack.run(tries, np.random.default_rng(seed))
    return attack


@pytest.mark.parametrize(("robot", "tries"), [("planar_2r", 200), ("panda", 24)])
def test_nothing_that_is_called_safe_touches_or_is_beyond_a_limit(robot: str, tries: int) -> None:
    found = attacked(robot, tries).found
    assert (found.tries, found.false, found.beyond) == (tries, [], 0)
    assert found.safe > tries // 10
    assert found.least < 0.02


@pytest.mark.parametrize("left_out", ["motion", "stop"])
def test_it_finds_what_is_not_proven(monkeypatch: pytest.MonkeyPatch, left_out: str) -> None:
    whole = Guard.first_unproven

    def without(self: Guard, curves: Any, spans: Any, on: list[Any]) -> Any:
        kept = [k for k, what in enumerate(on) if what != left_out]
        return whole(self, curves[kept], spans[kept], [on[k] for k in kept]) if kept else None

    monkeypatch.setattr(Guard, "first_unproven", without)
    assert any(attacked("planar_2r", 300, seed).found.false for seed in range(1, 5))


def test_it_finds_limits_that_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Judged, "broken_limit", lambda self: None)
    assert any(attacked("planar_2r", 150, seed).found.beyond for seed in range(1, 5))
