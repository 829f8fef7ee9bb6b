"""A session in a changing world: what it believes is what proving everything says, whatever happened before."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import planner
from planner.base.errors import PlannerError, SceneError, StateError
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.problem.outcome import Outcome
from planner.roadmap.roadmap import edge_motions
from planner.roadmap.storage import load_roadmap, same_world
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle, Sphere
from planner.search.manipulability_floor import find_violation
from planner.session.live_roadmap import LiveRoadmap
from planner.session.session import Session
from planner.trajectory.measure import path_contact, path_manipulability
from tests.browser import page_data
from tests.coal_judge import CoalWorld
from tests.session.test_live_world import change_at_random
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap

BALL = Obstacle("ball", Sphere(0.08), pose([-0.5, 0.5, 0]))


def fresh(**options) -> Session:
    return Session(load("planar_2r"), make_post().world.scene, roadmap=post_roadmap(), join_motions=300, **options)


def everything_decided(session: Session) -> LiveRoadmap:
    now = session.live
    return now.prove(np.flatnonzero(now.proofs.open))


def require_true(session: Session) -> None:
    """What is free is what a prover of the whole world proves, and clearances are no larger than distances."""
    now = everything_decided(session)
    checker = make_checker(session.robot, session.scene)
    proofs = EdgeProver(checker).prove(*edge_motions(now.roadmap, session.robot, np.arange(len(now.roadmap.edges))))
    np.testing.assert_array_equal(now.proofs.free, proofs.free)
    if session.scene.allowed:
        return  # the judge measures what may touch, too
    world, roadmap = CoalWorld(checker.world), now.with_edges(now.proofs.free)
    for row in range(0, len(roadmap.edges), 7):
        (start,), (delta,) = edge_motions(roadmap, session.robot, np.array([row]))
        assert roadmap.clearance[row] <= world.nearest_along(start, delta, 0.05, 0.005) + 1e-5


@pytest.mark.parametrize("seed", range(6))
def test_whatever_changes_the_edges_are_those_that_a_proof_of_all_gives(seed: int) -> None:
    rng, session = np.random.default_rng(seed), fresh()
    session.plan(POST_START, POST_GOAL, timing=None)
    for _ in range(12):
        change_at_random(session.world, rng)
        try:
            answer = session.replan()
        except (SceneError, StateError):
            continue
        assert (answer.max_error_vs_oracle or 0.0) <= 1e-9
        if answer.solved:
            assert path_contact(make_checker(session.robot, session.scene, "coal"), answer.path) is None
    require_true(session)


def test_what_an_obstacle_blocks_comes_back_without_a_check_when_it_goes() -> None:
    session = fresh()
    first = session.plan(POST_START, POST_GOAL, timing=None)
    before = session.roadmap
    session.add(BALL)
    now = everything_decided(session)
    lost = int(now.proofs.blocked.sum())
    assert lost > 0
    session._live = now
    change = session.remove("ball")
    assert (change.regained, change.proven) == (lost, 0)
    np.testing.assert_array_equal(session.roadmap.edges, before.edges)
    assert same_world(session.roadmap, session.checker)
    again = session.replan()
    np.testing.assert_array_equal(again.path, first.path)
    assert again.edges.proven == 0


def test_a_short_move_spends_clearance_only() -> None:
    session = fresh()
    session.plan(POST_START, POST_GOAL, timing=None)
    clearance = session.live.proofs.clearance
    change = session.move("thing0", position=[0.75, 0.004, 0])
    assert change.opened == int((clearance <= 0.004 + 1e-9).sum())
    assert change.opened < len(clearance)
    assert change.removed == change.proven == 0


BAD = {
    "an unknown name": (lambda s: s.move("nothing", position=[0, 0, 1]), "obstacles are thing0"),
    "a NaN": (lambda s: s.move("thing0", position=[np.nan, 0, 0]), "position"),
    "a name that is taken": (lambda s: s.add(Obstacle("link_1", Sphere(0.1), pose([3, 0, 0]))), "must be new"),
    "nowhere": (lambda s: Session(s.robot, Scene("none", (BALL,))).attach("ball", "link_2"), "at="),
    "a law": (lambda s: Session(s.robot, s.scene, law="prescribed-time"), "heal"),
    "an option": (lambda s: Session("planar_2r", "empty", nods=3), "did you mean 'nodes'"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_call_is_a_sentence_and_leaves_the_session_as_it_was(name: str) -> None:
    session = fresh()
    first = session.plan(POST_START, POST_GOAL, timing=None)
    before = session._live, session.world.now
    call, words = BAD[name]
    with pytest.raises(PlannerError, match=words) as caught:
        call(session)
    assert "\n" not in str(caught.value)
    assert (session._live, session.world.now) == before
    np.testing.assert_array_equal(session.replan().path, first.path)


def test_nothing_grows_over_many_changes_and_queries() -> None:
    session, rng = fresh(), np.random.default_rng(0)
    session.plan(POST_START, POST_GOAL, timing=None)
    lasting = session.live.lasting
    for step in range(60):
        session.add(Obstacle(f"guest {step}", Sphere(0.02), pose([2.0, 0, 0])))
        session.remove(f"guest {step}")
        session.plan(POST_START + rng.uniform(-0.1, 0.1, 2), POST_GOAL, timing=None)
    session.plan(POST_START, POST_GOAL, timing=None)  # adds nothing: the ends are nodes
    now = session.live
    assert len(now.roadmap.nodes) <= 1.5 * lasting + 2
    assert now.proofs.known.shape == (len(now.roadmap.edges), 2)
    assert session.scene.allowed == frozenset()
    require_true(session)


def test_a_closed_session_ends_what_is_under_way() -> None:
    session = fresh()
    session.plan(POST_START, POST_GOAL, timing=None)
    before = session._live
    session.close()
    for call in (
        lambda: session.plan(POST_START, POST_GOAL, timing=None),
        session.replan,
        lambda: session.remove("post"),
    ):
        with pytest.raises(PlannerError, match="session is closed"):
            call()
        assert session._live is before


@pytest.mark.parametrize("seed", range(1))
def test_whether_the_path_holds_is_what_a_check_of_it_says(seed: int) -> None:
    rng, session = np.random.default_rng(seed), fresh()
    assert not session.holds()
    session.plan(POST_START, POST_GOAL, timing=None)
    assert session.holds()
    said = set()
    session.add(Obstacle("box", Box((0.1, 0.1, 0.2)), pose([3.0, 0.0, 0.0])))
    before = session.checker
    for _ in range(25):
        session.world.restore(before)
        answer = session.plan(POST_START, POST_GOAL, timing=None)
        try:
            session.move("box", [*rng.uniform(-1, 1, 2), 0.0])
        except SceneError:
            continue
        holds = session.holds()
        said.add(holds)
        assert session.holds() is holds
        contact = path_contact(make_checker(session.robot, session.scene), answer.path)
        if holds:
            assert contact is None
            require_true(session)
        try:
            assert (session.replan().max_error_vs_oracle or 0.0) < 1e-9
        except StateError:  # the start or the goal is in collision
            assert not holds
    assert said == {True, False}


@pytest.mark.parametrize("validator", ["plan"], indirect=True)
def test_a_sessions_plan_is_a_plan_with_its_files_and_its_page(
    validator: jsonschema.Draft202012Validator, tmp_path: Path
) -> None:
    session = fresh(collision="coal")
    first = session.plan(POST_START, POST_GOAL, beta=0.3, timing=None)
    session.add(BALL)
    found = session.replan()
    for made in (first, found):
        made.save(tmp_path)
        record = json.loads((tmp_path / "plan.json").read_text())
        validator.validate(record)
        np.testing.assert_allclose(record["path"], made.path)
        assert record["config"]["beta"] == 0.3
        assert record["gabf"]["max_error_vs_oracle"] <= 1e-9
        assert record["roadmap"]["edges_certified"] == int(made.roadmap.proven.sum())
        kept = load_roadmap(tmp_path / "roadmap.npz")
        low, high = np.sort(np.stack([made.path_nodes[:-1], made.path_nodes[1:]]), axis=0)
        assert all(kept.proven[kept.edge_index(int(i), int(j))] for i, j in zip(low, high, strict=True))
        assert planner.check(made.path, checker=made.checker).ok
        assert made.message in json.dumps(page_data(tmp_path / "plan.html"), ensure_ascii=False)
    assert not found.roadmap.proven.all()  # what was opened and not asked for since is not passed off as proven
    assert found.edges.proven > 0
    assert found.seconds > 0.0


def test_a_session_plans_in_time_and_replans_as_it_was_asked() -> None:
    session = fresh()
    made = session.plan(POST_START, POST_GOAL)
    assert made.trajectory is not None
    assert planner.check(made).proven
    np.testing.assert_array_equal(made.trajectory.at(0.0)[0], POST_START)
    assert session.replan().trajectory is not None
    assert session.plan(POST_START, POST_GOAL, timing=None).trajectory is None
    assert session.replan().trajectory is None


def test_a_session_keeps_a_floor() -> None:
    """Each path is looked at densely by the one function that judges the floors of plans."""
    plain = Session("panda", "shelf", nodes=60, collision="coal", seed=6)
    free = plain.plan(beta=1.0, timing=None)
    w = path_manipulability(free.robot, free.path)
    tried = np.append(np.linspace(w.min(), w.max(), 12), 0.08)
    floors = [floor for floor in tried.tolist() if find_violation(free.robot, free.path, floor) is not None]
    assert floors, "without a floor the path dips below one"
    kept_to = 0
    for floor in floors:
        session = Session("panda", "shelf", roadmap=plain.roadmap, collision="coal", min_manipulability=floor)
        for kept in (session.plan(beta=1.0, timing=None), session.replan(), session.plan(beta=0.3, timing=None)):
            assert kept.outcome in (Outcome.SOLVED, Outcome.TOO_SINGULAR)
            assert (kept.max_error_vs_oracle or 0.0) <= 1e-9
            if kept.solved:
                assert find_violation(kept.robot, kept.path, floor) is None
                assert kept.to_dict()["manipulability"]["floor"]["holds"]
                assert planner.check(kept.path, checker=kept.checker).ok
                kept_to += 1
    assert kept_to >= len(floors)
    floored = Session("panda", "shelf", min_manipulability=0.01)
    floored.add(MovingObstacle("cart", Sphere(0.1), KnownMotion([0, 9], [pose([3.0, 0.0, 0.0])] * 2)))
    with pytest.raises(SceneError, match="must be left out"):
        floored.plan()
