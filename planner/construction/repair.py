"""A kept roadmap checked against the current world: which edges hold, and which need another proof.

A removed obstacle leaves every proof valid. Added or moved things make pairs that no proof has checked; an edge stays
proven if it is proven against these pairs alone. A larger margin is covered by an edge's certificate where that leaves
enough clearance, and by a new proof elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import FileError, choices
from planner.base.products import product
from planner.base.progress import QUIET, Progress
from planner.base.records import dataclass
from planner.collision.checker import CollisionChecker, is_free, keeping
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.world import Contact, World
from planner.kinematics.forward import joint_placements
from planner.kinematics.manipulability import node_manipulability
from planner.models.robot import Robot
from planner.roadmap.measure import measure_anew, measure_edges
from planner.roadmap.node_checks import nobody, with_checked_nodes
from planner.roadmap.roadmap import Roadmap, origin_of, segments
from planner.roadmap.storage import same_world
from planner.roadmap.world_record import changes, unproven_pairs

_BATCH = 128  # edges proven between two checks whether to stop
_CLEARANCE_SLACK = 1e-9  # m: forgives another library's rounding
_LIMIT_SLACK = 1e-9  # rad: forgives a limit that was printed and read back


@dataclass(frozen=True, eq=False)
class Verification:
    """Every edge proven again: ``verdict`` (k,) of :class:`Verdict` and the ``pair`` (k,) that stopped it, -1 for none.

    ``clearance`` (k,) is what the proofs found beyond the margin, m. They are about the first k edges: all of them,
    unless it was interrupted.
    """

    verdict: Ints
    pair: Ints
    clearance: Floats
    complete: bool

    def count(self, verdict: Verdict) -> int:
        return int((self.verdict == verdict).sum())


@dataclass(frozen=True, eq=False)
class Repair:
    """A roadmap that holds in another world, and what became of the edges: kept unseen, proven again, or dropped."""

    roadmap: Roadmap
    changes: tuple[str, ...]
    kept: int
    proven: int
    dropped: int
    nodes_dropped: int


def verify(
    roadmap: Roadmap,
    checker: CollisionChecker,
    progress: Progress = QUIET,
) -> Verification:
    """Prove every edge again, whatever its certificate says."""
    prover, m = EdgeProver(checker, progress), len(roadmap.edges)
    verdict, pair, clearance = np.zeros(m, dtype=np.int64), np.full(m, -1, dtype=np.int64), np.zeros(m)
    done = 0
    for rows in batches(np.arange(m)):
        proofs = prover.prove(*segments(roadmap, checker.robot, rows))
        if progress.stopped:
            break  # what is undecided may be so only because of that
        verdict[rows], pair[rows], clearance[rows] = proofs.verdict, proofs.pair, proofs.clearance
        done += len(rows)
        progress("edges", done, m)
    return Verification(verdict[:done], pair[:done], clearance[:done], done == m)


def first_without_clearance(
    roadmap: Roadmap, checker: CollisionChecker, found: Verification, progress: Progress = QUIET
) -> int | None:
    """The first edge that is not proven to keep what its certificate says; None if all are, or once stopped."""
    says = roadmap.clearance + (roadmap.origin.margin - checker.world.margin) - _CLEARANCE_SLACK
    for row in np.flatnonzero(says > found.clearance):
        if progress.stopped:
            return None
        if not np.isfinite(says[row]):
            return int(row)
        prover = EdgeProver(keeping(checker, float(says[row])))
        if not prover.prove(*segments(roadmap, checker.robot, np.array([row])), contacts=False).free.all():
            return int(row)
    return None


def first_failure(roadmap: Roadmap, checker: CollisionChecker, found: Verification) -> tuple[int, int, Contact] | None:
    """The first edge (i, j) that does not hold, and the two things that come too near; None if all hold."""
    failed = np.flatnonzero(found.verdict != Verdict.FREE)
    if not len(failed):
        return None
    i, j = roadmap.edges[failed[0]].tolist()
    # a contact that no joint can part is no matter of this edge's pairs
    static = EdgeProver(checker).static_contact
    return i, j, static or checker.world.contact(int(found.pair[failed[0]]))


def repair(
    roadmap: Roadmap,
    checker: CollisionChecker,
    progress: Progress = QUIET,
) -> Repair | None:
    """The roadmap as far as it holds in the checker's world; None if it was stopped before every edge was judged.

    Where nothing differs every edge is proven and measured again. Configurations out of limits or in collision go
    with their edges. The cost scale stays, unless manipulability or lengths are not what they were: with another tool,
    or other links. Raises :class:`FileError` where the joints are others, or no configuration is left.
    """
    world, m = checker.world, len(roadmap.edges)
    _require_same_joints(roadmap, world.robot)
    prover, judge = EdgeProver(checker, progress), _Judge(roadmap, world, progress)
    if prover.static_contact is not None:
        raise FileError(
            f"{prover.static_contact} come too near whatever the joints do, so nothing of the roadmap is free: "
            "move one of the two."
        )
    scene_pairs, self_rows = unproven_pairs(roadmap.origin.world, world)
    something_new = bool(scene_pairs.any() or self_rows.any())
    something_known = bool((world.checked & ~scene_pairs).any() or not self_rows.all())
    as_it_was = same_world(roadmap, checker)
    everything = as_it_was or (something_new and not something_known)
    anew = np.ones(m, dtype=bool) if everything else judge.doubtful()
    touched = np.zeros(m, dtype=bool)
    if something_new and not everything:
        new_pairs = np.concatenate([scene_pairs.ravel(), self_rows])
        touched = ~anew & ~judge.out_of_reach(checker, new_pairs, ~anew)
        judge.prove(prover.only(new_pairs), touched)
    judge.forget(anew)
    judge.prove(prover, anew)
    nodes = None if judge.stopped else _usable(roadmap, checker, judge.holds, progress)
    if nodes is None:
        return None
    kept = judge.holds & nodes[roadmap.edges].all(axis=1)
    looked = touched | anew
    return Repair(
        roadmap=_rewritten(judge, checker, nodes, kept, measure=as_it_was),
        changes=tuple(changes(roadmap.origin.world, world)),
        kept=int((kept & ~looked).sum()),
        proven=int((kept & looked).sum()),
        dropped=int((~kept).sum()),
        nodes_dropped=int((~nodes).sum()),
    )


class _Judge:
    """What is known of each edge while a repair goes on: ``holds``, ``clearance`` and ``samples``, (m,) each."""

    def __init__(self, roadmap: Roadmap, world: World, progress: Progress) -> None:
        self.roadmap, self.world, self.progress = roadmap, world, progress
        self.stopped = False
        self.holds = roadmap.proven.copy()
        self.clearance = roadmap.clearance + (roadmap.origin.margin - world.margin)
        self.samples = roadmap.samples.copy()

    def doubtful(self) -> Bools:
        """(m,) the edges never proven, or proven with less clearance than the margin now asks for.

        A clearance bounds from below: for the margin that it was proven with, 0 is enough.
        """
        grown = self.world.margin > self.roadmap.origin.margin
        return ~self.holds | (grown & (self.clearance <= 0))

    def out_of_reach(self, checker: CollisionChecker, pairs: Bools, rows: Bools) -> Bools:
        """(m,) those of ``rows`` on which none of ``pairs`` (pairs,) can touch, by one cheap check of each."""
        reach = self.world.pair_reach
        moving = pairs & reach.any(axis=1)  # the prover checks pairs that no joint can move once, when it is made
        clear = np.zeros(len(rows), dtype=bool)
        for batch in self._batches(rows):
            start, delta = self._segments(batch)
            gap = checker.bound.coarse(*joint_placements(checker.chain, start + 0.5 * delta)) - self.world.margin
            motion = product(checker.chain.sizes(delta), reach.T)
            least = np.where(moving, gap - 0.5 * motion, np.inf).min(axis=1, initial=np.inf)
            clear[batch] = least > 0
            self._note(batch[least > 0], least[least > 0])
        return clear

    def forget(self, rows: Bools) -> None:
        """What the certificates of ``rows`` say is not to count."""
        self.clearance[rows], self.samples[rows] = np.inf, 0

    def prove(self, prover: EdgeProver, rows: Bools) -> None:
        """Whether ``rows`` hold against the prover's world, beyond what is known of them."""
        done = 0
        for batch in self._batches(rows):
            proofs = prover.prove(*self._segments(batch))
            if self.progress.stopped:
                self.stopped = True  # and what is undecided may be so only because of that
                return
            self.holds[batch] = proofs.free
            self._note(batch, proofs.clearance)
            self.samples[batch] += proofs.samples
            done += len(batch)
            self.progress("edges", done, int(rows.sum()))

    def _note(self, rows: Ints, clearance: Floats) -> None:
        self.clearance[rows] = np.minimum(self.clearance[rows], clearance)

    def _segments(self, rows: Ints) -> tuple[Floats, Floats]:
        return segments(self.roadmap, self.world.robot, rows)

    def _batches(self, rows: Bools) -> Iterator[Ints]:
        for batch in batches(np.flatnonzero(rows)):
            self.stopped = self.stopped or self.progress.stopped
            if self.stopped:
                return
            yield batch


