"""The inequalities of a certificate, in numpy alone: curves, where bodies are on them, how far these move, planes.

Each inequality, as [5], holds in real arithmetic, whoever wrote the numbers: docs/explanation/certificate.md has them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

Array = np.ndarray
Data = dict[str, Any]
Shape = tuple[Array, float, bool]  # the convex hull of points (k, 3) with a radius around it, or a cylinder of two
MOST = 1000.0  # rad, m, also velocities times seconds and so on: larger numbers are refused [1]
TURNED = 2e-11  # what a joint's rotation is off at most, computed [6]
OFF = 2e-11  # of the sum of a polynomial's coefficients: what it is off at most, computed [5], and derivatives [11]
ROUNDED = 1.0 + 1e-12  # what sums of products of non-negative numbers are too small by at most [7]


class Refused(Exception):
    """What is not proven, as a sentence."""


def require(holds: Any, why: str) -> None:
    if not np.all(holds):
        raise Refused(why)


# c_1, c_2 ... by the rise, the slopes and second derivatives at both ends: Hermite, as ROS 2 controllers have it [3]
QUINTIC = ((0, 1, 0, 0, 0), (0, 0, 0, 0.5, 0), (10, -6, -4, -1.5, 0.5), (-15, 8, 7, 1.5, -1), (6, -3, -3, -0.5, 0.5))
HERMITE = (((1,),), ((0, 1, 0), (3, -2, -1), (-2, 1, 1)), QUINTIC)


def curves(data: Data) -> Array:
    """Coefficients (pieces, 6, dof) of q(s) = sum of c_k s^k, s in [0, 1]: the path's segments, then the motion [3]."""
    path, h, knots = data["path"], np.diff(data["clock"])[:, None] / 1e9, data["knots"]
    path = path if len(path) > 1 else np.repeat(path, 2, axis=0)
    made = np.zeros((len(path) - 1 + len(h), 6, path.shape[1]))
    made[: len(path) - 1, 0], made[: len(path) - 1, 1] = path[:-1], np.diff(path, axis=0)
    if len(h):
        made[-len(h) :, 0], ends = knots[0][:-1], [np.diff(knots[0], axis=0)]
        ends += [end * h**k for k, rows in enumerate(knots[1:], start=1) for end in (rows[:-1], rows[1:])]
        made[-len(h) :, 1 : 2 * len(knots)] = np.einsum("kc,cnd->nkd", HERMITE[len(knots) - 1], ends)
    require(np.abs(made).sum(axis=1) <= MOST, "a joint turns or slides farther than any does.")  # [1]
    return made


def require_between(pieces: Array, low: Array, high: Array, off: Array, why: str, meta: Data) -> None:
    """Polynomials, off by ``off`` as computed, stay within bounds: so do Bernstein coefficients of their parts [11]."""
    degree, dof = pieces.shape[1] - 1, pieces.shape[2]
    choose = np.array([[math.comb(j, k) for k in range(degree + 1)] for j in range(degree + 1)], dtype=float)
    half = choose / 2.0 ** np.arange(degree + 1)[:, None]  # de Casteljau: of a whole piece to its first half
    control, row = np.einsum("jk,nkd->ndj", choose / choose[-1], pieces).reshape(-1, degree + 1), np.arange(off.size)
    for _ in range(40):
        beyond = np.maximum(control - high[row % dof, None], low[row % dof, None] - control) + off.ravel()[row, None]
        bad = (beyond > 0.0).any(axis=1)
        if not bad.any():
            return
        row, control, beyond = row[bad], control[bad], beyond[bad]
        if beyond[:, [0, -1]].max() > 0.0 or len(row) > 1_000_000:  # its ends are values themselves
            break
        row, control = np.tile(row, 2), np.concatenate([control @ half.T, control[:, ::-1] @ half.T])
    raise Refused(f"{why}: joint {meta['joints'][row[0] % dof]} on piece {row[0] // dof}.")


