"""Tasks that make no sense, each with one sentence; steps that cannot be done, each with its reason."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import PlannerError, SceneError
from planner.base.resources import data_folder
from planner.problem.outcome import Outcome
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.tasks.plan import TaskPlanner, task
from planner.tasks.sampling import gripper_of, tool_poses
from planner.tasks.search import LazySearch
from planner.tasks.task import Grasp, Gripper, Move, Pick, Place, Task, TaskError
from tests.tasks.cases import BOARD, GRASPS, MUG, POST, SCENE, SMALL, TABLE
from tests.worlds import load

SCENE_TEXT = """
obstacles:
  - {name: table, type: box, size: [0.8, 1.4, 0.04], position: [0.55, 0.0, -0.02]}
  - {name: board, type: box, size: [0.4, 0.4, 0.02], position: [0.5, 0.35, 0.21]}
  - {name: tilted, type: box, size: [0.4, 0.4, 0.02], position: [0.5, 0.35, 0.6], rpy: [0.3, 0, 0]}
  - {name: crate, type: box, size: [0.2, 0.2, 0.2], position: [0.3, -0.1, 0.1]}
  - {name: ball, type: sphere, radius: 0.03, position: [0.3, -0.5, 0.03]}
  - {name: mug, type: cylinder, radius: 0.03, length: 0.1, position: [0.5, -0.3, 0.05]}
  - {name: foot, type: box, size: [0.05, 0.05, 0.05], position: [0.4, -0.6, 0.025]}
  - {name: vase, type: cylinder, radius: 0.02, length: 0.1, position: [0.4, -0.6, 0.1]}
  - {name: twin, type: box, size: [0.05, 0.05, 0.05], position: [0.45, -0.6, 0.025]}
states:
  panda: {crash: "q:0,1.7,0,-1.5,0,2,0"}
