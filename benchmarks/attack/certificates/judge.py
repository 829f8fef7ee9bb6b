"""Whether what a certificate claims is true, by another method: many configurations, two near points of each pair.

It shares nothing with the checker but the file: forward kinematics by SciPy's rotations, distances by non-negative
least squares. A pair is too close only where two points say so that lie in the bodies.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval
from scipy.optimize import minimize_scalar, nnls
from scipy.spatial.transform import Rotation

from planner.base.arrays import Floats

_HEAVY = 1e3  # of the equations that weights sum to one
_RIM = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


def closest(data: dict[str, Any], samples: int, rng: np.random.Generator, below: float) -> float:
    """The smallest distance (m) of a pair that is proven apart, in ``samples`` configurations of each piece of a curve.

    Never below the truth. Pairs whose enclosing spheres are ``below`` m apart count as that.
    """
    least = np.inf
    bodies, pairs = [_points(data, item) for item in range(len(data["joint"]))], proven_pairs(data)
    for curve in curves_of(data):
        for s in np.concatenate([[0.0, 1.0], rng.uniform(size=samples)]):
            placed = _placed(data, np.sum([c * s**k for k, c in enumerate(curve)], axis=0))
            there = [_at(placed, data, item, points) for item, (points, _) in enumerate(bodies)]
            middles = np.array([points.mean(axis=0) for points in there])
            sizes = [
                np.linalg.norm(p - m, axis=1).max() + bodies[k][1]
                for k, (p, m) in enumerate(zip(there, middles, strict=True))
            ]
            for a, b in pairs:
                rough = float(np.linalg.norm(middles[a] - middles[b]) - sizes[a] - sizes[b])
                if rough < min(least, below):
                    least = min(least, _distance(there[a], there[b]) - bodies[a][1] - bodies[b][1])
    return float(least)


def proven_pairs(data: dict[str, Any]) -> list[tuple[int, int]]:
    """The pairs of items that are said to be apart: of those that a joint moves against each other, in order."""
    carriers = np.maximum(data["joint"], 0).tolist()
    moving = [pair for pair in itertools.combinations(range(len(carriers)), 2) if len({carriers[k] for k in pair}) > 1]
    return [pair for pair, left in zip(moving, data["left"].tolist(), strict=True) if left == 0]


def least_w(data: dict[str, Any], words: dict[str, Any], samples: int) -> float:
    """The smallest w in ``samples`` configurations of each interval with a floor; inf of none.

    By singular values, and from the smallest sample on by a search along its interval.
    """
    curves, found = curves_of(data), np.inf
    high, claims = (data[name][int(data["parts"][:-1].sum()) :] for name in ("high", "normal"))
    pieces = np.repeat(np.arange(len(curves)), data["parts"][-1])
    for k, piece in enumerate(pieces):
        low = high[k - 1] if k and pieces[k - 1] == piece else 0.0
        if not claims[k].any():
            continue
        curve, s = curves[piece], np.linspace(low, high[k], samples)
        w = np.array([_w(data, words, polyval(each, curve)) for each in s])
        found = min(found, float(w.min()))
        if w.min() < 1.01 * data["floor"]:
            ends = s[max(w.argmin() - 1, 0)], s[min(w.argmin() + 1, samples - 1)]
            at: Any = minimize_scalar(lambda t, c=curve: _w(data, words, polyval(t, c)), bounds=ends, method="bounded")
            found = min(found, float(at.fun))
    return found


def _w(data: dict[str, Any], words: dict[str, Any], q: Floats) -> float:
    """The product of the singular values of the tool's Jacobian."""
    placed, joint = _placed(data, q), int(data["carrier"])
    turn, origin = placed[joint]
    tool, matrix = origin + turn @ data["tool"][:3, 3], np.zeros((6, len(q)))
    while joint > 0:
        turn, origin = placed[joint]
        axis = turn @ data["axis"][joint - 1]
        slides = bool(data["prismatic"][joint - 1])
        column = np.array([*axis, 0, 0, 0] if slides else [*np.cross(axis, tool - origin), *axis])
        matrix[:, data["leader"][joint - 1]] += data["factor"][joint - 1] * column
        joint = int(data["parent"][joint - 1])
    rows = {"pose": 6, "translation": 3, "planar": 2}[words["rows"]]
    return float(np.linalg.svd(matrix[:rows], compute_uv=False).prod())


