"""What a page is made of, without a browser: motion, worst points, ellipsoids, alternatives; notebook cells."""

from __future__ import annotations

import html
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from IPython.core.interactiveshell import InteractiveShell

import planner
from planner.base.errors import FileError, OptionError
from planner.base.request import PlanRequest
from planner.base.resolutions import SHOWN_STATES
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.motion.timing import time_path
from planner.paths.measure import path_manipulability
from planner.plan_record import Plan, shown_paths
from planner.planning import plan, with_alternatives
from planner.roadmap.storage import save_roadmap
from planner.tradeoff.page import of_tradeoff
from planner.tradeoff.sweep import Tradeoff, sweep
from planner.view.motion import configurations_at, ellipsoids, motion_data, path_shares, worst_points
from planner.view.shown_path import shown_motion
from tests.browser import page_data
from tests.worlds import ROBOTS, checker_of, load, random_q

TASK = PlanRequest(robot="planar_2r", scene="empty", start="q:-2,1.5", goal="q:2,-2", nodes=150, seed=4)


@pytest.fixture(scope="module")
def made() -> Plan:
    return with_alternatives(plan(TASK))


@pytest.fixture(scope="module")
def tradeoff(made: Plan, tmp_path_factory: pytest.TempPathFactory) -> Tradeoff:
    path = tmp_path_factory.mktemp("roadmap") / "roadmap.npz"
    save_roadmap(made.roadmap, path)
    return sweep(replace(TASK, roadmap=path))


# motion


def test_motion_is_even_in_joint_space(solved: Plan) -> None:
    shares, total = path_shares(solved.path)
    q = configurations_at(solved.path, shares, np.linspace(0, 1, SHOWN_STATES))
    np.testing.assert_array_equal(q[[0, -1]], solved.path[[0, -1]])
    steps = np.linalg.norm(np.diff(q, axis=0), axis=1)
    assert steps.max() <= total / (SHOWN_STATES - 1) * (1 + 1e-9)
    data = motion_data(solved.robot, solved.path)
    np.testing.assert_allclose(data["w"], manipulability(solved.robot, q), atol=1e-7)
    np.testing.assert_allclose(data["ellipsoids"][60], ellipsoids(solved.robot, q[[120]])[0], atol=1e-4)


def test_a_motion_is_even_in_time(solved: Plan) -> None:
    trajectory = time_path(solved.path, solved.checker)
    data = motion_data(solved.robot, solved.path, shown_motion(trajectory, solved.checker))
    assert data["seconds"] == data["motion"]["duration"] == trajectory.duration
    q = trajectory.at(np.linspace(0.0, trajectory.duration, SHOWN_STATES))
    np.testing.assert_allclose(data["waypoints"], q, atol=1e-8)
    np.testing.assert_allclose(data["w"], manipulability(solved.robot, q), atol=1e-6)
    for kind in ("velocity", "acceleration"):
        shares = np.array(data["motion"][kind])
        assert shares.shape == (solved.robot.dof, SHOWN_STATES)
        assert 0.9 < np.abs(shares).max() <= 1.0 + 1e-4
    assert min(data["motion"]["clearance"]) > 0
    assert data["worst"][0]["w"] <= min(data["w"]) + 1e-7  # as the page rounds them


def test_a_path_of_one_configuration_stands_still() -> None:
    data = motion_data(load("ur5"), load("ur5").home[None])
    assert data["seconds"] == 0.0
    assert data["shares"] == [0.0]
    assert len(set(data["w"])) == 1
    assert len(data["worst"]) == 1


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_ellipsoid_holds_the_velocities_that_unit_joint_velocities_reach(robot: str) -> None:
    """Against finite differences of the tool's place: the largest stretch in any direction is its support there."""
    arm, rng = load(robot), np.random.default_rng(0)
    q = random_q(arm, 3)
    step = 1e-6
    for row, (xx, yy, zz, xy, xz, yz) in zip(q, ellipsoids(arm, q), strict=True):
        root = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        ahead, behind = (tool_positions(arm, row + sign * step * np.eye(arm.dof)) for sign in (1, -1))
        numeric = ((ahead - behind) / (2 * step)).T
        directions = rng.normal(size=(20, 3))
        np.testing.assert_allclose(
            np.linalg.norm(directions @ numeric, axis=1), np.linalg.norm(directions @ root, axis=1), atol=1e-6
        )
        assert np.linalg.eigvalsh(root).min() >= -1e-9


def test_worst_points_are_the_lowest_minima(solved: Plan) -> None:
    robot, path = solved.robot, solved.path
    points = worst_points(robot, path)
    assert points[0].w == path_manipulability(robot, path).min()
    shares, _ = path_shares(path)
    for point in points:
        around = np.clip(point.share + np.array([-0.004, 0.0, 0.004]), 0, 1)
        w = manipulability(robot, configurations_at(path, shares, around))
        assert w[1] == pytest.approx(point.w)
        assert w[1] <= w.min() * (1.0 + 1e-4)  # the minimum is that of samples 0.01 rad apart
    assert len(points) < 2 or (points[0].w <= points[1].w and abs(points[0].share - points[1].share) > 0.1)


def test_worst_points_of_known_curves() -> None:
    """planar_2r: w = l1 l2 |sin q2|, so the minima are where the elbow is nearest to straight."""
    arm = load("planar_2r")
    there_and_back = np.array([[0.0, 1.5], [0.0, 0.2], [0.0, 1.0], [0.0, 0.4], [0.0, 1.5]])
    shares, _ = path_shares(there_and_back)
    first, second = worst_points(arm, there_and_back)
    assert (first.share, second.share) == pytest.approx((shares[1], shares[3]))
    flat = np.array([[0.0, 1.0], [1.0, 1.0]])
    assert len(worst_points(arm, flat)) >= 1
    assert worst_points(arm, np.array([[0.0, 1.0], [0.0, 0.5]]))[0].share == 1.0