"""
PICK = "{pick: mug}"
WRONG = {
    "unknown object": ("[{pick: cup}]", "step 1 picks 'cup', which is not in the scene; its obstacles are table"),
    "misspelt object": ("[{pick: mugg}]", "'mugg' (did you mean 'mug'?)"),
    "in the air": (f"[{PICK}, {{place: mug, pose: {{position: [0.5, 0.3, 0.4]}}}}]", "stand in the air at (0.5, 0.3"),
    "inside": (f"[{PICK}, {{place: mug, pose: {{position: [0.5, 0.3, 0.2]}}}}]", "would lie inside 'board'"),
    "region off": (
        f"[{PICK}, {{place: mug, on: board, at: [[0.4, 0.3], [0.9, 0.4]]}}]",
        "beyond the top of 'board' (x",
    ),
    "no board": (f"[{PICK}, {{place: mug, on: bord, at: [[0.4, 0.3], [0.6, 0.4]]}}]", "(did you mean 'board'?)"),
    "no box": (f"[{PICK}, {{place: mug, on: ball, at: [[0.4, 0.3], [0.6, 0.4]]}}]", "'ball' is no box"),
    "not held": ("[{place: mug, on: board, at: [[0.4, 0.3], [0.6, 0.4]]}]", "nothing is held: pick it first"),
    "two in hand": (f"[{PICK}, {{pick: ball}}]", "picks 'ball' while 'mug' is held"),
    "something stands on it": (
        "[{pick: foot}, {place: foot, on: board, at: [[0.4, 0.2], [0.6, 0.5]]}, {pick: vase}]",
        "step 1 picks 'foot' while 'vase' stands on it: pick 'vase' before",
    ),
    "wider than it opens": (
        "[{pick: mug, grasps: [{position: [0, 0, 0.05], rpy: [3.1416, 0, 0], opening: 0.5}]}]",
        "a grasp of 'mug' must open at most 0.08 m, got 0.5",
    ),
    "a state in contact": ("[{move: crash}]", "step 1, the move, is in collision"),
    "too wide": ("[{pick: crate}]", "'crate' is wider than the gripper opens (0.08 m)"),
    "no step": ("[]", "steps"),
    "two kinds": ("[{pick: mug, move: home}]", "give one of pick, place and move"),
    "unknown key": ("[{pick: mug, graps: auto}]", "unknown key 'steps.0.pick.graps' (did you mean 'grasps'?)"),
    "unknown step": ("[{shove: mug}]", "'steps.0' is wrong: give one of pick, place and move"),
    "a line in mm": (
        "[{pick: mug, approach: 100}]",
        "distance' is wrong: Input should be less than or equal to 1 (got 100)",
    ),
    "no number": ("[{pick: mug, approach: .nan}]", "'steps.0.pick.approach.distance' is wrong"),
    "no grasps": ("[{pick: mug, grasps: []}]", "'steps.0.pick.grasps' is wrong"),
    "half a region": (
        f"[{PICK}, {{place: mug, on: board}}]",
        "give 'on' and 'at', a box and",
    ),
    "axis and turn": ("[{pick: mug, grasps: [{axis: [0, 0, 1], rpy: [0, 0, 0]}]}]", "a quaternion (or rpy) or an axis"),
    "unknown state": ("[{move: nowhere}]", "step 1, the move, 'nowhere' is not among"),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "scene.yaml").write_text(SCENE_TEXT)
    return tmp_path


@pytest.mark.parametrize("what", WRONG)
def test_what_makes_no_sense_is_one_sentence(what: str, folder: Path) -> None:
    steps, text = WRONG[what]
    (folder / "task.yaml").write_text(f"robot: panda\nscene: scene.yaml\nsteps: {steps}\n")
    with pytest.raises(PlannerError, match=r"^[^\n]*$") as error:
        task(folder / "task.yaml", nodes=10)
    assert text in str(error.value)
    assert str(error.value).endswith(".")
    assert error.value.exit_code == 3


def test_two_objects_of_one_name(folder: Path) -> None:
    (folder / "scene.yaml").write_text(SCENE_TEXT.replace("name: ball", "name: mug"))
    (folder / "task.yaml").write_text("robot: panda\nscene: scene.yaml\nsteps: [{pick: mug}]\n")
    with pytest.raises(PlannerError, match="name 'mug' is used twice"):
        task(folder / "task.yaml")
    with pytest.raises(SceneError, match="scene 'twice' has 'mug' twice: name each once"):
        Scene("twice", (MUG, replace(MUG, placement=pose((0.5, 0.3, 0.12)))))


def test_a_task_without_steps() -> None:
    with pytest.raises(TaskError, match="a task has no steps: give at least one Pick, Place or Move"):
        replace(SMALL, steps=())


GRIPPERS = {
    "open: {claw: 0.04}": "the gripper cannot move 'claw': joints of panda that are held are panda_finger_joint1",
    "closed: {panda_joint3: 0.1}": "the gripper cannot move 'panda_joint3'",
    "open: {panda_finger_joint1: 40}": "moves 'panda_finger_joint1' to 40, outside its limits [0, 0.04]",
    "opening: 80": "'gripper.opening' is wrong: Input should be less than or equal to 1 (got 80)",
}
STARTS = {
    "crash": "start is in collision: ",
    "nowher": "start 'nowher' is not among the scene's states for panda (its states are default, crash, home)",
    "q:nan,0,0,0,0,0,0": "start holds a value that is not finite",
}


@pytest.mark.parametrize("said", [*GRIPPERS, *STARTS])
def test_a_gripper_or_a_start_that_cannot_be_is_one_sentence(said: str, folder: Path) -> None:
    line = f"gripper: {{{said}}}" if said in GRIPPERS else f"start: '{said}'"
    (folder / "task.yaml").write_text(f"robot: panda\nscene: scene.yaml\n{line}\nsteps: [{{pick: mug}}]\n")
    with pytest.raises(PlannerError, match=r"^[^\n]*$") as error:
        task(folder / "task.yaml", nodes=10)
    assert (GRIPPERS | STARTS)[said] in str(error.value)
    assert error.value.exit_code == 3


def test_what_stands_beside_another_is_not_on_it(folder: Path) -> None:
    """They touch, which is no reason to take the one before the other."""
    steps = "[{pick: vase}, {place: vase, on: board, at: [[0.4, 0.2], [0.6, 0.5]], samples: 1}, {pick: foot}, "
    steps += "{place: foot, on: board, at: [[0.4, 0.2], [0.6, 0.5]], samples: 1}, {pick: twin}]"
    (folder / "task.yaml").write_text(f"robot: panda\nscene: scene.yaml\nsteps: {steps}\n")
    assert task(folder / "task.yaml", nodes=10, ik_solutions=1).outcome in (Outcome.SOLVED, Outcome.NO_PATH)


def test_links_that_may_touch_nothing_are_honoured() -> None:
    assert gripper_of(load("panda"), Gripper(touch=())).touch == ()


def test_links_that_are_not_there_grasp_nothing() -> None:
    with pytest.raises(TaskError, match="link 'claw' cannot touch what is grasped: links with shapes are"):
        task(replace(SMALL, gripper=Gripper(touch=("claw",))))


def test_no_grasp_within_reach() -> None:
    away = Obstacle("mug", MUG.shape, pose((2.0, 0.0, 0.12)))
    found = task(replace(SMALL, scene=Scene("away", (TABLE, BOARD, away))), nodes=10)
    assert found.outcome is Outcome.NO_PATH
    assert found.reason is not None
    assert (found.reason.step, found.reason.what, found.reason.tried, found.reason.out_of_reach) == (
        1,
        "no_grasp",
        3,
        3,
    )
    assert "Step 1 (pick mug) cannot be done: no grasp is left, 3 of 3 out of reach" in found.message
    assert found.to_dict()["reason"]["kind"] == "step_fails"


def test_how_much_nearer_the_object_would_have_to_be_is_said() -> None:
    """Proven from the arm's lengths: as much nearer it is out of reach still, and 10 cm nearer it lacks 10 cm less."""
    beyond = []
    for x in (2.0, 1.9):
        mug = Obstacle("mug", MUG.shape, pose((x, 0.0, 0.22)))
        found = task(replace(SMALL, scene=Scene("away", (TABLE, BOARD, mug))), nodes=10)
        assert found.reason is not None
        assert found.reason.beyond is not None
        assert f"(the nearest by {found.reason.beyond:.2f} m or more)" in found.message
        beyond.append(found.reason.beyond)
    assert beyond[0] - beyond[1] == pytest.approx(0.1, abs=1e-3)
    assert beyond[1] > 0.5
    near = Obstacle("mug", MUG.shape, pose((1.9 - beyond[1], 0.0, 0.22)))
    last = task(replace(SMALL, scene=Scene("away", (TABLE, BOARD, near))), nodes=10).reason
    assert last is not None
    assert (last.out_of_reach, last.beyond) == (3, None)