def beyond_limits(data: dict[str, Any], samples: int = 50) -> float:
    """By how much (relative, rad or m) a sample of a curve is beyond the limits that the certificate names, at most."""
    s, found = np.linspace(0.0, 1.0, samples)[:, None], -np.inf
    free, seconds = data["wraps"] > 0, np.diff(data["clock"]) / 1e9
    curves = curves_of(data)
    for number, curve in enumerate(curves):
        q = polyval(s[:, 0], curve).T
        found = max(found, float(np.where(free, -np.inf, np.maximum(data["lower"] - q, q - data["upper"])).max()))
        piece = number - (len(curves) - len(seconds))
        for order in range(1, 1 + len(data["knots"]) * (piece >= 0)):
            slope = polyval(s[:, 0], polyder(curve, order)).T / seconds[piece] ** order
            most = data["limits"][order - 1]
            found = max(found, float((np.abs(slope) - most * (1.0 + 1e-6)).max()))
    return found


def curves_of(data: dict[str, Any]) -> list[Floats]:
    """Coefficients (degree + 1, dof) of every segment of the path and of every piece of the motion."""
    path, knots = data["path"], data["knots"]
    found = [np.array([a, b - a]) for a, b in itertools.pairwise(path)]
    for k, h in enumerate(np.diff(data["clock"]) / 1e9):
        orders, rows = range(len(knots)), []
        for s in (0.0, 1.0):  # the linear equations that a polynomial and its derivatives satisfy at both ends
            for order in orders:
                powers = np.arange(2 * len(knots))
                factor = np.array([np.prod(np.arange(p, p - order, -1)) if p >= order else 0.0 for p in powers])
                rows.append(factor * (s ** np.maximum(powers - order, 0)))
        ends = [knots[order][k + end] * h**order for end in (0, 1) for order in orders]
        found.append(np.linalg.solve(np.array(rows), np.array(ends)))
    return found


def _points(data: dict[str, Any], item: int) -> tuple[Floats, float]:
    """Points of an item in the frame of its joint, and the radius around them; of a cylinder points of its rims."""
    begin = int(data["count"][:item].sum())
    points, radius = data["points"][begin : begin + data["count"][item]], float(data["radius"][item])
    if not data["cylinder"][item]:
        return points, radius
    axis = (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
    u = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    u /= np.linalg.norm(u)
    rim = radius * (np.outer(np.cos(_RIM), u) + np.outer(np.sin(_RIM), np.cross(axis, u)))
    return np.concatenate([points[0] + rim, points[1] + rim]), 0.0


def _placed(data: dict[str, Any], q: Floats) -> list[tuple[Floats, Floats]]:
    """Rotation and origin of the base and every joint."""
    placed = [(np.eye(3), np.zeros(3))]
    q = data["factor"] * q[data["leader"]] + data["zero"]  # of all joints
    for j in range(len(q)):
        turn, origin = placed[data["parent"][j]]
        origin, turn = origin + turn @ data["shift"][j], turn @ data["turn"][j]
        if data["prismatic"][j]:
            origin = origin + turn @ data["axis"][j] * q[j]
        else:
            turn = turn @ Rotation.from_rotvec(data["axis"][j] * q[j]).as_matrix()
        placed.append((turn, origin))
    return placed


def _at(placed: list[tuple[Floats, Floats]], data: dict[str, Any], item: int, points: Floats) -> Floats:
    turn, origin = placed[max(int(data["joint"][item]), 0)]
    return points @ turn.T + origin


def _distance(a: Floats, b: Floats) -> float:
    """The distance (m) of two points of the hulls of ``a`` and ``b`` that are as near as least squares find them."""
    rows = np.vstack([np.hstack([a.T, -b.T]), np.zeros((2, len(a) + len(b)))])
    rows[3, : len(a)] = rows[4, len(a) :] = _HEAVY
    weights, _ = nnls(rows, np.array([0.0, 0.0, 0.0, _HEAVY, _HEAVY]))
    first, second = weights[: len(a)], weights[len(a) :]
    return float(np.linalg.norm(first @ a / first.sum() - second @ b / second.sum()))
