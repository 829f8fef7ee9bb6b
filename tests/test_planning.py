"""The whole plan: the best path of its roadmap by another algorithm, free at 1 mm, healed where an edge fails."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pydantic
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner import gabf
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.collision.recheck import sample_segment
from planner.cost.scale import COSTS
from planner.kinematics.forward import tool_positions
from planner.planning.plan import plan
from planner.planning.record import PlanRecord
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, TimingRequest
from planner.search.network import build_network, distance_cost
from planner.tradeoff.sweep import add_alternatives
from planner.trajectory.trajectory import Trajectory
from tests.coal_judge import CoalWorld
from tests.random_shapes import QUICK
from tests.search.failing import collide

RECORD = pydantic.TypeAdapter(PlanRecord)
SCENE = """
obstacles: [{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}]
states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}}
"""
SHUT = """
obstacles:
  - {name: left, type: box, size: [0.02, 0.3, 0.2], position: [0.12, 0.28, 0]}
  - {name: right, type: box, size: [0.02, 0.3, 0.2], position: [-0.12, 0.28, 0]}
states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.5707963,0.4"}}
"""


@pytest.fixture(scope="module")
def scenes(tmp_path_factory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("scenes")
    for name, text in (("post", SCENE), ("shut", SHUT)):
        (folder / f"{name}.yaml").write_text(text)
    return {name: str(folder / f"{name}.yaml") for name in ("post", "shut")}


@pytest.fixture(scope="module")
def small(scenes) -> PlanRequest:
    return PlanRequest.from_options(robot="planar_2r", scene=scenes["post"], nodes=80)


def mean_omega(roadmap, request) -> np.ndarray:
    """(m,) the manipulability cost along every edge, which tests/roadmap/test_motion_cost.py holds to be integrals."""
    return roadmap.edge_cost[:, COSTS.index(request.quality.manipulability_cost)]


def best_by_dijkstra(found) -> float:
    """The cheapest way by SciPy over edges that keep the clearance, their costs those of eq. (finew), integrated."""
    roadmap, request = found.roadmap, found.request
    weight = distance_cost(roadmap, request.quality.metric)
    weight = np.where(roadmap.clearance >= found.clearance_kept, weight, np.inf)
    n, (i, j), beta = len(roadmap.nodes), roadmap.edges.T, request.quality.beta
    graph = csr_matrix((weight * ((1 - beta) * mean_omega(roadmap, request) + beta), (i, j)), shape=(n, n))
    return float(dijkstra(graph, directed=False, indices=roadmap.starts[0])[roadmap.goals].min())


def assert_sound(found):
    """Everything that a solved plan claims, from the arrays alone."""
    roadmap, request, nodes = found.roadmap, found.request, found.path_nodes
    assert found.outcome is Outcome.SOLVED
    assert nodes[0] in roadmap.starts
    assert nodes[-1] in roadmap.goals
    assert len(np.unique(nodes)) == len(nodes)
    np.testing.assert_allclose(found.path[0], roadmap.nodes[nodes[0]])
    rows = [roadmap.edge_index(a, b) for a, b in itertools.pairwise(nodes)]
    weight = distance_cost(roadmap, request.quality.metric)[rows]
    assert found.cost.manipulability == pytest.approx((mean_omega(roadmap, request)[rows] * weight).sum())
    assert found.cost.distance == pytest.approx(weight.sum())
    beta = request.quality.beta
    assert found.cost.beta == beta
    total = (1 - beta) * found.cost.manipulability + beta * found.cost.distance
    assert found.cost.total == pytest.approx(total, rel=1e-12)
    assert found.cost.total == pytest.approx(best_by_dijkstra(found), rel=1e-12)
    assert roadmap.clearance[rows].min() >= found.clearance_kept
    assert found.cost.total == pytest.approx(found.cost_to_go.x[nodes[0]], rel=1e-12)
    assert found.max_error_vs_oracle == 0.0
    assert found.cost_to_go.outcome is gabf.Ending.SETTLED
    for a, b in itertools.pairwise(found.path):
        assert sample_segment(found.checker, a, b - a, 1e-3) is None


def test_the_papers_scenario(solved):
    assert_sound(solved)
    assert (solved.robot.name, solved.scene.name) == ("iiwa14", "paper")
    tool = tool_positions(solved.robot, solved.path)
    np.testing.assert_allclose(tool[[0, -1]], [[0.92, -0.10, 0.42], [-0.52, -0.04, 1.13]], atol=2e-6)
    assert solved.edges_removed == 0
    assert {"setup", "roadmap", "costs", "gabf", "path"} <= set(solved.timings)
    assert solved.cost_to_go.settling_time < 4.0


def test_a_path_only_is_proven_with_nothing_grown_around_it(scenes):
    found = plan(request=PlanRequest.from_options(robot="planar_2r", scene=scenes["post"], path_only=True), timing=None)
    assert_sound(found)
    assert len(found.roadmap.nodes) < 80
    assert found.roadmap.proven.all()
    assert not found.curve


@settings(QUICK, max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from([0.0, 0.3, 0.5, 0.7, 1.0]),
    st.sampled_from(["joint", "workspace"]),
    st.sampled_from(["inverse", "log", "linear"]),
    st.sampled_from(["nominal", "prescribed-time", "fixed-time", "singularity-free"]),
)
def test_a_plan_is_the_cheapest_by_dijkstra_for_every_objective_and_law(small, beta, metric, cost, law):
    options = {"beta": beta, "metric": metric, "manipulability_cost": cost, "law": law}
    assert_sound(plan(request=small.with_options(**options), timing=None))


def test_a_margin_is_kept_along_the_path(small):
    found = plan(request=small.with_options(margin=0.02), timing=None)
    assert_sound(found)
    judge = CoalWorld(found.checker.world)
    for a, b in itertools.pairwise(found.path):
        for s in np.linspace(0, 1, 50):
            assert judge.distances(a + s * (b - a)).min() > 0.02


def test_start_is_goal(small):
    found = plan(request=small.with_options(goal="q:-1.0,0.8"), timing=None)
    assert found.outcome is Outcome.SOLVED
    assert found.path_nodes.tolist() == [0]
    assert found.path.shape == (1, 2)
    assert (found.cost.total, found.cost.manipulability, found.cost.distance) == (0, 0, 0)
    assert found.max_error_vs_oracle == 0.0


def test_the_highest_floor_that_was_found_can_be_kept_to():
    request = PlanRequest.from_options(nodes=100, refinement_rounds=0, seed=2)
    failed = plan(request=request.with_options(min_manipulability=0.12), timing=None)
    assert failed.outcome is Outcome.TOO_SINGULAR
    assert 0.0 < failed.reason.reachable < failed.reason.asked == 0.12
    assert f"--min-manipulability {failed.reason.reachable:g}" in failed.message
    assert (
        plan(request=request.with_options(min_manipulability=failed.reason.reachable), timing=None).outcome
        is Outcome.SOLVED
    )


# an edge that fails the second look


@pytest.mark.parametrize("law", ["singularity-free", "nominal", "fixed-time"])
def test_an_edge_that_fails_is_removed_and_the_field_heals(small, monkeypatch, law):
    before = plan(request=small, timing=None)
    i, j = before.path_nodes[1:3]
    collide(monkeypatch, before.roadmap, np.array([[i, j]]))
    starts = []
    real = gabf.heal
    monkeypatch.setattr(gabf, "heal", lambda net, x, law: starts.append(gabf.raise_start(net, x)) or real(net, x, law))
    after = plan(request=small.with_options(law=law), timing=None)
    assert after.edges_removed == 1
    assert_sound(after)
    assert (int(i), int(j)) not in set(itertools.pairwise(after.path_nodes.tolist()))
    assert len(after.roadmap.edges) == len(before.roadmap.edges) - 1
    with pytest.raises(KeyError):
        after.roadmap.edge_index(int(i), int(j))
    assert len(after.network.arcs_between(int(i), int(j))) == len(after.network.arcs_between(int(j), int(i))) == 0
    # the second solve starts from the x of the first one, raised where a path went over the edge that is gone
    raised = starts[0] != before.cost_to_go.x
    assert np.all(starts[0] >= before.cost_to_go.x)
    assert raised[int(i)]
    assert 0 < raised.sum() < 0.5 * len(raised)
    # and heals to what a fresh solve of the smaller network finds
    fresh = gabf.oracle(build_network(after.roadmap, small.quality.beta, clearance=after.clearance_kept))
    np.testing.assert_array_equal(after.cost_to_go.x, fresh)
    assert after.cost.total >= before.cost.total


# interrupted


def test_stop_returns_the_partial_plan(small):
    found = plan(request=small, progress=Progress(stop=lambda: True), timing=None)
    assert found.outcome is Outcome.INTERRUPTED
    assert found.outcome.exit_code == 130
    assert len(found.roadmap.nodes) == 2
    assert found.network is None
    assert found.cost is None


# refusals of requests


CART = """
obstacles:
  - {name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}
  - {name: cart, type: box, size: [0.2, 0.2, 0.2], motion: [
      {t: 0, position: [1.2, 0.9, 0]}, {t: 3, position: [0.3, -0.5, 0]}, {t: 6, position: [0.3, -0.5, 0]},
      {t: 9, position: [-1.5, -1.5, 0]}]}
  - {name: dog, type: sphere, radius: 0.05, position: [-1.2, 1.2, 0], speed_limit: 0.2}
