"""w, clearance and motion, along paths and over time."""

from __future__ import annotations

import io
import itertools
import re
from dataclasses import replace

import numpy as np
import pytest

import planner
from planner import figures
from planner.collision.recheck import Clearance
from planner.kinematics.manipulability import manipulability
from planner.planning.result import Plan
from planner.trajectory.measure import dense_path, path_clearance
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


def test_a_saved_figure_has_the_fonts_that_journals_take(solved: Plan) -> None:
    file = io.BytesIO()
    figure = figures.manipulability(solved)
    figure.savefig(file, format="pdf", metadata={"CreationDate": None})
    assert b"/TrueType" in file.getvalue() or b"/CIDFontType2" in file.getvalue()
    assert b"/Type3" not in file.getvalue()
    assert figure.get_figwidth() == 3.5
