"""The page in a real browser: ready, offline, and its controls work."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.collision import make_checker
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.request import PlanRequest, TimingRequest
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Cylinder
from planner.tradeoff.result import Tradeoff
from planner.tradeoff.sweep import add_alternatives, sweep
from planner.trajectory.measure import path_manipulability
from planner.view.drawing import joint_matrices
from planner.view.motion import chain_data
from planner.view.state import inspect_state
from tests.browser import Tab, browser, dataset, drag, text, text_content
from tests.linkages import random_linkage
from tests.worlds import ROBOTS, joint_xml, link_xml, load, random_q

STAGE = (slice(0, 525), slice(345, None))  # of a picture: neither panel nor player
ARM = PlanRequest.from_options(robot="planar_2r", scene="empty", start="q:-2,1.5", goal="q:2,-2", nodes=150, seed=4)


@pytest.fixture(scope="module")
def made(solved: Plan) -> Plan:
    return add_alternatives(solved)


@pytest.fixture(scope="module")
def plan_file(made: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "plan.html"
    path.write_text(made.page())
    return path


@pytest.fixture(scope="module")
def tradeoff() -> Tradeoff:
    """Some paths, of which one is optimal for a few per cent of all betas only."""
    made = sweep(request=ARM)
    assert len(made.intervals) >= 4
    return made


@pytest.fixture(scope="module")
def sweep_file(tradeoff: Tradeoff, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "sweep.html"
    path.write_text(tradeoff.page())
    return path


@pytest.fixture(scope="module")
def window() -> Iterator[Tab]:
    with browser() as tab:
        yield tab


@pytest.fixture
def tab(window: Tab, plan_file: Path) -> Iterator[Tab]:
    """The plan's page, freshly loaded; it must not have complained by the end."""
    assert window.open(plan_file), window.console
    yield window
    assert window.console == []
    assert window.requests == []


@pytest.fixture
def sweep_tab(window: Tab, sweep_file: Path) -> Iterator[Tab]:
    assert window.open(sweep_file), window.console
    yield window
    assert window.console == []
    assert window.requests == []


