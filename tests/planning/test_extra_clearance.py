"""Paths keep clearance where there is some, by halves where it is tight: judged by coal at dense samples."""

import itertools

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.recheck import Clearance, dense_states
from planner.planning.improvement import certify_clearance
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, TimingRequest
from planner.robot.poses import pose
from planner.robot.scene import Obstacle, Scene
from planner.robot.shapes import Box
from tests.worlds import load, make_post, post_roadmap

BAR = Scene("bar", (Obstacle("box", Box((0.1, 0.04, 0.2)), pose([0.75, 0, 0])),))
ASKED = PlanRequest.from_options(
    robot="planar_2r", scene=BAR, start="q:-1.0,0.8", goal="q:1.3,-0.8", nodes=60, beta=1.0
)


def judged(found, q) -> float:
    """The smallest distance (m) at configurations, by coal."""
    return float(Clearance(make_checker(found.robot, found.scene, "coal"))(q).min())


@pytest.mark.parametrize("room", [0.0, 0.005, 0.02])
def test_path_and_motion_keep_what_is_asked_for(room: float) -> None:
    found = plan(request=ASKED.with_options(extra_clearance=room), timing=TimingRequest())
    assert found.clearance_kept == room
    along = np.vstack([dense_states(found.checker.world, a, b - a, 2e-3)[0] for a, b in itertools.pairwise(found.path)])
    motion = found.trajectory
    assert motion is not None
    in_time = motion.at(np.linspace(0.0, motion.duration, 2000))
    nearest = min(judged(found, along), judged(found, in_time))
    assert nearest >= room - 1e-5  # coal's own error
    assert motion.proven
    if room == 0.0:
        assert nearest < 0.003  # what the others gain is not there by itself


def test_a_narrow_goal_leaves_half_of_it_or_less_and_says_so() -> None:
    """The goal stands 4 mm before the bar: 2.5 of 5 mm are kept."""
    robot, checker = load("planar_2r"), make_checker(load("planar_2r"), BAR)
    line = np.column_stack([np.linspace(1.3, 0.2, 20_000), np.full(20_000, -0.8)])
    distance = Clearance(checker)(line, below=0.01)
    goal = line[np.argmax(distance < 0.004)]
    found = plan(request=ASKED.with_options(goal=goal.tolist()), timing=TimingRequest())
    assert robot.name == found.robot.name
    assert found.clearance_kept == 0.0025
    assert found.clearance is not None
    assert found.clearance.path is not None
    assert 0.0025 <= found.clearance.path.min <= 0.004 + 1e-6
    assert "Refined paths keep 2.5 of 5 mm" in str(found.record.rows)


def test_certificates_of_a_level_are_proofs() -> None:
    """Every edge that is said to keep a clearance does so at dense states, by coal; others do not all."""
    roadmap, checker = post_roadmap(), make_post()
    found, kept = certify_clearance(roadmap, checker, ASKED.with_options(extra_clearance=0.03).quality)
    assert kept == 0.03
    judge = Clearance(make_checker(checker.robot, checker.world.scene, "coal"))
    least = np.array([
        judge(dense_states(checker.world, roadmap.nodes[i], roadmap.nodes[j] - roadmap.nodes[i], 5e-3)[0]).min()
        for i, j in roadmap.edges
    ])  # fmt: skip
    says = found.clearance >= kept
    assert (least[says] >= kept - 1e-5).all()
    assert (least[~says] < kept + 1e-3).all()
    assert (roadmap.clearance < kept)[says].any()  # certificates alone would have said less
    assert 0 < says.sum() < len(says)
