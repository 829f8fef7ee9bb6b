"""False certificates that were once accepted, each written by someone who had read the checker."""

import json
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.attack.certificates.folders import AROUND, folder_of
from benchmarks.attack.certificates.mutations import Case
from planner.certificate import verify, verify_proof
from planner.certificate.verify_proof import Refused
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import tool_positions
from planner.robot.clouds import Points
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.shapes import Box, Cylinder
from planner.trajectory.timing import time_path
from tests.worlds import joint_xml, link_xml, load, make_post, scene_of

STRETCHED = np.array([[0.0, 0.0]])


def case_of(folder: Path, checker: CollisionChecker, path: np.ndarray = AROUND, timed: bool = False) -> Case:
    """A certificate that is true, to be changed."""
    made, certificate = folder_of(folder / "out", checker, path, time_path(path, checker) if timed else None)
    assert certificate.is_complete
    verify_proof.check(made)
    return Case.from_folder(made)


def test_a_disc_so_thin_that_its_length_squared_is_no_number(tmp_path: Path) -> None:
    """Where the squares of a length round to less, the axis is no unit vector and the disc smaller than it is."""
    tip = float(tool_positions(load("planar_2r"), STRETCHED)[0, 0])
    case = case_of(
        tmp_path, make_checker(load("planar_2r"), scene_of((Cylinder(0.1, 0.1), pose([1.5, 0, 0])))), STRETCHED
    )
    data = {name: array.copy() for name, array in case.data.items()}
    thin = 1.5873e-162  # its square is 0.51 of the smallest number there is
    data["points"][-2:] = [[tip + 0.9, 0.0, 0.0], [tip + 0.9, thin, 0.0]]
    data["radius"][-1] = 1.0  # from 0.1 m before the tip on
    for length, accepted in ((1e-3, True), (thin, False)):
        away = 0.3 if accepted else 0.0
        data["points"][-2:] = [[tip + 0.9 + away, 0.0, 0.0], [tip + 0.9 + away, length, 0.0]]
        data["normal"][data["pair"] < len(data["pairs"])] = [1.0, 0.0, 0.0]
        assert bool(case.accepts(data, case.meta)) == accepted


def test_the_radius_of_a_cloud_is_the_sum_of_its_terms(tmp_path: Path) -> None:
    """Samples on both sides of the arm, in groups, each with the whole radius."""
    at = np.linspace(0.7, 0.9, 5)
    xyz = np.concatenate([np.column_stack([at, 0 * at + y, 0 * at]) for y in (-0.3, 0.3)])
    checker = make_checker(load("planar_2r"), scene_of((Points(xyz, 0.02, noise=0.003, calibration=0.001), pose())))
    case = case_of(tmp_path, checker, np.array([[0.0, 0.0], [0.05, 0.0]]))
    assert case.meta["cuts"] == {"thing0": 8}
    terms = case.meta["clouds"]["thing0"]
    assert terms == {"covering": 0.02, "noise": 0.003, "calibration": 0.001, "estimated": False}
    said = case.accepts(case.data, {**case.meta, "clouds": {"thing0": {**terms, "estimated": True}}})
    assert said is not None
    assert "the radius of 'thing0' as a sum of {'calibration': 0.001, 'covering': 0.02" in said
    false = [{"covering": 0.05}, {"noise": 0.0}, {"covering": 0.024, "noise": -0.001}, {"calibration": float("nan")}]
    for change in false:
        assert case.accepts(case.data, {**case.meta, "clouds": {"thing0": {**terms, **change}}}) is None
    assert case.accepts(case.data, {**case.meta, "clouds": {"another": terms}}) is None
    data = {**case.data, "radius": np.where(case.data["radius"] == 0.024, 0.02, case.data["radius"])}
    assert case.accepts(data, case.meta) is None


def edited(change: Callable[[Any], object]) -> Callable[[str], str]:
    """The text of a file whose record is changed."""

    def made(text: str) -> str:
        record = json.loads(text)
        change(record)
        return json.dumps(record)

    return made


