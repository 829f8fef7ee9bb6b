"""Joint paths out of files: every form gives the same path, and what cannot be read is said in a sentence."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import FileError
from planner.trajectory.points import Points, read_motion
from tests.random_shapes import QUICK
from tests.worlds import load, random_q

ROBOT = load("planar_2r")
A, B = ROBOT.joints
ROWS = [[0.1, -0.2], [0.3, 0.4], [0.5, 1.0]]
SWAPPED = [row[::-1] for row in ROWS]
POINTS = [{"positions": row, "time_from_start": {"secs": k}} for k, row in enumerate(SWAPPED)]
MESSAGE = {"joint_names": [B, A], "points": POINTS}

JSON_FORMS = {
    "plan": {"robot": "planar_2r", "outcome": "solved", "joints": [A, B], "path": ROWS, "cost": {}},
    "rows": ROWS,
    "waypoints": {"joints": [B, A], "waypoints": SWAPPED},
    "positions": {"joint_names": [A, "gripper", B], "positions": [[a, 0.02, b] for a, b in ROWS]},
    "no names": {"path": ROWS},
    "trajectory message": MESSAGE,
    "robot trajectory": {"joint_trajectory": MESSAGE, "multi_dof_joint_trajectory": {}},
    "display trajectory": {"model_id": "r", "trajectory": [{"joint_trajectory": MESSAGE}]},
}
CSV_FORMS = {
    "bare": "0.1,-0.2\n0.3,0.4\n0.5,1.0\n",
    "header": f"{B},{A}\n-0.2,0.1\n0.4,0.3\n1.0,0.5\n",
    "mark of a spreadsheet": f"\ufeff{A},{B}\r\n0.1,-0.2\r\n0.3,0.4\r\n\r\n0.5,1.0\r\n",
    "quoted": f'"{B}","{A}"\n-0.2,0.1\n0.4,0.3\n1.0,0.5\n',
}


@pytest.mark.parametrize("form", [*JSON_FORMS, *CSV_FORMS])
def test_every_form_gives_the_same_path(form: str, tmp_path: Path) -> None:
    path = tmp_path / ("p.json" if form in JSON_FORMS else "p.CSV")
    path.write_text(json.dumps(JSON_FORMS[form]) if form in JSON_FORMS else CSV_FORMS[form], newline="")
    found = read_motion(path, ROBOT)
    np.testing.assert_allclose(found.columns[0] if isinstance(found, Points) else found, ROWS, atol=1e-15)


def test_what_is_left_out_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "p.json").write_text(
        json.dumps({"joint_names": [A, "gripper", B], "path": [[a, 0, b] for a, b in ROWS]})
    )
    read_motion(tmp_path / "p.json", ROBOT)
    assert "positions of gripper are left out: these are no planned joints of planar_2r" in caplog.text


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
    assert robot.continuous[0]
    rows = np.tile(robot.home, (3, 1))
    rows[:, 0] = [3.0, -3.0, -2.5]
    (tmp_path / "p.json").write_text(json.dumps(rows.tolist()))
    path = np.asarray(read_motion(tmp_path / "p.json", robot))
    np.testing.assert_allclose(path[:, 0], [3.0, 2 * np.pi - 3.0, 2 * np.pi - 2.5])
    np.testing.assert_allclose(path[:, 1:], rows[:, 1:], atol=1e-15)
    assert "row 1 to row 2 joint 'j2s6s200_joint_1' is taken to turn the shorter way, by 0.283185 rad" in caplog.text


@pytest.mark.parametrize("there", [np.pi, -np.pi, 2.0 * np.pi, 20.0, -7.0, 3.0 * np.pi])
def test_turns_that_angles_do_not_tell_are_refused(there: float, tmp_path: Path) -> None:
    """Half a turn goes either way, and a whole one is no rest."""
    robot = load("kinova")
    rows = np.tile(robot.home, (3, 1))
    rows[2, 0] = there
    (tmp_path / "p.json").write_text(json.dumps(rows.tolist()))
    with pytest.raises(FileError, match=r"row 2 to row 3 joint 'j2s6s200_joint_1' turns by .* give rows less than"):
        read_motion(tmp_path / "p.json", robot)


BAD = {
    "p.json": [
        ("{", "is no JSON"),
        ("[" * 100_000, "is "),
        ("3", "holds no path"),
        ("{}", "holds no path"),
        ("[]", "holds no rows"),
        ('{"path": "here"}', "holds no list of rows"),
        ("[[1, 2], [3]]", "row 2 has 1 values, the first row has 2"),
        ("[[1, 2], 3]", "row 2 has no list of values"),
        ("[[1, true]]", "row 1 holds something that is no number"),
        ("[[1, null]]", "row 1 holds something that is no number"),
        ("[[1, NaN]]", f"row 1 has no finite value for joint '{B}'"),
        ("[[1, 1e300]]", f"row 1 puts joint '{B}' at 1e+300"),
        ("[[1, 1e999]]", f"row 1 has no finite value for joint '{B}'"),
        ("[[1, 2, 3]]", "has 3 columns without names, planar_2r has 2 planned joints"),
        ('{"joints": 3, "path": [[1, 2]]}', "its joint names are no list of names"),
        ('{"joints": ["elbow", "wrist"], "path": [[1, 2]]}', f"names joint '{A}' nowhere; it names elbow, wrist"),
        (f'{{"joints": ["{A}", "{A}", "{B}"], "path": [[1, 2, 3]]}}', f"names joint '{A}' twice"),
        (f'{{"joints": ["{A}", "{B}"], "path": [[1, 2, 3]]}}', "names 2 columns and has 3"),
        ('{"robot": "ur5", "path": [[1, 2]]}', "is for robot 'ur5', not 'planar_2r'"),
        ('{"outcome": "no_path", "path": []}', "is a plan that found no path"),
        ('{"path": [[1, 2]], "units": "deg"}', "has a key 'units' that is not known"),
        ('{"path": [[1, 2]], "waypoints": [[1, 2]]}', "holds more than one path (path, waypoints)"),
        (f'{{"joints": ["{A}", "{B}"], "joint_names": ["{B}", "{A}"], "path": [[1, 2]]}}', "names its joints twice"),
        ('{"points": [{"positions": [1, 2], "velocities": [1, 2]}]}', "point 1 has velocities and no time_from_start"),
        ('{"points": [{"position": [1, 2]}]}', "did you mean 'positions'?"),
        ('{"trajectory": [{"points": []}, {"points": []}]}', "holds 2 trajectories"),
        ('{"intervals": [{"path": [[1, 2]]}]}', "is a sweep, one path an interval of beta"),
    ],
    "p.csv": [
        ("", "holds no rows"),
        (f"# {B} {A}\n1,2\n", "that is not known"),
        (f"{A},{B}\n", "holds no rows"),
        ("x,y\n1,2\n", "has a column 'x' that is not known"),
        ("1,2\n3,four\n", "row 2 holds something that is no number"),
        ("1,2\n3\n", "row 2 has 1 values, the first row has 2"),
        (f"{A},{B}\n1,\n", "row 1 holds something that is no number"),
        (f"{A},{B}\n1,2,3\n", "names 2 columns and has 3"),
        (f"time_ms,{A},{B}\n0,1,2\n", "has a column 'time_ms' that is not known"),
        (f"{A},{B},{B}_velocity\n1,2,3\n", f"has a column '{B}_velocity' and no times"),
        (f"{A},{B},{A}_deg\n1,2,3\n", f"has a column '{A}_deg' that is not known: did you mean '{A}'"),
    ],
    "p.yaml": [("- [1, 2]", "holds no trajectory")],
}


@pytest.mark.parametrize(("name", "content", "text"), [(n, c, t) for n, rows in BAD.items() for c, t in rows])
def test_what_cannot_be_read(name: str, content: str, text: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(FileError) as error:
        read_motion(tmp_path / name, ROBOT)
    assert text in str(error.value)
    assert str(error.value).endswith((".", "'"))


def test_files_that_are_not_there_or_no_text(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="not found"):
        read_motion(tmp_path / "none.json", ROBOT)
    (tmp_path / "p.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match="not UTF-8"):
        read_motion(tmp_path / "p.csv", ROBOT)


def test_a_trajectory_that_moves_a_base_too_is_refused(tmp_path: Path) -> None:
    whole = {"joint_trajectory": MESSAGE, "multi_dof_joint_trajectory": {"joint_names": ["base"], "points": [{}]}}
    (tmp_path / "a.json").write_text(json.dumps(whole))
    with pytest.raises(FileError, match="several degrees of freedom"):
        read_motion(tmp_path / "a.json", ROBOT)
