"""Tasks that make no sense, each with one sentence; steps that cannot be done, each with its reason."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.base.errors import PlannerError
from planner.base.yamlfile import yaml_text
from planner.problem.outcome import Outcome
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.tasks.plan import task
from planner.tasks.sampling import tool_poses
from planner.tasks.task import Move, Pick, Place, Task
from tests.tasks.cases import BOARD, GRASPS, MUG, SCENE, SMALL, TABLE

SCENE_TEXT = """
obstacles:
  - {name: table, type: box, size: [0.8, 1.4, 0.04], position: [0.55, 0.0, -0.02]}
  - {name: board, type: box, size: [0.4, 0.4, 0.02], position: [0.5, 0.35, 0.21]}
  - {name: tilted, type: box, size: [0.4, 0.4, 0.02], position: [0.5, 0.35, 0.6], rpy: [0.3, 0, 0]}
  - {name: crate, type: box, size: [0.2, 0.2, 0.2], position: [0.3, -0.1, 0.1]}
  - {name: ball, type: sphere, radius: 0.03, position: [0.3, -0.5, 0.03]}
  - {name: mug, type: cylinder, radius: 0.03, length: 0.1, position: [0.5, -0.3, 0.05]}
states:
  panda: {crash: "q:0,1.7,0,-1.5,0,2,0"}
"""
KEYS = ["pick", "place", "move", "on", "at", "pose", "samples", "grasps", "approach", "retreat", "distance", "axis"]
KEYS += ["frame", "position", "rpy", "quaternion", "cone", "opening", "open", "closed", "touch"]
SPOT = "at: [[0.4, 0.3], [0.6, 0.4]]"  # as the rows name it
WRONG = {
    "steps: [{pick: mugg}]": "step 1 picks 'mugg' (did you mean 'mug'?), not found in the scene; obstacles are table",
    "steps: [{pick: mug}, {place: mug, pose: {position: [0.5, 0.3, 0.4]}}]": "got (0.5, 0.3, 0.4) m without one",
    "steps: [{pick: mug}, {place: mug, on: board, at: [[0.4, 0.3], [0.45, 0.4]]}]": "must be larger than 'mug'",
    "steps: [{place: mug, on: board, SPOT}]": "nothing is held: pick it first",
    "steps: [{pick: mug}, {pick: ball}]": "picks 'ball' while 'mug' is held: place that first",
    "steps: [{pick: mug, grasps: [{opening: 0.5}]}]": "a grasp of 'mug' must open at most 0.08 m, got 0.5",
    "steps: [{pick: mug, graps: auto}]": "unknown key 'steps.0.pick.graps' (did you mean 'grasps'?)",
    "steps: [{pick: crate}]": "'crate' must be narrower than the gripper's opening of 0.08 m",
    "steps: [{move: crash}]": "step 1, the move, is in collision",
    "steps: [{shove: mug}]": "'steps.0' is wrong: give one of pick, place and move",
    "steps: [{pick: mug}]\ngripper: {open: {claw: 0.04}}": "joint of the gripper must be a fixed joint of panda",
    "steps: [{pick: mug}]\ngripper: {touch: [claw]}": "link 'claw' of 'touch' not found",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "scene.yaml").write_text(SCENE_TEXT)
    return tmp_path


@pytest.mark.parametrize("text", WRONG)
def test_what_makes_no_sense_is_one_sentence(text: str, folder: Path) -> None:
    (folder / "task.yaml").write_text(f"robot: panda\nscene: scene.yaml\n{text.replace('SPOT', SPOT)}\n")
    with pytest.raises(PlannerError, match=r"^[^\n]*\.$") as error:
        task(folder / "task.yaml", nodes=10, timing=None)
    assert WRONG[text] in str(error.value)
    assert error.value.exit_code == 3


_ANYTHING = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.sampled_from(["mug", "auto", "home", ""]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS), inner, max_size=4),
    max_leaves=12,
)


@settings(deadline=None)  # the first file loads the reader
@given(steps=_ANYTHING, gripper=_ANYTHING)
def test_any_file_is_a_task_or_one_sentence(tmp_path_factory, steps: object, gripper: object) -> None:
    path = tmp_path_factory.mktemp("any") / "task.yaml"
    path.write_text(yaml_text({"robot": "panda", "scene": "empty", "steps": steps, "gripper": gripper}))
    try:
        text = str(Task.load(path).steps[0])
    except PlannerError as error:
        text = str(error)
    assert "\n" not in text


def test_how_much_nearer_the_object_would_have_to_be_is_said() -> None:
    """Proven from the arm's lengths: as much nearer it is out of reach still, and 10 cm nearer it lacks 10 cm less."""
    beyond = []
    for x in (2.0, 1.9):
        mug = Obstacle("mug", MUG.shape, pose((x, 0.0, 0.22)))
        found = task(replace(SMALL, scene=Scene("away", (TABLE, BOARD, mug))), nodes=10, timing=None)
        assert found.reason is not None
        assert found.reason.beyond is not None
        assert f"(the nearest by {found.reason.beyond:.2f} m or more)" in found.message
        beyond.append(found.reason.beyond)
    assert beyond[0] - beyond[1] == pytest.approx(0.1, abs=1e-3)
    assert beyond[1] > 0.5
    near = Obstacle("mug", MUG.shape, pose((1.9 - beyond[1], 0.0, 0.22)))
    last = task(replace(SMALL, scene=Scene("away", (TABLE, BOARD, near))), nodes=10, timing=None).reason
    assert last is not None
    assert (last.out_of_reach, last.beyond) == (3, None)


