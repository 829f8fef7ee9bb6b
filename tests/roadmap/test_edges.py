"""What an edge's certificate promises: less room than there is, for every edge, however its proof came about."""

from dataclasses import replace

import numpy as np
import pytest

from planner.collision import second_checker
from planner.collision.checker import is_free
from planner.collision.edge_prover import EdgeProver
from planner.collision.recheck import sample_segment
from planner.kinematics.manipulability import manipulability
from planner.roadmap.edges import MotionChecker, RecordingProver, enlarge_roadmap
from planner.roadmap.shortcuts import split_motions
from tests.coal_judge import CoalWorld
from tests.worlds import checker_of, load, make_post, post_roadmap, random_q, small_plan


@pytest.mark.parametrize("which", ["planar_2r", "iiwa14"])
def test_the_clearance_of_every_edge_is_there(which):
    roadmap = post_roadmap() if which == "planar_2r" else small_plan().roadmap
    checker = make_post() if which == "planar_2r" else checker_of("iiwa14", "paper")
    world, robot = CoalWorld(checker.world), checker.robot
    assert (roadmap.samples > 0).all()
    assert (roadmap.clearance >= 0).all()
    assert roadmap.clearance.max() > 0.01
    for row in range(0, len(roadmap.edges), 2 if which == "planar_2r" else 30):
        i, j = roadmap.edges[row]
        delta = robot.difference(roadmap.nodes[i], roadmap.nodes[j])
        nearest = world.nearest_along(roadmap.nodes[i], delta, 0.02, 0.01)
        assert nearest >= roadmap.origin.margin + roadmap.clearance[row] - 1e-6


@pytest.fixture
def proven():
    """Free segments of planar_2r as nodes and edges, with what a plain prover says of them."""
    q = random_q(load("planar_2r"), 40)
    edges = np.array([(k, k + 1) for k in range(0, 40, 2)])
    proofs = EdgeProver(make_post()).prove(q[edges[:, 0]], q[edges[:, 1]] - q[edges[:, 0]])
    return q, edges[proofs.free], proofs.clearance[proofs.free], proofs.samples[proofs.free]


def test_what_was_proven_is_remembered_from_either_end(proven, monkeypatch):
    q, edges, clearance, samples = proven
    prover = RecordingProver(make_post())
    half = len(edges) // 2
    for rows, (first, second) in ((slice(0, half), (0, 1)), (slice(half, None), (1, 0))):
        a, b = q[edges[rows, first]], q[edges[rows, second]]
        assert prover.prove(a, b - a).free.all()
    monkeypatch.setattr(EdgeProver, "prove", lambda *_: pytest.fail("proven twice"))
    found, looked = prover.certificates(q, edges)
    np.testing.assert_array_equal(found[:half], np.maximum(clearance[:half], 0))
    np.testing.assert_array_equal(looked[:half], samples[:half])


@pytest.mark.parametrize("remembered", [True, False])
def test_what_is_proven_one_after_the_other_or_never_has_its_certificate(proven, remembered):
    q, edges, clearance, samples = proven
    prover = RecordingProver(make_post())
    is_free = prover.each_free()
    assert not remembered or all(is_free(q[i], q[j] - q[i]) for i, j in edges)
    found, looked = prover.certificates(q, edges)
    np.testing.assert_array_equal(found, np.maximum(clearance, 0))
    np.testing.assert_array_equal(looked, samples)


def test_pieces_have_the_certificate_of_the_motion_that_they_are_of(proven, monkeypatch):
    q, edges, clearance, _ = proven
    prover, world = RecordingProver(make_post()), CoalWorld(make_post().world)
    a, b = q[edges.T]
    assert prover.free(a, b - a).all()
    monkeypatch.setattr(EdgeProver, "prove", lambda *_: pytest.fail("proven twice"))
    for first, last, promised in zip(a, b, clearance, strict=True):
        rows = split_motions(prover, np.array([first, last]), 0.3)
        backwards = np.arange(len(rows))[:0:-1]
        pairs = np.column_stack([backwards, backwards - 1])
        found, looked = prover.certificates(rows, pairs)
        assert (found == max(promised, 0.0)).all()
        assert (looked > 0).all()
        for i, j in pairs:
            assert world.nearest_along(rows[i], rows[j] - rows[i], 0.02, 0.01) >= promised - 1e-6


def test_nothing_is_claimed_for_what_cannot_be_proven():
    """Neither for the motion nor for its pieces."""
    prover = RecordingProver(make_post())
    across = np.array([[-1.0, 0.0], [1.0, 0.0]])  # straight through the post
    for rows, edge in ((across, [[0, 1]]), (split_motions(prover, across, 0.5), [[1, 2]])):
        free, samples = prover.certificates(rows, np.array(edge))
        assert (free.tolist(), samples.tolist()) == ([0.0], [0])