def differ(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(height, width) which pixels of two pictures differ clearly."""
    return np.abs(first - second).max(axis=2) > 30


def tool_in_page(tab: Tab) -> np.ndarray:
    """The tool position of the page's robot: the last frame's matrix as it is drawn."""
    joint, offset = tab.run("[data.chain.tool.parent, data.chain.tool.offset]")
    place = f"new THREE.Vector3(...{offset}).applyMatrix4((g => (g.updateMatrix(), g.matrix))(group('robot/{joint}')))"
    return np.array(tab.run(f"{place}.toArray()"))


# the page as it opens


def test_the_page_is_ready_and_names_its_content(tab: Tab, made: Plan) -> None:
    words = tab.run("document.body.innerText")
    for expected in ("iiwa14 in paper", "A collision-free path was found.", "manipulability w", "β 0.5"):
        assert expected in words
    assert "150 nodes" in tab.run("element('about').textContent")
    assert f"{made.cost.manipulability:.4f}" in text(tab, "numbers")
    assert text(tab, "now") == f"w = {made.roadmap.manipulability[made.path_nodes[0]]:.4f} m³ · 0 %"


def test_forward_kinematics_of_every_robot(tab: Tab, urdf_file: Callable[..., str]) -> None:
    """Revolute, continuous and sliding joints, in a chain and placed anywhere, and those that follow others."""
    inside = link_xml("a") + link_xml("b") + link_xml("c") + joint_xml("slide", "a", "b", "prismatic", "0 0.6 0.8")
    inside += joint_xml("turn", "b", "c", "continuous", "0 1 0", xyz="0.1 0.2 0.3")
    for robot in (*map(load, ROBOTS), Robot.load(urdf_file(inside)), *(random_linkage(k).robot for k in range(4))):
        q = random_q(robot, 4)
        tab.run(f"void (data.chain = {json.dumps(chain_data(robot))})")
        place = "placements(q).slice(1).map(f => columns(f.rotation, f.position))"
        frames = np.array(tab.run(f"{json.dumps(q.tolist())}.map(q => {place})"))
        frames = frames.reshape(4, -1, 4, 4).transpose(0, 1, 3, 2)
        np.testing.assert_allclose(frames, joint_matrices(robot, q), atol=1e-9, err_msg=robot.name)


# the trade-off


def test_the_slider_changes_the_path(sweep_tab: Tab, tradeoff: Tradeoff) -> None:
    tab, pictures = sweep_tab, []
    for k, interval in enumerate(tradeoff.intervals):
        drag(tab, "beta", 0.9 * interval.beta_min + 0.1 * interval.beta_max)
        assert dataset(tab, "path") == str(k)
        assert tab.run("data.paths.map((_, k) => group('paths/' + k).visible)").index(True) == k
        assert f"{interval.manipulability_cost:.4f}" in text(tab, "numbers")
        assert f"{interval.distance_cost:.4f}" in text(tab, "numbers")
        assert f"{interval.workspace_length:.3f} m" in text(tab, "numbers")
        middle = 0.5 * (interval.beta_min + interval.beta_max)
        assert float(dataset(tab, "beta")) == pytest.approx(middle), "let go, it snaps"
        assert text(tab, "which") == f"path {k + 1} of {len(tradeoff.intervals)}"
        words = text(tab, "interval").split()
        assert [float(words[-3]), float(words[-1])] == pytest.approx([interval.beta_min, interval.beta_max], abs=5e-5)
        tab.run("goTo(0.5)")
        pictures.append((tab.screenshot(), tool_in_page(tab), tab.run("element('spark').innerHTML")))
    (first, tool, curve), (last, other_tool, other_curve) = pictures[0], pictures[-1]
    assert differ(first, last)[STAGE].mean() > 0.002
    assert np.linalg.norm(tool - other_tool) > 0.02
    assert curve != other_curve


# manipulability


def test_the_worst_points_are_marked_and_lead_there(tab: Tab, made: Plan) -> None:
    lowest = path_manipulability(made.robot, made.path).min()
    marks = tab.run("[...document.querySelectorAll('.mark')].map(m => m.textContent)")
    lines = tab.run("[...element('worst-list').children].map(m => m.textContent)")
    count = tab.run("shownPath().worst.length")
    assert len(marks) == len(lines) == count >= 1
    assert "lowest manipulability of the path" in text(tab, "worst")
    assert tab.run("shownPath().worst.map(p => p.w)")[0] == pytest.approx(lowest)
    for k, selector in enumerate(("#worst-list button", ".mark")):
        tab.run("goTo(0)")
        tab.click(selector)
        point = tab.run("shownPath().worst[0]")
        assert float(dataset(tab, "share")) == pytest.approx(point["share"], abs=1e-4), k
        np.testing.assert_allclose(tool_in_page(tab), point["position"], atol=2e-3)


# a phone, and the picture


PHONE = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}


@pytest.fixture
def phone(window: Tab, sweep_file: Path) -> Iterator[Tab]:
    """The sweep's page as a phone has it."""
    window.call("Emulation.setDeviceMetricsOverride", **PHONE)
    assert window.open(sweep_file), window.console
    yield window
    window.call("Emulation.clearDeviceMetricsOverride")
    assert window.console == []


def test_on_a_phone_the_robot_is_seen_and_the_panel_unfolds(phone: Tab) -> None:
    assert phone.run("[innerWidth, document.documentElement.scrollWidth]") == [390, 390], "nothing sticks out"
    assert phone.run("element('body').hidden") is True
    assert "planar_2r in empty" in text(phone, "panel")
    panel = phone.run("(b => b.height / innerHeight)(element('panel').getBoundingClientRect())")
    assert panel < 0.3
    phone.click("#fold")
    assert phone.run("element('body').hidden") is False
    assert "manipulability cost" in text(phone, "numbers")
    assert phone.run("element('panel').getBoundingClientRect().bottom <= element('player').getBoundingClientRect().top")
    assert phone.run("document.documentElement.scrollWidth") == 390


# other pages


def test_a_moving_obstacle_is_shown_at_the_time_of_the_player(window: Tab, tmp_path: Path) -> None:
    way = [pose([1.2, 0.9, 0]), pose([0.5, 1.2, 0], [0.4, 0, 2.5]), pose([-1.5, 1.5, 0], [0, 0, -2.9])]
    cart = MovingObstacle("cart", Cylinder(0.1, 0.3), KnownMotion([0, 0.6, 30], way))
    found = plan(request=ARM.with_options(scene=Scene("cart", moving=(cart,))), timing=TimingRequest())
    found.save(tmp_path)
    assert window.open(tmp_path / "plan.html"), window.console
    upright = pose(rpy=[np.pi / 2, 0, 0])  # three.js cylinders lie on y
    for share in (0.0, 0.15, 0.8, 1.0):
        window.run(f"void goTo({share})")
        matrix = window.run("viewer.scene.updateMatrixWorld(true), drawn('moving/0/shape').matrixWorld.toArray()")
        there = cart.motion.at(share * found.trajectory.duration)[0] @ upright
        shown = pose(rpy=[np.pi / 2, 0, 0]) @ np.array(matrix).reshape(4, 4).T  # meshcat's world is y-up
        np.testing.assert_allclose(shown, there, atol=1e-6)
    assert "path of a moving obstacle" in text_content(window, "key")
    assert window.run("data.names['moving/0/shape']") == "cart"
    window.run("element('obstacles').querySelector('button').click()")
    assert window.run("root.dataset.marked") == "cart"
    assert window.run("element('tradeoff').hidden")
    assert window.console == window.requests == []


# the file


def test_a_damaged_page_fails(window: Tab, plan_file: Path, tmp_path: Path) -> None:
    """The negative control: the checks of the tests above notice damage."""
    whole, damaged = plan_file.read_text(), tmp_path / "damaged.html"
    at = whole.index('id="scene">') + 5000
    for broken in (whole[:at] + whole[at + 4000 :], whole.replace('id="scrub"', 'id="srub"')):
        damaged.write_text(broken)
        assert not window.open(damaged)
        window.drawn()
        assert window.console


HOSTILE = (
    "@@VIEWER@@",
    "<!--<script>",
    "</script><script>ran = 1</script>",
    "</title></style><script>ran = 1</script>",
    "<img src=x onerror='ran = 1'>",
    "\"'; ran = 1; //",
    "${ran = 1}`+(ran=1)+`",
    "\\u003cscript>ran = 1</script>\\",
    "a\u2028ran = 1\u2029b\x85c",
    "__proto__",
    "\u202egnp.tra e\u0301 \U0001f469\u200d\U0001f680",
)


def assert_harmless(window: Tab, html: str, name: str, path: Path) -> None:
    """The page is drawn, says the name letter by letter, and nothing in the name has become markup or run."""
    path.write_text(html)
    assert window.open(path), window.console
    assert window.console == window.requests == []
    assert window.run("typeof ran") == "undefined"
    assert window.run("document.querySelector('h1').textContent").endswith(f" in {name}")
    assert window.run("document.title").endswith(f" in {name}")
    assert window.run("document.querySelector('#obstacles button').textContent") == name
    assert window.run("[document.images.length, document.scripts.length]") == [0, 7]


def test_names_that_break_nothing_in_a_plan(window: Tab, made: Plan, tradeoff: Tradeoff, tmp_path: Path) -> None:
    name = "".join(HOSTILE)
    obstacles = tuple(replace(item, name=f"{name}{k or ''}") for k, item in enumerate(made.scene.obstacles))
    scene = replace(made.scene, name=name, obstacles=(*obstacles[:-1], replace(obstacles[-1], name="__proto__")))
    for found in (made, tradeoff):
        checker = make_checker(replace(found.robot, name=name), scene)
        assert_harmless(window, replace(found, checker=checker).page(), name, tmp_path / found.PAGE)


def test_a_script_in_a_name_would_be_noticed(window: Tab, tmp_path: Path) -> None:
    """The negative control: in a page that does not escape, the same names run."""
    html = inspect_state(make_checker(load("planar_2r"), Scene("safe", ())), np.zeros(2)).page()
    path = tmp_path / "state.html"
    path.write_text(html.replace("planar_2r in safe</h1>", f"{HOSTILE[2]}</h1>"))
    window.open(path)
    assert window.run("typeof ran") == "number"


def test_a_page_is_small(made: Plan) -> None:
    assert 300_000 < len(made.page().encode()) < 1_000_000  # of which meshcat's viewer is 290 kB
