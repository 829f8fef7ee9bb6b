"""The page in a real browser: ready, offline, and everything on it does what it says."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import pytest

from planner.collision import make_checker
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import jacobian
from planner.models.moving import KnownMotion, MovingObstacle
from planner.models.poses import pose
from planner.models.robot import Robot, load_visuals
from planner.models.scene import Scene
from planner.models.shapes import Box, Cylinder, Obstacle, Sphere
from planner.paths.measure import path_manipulability
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.reasons import Separated
from planner.problem.request import PlanRequest, TimingRequest
from planner.tradeoff.alternatives import ShownPath, with_alternatives
from planner.tradeoff.sweep import Tradeoff, sweep
from planner.trajectory.timing import time_path
from planner.view.drawing import joint_matrices
from planner.view.motion import chain_data
from planner.view.page import Content, page
from planner.view.state import inspect_state, state_page
from tests.browser import Tab, browser
from tests.linkages import random_linkage
from tests.worlds import ROBOTS, joint_xml, link_xml, load, planar_trap, random_q

STAGE = (slice(0, 525), slice(345, None))  # of a picture: neither panel nor player
ARM = PlanRequest(robot="planar_2r", scene="empty", start="q:-2,1.5", goal="q:2,-2", nodes=150, seed=4)


@pytest.fixture(scope="module")
def made(solved: Plan) -> Plan:
    return with_alternatives(solved)


@pytest.fixture(scope="module")
def plan_file(made: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "plan.html"
    path.write_text(made.page())
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


def text_content(tab: Tab, element: str) -> str:
    """Its text letter by letter, folded or not."""
    return tab.run(f"element('{element}').textContent")


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


# playing


def test_play_moves_the_robot_where_it_stands(tab: Tab) -> None:
    start = tab.screenshot()
    tab.run("show('robot', false)")
    tab.drawn()
    robot = differ(start, tab.screenshot())  # the pixels that show the robot at the start
    tab.run("show('robot', true), shownPath().seconds = 1000")  # a busy machine draws a frame a second
    beyond = "new Promise(done => (function look() {{ share > {} ? done(1) : setTimeout(look, 20); }})())".format
    tab.click("#play")
    tab.run(beyond(0))
    tab.run("goTo(0.35)")
    tab.run(beyond(0.35))  # it plays on from where it is put
    tab.click("#play")
    assert dataset(tab, "playing") == "false"
    share = float(dataset(tab, "share"))
    assert 0.35 <= share < 0.5
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


def test_a_motion_is_shown_in_time_with_plots(window: Tab, made: Plan, tmp_path: Path) -> None:
    """Charts of all joints and the clearance; the pointer over them moves the robot to that moment."""
    trajectory = time_path(made.path, made.checker)
    file = tmp_path / "motion.html"
    file.write_text(replace(made, trajectory=trajectory).page())
    assert window.open(file), window.console
    window.run("showPlots(true)")
    assert window.run("document.querySelectorAll('#plots svg').length") == 4
    assert window.run("document.querySelectorAll('#plots .way').length") == 3 * made.robot.dof + 1
    box = "document.querySelector('#plots svg').getBoundingClientRect()"
    event = f"new PointerEvent('pointermove', {{ clientX: {box}.left + 0.25 * {box}.width, bubbles: true }})"
    window.run(f"element('plots').dispatchEvent({event})")
    assert float(dataset(window, "share")) == pytest.approx(0.25, abs=2e-3)
    assert text(window, "now").endswith(f"{0.25 * trajectory.duration:.2f} s")
    lowest = path_manipulability(made.robot, trajectory.at(np.linspace(0, trajectory.duration, 1001))).min()
    assert window.run("shownPath().worst[0].w") == pytest.approx(lowest, rel=1e-3)
    assert "lowest manipulability of the motion" in text(window, "worst")
    assert "smallest" not in text(window, "panel")  # it is said once
    assert text(window, "panel").count(window.run("short(shownPath().worst[0].w)")) == 1
    q = window.run("configurationAt(shownPath(), share)")
    np.testing.assert_allclose(q, trajectory.at(0.25 * trajectory.duration)[0], atol=2e-2)
    assert window.run(
        "element('panel').getBoundingClientRect().bottom <= element('player').getBoundingClientRect().top"
    )
    window.run("showPlots(false)")
    assert window.run("element('plots').hidden")


def test_a_millimetre_of_clearance_is_seen_beside_133(tab: Tab) -> None:
    frame = tab.run("""(plot => {
        element('plots').hidden = false;
        element('plots').append(plot);
        const at = [...plot.querySelectorAll('.way')].map(w => w.getAttribute('d').match(/[\\d.]+ [\\d.]+/g)
            .map(p => Number(p.split(' ')[1]))), height = plot.querySelector('svg').getBoundingClientRect().height;
        const said = [...plot.querySelectorAll('.tick')].map(t => [t.textContent, parseFloat(t.style.top)]);
        plot.remove();
        element('plots').hidden = true;
        return { at: at[0], height, said };
    })(clearanceChart([0.133, 0.001, 0.01, 0]))""")
    most, one, ten, none = (place * frame["height"] / 100 for place in frame["at"])  # pixels from the top
    assert (most, none) == pytest.approx((0, frame["height"]), abs=0.1)
    assert none - one > 6
    assert one - ten > 10
    assert [name for name, _ in frame["said"]] == ["1", "10", "100"]
    assert frame["said"][0][1] == pytest.approx(frame["at"][1], abs=0.1)


def test_a_visitor_is_told_what_beta_and_w_are(sweep_tab: Tab) -> None:
    for part, sentence in (("tradeoff", "β weighs the path's two costs"), ("worst", "w, the manipulability, says how")):
        assert sentence in text(sweep_tab, part)


@pytest.mark.parametrize("found", [True, False])
def test_the_opening_view_sees_start_goal_and_path(window: Tab, made: Plan, tmp_path: Path, found: bool) -> None:
    """Past a wall that stands between them and where the page opens otherwise."""
    wall = Obstacle("wall", Box((3.0, 0.02, 6.0)), pose([0.53 * 2.2, -0.78 * 2.2, 0.0], [0, 0, 0.6]))
    content = Content(
        made.robot,
        Scene("walled", (wall,)),
        "",
        made.path[0],
        roadmap=made.roadmap,
        paths=[ShownPath(made.path, [])] if found else [],
    )
    file = tmp_path / "page.html"
    file.write_text(page(content))
    assert window.open(file), window.console
    seen = "seenFrom(viewer.camera.position.clone(), places, [group('obstacles/0')])"
    whole = "places.reduce((sum, { weight }) => sum + weight, 0)"
    assert window.run(f"(places => {seen} === {whole})(placesToSee(shownPath()))")
    assert window.run("placesToSee(shownPath()).length") == (13 if found else 1 + len(made.roadmap.goals))
    before = "viewer.controls.target.clone().add(new THREE.Vector3(0.53, 0.33, 0.78).normalize().multiplyScalar(9))"
    from_front = seen.replace("viewer.camera.position.clone()", before)
    assert window.run(f"(places => {from_front} < {whole})(placesToSee(shownPath()))"), "the wall is in the way there"


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
    found = with_alternatives(plan(replace(ARM, beta=0.03)))
    (tmp_path / "plan.html").write_text(found.page())
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
            known = np.isfinite(values)  # no edge that keeps so much clearance leads on from the others: they are grey
            lightness = looks[choice][known].sum(axis=1)
            np.testing.assert_allclose(lightness[np.argsort(values[known])], np.sort(lightness), atol=0.02)
            assert (np.ptp(looks[choice][~known], axis=1) < 0.02).all()
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
    assert "lowest manipulability of the path" in text(tab, "worst")
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


def on_screen(tab: Tab) -> np.ndarray:
    """(k, 2) pixels: vertices of all that is drawn of the robot now, and of its tool's path."""
    places = """[...Object.keys(data.names).filter(p => p.startsWith('robot/')), 'paths/' + current]
        .filter(p => group(p).visible).flatMap(p => {
            const mesh = drawn(p), at = mesh.geometry.attributes.position, step = Math.ceil(at.count / 500), seen = [];
            mesh.updateWorldMatrix(true, false);
            for (let k = 0; k < at.count; k += step) {
                const v = new THREE.Vector3().fromBufferAttribute(at, k).applyMatrix4(mesh.matrixWorld);
                v.project(viewer.camera);
                seen.push([(v.x + 1) / 2 * innerWidth, (1 - v.y) / 2 * innerHeight]);
            }
            return seen;
        })"""
    return np.array(tab.run(places))


