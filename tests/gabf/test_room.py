"""Facts about the package as a whole: what it loads, and what its documentation shows."""

import subprocess
import sys

import numpy as np

from planner import gabf

from .networks import Network, solve


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


def test_the_example_in_the_docstrings_runs():
    net = Network([0, 0, 1, 3], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], kernel=gabf.Additive())
    assert solve(net).x.tolist() == [0, 1, 2]
    omega = np.array([0.2, 0.4, 0.9])
    net = Network([0, 0, 1, 3], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], node_cost=omega)
    result = solve(net, law=gabf.SingularityFree(T=4.0))
    assert gabf.extract_path(net, result, start=2).tolist() == [2, 1, 0]