ATTACH = {"t": 0.5, "kind": "attach", "object": "thing0", "link": "tool"}
FALSE_FILES: list[tuple[str, Callable[[str], str], str]] = [
    ("trajectory.json", edited(lambda motion: motion["points"][3].update(t=motion["points"][3]["t"] + 1e-12)),
     "of another motion"),
    ("trajectory.json", edited(lambda motion: motion.update(events=[ATTACH])), "of another motion"),  # is no body of it
    # of a name that stands twice Python takes the last, and other readers the first
    ("plan.json", lambda text: '{"path": [[0.0, 0.0], [3.0, 0.0]],' + text.strip()[1:], "twice"),
    ("trajectory.json", lambda text: '{"points": [],' + text.strip()[1:], "twice"),
    # Python reads the text 1_0 as 10, and C as 1
    *(("plan.json", edited(lambda plan, x=x: plan["path"][0].__setitem__(0, x)), "another") for x in ("1_0", None)),
    *(("trajectory.json", edited(lambda motion, x=x: motion["points"][0]["q"].__setitem__(0, x)), "another")
      for x in ("1_0", None)),
]  # fmt: skip


def test_files_of_which_something_else_is_certified(tmp_path: Path) -> None:
    case = case_of(tmp_path, make_post(), timed=True)
    for name, change, words in FALSE_FILES:
        kept = (case.folder / name).read_text()
        (case.folder / name).write_text(change(kept))
        with pytest.raises(Refused, match=words):
            verify_proof.check(case.folder)
        (case.folder / name).write_text(kept)
    verify_proof.check(case.folder)


def test_names_that_say_more_than_was_proven(tmp_path: Path) -> None:
    case = case_of(tmp_path, make_post())
    lie = "planar_2r\nProven: the controller too.\x1b[8m"
    case.plan["robot"] = lie
    said = case.accepts(case.data, {**case.meta, "robot": lie})
    assert said is None or ("\nProven: the controller" not in said and "\x1b" not in said)
    items = list(case.meta["items"])
    left = case.data["exempt"][0]
    items[left[0]] = "none\nProven: of obstacles that move, too"
    said = case.accepts(case.data, {**case.meta, "items": items, "robot": "planar_2r"}, follow=False)
    assert said is None or "\nProven: of obst" not in said


def test_velocities_that_the_robot_does_not_have(tmp_path: Path) -> None:
    """Whoever may say how fast a motion may be has a proof of any motion."""
    post = make_post()
    motion = time_path(AROUND, post)
    assert motion.limits is not None
    wide = replace(motion.limits, velocity=100.0 * motion.limits.velocity)
    folder, _ = folder_of(tmp_path / "out", post, AROUND, replace(motion, limits=wide))
    assert "limits on position, those of trajectory.json on velocity, acceleration" in verify_proof.check(folder)
    with pytest.raises(Refused, match="'joint_1' may not be that fast in"):
        verify_proof.check(folder, post.robot.source.path)
    with pytest.raises(Refused, match="velocity limit beyond the robot's"):
        verify(folder, post.world)


ARM = """<robot name="made"><link name="base"/>{one}{two}{first}{second}</robot>"""
BOX = '<box size="0.2 0.02 0.02"/>'


def arm_of(folder: Path, two: str = BOX) -> tuple[Case, str]:
    """A certificate of a robot with a finger, and its URDF."""
    text = ARM.format(
        one=link_xml("one", '<box size="0.1 0.02 0.02"/>'),
        two=link_xml("two", two),
        first=joint_xml("first", "base", "one"),
        second=joint_xml("second", "one", "two", "prismatic", xyz="0.3 0 0"),
    )
    (folder / "made.urdf").write_text(text)
    robot = Robot.load(folder / "made.urdf", tool="two", fixed_joints={"second": 0.0})
    checker = make_checker(robot, scene_of((Box((0.1, 0.1, 0.1)), pose([0, 0, 0.5]))))
    case = case_of(folder, checker, np.array([[0.0], [0.5]]))
    assert verify_proof.check(case.folder, folder / "made.urdf")
    return case, text