def assert_in_view(tab: Tab, shares: tuple[float, ...] = (0.0, 0.3, 0.7, 1.0)) -> None:
    """Robot and path lie beside the panel and above the player, all along the way, and fill a fair part of that."""
    free = tab.run("freeArea()")
    widest = 0.0
    for share in shares:
        tab.run(f"goTo({share})")
        tab.drawn()
        low, high = on_screen(tab).min(axis=0), on_screen(tab).max(axis=0)
        assert low[0] >= free["x"] - 1
        assert low[1] >= free["y"] - 1
        assert high[0] <= free["x"] + free["width"] + 1
        assert high[1] <= free["y"] + free["height"] + 1
        widest = max(widest, float((high - low).max()) / min(free["width"], free["height"]))
    assert widest > 0.3


def test_on_a_phone_the_robot_is_seen_and_the_panel_unfolds(phone: Tab) -> None:
    assert phone.run("[innerWidth, document.documentElement.scrollWidth]") == [390, 390], "nothing sticks out"
    assert phone.run("element('body').hidden") is True
    assert "planar_2r in empty" in text(phone, "panel")
    panel = phone.run("(b => b.height / innerHeight)(element('panel').getBoundingClientRect())")
    assert panel < 0.2
    assert_in_view(phone)
    picture = phone.screenshot()
    phone.run("show('robot', false)")
    phone.drawn()
    assert differ(picture, phone.screenshot()).mean() > 0.002
    phone.click("#fold")
    assert phone.run("element('body').hidden") is False
    assert "manipulability cost" in text(phone, "numbers")
    assert phone.run("element('panel').getBoundingClientRect().bottom <= element('player').getBoundingClientRect().top")
    assert phone.run("document.documentElement.scrollWidth") == 390
    top, bottom = phone.run("['panel', 'player'].map(name => element(name).getBoundingClientRect()).map(b => b.height)")
    assert top < 0.5 * (844 - bottom), "half of the scene stays"
    assert_in_view(phone)
    phone.click("#fold")
    assert phone.run("element('body').hidden") is True
    assert_in_view(phone)


