"""roboplan's answer becomes columns, with a stand-in for its environment."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.motion import runner
from benchmarks.motion.other_law import roboplan_law
from planner.base.errors import PlannerError
from planner.collision import make_checker
from planner.models.poses import pose
from planner.models.shapes import Box
from planner.trajectory.limits import MotionLimits
from tests.worlds import load, scene_of

ARM = load("planar_2r")
JUDGE = make_checker(ARM, scene_of((Box((0.1, 0.1, 0.1)), pose([5.0, 0.0, 0.0]))))
LIMITS = MotionLimits.of(ARM)
PATH = np.array([[0.0, 0.5], [0.4, 0.5]])


def answering(found: dict, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = folder / "runner.py"
    script.write_text(f"import sys, pathlib\npathlib.Path(sys.argv[2]).write_text({json.dumps(found)!r})\n")
    monkeypatch.setattr(runner, "__file__", str(script))


def test_its_samples_are_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = {"q": PATH.tolist(), "qd": [[0, 0], [0, 0]], "qdd": [[10.0, 0], [-10.0, 0]]}
    answering({"times": [0.0, 0.5], **rows}, tmp_path, monkeypatch)
    found = roboplan_law(sys.executable, PATH, JUDGE, LIMITS, 0.01)
    assert found == {"roboplan_s": 0.5, "roboplan_share": 2.0, "roboplan_contact": ""}


def test_what_it_refuses_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answering({"message": "no"}, tmp_path, monkeypatch)
    assert roboplan_law(sys.executable, PATH, JUDGE, LIMITS, 0.01) == {"roboplan_contact": "not timed: no"}
    with pytest.raises(PlannerError, match="did not answer"):
        roboplan_law(str(tmp_path / "no-python"), PATH, JUDGE, LIMITS, 0.01)