def test_a_joint_that_mimics_a_planned_one_is_not_held(tmp_path: Path) -> None:
    """Directly or by way of another one."""
    case, text = arm_of(tmp_path)
    by = joint_xml("third", "two", "three").replace("</joint>", '<mimic joint="first"/></joint>') + link_xml("three")
    leads = {"first": text, "third": text.replace("</robot>", f"{by}</robot>")}
    for leader, robot in leads.items():
        at = robot.index('<joint name="second"')
        mimic = robot[:at] + robot[at:].replace("</joint>", f'<mimic joint="{leader}"/></joint>', 1)
        (tmp_path / "made.urdf").write_text(mimic)
        with pytest.raises(Refused, match="moves"):
            verify_proof.check(case.folder, tmp_path / "made.urdf")


MORE = '<link name="two"><collision><geometry><sphere radius="0.1"/></geometry></collision>'


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('name="first" type="revolute"', 'name="first" type="fixed"', "joint 'first' does not move"),
        ('name="first" type="revolute"', 'name="first" type="floating"', "joint 'first' does not move"),
        ('<link name="two">', MORE, r"'two_1' hangs on another joint in .*, or is no body"),
    ],
)
def test_a_urdf_of_which_something_else_is_certified(old: str, new: str, words: str, tmp_path: Path) -> None:
    case, text = arm_of(tmp_path)
    assert old in text
    assert case.accepts(case.data, {**case.meta, "widened": True})
    (tmp_path / "made.urdf").write_text(text.replace(old, new, 1))
    with pytest.raises(Refused, match=words):
        verify_proof.check(case.folder, tmp_path / "made.urdf")


def test_everything_that_is_only_said_is_in_the_verdict(tmp_path: Path) -> None:
    """Pairs left out, joints held, slabs, obstacles and states, each by its name; another word is refused."""
    case, _ = arm_of(tmp_path)
    words = {**case.meta, "held": {"second": 0.125}, "cuts": {"one_0": 3}, "states": {"rest": ["q:0"]}}
    said = case.accepts(case.data, {**words, "widened": True})
    assert said is not None
    for name in ("joint 'second' held at 0.125", "mesh 'one_0' cut into 3 slabs", "'rest'", "limits on position that"):
        assert name in said
    names, left = case.meta["items"], case.data["left"] == verify_proof.EXEMPT
    assert all(f"obstacle {names[k]!r}" in said for k in np.flatnonzero(case.data["joint"] < 0))
    assert f"Said to be left out, by files that are not read here: {left.sum()} pairs" in said
    assert all(f"{names[a]!r} and {names[b]!r}" in said for a, b in case.data["exempt"])
    assert case.accepts(case.data, {**case.meta, "omitted": ["everything else"]}) is None


def test_what_is_no_mesh_is_not_cut(tmp_path: Path) -> None:
    case, _ = arm_of(tmp_path)
    items = [name.replace("two_0", "two_0, slab 1") for name in case.meta["items"]]
    points, at = case.data["points"].copy(), items.index("two_0, slab 1")
    begin = int(case.data["count"][:at].sum())
    points[begin : begin + case.data["count"][at]] *= 0.01
    data = {**case.data, "points": points}
    words = {**case.meta, "items": items, "cuts": {"two_0": 1}}
    assert case.accepts(data, words)
    with pytest.raises(Refused):
        verify_proof.check(case.folder, tmp_path / "made.urdf")


def test_a_mesh_is_no_text_that_stands_in_its_header(tmp_path: Path) -> None:
    """Its triangles count 50 bytes each, and with one byte more it once was what its first 80 bytes say."""
    header = b"vertex 0 0 0 vertex .01 0 0 vertex 0 .01 0".ljust(80)
    (tmp_path / "made.stl").write_bytes(header + (1).to_bytes(4, "little") + bytes(50) + b"\n")
    assert verify_proof.shape_in(ET.fromstring('<mesh filename="file://made.stl"/>'), tmp_path / "made.urdf") is None