def test_the_panel_folds_on_a_desk_too(tab: Tab) -> None:
    assert tab.run("element('body').hidden") is False
    tab.click("#fold")
    assert tab.run("element('body').hidden") is True
    assert tab.run("freeArea().x") == 0
    assert tab.run("element('fold').getAttribute('aria-expanded')") == "false"


def test_robot_and_path_are_in_view(tab: Tab, window: Tab, tmp_path: Path, urdf_file: Callable[..., str]) -> None:
    """Also a robot with a body that is higher than its arm is long, and another arm that is not planned."""
    assert_in_view(tab)
    inside = f'<link name="body">{visual_xml("0.4 0.4 2.4")}</link><link name="other">{visual_xml("0.2 3 0.2")}</link>'
    inside += joint_xml("mount", "body", "other", "fixed", xyz="0 0 1") + link_xml("hand")
    inside += f'<link name="arm">{visual_xml("0.1 0.1 0.4")}</link>' + joint_xml("turn", "body", "arm", xyz="0.3 0 0.8")
    inside += joint_xml("grip", "arm", "hand", axis="0 1 0", xyz="0 0 0.2")
    robot = Robot.load(urdf_file(inside), tool="hand")
    path = np.array([[-1.0, 0.0], [1.0, 1.0]])
    content = Content(robot, Scene("none", ()), "", path[0], paths=[ShownPath(path, [])])
    (tmp_path / "page.html").write_text(page(content))
    assert window.open(tmp_path / "page.html"), window.console
    assert_in_view(window)


