"""How near a path and its motion come to anything that is checked, where, and what to do where that is too near."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Floats, so_far
from planner.base.polylines import lengths_of
from planner.base.polynomials import bernstein, derivative, evaluate
from planner.collision.checker import CollisionChecker
from planner.trajectory.path_clearance import (
    CLOSE,
    TOO_CLOSE,
    TOO_CLOSE_TEXT,
    clearance_text,
    nearest_pair,
    smallest_clearance,
)
from planner.trajectory.trajectory import Trajectory

_CHORD = 1e-5  # rad (m): how far a motion may be from the chords along which its clearance is looked for


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
    lengths = lengths_of(path)
    passed = so_far(lengths)
    return _nearest(path, passed / max(float(passed[-1]), 1e-300), checker)


def nearest_in_motion(trajectory: Trajectory, checker: CollisionChecker) -> Nearest | None:
    """The same along a motion."""
    return nearest_on_pieces(trajectory.coefficients, trajectory.times, checker)


def nearest_on_pieces(coefficients: Floats, times: Floats, checker: CollisionChecker) -> Nearest | None:
    """The same along pieces (k, degree + 1, dof) between ``times`` (k + 1,) s, along chords within 0.01 mrad."""
    h = np.diff(times)
    bend = np.abs(bernstein(derivative(coefficients, 2))).max(axis=(1, 2), initial=0.0)
    counts = np.maximum(1, np.ceil(np.sqrt(bend / (8.0 * _CHORD)))).astype(int)
    piece = np.repeat(np.arange(len(counts)), counts)
    u = (np.arange(len(piece)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[piece]
    q = np.vstack([evaluate(coefficients[piece], u), coefficients[-1:].sum(axis=1)])
    return _nearest(q, np.append(times[piece] + u * h[piece], times[-1]), checker)


def _nearest(q: Floats, places: Floats, checker: CollisionChecker) -> Nearest | None:
    """The smallest clearance along configurations (k, dof) at ``places`` (k,)."""
    found = smallest_clearance(checker, q)
    pair = None if found is None else nearest_pair(checker, found.q)
    if found is None or pair is None:
        return None
    ends = places[found.segment : found.segment + 2]
    return Nearest(found.value, (pair.first, pair.second), float(ends[0] + found.share * (ends[-1] - ends[0])))


def clearance_rows(clearance: dict[str, Any], asked: float) -> list[tuple[str, str]]:
    """What is said of a record of ``path``, ``motion`` and what is ``kept`` (m), where ``asked`` (m) was asked for."""
    path, motion, kept = (clearance[key] for key in ("path", "motion", "kept"))
    if path is None:
        return [("clearance", "there is nothing to come near to")]
    text = f"{_text(path)} at {100 * path['at']:.0f} % of the path"
    if motion is not None:
        text += f"; {_text(motion)} at {motion['at']:.3f} s of the motion"
    if 0 < kept < asked:
        text += f". Refined paths keep {1000 * kept:.2g} of {1000 * asked:g} mm: start, goal or a passage leave no more"
    least = min(item["min"] for item in (path, motion) if item is not None)
    return [("clearance", text), *([(TOO_CLOSE, TOO_CLOSE_TEXT)] if least < CLOSE else [])]


def check_rows(nearest: Nearest | None, touches: bool, unit: str) -> list[tuple[str, str]]:
    """What a check of somebody's motion says of its clearance; ``touches`` where a contact was found."""
    if nearest is None:
        return [("smallest clearance", "there is nothing to come near to")]
    if touches and nearest.min <= 0.0:
        return [("smallest clearance", f"none at {nearest.at:.3f} {unit}")]
    close = [(TOO_CLOSE, TOO_CLOSE_TEXT)] if nearest.min < CLOSE else []
    return [("smallest clearance", f"{_text(nearest.to_dict())} at {nearest.at:.3f} {unit}"), *close]


def _text(item: dict[str, Any]) -> str:
    return f"{clearance_text(item['min'])} ('{item['pair'][0]}' and '{item['pair'][1]}')"
