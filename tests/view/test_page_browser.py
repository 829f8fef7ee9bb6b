"""The page in a real browser: ready, offline, and everything on it does what it says."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.base.outcome import Outcome
from planner.base.request import PlanRequest
from planner.collision import make_checker
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import jacobian
from planner.paths.measure import path_manipulability
from planner.planning import Plan, plan
from planner.tradeoff.alternatives import ShownPath
from planner.tradeoff.sweep import Tradeoff, sweep
from planner.view.drawing import joint_matrices
from planner.view.motion import chain_data
from planner.view.page import Content, page, plan_page, sweep_page, write_plan_page, write_sweep_page
from planner.view.state import inspect_state, state_page
from planner.world.robot import Robot, load_visuals
from planner.world.scene import Scene
from tests.browser import Tab, browser, page_data
from tests.worlds import ROBOTS, joint_xml, link_xml, load, random_q

STAGE = (slice(0, 525), slice(345, None))  # of a picture: neither panel nor player
ARM = PlanRequest(robot="planar_2r", scene="empty", start="q:-2,1.5", goal="q:2,-2", nodes=150, seed=4)


@pytest.fixture(scope="module")
def made(solved: Plan) -> Plan:
    return solved


@pytest.fixture(scope="module")
def plan_file(made: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "plan.html"
    write_plan_page(made, path)
    return path


@pytest.fixture(scope="module")
def tradeoff() -> Tradeoff:
    """Some paths, of which one is optimal for a few per cent of all betas only."""
    made = sweep(ARM)
    assert len(made.intervals) >= 4
    return made


@pytest.fixture(scope="module")
def sweep_file(tradeoff: Tradeoff, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "sweep.html"
    write_sweep_page(tradeoff, path)
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


def choose(tab: Tab, element: str, value: str) -> None:
    tab.run(f"(e => {{ e.value = {json.dumps(value)}; e.dispatchEvent(new Event('change')); }})(element('{element}'))")
    tab.drawn()


def drag(tab: Tab, element: str, value: float, let_go: bool = True) -> None:
    """A range dragged to a value."""
    for event in ("input", "change") if let_go else ("input",):
        tab.run(f"(e => {{ e.value = {value}; e.dispatchEvent(new Event('{event}')); }})(element('{element}'))")
    tab.drawn()


def dataset(tab: Tab, name: str) -> str:
    return tab.run(f"document.documentElement.dataset.{name}")


def text(tab: Tab, element: str) -> str:
    return tab.run(f"element('{element}').innerText")


def tool_in_page(tab: Tab) -> np.ndarray:
    """Where the page's robot has its tool: the last frame's matrix as it is drawn."""
    joint, offset = tab.run("[data.chain.tool.parent, data.chain.tool.offset]")
    place = f"new THREE.Vector3(...{offset}).applyMatrix4((g => (g.updateMatrix(), g.matrix))(group('robot/{joint}')))"
    return np.array(tab.run(f"{place}.toArray()"))


# the page as it opens


def test_the_page_is_ready_and_says_what_it_shows(tab: Tab, made: Plan) -> None:
    words = tab.run("document.body.innerText")
    for expected in ("iiwa14 in paper", "A collision-free path was found.", "manipulability w", "β 0.5000"):
        assert expected in words
    assert "150 nodes" in tab.run("element('about').textContent")
    assert made.cost is not None
    assert f"{made.cost.manipulability:.4f}" in text(tab, "numbers")
    assert text(tab, "now") == f"w = {made.roadmap.manipulability[made.path_nodes[0]]:.4f} m³ · 0 %"


def test_every_object_is_there(tab: Tab, made: Plan) -> None:
    robot, roadmap = made.robot, made.roadmap
    paths = len(page_data_paths(tab))
    meshes = len(load_visuals(robot)) + len(robot.bodies) + len(made.scene.obstacles)
    meshes += len(roadmap.starts) + len(roadmap.goals) + paths
    count = "viewer.scene_tree.find(['meshcat']).object.traverse(o => { for (const k in n) n[k] += o[k] ? 1 : 0; })"
    counted = tab.run(f"(() => {{ const n = {{isMesh: 0, isPoints: 0, isLineSegments: 0}}; {count}; return n; }})()")
    assert counted == {"isMesh": meshes, "isPoints": 1, "isLineSegments": 1}
    assert tab.run("drawn('roadmap/nodes').geometry.attributes.position.count") == len(roadmap.nodes)
    assert tab.run("drawn('roadmap/edges').geometry.attributes.position.count") == 8 * len(roadmap.edges)


def page_data_paths(tab: Tab) -> list[Any]:
    return tab.run("data.paths.map(path => path.interval)")


def test_robot_and_path_are_seen(tab: Tab) -> None:
    whole = tab.screenshot()
    for name in ("robot", "paths", "obstacles", "roadmap/nodes"):
        tab.run(f"show('{name}', false)")
        tab.drawn()
        bare = tab.screenshot()
        assert differ(whole, bare).mean() > 0.0005, name
        whole = bare


def test_the_robot_stands_where_python_puts_it(tab: Tab, made: Plan) -> None:
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(made.path, axis=0), axis=1))])
    for share in (0.0, 0.123, 0.5, 0.987, 1.0):
        tab.run(f"goTo({share})")
        q = np.array([np.interp(share * along[-1], along, column) for column in made.path.T])
        np.testing.assert_allclose(tool_in_page(tab), tool_positions(made.robot, q)[0], atol=1e-6)


def test_forward_kinematics_of_every_robot(tab: Tab, urdf_file: Callable[..., str]) -> None:
    """Revolute, continuous and sliding joints, in a chain and placed anywhere."""
    inside = link_xml("a") + link_xml("b") + link_xml("c") + joint_xml("slide", "a", "b", "prismatic", "0 0.6 0.8")
    inside += joint_xml("turn", "b", "c", "continuous", "0 1 0", xyz="0.1 0.2 0.3")
    for robot in (*map(load, ROBOTS), Robot.load(urdf_file(inside))):
        q = random_q(robot, 4)
        tab.run(f"void (data.chain = {json.dumps(chain_data(robot))})")
        place = "placements(q).slice(1).map(f => columns(f.rotation, f.position))"
        frames = np.array(tab.run(f"{json.dumps(q.tolist())}.map(q => {place})"))
        frames = frames.reshape(4, robot.dof, 4, 4).transpose(0, 1, 3, 2)
        np.testing.assert_allclose(frames, joint_matrices(robot, q), atol=1e-9, err_msg=robot.name)


# playing


def test_play_moves_the_robot_where_it_stands(tab: Tab) -> None:
    start = tab.screenshot()
    tab.run("show('robot', false)")
    tab.drawn()
    robot = differ(start, tab.screenshot())  # the pixels that show the robot at the start
    tab.run("show('robot', true)")
    tab.click("#play")
    tab.run("new Promise(done => (function look() { share > 0.3 ? done(1) : setTimeout(look, 20); })())")
    tab.click("#play")
    assert dataset(tab, "playing") == "false"
    share = float(dataset(tab, "share"))
    assert 0.3 <= share < 1.0
    tab.drawn()
    later = tab.screenshot()
    assert differ(start, later)[STAGE][robot[STAGE]].mean() > 0.3
    assert differ(start, later)[STAGE].mean() < 0.3
    assert float(dataset(tab, "share")) == share, "paused"


def test_play_goes_on_to_the_end_and_starts_over(tab: Tab) -> None:
    tab.run("shownPath().seconds = 0.2, play()")
    tab.run("new Promise(done => (function look() { playing ? setTimeout(look, 20) : done(1); })())")
    assert dataset(tab, "share") == "1.0000"
    assert text(tab, "play") == "Play"
    tab.run("shownPath().seconds = 1000, play()")
    assert float(dataset(tab, "share")) < 0.01
    assert text(tab, "play") == "Pause"


def test_keys_and_scrubber(tab: Tab) -> None:
    tab.press(" ", "Space")
    assert dataset(tab, "playing") == "true"
    tab.press(" ", "Space")
    assert dataset(tab, "playing") == "false"
    drag(tab, "scrub", 500)
    assert dataset(tab, "share") == "0.5000"
    for key, expected in (("ArrowRight", "0.5100"), ("ArrowLeft", "0.5000"), ("ArrowLeft", "0.4900")):
        tab.press(key)
        assert dataset(tab, "share") == expected
    tab.click("#spark")  # in its middle
    assert float(dataset(tab, "share")) == pytest.approx(0.5, abs=0.01)
    tab.run("element('play').focus()")
    tab.press(" ", "Space")  # presses the button, once
    assert dataset(tab, "playing") == "true"


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


def test_interval_by_interval_with_keys_and_buttons(sweep_tab: Tab, tradeoff: Tradeoff) -> None:
    tab, last = sweep_tab, len(tradeoff.intervals) - 1
    drag(tab, "beta", 0.0)
    seen = [dataset(tab, "path")]
    tab.run("element('beta').focus()")
    for _ in range(last + 1):
        tab.press("ArrowRight")
        seen.append(dataset(tab, "path"))
    assert seen == [*map(str, range(last + 1)), str(last)]
    tab.click("#less")
    assert dataset(tab, "path") == str(last - 1)
    tab.run("element('beta').focus()")
    tab.press("Home")
    assert dataset(tab, "path") == "0"
    assert dataset(tab, "share") == "0.0000", "the keys of the slider do not move the robot"


def test_the_plan_page_has_all_betas_and_opens_at_its_own(window: Tab, tmp_path: Path) -> None:
    found = plan(replace(ARM, beta=0.03))
    write_plan_page(found, tmp_path / "plan.html")
    assert window.open(tmp_path / "plan.html"), window.console
    intervals = page_data_paths(window)
    assert intervals[0][0] == 0.0
    assert intervals[-1][1] == 1.0
    assert len(intervals) >= 4
    low, high = intervals[int(dataset(window, "path"))]
    assert low <= 0.03 <= high < 1.0
    assert text(window, "beta-now") == "0.0300"
    np.testing.assert_allclose(window.run("shownPath().waypoints"), found.path, atol=1e-8)


# roadmap


def test_nodes_and_edges_are_coloured_by_choice(tab: Tab, made: Plan) -> None:
    assert made.cost_to_go is not None
    n, x = len(made.roadmap.nodes), made.cost_to_go.x
    colours = "Array.from(drawn('roadmap/{}').geometry.attributes.color.array)"
    nodes = lambda: np.array(tab.run(colours.format("nodes"))).reshape(n, 3)  # noqa: E731
    looks = {}
    for choice, legend, values in (
        ("w", "manipulability w (m³)", made.roadmap.manipulability),
        ("cost", "cost-to-go (no unit)", x),
        ("component", "component", made.roadmap.components),
    ):
        choose(tab, "colour", choice)
        assert legend in text(tab, "legend-unit")
        looks[choice] = nodes()
        if choice != "component":
            assert text(tab, "high") == f"{values[np.isfinite(values)].max():.{3 if choice == 'w' else 2}f}"
            lightness = looks[choice].sum(axis=1)
            np.testing.assert_allclose(lightness[np.argsort(values)], np.sort(lightness), atol=0.02)
    assert len(np.unique(looks["component"], axis=0)) == made.roadmap.component_count
    assert np.abs(looks["w"] - looks["cost"]).max() > 0.2
    choose(tab, "colour", "w")
    ends = np.array(tab.run(colours.format("edges"))).reshape(-1, 8, 3)[:, [0, 7]]
    np.testing.assert_allclose(ends, looks["w"][made.roadmap.edges], atol=1e-6)


def test_cost_to_go_is_that_of_the_shown_path(sweep_tab: Tab, tradeoff: Tradeoff) -> None:
    choose(sweep_tab, "colour", "cost")
    for interval in (tradeoff.intervals[0], tradeoff.intervals[-1]):
        drag(sweep_tab, "beta", 0.5 * (interval.beta_min + interval.beta_max))
        x = interval.cost_to_go.x
        assert text(sweep_tab, "high") == f"{x[np.isfinite(x)].max():.2f}"


def test_switches(tab: Tab) -> None:
    for switch, seen in (("edges", "group('roadmap/edges').visible"), ("ellipsoid", "ellipsoid.visible")):
        assert tab.run(seen) is False
        before = tab.screenshot()
        tab.click(f"#{switch}")
        assert tab.run(seen) is True
        assert differ(before, tab.screenshot())[STAGE].mean() > 0.0005, switch
    tab.click("#collision")
    kinds = tab.run("Object.keys(data.names).filter(p => p.startsWith('robot/') && group(p).visible)")
    assert kinds
    assert all("/collision/" in path for path in kinds)
    choose(tab, "colour", "none")
    assert tab.run("group('roadmap/nodes').visible") is False


# manipulability


def test_the_ellipsoid_is_the_jacobians_and_moves(tab: Tab, made: Plan) -> None:
    scale, matrices = tab.run("scale"), []
    for share, q in ((0.0, made.path[0]), (1.0, made.path[-1])):
        tab.run(f"goTo({share})")
        matrix = np.array(tab.run("ellipsoid.matrix.toArray()")).reshape(4, 4).T
        linear = jacobian(made.robot, q)[:3]
        np.testing.assert_allclose(matrix[:3, 3], tool_positions(made.robot, q)[0], atol=1e-6)
        np.testing.assert_allclose((matrix[:3, :3] / scale) @ (matrix[:3, :3] / scale).T, linear @ linear.T, atol=5e-3)
        matrices.append(matrix)
    assert np.abs(matrices[0] - matrices[1]).max() > 0.01
    assert f"{scale} m drawn for 1 m/s" in tab.run("element('key').textContent")


def test_the_worst_points_are_marked_and_lead_there(tab: Tab, made: Plan) -> None:
    lowest = path_manipulability(made.robot, made.path).min()
    marks = tab.run("[...document.querySelectorAll('.mark')].map(m => m.textContent)")
    lines = tab.run("[...element('worst-list').children].map(m => m.textContent)")
    count = tab.run("shownPath().worst.length")
    assert len(marks) == len(lines) == count >= 1
    assert tab.run("shownPath().worst.map(p => p.w)")[0] == pytest.approx(lowest)
    for k, selector in enumerate(("#worst-list button", ".mark")):
        tab.run("goTo(0)")
        tab.click(selector)
        point = tab.run("shownPath().worst[0]")
        assert float(dataset(tab, "share")) == pytest.approx(point["share"], abs=1e-4), k
        np.testing.assert_allclose(tool_in_page(tab), point["position"], atol=2e-3)
    last = tab.run(f"dots.children[{count - 1}].getWorldPosition(new THREE.Vector3()).project(viewer.camera).toArray()")
    x, y = (last[0] + 1) / 2 * tab.run("innerWidth"), (1 - last[1]) / 2 * tab.run("innerHeight")
    mark = f"document.querySelectorAll('.mark')[{count - 1}]"
    box = tab.run(f"(b => [b.x, b.y, b.width, b.height])({mark}.getBoundingClientRect())")
    assert min(abs(box[0] + box[2] + 8 - x), abs(box[0] - 8 - x)) < 3, "left or right of its point"
    assert abs(box[1] + box[3] / 2 - y) < 3


# obstacles


def test_names_on_hover(tab: Tab) -> None:
    project = "drawn('obstacles/{}').getWorldPosition(new THREE.Vector3()).project(viewer.camera).toArray()"
    choose(tab, "colour", "none")
    named = 0
    for k, name in enumerate(tab.run("data.obstacles")):
        x, y, _ = tab.run(project.format(k))
        place = (x + 1) / 2 * tab.run("innerWidth"), (1 - y) / 2 * tab.run("innerHeight")
        tab.mouse(*place)
        assert tab.run("element('tip').hidden") is False, name
        named += text(tab, "tip") == name  # something else may stand before it
    assert named >= 4
    tab.mouse(960, 40)
    assert tab.run("element('tip').hidden") is True
    choose(tab, "colour", "w")
    tip = tab.run("nodeText(3)")
    assert "node 3" in tip
    assert "cost-to-go" in tip


def test_obstacles_are_marked_from_the_list(tab: Tab) -> None:
    tab.run("element('obstacle-section').open = true")
    tab.drawn()
    before = tab.screenshot()
    tab.click("#obstacles li:nth-child(6) button")
    assert dataset(tab, "marked") == "cabinet"
    tab.mouse(600, 10)
    assert differ(before, tab.screenshot())[STAGE].mean() > 0.005
    tab.click("#obstacles li:nth-child(6) button")
    assert dataset(tab, "marked") == ""
    tab.mouse(600, 10)
    assert differ(before, tab.screenshot())[STAGE].mean() < 0.0005


# other pages


def test_pages_without_a_path(window: Tab, tradeoff: Tradeoff, tmp_path: Path) -> None:
    found = plan(replace(ARM, nodes=30))
    found = replace(found, path=np.zeros((0, 2)), path_nodes=found.path_nodes[:0], cost=None)
    partial = replace(tradeoff, intervals=tradeoff.intervals[:2], complete=False, outcome=Outcome.INTERRUPTED)
    for html, paths, field, words in (
        (plan_page(replace(found, outcome=Outcome.NO_PATH)), 1, True, "were not connected"),
        (plan_page(replace(found, outcome=Outcome.INTERRUPTED, cost_to_go=None)), 1, False, "Interrupted"),
        (sweep_page(replace(tradeoff, intervals=(), outcome=Outcome.NO_PATH)), 1, False, "were not connected"),
        (sweep_page(partial), 2, True, "Interrupted"),
    ):
        (tmp_path / "page.html").write_text(html)
        assert window.open(tmp_path / "page.html"), window.console
        assert window.console == []
        assert words in text(window, "message")
        assert window.run("data.paths.length") == paths
        assert window.run("element('player').hidden && element('tradeoff').hidden") is (paths == 1)
        assert window.run("element('colour').querySelector('[value=cost]') !== null") is field


def test_a_state_in_collision_is_seen(window: Tab, tmp_path: Path) -> None:
    checker = make_checker(load("iiwa14"), Scene.load("paper"))
    report = inspect_state(checker, np.array([0, 1.9, 0, -0.4, 0, 3.0, 0]))
    assert report.contacts
    (tmp_path / "state.html").write_text(state_page(report))
    assert window.open(tmp_path / "state.html"), window.console
    assert window.console == window.requests == []
    assert str(report.contacts[0]) in text(window, "message")
    red = window.run("Object.keys(data.names).filter(p => drawn(p).material.color.getHex() === 0xe61f1f)")
    names = window.run("data.names")
    assert {names[path] for path in red} == {name for pair in report.contacts for name in (pair.first, pair.second)}
    wrong = window.run("[...document.querySelectorAll('tr.wrong')].map(r => r.textContent)")
    assert any("iiwa14_joint_6" in row for row in wrong)
    assert any("contact" in row for row in wrong)


# the file


def test_a_damaged_page_fails(window: Tab, plan_file: Path, tmp_path: Path) -> None:
    """The negative control: what the tests above rely on does notice."""
    whole, damaged = plan_file.read_text(), tmp_path / "damaged.html"
    at = whole.index('id="scene">') + 5000
    for broken in (whole[:at] + whole[at + 4000 :], whole.replace('id="scrub"', 'id="srub"')):
        damaged.write_text(broken)
        assert not window.open(damaged)
        window.drawn()
        assert window.console


def test_a_page_that_asks_the_network_is_noticed(window: Tab, plan_file: Path, tmp_path: Path) -> None:
    whole, nosy = plan_file.read_text(), tmp_path / "nosy.html"
    nosy.write_text(whole.replace("</body>", '<img src="http://127.0.0.1:9/pixel.png"></body>'))
    assert window.open(nosy)
    window.drawn()
    assert window.console, "the page's own policy forbids it"
    loose = whole.replace("img-src data: blob:", "img-src *")
    nosy.write_text(loose.replace("</body>", '<img src="http://127.0.0.1:9/pixel.png"></body>'))
    assert window.open(nosy)
    window.drawn()
    assert window.requests == ["http://127.0.0.1:9/pixel.png"]


def test_text_from_files_cannot_become_markup(window: Tab, tmp_path: Path) -> None:
    nasty = "</script><img src=x onerror=alert(1)>"
    (tmp_path / "s.yaml").write_text(
        f"name: {json.dumps(nasty)}\nobstacles:\n"
        f"  - {{name: {json.dumps(nasty)}, type: sphere, radius: 0.05, position: [2, 2, 2]}}\n"
    )
    checker = make_checker(load("planar_2r"), Scene.load(str(tmp_path / "s.yaml")))
    path = tmp_path / "state.html"
    path.write_text(state_page(inspect_state(checker, np.zeros(2))))
    assert nasty not in path.read_text()
    assert page_data(path)["obstacles"] == [nasty]
    assert window.open(path), window.console
    assert window.run("document.querySelector('h1').textContent") == f"planar_2r in {nasty}"
    assert window.run("document.querySelector('#obstacles button').textContent") == nasty
    assert window.run("document.querySelectorAll('img').length") == 0


@pytest.mark.parametrize(("robot", "scene", "most"), [("iiwa14", "paper", 3_000_000), ("panda", "shelf", 8_000_000)])
def test_size_with_a_roadmap_of_1012_nodes(made: Plan, robot: str, scene: str, most: int) -> None:
    """Random nodes are worse to compress than a grown roadmap's; ten paths are more than a sweep mostly has."""
    arm, rng, n = load(robot), np.random.default_rng(0), 1012
    nodes = random_q(arm, n)
    edges = np.sort(rng.choice(n, size=(2029, 2)), axis=1)
    length = rng.random(2029)
    roadmap = replace(
        made.roadmap,
        nodes=nodes,
        edges=edges[edges[:, 0] < edges[:, 1]],
        proven=np.ones(2029, bool)[edges[:, 0] < edges[:, 1]],
        manipulability=rng.random(n),
        joint_length=length[edges[:, 0] < edges[:, 1]],
        tool_length=length[edges[:, 0] < edges[:, 1]],
    )
    paths = [ShownPath(nodes[12 * k : 12 * k + 12], [], (k / 10, (k + 1) / 10), rng.random(n)) for k in range(10)]
    content = Content(arm, Scene.load(scene), "", nodes[0], roadmap=roadmap, paths=paths, beta=0.5)
    assert 500_000 < len(page(content).encode()) < most
