"""The live page in a real browser: what is dragged by the mouse is planned anew, what is refused goes back."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.live.controller import LiveController
from planner.models.scene import Scene
from planner.view.serve import running
from tests.browser import Tab, browser
from tests.live.controllers import ask, make_controller

# where a point of the room, in metres, is seen in the window
SEEN = """((x, y, z) => {
  const place = viewer.scene.localToWorld(new THREE.Vector3(x, y, z)).project(viewer.camera);
  return [((place.x + 1) / 2) * innerWidth, ((1 - place.y) / 2) * innerHeight];
})"""
DONE = "[document.documentElement.dataset.answers, document.documentElement.dataset.refused].join()"


@pytest.fixture(scope="module")
def window() -> Iterator[Tab]:
    with browser() as tab:
        yield tab


@pytest.fixture
def opened(window: Tab, tmp_path: Path) -> Iterator[tuple[Tab, LiveController]]:
    """A live page, freshly opened; nothing may have been complained of, or asked of anyone else, by the end."""
    controller = make_controller(tmp_path)
    with running(controller) as (address, _):
        assert window.open(address), window.console
        yield window, controller
        assert window.console == []
        own = address.partition("?")[0]
        assert all(request.startswith(own) for request in window.requests)


def seen(tab: Tab, point: Any) -> np.ndarray:
    return np.array(tab.run(f"{SEEN}({', '.join(map(repr, map(float, point)))})"))


def mouse(tab: Tab, first: np.ndarray, last: np.ndarray) -> None:
    """The left button pressed at one place of the window and let go at another."""

    def say(kind: str, place: np.ndarray, **more: Any) -> None:
        tab.call("Input.dispatchMouseEvent", type=kind, x=float(place[0]), y=float(place[1]), **more)

    say("mouseMoved", first)
    say("mousePressed", first, button="left", clickCount=1)
    for share in (0.2, 0.6, 1.0):
        say("mouseMoved", first + share * (last - first), button="left", buttons=1)
    say("mouseReleased", last, button="left", clickCount=1)


def answered(tab: Tab, before: str) -> None:
    """Wait for the planner's answer to what was done since the page said ``before``."""
    tab.run(f"new Promise(done => (function look() {{ {DONE} !== '{before}' ? done(1) : setTimeout(look, 20); }})())")
    tab.drawn()


def drag(tab: Tab, first: np.ndarray, last: np.ndarray) -> None:
    before = tab.run(DONE)
    mouse(tab, first, last)
    answered(tab, before)


def place(controller: LiveController, name: str) -> np.ndarray:
    return next(item.placement for item in controller._session.scene.obstacles if item.name == name)


def waypoints(tab: Tab) -> np.ndarray:
    return np.array(tab.run("data.paths[0].waypoints"))


def text(tab: Tab, element: str) -> str:
    return tab.run(f"element('{element}').textContent")


def test_an_obstacle_is_dragged_and_the_path_is_new(opened: tuple[Tab, LiveController]) -> None:
    """By its body: it stays on its level, under the pointer."""
    tab, controller = opened
    path, picture, top = waypoints(tab), tab.screenshot(), np.array([0.0, 0.0, 0.1])
    first, last = np.array([0.75, 0.0, 0.0]) + top, np.array([0.7, -0.3, 0.0]) + top
    tab.run("choose(0)")  # so that no arrow of the obstacle's own is in the way
    drag(tab, seen(tab, first), seen(tab, last))
    np.testing.assert_allclose(place(controller, "post")[:3, 3], [0.7, -0.3, 0.0], atol=0.01)
    assert place(controller, "post")[2, 3] == 0.0
    assert tab.run("document.documentElement.dataset.holds") in ("true", "false")  # it was said before the answer
    assert controller._state.plan.solved
    assert not np.array_equal(waypoints(tab), path)
    np.testing.assert_allclose(waypoints(tab)[[0, -1]], controller._state.plan.path[[0, -1]], atol=1e-8)
    assert np.abs(tab.screenshot() - picture).max() > 30
    assert "obstacle 'post' moved" in text(tab, "live-said")
    assert "proven again" in text(tab, "live-report")
    assert text(tab, "message") == "A collision-free path was found."
    assert tab.run("[live.undo, element('undo').disabled]") == [1, False]


