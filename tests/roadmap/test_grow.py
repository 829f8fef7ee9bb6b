"""Growing with OMPL: proven motions only, by seed, by counts."""

import itertools

import numpy as np
import pytest

from planner.base.errors import StateError
from planner.base.progress import Progress
from planner.base.resolutions import PROOF
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.recheck import sample_segment
from planner.kinematics.manipulability import manipulability
from planner.roadmap.build import build_roadmap
from planner.roadmap.grow import Growth, GrowthSettings, ascend_manipulability, grow
from planner.roadmap.roadmap import component_labels
from planner.robot.poses import pose
from planner.robot.shapes import Sphere
from planner.trajectory.measure import path_contact
from tests.worlds import POST_GOAL, POST_START, checker_of, load, scene_of

A, B = POST_START[None], POST_GOAL[None]


def grown(checker, nodes=60, seed=0, starts=A, goals=B, **more) -> Growth:
    settings = GrowthSettings(**more)
    return grow(EdgeProver(checker), starts, goals, nodes, seed, settings)


def test_a_forest_of_proven_motions(post):
    growth, robot = grown(post), load("planar_2r")
    assert growth.joined
    assert len(growth.nodes) == 60
    np.testing.assert_array_equal(growth.nodes[growth.starts], A)
    np.testing.assert_array_equal(growth.nodes[growth.goals], B)
    assert ((growth.nodes >= robot.lower) & (growth.nodes <= robot.upper)).all()
    assert (growth.edges[:, 0] < growth.edges[:, 1]).all()
    assert len(np.unique(growth.edges, axis=0)) == len(growth.edges)
    assert len(np.unique(growth.nodes, axis=0)) == len(growth.nodes)
    labels = component_labels(len(growth.nodes), growth.edges)
    assert labels[growth.starts[0]] == labels[growth.goals[0]]
    assert labels.max() == 0
    for i, j in growth.edges:
        assert sample_segment(post, growth.nodes[i], growth.nodes[j] - growth.nodes[i], 1e-3) is None


def test_steps_keep_the_range(post):
    growth = grown(post, range=0.4)
    length = np.linalg.norm(growth.nodes[growth.edges[:, 0]] - growth.nodes[growth.edges[:, 1]], axis=1)
    assert length.max() <= 0.4 + 1e-9
    assert length.max() > 0.2


def test_progress_counts_up_to_the_nodes(post):
    heard = []
    growth = grow(
        EdgeProver(post),
        A,
        B,
        50,
        0,
        GrowthSettings(),
        Progress(lambda stage, done, total: heard.append((stage, done, total))),
    )
    done = [count for stage, count, total in heard if stage == "roadmap" and total == 50]
    first = [count == total for stage, count, total in heard if stage == "first path"]
    assert first[-1]
    assert done == sorted(done)
    assert done[-1] == 50 == len(growth.nodes)


class Doubting(EdgeProver):
    """Proves no motion from a node on a chessboard's black squares, whatever is in the way."""

    def prove(self, start, delta, resolution=PROOF, contacts=True):
        proofs = super().prove(start, delta, resolution, contacts)
        proofs.verdict[self.doubts(start)] = Verdict.UNDECIDED
        return proofs

    @staticmethod
    def doubts(start):
        return np.floor(3.0 * np.atleast_2d(start)).sum(axis=1) % 2 == 1


def test_what_hangs_on_a_motion_without_a_proof_is_dropped():
    checker, goals = make_checker(load("planar_2r"), scene_of()), np.zeros((0, 2))
    root = np.array([[0.1, 0.1]])
    assert not Doubting.doubts(root).any()
    growth = grow(Doubting(checker), root, goals, 300, 0, GrowthSettings())
    assert len(growth.nodes) == 300
    assert component_labels(300, growth.edges).max() == 0
    doubted = Doubting.doubts(growth.nodes)
    assert doubted.sum() > 50  # they were reached, and nothing led on from them
    a, b = growth.edges.T
    assert not (doubted[a] & doubted[b]).any()