def visual_xml(size: str) -> str:
    return f'<visual><geometry><box size="{size}"/></geometry></visual>'


@pytest.mark.parametrize("robot", ["ur5", "panda", "iiwa14"])
def test_light_robots_are_not_overexposed(window: Tab, tmp_path: Path, robot: str) -> None:
    arm = load(robot)
    (tmp_path / "page.html").write_text(page(Content(arm, Scene("none", ()), "", arm.home)))
    assert window.open(tmp_path / "page.html"), window.console
    whole = window.screenshot()
    window.run("show('robot', false)")
    window.drawn()
    bright = whole[differ(whole, window.screenshot())].min(axis=1)
    assert (bright > 250).mean() < 0.01
    assert np.percentile(bright, 90) - np.percentile(bright, 10) > 50, "nor flat"


# the curve of w, and the joints


def test_the_curve_has_an_axis_a_unit_and_the_floor(window: Tab, tmp_path: Path) -> None:
    path = np.array([[-2.0, 1.5], [0.0, 0.5], [1.0, 1.2]])
    robot = load("planar_2r")
    content = Content(robot, Scene("none", ()), "", path[0], paths=[ShownPath(path, [])], floor=0.05)
    (tmp_path / "page.html").write_text(page(content))
    assert window.open(tmp_path / "page.html"), window.console
    labels = window.run("[...element('heights').children].map(s => [s.textContent, parseFloat(s.style.top)])")
    numbers = dict(labels)
    floor = numbers.pop("floor 0.05")
    assert [*numbers] == ["0.00", "0.05", "0.10", "w 0.15 m²"]
    values = [float(words.replace("w ", "").replace(" m²", "")) for words in numbers]
    heights = np.array([*numbers.values()])
    slope = np.diff(heights) / np.diff(values)
    np.testing.assert_allclose(slope, slope[0], rtol=1e-6)
    assert floor == pytest.approx(heights[0] + 0.05 * slope[0])
    curve = window.run("element('spark').querySelector('.curve').getAttribute('d')")
    lowest = max(float(point.split()[1]) for point in curve.split("L")[1:-1])
    w = path_manipulability(robot, path)
    assert lowest == pytest.approx(heights[0] + w.min() * slope[0], abs=0.2)
    assert f"M0 {floor:.2f}H1000" == window.run("element('spark').querySelector('.floor').getAttribute('d')")
    whole = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert text(window, "shares").split() == [
        "0",
        "%",
        "25",
        "%",
        "50",
        "%",
        "75",
        "%",
        *f"100 % of {whole:.2f} rad".split(),
    ]


def test_a_page_without_a_floor_has_none(tab: Tab) -> None:
    assert "floor" not in text(tab, "heights")
    assert tab.run("element('spark').querySelector('.floor')") is None


def test_joints_are_shown_against_their_limits(tab: Tab, made: Plan) -> None:
    robot, path = made.robot, made.path
    rows = tab.run("[...element('joints').rows].map(r => [...r.cells].map(c => c.textContent))")
    assert [row[0] for row in rows] == list(robot.joints)
    assert [float(row[3].removeprefix("± ")) for row in rows] == pytest.approx(robot.upper, abs=0.005)
    tab.run("goTo(1)")
    values = tab.run("[...document.querySelectorAll('#joints .value')].map(c => c.textContent)")
    assert [float(value.replace("−", "-").removesuffix(" rad")) for value in values] == pytest.approx(
        path[-1], abs=0.006
    )
    for j, line in enumerate(tab.run("[...document.querySelectorAll('#joints .way')].map(p => p.getAttribute('d'))")):
        heights = np.array([float(point.split()[1]) for point in line[1:].split("L")])
        shares = (path[:, j] - robot.lower[j]) / (robot.upper[j] - robot.lower[j])
        np.testing.assert_allclose(heights, 100 - 100 * shares, atol=0.01)
    room = np.minimum(path - robot.lower, robot.upper - path)
    row, j = np.unravel_index(room.argmin(), room.shape)
    assert f"{robot.joints[j]} is nearest to a limit: {room[row, j]:.2f} rad" in text(tab, "joint-limit")