def test_what_the_pointer_is_told_of_a_node_goes_with_the_old_field(opened: tuple[Tab, LiveController]) -> None:
    tab, _ = opened
    place = "new THREE.Vector3().fromBufferAttribute(drawn('roadmap/nodes').geometry.attributes.position, 70)"
    tab.mouse(*seen(tab, tab.run(f"{place}.toArray()")))
    assert "cost-to-go" in text(tab, "tip")
    assert tab.run("element('tip').hidden") is False
    count = tab.run(DONE)
    tab.run("(s => { s.value = 0.9; s.oninput(); s.onchange(); })(element('live-beta'))")
    answered(tab, count)
    assert tab.run("element('tip').hidden") is True


def test_what_is_under_the_pointer_is_dragged_not_the_margin_of_anothers_arrow(
    opened: tuple[Tab, LiveController],
) -> None:
    """The gizmo of the post lies over the drum: where no arrow is drawn, the drum is meant."""
    tab, controller = opened
    drum = place(controller, "drum")[:3, 3]
    top, there = drum + np.array([0.0, 0.0, 0.1]), drum + np.array([0.0, -0.1, 0.0])
    tab.run("choose(1)")
    # the post's x-arrow, moved beside the middle of the drum's top: its margin covers that, what is drawn does not
    size = tab.run("gizmo.scale.x")
    tab.run(f"gizmo.position.set(...{(top + np.array([-0.42, 0.05, 0.0]) * size).tolist()}); viewer.set_dirty()")
    first = seen(tab, top)
    kinds = tab.run(
        f"(e => {{ pointerRay(e); return [grips, handles].map(p => ray.intersectObjects(p, false).length > 0); }})"
        f"({{clientX: {first[0]}, clientY: {first[1]}}})"
    )
    assert kinds == [True, False]
    before = place(controller, "post").copy()
    drag(tab, first, seen(tab, there + top - drum))
    np.testing.assert_array_equal(place(controller, "post"), before)
    np.testing.assert_allclose(place(controller, "drum")[:3, 3], there, atol=0.02)


def test_an_arrow_moves_along_its_axis_and_the_ring_turns(opened: tuple[Tab, LiveController]) -> None:
    tab, controller = opened
    tab.run("choose(1)")
    size = tab.run("gizmo.scale.x")
    for axis in range(3):
        tip, centre = 0.8 * size * np.eye(3)[axis], place(controller, "post")[:3, 3].copy()
        drag(tab, seen(tab, centre + tip), seen(tab, centre + tip + 0.05 * np.eye(3)[axis]))
        np.testing.assert_allclose(place(controller, "post")[:3, 3] - centre, 0.05 * np.eye(3)[axis], atol=0.004)
    centre = place(controller, "post")[:3, 3]
    rim = [0.62 * size * np.array([np.cos(angle), np.sin(angle), 0.0]) for angle in (-0.7, -0.4)]
    drag(tab, seen(tab, centre + rim[0]), seen(tab, centre + rim[1]))
    turn = place(controller, "post")[:3, :3]
    assert np.arctan2(turn[1, 0], turn[0, 0]) == pytest.approx(0.3, abs=0.03)
    np.testing.assert_allclose(turn[2], [0, 0, 1], atol=1e-9)


def test_the_goal_is_dragged(opened: tuple[Tab, LiveController]) -> None:
    tab, controller = opened
    goal = controller._state.goal_position
    tab.run("choose(1)")
    drag(tab, seen(tab, goal), seen(tab, [0.4, 0.6, goal[2]]))
    np.testing.assert_allclose(controller._state.goal_position[:2], [0.4, 0.6], atol=0.02)
    assert tab.run("document.documentElement.dataset.chosen") == "goal"


