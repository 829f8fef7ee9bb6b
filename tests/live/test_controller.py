"""What the live page asks for: it is done as the session does it, or refused in a sentence and nothing has changed."""

from __future__ import annotations

import json
import re
import threading
from pathlib import Path

import numpy as np
import pytest

from planner.collision import make_checker
from planner.kinematics.forward import tool_positions
from planner.live.controller import LiveController
from planner.models.scene import Scene
from planner.paths.measure import path_contact
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from tests.live.controllers import SCENE, ask, make_controller, move, path_of
from tests.worlds import load


@pytest.fixture
def controller(tmp_path: Path) -> LiveController:
    return make_controller(tmp_path)


def place(controller: LiveController, name: str) -> np.ndarray:
    return next(item.placement for item in controller._session.scene.obstacles if item.name == name)


def test_a_moved_obstacle_gets_a_path_around_it(controller: LiveController) -> None:
    answer = move(controller, "post", 0.8, 0.15, 0.0)
    assert "error" not in answer
    np.testing.assert_array_equal(place(controller, "post")[:3, 3], [0.8, 0.15, 0.0])
    checker = make_checker(load("planar_2r"), controller._session.scene, "fcl")
    assert path_contact(checker, path_of(answer)) is None
    assert answer["live"]["undo"] == 1
    assert dict(answer["live"]["report"])["proven again"].endswith("edges")
    assert {"change", "planning", "drawing"} == set(answer["live"]["seconds"])
    assert answer["live"]["obstacles"][0]["position"] == [0.8, 0.15, 0.0]


def test_goal_start_and_beta(controller: LiveController) -> None:
    path = path_of(ask(controller, do="goal", position=[0.3, 0.7, 0.0]))
    np.testing.assert_allclose(tool_positions(load("planar_2r"), path[-1])[0], [0.3, 0.7, 0.0], atol=1e-4)
    path = path_of(ask(controller, do="start", joints=[-1.2, 0.9]))
    np.testing.assert_allclose(path[0], [-1.2, 0.9], atol=1e-9)
    assert ask(controller, do="beta", beta=0.9)["data"]["beta"] == 0.9
    assert controller._state.plan.cost is not None
    assert controller._state.plan.cost.beta == 0.9


def test_of_a_pose_the_orientation_stays(controller: LiveController) -> None:
    turned = "pose:0.3,0.7,0.0,0,0,0.6,0.8"
    object.__setattr__(controller._state.question, "goal", turned)
    assert controller._goal_at((0.5, 0.6, 0.0)) == "pose:0.5,0.6,0.0,0.0,0.0,0.6,0.8"


def test_undo_goes_back_exactly(controller: LiveController) -> None:
    path, field = controller._state.plan.path, controller._state.plan.cost_to_go
    move(controller, "post", 0.8, 0.15, 0.0)
    ask(controller, do="goal", position=[0.3, 0.7, 0.0])
    for left in (1, 0):
        assert ask(controller, do="undo")["live"]["undo"] == left
    assert controller._state.plan.path is path
    assert controller._state.plan.cost_to_go is field
    np.testing.assert_array_equal(place(controller, "post")[:3, 3], [0.75, 0.0, 0.0])
    assert "nothing to undo" in ask(controller, do="undo")["error"]


