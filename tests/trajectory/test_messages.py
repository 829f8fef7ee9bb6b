"""Messages and files of plain data: each field is honoured, noted or refused by its name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from planner.base.errors import FileError
from planner.trajectory.points import Points, read_motion
from tests.trajectory.test_export import ARM, A, B


def message(**changed: Any) -> dict[str, Any]:
    """A JointTrajectory of two points, with keys changed; those of points where they are keys of points."""
    point = {"positions": [0.1, 0.2], "velocities": [0.0, 0.0], "accelerations": [0.0, 0.0], "effort": []}
    of_points = {key: changed.pop(key) for key in [*point, "time_from_start", "jerks", "velocity"] if key in changed}
    points = [{**point, "time_from_start": {"sec": k, "nanosec": 0}} for k in range(2)]
    points[1] = {key: value for key, value in (points[1] | of_points).items() if value is not ...}
    made = {"header": {}, "joint_names": [A, B], "points": points} | changed
    return {key: value for key, value in made.items() if value is not ...}


OURS = {
    "joints": [A, B],
    "points": [{"t": k, "q": [0.1, 0.2], "qd": [0, 0], "qdd": [0, 0]} for k in range(2)],
}
REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "sec with a part": (message(time_from_start={"sec": 1.5, "nanosec": 0}), "sec 1.5 is no whole number"),
    "nanosec with a part": (message(time_from_start={"sec": 1, "nanosec": 0.5}), "nanosec 0.5 is no whole number"),
    "nanosec too many": (message(time_from_start={"sec": 1, "nanosec": 10**9}), "nanosec 1000000000 is not usable"),
    "nanosec below 0": (message(time_from_start={"sec": 1, "nanosec": -1}), "nanosec -1 is not usable"),
    "sec beyond all": (message(time_from_start={"sec": 2**31}), "less than 2\\^31 s"),
    "sec a truth": (message(time_from_start={"sec": True}), "sec True is no whole number"),
    "no such clock": (message(time_from_start={"seconds": 1}), "is no time; give sec and nanosec"),
    "two clocks": (message(time_from_start={"sec": 1, "nsecs": 5}), "is no time; give sec and nanosec"),
    "no clock": (message(time_from_start={}), "is no time; give sec and nanosec"),
    "one without time": (message(time_from_start=...), "point 2 has no time_from_start, others have"),
    "one without velocities": (message(velocities=[]), "point 2 has no velocities, others have"),
    "too few velocities": (message(velocities=[0.0]), "row 2 has 1 values"),
    "no positions": (message(positions=[]), "point 2 has no positions"),
    "jerks": (message(jerks=[0, 0]), "point 2 has a key 'jerks' that is not known"),
    "misspelt": (message(velocity=[0, 0]), "did you mean 'velocities'"),
    "no names": (message(joint_names=...), "names no joints"),
    "names twice": (message(joint_names=[A, A]), f"names joint '{A}' twice"),
    "unknown beside": (message(speed_scale=0.5), "has a key 'speed_scale' that is not known"),
    "unknown around": ({"joint_trajectory": message(), "scale": 2}, "has a key 'scale' that is not known"),
    "several joints at once": (
        {"joint_trajectory": message(), "multi_dof_joint_trajectory": {"points": [{}]}},
        "several degrees of freedom",
    ),
    "two trajectories": ({"trajectory": [message(), message()]}, "holds 2 trajectories"),
    "no interpolation of ours": ({**OURS, "interpolation": "splines"}, "give one of lines, cubics, quintics"),
    "not ours": ({**OURS, "unit": "deg"}, "has a key 'unit' that is not known"),
    "not of ours": ({**OURS, "points": [{**OURS["points"][0], "w": 1}]}, "point 1 has a key 'w'"),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("ending", ["json", "yaml"])
def test_what_a_message_says_is_honoured_or_refused(name: str, ending: str, tmp_path: Path) -> None:
    data, words = REFUSED[name]
    (tmp_path / f"a.{ending}").write_text(json.dumps(data))
    with pytest.raises(FileError, match=words) as caught:
        read_motion(tmp_path / f"a.{ending}", ARM)
    assert str(caught.value).endswith((".", "'"))


def test_times_are_read_to_the_nanosecond(tmp_path: Path) -> None:
    late = message(time_from_start={"sec": 999_999, "nanosec": 999_999_999})
    (tmp_path / "a.json").write_text(json.dumps(late))
    points = read_motion(tmp_path / "a.json", ARM)
    assert isinstance(points, Points)
    assert points.trajectory().nanoseconds.tolist() == [0, 999_999_999_999_999]
    close = message(time_from_start={"sec": 0, "nanosec": 1})
    (tmp_path / "a.json").write_text(json.dumps(close))
    points = read_motion(tmp_path / "a.json", ARM)
    assert isinstance(points, Points)
    assert points.trajectory().nanoseconds.tolist() == [0, 1]
