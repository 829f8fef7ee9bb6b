"""A kept roadmap in another world: what is kept is what a proof of everything keeps, and nothing is proven in vain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.looks import recheck
from planner.construction.repair import first_failure, measures_hold, repair, verify, within_limits
from planner.kinematics.manipulability import manipulability
from planner.models.poses import pose
from planner.models.robot import Robot, with_carried, with_widened_limits
from planner.models.scene import Scene
from planner.models.shapes import Box, Carried, Obstacle, Sphere
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import same_world
from planner.roadmap.world_record import changes, unproven_pairs
from tests.coal_judge import CoalWorld
from tests.random_shapes import box_mesh
from tests.worlds import checker_of, load, make_post, post_roadmap, small_plan

OLD = post_roadmap()
POST, AT = Box((0.1, 0.02, 0.2)), pose([0.75, 0, 0])
BALL = Sphere(0.08), pose([-0.5, 0.5, 0])
FINGER = Carried("link_2", "finger", Sphere(0.05), pose([0.45, 0, 0]), ("link_2",))


def made(robot: Robot | None = None, allowed=frozenset(), margin=0.0, backend="fcl", **obstacles):
    """planar_2r among obstacles by name; those of the roadmap's own scene are thing0."""
    items = tuple(Obstacle(name, shape, place) for name, (shape, place) in obstacles.items())
    return make_checker(robot or load("planar_2r"), Scene("made", items, allowed=allowed), backend, margin)


WORLDS = {
    "as it was": lambda: make_post(),
    "moved": lambda: made(thing0=(POST, pose([0.7, 0.1, 0]))),
    "added": lambda: made(thing0=(POST, AT), ball=BALL),
    "added far away": lambda: made(thing0=(POST, AT), ball=(Sphere(0.3), pose([5, 5, 0]))),
    "removed": lambda: made(),
    "renamed": lambda: made(pillar=(POST, AT)),
    "of another shape": lambda: made(thing0=(Box((0.1, 0.1, 0.2)), AT)),
    "swapped": lambda: made(ball=(Sphere(0.1), pose([0.3, 0.6, 0]))),
    "a mesh added": lambda: made(thing0=(POST, AT), slab=(box_mesh((0.02, 0.3, 0.2)), pose([-0.2, -0.7, 0]))),
    "a larger margin": lambda: made(thing0=(POST, AT), margin=0.01),
    "a larger margin and a ball": lambda: made(thing0=(POST, AT), ball=BALL, margin=0.01),
    "something carried": lambda: made(with_carried(load("planar_2r"), [FINGER]), thing0=(POST, AT)),
    "another place": lambda: made(Robot.load("planar_2r", base=pose([0.1, 0, 0])), thing0=(POST, AT)),
    "by coal": lambda: made(thing0=(POST, pose([0.7, 0.1, 0])), backend="coal"),
}  # fmt: skip


def keys(roadmap: Roadmap) -> set[tuple[bytes, bytes]]:
    """Edges by the values of their ends: what they are whatever the numbers of their nodes."""
    return {(roadmap.nodes[i].tobytes(), roadmap.nodes[j].tobytes()) for i, j in roadmap.edges}


def segments(roadmap: Roadmap, robot: Robot):
    a, b = roadmap.nodes[roadmap.edges[:, 0]], roadmap.nodes[roadmap.edges[:, 1]]
    return a, robot.difference(a, b)


def all_proven_again(roadmap: Roadmap, checker) -> set[tuple[bytes, bytes]]:
    free = EdgeProver(checker).prove(*segments(roadmap, checker.robot)).free
    return keys(roadmap.part(np.ones(len(roadmap.nodes), dtype=bool), free))


