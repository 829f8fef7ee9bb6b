"""Measures of a path or a motion: manipulability, lengths, the first contact, the smallest clearance."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints, cumulative_sums, cut, lengths_along, parts_of
from planner.base.polynomials import bernstein, derivative, evaluate
from planner.base.resolutions import CLEARANCE_ALONG_PATH, CLEARANCE_FIRST, RECHECK, W_ALONG_PATH
from planner.collision.checker import CollisionChecker
from planner.collision.recheck import Clearance, PathContact, dense_states, sample_contacts, straight
from planner.collision.world import Contact
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.robot.robot import Robot
from planner.trajectory.trajectory import Trajectory

TOLERANCE, SHARE = 1e-3, 0.1  # m, and share of the clearance: bounds of the overestimate of a reported clearance
CLOSE = 5e-3  # m: models of one robot differ by a millimetre, and calibrations by more
TOO_CLOSE = "close"  # row of the summary for a clearance below CLOSE
TOO_CLOSE_TEXT = (
    f"less than {1000 * CLOSE:g} mm, a typical error of models and calibrations: --margin 0.005 keeps a distance "
    "everywhere, --extra-clearance 0.01 lets refined paths keep more where possible"
)
SHOWN = 1e-4  # m: the smallest clearance that is printed; proofs need about twice as much
NOTHING_NEAR = "no pair is checked"
_CHORD = 1e-5  # rad (m): largest distance of a motion from the chords along which its clearance is measured
_STRAIGHT = 1e-3  # rad: a smaller change of direction is no corner


def dense_path(path: Floats, step: float = W_ALONG_PATH) -> Floats:
    """Return configurations (n, dof) along a joint path, at most ``step`` (rad) apart in every joint."""
    return dense_segments(path, step)[0]


def dense_segments(path: Floats, step: float) -> tuple[Floats, Ints]:
    """Return the configurations (n, dof) of :func:`dense_path`, and the segment (n,) of each."""
    parts = parts_of(np.abs(np.diff(path, axis=0)).max(axis=1, initial=0.0), step)
    return cut(path, parts), np.concatenate([[0], np.repeat(np.arange(len(parts)), parts)])


@dataclass(frozen=True)
class PathMeasures:
    """Measures of a joint path: smallest and mean w, lengths in rad and m."""

    w_min: float
    w_mean: float
    joint_length: float
    workspace_length: float


def measure_path(robot: Robot, path: Floats) -> PathMeasures:
    """Return manipulability at states ``W_ALONG_PATH`` apart, and both lengths, of a joint path (k, dof)."""
    w = path_manipulability(robot, path)
    return PathMeasures(float(w.min()), float(w.mean()), joint_path_length(path), tool_path_length(robot, path))


def path_manipulability(robot: Robot, path: Floats) -> Floats:
    """Return w (n,) sampled densely along a joint path."""
    return w_along_path(robot, path)[1]


def w_along_path(robot: Robot, path: Floats) -> tuple[Floats, Floats]:
    """Return joint motion (n,) rad from the start, and w (n,) there, sampled densely along a joint path."""
    q = dense_path(path)
    return lengths_along(q), manipulability(robot, q)


def tool_path_length(robot: Robot, path: Floats) -> float:
    """Return the length (m) of the tool's path along a joint path: of several tools, the sum."""
    paths = [tool_positions(one, dense_path(path)) for one in robot.with_each_tool]
    return sum(float(np.linalg.norm(np.diff(each, axis=0), axis=1).sum()) for each in paths)