def test_ends_at_their_limits_up_to_rounding_are_joined():
    """OMPL forgives less than we do: what is printed with ten digits was no root for it."""
    robot = load("planar_2r")
    checker = make_checker(robot, scene_of())
    roadmap = build_roadmap(robot, checker, [3.141592654, 0.5], [-3.141592654, 1.0], 60, 0)
    assert (np.abs(roadmap.nodes) <= robot.upper).all()
    assert component_labels(60, roadmap.edges).max() == 0


def test_a_root_that_ompl_refuses_grows_nothing(post):
    growth = grown(post, starts=np.array([[99.0, 0.0]]), goals=np.zeros((0, 2)))
    assert len(growth.nodes) == 1
    assert len(growth.edges) == 0


def test_stop_ends_it_at_once_and_keeps_the_ends(post):
    growth = grow(EdgeProver(post), A, B, 500, 0, GrowthSettings(), Progress(stop=lambda: True))
    assert len(growth.nodes) == 2
    assert len(growth.edges) == 0
    assert not growth.joined


def test_motions_are_bounded(post):
    growth = grown(post, nodes=400, motions_per_node=1)
    assert growth.motions <= 10_000 + 400 + 300
    assert len(growth.nodes) < 400


def test_continuous_joints_stay_within_a_turn_and_wrap():
    robot, checker = load("kinova"), checker_of("kinova")
    start, goal = robot.home.copy(), robot.home.copy()
    start[0], goal[0] = 3.0, -3.0
    growth = grow(EdgeProver(checker), start[None], goal[None], 12, 0, GrowthSettings())
    wraps = robot.continuous
    assert growth.joined
    assert (np.abs(growth.nodes[:, wraps]) <= np.pi + 1e-12).all()
    delta = robot.difference(growth.nodes[growth.edges[:, 0]], growth.nodes[growth.edges[:, 1]])
    assert np.linalg.norm(delta, axis=1).max() <= 0.8 + 1e-9
    crossing = np.abs(growth.nodes[growth.edges[:, 0], 0] - growth.nodes[growth.edges[:, 1], 0]) > np.pi
    assert crossing.any()  # the short way from 3 to -3 leads past pi


# the whole roadmap


@pytest.mark.parametrize("floor", [0.1, 1e9])
def test_ways_up_to_the_floor_are_grown_once(floor):
    robot = load("planar_2r")
    low = np.array([[0.3, 0.02], [-1.0, -0.02]])
    roadmap = build_roadmap(robot, checker_of("planar_2r"), *low, nodes=200, min_manipulability=floor)
    assert len(np.unique(roadmap.edges, axis=0)) == len(roadmap.edges)
    prover = EdgeProver(checker_of("planar_2r"))
    alone = grow(prover, low[:1], low[1:], 2, 0, GrowthSettings(floor=floor))
    known = {q.tobytes() for q in alone.nodes}
    assert all(q.tobytes() in known for q in roadmap.nodes[roadmap.manipulability < floor])
    assert roadmap.is_connected == (floor < 1)


def test_a_ball_in_the_way_of_the_start_is_refused():
    checker = make_checker(load("planar_2r"), scene_of((Sphere(0.1), pose([0.9, 0, 0]))))
    with pytest.raises(StateError, match="start is in collision"):
        build_roadmap(load("planar_2r"), checker, np.zeros(2), B[0], nodes=10)
    with pytest.raises(StateError, match="goal puts joint 'joint_2' at 3, outside its limits"):
        build_roadmap(load("planar_2r"), checker, B[0], np.array([0.0, 3.0]), nodes=10)


@pytest.mark.parametrize("name", ["iiwa14", "panda", "ur5"])
def test_climbing_rises_all_the_way(name: str) -> None:
    robot, checker = load(name), checker_of(name)
    rng, done = np.random.default_rng(2), 0
    for q in rng.uniform(robot.lower, robot.upper, (12, robot.dof)):
        start = float(manipulability(robot, q[None])[0])
        if not checker.bound.is_clear(q[None]) or start > 0.02:
            continue
        way = ascend_manipulability(EdgeProver(checker), q, 0.03)
        share = np.linspace(0, 1, 12)[:, None]
        w = manipulability(robot, np.concatenate([a + share * (b - a) for a, b in itertools.pairwise(way)]))
        assert w.min() >= start - 1e-12
        assert w[-1] >= 0.03
        assert path_contact(checker, way) is None
        done += 1
    assert done