@pytest.mark.parametrize("name", WORLDS)
def test_what_is_kept_is_what_proving_everything_keeps(name):
    checker = WORLDS[name]()
    found = repair(OLD, checker)
    assert found is not None
    new = found.roadmap
    assert keys(new) == all_proven_again(OLD, checker)
    assert found.kept + found.proven + found.dropped == len(OLD.edges)
    assert found.kept + found.proven == len(new.edges)
    assert new.proven.all()
    free = [q for q in OLD.nodes if is_free(checker, q)]
    np.testing.assert_array_equal(new.nodes, free)
    assert found.nodes_dropped == len(OLD.nodes) - len(free)
    assert same_world(new, checker)
    assert measures_hold(new, checker.robot)
    again = repair(new, checker)
    assert again is not None
    assert again.roadmap.sha256 == new.sha256
    assert again.dropped == 0


@pytest.mark.parametrize("name", ["moved", "added", "a mesh added", "a larger margin", "something carried"])
def test_what_is_kept_is_free_in_coals_opinion_and_has_its_clearance(name):
    checker = WORLDS[name]()
    found = repair(OLD, checker)
    assert found is not None
    new, world = found.roadmap, CoalWorld(checker.world)
    for i, j, promised in zip(*new.edges.T, new.clearance, strict=True):
        delta = new.nodes[j] - new.nodes[i]
        assert world.nearest_along(new.nodes[i], delta, 0.02, 0.005) > checker.world.margin + promised - 1e-6


def test_counts_tell_what_had_to_be_looked_at():
    counts = {}
    for name in ("removed", "added far away", "added", "another place", "as it was", "renamed"):
        found = repair(OLD, WORLDS[name]())
        assert found is not None
        counts[name] = found.kept, found.proven, found.dropped
    everything = len(OLD.edges)
    assert counts["removed"] == counts["added far away"] == (everything, 0, 0)
    # the same world, whatever its obstacles are called: then it is a check of everything
    assert counts["as it was"] == counts["renamed"] == (0, everything, 0)
    kept, proven, dropped = counts["added"]
    assert kept > 0.4 * everything
    assert proven > 0
    assert dropped > 0
    assert counts["another place"][0] == 0


def test_what_the_difference_does_not_touch_is_not_proven(monkeypatch):
    def refuse(*_):
        raise AssertionError("an edge is proven")

    for name in ("removed", "added far away"):
        checker = WORLDS[name]()
        with monkeypatch.context() as patch:
            patch.setattr(EdgeProver, "prove", refuse)
            found = repair(OLD, checker)
        assert found is not None
        assert found.roadmap.origin.scene_identity == checker.world.scene.identity


def test_only_pairs_with_what_is_new_are_looked_at():
    checker = WORLDS["added"]()
    scene, own = unproven_pairs(OLD.origin.world, checker.world)
    assert not own.any()
    assert not scene[:, 0].any()
    np.testing.assert_array_equal(scene[:, 1], checker.world.checked[:, 1])
    seen = []
    real = EdgeProver.prove_curves
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            EdgeProver,
            "prove_curves",
            lambda self, *asked: seen.append(np.flatnonzero(~self._bounds.left_out)) or real(self, *asked),
        )
        repair(OLD, checker)
    new = np.flatnonzero(np.concatenate([scene.ravel(), own]))
    assert seen
    assert all(np.isin(pairs, new).all() for pairs in seen)


def test_a_certificate_that_leaves_room_for_the_margin_is_enough():
    roomy = replace(OLD, clearance=np.where(np.arange(len(OLD.edges)) % 2, 0.02, 0.0))
    found = repair(roomy, WORLDS["a larger margin"]())
    assert found is not None
    assert found.kept == (roomy.clearance > 0.01).sum()
    kept = np.isclose(found.roadmap.clearance, 0.01)
    assert kept.sum() >= found.kept  # what is left of it beyond the new margin
    smaller = replace(OLD, origin=replace(OLD.origin, margin=0.05))
    found = repair(smaller, WORLDS["removed"]())
    assert found is not None
    assert found.kept == len(OLD.edges)
    np.testing.assert_allclose(found.roadmap.clearance, OLD.clearance + 0.05)


def test_what_was_not_proven_is_proven_or_dropped():
    doubtful = replace(OLD, proven=np.arange(len(OLD.edges)) >= 10)
    found = repair(doubtful, WORLDS["removed"]())
    assert found is not None
    assert (found.kept, found.proven, found.dropped) == (len(OLD.edges) - 10, 10, 0)