def test_joints_that_turn_freely_have_no_limits(window: Tab, tmp_path: Path) -> None:
    arm = load("kinova")
    (tmp_path / "page.html").write_text(page(Content(arm, Scene("none", ()), "", arm.home)))
    assert window.open(tmp_path / "page.html"), window.console
    limits = window.run("[...element('joints').rows].map(r => r.cells[3].textContent)")
    assert [words == "turns freely" for words in limits] == arm.continuous.tolist()


# two paths at once, and those of no beta


def test_two_paths_side_by_side(sweep_tab: Tab, tradeoff: Tradeoff) -> None:
    tab, last = sweep_tab, len(tradeoff.intervals) - 1
    drag(tab, "beta", 0.0)
    tab.run("goTo(0.5)")
    before = tab.screenshot()
    choose(tab, "compare", str(last))
    assert dataset(tab, "compared") == str(last)
    visible = tab.run("data.paths.map((_, k) => group('paths/' + k).visible)")
    assert [k for k, seen in enumerate(visible) if seen] == [0, last]
    for name in ("manipulability_cost", "distance_cost"):
        for k, column in ((0, 1), (last, 2)):
            cells = tab.run(f"[...element('numbers').rows].map(r => r.cells[{column}].textContent)")
            assert f"{getattr(tradeoff.intervals[k], name):.4f}" in cells
    assert differ(before, tab.screenshot())[STAGE].mean() > 0.002
    assert tab.run("ghost.visible") is True
    # the second robot stands where the second path is
    offset = tab.run("data.chain.tool.offset")
    place = f"new THREE.Vector3(...{offset}).applyMatrix4((g => (g.updateMatrix(), g.matrix))(ghost.children.at(-1)))"
    other = tradeoff.intervals[last].path
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(other, axis=0), axis=1))])
    q = np.array([np.interp(0.5 * along[-1], along, column) for column in other.T])
    np.testing.assert_allclose(tab.run(f"{place}.toArray()"), tool_positions(tradeoff.robot, q)[0], atol=1e-6)
    w = path_manipulability(tradeoff.robot, np.array([q, q]))[0]
    assert f"{w:.4f}" in text(tab, "now-other")
    drag(tab, "beta", 1.0)  # the path beside itself
    assert dataset(tab, "compared") == ""
    assert tab.run("ghost.visible") is False
    drag(tab, "beta", 0.0)
    choose(tab, "compare", "")
    assert text(tab, "now-other") == ""
    assert not differ(before, tab.screenshot())[STAGE].any()


def test_a_path_chosen_by_its_costs_sets_beta(sweep_tab: Tab, tradeoff: Tradeoff) -> None:
    for k, interval in enumerate(tradeoff.intervals):
        sweep_tab.run(f"element('costs').querySelectorAll('g')[{k}].dispatchEvent(new MouseEvent('click'))")
        assert dataset(sweep_tab, "path") == str(k)
        assert interval.beta_min <= float(dataset(sweep_tab, "beta")) <= interval.beta_max


# other pages


