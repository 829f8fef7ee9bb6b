"""What is measured along a path or a motion: manipulability, lengths, the first contact, the smallest clearance."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints, cut, lengths_along, parts_of, so_far
from planner.base.polynomials import bernstein, derivative, evaluate
from planner.base.resolutions import CLEARANCE_ALONG_PATH, CLEARANCE_FIRST, RECHECK, W_ALONG_PATH
from planner.collision.checker import CollisionChecker
from planner.collision.looks import Clearance, Seen, dense_states, first_seen, straight
from planner.collision.world import Contact
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.robot.robot import Robot
from planner.trajectory.trajectory import Trajectory

TOLERANCE, SHARE = 1e-3, 0.1  # m, and of the clearance itself: what is reported is too large by less than either
CLOSE = 5e-3  # m: models of one robot differ by a millimetre, and calibrations by more
TOO_CLOSE = "close"  # the row of the summary that is there only where something comes closer than CLOSE
TOO_CLOSE_TEXT = (
    f"less than {1000 * CLOSE:g} mm, by which the robot's true shape or place may differ: --margin 0.005 keeps a "
    "distance for certain, at start and goal too; --extra-clearance 0.01 lets refined paths keep more where possible"
)
SHOWN = 1e-4  # m: the smallest clearance that is printed; proofs need about twice that
NOTHING_NEAR = "there is nothing to come near to"
_CHORD = 1e-5  # rad (m): how far a motion may be from the chords along which its clearance is looked for
_STRAIGHT = 1e-3  # rad: a smaller change of direction is no corner


def dense_path(path: Floats, step: float = W_ALONG_PATH) -> Floats:
    """Configurations (n, dof) along a joint path, no joint moving more than ``step`` (rad) between two of them."""
    return dense_segments(path, step)[0]


def dense_segments(path: Floats, step: float) -> tuple[Floats, Ints]:
    """Configurations (n, dof) as :func:`dense_path` has them, and the segment (n,) that each ends or lies on."""
    parts = parts_of(np.abs(np.diff(path, axis=0)).max(axis=1, initial=0.0), step)
    return cut(path, parts), np.concatenate([[0], np.repeat(np.arange(len(parts)), parts)])


@dataclass(frozen=True)
class PathMeasures:
    """What every report says of a joint path: w at its smallest and in the mean, lengths in rad and m."""

    w_min: float
    w_mean: float
    joint_length: float
    workspace_length: float


def measure_path(robot: Robot, path: Floats) -> PathMeasures:
    """Manipulability at states ``W_ALONG_PATH`` apart, and both lengths, of a joint path (k, dof)."""
    w = path_manipulability(robot, path)
    return PathMeasures(float(w.min()), float(w.mean()), joint_path_length(path), tool_path_length(robot, path))


def path_manipulability(robot: Robot, path: Floats) -> Floats:
    """w (n,) sampled densely along a joint path."""
    return w_along_path(robot, path)[1]


def w_along_path(robot: Robot, path: Floats) -> tuple[Floats, Floats]:
    """Joint motion (n,) rad from the start, and w (n,) there, sampled densely along a joint path."""
    q = dense_path(path)
    return lengths_along(q), manipulability(robot, q)


def tool_path_length(robot: Robot, path: Floats) -> float:
    """Length (m) of the tool's path along a joint path."""
    return float(np.linalg.norm(np.diff(tool_positions(robot, dense_path(path)), axis=0), axis=1).sum())


