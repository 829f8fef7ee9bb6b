"""A check of a joint path from any source: limits, contacts, clearance, proofs, manipulability."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError
from planner.base.polylines import lengths_along
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF_OF_CHECK, RECHECK
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.world import Contact
from planner.constraints.keeps import Kept
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.query.resolve import beyond_limits, looks_like_degrees
from planner.robot.robot import Robot
from planner.trajectory.measure import PathContact, dense_path, joint_path_length, path_contact
from planner.trajectory.path_clearance import Place, nearest_pair, slack, smallest_clearance


@dataclass(frozen=True)
class Excess:
    """Waypoint ``row`` puts ``joint`` at ``value``, ``beyond`` its limits by so much (rad, m)."""

    row: int
    joint: str
    value: float
    beyond: float


@dataclass(frozen=True, eq=False)
class Proven:
    """What the proofs of a path's segments came to: ``verdicts`` (k - 1,).

    ``bound`` (m) is a distance that no checked pair comes nearer than anywhere on the path, None unless every segment
    is proven free. ``strikes`` is the first segment that is proven to touch, and its pair.
    """

    verdicts: Ints
    bound: float | None = None
    strikes: tuple[int, Contact] | None = None

    def count(self, verdict: Verdict) -> int:
        return int((self.verdicts == verdict).sum())


@dataclass(frozen=True, eq=False)
class PathReport:
    """What was found on a path (k, dof), sampled every ``step`` metres of motion by ``second_checker``; true if ok.

    Where its values look like ``degrees`` nothing else was checked, as the motions between them mean nothing.
    ``clearance`` is the smallest one (m) and ``nearest`` its pair, None where no pair is checked. ``w`` (n,) is sampled
    densely at ``shares`` (n,) of the joint motion; ``lowest`` is its minimum. ``kept`` is what came of each condition,
    and where it has least to spare. Lengths are in rad and m.
    """

    checker: CollisionChecker
    path: Floats
    step: float
    excess: Excess | None
    degrees: bool
    contact: PathContact | None
    proven: Proven
    clearance: Place | None
    nearest: Contact | None
    shares: Floats
    w: Floats
    lowest: Place
    kept: tuple[tuple[Kept, Place], ...]
    joint_length: float
    workspace_length: float

    def __bool__(self) -> bool:
        return self.ok

    def __repr__(self) -> str:
        return f"<PathReport: {len(self.path)} points, {'ok' if self.ok else 'not ok'}>"

    @property
    def ok(self) -> bool:
        """Within limits, free and keeping what is kept wherever it was sampled, and no segment proven to touch."""
        kept = not any(each.strays for each, _ in self.kept)
        return self.excess is None and self.contact is None and self.proven.strikes is None and kept


def check_path(
    checker: CollisionChecker, path: Floats, step: float = RECHECK, progress: Progress = QUIET
) -> PathReport:
    """Check a joint path (k, dof): every ``step`` metres of motion by itself, and by proofs of whole segments.

    Between waypoints the path is straight in joint space. ``checker`` proves segments. Coal samples them, in one call
    per segment: it shares no code with FCL's proofs and is seven times as fast. A path that looks like degrees is not
    checked for contacts.
    Raises :class:`OptionError` for a step that is no distance.
    """
    require_step(step)
    robot = checker.robot
    excess = worst_excess(robot, path)
    degrees = excess is not None and looks_like_degrees(robot, path)
    contact, clearance, proven = None, None, _not_proven(path)
    if not degrees:
        contact, clearance, proven = _look(checker, path, step, progress)
    dense = path if degrees else dense_path(path)
    w, tool = manipulability(robot, dense), tool_positions(robot, dense)
    kept = () if degrees else checker.world.keeps.along(dense, np.stack([path[:-1], np.diff(path, axis=0)], axis=1))
    along = lengths_along(dense)
    return PathReport(
        checker=checker,
        path=path,
        step=step,
        excess=excess,
        degrees=degrees,
        contact=contact,
        proven=proven,
        clearance=clearance,
        nearest=None if clearance is None else nearest_pair(checker, clearance.q),
        shares=along / max(float(along[-1]), 1e-300),
        w=w,
        lowest=_place_of(path, dense[w.argmin()], float(w.min())),
        kept=tuple((each, _place_of(path, dense[each.row], each.spare)) for each in kept),
        joint_length=joint_path_length(path),
        workspace_length=float(np.linalg.norm(np.diff(tool, axis=0), axis=1).sum()),
    )


def _look(
    checker: CollisionChecker, path: Floats, step: float, progress: Progress
) -> tuple[PathContact | None, Place | None, Proven]:
    """The quick samples first, then the distances, then the proofs, which need the distances."""
    segments = max(len(path) - 1, 1)
    contact = path_contact(second_checker(checker), path, step, lambda done: progress("contacts", done, segments))
    progress("clearance", 0, segments)
    clearance = smallest_clearance(checker, path)
    progress("clearance", segments, segments)
    proven = prove_path(checker, path, np.inf if clearance is None else clearance.value)
    progress("proofs", segments, segments)
    return contact, clearance, proven


def require_step(step: float) -> None:
    """Raise :class:`OptionError` unless ``step`` (m) is a usable distance between the samples of a path."""
    if not 1e-6 <= step <= 1.0:
        raise OptionError(f"step {step:g} m is not usable: give a distance from 0.000001 to 1.")


def worst_excess(robot: Robot, path: Floats) -> Excess | None:
    """The value farthest beyond a joint limit; between waypoints within limits the path is within them too."""
    beyond = beyond_limits(robot, path)
    row, joint = np.unravel_index(int(beyond.argmax()), beyond.shape)
    if not beyond[row, joint]:
        return None
    return Excess(int(row), robot.joints[joint], float(path[row, joint]), float(beyond[row, joint]))


def prove_path(checker: CollisionChecker, path: Floats, clearance: float = np.inf) -> Proven:
    """Prove every segment that lies within joint limits: outside them the motion of sliding joints is not bounded.

    ``clearance`` (m) is the smallest that is known of; where all is proven free, proofs of distances below it follow.
    """
    robot, world = checker.robot, checker.world
    verdicts = _not_proven(path).verdicts
    outside = np.flatnonzero(beyond_limits(robot, path).any(axis=1))
    rows = np.setdiff1d(np.arange(len(verdicts)), np.concatenate([outside - 1, outside]))
    if not len(rows):
        return Proven(verdicts)
    prover = EdgeProver(checker)
    proofs = prover.prove(path[rows], path[rows + 1] - path[rows])
    verdicts[rows] = proofs.verdict
    for k in np.flatnonzero(proofs.verdict == Verdict.COLLIDES)[:1]:
        contact = prover.static_contact or world.contact(int(proofs.pair[k]))
        return Proven(verdicts, strikes=(int(rows[k]), contact))
    free = bool((verdicts == Verdict.FREE).all())
    return Proven(verdicts, proven_distance(checker, path, clearance) if free else None)


def _not_proven(path: Floats) -> Proven:
    return Proven(np.full(len(path) - 1, int(Verdict.UNDECIDED)))


def proven_distance(checker: CollisionChecker, path: Floats, clearance: float) -> float:
    """A distance (m) that a path, proven free at the checker's margin, is proven to keep: that margin or more.

    Proofs are tried at margins a little below the ``clearance`` that was found, so it may be smaller than the truth.
    """
    world = checker.world
    for margin in (clearance - slack(clearance) - PROOF_OF_CHECK, 0.5 * clearance):
        if world.margin < margin < np.inf:
            wider = type(checker)(replace(world, margin=margin))
            if EdgeProver(wider).prove(path[:-1], np.diff(path, axis=0)).free.all():
                return float(margin)
    return world.margin


def _place_of(path: Floats, q: Floats, value: float) -> Place:
    """Where on a path the configuration ``q`` (dof,), which lies on it, is passed first."""
    if len(path) == 1:
        return Place(0, 0.0, q, value)
    start, delta = path[:-1], np.diff(path, axis=0)
    length = np.maximum((delta**2).sum(axis=1), 1e-300)
    share = np.clip(((q - start) * delta).sum(axis=1) / length, 0.0, 1.0)
    off = np.abs(start + share[:, None] * delta - q).max(axis=1)
    segment = int(np.flatnonzero(off <= off.min() + 1e-9)[0])
    return Place(segment, float(share[segment]), q, value)
