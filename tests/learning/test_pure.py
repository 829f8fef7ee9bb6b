"""Learning knows graphs only, but for the one module that measures a roadmap."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.test_imports import MODULES, imported

GRAPHS_ONLY = [name for name in MODULES if name.startswith("planner.learning") and "roadmap" not in name]
ALLOWED = ("planner.learning", "planner.gabf", "planner.base.arrays", "planner.base.errors", "planner.base.records")


@pytest.mark.parametrize("module", GRAPHS_ONLY)
def test_imports_of_ours_are_of_graphs(module: str) -> None:
    ours = {name for name in imported(MODULES[module]) if name.split(".")[0] == "planner" and name != "planner"}
    assert all(name.startswith(ALLOWED) for name in ours), ours
    assert "planner.learning.roadmap_costs" not in ours


def test_learning_loads_no_robot_library() -> None:
    code = "import planner.learning, sys; print(*{name.split('.')[0] for name in sys.modules})"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"pinocchio", "ompl", "fcl", "coal", "scipy", "matplotlib"} & set(loaded)
    assert "numpy" in loaded