def test_what_was_allowed_to_touch_and_is_not_any_more():
    allowed = frozenset([frozenset(("link_2", "ball")), frozenset(("link_1", "ball"))])
    ball = {"thing0": (POST, AT), "ball": BALL}
    lenient, strict = made(allowed=allowed, **ball), made(**ball)
    old = repair(OLD, lenient)
    assert old is not None
    assert old.kept == len(OLD.edges)
    assert changes(old.roadmap.origin.world, strict.world) == ["obstacle 'ball' may be touched by other links"]
    found = repair(old.roadmap, strict)
    assert found is not None
    assert keys(found.roadmap) == all_proven_again(OLD, strict)
    back = repair(found.roadmap, lenient)
    assert back is not None
    assert back.proven == back.dropped == 0


def test_pairs_of_links_that_nobody_looked_at():
    """As where the other backend worked out which pairs can touch: names and geometry are the same."""
    paper = checker_of("iiwa14", "paper")
    plan = small_plan()
    record = plan.roadmap.origin.world
    fewer = replace(plan.roadmap.origin, world=replace(record, self_pairs=record.self_pairs[3:]))
    old = replace(plan.roadmap, origin=fewer)
    assert not same_world(old, paper)
    scene, own = unproven_pairs(old.origin.world, paper.world)
    assert (scene.any(), own.sum()) == (False, 3)
    found = repair(old, paper)
    assert found is not None
    assert found.roadmap.sha256 == plan.roadmap.sha256
    assert same_world(found.roadmap, paper)


def test_a_ball_in_the_papers_scene():
    plan = small_plan()
    ball = Obstacle("ball in the way", Sphere(0.1), pose([0.45, -0.25, 0.75]))
    scene = replace(plan.scene, obstacles=(*plan.scene.obstacles, ball))
    checker = make_checker(plan.robot, scene)
    found = repair(plan.roadmap, checker)
    assert found is not None
    assert keys(found.roadmap) == all_proven_again(plan.roadmap, checker)
    assert found.changes == ("obstacle 'ball in the way' added",)
    assert min(found.kept, found.proven, found.dropped) > 0
    assert found.roadmap.scale == plan.roadmap.scale


# the robot


def test_limits_take_configurations_with_them():
    robot = load("planar_2r")
    tight = replace(robot, lower=robot.lower, upper=np.minimum(robot.upper, 0.5))
    checker = made(tight, thing0=(POST, AT))
    found = repair(OLD, checker)
    assert found is not None
    assert found.changes == ("narrower joint limits, see --widen-limits",)
    inside = (OLD.nodes <= 0.5).all(axis=1)
    np.testing.assert_array_equal(within_limits(OLD, tight), inside)
    np.testing.assert_array_equal(found.roadmap.nodes, OLD.nodes[inside])
    assert found.kept == len(found.roadmap.edges) > 0


def test_wider_limits_are_the_same_world():
    wide = with_widened_limits(load("planar_2r"), np.array([[-9.0, -9.0], [9.0, 9.0]]))
    assert same_world(OLD, made(wide, thing0=(POST, AT)))


def test_another_tool_is_measured_anew_and_moves_no_proof():
    robot = Robot.load("planar_2r", tool="link_2")
    found = repair(OLD, made(robot, thing0=(POST, AT)))
    assert found is not None
    assert (found.kept, found.dropped) == (len(OLD.edges), 0)
    np.testing.assert_allclose(found.roadmap.manipulability, manipulability(robot, OLD.nodes), atol=1e-15)
    assert found.roadmap.scale != OLD.scale
    assert found.roadmap.origin.tool == "link_2"


def test_other_joints_are_refused():
    with pytest.raises(FileError, match=r"is for joints joint_1, joint_2, the robot has iiwa14_joint_1, .* build one"):
        repair(OLD, checker_of("iiwa14"))


