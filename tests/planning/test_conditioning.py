"""The judgement on a path: where it is worst, and the floor that is reachable."""

import numpy as np
import pytest

from planner.planning.plan import plan
from planner.planning.quality import measure_conditioning
from planner.problem.request import PlanRequest
from planner.search.manipulability_floor import highest_floor
from planner.search.network import build_network
from tests.worlds import load, post_roadmap

ROBOT = load("planar_2r")


def test_a_singular_place_is_found():
    path = np.array([[-1.0, 1.2], [-0.9, 0.6], [-0.6, -0.6]])  # stretched out half way along the second motion
    found = measure_conditioning(
        ROBOT, post_roadmap(), path, PlanRequest.from_options(robot="planar_2r", cost_integration="edges").quality
    )
    assert found.poor
    assert found.typical == np.median(post_roadmap().manipulability)
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert found.share == pytest.approx((lengths[0] + 0.5 * lengths[1]) / lengths.sum(), abs=0.01)
    assert found.advice is not None
    assert f"at {100 * found.share:.0f} % of the path" in found.advice
    assert "--cost-integration" not in found.advice


def test_the_floor_that_is_advised_can_be_kept(tmp_path):
    """A plan of length only that comes out bad, and the same with what it advises, on its own roadmap."""
    request = PlanRequest.from_options(
        nodes=150, collision="coal", beta=1.0, seed=1
    )  # with 0 it ends in a goal below the floor
    found = plan(request=request, timing=None)
    floor = highest_floor(found.robot, found.roadmap, build_network(found.roadmap))
    found.save(tmp_path)
    better = plan(request=request, roadmap=tmp_path / "roadmap.npz", min_manipulability=floor, timing=None)
    worst = better.record.conditioning
    assert worst is not None
    assert worst.w_min >= floor
