"""Files of tool paths: what they say, and one sentence for what makes no sense."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import yaml

from planner.base.errors import FileError
from planner.tool_paths.file import read_tool_path
from tests.tool_paths.judge import great_arc

POINTS: list[dict[str, Any]] = [
    {"position": [0.4, -0.1, 0.3], "axis": [0, 0, -1]},
    {"position": [0.4, 0.1, 0.3], "axis": [0, 0, -1]},
]


def with_point(**keys: Any) -> list[dict[str, Any]]:
    return [POINTS[0], {**POINTS[1], **keys}]


def test_a_yaml_file_and_a_csv_say_the_same(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(yaml.safe_dump({"points": POINTS}))
    (tmp_path / "a.csv").write_text("x,y,z,ax,ay,az\n0.4,-0.1,0.3,0,0,-1\n0.4,0.1,0.3,0,0,-1\n")
    one, two = read_tool_path(tmp_path / "a.yaml"), read_tool_path(tmp_path / "a.csv")
    np.testing.assert_array_equal(one.positions, two.positions)
    np.testing.assert_array_equal(one.turns, two.turns)
    assert one.free.all()
    np.testing.assert_allclose(one.turns[:, :, 2], [[0, 0, -1]] * 2, atol=1e-15)


def test_an_arc_is_lines_near_it_through_its_middle() -> None:
    points = [{"position": p, "axis": [0, 0, -1]} for p in ([0.4, -0.1, 0.3], [0.5, 0.0, 0.3], [0.4, 0.1, 0.3])]
    points[1]["via"] = "arc"
    found = read_tool_path({"points": points})
    radius = np.linalg.norm(found.positions - [0.4, 0, 0.3], axis=1)
    np.testing.assert_allclose(radius, 0.1, atol=1e-12)
    middles = 0.5 * (found.positions[:-1] + found.positions[1:])
    assert 0 < (0.1 - np.linalg.norm(middles - [0.4, 0, 0.3], axis=1)).max() <= 1.01e-4
    assert np.abs(found.positions - [0.5, 0, 0.3]).sum(axis=1).min() == 0.0
    assert found.positions[-1].tolist() == [0.4, 0.1, 0.3]
    assert set(found.given) == {1, 2, 3}
    assert found.lengths.sum() == pytest.approx(0.1 * np.pi, rel=1e-3)


def test_approach_and_retreat_are_legs_along_the_tools_axis() -> None:
    found = read_tool_path({"points": POINTS, "approach": 0.05, "retreat": 0.1})
    np.testing.assert_allclose(found.positions[[0, -1]], [[0.4, -0.1, 0.35], [0.4, 0.1, 0.4]])
    assert len(found.positions) == 4
    assert found.given.tolist() == [1, 1, 2, 2]


@pytest.mark.parametrize(
    ("data", "part"),
    [
        ({"points": POINTS[:1]}, "two points or more, got 1"),
        ({"points": with_point(position=[0.4, float("nan"), 0.3])}, "finite number"),
        ({"points": [POINTS[0], POINTS[0]]}, "must differ from the next one"),
        ({"points": with_point(position=[400, 100, 300])}, "not mm"),
        ({"points": [POINTS[0], {"position": [0.4, 0.1, 0.3], "quaternion": [0, 0, 0, 2]}]}, "got 2"),
        ({"points": with_point(axis=[0, 0, -2])}, "got 2"),
        ({"points": POINTS, "tube": {"position": 0}}, "tube.position"),
        ({"points": [POINTS[0], {"position": [0.4, 0.1, 0.3], "cone": {"axis": [0, 0, -1], "angle": 3.49}}]}, "cone"),
        ({"points": with_point(quaternion=[0, 0, 0, 1])}, "one of quaternion, axis and cone"),
        ({"points": with_point(frame="camera")}, "unknown key"),
        ({"points": with_point(via="arc")}, "via"),
        ({"points": POINTS, "approach": -1}, "approach"),
        (
            {"points": [POINTS[0], {**POINTS[1], "via": "arc"}, {"position": [0.4, 0.3, 0.3], "axis": [0, 0, -1]}]},
            "must be the middle of an arc, but the three points"
        ),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_one_sentence(data: dict[str, Any], part: str) -> None:
    with pytest.raises(FileError) as caught:
        read_tool_path(data)
    text = str(caught.value)
    assert part in text
    assert text.endswith(".")
    assert "\n" not in text
    assert len(text) < 300


@pytest.mark.parametrize(
    "text",
    [
        "",
        "x,y,z\n1,2,3\n",
        "x,y,z,ax,ay,az\n0,0,one,0,0,1\n",
        "x,y,z,ax,ay,az\n0,0,0,0,0,1,9\n1,0,0,0,0,1,9\n",
        "x,x,y,z,ax,ay,az\n9,0,0,0,0,0,1\n9,1,0,0,0,0,1\n",
        "x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,2\n1,0,0,0,0,0,1\n",
    ],
)
def test_a_bad_csv_is_one_sentence(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(FileError, match=r"tool path .*\.$"):
        read_tool_path(tmp_path / "a.csv")


def turned(rng: np.random.Generator, kind: str, position: Any, **more: Any) -> dict[str, Any]:
    """A point with the tool leaning by up to 0.6 rad from straight down and turned about that at random."""
    lean, spin = rng.normal(size=3) * [0.3, 0.3, 0.0], np.array([0.0, 0.0, rng.uniform(-3.1, 3.1)])
    rotation = pin.exp3(lean) @ np.diag([1.0, -1.0, -1.0]) @ pin.exp3(spin)
    z = rotation[:, 2].tolist()
    how = {"axis": z, "cone": {"axis": z, "angle": 0.1}, "quaternion": pin.Quaternion(rotation).coeffs().tolist()}
    return {"position": list(position), kind: how[kind], **more}


def test_where_the_tool_turns_freely_its_axis_goes_along_the_great_arc() -> None:
    """However it is turned about it where that is given, which binds at that point alone; against Pinocchio."""
    rng = np.random.default_rng(0)
    for kinds in itertools.product(("axis", "quaternion", "cone"), repeat=3):
        points = [turned(rng, kind, [0.4, 0.1 * k, 0.3]) for k, kind in enumerate(kinds)]
        given = read_tool_path({"points": points})
        even = given.subdivide()
        assert (even.turn_angles <= 0.05 + 1e-9).all()
        for line in np.flatnonzero(given.free[:-1] | given.free[1:]):
            for u in (0.0, 0.2, 0.7, 1.0):
                z = great_arc(given.turns[line, :, 2], given.turns[line + 1, :, 2], u)
                k = min(int(np.searchsorted(even.along, (line + u) * 0.1 + 1e-9)) - 1, len(even.lengths) - 1)
                share = ((line + u) * 0.1 - even.along[k]) / even.lengths[k]
                for path, place in ((given, (line, u)), (even, (k, share))):
                    turns = path.at(np.array([place[0]]), np.array([place[1]]))[1]
                    np.testing.assert_allclose(turns[0, :, 2], z, atol=1e-9)
        for k, kind in enumerate(kinds):
            at = int(np.abs(even.along - 0.1 * k).argmin())
            assert even.free[at] == (kind != "quaternion")
            np.testing.assert_allclose(even.turns[at], given.turns[k], atol=1e-12)
