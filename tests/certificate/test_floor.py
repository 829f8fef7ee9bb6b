"""The floor under w in a certificate: what is shown is true, and what is false is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from benchmarks.attack.certificates.folders import AROUND, folder_of
from benchmarks.attack.certificates.judge import least_w
from benchmarks.attack.certificates.mutations import WITNESSES, Case, pack_witnesses
from planner.certificate import make_certificate, verify_proof
from planner.certificate.geometry import split_shapes
from planner.certificate.verify_proof import ROWS
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.kinematics.manipulability import manipulability
from planner.robot.files.robot_files import Rows
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.trajectory.timing import time_path
from tests.worlds import ROBOTS, joint_xml, link_xml, load, make_post, random_q

LEAST = float(manipulability(make_post().robot, AROUND[[-1]])[0])  # where AROUND ends


@pytest.fixture
def case(tmp_path: Path) -> Case:
    """A path and a motion whose floor is all but the least w there is."""
    folder, _ = folder_of(tmp_path, make_post(), AROUND, time_path(AROUND, make_post()), floor=0.999 * LEAST)
    return Case.from_folder(folder)


def test_a_floor_is_shown_along_all_of_path_and_motion(case: Case) -> None:
    said = case.accepts(case.data, case.meta)
    assert said is not None
    assert f"at least {0.999 * LEAST} is shown on every piece; plan.json asks for {0.999 * LEAST}.\n" in said
    assert least_w(case.data, case.meta, 9) >= case.data["floor"]


@pytest.mark.parametrize("floor", [LEAST * (1 + 1e-9), LEAST * 1.01, 10.0])
def test_a_floor_above_what_is_kept_is_refused(case: Case, floor: float) -> None:
    assert case.accepts({**case.data, "floor": np.array(floor)}, case.meta) is None


def test_the_part_of_a_path_that_starts_below_the_floor_is_named(tmp_path: Path) -> None:
    path = np.array([[1.6, 0.05], [1.6, 2.0]])
    post = make_post()
    case = Case.from_folder(folder_of(tmp_path, post, path, floor=0.1)[0])
    begins = (np.arcsin(0.1 / float(manipulability(post.robot, np.array([[0.0, np.pi / 2]]))[0])) - 0.05) / 1.95
    shown = case.data["low"][(case.data["pair"] == len(case.data["pairs"])) & case.data["normal"].any(axis=1)].min()
    assert begins < shown < begins + 1e-5
    assert f"on every piece but for 0.0 to {shown} of piece 0;" in str(case.accepts(case.data, case.meta))
    claimed = {**case.data, "normal": np.where(case.data["normal"] == 0, np.float32(1), case.data["normal"])}
    assert case.accepts(claimed, case.meta) is None


def test_an_interval_that_is_too_wide_for_its_witness_is_refused(case: Case) -> None:
    data = {name: array.copy() for name, array in case.data.items()}
    k = np.flatnonzero(data["pair"] == len(data["pairs"]))[-1]
    data["low"][k] = 0.0
    wide = np.flatnonzero((data["pair"] != len(data["pairs"])) | (data["piece"] != data["piece"][k]))
    for name in WITNESSES:
        data[name] = np.concatenate([data[name][wide], data[name][[k]]])
    data["high"][-1] = 1.0
    data = pack_witnesses(data)
    assert case.accepts({**data, "floor": np.array(0.5 * LEAST)}, case.meta) is not None  # less is shown by as much
    data["knots"][:, -2:] = 0.0
    assert case.accepts(data, case.meta) is None


def test_a_floor_in_plan_json_is_a_number(case: Case) -> None:
    case.plan["config"]["min_manipulability"] = "0\nProven: more"
    floored = case.data["pair"] == len(case.data["pairs"])
    normal = np.where(floored[:, None], np.float32(0), case.data["normal"])
    assert case.accepts({**case.data, "normal": normal}, case.meta) is None


@pytest.mark.parametrize("robot", ROBOTS)
def test_no_optimiser_finds_less_w_than_is_said(robot: str) -> None:
    """Around random configurations, within the joints' motion of an interval: descents to the least w."""
    arm = load(robot)
    checker = make_checker(arm, Scene.load("empty"))
    rng = np.random.default_rng(0)
    for q in random_q(arm, 3):
        way = rng.normal(size=arm.dof) * 0.02
        path = np.clip(np.array([q - way, q + way]), arm.lower, arm.upper)
        floor = 0.8 * float(manipulability(arm, path).min())
        attacked(checker, path, floor, rng)


