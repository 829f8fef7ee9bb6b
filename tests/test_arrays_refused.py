"""Every public function that takes arrays refuses other shapes and numbers that are not finite, in one sentence.

A table of facts, one for each place where arrays enter the package: none ends in a traceback of a library, none in an
answer.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

import planner
from planner.base.errors import PlannerError
from planner.collision.checker import CollisionChecker, contact_at, is_free
from planner.collision.edge_prover import EdgeProver
from planner.collision.path_moves import cheapest_chain, first_free
from planner.constraints.floor import prove_floor
from planner.kinematics.manipulability import manipulability
from planner.trajectory.limits import KINDS
from tests.worlds import load, make_post, post_roadmap

NAN, EYE = np.nan, np.eye(4)
ROBOT = load("planar_2r")
FINE = np.array([[-1.0, 0.8], [-1.1, 0.9], [-1.0, 1.0]])
BAD_ROWS = {
    "one column": FINE[:, :1],
    "three columns": np.zeros((1000, 3)),
    "a NaN": np.array([[-1.0, 0.8], [NAN, 0.9]]),
    "infinite": np.array([[-1.0, np.inf]]),
    "far beyond any joint": np.array([[-1.0, 1e9]]),
    "three dimensions": FINE[None],
    "a number": 3.0,
    "text": [["a", "b"]],
    "ragged": [[0.0, 0.0], [0.0]],
    "complex": FINE * 1j,
    "nothing": None,
}


def checker() -> CollisionChecker:
    return make_post()


def prover() -> EdgeProver:
    return EdgeProver(make_post())


ROWS: dict[str, Callable[[object], object]] = {
    "first_contact": lambda q: checker().first_contact(q),
    "first_contact_along": lambda q: checker().first_contact_along(q, np.ones(1)),
    "contact_at": lambda q: contact_at(checker(), q),
    "is_free": lambda q: is_free(checker(), q),
    "time_path": lambda q: planner.time_path(q, checker()),
    "prove, starts": lambda q: prover().prove(q, q),
    "prove, motions": lambda q: prover().prove(FINE[:1], q),
    "free": lambda q: prover().free(FINE[:1], q),
    "first_free": lambda q: first_free(prover(), FINE[:2], q, np.ones(2, dtype=int), np.ones(2, dtype=int)),
    "cheapest_chain": lambda q: cheapest_chain(prover(), q, np.ones((len(FINE), len(FINE)))),
    "prove_curves": lambda q: prover().prove_curves(q),
    "prove_floor": lambda q: prove_floor(ROBOT, q, 0.1),
    "build_roadmap, start": lambda q: planner.build_roadmap(ROBOT, checker(), q, FINE[0], nodes=4),
    "build_roadmap, goal": lambda q: planner.build_roadmap(ROBOT, checker(), FINE[0], q, nodes=4),
    "plan": lambda q: planner.plan(robot="planar_2r", scene="empty", start=q, goal=FINE[0], nodes=4, timing=None),
    "Session.plan": lambda q: planner.Session("planar_2r", "empty", nodes=4).plan(q, FINE[0], timing=None),
    "Trajectory.from_points": lambda q: planner.Trajectory.from_points(ROBOT.joints, [0.0, 1.0, 2.0], q),
}
THREE_DIMENSIONS_ARE_FINE = ("prove_curves", "prove_floor")


@pytest.mark.parametrize("rows", BAD_ROWS)
@pytest.mark.parametrize("name", ROWS)
def test_rows_of_joint_values(name: str, rows: str) -> None:
    if rows == "three dimensions" and name in THREE_DIMENSIONS_ARE_FINE:
        return
    require_sentence(partial(ROWS[name], BAD_ROWS[rows]))


def require_sentence(call: Callable[[], object]) -> None:
    with pytest.raises(PlannerError) as caught:
        call()
    text = str(caught.value)
    assert 10 < len(text) < 400
    assert "\n" not in text
    assert any(mark in text for mark in ":;,"), "what is wrong, and the remedy"


def network() -> planner.gabf.Network:
    return planner.gabf.Network.from_arcs([1, 2, 2], [0, 0, 1], np.ones(3), [0], 3, node_cost=np.ones(3))


def obstacle(**other: object) -> Callable[[], object]:
    given = {"name": "x", "shape": planner.Sphere(0.1), "placement": EYE} | other
    return lambda: planner.Obstacle(**given)


def limits(**other: object) -> Callable[[], object]:
    given = {kind: np.ones(2) for kind in ("velocity", "acceleration", "jerk")} | other
    return lambda: planner.MotionLimits(ROBOT.joints, source=dict.fromkeys(given, "test"), **given)


def through(times: object, *columns: object) -> Callable[[], object]:
    return lambda: planner.Trajectory.from_points(ROBOT.joints, times, *columns)


TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
SCENE = planner.Scene("x", (planner.Obstacle("box", planner.Box((0.1, 0.1, 0.1)), planner.pose([0, 0, 3])),))
OTHER = planner.MotionLimits(("a", "b"), *np.ones((3, 2)), source=dict.fromkeys(KINDS, "test"))
MOTION = planner.Trajectory.from_points(ROBOT.joints, np.array([0.0, 1.0]), FINE[:2], np.zeros((2, 2)))
CALLS: dict[str, Callable[[], object]] = {
    "a box with NaN": lambda: planner.Box((NAN, 1, 1)),
    "a box as wide as the world": lambda: planner.Box((1, 1, 1e9)),
    "a sphere with NaN": lambda: planner.Sphere(NAN),
    "a mesh with an index too large": lambda: planner.Mesh(TRIANGLE, np.array([[0, 1, 3]])),
    "a mesh with NaN": lambda: planner.Mesh(NAN * TRIANGLE, np.array([[0, 1, 2]])),
    "an obstacle nowhere": obstacle(placement=np.full((4, 4), NAN)),
    "an obstacle that is stretched": obstacle(placement=np.diag([2.0, 2.0, 2.0, 1.0])),
    "an obstacle with a NaN speed": obstacle(speed_limit=NAN),
    "pose, position": lambda: planner.pose([NAN, 0, 0]),
    "a known motion, times": lambda: planner.KnownMotion([[0]], [EYE]),
    "a known motion, mirrored": lambda: planner.KnownMotion([0], [np.diag([-1.0, 1, 1, 1])]),
    "time_path, no waypoint": lambda: planner.time_path(np.zeros((0, 2)), checker()),
    "make_checker, text as margin": lambda: planner.make_checker(ROBOT, SCENE, margin="a"),
    "time_path, limits of another robot": lambda: planner.time_path(FINE, checker(), limits=OTHER),
    "robot, base with NaN": lambda: planner.Robot.load("planar_2r", base=np.full((4, 4), NAN)),
    "network of a roadmap, NaN as clearance": lambda: planner.build_network(post_roadmap(), 0.5, NAN),
    "limits, one": limits(velocity=np.ones(1)),
    "limits, NaN": limits(jerk=np.array([1.0, NAN])),
    "through, NaN": through([0.0, NAN], FINE[:2]),
    "through, equal times": through([0.0, 0.0], FINE[:2]),
    "through, velocities": through([0.0, 1.0], FINE[:2], np.zeros((2, 1))),
    "export, another format": lambda: planner.export(MOTION, "CSV"),
    "at, NaN": lambda: MOTION.at(NAN),
    "stop_at": lambda: planner.stop_at(planner.time_path(FINE, checker(), time_law="blended"), NAN),
    "prove, unequal": lambda: prover().prove(FINE[:2], FINE[:1]),
    "prove, resolution": lambda: prover().prove(FINE[:1], 0.1 * FINE[:1], resolution=NAN),
    "prove, some pairs": lambda: prover().only(np.zeros(100, dtype=bool)),
    "first_free, motions": lambda: first_free(prover(), FINE, FINE, np.array([7]), np.array([1])),
    "cheapest_chain, prices": lambda: cheapest_chain(prover(), FINE, np.ones((2, 2))),
    "prove_floor, floor": lambda: prove_floor(ROBOT, np.zeros((1, 2, 2)), NAN),
    "roadmap, no start": lambda: planner.build_roadmap(ROBOT, checker(), np.zeros((0, 2)), FINE[0], 4),
    "check, far beyond any joint": lambda: planner.check([[-1.0, 0.8], [-1.0, 1e300]], checker=checker()),
    "checker, margin": lambda: planner.make_checker(ROBOT, SCENE, margin=NAN),
    "session, move": lambda: planner.Session(ROBOT, SCENE, nodes=4).move("box", position=[NAN, 0, 0]),
    "kinematics, w": lambda: manipulability(ROBOT, np.zeros((1000, 1))),
    "network, weights of text": lambda: planner.gabf.Network.from_arcs([1], [0], ["a"], [0], 2),
    "network, without arcs": lambda: network().without_arcs(np.array([3])),
    "solve, x0": lambda: planner.gabf.solve(network(), x0=np.array([0.0, NAN, 1.0])),
    "extract_path, field": lambda: planner.gabf.extract_path(network(), np.ones(2), 1),
    "paths_from, start": lambda: planner.paths_from(network(), planner.gabf.solve(network()), [0.5]),
    "cheapest_path, text": lambda: planner.gabf.cheapest_path(planner.gabf.solve(network()), "a"),
    "raise_start, complex": lambda: planner.gabf.raise_start(network(), 1j * np.ones(3)),
    "bellman_operator": lambda: planner.gabf.bellman_operator(network(), np.array([0.0, NAN, 1.0])),
}


@pytest.mark.parametrize("name", CALLS)
def test_other_arrays_and_numbers(name: str) -> None:
    require_sentence(CALLS[name])


@pytest.mark.parametrize("q", [[-1.0, 0.8], (-1.0, 0.8), FINE, FINE[:1].tolist(), np.asfortranarray(FINE), FINE[::2]])
def test_arrays_of_any_layout_are_accepted(q: object) -> None:
    assert checker().first_contact(q) is None
    assert planner.time_path(np.atleast_2d(np.asarray(q)), checker(), time_law="blended").proven


def test_sizes_are_plain_numbers() -> None:
    box = planner.Box(np.array([1, 2, 3]))
    assert box == planner.Box((1.0, 2.0, 3.0))
    assert hash(box) == hash(planner.Box([1, 2, 3]))
    assert planner.Sphere(np.float32(0.5)) == planner.Sphere(0.5)