def rotation(axis: Array, angle: Any) -> Array:
    """(..., 3, 3) about a unit vector (3,) by angles (..., 1, 1), Rodrigues' formula, no library's sine [4]."""
    require(np.abs(angle) <= MOST, "a joint turns farther than any does.")
    turned: Any = np.ones_like(angle, dtype=complex)
    cross = np.cross(axis, np.eye(3)).T
    for k in range(20, 0, -1):
        turned = 1.0 + angle / (1024 * k) * 1j * turned
    for _ in range(10):
        turned = turned * turned
    return np.eye(3) + turned.imag * cross + (1.0 - turned.real) * (cross @ cross)


def frames(data: Data, q: Array) -> tuple[Array, Array]:
    """Rotations (joints + 1, n, 3, 3) and origins (joints + 1, n, 3) of base and joints at q (n, dof) [6]."""
    q = data["factor"] * q[:, data["leader"]] + data["zero"]  # now of all joints
    turn, origin = np.empty((q.shape[1] + 1, len(q), 3, 3)), np.zeros((q.shape[1] + 1, len(q), 3))
    turn[0] = np.eye(3)
    for j, (before, axis, slides) in enumerate(zip(data["parent"], data["axis"], data["prismatic"] > 0, strict=True)):
        turn[j + 1] = turn[before] @ data["turn"][j] @ rotation(axis, np.where(slides, 0.0, q[:, j, None, None]))
        origin[j + 1] = origin[before] + turn[before] @ data["shift"][j]
        origin[j + 1] += np.where(slides, q[:, j, None], 0.0) * (turn[j + 1] @ axis)
    return turn, origin


def reaches(data: Data, pieces: Array) -> tuple[Array, float]:
    """(items + 1, joints) how fast a joint moves items and tool at most [8], 0 if it carries none; for rounding, m."""
    made, joints = [*data["shapes"], (data["tool"][None, :3, 3], 0.0)], np.append(data["joint"], data["carrier"])
    most = np.abs(pieces).sum(axis=1).max(axis=0)[data["leader"]] * np.abs(data["factor"]) + np.abs(data["zero"])
    require(most <= MOST, "a joint follows another farther than any goes.")  # [1]
    travel = np.where(data["prismatic"] > 0, ROUNDED * most, 0.0)
    found, size = np.zeros((len(made), len(travel))), 1.0
    for item, (points, radius, *_) in enumerate(made):
        joint, far = joints[item] - 1, np.linalg.norm(points, axis=1).max() + radius
        across = np.linalg.norm(np.cross(points, data["axis"][max(joint, 0)]), axis=1).max() + radius
        size = max(size, far)
        while joint >= 0:
            found[item, joint] = 1.0 if data["prismatic"][joint] else max(across, 1e-9)
            before, shift = data["parent"][joint] - 1, data["shift"][joint]
            across = far + travel[joint] + np.linalg.norm(np.cross(shift, data["axis"][before]))
            far, joint = far + travel[joint] + np.linalg.norm(shift), before
    size += np.linalg.norm(data["shift"], axis=1).sum() + travel.sum()
    require(np.linalg.det(data["turn"]) > 0.0, "a joint's frame is no rotation.")
    stretched = np.abs(data["turn"].transpose(0, 2, 1) @ data["turn"] - np.eye(3)).max()  # [2]
    return found, float((TURNED + 8.0 * stretched) * (len(travel) + 1) * size)  # [10]


def farthest(shape: Shape, direction: Array) -> Array:
    """(n,) how far a shape goes in unit directions (n, 3) of its frame [9]."""
    points, radius, cylinder = shape
    reached = (direction @ points.T).max(axis=1)
    if not cylinder:
        return reached + radius
    along, length = points[1] - points[0], np.linalg.norm(points[1] - points[0])
    require(length > 1e-9, "a cylinder is too short to have an axis.")
    return reached + radius * np.linalg.norm(np.cross(direction, along / length), axis=1)


