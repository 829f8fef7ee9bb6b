"""``trajectory.json``: it comes back as it was, damaged ones are refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.base.errors import PlannerError
from planner.trajectory.file import TRAJECTORY_NAME
from planner.trajectory.recorded import read_motion
from planner.trajectory.trajectory import Trajectory
from tests.trajectory.test_export import ARM, MADE, A


def test_our_own_file_comes_back_as_it_was(tmp_path: Path) -> None:
    MADE.save(tmp_path / TRAJECTORY_NAME, "planar_2r", "empty")
    found = Trajectory.load(tmp_path)
    np.testing.assert_array_equal(found.times, MADE.times)
    np.testing.assert_allclose(found.coefficients, MADE.coefficients, atol=1e-14)
    assert (found.time_law, found.proven, found.proof) == (MADE.time_law, MADE.proven, MADE.proof)
    assert found.limits is not None
    assert MADE.limits is not None
    assert found.limits.to_dict() == MADE.limits.to_dict()
    record = json.loads((tmp_path / TRAJECTORY_NAME).read_text())
    assert record["duration"] == record["points"][-1]["t"] == MADE.duration
    points = read_motion(tmp_path, ARM)
    assert isinstance(points, Trajectory)
    assert points.limits is not None


FILE: dict[str, Any] = {
    "law": "x",
    "interpolation": "cubics",
    "joints": [A],
    "points": [{"t": 0, "q": [1], "qd": [0], "qdd": [0]}] * 2,
}


BAD = [
    ("[1, 2]", "must be a mapping of keys to values, got list"),
    ("{", "must be JSON"),
    ('{"points": [], "points": []}', "key 'points' is repeated"),
    (json.dumps({**FILE, "points": [{"t": 0, "q": [1]}] * 2}), "cubics must have 2"),
    (json.dumps({**FILE, "joints": [A, A]}), "joints must differ"),
    (json.dumps({**FILE, "proof": {"floor": {"asked": "x"}}}), "'proof.floor.asked' is wrong"),
    (json.dumps({**FILE, "joints": ["\ud800"]}), "must be text and finite"),
    (json.dumps(FILE), "times must increase"),
    (json.dumps({**FILE, "unit": "deg"}), "unknown key"),
    *(
        (json.dumps({**FILE, "points": [FILE["points"][0], {**FILE["points"][0], **odd}]}), "got others at point 2")
        for odd in ({"t": 1, "qd": [1e200]}, {"t": 1, "q": [-1e308]}, {"t": 1e300})
    ),
]


@pytest.mark.parametrize(("text", "sentence"), BAD)
def test_damaged_files_are_refused(text: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / TRAJECTORY_NAME).write_text(text)
    with pytest.raises(PlannerError, match=sentence) as caught:
        Trajectory.load(tmp_path)
    assert caught.value.exit_code == 3