def test_starts_and_goals_in_collision_are_gone():
    swallowed = made(thing0=(POST, AT), ball=(Sphere(0.1), pose([0.5, -0.4, 0])))
    assert not is_free(swallowed, OLD.nodes[OLD.starts[0]])
    found = repair(OLD, swallowed)
    assert found is not None
    assert len(found.roadmap.starts) == 0
    np.testing.assert_array_equal(
        found.roadmap.nodes[found.roadmap.goals],
        [q for q in OLD.nodes[OLD.goals] if is_free(swallowed, q)],
    )


def test_where_nothing_is_left():
    everywhere = made(ball=(Sphere(5.0), pose([0, 0, 0])))
    with pytest.raises(FileError, match=r"no configuration of the roadmap is free|whatever the joints do"):
        repair(OLD, everywhere)


def test_a_contact_that_no_joint_can_part():
    paper = small_plan()
    block = Obstacle("block", Box((0.1, 0.1, 0.05)), pose([0, 0, 0]))
    checker = make_checker(paper.robot, replace(paper.scene, obstacles=(*paper.scene.obstacles, block)))
    with pytest.raises(FileError, match="'block' come too near whatever the joints do"):
        repair(paper.roadmap, checker)


# interrupted


def test_stop_gives_nothing_and_verify_says_how_far_it_came():
    assert repair(OLD, WORLDS["another place"](), progress=Progress(stop=lambda: True)) is None
    assert repair(OLD, WORLDS["moved"](), progress=Progress(stop=lambda: True)) is None
    found = verify(OLD, make_post(), progress=Progress(stop=lambda: True))
    assert (found.complete, len(found.verdict)) == (False, 0)


@pytest.mark.parametrize("after", [1, 3])
def test_a_stop_in_the_middle_is_seen_within_a_batch_and_no_verdict_is_made_of_it(after, monkeypatch):
    monkeypatch.setattr("planner.construction.repair._BATCH", 16)
    calls = iter(range(10**6))
    found = verify(OLD, make_post(), progress=Progress(stop=lambda: next(calls) >= after))
    assert not found.complete
    assert len(found.verdict) <= 16 * after
    assert (found.verdict == Verdict.FREE).all()  # an edge that was cut off is not among them
    calls = iter(range(10**6))
    assert repair(OLD, WORLDS["another place"](), progress=Progress(stop=lambda: next(calls) >= after)) is None


def test_progress_counts_edges():
    heard = []
    verify(OLD, make_post(), Progress(lambda *args: heard.append(args)))
    assert heard[-1] == ("edges", len(OLD.edges), len(OLD.edges))
    heard.clear()
    found = repair(OLD, WORLDS["moved"](), Progress(lambda *args: heard.append(args)))
    assert found is not None
    assert heard[-1][1] == heard[-1][2] <= len(OLD.edges)


# a check of everything


def test_verify_finds_what_does_not_hold():
    fine = verify(OLD, make_post())
    assert fine.complete
    assert fine.count(Verdict.FREE) == len(OLD.edges)
    assert first_failure(OLD, make_post(), fine) is None
    across = next(
        (i, j)
        for i in range(60)
        for j in range(i + 1, 60)
        if (OLD.edges != (i, j)).any(axis=1).all()
        and recheck(make_post(), OLD.nodes[i], OLD.nodes[j] - OLD.nodes[i]) is not None
    )
    edges = np.array([*OLD.edges[:7].tolist(), across, *OLD.edges[8:].tolist()])
    lying = replace(OLD, edges=edges)
    found = verify(lying, make_post())
    assert (found.count(Verdict.COLLIDES), found.count(Verdict.FREE)) == (1, len(OLD.edges) - 1)
    failure = first_failure(lying, make_post(), found)
    assert failure is not None
    assert failure[:2] == across
    assert failure[2].second == "thing0"
    mended = repair(lying, make_post())
    assert mended is not None
    assert mended.dropped == 1


def test_measures_that_lie_are_measured_again():
    lying = replace(OLD, manipulability=OLD.manipulability + 0.1)
    assert measures_hold(OLD, load("planar_2r"))
    assert not measures_hold(lying, load("planar_2r"))
    mended = repair(lying, make_post())
    assert mended is not None
    np.testing.assert_allclose(mended.roadmap.manipulability, OLD.manipulability)
