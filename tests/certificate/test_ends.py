"""A path's ends are what plan.json asks for, as far as the checker judges them."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.attack.certificates.folders import folder_of
from benchmarks.attack.certificates.mutations import Case
from planner.certificate import verify_proof
from planner.certificate.verify_proof import Refused
from planner.collision import make_checker
from planner.kinematics.forward import tool_pose
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from planner.robot.scene import Scene
from tests.worlds import load

PATH = np.array([[-1.0, 0.6, 0.1, -1.5, 0.2, 1.0, 0.3], [-0.8, 0.7, 0.1, -1.4, 0.3, 1.1, 0.4]])


@pytest.fixture
def case(tmp_path: Path) -> Case:
    """The iiwa 14 in an empty scene."""
    return Case.from_folder(folder_of(tmp_path, make_checker(load("iiwa14"), Scene.load("empty")), PATH)[0])


def said_of(case: Case, goal: str, config: dict[str, object] | None = None, **words: object) -> str | None:
    """What the checker says where ``goal`` is asked for and reached."""
    case.plan["config"] |= {"goal": goal, **(config or {})}
    case.plan["goal"] = goal
    return case.accepts(case.data, {**case.meta, **words}, follow=False)


def texts(at: tuple[float, ...] = (0, 0, 0), turned: float = 0.0) -> tuple[str, str]:
    """Position and pose of the tool at the path's end, off by ``at`` (m) and by ``turned`` (rad)."""
    there = tool_pose(load("iiwa14"), PATH[-1])
    xyz = ",".join(repr(float(x)) for x in there.translation + np.array(at))
    turn = Rotation.from_matrix(there.rotation) * Rotation.from_rotvec([0, turned, 0])
    return f"xyz:{xyz}", f"pose:{xyz}," + ",".join(repr(float(x)) for x in -turn.as_quat())


@pytest.mark.parametrize("kind", [0, 1])
def test_a_tool_that_is_there_is_told_from_one_that_is_elsewhere(case: Case, kind: int) -> None:
    goal = texts()[kind]
    assert f"Its goal is {goal!r}" in str(said_of(case, goal))
    for axis in np.eye(3) * 1e-5:
        assert said_of(case, texts(tuple(axis))[kind]) is None
    if kind == 1:
        assert said_of(case, texts(turned=1e-5)[1]) is None


def test_joint_values_are_those_asked_for(case: Case) -> None:
    for off, accepted in ((0.0, True), (1e-9, True), (1e-7, False), (2 * np.pi, False)):
        goal = "q:" + ",".join(repr(float(q)) for q in PATH[-1] + off * np.eye(7)[3])
        assert bool(said_of(case, goal)) == accepted
    assert said_of(case, "q:0.0") is None
    assert said_of(case, "xyz:1.0") is None


def test_joints_without_limits_may_be_whole_turns_off(tmp_path: Path) -> None:
    robot = load("kinova")
    path = np.full((2, robot.dof), 1.5)
    case = Case.from_folder(folder_of(tmp_path, make_checker(robot, Scene.load("empty")), path)[0])
    turning = int(np.flatnonzero(robot.continuous)[0])
    for joint, accepted in ((turning, True), (int(np.flatnonzero(~robot.continuous)[0]), False)):
        goal = "q:" + ",".join(map(repr, (path[0] + 2 * np.pi * np.eye(robot.dof)[joint]).tolist()))
        assert bool(said_of(case, goal)) == accepted


def test_names_are_what_the_certificate_says(case: Case) -> None:
    joints = "q:" + ",".join(map(repr, PATH[-1].tolist()))
    assert "Its goal is 'there', 'q:" in str(said_of(case, "there", states={"there": ["xyz:9,9,9", joints]}))
    assert said_of(case, "there", states={"there": ["xyz:9,9,9"]}) is None
    assert "Whether its goal is 'there' is not judged" in str(said_of(case, "there", states={}))
    wrong = "q:" + ",".join(map(repr, PATH[0].tolist()))
    assert said_of(case, wrong, states={wrong: [joints]}) is None, "a text with numbers is no name"


def test_a_goal_that_nobody_asked_for_is_refused(case: Case) -> None:
    assert said_of(case, texts()[0]) is not None
    case.plan["goal"] = texts()[1]
    assert case.accepts(case.data, case.meta, follow=False) is None


@pytest.mark.parametrize("goal", ["xyz:-0.52,-0.04,1.13", "home;xyz:-0.52,-0.04,1.13"])
def test_the_ends_of_plans_are_judged(goal: str, tmp_path: Path) -> None:
    found = plan(
        request=PlanRequest.from_options(robot="iiwa14", scene="paper", goal=goal, path_only=True, refinement_rounds=0),
        timing=None,
    )
    found.save_without_page(tmp_path, certificate=True)
    said = verify_proof.check(tmp_path)
    assert "Its start is 'start', 'xyz:" in said
    assert f"Its goal is {found.goal!r}" in said
    case = Case.from_folder(tmp_path)
    with pytest.raises(Refused, match="start is not"):
        verify_proof.require_ends(
            {**case.data, "path": case.data["path"] + 1e-5},
            case.meta,
            case.plan,
        )