def test_grasps_in_contact_are_counted_by_what_they_touch() -> None:
    lid = Obstacle("lid", Box((0.2, 0.2, 0.02)), pose((0.5, -0.3, 0.35)))
    found = task(replace(SMALL, scene=Scene("covered", (TABLE, BOARD, lid, MUG))), nodes=10, timing=None)
    assert found.reason is not None
    assert found.reason.what == "no_grasp"
    assert sum(found.reason.contacts.values()) + found.reason.out_of_reach == 3
    assert "lid" in found.reason.names
    assert "'lid'" in found.message


CONSTRAINTS = {"plane:0,0,1,0.45": ("no_grasp", 3), "axis:z,0,0,-1,0.1": ("no_path", 1)}


@pytest.mark.parametrize("constraint", CONSTRAINTS)
def test_what_strays_from_what_is_kept_is_counted_as_that(constraint: str) -> None:
    """Grasps below a plane that the tool stays above, and one that tilts more than the tool may: nothing touches."""
    found, (what, violations) = (
        task(replace(SMALL, scene=replace(SCENE, constraints=constraint)), nodes=20, timing=None),
        CONSTRAINTS[constraint],
    )
    assert found.reason is not None
    assert found.reason.what == what
    assert (found.reason.violations, found.reason.contacts, found.reason.conditions) == (violations, {}, (constraint,))
    assert f"{violations} against constraints ({constraint})" in found.message
    assert "None" not in found.message
    assert found.to_dict()["reason"]["violations"] == violations


def test_no_placement_that_the_object_fits_into() -> None:
    """The hand gets there, the object does not: something small stands in its only place."""
    peg = Obstacle("peg", Box((0.01, 0.01, 0.03)), pose((0.5, 0.35, 0.235)))
    narrow = Place("mug", "board", ((0.47, 0.32), (0.53, 0.38)), samples=3)
    scene = Scene("pegged", (TABLE, BOARD, peg, MUG))
    found = task(replace(SMALL, scene=scene, steps=(Pick("mug", GRASPS), narrow, Move("home"))), nodes=60, timing=None)
    assert found.outcome is Outcome.NO_PATH
    assert found.reason is not None
    assert (found.reason.step, found.reason.what) == (2, "no_placement")
    assert found.reason.names == {"mug", "peg"}
    reason = found.reason  # each pair of a grasp and a placement once, however many configurations of it are in contact
    assert reason.out_of_reach + sum(reason.contacts.values()) <= reason.tried
    assert "Step 2 (place mug) cannot be done: no placement is feasible" in found.message


def test_a_free_axis_and_a_cone_become_poses(folder: Path) -> None:
    grasps = "[{position: [0, 0, 0.02], axis: [0, 0, -2], cone: 0.4, opening: 0.06}]"
    (folder / "task.yaml").write_text(
        f"robot: panda\nscene: scene.yaml\nsteps: [{{pick: mug, grasps: {grasps}, approach: {{axis: [1, 0, 0]}}}}]\n"
    )
    step = Task.load(folder / "task.yaml").steps[0]
    assert isinstance(step, Pick)
    assert step.grasps is not None
    poses = [tool for grasp in step.grasps for tool in tool_poses(grasp)]
    assert len(poses) == 7 * 12
    cosines = np.array([tool[:3, 2] @ [0, 0, -1] for tool in poses])
    np.testing.assert_allclose(cosines, np.repeat([1.0, *[np.cos(0.4)] * 6], 12))
    for tool in poses:
        np.testing.assert_allclose(tool[:3, :3] @ tool[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(tool[:3, :3]) == pytest.approx(1.0)
    assert step.approach.axis == (1.0, 0.0, 0.0)