def joint_path_length(path: Floats) -> float:
    """Return the sum of the Euclidean lengths (rad) of a joint path's segments."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def count_corners(path: Floats) -> int:
    """Return the number of corners of a joint path (k, dof): changes of direction above 0.001 rad."""
    step = np.diff(path, axis=0)
    far = np.linalg.norm(step, axis=1)
    ahead = step[far > 0] / far[far > 0][:, None]
    return int((np.linalg.norm(np.diff(ahead, axis=0), axis=1) > _STRAIGHT).sum())


def path_contact(checker: CollisionChecker, path: Floats, step: float = RECHECK) -> PathContact | None:
    """Return the first contact along a joint path sampled every ``step`` metres of motion, without proofs."""
    start = path[:-1] if len(path) > 1 else path
    return sample_contacts(checker, straight(start, np.diff(path, axis=0) if len(path) > 1 else 0.0 * path), step)


def path_clearance(checker: CollisionChecker, path: Floats) -> tuple[Floats, Floats]:
    """Return states (n, dof) ``CLEARANCE_ALONG_PATH`` apart on a path, and the clearances (n,) m there."""
    along = (dense_states(checker.world, a, b - a, CLEARANCE_ALONG_PATH)[0] for a, b in itertools.pairwise(path))
    q = np.concatenate([path[:1], *(states[1:] for states in along)])
    return q, Clearance(checker)(q)


@dataclass(frozen=True)
class Nearest:
    """The smallest distance ``min`` (m), its ``pair`` of names, and its location ``at``.

    ``at`` is the share of the joint motion on a path, and a time in s on a trajectory.
    """

    min: float
    pair: tuple[str, str]
    at: float

    def to_dict(self) -> dict[str, Any]:
        """Return the clearance as plain data."""
        return {"min": self.min, "pair": list(self.pair), "at": self.at}


def nearest_on_path(path: Floats, checker: CollisionChecker) -> Nearest | None:
    """Return the smallest clearance along a joint path (k, dof); None if no joint moves a checked pair."""
    along = lengths_along(path)
    return _nearest(path, along / max(float(along[-1]), 1e-300), checker)


def nearest_in_motion(trajectory: Trajectory, checker: CollisionChecker) -> Nearest | None:
    """Return the smallest clearance along a motion."""
    return nearest_on_pieces(trajectory.coefficients, trajectory.times, checker)


def nearest_on_pieces(coefficients: Floats, locations: Floats, checker: CollisionChecker) -> Nearest | None:
    """Return the smallest clearance on pieces (k, degree + 1, dof) between ``locations`` (k + 1,).

    It follows chords within 0.01 mrad. ``at`` lies between two locations, such as times.
    """
    length = np.diff(locations)
    bend = np.abs(bernstein(derivative(coefficients, 2))).max(axis=(1, 2), initial=0.0)
    counts = np.maximum(1, np.ceil(np.sqrt(bend / (8.0 * _CHORD)))).astype(int)
    piece = np.repeat(np.arange(len(counts)), counts)
    u = (np.arange(len(piece)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[piece]
    q = np.vstack([evaluate(coefficients[piece], u), coefficients[-1:].sum(axis=1)])
    return _nearest(q, np.append(locations[piece] + u * length[piece], locations[-1]), checker)


def _nearest(path: Floats, locations: Floats, checker: CollisionChecker) -> Nearest | None:
    """Return the smallest clearance along a path (k, dof) with rows at ``locations`` (k,)."""
    smallest = smallest_clearance(checker, path)
    pair = None if smallest is None else nearest_pair(checker, smallest[3])
    if smallest is None or pair is None:
        return None
    value, segment, share, _ = smallest
    ends = locations[segment : segment + 2]
    return Nearest(value, (pair.first, pair.second), float(ends[0] + share * (ends[-1] - ends[0])))


def smallest_clearance(checker: CollisionChecker, path: Floats) -> tuple[float, int, float, Floats] | None:
    """Return the smallest clearance (m) along a path (k, dof), its segment, share and state (dof,).

    It is accurate to 1 mm and to a tenth; None if no pair is checked. A distance changes by at most the motion of its
    two bodies, so between two samples ``left`` and ``right``, ``motion`` apart, it is at least (left + right - motion)
    / 2. Intervals with a bound below the best sample are halved together until none is left (Piyavskii 1972). The error
    of the collision library comes on top.
    """
    clearance, best = Clearance(checker), (np.inf, 0, 0.0, path[0])
    # a distance changes by at most the motion of both bodies
    motion = (checker.chain.sizes(np.diff(path, axis=0)) @ checker.world.pair_reach.T).max(axis=1, initial=0.0)
    travel = cumulative_sums(motion)  # (k,) motion from the start to each waypoint

    def sample(locations: Floats) -> Floats:
        """Return clearances (n,) at ``locations`` (n,), or lower bounds above the best; update the best."""
        nonlocal best
        segment = np.clip(np.searchsorted(travel, locations, side="right") - 1, 0, max(0, len(path) - 2))
        ahead = np.minimum(segment + 1, len(path) - 1)
        share = (locations - travel[segment]) / np.maximum(travel[ahead] - travel[segment], 1e-300)
        q = path[segment] + share[:, None] * (path[ahead] - path[segment])
        values = clearance.smallest(q, best[0])
        row = int(values.argmin())
        if values[row] < best[0]:
            best = float(values[row]), int(segment[row]), float(share[row]), q[row]
        return values

    # of length CLEARANCE_FIRST, independent of the waypoints: a trajectory has thousands of them
    locations = np.linspace(0.0, travel[-1], max(1, int(np.ceil(travel[-1] / CLEARANCE_FIRST))) + 1)
    values = sample(locations)
    low, high, left, right = locations[:-1], locations[1:], values[:-1], values[1:]
    while True:
        bound = np.maximum(0.0, 0.5 * (left + right - (high - low)))
        open_ = np.isfinite(bound) & (bound < best[0] - slack(best[0]))
        if not open_.any():
            return best if np.isfinite(best[0]) else None
        low, high, left, right = low[open_], high[open_], left[open_], right[open_]
        middle = 0.5 * (low + high)
        value = sample(middle)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        left, right = np.concatenate([left, value]), np.concatenate([value, right])


def slack(clearance: float) -> float:
    """Return the largest overestimate (m) of a reported ``clearance``."""
    return min(TOLERANCE, SHARE * clearance)


def nearest_pair(checker: CollisionChecker, q: Floats) -> Contact | None:
    """Return the nearest checked pair at ``q`` (dof,) that some joint can move; None without such a pair."""
    world = checker.world
    checked = np.concatenate([world.checked.ravel(), np.ones(len(world.self_pairs), dtype=bool)])
    pairs = np.flatnonzero(checked & world.moving)
    if not len(pairs):
        return None
    return world.contact(int(pairs[checker.gaps(q, pairs).argmin()]))


def clearance_text(clearance: float) -> str:
    """Return a clearance (m) in words; one below 0.1 mm is not distinguished from contact."""
    if clearance >= SHOWN:
        return f"{1000 * clearance:.1f} mm"
    return f"less than {1000 * SHOWN:g} mm, which proofs cannot distinguish from contact"


def nearest_text(near: Nearest) -> str:
    """Return a clearance and its pair in words."""
    return f"{clearance_text(near.min)} ('{near.pair[0]}' and '{near.pair[1]}')"