def test_w_is_that_of_the_planner() -> None:
    """An interval of no width has the planner's w, but for rounding."""
    for robot in ("iiwa14", "ur5", "planar_2r"):
        arm = load(robot)
        checker, path = make_checker(arm, Scene.load("empty")), random_q(arm, 4)
        made = make_certificate(checker, path, floor=0.0)
        pieces, rows = verify_proof.curves(made.arrays), np.arange(3)
        data = {**made.arrays, "piece": rows, "low": np.full(3, 0.5), "high": np.full(3, 0.5)}
        reach, spare = verify_proof.reaches(data | {"shapes": split_shapes(data)}, pieces)
        least = verify_proof.least_w(data, pieces, reach[-1], spare, ROWS[made.meta["rows"]], rows)
        w = manipulability(arm, 0.5 * (path[1:] + path[:-1]))
        assert (least <= w).all()
        np.testing.assert_allclose(least, w, rtol=1e-4)


@pytest.mark.parametrize("rows", ["planar", "translation", "pose"])
def test_no_optimiser_finds_less_w_where_joints_slide_or_are_few(rows: Rows, tmp_path: Path) -> None:
    """Of an arm of four joints, one of which slides, so that six rows are more than its joints."""
    bar = '<box size="0.02 0.02 0.02"/>'
    text = link_xml("base") + "".join(link_xml(name, bar) for name in "abcd")
    text += joint_xml("one", "base", "a", axis="0 0 1") + joint_xml("two", "a", "b", axis="0 1 0", xyz="0.3 0 0.2")
    text += joint_xml("three", "b", "c", "prismatic", axis="1 0 0", xyz="0.2 0 0", limit="0 0.5")
    text += joint_xml("four", "c", "d", axis="0.6 0 0.8", xyz="0.1 0.3 0.2")
    (tmp_path / "made.urdf").write_text(f'<robot name="made">{text}</robot>')
    arm = replace(Robot.load(tmp_path / "made.urdf"), jacobian_rows=rows)
    checker, rng, widths = make_checker(arm, Scene.load("empty")), np.random.default_rng(1), []
    for q in random_q(arm, 10):
        path = np.clip(np.array([q, q + rng.normal(size=4) * 0.05]), arm.lower, arm.upper)
        floor = 0.9 * float(manipulability(arm, path).min())
        widths.append(attacked(checker, path, floor, rng))
    assert np.median(widths) > 0.01, "intervals are no dust"


def attacked(checker: CollisionChecker, path: np.ndarray, floor: float, rng: np.random.Generator) -> float:
    """Descents to the least w within what joints move in the intervals; the width of the widest interval."""
    made, arm = make_certificate(checker, path, floor=floor), checker.robot
    data, pieces = dict(made.arrays), verify_proof.curves(made.arrays)
    data["left"] = np.minimum(data["left"], verify_proof.EXEMPT)  # bodies may touch here
    data["shapes"] = split_shapes(data)
    verify_proof.assign_witnesses(data, made.meta, pieces)
    reach, spare = verify_proof.reaches(data, pieces)
    floored = np.flatnonzero((data["pair"] == len(data["pairs"])) & data["normal"].any(axis=1))
    assert len(floored)
    rows = floored[np.argsort(data["low"][floored] - data["high"][floored])][:2]
    least = verify_proof.least_w(data, pieces, reach[-1], spare, ROWS[made.meta["rows"]], rows)
    middle, moved = verify_proof.middles(data, pieces, rows)
    for bound, centre, spread in zip(least, middle, moved, strict=True):
        box = list(zip(centre - spread, centre + spread, strict=True))
        for _ in range(2):
            start = centre + spread * rng.uniform(-1, 1, size=arm.dof)
            found = minimize(lambda x: manipulability(arm, x[None])[0], start, bounds=box)
            assert bound <= found.fun * (1 + 1e-9)
        assert bound <= float(manipulability(arm, centre[None])[0])
    return float((data["high"] - data["low"])[rows].max())
