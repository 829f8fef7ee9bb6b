"""Every figure shows what it was given: data, labels with units, and lines that differ in more than colour."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from planner import gabf
from planner.base.errors import OptionError
from planner.base.outcome import Outcome
from planner.base.request import SweepRequest
from planner.costs.network import build_network
from planner.figures import figure as figures
from planner.figures.space import blocked_grid, determinant_grid
from planner.figures.strokes import DASHES, MARKS, SHADES, marked, stroke
from planner.figures.workspace import clipped, faces_of
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.paths.measure import dense_path, path_clearance
from planner.plan_record import Plan
from planner.tradeoff.nondominated import Front
from planner.tradeoff.sweep import Interval, Tradeoff
from planner.world.poses import pose
from planner.world.shapes import Box, Capsule, Cylinder, Shape, Sphere
from tests import worlds
from tests.coal_judge import CoalWorld
from tests.random_shapes import box_mesh

NONE: Any = None


def lines(axes: Any) -> dict[str, np.ndarray]:
    """The labelled lines of a panel: (2, n) data by label."""
    return {str(line.get_label()): data(line) for line in axes.get_lines()}


def data(line: Any) -> np.ndarray:
    """(2, n) what a line shows."""
    return np.array(line.get_data(), dtype=float)


def require_labels(figure: Figure) -> None:
    """Every panel names both axes, with units."""
    for axes in figure.axes:
        if axes.axison and axes.get_label() != "<colorbar>":
            assert "(" in axes.get_xlabel() or axes.get_shared_x_axes().get_siblings(axes) != [axes], axes
            assert "(" in axes.get_ylabel() or "relative" in axes.get_ylabel(), axes.get_ylabel()


def interval(low: float, high: float, omega: float, distance: float) -> Interval:
    empty = np.zeros(0)
    return Interval(low, high, empty.astype(np.int64), empty, omega, distance, 0.0, 0.0, 0.0, 0.0, NONE)


def tradeoff(front: Front | None, *intervals: Interval) -> Tradeoff:
    outcome = Outcome.SOLVED if intervals else Outcome.NO_PATH
    return Tradeoff(SweepRequest(), outcome, NONE, NONE, NONE, NONE, intervals=intervals, front=front)


# lines meet at beta = 0.25 and 0.5; (2.5, 7.5) lies above all three, so that no beta reaches it
THREE = (interval(0.0, 0.25, 1.0, 10.0), interval(0.25, 0.5, 2.0, 7.0), interval(0.5, 1.0, 5.0, 4.0))
POINTS = np.array([[1.0, 10.0], [1.9, 9.0], [2.0, 7.0], [4.9, 6.0], [5.0, 4.0]])


def front(complete: bool = True) -> Front:
    return Front(POINTS, tuple(np.zeros(1, dtype=np.int64) for _ in POINTS), complete, 9)


@pytest.fixture(scope="module")
def laws() -> dict[str, gabf.CostToGo]:
    """Two laws on the nine-node example, with their trajectories."""
    network = gabf.examples.nine_node()
    chosen = {"nominal": gabf.Nominal(), "singularity-free": gabf.SingularityFree(T=2.0)}
    return {name: gabf.solve(network, law=law, save=gabf.EverySteps(1)) for name, law in chosen.items()}


def test_the_first_lines_differ_in_dash_and_marker_and_all_in_shade() -> None:
    assert len(set(DASHES)) == len(set(MARKS)) == len(set(SHADES)) == 6
    assert stroke(1)["linestyle"] != stroke(2)["linestyle"]
    assert marked(1)["marker"] != marked(2)["marker"]


def test_profiles_show_w_and_clearance_along_each_path(solved: Plan) -> None:
    checker, robot = solved.checker, solved.robot
    half = solved.path[: len(solved.path) // 2 + 1]
    figure = figures.path_profiles(checker, {"whole": solved.path, "half": half})
    require_labels(figure)
    upper, lower = figure.axes
    shown = lines(upper)
    assert set(shown) == {"whole", "half"}
    q = dense_path(solved.path)
    assert np.array_equal(shown["whole"][1], manipulability(robot, q))
    length = sum(np.linalg.norm(b - a) for a, b in itertools.pairwise(solved.path))
    assert shown["whole"][0][[0, -1]] == pytest.approx([0.0, length])
    below = lower.get_lines()
    assert len(below) == 2
    assert np.array_equal(data(below[1])[1], path_clearance(checker, half)[1])
    assert "(m³)" in upper.get_ylabel()


def test_an_empty_path_has_no_profile(solved: Plan) -> None:
    with pytest.raises(OptionError, match="'none' has no path"):
        figures.path_profiles(solved.checker, {"none": np.zeros((0, 7))})


def test_certified_clearance_is_drawn_against_what_was_measured() -> None:
    figure = figures.clearance_bounds(np.array([0.01, 0.02]), np.array([0.015, 0.05]))
    require_labels(figure)
    shown = lines(figure.axes[0])
    assert shown["an edge"].T.tolist() == [[0.015, 0.01], [0.05, 0.02]]
    assert np.array_equal(*shown["equal"])


def test_the_front_tells_what_beta_reaches_from_what_it_does_not() -> None:
    figure = figures.tradeoff_front(tradeoff(front(), *THREE))
    require_labels(figure)
    (axes,) = figure.axes
    shown = lines(axes)
    assert np.array_equal(shown["optimal for some $\\beta$"].T, POINTS[[0, 2, 4]])
    assert np.array_equal(shown["non-dominated, reached by no $\\beta$"].T, POINTS[[1, 3]])
    assert [text.get_text() for text in axes.texts] == [
        "$\\beta$ 0 to 0.25",
        "$\\beta$ 0.25 to 0.5",
        "$\\beta$ 0.5 to 1",
    ]


def test_a_front_that_was_not_asked_for_or_cut_short_is_said_so() -> None:
    assert len(figures.tradeoff_front(tradeoff(None, *THREE)).axes[0].get_lines()) == 1
    shown = lines(figures.tradeoff_front(tradeoff(front(complete=False), *THREE)).axes[0])
    assert any("as far as searched" in label for label in shown)


def test_the_envelope_is_the_least_cost() -> None:
    figure = figures.cost_envelope(tradeoff(None, *THREE))
    require_labels(figure)
    shown = lines(figure.axes[0])
    beta = np.linspace(0, 1, 101)
    least = np.min([(1 - beta) * i.manipulability_cost + beta * i.distance_cost for i in THREE], axis=0)
    assert np.interp(beta, *shown["least cost"]) == pytest.approx(least, abs=1e-12)
    assert len(shown) == 4
    assert np.array_equal(shown["path 2"], [[0, 1], [2.0, 7.0]])


@pytest.mark.parametrize("draw", [figures.tradeoff_front, figures.cost_envelope])
def test_a_trade_off_without_a_path_cannot_be_drawn(draw: Any) -> None:
    with pytest.raises(OptionError, match="no path to draw"):
        draw(tradeoff(None))


def test_costs_against_beta_are_medians_with_every_roadmap_behind() -> None:
    omega, distance = np.array([[1.0, 2, 4], [3, 4, 8], [2, 9, 10]]), np.array([[6.0, 5, 4], [8, 7, 4], [9, 9, 3]])
    rrt, printed = (np.array([7.0, 5, 6]), np.array([1.0, 2, 3])), (np.array([0.1, 1, 1]), np.array([3.0, 2, 2]))
    figure = figures.beta_costs((0.0, 0.5, 1.0), (omega, distance), {"RRT": rrt}, printed)
    require_labels(figure)
    left, middle, right = figure.axes
    assert lines(left)["GABF, median"][1].tolist() == [2, 4, 8]
    assert lines(middle)["GABF, median"][1].tolist() == [8, 7, 4]
    assert lines(left)["RRT, median"][1].tolist() == [6, 6]
    grey = [line for line in middle.get_lines() if line.get_color() == "0.7"]
    assert [data(line)[1].tolist() for line in grey] == distance.tolist()
    assert lines(right)["$\\Omega$, paper"][1].tolist() == [0.1, 1, 1]
    assert lines(right)["$D$, ours (median)"][1] == pytest.approx([2.0, 1.75, 1.0])


def test_convergence_shows_the_trajectory_with_its_deadline(laws: dict[str, gabf.CostToGo]) -> None:
    nodes = np.array([2, 5])
    figure = figures.convergence(laws, nodes)
    require_labels(figure)
    nominal, free = figure.axes
    course = laws["nominal"].trajectory
    assert course is not None
    assert len(nominal.get_lines()) == 3  # two nodes, settled; this law has no T_p
    assert np.array_equal(data(nominal.get_lines()[0])[1], course.x[:, 2])
    shown = lines(free)
    assert shown["$T_p$"][0].tolist() == [2.0, 2.0]
    assert shown["every node settled"][0][0] == laws["singularity-free"].settling_time
    assert data(free.get_lines()[1])[0, -1] == 2.0  # at rest until T_p
    assert data(free.get_lines()[1])[1, -1] == laws["singularity-free"].x[5]


def test_convergence_chooses_nodes_over_the_whole_range(laws: dict[str, gabf.CostToGo]) -> None:
    (panel,) = figures.convergence({"nominal": laws["nominal"]}, unit="km").axes
    ends = [data(line)[1, -1] for line in panel.get_lines()[:-1]]
    assert sorted(ends) == pytest.approx(sorted(laws["nominal"].x))
    assert "(km)" in panel.get_ylabel()


def test_error_decay_is_the_distance_from_the_optimum(laws: dict[str, gabf.CostToGo]) -> None:
    figure = figures.error_decay(laws)
    require_labels(figure)
    (axes,) = figure.axes
    shown = lines(axes)
    assert set(shown) == {"nominal", "singularity-free", "$T_p = 2$ s"}
    course = laws["nominal"].trajectory
    assert course is not None
    assert np.array_equal(shown["nominal"][0], course.t)
    error = np.abs(course.x - laws["singularity-free"].x).max(axis=1)  # the other law's answer, no oracle's
    assert shown["nominal"][1] == pytest.approx(np.maximum(error, 1e-10), rel=1e-6)
    assert axes.get_xlim() == (0.0, 3.0)


@pytest.mark.parametrize("draw", [figures.convergence, figures.error_decay])
def test_without_a_trajectory_there_is_nothing_to_draw(draw: Any, laws: dict[str, gabf.CostToGo]) -> None:
    with pytest.raises(OptionError, match=r"save=gabf.EverySteps"):
        draw({"bare": replace(laws["nominal"], trajectory=None)})


@pytest.fixture(scope="module")
def space() -> tuple[Figure, np.ndarray, np.ndarray]:
    """The configuration space around the post with its cost-to-go and a path."""
    roadmap = worlds.post_roadmap()
    network = build_network(roadmap, 0.5)
    field = gabf.solve(network)
    x = field.x.copy()
    x[7] = np.inf  # as a node that reaches no goal
    path = roadmap.nodes[gabf.extract_path(network, field, int(roadmap.starts[0]))]
    return figures.configuration_space(worlds.make_post(), roadmap, x, path, resolution=31), x, path


def test_the_configuration_space_shows_roadmap_cost_and_path(space: tuple[Figure, np.ndarray, np.ndarray]) -> None:
    figure, x, path = space
    require_labels(figure)
    axes, bar = figure.axes
    roadmap = worlds.post_roadmap()
    dots: Any = next(c for c in axes.collections if type(c).__name__ == "PathCollection")
    assert np.array_equal(np.ma.getdata(dots.get_array()), x[np.isfinite(x)])
    assert np.array_equal(np.ma.getdata(dots.get_offsets()), roadmap.nodes[np.isfinite(x)])
    assert bar.get_ylabel() == "cost-to-go $x$ (no unit)"
    assert np.array_equal(lines(axes)["path"].T, path)
    edges: Any = next(c for c in axes.collections if type(c).__name__ == "LineCollection")
    assert len(edges.get_segments()) == len(roadmap.edges)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("joint_1 (rad)", "joint_2 (rad)")
    grey = [line for line in axes.get_lines() if data(line).shape[1] == 1 and to_hex(line.get_color()) == "#999999"]
    assert len(grey) == 1


def test_the_blocked_region_and_the_singular_line_are_where_they_are() -> None:
    checker, robot = worlds.make_post(), worlds.load("planar_2r")
    first, second = np.linspace(-1.0, 1.0, 9), np.linspace(-2.9, 2.9, 9)
    coal = CoalWorld(checker.world)
    truth = [[coal.distances(np.array([p, q])).min() <= 0 for q in second] for p in first]
    assert 0 < np.sum(truth) < 81
    assert np.array_equal(blocked_grid(checker, first, second), truth)
    assert determinant_grid(robot, first, second) == pytest.approx(np.tile(0.2 * np.sin(second), (9, 1)), abs=1e-12)


def test_only_an_arm_of_two_joints_has_such_a_space(solved: Plan) -> None:
    with pytest.raises(OptionError, match="iiwa14 has 7 joints"):
        figures.configuration_space(solved.checker, solved.roadmap, np.zeros(len(solved.roadmap.nodes)))


def test_tool_paths_pass_where_the_tool_passes(solved: Plan) -> None:
    half = solved.path[: len(solved.path) // 2 + 1]
    figure = figures.tool_paths(solved.robot, solved.scene, {"whole": solved.path, "half": half})
    for axes in figure.axes:
        shown: Any = axes
        assert [shown.get_xlabel(), shown.get_ylabel(), shown.get_zlabel()] == ["x (m)", "y (m)", "z (m)"]
        found = {line.get_label(): np.array(line.get_data_3d()).T for line in shown.get_lines()}
        assert np.array_equal(found["half"], tool_positions(solved.robot, dense_path(half)))
        assert shown.get_zlim()[0] <= found["whole"][:, 2].min()
        assert {text.get_text().strip() for text in shown.texts} == {"start", "goal"}
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["whole", "half"]


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        (Box((0.2, 0.4, 0.6)), (0.1, 0.2, 0.3)),
        (Sphere(0.3), (0.3, 0.3, 0.3)),
        (Cylinder(0.1, 0.8), (0.1, 0.1, 0.4)),
        (Capsule(0.1, 0.8), (0.1, 0.1, 0.5)),
        (box_mesh((0.2, 0.4, 0.6)), (0.1, 0.2, 0.3)),
    ],
    ids=["box", "sphere", "cylinder", "capsule", "mesh"],
)
def test_faces_reach_as_far_as_the_shape_and_are_flat(shape: Shape, half: tuple[float, ...]) -> None:
    placement = pose((1.0, 2.0, 3.0), rpy=(0.0, 0.0, np.pi / 2))
    faces = faces_of(shape, placement)
    corners = np.concatenate(faces) - [1.0, 2.0, 3.0]
    turned = np.array([half[1], half[0], half[2]])
    assert np.abs(corners).max(axis=0) == pytest.approx(turned, abs=1e-12)
    for face in faces:
        across = np.linalg.svd(face - face.mean(axis=0), compute_uv=False)
        assert len(across) < 3 or across[-1] < 1e-12


def test_a_face_is_cut_at_the_box() -> None:
    rng = np.random.default_rng(0)
    low, high = np.full(3, -0.5), np.full(3, 0.5)
    for _ in range(50):
        face = rng.uniform(-1.5, 1.5, (3, 3))
        cut = clipped(face, low, high)
        share = rng.dirichlet(np.ones(3), 4000) @ face
        inside = ((share >= low) & (share <= high)).all(axis=1).mean()
        area = sum(np.linalg.norm(np.cross(b - cut[0], c - cut[0])) for b, c in itertools.pairwise(cut[1:]))
        assert area / np.linalg.norm(np.cross(face[1] - face[0], face[2] - face[0])) == pytest.approx(inside, abs=0.04)
        if len(cut):
            assert (cut >= low - 1e-12).all()
            assert (cut <= high + 1e-12).all()
    assert len(clipped(np.full((3, 3), 2.0), low, high)) == 0
