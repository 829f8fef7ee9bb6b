"""Motions out of files: every form gives the same motion; each field is honoured, noted or refused by its name."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import FileError, PlannerError
from planner.trajectory.export import export
from planner.trajectory.recorded import read_motion
from planner.trajectory.trajectory import Trajectory
from tests.random_shapes import QUICK
from tests.trajectory.test_export import ARM, MADE, A, B, read_back
from tests.worlds import load, random_q

ROWS = [[0.1, -0.2], [0.3, 0.4], [0.5, 1.0]]
SWAPPED = [row[::-1] for row in ROWS]
POINTS = [{"positions": row, "time_from_start": {"secs": k}} for k, row in enumerate(SWAPPED)]
MESSAGE = {"joint_names": [B, A], "points": POINTS}
FORMS = {
    "plan.json": {"robot": "planar_2r", "outcome": "solved", "joints": [A, B], "path": ROWS, "cost": {}},
    "rows.json": ROWS,
    "rows.yaml": ROWS,
    "waypoints.json": {"joints": [B, A], "waypoints": SWAPPED},
    "positions.json": {"joint_names": [A, "gripper", B], "positions": [[a, 0.02, b] for a, b in ROWS]},
    "no names.json": {"path": ROWS},
    "points without times.json": {"joint_names": [B, A], "points": [{"positions": row} for row in SWAPPED]},
    "message.json": MESSAGE,
    "robot trajectory.yaml": {"joint_trajectory": MESSAGE, "multi_dof_joint_trajectory": {}},
    "display trajectory.json": {"model_id": "r", "trajectory": [{"joint_trajectory": MESSAGE}]},
    "bare.csv": "0.1,-0.2\n0.3,0.4\n0.5,1.0\n",
    "header.csv": f"{B},{A}\n-0.2,0.1\n0.4,0.3\n1.0,0.5\n",
    "mark of a spreadsheet.CSV": f"\ufeff{A},{B}\r\n0.1,-0.2\r\n0.3,0.4\r\n\r\n0.5,1.0\r\n",
    "quoted.csv": f'"{B}","{A}"\n-0.2,0.1\n0.4,0.3\n1.0,0.5\n',
    "times.csv": f"{B},t,{A}\n-0.2,0,0.1\n0.4,1,0.3\n1.0,2,0.5\n",
}


def motion(path: Path, content: Any) -> Any:
    path.write_text(content if isinstance(content, str) else json.dumps(content), newline="")
    return read_motion(path, ARM)


def trajectory(path: Path, content: Any) -> Trajectory:
    found = motion(path, content)
    assert isinstance(found, Trajectory)
    return found


@pytest.mark.parametrize("name", FORMS)
def test_every_form_gives_the_same_rows(name: str, tmp_path: Path) -> None:
    found = motion(tmp_path / name, FORMS[name])
    np.testing.assert_array_equal(found.columns[0] if isinstance(found, Trajectory) else found, ROWS)


@QUICK
@given(st.integers(0, 2**31), st.permutations(range(7)))
def test_columns_in_any_order(tmp_path_factory: pytest.TempPathFactory, seed: int, order: list[int]) -> None:
    robot = load("iiwa14")
    rows = random_q(robot, 4, seed)
    path = tmp_path_factory.mktemp("order") / "p.csv"
    names = ",".join(robot.joints[k] for k in order)
    path.write_text("\n".join([names, *(",".join(repr(float(row[k])) for k in order) for row in rows)]))
    np.testing.assert_array_equal(read_motion(path, robot), rows)


def test_continuous_joints_take_the_shorter_way(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    robot = load("kinova")
    rows = np.tile(robot.home, (3, 1))
    rows[:, 0] = [3.0, -3.0, -2.5]
    (tmp_path / "p.json").write_text(json.dumps(rows.tolist()))
    path = np.asarray(read_motion(tmp_path / "p.json", robot))
    np.testing.assert_allclose(path[:, 0], [3.0, 2 * np.pi - 3.0, 2 * np.pi - 2.5])
    np.testing.assert_array_equal(path[:, 1:], rows[:, 1:])
    assert "joint 'j2s6s200_joint_1' turns the shorter way, by 0.283185 rad" in caplog.text


@pytest.mark.parametrize("there", [np.pi, -np.pi, 2.0 * np.pi, 20.0, -7.0, 3.0 * np.pi])
def test_turns_that_angles_do_not_tell_are_refused(there: float, tmp_path: Path) -> None:
    """Half a turn goes either way, and a whole one is no rest."""
    robot = load("kinova")
    rows = np.tile(robot.home, (3, 1))
    rows[2, 0] = there
    (tmp_path / "p.json").write_text(json.dumps(rows.tolist()))
    with pytest.raises(FileError, match="joint 'j2s6s200_joint_1' must turn by less than half a turn"):
        read_motion(tmp_path / "p.json", robot)


def test_columns_go_by_name_and_others_are_left_out(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    data = json.loads(export(MADE, "ros-json"))
    data["joint_names"] = ["finger", B, A]
    for point in data["points"]:
        for key in ("positions", "velocities", "accelerations"):
            point[key] = [0.02, *point[key][::-1]]
    left = "positions of finger are ignored: planar_2r does not plan these joints"
    for wrapped in (data, {"trajectory": data}, {"goal": {"trajectory": data}}):
        found = read_back(json.dumps(wrapped).encode(), "ros-json", tmp_path)
        np.testing.assert_array_equal(found.coefficients, MADE.coefficients)
        assert found.notes == (left,)
    motion(tmp_path / "p.json", {"joints": [A, "finger", B], "path": [[a, 0, b] for a, b in ROWS]})
    assert left in caplog.text, "of a path it is a warning"


@pytest.mark.parametrize(("columns", "kind"), [(1, "lines"), (2, "cubics"), (3, "quintics")])
def test_what_is_given_decides_what_runs_between(columns: int, kind: str, tmp_path: Path) -> None:
    names = ["t", *(joint + ending for ending in ("", "_velocity", "_acceleration")[:columns] for joint in (A, B))]
    rows = [[0.0] * len(names), [1.0, 0.5, 0.1, 0.0, 0.0, 0.0, 0.0][: len(names)]]
    found = trajectory(tmp_path / "a.csv", "\n".join(",".join(map(str, row)) for row in [names, *rows]))
    assert found.interpolation == kind
    points = [dict(zip(("q", "qd", "qdd")[:columns], [[0, 0]] * columns, strict=True), t=k) for k in range(2)]
    assert trajectory(tmp_path / "a.json", {"joints": [A, B], "points": points}).interpolation == kind


def message(**changed: Any) -> dict[str, Any]:
    """A JointTrajectory of two points, with keys changed; those of points where they are keys of points."""
    point = {"positions": [0.1, 0.2], "velocities": [0.0, 0.0], "accelerations": [0.0, 0.0], "effort": []}
    of_points = {key: changed.pop(key) for key in [*point, "time_from_start", "velocity"] if key in changed}
    points = [{**point, "time_from_start": {"sec": k, "nanosec": 0}} for k in range(2)]
    points[1] = {key: value for key, value in (points[1] | of_points).items() if value is not ...}
    made = {"header": {}, "joint_names": [A, B], "points": points} | changed
    return {key: value for key, value in made.items() if value is not ...}


def bare(*names: str) -> dict[str, Any]:
    """A message of which no point has these."""
    return message() | {"points": [{**point, **{name: [] for name in names}} for point in message()["points"]]}


OURS = {"joints": [A, B], "points": [{"t": k, "q": [0.1, 0.2], "qd": [0, 0], "qdd": [0, 0]} for k in range(2)]}
CLOCK = "give whole sec"
SEVERAL = {"joint_trajectory": message(), "multi_dof_joint_trajectory": {"points": [{}]}}
REFUSED: list[tuple[Any, str]] = [
    (message(time_from_start={"sec": 1.5, "nanosec": 0}), CLOCK),
    (message(time_from_start={"sec": 1, "nanosec": 10**9}), CLOCK),
    (message(time_from_start={"sec": 2**31}), CLOCK),
    (message(time_from_start={"sec": 0}), "times must increase"),
    (message(time_from_start=...), "time_from_start of point 2 not found"),
    (message(velocities=[0.0]), "point 2 must have 2 velocities, got 1"),
    (message(velocity=[0, 0]), "did you mean 'velocities'"),
    (message(joint_names=...), "joint_names not found"),
    (bare("velocities"), "accelerations must come with velocities"),
    (SEVERAL, "one degree of freedom"),
    ({"trajectory": [message(), message()]}, "must hold one trajectory, got 2"),
    ({**OURS, "unit": "deg"}, "unknown key 'unit'"),
    ({**OURS, "interpolation": "cubics", "points": [{"t": k, "q": [0, 0]} for k in range(2)]}, "cubics must have 2 of"),
    ([], "rows not found"),
    ([[1, 2], [3]], "row 2 must have 2 values, got 1"),
    ([[1, 1e300]], f"joint '{B}' must be within 1000, got 1e+300 in row 1"),
    ([[1, 2, 3]], "must have 2 columns, got 3 without names"),
    ({"joints": ["elbow", "wrist"], "path": [[1, 2]]}, f"must name joint '{A}' once, got elbow, wrist"),
    ({"joints": [A, A, B], "path": [[1, 2, 3]]}, f"must name joint '{A}' once"),
    ({"robot": "ur5", "path": [[1, 2]]}, "must be for robot 'planar_2r', got 'ur5'"),
    ({"outcome": "no_path", "path": []}, "path not found"),
    ({"path": [[1, 2]], "waypoints": [[1, 2]]}, "must hold one path, got path, waypoints"),
    ({"intervals": [{"path": [[1, 2]]}]}, "must hold one path, got a sweep"),
]
REFUSED_TEXT = {
    "json": [
        ("[" * 100_000, "must be JSON"),
        ('{"path": [[1, 2]], "path": [[3, 4]]}', "key 'path' is repeated"),
    ],
    "csv": [
        (f"# {B} {A}\n1,2\n", "column must be one of"),
        ("1,2\n3,four\n", "row 2 must hold numbers"),
        (f"{A},{B}\n1,nan\n", f"joint '{B}' must be within 1000, got nan"),
        (f"{A},{A}\n1,2\n", "columns must differ"),
        (f"{A},{B},{A}_deg\n1,2,3\n", f"got '{A}_deg' (did you mean '{A}'"),
        (f"t,{A},{B},{A}_velocity\n0,0,0,0\n1,0,0,0\n", f"must name joint '{B}' once"),
    ],
}


@pytest.mark.parametrize(
    ("ending", "content", "words"),
    [
        *((ending, data, words) for data, words in REFUSED for ending in ("json", "yaml")),
        *((ending, text, words) for ending, rows in REFUSED_TEXT.items() for text, words in rows),
    ],
)
def test_what_cannot_be_read_is_a_sentence(ending: str, content: Any, words: str, tmp_path: Path) -> None:
    with pytest.raises(FileError) as error:
        motion(tmp_path / f"p.{ending}", content)
    assert words in str(error.value)
    assert str(error.value).endswith((".", "'"))


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 2**40) | st.floats() | st.sampled_from(["", A, "t", "deg", "soon"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["sec", "q", "path", A]), inner),
    max_leaves=4,
)
DOCUMENTS = [*(content for content in FORMS.values() if not isinstance(content, str)), message(), OURS]


def replace_at_random(content: Any, draw: st.DataObject) -> Any:
    """The document with one value, at any depth, gone or replaced by any other."""
    copy = json.loads(json.dumps(content))
    at, node = None, copy
    while isinstance(node, (dict, list)) and node and (at is None or draw.draw(st.integers(0, 3))):
        keys = list(node) if isinstance(node, dict) else list(range(len(node)))
        at, key = node, draw.draw(st.sampled_from(keys))
        node = node[key]
    assert at is not None
    if draw.draw(st.booleans()):
        at[key] = draw.draw(JSON)
    else:
        del at[key]
    return copy


@QUICK
@given(st.sampled_from(DOCUMENTS), st.data())
def test_any_document_is_a_motion_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, content: Any, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("any") / "p.json"
    try:
        found = motion(path, replace_at_random(content, data))
    except FileError as error:
        text, found = str(error), None
    if found is None:
        assert "\n" not in text
        return
    rows = found.columns[0] if isinstance(found, Trajectory) else found
    assert rows.shape[1] == 2
    assert np.isfinite(rows).all()


def test_files_that_are_not_there_or_no_text(tmp_path: Path) -> None:
    for name in ("none.json", "none.xyz"):
        with pytest.raises(FileError, match="not found"):
            read_motion(tmp_path / name, ARM)
    (tmp_path / "p.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match="must be UTF-8 text"):
        read_motion(tmp_path / "p.csv", ARM)


def test_what_is_left_aside_is_noted(tmp_path: Path) -> None:
    inner = message(effort=[1.0, 1.0], header={"stamp": {"sec": 5, "nanosec": 0}})
    tolerances = {"goal_time_tolerance": {"sec": 1, "nanosec": 0}, "path_tolerance": []}
    wrapped = {"goal": {"trajectory": inner, **tolerances}}
    text = json.dumps(wrapped) + "\n---\n" + json.dumps(message()) + "\n---\n"
    noted = "; ".join(trajectory(tmp_path / "a.yaml", text).notes)
    for words in ("first of 2 documents", "goal_time_tolerance of the message", "the header's stamp", "effort is not"):
        assert words in noted
    assert trajectory(tmp_path / "a.json", message()).notes == ()
    event = {"t": 0, "kind": "attach", "object": "mug", "link": "hand"}
    assert "events of a task" in trajectory(tmp_path / "a.json", OURS | {"events": [event]}).notes[0]


@given(st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1))
@QUICK
def test_times_are_read_to_the_nanosecond(tmp_path_factory: pytest.TempPathFactory, sec: int, part: int) -> None:
    """Up to 11 days, as our own file is."""
    sec, part = sec % 10**6, max(part, 1)
    late = message(time_from_start={"sec": sec, "nanosec": part})
    found = trajectory(tmp_path_factory.mktemp("times") / "a.json", late)
    assert found.nanoseconds.tolist() == [0, sec * 10**9 + part]


def test_what_topic_echo_left_out_is_missed(tmp_path: Path) -> None:
    """As rosidl_runtime_py shortens: 128 points and a text in place of the others, or one text for all."""
    file, data = tmp_path / "echo.yaml", json.loads(export(MADE, "ros-json"))
    whole = trajectory(file, yaml.safe_dump(data) + "---\n" + yaml.safe_dump(data)[:2000])
    np.testing.assert_array_equal(whole.times, MADE.times)
    assert whole.notes == ("only the first of 2 documents is checked",)
    several = "<sequence type: trajectory_msgs/msg/JointTrajectoryPoint, length: 200>"
    for left in ([*data["points"][:128], "..."], several):
        with pytest.raises(PlannerError, match=r"points must be complete, .* --full-length\.$"):
            motion(file, yaml.safe_dump(data | {"points": left}) + "---\n")


def test_a_file_that_is_cut_within_a_line_says_so(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """At every byte of one it is refused, or read with a note (of a path a warning) that its last point is in doubt."""
    data, file = json.loads(export(MADE, "ros-json")), tmp_path / "cut.yaml"
    points = [point for point in data["points"] if point["time_from_start"]["sec"] > 0][:3]
    text = yaml.safe_dump(data | {"points": points}, sort_keys=False)
    for end in range(text.index("points"), len(text), 3):
        try:
            found = motion(file, text[:end])
        except PlannerError:
            continue
        notes = "; ".join(found.notes) if isinstance(found, Trajectory) else caplog.text
        assert "the file ends within a line" in notes or text[end - 1] == "\n"
    assert trajectory(file, text).notes == ()
