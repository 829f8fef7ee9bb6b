"""w, clearance and motion, along paths and over time."""

from __future__ import annotations

import io
import itertools
import re
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import planner
from planner import figures
from planner.base.errors import OptionError
from planner.collision.recheck import Clearance
from planner.figures.paths import w_label
from planner.figures.style import leave_headroom, single, stroke
from planner.kinematics.manipulability import jacobians, manipulability
from planner.planning.result import Plan
from planner.trajectory.limits import KINDS
from planner.trajectory.measure import dense_path, path_clearance
from planner.trajectory.trajectory import Trajectory
from tests import worlds
from tests.figures.panels import data, lines, require_labels


@pytest.fixture(scope="module")
def timed(solved: Plan) -> Plan:
    """The paper's scenario with its motion."""
    return replace(solved, trajectory=planner.time_path(solved.path, solved.checker, time_law="stop-at-corners"))


def test_w_is_drawn_over_the_joint_motion_of_each_path(solved: Plan) -> None:
    half = solved.path[: len(solved.path) // 2 + 1]
    figure = figures.manipulability({"whole": solved, "half": half}, checker=solved.checker)
    require_labels(figure)
    shown = lines(figure.axes[0])
    assert set(shown) == {"whole", "half"}
    assert np.array_equal(shown["whole"][1], manipulability(solved.robot, dense_path(solved.path)))
    length = sum(np.linalg.norm(b - a) for a, b in itertools.pairwise(solved.path))
    assert shown["whole"][0][[0, -1]] == pytest.approx([0.0, length])
    assert "(m³)" in figure.axes[0].get_ylabel()


def test_a_plan_gives_w_with_its_abscissa(solved: Plan) -> None:
    s, w = solved.w_along_path
    assert np.array_equal(np.stack([s, w]), data(figures.manipulability(solved).axes[0].get_lines()[0]))
    steps = np.linalg.norm(np.diff(solved.path, axis=0), axis=1)
    at = np.searchsorted(s, np.cumsum(steps) - 1e-9)
    for row, q in zip(at, solved.path[1:], strict=True):
        assert w[row] == pytest.approx(
            np.prod(np.linalg.svd(jacobians(solved.robot, q[None])[0], compute_uv=False)), rel=1e-6
        )
    assert [len(part) for part in replace(solved, path=np.zeros((0, 0))).w_along_path] == [0, 0]


def test_over_time_w_is_that_of_the_motion(timed: Plan) -> None:
    t, w = data(figures.manipulability(timed, over="time").axes[0].get_lines()[0])
    motion = timed.trajectory
    assert motion is not None
    assert t[[0, -1]] == pytest.approx(motion.times[[0, -1]])
    assert np.array_equal(w, manipulability(timed.robot, motion.at(t)))
    alone = figures.manipulability(motion, "time", timed.checker)
    assert np.array_equal(data(alone.axes[0].get_lines()[0])[1], w)


def test_clearance_is_drawn_along_the_path_and_over_time(timed: Plan) -> None:
    along = data(figures.clearance(timed).axes[0].get_lines()[0])
    assert np.array_equal(along[1], path_clearance(timed.checker, timed.path)[1])
    t, clearance = data(figures.clearance(timed, over="time").axes[0].get_lines()[0])
    assert timed.trajectory is not None
    assert clearance == pytest.approx(Clearance(timed.checker)(timed.trajectory.at(t)))


@pytest.mark.parametrize("value", [0.0444, 0.0, -0.2])
def test_a_constant_curve_does_not_lie_on_the_frame(value: float) -> None:
    _, axes = single(3.0, 2.0)
    axes.plot([0.0, 1.0], [value, value])
    for bottom in (None, -1.0):
        leave_headroom(axes, bottom=bottom)
        low, high = axes.get_ylim()
        assert value - low >= 0.09 * (high - low)
        assert high - value >= 0.09 * (high - low)


def test_a_path_far_from_all_says_so() -> None:
    whole = worlds.make_post()
    free: Any = type(whole)(whole.world.only(np.zeros(len(whole.world.pair_reach), dtype=bool)))
    figure = figures.clearance(np.array([[0.0, 0.1], [0.5, 0.2]]), checker=free)
    assert "nothing" in figure.axes[0].get_title()


def test_the_motion_is_drawn_against_each_joints_limits(timed: Plan) -> None:
    motion, robot = timed.trajectory, timed.robot
    assert motion is not None
    assert motion.limits is not None
    figure = figures.motion(timed)
    require_labels(figure)
    most = [None, motion.limits.velocity, motion.limits.acceleration, motion.limits.jerk]
    for order, axes in enumerate(figure.axes):
        drawn = axes.get_lines()
        for k, joint in enumerate(motion.joints):
            t, values = data(drawn[k])
            assert drawn[k].get_label() == joint
            assert np.array_equal(values, motion.at(t, order)[:, k])
        marks = [line for line in drawn[robot.dof :] if line.get_linestyle() == "None"]
        shown = {(str(line.get_marker()), round(float(data(line)[1, 0]), 9)) for line in marks}
        limits = most[order]
        ends = np.stack([robot.lower, robot.upper] if limits is None else [-limits, limits], axis=1)
        looks = [str(line.get_marker()) for line in drawn[: robot.dof]]
        assert shown == {(look, round(end, 9)) for look, pair in zip(looks, ends, strict=True) for end in pair}
        low, high = axes.get_ylim()
        assert low < ends.min() < ends.max() < high
    units = [re.findall(r"\((.*)\)", axes.get_ylabel())[0] for axes in figure.axes]
    assert units == ["rad", "rad/s", "rad/s²", "rad/s³"]


def test_lines_of_a_motion_are_told_apart_without_colour(timed: Plan) -> None:
    drawn = figures.motion(timed).axes[0].get_lines()[: timed.robot.dof]
    assert len({str(line.get_marker()) for line in drawn}) == timed.robot.dof
    assert len({str(stroke(k)["linestyle"]) for k in range(timed.robot.dof)}) == timed.robot.dof


def test_limits_far_beyond_a_motion_are_named_and_not_drawn() -> None:
    given: dict[str, str] = dict.fromkeys(KINDS, "given")
    most = np.full(2, 9.0)
    limits = planner.MotionLimits(("a", "b"), most, most, most, given)
    slow = Trajectory.from_points(("a", "b"), np.array([0.0, 1.0]), np.array([[0.0, 0.0], [0.1, 0.2]]))
    velocity = figures.motion(replace(slow, limits=limits)).axes[1]
    assert [text.get_text() for text in velocity.texts][-1] == "limits from $\\pm$9 on, not shown"
    assert velocity.get_ylim()[1] < 1.0


def test_each_refusal_says_what_to_do(solved: Plan) -> None:
    for draw in (figures.motion, figures.manipulability, figures.clearance):
        refused: Any = draw
        with pytest.raises(OptionError, match=r"planner\.time_path"):
            refused(solved) if draw is figures.motion else refused(solved, over="time")
    with pytest.raises(OptionError, match=r"checker=planner\.make_checker"):
        figures.manipulability(solved.path)
    with pytest.raises(OptionError, match="leave it out"):
        figures.manipulability(np.zeros((0, solved.robot.dof)), checker=solved.checker)


def test_a_saved_figure_has_the_fonts_that_journals_take(solved: Plan) -> None:
    file = io.BytesIO()
    figure = figures.manipulability(solved)
    figure.savefig(file, format="pdf", metadata={"CreationDate": None})
    assert b"/TrueType" in file.getvalue() or b"/CIDFontType2" in file.getvalue()
    assert b"/Type3" not in file.getvalue()
    assert figure.get_figwidth() == 3.5


def test_without_matplotlib_the_module_says_what_to_install() -> None:
    code = "import sys; sys.modules['matplotlib'] = None\nimport planner\nplanner.figures"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "pip install 'gabf-planner[figures]'" in done.stderr


def test_another_measure_is_named_in_place_of_w(solved: Plan) -> None:
    assert w_label(solved.robot) == "manipulability $w$ (m³)"
    assert w_label(replace(solved.robot, measure="min-singular-value")) == "min-singular-value (m)"
    assert w_label(replace(solved.robot, measure="inverse-condition")) == "inverse-condition (no unit)"