def test_grasps_in_contact_are_counted_by_what_they_touch() -> None:
    lid = Obstacle("lid", Box((0.2, 0.2, 0.02)), pose((0.5, -0.3, 0.35)))
    found = task(replace(SMALL, scene=Scene("covered", (TABLE, BOARD, lid, MUG))), nodes=10)
    assert found.reason is not None
    assert found.reason.what == "no_grasp"
    assert sum(found.reason.contacts.values()) + found.reason.out_of_reach == 3
    assert "lid" in found.reason.names
    assert "'lid'" in found.message


def test_a_grasp_with_the_hand_in_the_object_is_one_in_contact() -> None:
    inside = Grasp(position=(0.0, 0.0, 0.08), rpy=(np.pi, 0.0, 0.0))
    found = task(replace(SMALL, steps=(Pick("mug", (inside,)), *SMALL.steps[1:])), nodes=10)
    assert found.reason is not None
    assert "'mug'" in str(found.reason.contacts)


KEEPS = {"plane:0,0,1,0.45": ("no_grasp", 3), "axis:z,0,0,-1,0.1": ("no_path", 1)}


@pytest.mark.parametrize("keep", KEEPS)
def test_what_strays_from_what_is_kept_is_counted_as_that(keep: str) -> None:
    """Grasps below a plane that the tool stays above, and one that tilts more than the tool may: nothing touches."""
    found, (what, strays) = task(replace(SMALL, scene=replace(SCENE, keep=keep)), nodes=20), KEEPS[keep]
    assert found.reason is not None
    assert found.reason.what == what
    assert (found.reason.strays, found.reason.contacts, found.reason.conditions) == (strays, {}, (keep,))
    assert f"{strays} straying from what is kept ({keep})" in found.message
    assert "None" not in found.message
    assert found.to_dict()["reason"]["strays"] == strays


def test_no_placement_that_the_object_fits_into() -> None:
    """The hand gets there, the object does not: something small stands in its only place."""
    peg = Obstacle("peg", Box((0.01, 0.01, 0.03)), pose((0.5, 0.35, 0.235)))
    narrow = Place("mug", "board", ((0.47, 0.32), (0.53, 0.38)), samples=3)
    scene = Scene("pegged", (TABLE, BOARD, peg, MUG))
    found = task(replace(SMALL, scene=scene, steps=(Pick("mug", GRASPS), narrow, Move("home"))), nodes=60)
    assert found.outcome is Outcome.NO_PATH
    assert found.reason is not None
    assert (found.reason.step, found.reason.what) == (2, "no_placement")
    assert found.reason.names == {"mug", "peg"}
    reason = found.reason  # each pair of a grasp and a placement once, however many configurations of it are in contact
    assert reason.out_of_reach + sum(reason.contacts.values()) <= reason.tried
    assert "Step 2 (place mug) cannot be done: no placement is left" in found.message


def test_a_roadmap_too_small_leaves_no_path() -> None:
    planner = TaskPlanner.of(SMALL, nodes=100, ik_solutions=2)
    assert planner.network is not None
    assert planner.search is not None
    off = planner.network.leg == 3 * 2  # the way home
    cut = replace(planner.network, heads=np.where(off, planner.network.tails[0], planner.network.heads))
    planner.search = LazySearch(planner.candidates.modes, cut, planner.search.law)
    found = planner.plan()
    assert found.reason is not None
    assert (found.reason.step, found.reason.what) == (3, "no_path")
    assert found.message.startswith("Step 3 (move to home) cannot be done: no path leads there within the budget")


def test_objects_that_move_are_refused() -> None:
    quick = replace(POST, speed_limit=0.1)
    with pytest.raises(TaskError, match="obstacles move"):
        task(replace(SMALL, scene=Scene("moving", (TABLE, BOARD, MUG, quick))))


def test_the_example_is_as_small_as_a_task_can_be() -> None:
    made = Task.load(data_folder("scenes") / "examples/tidy.yaml")
    assert [type(step).__name__ for step in made.steps] == ["Pick", "Place", "Move"]
    assert isinstance(made.steps[1], Place)
    assert (made.steps[1].on, made.steps[1].at) == ("board", ((0.35, 0.2), (0.65, 0.5)))


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