states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}}
"""


@pytest.fixture(scope="module")
def moving(tmp_path_factory) -> PlanRequest:
    path = tmp_path_factory.mktemp("moving") / "cart.yaml"
    path.write_text(CART)
    return PlanRequest.from_options(robot="planar_2r", scene=str(path), nodes=80)


def test_among_moving_obstacles_the_plan_is_in_time(moving, tmp_path):
    """Nothing touches at many moments, by FCL; the files hold moving obstacles, waits and horizon."""
    found = plan(request=moving, timing=TimingRequest())
    assert found.outcome is Outcome.SOLVED
    assert found.trajectory.proven
    cart = found.scene.moving[0]
    for t in np.linspace(0, found.trajectory.duration + 10, 300):
        there = replace(found.scene, obstacles=(*found.scene.obstacles, cart.standing(t)), moving=())
        assert is_free(make_checker(found.robot, there), found.trajectory.at(t)[0])
    network = build_network(found.roadmap, moving.quality.beta)
    cost = sum(
        network.arcs.take(network.arcs_between(i, j))(np.zeros(1))[0] for i, j in itertools.pairwise(found.path_nodes)
    )
    np.testing.assert_allclose(found.cost.total, cost)
    add_alternatives(found).save(tmp_path)
    record = json.loads((tmp_path / "plan.json").read_text())
    times = record["in_time"]["waypoints"]
    assert len(record["path"]) == len(times["arrivals"]) == len(times["departures"])
    assert (np.array(times["departures"]) >= times["arrivals"]).all()
    assert times["arrivals"][-1] == pytest.approx(record["trajectory"]["duration"], abs=1e-9)
    assert record["in_time"]["moving"] == ["cart"]
    assert record["in_time"]["horizon"]["speed_limits"] == {"dog": 0.2}
    assert Trajectory.load(tmp_path).proof["horizon"] == record["in_time"]["horizon"]
    np.testing.assert_allclose(Trajectory.load(tmp_path).at(times["arrivals"]), record["path"], atol=1e-9)
    RECORD.validate_python(record)