def test_pages_without_a_path(window: Tab, tradeoff: Tradeoff, tmp_path: Path) -> None:
    found = plan(replace(ARM, nodes=30))
    found = replace(found, path=np.zeros((0, 2)), path_nodes=found.path_nodes[:0], cost=None)
    partial = replace(tradeoff, intervals=tradeoff.intervals[:2], complete=False, outcome=Outcome.INTERRUPTED)
    for html, paths, field, words in (
        (replace(found, outcome=Outcome.NO_PATH).page(), 1, True, "were not connected"),
        (replace(found, outcome=Outcome.INTERRUPTED, cost_to_go=None).page(), 1, False, "Interrupted"),
        (replace(tradeoff, intervals=(), outcome=Outcome.NO_PATH).page(), 1, False, "were not connected"),
        (partial.page(), 2, True, "Interrupted"),
    ):
        (tmp_path / "page.html").write_text(html)
        assert window.open(tmp_path / "page.html"), window.console
        assert window.console == []
        assert words in text(window, "message")
        assert window.run("data.paths.length") == paths
        assert window.run("element('player').hidden && element('tradeoff').hidden") is (paths == 1)
        assert window.run("element('colour').querySelector('[value=cost]') !== null") is field


def test_what_separates_start_from_goal_is_red(window: Tab, tmp_path: Path) -> None:
    request = replace(ARM, scene=str(planar_trap(tmp_path)), start="q:0.2,0.3", goal="q:3.0,-0.3", nodes=30)
    found = plan(request)
    assert isinstance(found.reason, Separated)
    found.save(tmp_path)
    assert window.open(tmp_path / "plan.html"), window.console
    assert window.console == window.requests == []
    assert found.reason.sentence == text(window, "message")
    red = window.run("Object.keys(data.names).filter(p => drawn(p).material.color.getHex() === 0xe61f1f)")
    names = window.run("data.names")
    assert [names[path] for path in red] == list(found.reason.obstacles)
    assert "separates start from goal" in text_content(window, "key")
    whole = window.screenshot()
    window.run("show('gap', false)")
    window.drawn()
    assert differ(whole, window.screenshot()).mean() > 0.0005


def test_what_moves_is_where_it_is_at_the_time_shown(window: Tab, tmp_path: Path) -> None:
    way = [pose([1.2, 0.9, 0]), pose([0.5, 1.2, 0], [0.4, 0, 2.5]), pose([-1.5, 1.5, 0], [0, 0, -2.9])]
    cart = MovingObstacle("cart", Cylinder(0.1, 0.3), KnownMotion([0, 0.6, 30], way))
    found = plan(replace(ARM, scene=Scene("cart", moving=(cart,))), timing=TimingRequest())
    found.save(tmp_path)
    assert window.open(tmp_path / "plan.html"), window.console
    assert found.trajectory is not None
    upright = pose(rpy=[np.pi / 2, 0, 0])  # three.js cylinders lie on y
    seen = []
    for share in (0.0, 0.15, 0.8, 1.0):
        window.run(f"void goTo({share})")
        window.drawn()
        seen.append(window.screenshot()[STAGE])
        matrix = window.run("viewer.scene.updateMatrixWorld(true), drawn('moving/0/shape').matrixWorld.toArray()")
        there = cart.motion.at(share * found.trajectory.duration)[0] @ upright
        shown = pose(rpy=[np.pi / 2, 0, 0]) @ np.array(matrix).reshape(4, 4).T  # meshcat's world is y-up
        np.testing.assert_allclose(shown, there, atol=1e-6)
    assert differ(seen[0], seen[2]).mean() > 0.0005
    assert "the way of what moves" in text_content(window, "key")
    assert window.run("data.names['moving/0/shape']") == "cart"
    window.run("element('obstacles').querySelector('button').click()")
    assert window.run("root.dataset.marked") == "cart"
    assert window.run("element('tradeoff').hidden")
    assert window.console == window.requests == []


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


HOSTILE = (
    "@@VIEWER@@",
    "@@DATA@@ @@TITLE@@ @@",
    "<!--<script>",
    "--><script>ran = 1</script><!--",
    "</script><script>ran = 1</script>",
    "</SCRIPT ><script >ran = 1</script>",
    "</title></style><script>ran = 1</script>",
    "<img src=x onerror='ran = 1'>",
    "<svg/onload=ran=1>",
    "\"'; ran = 1; //",
    "${ran = 1}`+(ran=1)+`",
    "\\u003cscript>ran = 1</script>\\",
    "]]>&lt;script&gt;ran = 1&lt;/script&gt;&amp;",
    "javascript:ran=1",
    "a\u2028ran = 1\u2029b\x85c",
    "__proto__",
    "constructor",
    "[bold]{0} %s $1 \\1 \\g<0>",
    "\u202egnp.tra 🤖 e\u0301 \U0001f469\u200d\U0001f680",
)


