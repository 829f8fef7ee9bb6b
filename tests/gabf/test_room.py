"""Facts about the package as a whole: what it loads, and what its documentation shows."""

import doctest
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import scipy.sparse

from planner import gabf
from planner.base import errors

FILES = sorted(Path(str(gabf.__file__)).parent.glob("*.py"))


def test_importing_the_package_loads_no_robot_library_and_no_scipy():
    code = (
        "import sys, planner.gabf as g; g.solve(g.Network.from_arcs([1], [0], [1.0], [0], 2, kernel=g.Additive()));"
        "print([m for m in ('scipy', 'numba', 'pinocchio', 'ompl', 'fcl', 'coal', 'meshcat', 'matplotlib')"
        " if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert shown.strip() == "[]"


def test_every_public_name_is_there_and_documented():
    for name in gabf.__all__:
        assert getattr(gabf, name).__doc__, name


@pytest.mark.parametrize("module", [gabf, *(m for m in vars(gabf).values() if isinstance(m, ModuleType))])
def test_the_examples_in_the_docstrings_run(module):
    names = {"gabf": gabf, "np": np, "scipy": scipy}
    assert doctest.testmod(module, extraglobs=names).failed == 0


def test_the_errors_that_the_room_raises_are_public_in_it():
    text = "".join(path.read_text() for path in FILES)
    raised = {name for name in vars(errors) if name.endswith("Error") and name in text}
    assert {"AssumptionError", "OptionError", "StateError"} <= raised
    assert all(getattr(gabf, name) is getattr(errors, name) and name in gabf.__all__ for name in raised)
