"""Fewer corners: pairs of a path's waypoints become one, wherever that costs no more than a stated share.

A path that slides along an obstacle bends often and little. One corner a little farther out does for two of them; the
search puts it where both neighbours' motions are proven and the cost rises least, and descent then moves what is left.
"""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats
from planner.roadmap.refine import PathRefiner

TOLERANCE = 1e-3  # of the cost: what a path with fewer corners may cost more than the one it came from
_OUTWARD = (0.0, 0.3, 0.7, 1.2)  # candidates beyond the point where the neighbouring motions would meet
_RANDOM = 24  # candidates around these
_PROVEN = 48  # candidates of all pairs whose motions are proven


def simplified(refiner: PathRefiner, path: Floats, rng: np.random.Generator) -> Floats:
    """The path (k, dof) with as few waypoints as are found for at most 1 + ``TOLERANCE`` times its cost.

    Its ends stay, its motions are proven, and keep above the floor of the cost. One of infinite cost, which does not
    keep above it, stays as it is: no share of that is a limit.
    """
    limit = (1.0 + TOLERANCE) * refiner.total(path)
    while len(path) > 3 and np.isfinite(limit) and not refiner.progress.stopped:
        merged = _merged(refiner, path, limit, rng)
        if merged is None:
            break
        path = refiner.descend(merged)
    return path


def _merged(refiner: PathRefiner, path: Floats, limit: float, rng: np.random.Generator) -> Floats | None:
    """The path with one pair of neighbouring waypoints merged, the pair that is cheapest to merge; None for none."""
    a, p, q, b = path[:-3], path[1:-2], path[2:-1], path[3:]
    robot, places = refiner.prover.robot, _candidates(a, p, q, b, rng)
    places = np.where(robot.continuous, places, np.clip(places, robot.lower, robot.upper))
    count = places.shape[1]
    flat = places.reshape(-1, robot.dof)
    before, after = np.repeat(a, count, axis=0), np.repeat(b, count, axis=0)
    step = refiner.cost(path[:-1], path[1:])
    rise = refiner.cost(before, flat) + refiner.cost(flat, after) - np.repeat(step[:-2] + step[1:-1] + step[2:], count)
    order = np.argsort(rise, kind="stable")
    order = order[step.sum() + rise[order] <= limit][:_PROVEN]
    start = np.stack([before[order], flat[order]], axis=1).reshape(-1, robot.dof)
    end = np.stack([flat[order], after[order]], axis=1).reshape(-1, robot.dof)
    best = refiner.first_allowed(start, end, np.full(len(order), 2), np.array([len(order)]))[0]
    if best < 0:
        return None
    row = order[best]
    pair = row // count
    return np.concatenate([path[: pair + 1], flat[row : row + 1], path[pair + 3 :]])


def _candidates(a: Floats, p: Floats, q: Floats, b: Floats, rng: np.random.Generator) -> Floats:
    """Where one waypoint might stand for ``p`` and ``q``, between ``a`` and ``b``: (k, candidates, dof)."""
    middle, meeting = 0.5 * (p + q), _meeting(a, p, q, b)
    places = [p, q, middle, *(meeting + share * (meeting - middle) for share in _OUTWARD)]
    size = 0.5 * (
        np.linalg.norm(q - p, axis=1, keepdims=True) + np.linalg.norm(meeting - middle, axis=1, keepdims=True)
    )
    for _ in range(_RANDOM):
        around = middle + rng.uniform(0.0, 1.5) * (meeting - middle)
        places.append(around + rng.uniform(0.1, 0.7) * size * rng.normal(size=p.shape) / np.sqrt(p.shape[1]))
    return np.stack(places, axis=1)


def _meeting(a: Floats, p: Floats, q: Floats, b: Floats) -> Floats:
    """Half way between the points where the lines a p and b q, drawn beyond p and q, come nearest to each other.

    They are drawn no farther than ``p`` and ``q`` are apart.
    """
    u, v = (ahead / np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-300) for ahead in (p - a, q - b))
    w, most = q - p, np.linalg.norm(q - p, axis=1)
    uv, uw, vw = ((one * other).sum(axis=1) for one, other in ((u, v), (u, w), (v, w)))
    level = np.maximum(1.0 - uv * uv, 1e-9)
    s, t = (np.clip(far, 0.0, most)[:, None] for far in ((uw - uv * vw) / level, (uv * uw - vw) / level))
    return 0.5 * (p + s * u + q + t * v)