@pytest.fixture
def named_robot(tmp_path: Path) -> Callable[[str], Robot]:
    """An arm of two joints in a folder, all of which are called alike as far as files and URDFs can."""

    def make(name: str) -> Robot:
        text = link_xml("base") + link_xml("a", '<sphere radius="0.1"/>') + joint_xml("turn", "base", "a", xyz="1 0 0")
        text += link_xml("b", '<sphere radius="0.1"/>') + joint_xml("bend", "a", "b", xyz="0.5 0 0")
        for plain in ("base", "a", "b", "turn", "bend"):
            text = text.replace(f'"{plain}"', quoteattr(f"{name}{plain}"))
        folder = tmp_path / name.replace("/", "")
        folder.mkdir()
        (folder / "arm.urdf").write_text(f'<robot name={quoteattr(name)} version="1.0">{text}</robot>')
        return Robot.load(str(folder / "arm.urdf"))

    return make


def assert_harmless(window: Tab, html: str, name: str, path: Path) -> None:
    """The page is drawn, says the name letter by letter, and nothing in the name has become markup or run."""
    path.write_text(html)
    assert window.open(path), window.console
    assert window.console == window.requests == []
    assert window.run("typeof ran") == "undefined"
    assert window.run("document.querySelector('h1').textContent").endswith(f" in {name}")
    assert window.run("document.title").endswith(f" in {name}")
    assert window.run("document.querySelector('#obstacles button').textContent") == name
    assert window.run("[document.images.length, document.scripts.length]") == [0, 4]


@pytest.mark.parametrize("name", HOSTILE)
def test_no_name_breaks_the_page_or_runs_in_it(
    window: Tab, tmp_path: Path, named_robot: Callable[[str], Robot], name: str
) -> None:
    """A state's page speaks of scene, obstacles, links and joints; two links stand in the obstacle."""
    robot = named_robot(name)
    scene = Scene(name, (Obstacle(name, Sphere(2.0), pose()),))
    html = state_page(inspect_state(make_checker(robot, scene), np.array([0.0, 2.0])))
    assert_harmless(window, html, name, tmp_path / "state.html")
    assert window.run("document.querySelector('h1').textContent") == f"{robot.name} in {name}"
    assert f"'{name}a' and '{name}' touch" in text_content(window, "message")
    assert f"{name}bend" in text_content(window, "joints")
    window.run("element('viewer').dispatchEvent(new PointerEvent('pointermove', {clientX: 640, clientY: 300}))")
    window.drawn()
    assert window.run("Object.values(data.names)").count(name) == 1


def test_names_that_break_nothing_in_a_plan(window: Tab, made: Plan, tradeoff: Tradeoff, tmp_path: Path) -> None:
    name = "".join(HOSTILE)
    obstacles = tuple(replace(item, name=f"{name}{k or ''}") for k, item in enumerate(made.scene.obstacles))
    scene = replace(made.scene, name=name, obstacles=obstacles)
    assert_harmless(window, replace(made, scene=scene).page(), name, tmp_path / "plan.html")
    sweep = replace(tradeoff, scene=scene, robot=replace(tradeoff.robot, name=name))
    assert_harmless(window, sweep.page(), name, tmp_path / "sweep.html")


def test_a_script_in_a_name_would_be_noticed(window: Tab, tmp_path: Path) -> None:
    """The negative control: in a page that does not escape, the same names run."""
    html = state_page(inspect_state(make_checker(load("planar_2r"), Scene("safe", ())), np.zeros(2)))
    path = tmp_path / "state.html"
    path.write_text(html.replace("planar_2r in safe</h1>", f"{HOSTILE[4]}</h1>"))
    window.open(path)
    assert window.run("typeof ran") == "number"


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