def measures_hold(roadmap: Roadmap, robot: Robot) -> bool:
    """Whether manipulability and lengths, which the costs are made of, are those of the configurations."""
    measured = measure_edges(robot, roadmap.nodes, roadmap.edges, roadmap.scale)
    theirs = {**measured, "manipulability": node_manipulability(robot, roadmap.nodes)}
    return all(np.allclose(getattr(roadmap, name), value, rtol=1e-6, atol=1e-9) for name, value in theirs.items())


def batches(rows: Ints) -> Iterator[Ints]:
    """``rows`` a few at a time, so that there is a moment to stop at."""
    for first in range(0, len(rows), _BATCH):
        yield rows[first : first + _BATCH]


def within_limits(roadmap: Roadmap, robot: Robot) -> Bools:
    """(n,) which configurations are within the robot's limits; a continuous joint has none."""
    beyond = np.maximum(robot.lower - roadmap.nodes, roadmap.nodes - robot.upper)
    return np.where(robot.continuous, 0.0, beyond).max(axis=1) <= _LIMIT_SLACK


def _require_same_joints(roadmap: Roadmap, robot: Robot) -> None:
    if roadmap.origin.joints != robot.joints:
        raise FileError(
            f"the roadmap is for joints {choices(roadmap.origin.joints)}, the robot has {choices(robot.joints)}: "
            "nothing of it can be kept, build one for this robot."
        )


