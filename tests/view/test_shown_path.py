"""The field that a page shows under a floor: of a node's copies the least cost-to-go."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from planner.view.shown_path import on_roadmap


def test_a_node_with_copies_has_the_least_and_one_without_has_none() -> None:
    layered: Any = SimpleNamespace(roadmap_node=np.array([0, 1, 3, 1, 0]))
    field: Any = SimpleNamespace(x=np.array([5.0, 2.0, 4.0, 1.0, 6.0]))
    found = on_roadmap(layered, field)
    assert found is not None
    assert found.tolist() == [5.0, 1.0, np.inf, 4.0]
    assert on_roadmap(None, field) is None
    assert on_roadmap(layered, None) is None