def test_what_is_refused_goes_back_and_is_red(opened: tuple[Tab, LiveController]) -> None:
    tab, controller = opened
    before, path = controller._state, waypoints(tab)
    count = tab.run(DONE)
    tab.run("element('live-x').value = 0, element('live-x').onchange()")  # into the robot's base
    answered(tab, count)
    assert controller._state is before
    assert "'post'" in text(tab, "message")
    assert tab.run("element('message').classList.contains('wrong')")
    red = tab.run(
        "Object.keys(data.names).filter(p => drawn(p).material.color.getHex() === RED).map(p => data.names[p])"
    )
    assert "post" in red
    assert len(red) >= 2
    assert tab.run("element('live-x').valueAsNumber") == 0.75
    x = tab.run("(g => (g.updateMatrix(), g.matrix.elements[12]))(group('obstacles/0'))")
    assert x == pytest.approx(0.75)
    np.testing.assert_array_equal(waypoints(tab), path)


def test_start_beta_undo_save_and_a_reload_of_the_page(opened: tuple[Tab, LiveController], tmp_path: Path) -> None:
    tab, controller = opened
    steps = (
        "(s => { s.value = -1.2; s.oninput(); s.onchange(); })(element('live-start').querySelector('input'))",
        "(s => { s.value = 0.9; s.oninput(); s.onchange(); })(element('live-beta'))",
        "(f => { f.value = 0.1; f.onchange(); })(element('live-yaw'))",
    )
    for step in steps:
        count = tab.run(DONE)
        tab.run(step)
        answered(tab, count)
    assert waypoints(tab)[0][0] == pytest.approx(-1.2)
    assert controller._state.question.beta == 0.9
    assert np.arctan2(*place(controller, "post")[[1, 0], 0]) == pytest.approx(0.1)
    for choice in ("before", "change", "cost"):
        tab.run(f"(e => {{ e.value = '{choice}'; e.onchange(); }})(element('colour'))")
        assert tab.run("document.documentElement.dataset.colour") == choice
    address = tab.run("location.href")
    assert tab.open(address)
    assert tab.run("live.undo") == 3
    assert waypoints(tab)[0][0] == pytest.approx(-1.2)
    count = tab.run(DONE)
    tab.run("element('undo').click()")
    answered(tab, count)
    assert place(controller, "post")[1, 0] == 0.0
    tab.run("element('save').click()")
    tab.run("new Promise(done => (function look() { element('live-said').textContent.startsWith('Written') ? done(1) "
            ": setTimeout(look, 20); })())")  # fmt: skip
    saved = Scene.load(str(tmp_path / "saved.yaml")).states_of("planar_2r")["start"]
    assert saved.startswith("q:-1.2")


def test_objects_that_another_viewer_brought_are_drawn(opened: tuple[Tab, LiveController], tmp_path: Path) -> None:
    tab, controller = opened
    ball = "{name: ball, type: sphere, radius: 0.02, position: [0.9, 0.3, 0]}"
    (tmp_path / "scene.yaml").write_text(f"obstacles: [{ball}]")
    ask(controller, do="reload")
    assert "ball" not in tab.run("Object.values(data.names)")
    tab.run("(s => { s.value = 0.9; s.oninput(); s.onchange(); })(element('live-beta'))")
    until = time.monotonic() + 20
    while "ball" not in (names := tab.run("typeof data === 'undefined' ? [] : Object.values(data.names)")):
        assert time.monotonic() < until, names
        time.sleep(0.1)
    assert "post" not in names


def test_where_there_is_no_path_what_separates_is_red(opened: tuple[Tab, LiveController]) -> None:
    tab, _ = opened
    count = tab.run(DONE)
    tab.run("element('live-x').value = 0.3, element('live-x').onchange()")
    answered(tab, count)
    assert "'post' separates them" in text(tab, "message")
    red = tab.run(
        "Object.keys(data.names).filter(p => drawn(p).material.color.getHex() === RED).map(p => data.names[p])"
    )
    assert red == ["post"]
    count = tab.run(DONE)
    tab.run("element('undo').click()")
    answered(tab, count)
    assert text(tab, "message") == "A collision-free path was found."
    assert tab.run("element('player').hidden") is False
