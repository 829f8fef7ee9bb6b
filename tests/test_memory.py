"""Nothing that C++ holds is freed too early: plans and planners under the allocators' debug hooks, collected often.

Freed memory is overwritten there, so that a later read crashes.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

_HOOKS = {
    "PYTHONMALLOC": "malloc_debug",  # Python's own hooks, over the C library's allocator
    "MALLOC_PERTURB_": "165",  # glibc: what is freed is overwritten
    "MALLOC_CHECK_": "3",  # glibc: a block that is freed twice, or written past its end, ends the process
    "LD_PRELOAD": "libc_malloc_debug.so.0",  # where glibc 2.34 and later have what MALLOC_CHECK_ asks for
}

_OFTEN = "import gc; gc.set_threshold(100, 2, 2)\n"

_PLANS = """
import contextlib, sys
from planner import cli
for collision in ("fcl", "coal"):
    sys.argv = ["planner", "plan", "--nodes", "20", "--no-page", "--collision", collision, "--out", collision]
    with contextlib.suppress(SystemExit):
        cli.main()
"""

_TREES = """
import numpy as np
from planner.roadmap.ompl_planners import JointSpace
from planner.roadmap.ompl_planners import TreePlanners
for wrap in (False, True):
    space = JointSpace(np.full(3, -2.0), np.full(3, 2.0), np.array([wrap, False, False]))
    with TreePlanners(space, lambda a, d: bool((np.abs(a + d)[:2] > 0.3).any()), np.random.default_rng(3)) as planners:
        path = planners.rrt_connect(np.array([[-1.0, -1, 0], [-1, 0, 0]]), np.array([[1.0, 1, 0]]), 0.5, 500)
        gc.collect()
        assert len(planners.rrt(path, 0.5, 60, 500).nodes) > 60
        gc.collect()
    gc.collect()
"""

_PRM = """
import weakref
import numpy as np
from benchmarks.others.ompl import OmplPrm
from planner.robot.robot import Robot
prm = OmplPrm(Robot.load("planar_2r"), lambda q: bool(np.abs(q[0]) > 0.3), seed=1)
prm.build(30)
assert len(prm.graph()[0]) >= 30
assert len(prm.query(np.array([-1.0, 0.5]), np.array([-2.0, -0.5]))) > 1
held = weakref.ref(prm)
del prm
gc.collect()
assert held() is None, "the benchmark's roadmaps are never freed"
"""


def _under_hooks(script: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-X", "dev", "-W", "ignore", "-c", _OFTEN + script],
        cwd=cwd,
        env={**os.environ, **_HOOKS},
        text=True,
        capture_output=True,
        timeout=300,
        check=False,
    )


def test_plans_survive_the_debug_hooks(tmp_path: Path) -> None:
    """At the default's collection thresholds it takes 1012 nodes to crash; collected often, 20 are enough."""
    done = _under_hooks(_PLANS, cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-3000:]
    assert all((tmp_path / collision / "plan.json").exists() for collision in ("fcl", "coal"))


@pytest.mark.parametrize("script", [_TREES, _PRM], ids=["trees", "prm"])
def test_every_door_to_ompl_survives_the_debug_hooks(script: str, tmp_path: Path) -> None:
    done = _under_hooks(script, cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-3000:]


def test_the_hooks_see_a_read_of_freed_memory(tmp_path: Path) -> None:
    """OMPL's bindings free a state checker that is a plain function; without it the tests above prove nothing."""
    script = """
from ompl import base as ob
space = ob.RealVectorStateSpace(1)
info = ob.SpaceInformation(space)
info.setStateValidityChecker(lambda state: True)
gc.collect()
"""
    assert _under_hooks(script, cwd=tmp_path).returncode < 0
