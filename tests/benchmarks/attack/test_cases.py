"""The cases that the attack draws."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks.attack.cases import KINDS, random_case


@pytest.mark.parametrize("kind", KINDS)
def test_the_climb_keeps_shapes_and_placements_usable(kind: str) -> None:
    rng, case = np.random.default_rng(1), None
    for _ in range(60):
        case = random_case((kind, "mesh"), "distances", rng)
        for place in (case.place_first, case.place_second):
            np.testing.assert_allclose(place[:3, :3] @ place[:3, :3].T, np.eye(3), atol=1e-9)
    assert isinstance(json.dumps(case.describe()), str) if case else False