def _usable(roadmap: Roadmap, checker: CollisionChecker, holds: Bools, progress: Progress) -> Bools | None:
    """(n,) which configurations are within limits and free (the ends of a proven edge are); None once stopped."""
    good = within_limits(roadmap, checker.robot)
    proven = np.zeros(len(good), dtype=bool)
    proven[roadmap.edges[holds]] = True
    for row in np.flatnonzero(good & ~proven):
        if progress.stopped:
            return None
        good[row] = is_free(checker, roadmap.nodes[row])
    if not good.any():
        raise FileError("no configuration of the roadmap is free in this scene: build a new one.")
    return good


def _rewritten(judge: _Judge, checker: CollisionChecker, nodes: Bools, edges: Bools, measure: bool) -> Roadmap:
    """The part that holds, with its new certificates and origin.

    Manipulability and lengths are measured again where the robot is another (or ``measure`` is True), and replaced
    where they differ.
    """
    robot, old = checker.robot, judge.roadmap
    whole = replace(
        old,
        checked_by=nobody(len(old.nodes)),
        proven=judge.holds,
        clearance=np.maximum(judge.clearance, 0.0),
        samples=judge.samples,
        origin=origin_of(checker, old.origin.seed),
    )
    part = with_checked_nodes(whole.part(nodes, edges), checker)
    # measuring takes several times as long as finding out what one obstacle more touches
    if (robot.identity == old.origin.robot_identity and not measure) or measures_hold(part, robot):
        return part
    w, scale, measures = measure_anew(robot, part.nodes, part.edges)
    return replace(part, manipulability=w, scale=scale, **measures)
