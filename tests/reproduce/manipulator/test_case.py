"""One seed of the manipulator study."""

import numpy as np
import pytest

from planner.cost.scale import manipulability_cost
from planner.kinematics.manipulability import manipulability
from planner.query.query import Query
from reproduce.manipulator.case import BETAS, RRT, SHORTENED, SeedStudy, label_of


def test_costs_are_those_of_the_paths_configurations(case: SeedStudy, query: Query) -> None:
    """Omega over every node but the start, D over every edge: recomputed from joint values alone."""
    scale = case.roadmap.scale
    for measured in case.ways.values():
        omega = manipulability_cost(manipulability(query.robot, measured.q[1:]), scale)
        steps = np.linalg.norm(np.diff(measured.q, axis=0), axis=1) / scale.joint_length
        assert measured.manipulability_cost == pytest.approx(omega.sum(), rel=1e-9)
        assert measured.distance_cost == pytest.approx(np.maximum(steps, scale.zeta).sum(), rel=1e-9)


def test_no_beta_is_beaten_by_another_path_of_its_roadmap(case: SeedStudy) -> None:
    for beta in BETAS:
        least = case.ways[label_of(beta)].total(beta)
        assert all(least <= other.total(beta) + 1e-9 for label, other in case.ways.items() if label != RRT)
    assert all(field.error <= 1e-12 for field in case.fields)


def test_the_shortened_rrt_path_is_part_of_the_roadmap_and_the_raw_one_no_shorter(case: SeedStudy) -> None:
    known = {q.tobytes() for q in case.roadmap.nodes}
    assert all(q.tobytes() in known for q in case.ways[SHORTENED].nodes)
    assert case.ways[RRT].joint_length >= case.ways[SHORTENED].joint_length
    for rrt in (case.ways[RRT], case.ways[SHORTENED]):
        assert np.array_equal(rrt.nodes[0], case.roadmap.nodes[case.roadmap.starts[0]])
        assert any(np.array_equal(rrt.nodes[-1], goal) for goal in case.roadmap.nodes[case.roadmap.goals])