# the paths for all betas


def test_a_plan_and_a_sweep_show_the_same_paths(made: Plan, tradeoff: Tradeoff) -> None:
    (mine, current), theirs = shown_paths(made), of_tradeoff(tradeoff)
    assert len(mine) == len(theirs) >= 4
    for a, b in zip(mine, theirs, strict=True):
        assert a.interval == pytest.approx(b.interval, abs=1e-9)
        assert a.numbers == b.numbers
        np.testing.assert_array_equal(a.path, b.path)
    assert mine[current].path is made.path
    for interval, shown in zip(tradeoff.intervals, theirs, strict=True):
        rows = dict(shown.numbers)
        assert rows["w smallest (m²)"] == f"{interval.w_min:.3g}"
        assert rows["tool's path"] == f"{interval.workspace_length:.3f} m"


@pytest.mark.parametrize("floor", [0.02, 0.03])  # above the goal's w alone; above those of both ends
def test_with_a_floor_too_they_show_the_same_paths(floor: float, tmp_path: Path) -> None:
    held = with_alternatives(plan(PlanRequest(nodes=150, min_manipulability=floor)))
    save_roadmap(held.roadmap, tmp_path / "roadmap.npz")
    whole = sweep(PlanRequest(roadmap=tmp_path / "roadmap.npz", min_manipulability=floor))
    (mine, current), theirs = shown_paths(held), of_tradeoff(whole)
    assert len(mine) == len(theirs) >= 1
    for a, b in zip(mine, theirs, strict=True):
        assert a.interval == pytest.approx(b.interval, abs=1e-9)
        assert a.numbers == b.numbers
        np.testing.assert_array_equal(a.path, b.path)
    field = mine[current].cost_to_go
    assert field is not None
    assert field.shape == (len(held.roadmap.nodes),)
    assert held.cost is not None
    assert field[held.path_nodes[0]] == pytest.approx(held.cost.total)


def test_a_plan_that_is_one_of_several_as_good_is_shown_itself(made: Plan) -> None:
    """At a corner of the trade-off, as at 0 and 1, the plan's path may be none of the intervals'."""
    assert made.cost is not None
    other = replace(made, cost=replace(made.cost, distance=made.cost.distance + 1.0))
    plain, _ = shown_paths(made)
    for beta, place in ((0.0, 0), (plain[0].interval[1], 1), (1.0, len(plain))):  # type: ignore[index]
        shown, current = shown_paths(replace(other, request=replace(made.request, beta=beta)))
        assert len(shown) == len(plain) + 1
        assert current == place
        assert shown[current].interval == (beta, beta)
        assert shown[current].path is made.path


def test_pages_are_the_same_bytes_twice_and_whole(made: Plan, tradeoff: Tradeoff, tmp_path: Path) -> None:
    for thing, name in ((made, "plan.html"), (tradeoff, "sweep.html")):
        thing.save(tmp_path / "a")
        thing.save(str(tmp_path / "b"))
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
        assert page_data(tmp_path / "a" / name)["paths"][0]["interval"][0] == 0.0
        (tmp_path / "file").write_text("")
        with pytest.raises(FileError, match="cannot be made"):
            thing.save(tmp_path / "file" / "a")


# notebooks


def test_cells_show_small_tables(made: Plan, tradeoff: Tradeoff) -> None:
    shell = InteractiveShell()
    for thing, words in (
        (made, ("planar_2r in empty", "150 nodes", "min ")),
        (tradeoff, ("A collision-free path was found.", "w min", str(len(tradeoff.intervals[0].path_nodes)))),
        (made.roadmap, ("Roadmap of planar_2r in empty", "150 nodes", "seed")),
        (replace(tradeoff, intervals=()), ("planar_2r in empty",)),
    ):
        data, _ = shell.display_formatter.format(thing)  # type: ignore[union-attr]
        assert set(data) == {"text/plain", "text/html"}
        assert len(data["text/plain"]) < 100
        assert len(data["text/html"]) < 5000
        for word in words:
            assert word in data["text/html"]


def test_show_puts_the_page_into_the_cell(made: Plan, tradeoff: Tradeoff) -> None:
    for shown in (planner.show(made), planner.show(tradeoff), planner.show(made.roadmap, made.checker, height=400)):
        cell = shown._repr_html_()
        assert cell.startswith('<iframe sandbox="allow-scripts"')
        assert html.unescape(cell.split('srcdoc="')[1].rsplit('"')[0]) == shown.html
        assert len(repr(shown)) < 50
    assert "height:400px" in cell
    with pytest.raises(OptionError, match="holds no geometry"):
        planner.show(made.roadmap)
    with pytest.raises(OptionError, match="a str has no page"):
        planner.show("plan.json")  # type: ignore[arg-type]


def test_names_out_of_files_cannot_become_markup(made: Plan) -> None:
    nasty = replace(made, scene=replace(made.scene, name="<script>alert(1)</script>"))
    assert "<script>" not in nasty._repr_html_()


def test_a_roadmap_that_has_no_edges_is_shown(tmp_path: Path) -> None:
    checker = checker_of("planar_2r")
    lone = planner.build_roadmap(load("planar_2r"), checker, start=[0, 1], goal=[0.5, 1], nodes=2)
    for k in reversed(range(len(lone.edges))):
        lone = lone.without_edge(k)
    assert "0 edges" in lone._repr_html_()
    (tmp_path / "page.html").write_text(planner.show(lone, checker).html)
    assert page_data(tmp_path / "page.html")["roadmap"]["edges"] == []