def test_a_joint_that_stands_before_what_carries_it_in_the_urdf(tmp_path: Path) -> None:
    """Else its frame is made of one that was not computed yet."""
    folder, _ = folder_of(tmp_path / "out", make_post(), AROUND)
    case, urdf = Case.from_folder(folder), load("planar_2r").source.path
    assert verify_proof.check(folder, urdf)
    words = {**case.meta, "joints": case.meta["joints"][::-1], "tree": case.meta["tree"][::-1]}
    case.plan["joints"] = words["joints"]
    case.accepts({**case.data, "joint": np.array([-1, 0, 2, 1])[case.data["joint"] + 1]}, words)
    with pytest.raises(Refused, match="stands before what carries it"):
        verify_proof.check(folder, urdf)


@pytest.mark.parametrize("widened", [2, "x"])
def test_limits_that_are_not_compared_are_told(widened: object, tmp_path: Path) -> None:
    case, _ = arm_of(tmp_path)
    assert case.accepts(case.data, {**case.meta, "widened": widened})
    assert "limits on position that are not those of" in verify_proof.check(case.folder, tmp_path / "made.urdf")


@pytest.mark.parametrize("value", [3000.0, float("nan")])
def test_a_held_joint_does_not_shrink_what_it_carries(value: float, tmp_path: Path) -> None:
    """The series of an angle that is too large for it is no rotation."""
    case, text = arm_of(tmp_path)
    (tmp_path / "made.urdf").write_text(text.replace('name="second" type="prismatic"', 'name="second" type="revolute"'))
    assert verify_proof.check(case.folder, tmp_path / "made.urdf")
    case.accepts(case.data, {**case.meta, "held": {"second": value}})
    with pytest.raises(Refused, match="a joint turns too far"):
        verify_proof.check(case.folder, tmp_path / "made.urdf")


def test_a_base_that_shrinks_what_it_carries(tmp_path: Path) -> None:
    case, _ = arm_of(tmp_path)
    base = case.data["base"].copy()
    for shrunk in (0.5, 1.0 - 1e-6):
        base[:3, :3] = shrunk * np.eye(3)
        case.accepts({**case.data, "base": base}, case.meta)
        with pytest.raises(Refused, match="too large for their rounding"):
            verify_proof.check(case.folder, tmp_path / "made.urdf")


def test_parts_that_do_not_cover_a_piece(tmp_path: Path) -> None:
    """Too few, none, more than there are, of another pair, without a length, or ending before the piece does."""
    case = case_of(tmp_path, make_post(), timed=True)
    parts, high = case.data["parts"], case.data["high"]

    def refused(**changed: np.ndarray) -> bool:
        return case.accepts({**case.data, **changed}, case.meta) is None

    assert not refused()
    at = np.argwhere(parts > 1)[0]
    for row, by in (((at[0], at[1]), -1), ((at[0], at[1]), 1), ((0, 0), -parts[0, 0]), ((0, 0), 2**30)):
        wrong = parts.copy()
        wrong[row] += by
        assert refused(parts=wrong)
        wrong[-1, -1] -= by  # as many as there are
        assert refused(parts=wrong)
    for wrong in (parts[:-1], parts[:, :-1], parts.T, np.concatenate([parts, parts[:1]])):
        assert refused(parts=np.ascontiguousarray(wrong))
    first = int(parts.ravel()[: parts.shape[1] * at[0] + at[1]].sum())
    for end in (0.0, -0.0, high[first + 1], np.nextafter(1.0, 2.0)):
        wrong = high.copy()
        wrong[first] = end
        assert refused(high=wrong)
    wrong = high.copy()
    wrong[-1] = np.nextafter(1.0, 0.0)
    assert refused(high=wrong)