REFUSED = {
    "into the robot": ({"do": "move", "name": "post", "position": [0.0, 0.0, 0.0]}, "'post'", ["link_0", "post"]),
    "onto the goal": ({"do": "move", "name": "post", "position": [0.27, 0.42, 0.0]}, "goal is in collision", None),
    "no such obstacle": ({"do": "move", "name": "wall", "position": [0, 0, 0]}, "'wall' not found", []),
    "too far": ({"do": "move", "name": "post", "position": [1e9, 0, 0]}, "position", []),
    "no place": ({"do": "move", "name": "post", "position": [float("nan"), 0, 0]}, "position", []),
    "goal out of reach": ({"do": "goal", "position": [5.0, 0, 0]}, "cannot be reached", []),
    "start beyond a limit": ({"do": "start", "joints": [0.0, 99.0]}, "outside its limits", []),
    "start of another robot": ({"do": "start", "joints": [0.0]}, "1 joint values", []),
    "beta": ({"do": "beta", "beta": 2}, "beta", []),
    "unknown": ({"do": "format the disk"}, "format the disk", []),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused_is_a_sentence_and_changes_nothing(controller: LiveController, case: str) -> None:
    order, words, red = REFUSED[case]
    if order["do"] == "move":
        order = {"quaternion": [0, 0, 0, 1], **order}
    before, snapshot = controller._state, controller._session.snapshot()
    answer = ask(controller, **order)
    assert words in answer["error"]
    assert answer["error"].endswith(".")
    assert red is None or answer["red"] == red
    assert controller._state is before
    after = controller._session.snapshot()
    assert (after.now.live, after.asked, after.end) == (snapshot.now.live, snapshot.asked, snapshot.end)
    assert ask(controller, do="beta", beta=0.4)["live"]["undo"] == 1


@pytest.mark.parametrize(
    "body", [b"", b"{", b"[]", b"null", b'{"order": 1}', b"\xff\xfe", b"[" * 100_000, b'{"order": {}}']
)
def test_what_is_no_request(controller: LiveController, body: bytes) -> None:
    answer = json.loads(controller.answer(body))
    assert answer["error"].endswith(".")
    assert "failed" not in answer["error"]


def test_a_fault_of_ours_is_a_sentence_too(controller: LiveController, monkeypatch: pytest.MonkeyPatch) -> None:
    before = controller._session.snapshot()
    monkeypatch.setattr(controller._session, "replan", lambda: 1 / 0)
    assert "failed at this" in move(controller, "post", 0.8, 0.15, 0.0)["error"]
    np.testing.assert_array_equal(place(controller, "post")[:3, 3], [0.75, 0.0, 0.0])
    assert controller._session.snapshot().now is before.now


def test_what_moves_is_named_as_left_aside(controller: LiveController, tmp_path: Path) -> None:
    """A path without times cannot keep clear of it: the page must not pass the path off as free of it."""
    ball = "  - {name: ball, type: sphere, radius: 0.1, motion: [{t: 0, position: [2, 0, 0]}]}"
    aside = "Left aside, because they move: ball;"
    among = make_controller(tmp_path, SCENE.replace("\nstates", f"\n{ball}\nstates"))
    assert aside in among.message
    assert aside in move(among, "post", 0.8, 0.15, 0.0)["data"]["message"]
    assert "Left aside" not in controller.message


def test_no_path_says_what_separates(controller: LiveController) -> None:
    """The post across the way at the height of the first link: the arm cannot pass."""
    answer = ask(controller, do="move", name="post", position=[0.3, 0.0, 0.0], quaternion=[0, 0, 0, 1])
    assert "error" not in answer
    assert answer["data"]["blamed"] == "separated"
    assert answer["live"]["red"] == ["post"]
    assert "'post' separates them" in answer["data"]["message"]
    assert "error" not in ask(controller, do="undo")


def test_what_is_saved_is_planned_as_shown(controller: LiveController, tmp_path: Path) -> None:
    move(controller, "post", 0.8, 0.15, 0.0)
    ask(controller, do="goal", position=[0.3, 0.7, 0.0])
    saved = ask(controller, do="save")["saved"]
    assert str(tmp_path / "saved.yaml") in saved
    scene = Scene.load(str(tmp_path / "saved.yaml"))
    np.testing.assert_allclose(scene.obstacles[0].placement, place(controller, "post"), atol=1e-15)
    assert scene.states_of("planar_2r") == {"start": "q:-1.0,0.8", "goal": "xyz:0.3,0.7,0.0"}
    found = plan(PlanRequest(robot="planar_2r", scene=str(tmp_path / "saved.yaml"), nodes=50))
    np.testing.assert_allclose(found.path[0], [-1.0, 0.8])


def test_what_names_other_states_is_saved_as_what_it_stands_for(tmp_path: Path) -> None:
    """Else a start at home, where the scene's home is its start, would lead back to itself."""
    states = '{home: start, start: "q:-1.0,0.8", goal: end, end: "q:1.0,-0.8"}'
    controller = make_controller(tmp_path, SCENE.replace('{start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}', states))
    object.__setattr__(controller._state.question, "start", "home")
    assert "saved" in ask(controller, do="save")
    saved = Scene.load(str(tmp_path / "saved.yaml")).states_of("planar_2r")
    assert (saved["start"], saved["goal"]) == ("q:-1.0,0.8", "q:1.0,-0.8")


def test_reload_puts_everything_back(controller: LiveController, tmp_path: Path) -> None:
    move(controller, "post", 0.8, 0.15, 0.0)
    live = ask(controller, do="reload")["live"]
    assert live["undo"] == 2
    drawn = live["drawn"]
    np.testing.assert_array_equal(place(controller, "post")[:3, 3], [0.75, 0.0, 0.0])
    (tmp_path / "scene.yaml").write_text(
        "obstacles: [{name: ball, type: sphere, radius: 0.02, position: [0.9, 0.3, 0]}]"
    )
    assert ask(controller, do="reload")["live"]["drawn"] != drawn
    assert [item.name for item in controller._session.scene.obstacles] == ["ball"]
    assert ask(controller, do="undo")["live"]["drawn"] == drawn
    assert len(controller._session.scene.obstacles) == 2
    (tmp_path / "scene.yaml").write_text("obstacles: 1")
    assert "obstacles" in ask(controller, do="reload")["error"]


_MOVING = "{name: cart, type: sphere, radius: 0.05, motion: [{t: 0, position: [2, 2, 0]}, {t: 1, position: [3, 2, 0]}]}"


@pytest.mark.parametrize(
    ("edit", "left"),
    [
        (("0.8", "0.7"), "states"),
        (("states:", "robots: {planar_2r: {base: {position: [0, 0, 1]}}}\nstates:"), "how robots are set up"),
        (("obstacles:", f"obstacles:\n  - {_MOVING}"), "obstacles that move"),
        (("states:", "allowed: [[post, forearm]]\nstates:"), "what may touch"),
        (("states:", 'keep: ["box:-2,-2,-2,2,2,2"]\nstates:'), "what motions keep"),
        (("0.75, 0, 0", "0.75, 0.1, 0"), None),
        (("name: post", "name: pole"), None),
    ],
)
def test_a_reload_tells_what_it_leaves(tmp_path: Path, edit: tuple[str, str], left: str | None) -> None:
    controller = make_controller(tmp_path)
    (tmp_path / "scene.yaml").write_text(SCENE.replace(*edit))
    report = dict(ask(controller, do="reload")["live"]["report"])
    told = None if left is None else f"{left}: open the live view again for that"
    assert report.get("changed too, and left") == told
    (tmp_path / "scene.yaml").write_text(SCENE)
    assert "changed too, and left" not in dict(ask(controller, do="reload")["live"]["report"])


def test_a_reload_tells_what_is_passed_over(tmp_path: Path) -> None:
    """Of MoveIt's messages, fields are; those that were when the page opened were told then."""
    message = "{name: tray, world: {collision_objects: [%s]}, robot_state: {joint_state: {name: [j1], %s}}}"
    controller = make_controller(tmp_path)
    (tmp_path / "scene.yaml").write_text(message % ("", "position: [0.1], effort: [3.0]"))
    report = dict(ask(controller, do="reload")["live"]["report"])
    assert "effort" in report["noted"]
    assert "states" in report["changed too, and left"]
    assert "robot_state" in report["changed too, and left"]


@pytest.mark.parametrize(("more", "seen"), [("radius: 0.06", True), ("speed_limit: 0.5", False)])
def test_a_reload_takes_all_that_was_changed_of_the_last_obstacle(tmp_path: Path, more: str, seen: bool) -> None:
    """Neither names nor their order change; what moves by itself looks the same."""
    ball = {"name": "ball", "type": "sphere", "radius": 0.05, "position": [0.9, 0.3, 0.0]}
    states = 'states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}}'
    controller = make_controller(tmp_path, f"obstacles: [{json.dumps(ball)}]\n{states}")
    drawn = re.findall(r'"drawn":\s*"(\w{64})"', controller.page())[0]
    key, value = more.split(": ")
    (tmp_path / "scene.yaml").write_text(f"obstacles: [{json.dumps(ball | {key: float(value)})}]")
    answer = ask(controller, do="reload")
    assert (answer["live"]["drawn"] != drawn) == seen
    found = controller._session.scene.obstacles[0]
    assert found.speed_limit == (0.0 if seen else 0.5)
    assert vars(found.shape)["radius"] == (0.06 if seen else 0.05)


def test_requests_wait_for_each_other(controller: LiveController) -> None:
    answers: list[dict] = []
    betas = np.linspace(0.1, 0.9, 6)
    threads = [threading.Thread(target=lambda b=b: answers.append(ask(controller, do="beta", beta=b))) for b in betas]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(answer["live"]["undo"] for answer in answers) == [1, 2, 3, 4, 5, 6]


def test_states_to_go_back_to_share_what_is_equal(tmp_path: Path) -> None:
    controller = make_controller(tmp_path)
    for k in range(8):
        assert "error" not in move(controller, "post", 0.75, 0.01 * k, 0.0)
    worlds = [state.snapshot.now.live for state in [*controller._past, controller._state]]
    assert len({id(live.checker) for live in worlds}) == 8  # the first move went nowhere
    assert len({id(vars(live.checker)["_broad"]) for live in worlds}) == 1  # most of a world's memory
    assert len({id(live.bare) for live in worlds}) == 1


def test_a_look_says_whether_the_path_holds_and_changes_nothing(tmp_path: Path) -> None:
    controller = make_controller(tmp_path)
    before, path = controller._session.live, controller._state.plan.path

    def look(*position: float) -> dict:
        return ask(controller, do="look", name="post", position=position, quaternion=[0, 0, 0, 1])

    assert look(-0.9, 0.9, 0.0) == {"holds": True}
    middle = tool_positions(controller._session.robot, 0.5 * (path[len(path) // 2 - 1] + path[len(path) // 2]))[0]
    assert look(*middle.tolist()) == {"holds": False}
    assert "touch" in look(0.0, 0.0, 0.0)["error"]  # the base
    assert controller._session.live is before
    assert not controller._past
