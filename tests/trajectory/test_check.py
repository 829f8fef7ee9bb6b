"""Trajectories of any origin: what a controller makes of their points is proven or refuted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import planner
from planner.base.errors import ArrayError, FileError, OptionError
from planner.collision import make_checker
from planner.collision.edge_prover import Verdict
from planner.robot.poses import pose
from planner.robot.shapes import Box
from planner.trajectory.check import TrajectoryReport, check_trajectory, sampled_contact
from planner.trajectory.limits import MotionLimits
from planner.trajectory.points import Points
from planner.trajectory.report import report_record, report_rows, verdict_sentence
from planner.trajectory.timing import time_path
from tests.worlds import load, scene_of

ARM = load("planar_2r")
LIMITS = MotionLimits.of(ARM)
# behind the arm's way from q1 = -0.6 to 0, and in that of a swing beyond 0.2
CHECKER = make_checker(ARM, scene_of((Box((0.1, 0.1, 0.1)), pose([0.75, 0.35, 0.0]))))


def report_of(times: list[float], *columns: list[list[float]], limits: MotionLimits = LIMITS) -> TrajectoryReport:
    arrays = tuple(np.array(rows, dtype=float) for rows in columns)
    report = check_trajectory(CHECKER, Points(ARM.joints, np.array(times, dtype=float), arrays), limits)
    assert report_rows(report)
    assert report_record(report)["message"] == verdict_sentence(report)
    return report


def test_our_own_is_proven_by_the_check_too() -> None:
    made = time_path(np.array([[-1.0, 0.5], [-0.6, -0.4], [-0.2, 0.1]]), CHECKER)
    report = check_trajectory(
        CHECKER, Points(ARM.joints, made.times, (made.knots(), made.knots(1), made.knots(2))), LIMITS
    )
    assert report.ok
    assert report.proof is not None
    assert (report.proof.verdict == Verdict.FREE).all()
    assert verdict_sentence(report).startswith("Free and within all limits")


@pytest.mark.parametrize("step", [0.05, 1e-3])
def test_a_motion_is_looked_at_past_its_knots(step: float, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = planner.plan(robot="panda", scene="shelf", path_only=True, timing=planner.TimingRequest())
    motion, judge = plan.trajectory, plan.checker
    assert motion is not None
    seen: list[tuple[np.ndarray, np.ndarray]] = []
    monkeypatch.setattr(type(judge), "first_contact_along", lambda _, *given: seen.append(given))
    assert sampled_contact(motion, judge, step) is None
    ((states, apart),) = seen
    np.testing.assert_allclose(states[[0, -1]], motion.knots()[[0, -1]], rtol=0, atol=1e-12)
    assert 0 < apart.max() <= 2 * step  # of two bodies that move
    if step > 0.01:
        assert len(states) < len(motion.times)


def test_one_function_checks_paths_and_trajectories() -> None:
    path = [[-1.0, 0.5], [-0.6, -0.4], [-0.2, 0.1]]
    made = time_path(np.array(path), CHECKER)
    straight, timed = planner.check(path, CHECKER), planner.check(made, CHECKER)
    assert straight.ok
    assert timed.ok
    assert isinstance(timed, TrajectoryReport)
    assert timed.limits == made.limits
    assert not planner.check([[-1.0, 0.5], [0.8, 0.0]], CHECKER).ok
    slower = MotionLimits.of(ARM, planner.LimitsRequest(velocity_scale=0.1))
    assert not planner.check(replace(made, limits=slower), CHECKER).ok
    with pytest.raises(OptionError, match="is of other joints"):
        planner.check(replace(made, joints=("a", "b")), CHECKER)
    with pytest.raises(ArrayError, match="path"):
        planner.check([[1.0, 2.0, 3.0]], CHECKER)


def test_points_that_are_free_and_a_curve_between_them_that_touches() -> None:
    """Each point, and the line between them, is free; the cubic that the velocities make swings into the box."""
    still = report_of([0.0, 4.0], [[-0.3, 0.0], [-0.3, 0.0]])
    assert still.ok
    swings = report_of([0.0, 4.0, 4.5], [[-0.3, 0.0], [-0.3, 0.0], [-0.3, 0.0]], [[1.2, 0.0], [0.0, 0.0], [0.0, 0.0]])
    assert not swings.ok
    assert swings.contact is not None
    q = swings.contact.q
    assert q is not None
    t = np.linspace(0.0, 4.0, 4001)
    assert swings.trajectory is not None
    free = np.array([CHECKER.first_contact(row) is None for row in swings.trajectory.at(t)[::20]])
    assert abs(swings.contact.begin - t[::20][~free][0]) < 0.05
    assert "touch" in verdict_sentence(swings)


@pytest.mark.parametrize(
    ("times", "columns", "words"),
    [
        ([0.0, 0.1], ([[-0.6, 0.0], [-0.3, 0.0]],), "of velocity"),
        ([0.0, 0.4], ([[-0.6, 0.0], [-0.3, 0.0]], [[0.0, 0.0], [0.0, 0.0]]), "of acceleration"),
        ([0.0, 2.0], ([[-0.6, 0.0], [-0.6, 0.0]], [[0.0, 3.3], [0.0, 0.0]]), "of velocity"),
        ([0.0, 0.0], ([[-0.6, 0.0], [-0.3, 0.0]],), "time does not increase from point 1"),
        ([0.0, 1.0], ([[-0.6, 0.0], [-0.3, 0.0]], [[0.0, 0.0], [0.1, 0.0]]), "the last velocity is not 0"),
        ([0.0, 1.0], ([[-0.6, 0.0], [-0.3, 0.0]], [[0.0, 0.0], [5e-7, 0.0]]), "the last velocity is not 0"),
        ([-1.0, 1.0], ([[-0.6, 0.0], [-0.3, 0.0]],), "before the start"),
        ([0.0, 90.0], ([[-0.6, 0.0], [-0.6, 80.0]],), "degrees"),
        ([0.0, 9.0], ([[-0.6, 0.0], [-0.6, 4.0]],), "beyond its limit"),
    ],
)
def test_what_breaks_a_limit_is_named(times: list[float], columns: tuple, words: str) -> None:
    report = report_of(times, *columns)
    assert not report.ok
    assert words in verdict_sentence(report)


def test_a_swing_beyond_all_reason_is_refused() -> None:
    """It would take forever to sample."""
    with pytest.raises(FileError, match="between 0 and 900 s the trajectory swings as far as"):
        report_of([0.0, 900.0], [[-0.6, 0.0], [-0.3, 0.0]], [[900.0, 0.0], [0.0, 0.0]])