def joint_path_length(path: Floats) -> float:
    """Sum of the Euclidean lengths (rad) of a joint path's segments."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def count_corners(path: Floats) -> int:
    """How often a joint path (k, dof) changes its direction, by more than 0.001 rad: a robot stops or blends there."""
    step = np.diff(path, axis=0)
    far = np.linalg.norm(step, axis=1)
    ahead = step[far > 0] / far[far > 0][:, None]
    return int((np.linalg.norm(np.diff(ahead, axis=0), axis=1) > _STRAIGHT).sum())


def path_contact(checker: CollisionChecker, path: Floats, step: float = RECHECK) -> Seen | None:
    """The first contact along a joint path sampled every ``step`` metres of motion, without bounds or proofs."""
    start = path[:-1] if len(path) > 1 else path
    return first_seen(checker, straight(start, np.diff(path, axis=0) if len(path) > 1 else 0.0 * path), step)


def path_clearance(checker: CollisionChecker, path: Floats) -> tuple[Floats, Floats]:
    """Configurations (n, dof) along a joint path, ``CLEARANCE_ALONG_PATH`` apart, and the clearance (n,) m at each."""
    along = (dense_states(checker.world, a, b - a, CLEARANCE_ALONG_PATH)[0] for a, b in itertools.pairwise(path))
    q = np.concatenate([path[:1], *(states[1:] for states in along)])
    return q, Clearance(checker)(q)


@dataclass(frozen=True)
class Nearest:
    """The smallest distance ``min`` (m), of the ``pair`` of things, and where: ``at``.

    Along a path ``at`` is the share of its joint motion, in a motion the time in s.
    """

    min: float
    pair: tuple[str, str]
    at: float

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {"min": self.min, "pair": list(self.pair), "at": self.at}


def nearest_on_path(path: Floats, checker: CollisionChecker) -> Nearest | None:
    """The smallest clearance along a joint path (k, dof), to a tenth; None where no joint moves a checked pair."""
    along = lengths_along(path)
    return _nearest(path, along / max(float(along[-1]), 1e-300), checker)


def nearest_in_motion(trajectory: Trajectory, checker: CollisionChecker) -> Nearest | None:
    """The smallest clearance along a motion."""
    return nearest_on_pieces(trajectory.coefficients, trajectory.times, checker)


def nearest_on_pieces(coefficients: Floats, places: Floats, checker: CollisionChecker) -> Nearest | None:
    """The smallest clearance on pieces (k, degree + 1, dof) between ``places`` (k + 1,), along chords within 0.01 mrad.

    ``at`` of the result lies between two places, such as times.
    """
    length = np.diff(places)
    bend = np.abs(bernstein(derivative(coefficients, 2))).max(axis=(1, 2), initial=0.0)
    counts = np.maximum(1, np.ceil(np.sqrt(bend / (8.0 * _CHORD)))).astype(int)
    piece = np.repeat(np.arange(len(counts)), counts)
    u = (np.arange(len(piece)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[piece]
    q = np.vstack([evaluate(coefficients[piece], u), coefficients[-1:].sum(axis=1)])
    return _nearest(q, np.append(places[piece] + u * length[piece], places[-1]), checker)


def _nearest(path: Floats, places: Floats, checker: CollisionChecker) -> Nearest | None:
    """The smallest clearance along a path (k, dof), whose rows are at ``places`` (k,)."""
    found = smallest_clearance(checker, path)
    pair = None if found is None else nearest_pair(checker, found[3])
    if found is None or pair is None:
        return None
    value, segment, share, _ = found
    ends = places[segment : segment + 2]
    return Nearest(value, (pair.first, pair.second), float(ends[0] + share * (ends[-1] - ends[0])))


def smallest_clearance(checker: CollisionChecker, path: Floats) -> tuple[float, int, float, Floats] | None:
    """The smallest clearance (m) along a path (k, dof), to 1 mm and to a tenth; None where no pair is checked.

    With it the segment, the share of its length and the configuration (dof,) there. A distance changes by no more than
    its two bodies move, so between two samples at ``left`` and ``right``, ``motion`` apart, it is at least
    (left + right - motion) / 2. Pieces that may hide one that is smaller by more than that are halved, all at a time,
    until there are none (Piyavskii 1972). The backend's own error comes on top.
    """
    clearance, best = Clearance(checker), (np.inf, 0, 0.0, path[0])
    # two bodies may come nearer by what both of them move
    motion = (checker.chain.sizes(np.diff(path, axis=0)) @ checker.world.pair_reach.T).max(axis=1, initial=0.0)
    passed = so_far(motion)  # (k,) motion from the start to each waypoint

    def look(places: Floats) -> Floats:
        """The clearances (n,) at ``places`` (n,) of which one is a new best one, if any is; lower bounds of others."""
        nonlocal best
        segment = np.clip(np.searchsorted(passed, places, side="right") - 1, 0, max(0, len(path) - 2))
        ahead = np.minimum(segment + 1, len(path) - 1)
        share = (places - passed[segment]) / np.maximum(passed[ahead] - passed[segment], 1e-300)
        q = path[segment] + share[:, None] * (path[ahead] - path[segment])
        values = clearance.smallest(q, best[0])
        row = int(values.argmin())
        if values[row] < best[0]:
            best = float(values[row]), int(segment[row]), float(share[row]), q[row]
        return values

    # CLEARANCE_FIRST long at first, whatever the waypoints: a trajectory has thousands of them
    places = np.linspace(0.0, passed[-1], max(1, int(np.ceil(passed[-1] / CLEARANCE_FIRST))) + 1)
    values = look(places)
    low, high, left, right = places[:-1], places[1:], values[:-1], values[1:]
    while True:
        bound = np.maximum(0.0, 0.5 * (left + right - (high - low)))
        hiding = np.isfinite(bound) & (bound < best[0] - slack(best[0]))
        if not hiding.any():
            return best if np.isfinite(best[0]) else None
        low, high, left, right = low[hiding], high[hiding], left[hiding], right[hiding]
        middle = 0.5 * (low + high)
        value = look(middle)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        left, right = np.concatenate([left, value]), np.concatenate([value, right])


def slack(clearance: float) -> float:
    """By how much (m) a reported ``clearance`` may be too large."""
    return min(TOLERANCE, SHARE * clearance)


def nearest_pair(checker: CollisionChecker, q: Floats) -> Contact | None:
    """The checked pair that is nearest at ``q`` (dof,), of those that some joint can move; None where there is none."""
    world = checker.world
    checked = np.concatenate([world.checked.ravel(), np.ones(len(world.self_pairs), dtype=bool)])
    pairs = np.flatnonzero(checked & world.moving)
    if not len(pairs):
        return None
    return world.contact(int(pairs[checker.gaps(q, pairs).argmin()]))


def clearance_text(clearance: float) -> str:
    """A clearance (m) for people: one that would be printed as 0.0 mm says what it means."""
    if clearance >= SHOWN:
        return f"{1000 * clearance:.1f} mm"
    return f"less than {1000 * SHOWN:g} mm, which no proof can tell from contact"


def nearest_text(near: Nearest) -> str:
    """A clearance and its two things."""
    return f"{clearance_text(near.min)} ('{near.pair[0]}' and '{near.pair[1]}')"