def middles(data: Data, pieces: Array, rows: Array) -> tuple[Array, Array]:
    """Configurations (n, dof) in the middles of the intervals, how far all joints (n, joints) move from there [7]."""
    low, high, c = data["low"][rows], data["high"][rows], pieces[data["piece"][rows]]
    middle, off = 0.5 * (low + high), OFF * np.abs(c).sum(axis=1)
    half = np.maximum(high - middle, middle - low)
    for k in range(5):  # Taylor's expansion at the middle, by Horner's scheme once a power
        for j in range(4, k - 1, -1):
            c[:, j] += middle[:, None] * c[:, j + 1]
    moved = off + sum(np.abs(c[:, k]) * half[:, None] ** k for k in range(1, 6))
    return c[:, 0], np.abs(data["factor"]) * moved[:, data["leader"]]


def gaps_and_motions(data: Data, pieces: Array, reach: Array, rows: Array) -> tuple[Array, Array]:
    """(n,) each: the width between the planes in the middles of the intervals [9], the motion from there [7], m."""
    pair, normal = data["pairs"][data["pair"][rows]], data["normal"][rows].astype(float)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)  # NaN of none, which shows nothing
    begin = np.unique(data["piece"][rows] + 1j * data["low"][rows], return_inverse=True)[1]
    _, one, own = np.unique(begin + 1j * data["high"][rows], return_index=True, return_inverse=True)
    q, moved = middles(data, pieces, rows[one])  # of intervals that pairs have in common once
    turn, origin = frames(data, q)
    apart = np.zeros(len(rows))
    for sign, items in zip((1.0, -1.0), pair.T, strict=True):
        for item in np.unique(items):
            mine = np.flatnonzero(items == item)
            joint, direction = max(data["joint"][item], 0), sign * normal[mine]
            apart[mine] -= np.einsum("ni,ni->n", direction, origin[joint][own[mine]])
            apart[mine] -= farthest(data["shapes"][item], (direction[:, None, :] @ turn[joint][own[mine]])[:, 0])
    first, second = reach[pair.T]
    relative = np.where((first > 0) & (second > 0), 0.0, first + second)  # joints that carry both do not count [8]
    return apart, np.einsum("nd,nd->n", moved[own], relative)


def least_w(data: Data, pieces: Array, reach: Array, spare: float, count: int, rows: Array) -> Array:
    """(n,) what w of the first rows of the tool's Jacobian is at least on the intervals of witnesses [12]."""
    q, moved = middles(data, pieces, rows)
    turn, origin = frames(data, q)
    order = np.arange(len(reach))
    tool = origin[data["carrier"]] + turn[data["carrier"]] @ data["tool"][:3, 3]
    matrix = np.zeros((len(rows), 6, len(reach)))
    for k in np.flatnonzero(reach):
        axis = turn[k + 1] @ data["axis"][k]
        matrix[:, :3, k] = axis if data["prismatic"][k] else np.cross(axis, tool - origin[k + 1])
        matrix[:, 3:, k] = 0.0 if data["prismatic"][k] else axis
    turns = (order < order[:, None]) & (count == 6)  # the joint before turns the axis of the one behind
    rate = np.hypot(reach[np.maximum(order, order[:, None])], turns) * (np.outer(reach, reach) > 0)
    led = data["factor"][:, None] * (data["leader"][:, None] == np.arange(len(data["wraps"])))  # [12]
    change = ROUNDED * np.linalg.norm(moved @ rate.T @ np.abs(led), axis=1)
    change += 4.0 * len(reach) * spare * max(1.0, np.abs(led).sum(axis=0).max())
    matrix, one = matrix[:, :count] @ led, np.eye(min(count, led.shape[1]))
    u, s, v = np.linalg.svd(matrix, full_matrices=False)  # nothing rests on how good it is
    wrong = (u.transpose(0, 2, 1) @ u - one, v @ v.transpose(0, 2, 1) - one, matrix - (u * s[:, None]) @ v)
    bent, skewed, lost = (np.linalg.norm(each, axis=(1, 2))[:, None] for each in wrong)
    least = s * (1.0 - bent - skewed - 1e-12) - (lost + change[:, None] + 1e-12 * s.max(axis=1, keepdims=True))
    return np.maximum(least, 0.0).prod(axis=1) / ROUNDED