def test_motions_with_a_floor_refuse_what_dips() -> None:
    robot, prover = load("planar_2r"), EdgeProver(checker_of("planar_2r"))
    a, through_straight = np.array([0.0, 0.8]), np.array([0.0, -1.6])
    assert MotionChecker(prover).is_proven(a, through_straight)
    assert not MotionChecker(prover, 0.01).is_proven(a, through_straight)
    assert MotionChecker(prover, 0.01).is_proven(a, np.array([1.0, 0.3]))
    assert not MotionChecker(prover, 0.01).make_state_check(0.05)(a, through_straight)
    assert manipulability(robot, a[None])[0] > 0.01


def test_the_shortest_way_turns_as_the_path_does() -> None:
    """A shortcut by half a turn or more would be told by its ends, and they tell the motion the other way round."""
    robot, prover = load("kinova"), EdgeProver(checker_of("kinova"))
    joint = int(np.flatnonzero(robot.continuous)[0])
    for turn in (1.0, np.pi, 1.5 * np.pi, -2.0 * np.pi, 7.0):
        path = np.repeat(robot.home[None], 41, axis=0)
        path[:, joint] += np.linspace(0.0, turn, len(path))
        path = robot.normalise(path)
        short = MotionChecker(prover).shorten_path(path)
        assert len(short) < 10
        np.testing.assert_array_equal(short[[0, -1]], path[[0, -1]])
        np.testing.assert_allclose(robot.unwound(short)[-1] - path[0], robot.unwound(path)[-1] - path[0], atol=1e-9)


def test_what_looks_free_may_touch_and_what_is_proven_does_not() -> None:
    """Of random motions past the post, by coal every millimetre: proven ones are free, sampled ones nearly all."""
    checker = make_post()
    motions, rng = MotionChecker(EdgeProver(checker)), np.random.default_rng(0)
    looks = motions.make_state_check(0.05)
    starts = [q for q in rng.uniform(-2.5, 2.5, size=(60, 2)) if is_free(checker, q)]
    verdicts = []
    for q in starts:
        delta = rng.normal(size=2) * 0.6
        if (np.abs(q + delta) > 2.8).any():
            continue
        truth = sample_segment(second_checker(checker), q, delta, 1e-3) is None
        verdicts.append((truth, motions.is_proven(q, delta), looks(q, delta)))
    assert {truth for truth, _, _ in verdicts} == {True, False}
    for truth, proven, looked in verdicts:
        assert truth or not proven
        assert looked or not proven, "what is proven looks free, too"
    assert np.mean([truth == looked for truth, _, looked in verdicts]) > 0.9


def free_pairs(prover: RecordingProver, count: int) -> np.ndarray:
    """(count, 2) nodes of the post's roadmap that a proven motion joins, without an edge between them as yet."""
    nodes, edges = post_roadmap().nodes, set(map(tuple, post_roadmap().edges.tolist()))
    pairs = np.array([(i, j) for j in range(len(nodes)) for i in range(j) if (i, j) not in edges])
    a, b = nodes[pairs[:, 0]], nodes[pairs[:, 1]]
    return pairs[prover.free(a, prover.robot.difference(a, b))][:count]


def test_edges_that_are_there_stay_and_new_ones_come_once() -> None:
    old, prover = post_roadmap(), RecordingProver(make_post())
    new = free_pairs(prover, 5)
    made = enlarge_roadmap(old, prover, old.nodes[:0], np.concatenate([new, old.edges[:7], new]))
    assert sorted(map(tuple, made.edges.tolist())) == sorted(map(tuple, [*old.edges.tolist(), *new.tolist()]))
    rows = [made.edge_index(i, j) for i, j in old.edges.tolist()]
    for name in ("proven", "joint_length", "tool_length", "clearance", "samples", "edge_manipulability"):
        np.testing.assert_array_equal(getattr(made, name)[rows], getattr(old, name))
    assert made.proven.all()
    np.testing.assert_array_equal(made.edges, np.unique(made.edges, axis=0))  # sorted


@pytest.mark.parametrize("margin", [0.0, 0.01])
def test_the_margin_is_the_weaker_one_and_clearances_count_from_it(margin: float) -> None:
    old, prover = post_roadmap(), RecordingProver(make_post())
    assert prover.world.margin == 0.0
    with_margin = replace(old, origin=replace(old.origin, margin=margin))
    new = free_pairs(prover, 1)
    made = enlarge_roadmap(with_margin, prover, old.nodes[:0], new)
    assert made.origin.margin == 0.0
    rows = [made.edge_index(i, j) for i, j in old.edges.tolist()]
    np.testing.assert_allclose(made.clearance[rows], old.clearance + margin, rtol=0, atol=1e-15)
    same = enlarge_roadmap(old, prover, old.nodes[:0], new)
    assert made.clearance[made.edge_index(*new[0])] == same.clearance[same.edge_index(*new[0])]
