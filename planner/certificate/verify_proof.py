#!/usr/bin/env python3
r"""Check the certificate of a plan without the planner: this file needs Python and numpy, nothing else.

    python verify_proof.py OUT [--urdf ROBOT.urdf]
OUT is the folder that `planner plan --certificate` wrote. Exit code 0 and what is proven, or 1 and the reason.
docs/explanation/certificate.md explains the idea. The analysis follows: each inequality holds in real arithmetic,
whatever numbers the certificate contains. u = 2^-53, gamma_k = k u / (1 - k u), C = sum over k >= 1 of |c_k|.
[1] Sizes. LAYOUT bounds each number: coordinates by 1000 m, sum_k |c_k| of a joint on a piece by 1000, joints by 100,
times by 23 days, up to which nanoseconds differ as seconds. A joint of the tree is f q + z of a planned q, where |f|,
|z| and |f| sum_k |c_k| + |z| are at most 1000. So nothing overflows, and underflow is far below the 2e-11 L of [6].
[2] Frames. A joint's frame P stands for the nearest rotation. With eps = max |P^T P - I| < 1e-6 (as sigma of [10] is at
most 1e-5; usually 1e-15) and det P > 0, a singular value s has |s - 1| <= |s^2 - 1| <= ||P^T P - I|| <= 3 eps. Axes are
unit vectors up to 1e-13. Frames from a URDF are products of rotations [4], within 3e-12 rad of the file's angles.
[3] Curves. A segment of the path is q_0 + s (q_1 - q_0). A piece of the motion is the Hermite line, cubic or quintic
of a ROS 2 joint trajectory controller: c_0 = q_0, and QUINTIC weighs q_1 - q_0, h q', h^2 q'' at both ends, h in s.
[4] Sine and cosine. e^(ix) = (e^(ix/1024))^1024, where x/1024 is exact and below 1. Taylor's series to the 20th power
leaves 1e-19. Horner's f_k = 1 + (z/k) f_(k+1), |f_k| <= e, rounds by less than 20 u, as a complex product is off by at
most sqrt(5) u. Ten squarings multiply this by 1024 and add sqrt(5) u (512 + 256 + ...): in all below 3e-12.
[5] Joint values. In [3], q_1 - q_0 = sum c_k, h q'_0 = c_1, h q'_1 = sum k c_k, h^2 q''_0 = 2 c_2 and h^2 q''_1 =
sum k (k-1) c_k are at most 1, 1, 5, 2 and 20 times C. The table's columns sum to 31, 18, 14, 4 and 2, so the terms sum
to at most 167 C, with an error of gamma_10 of that. Taylor's shift to m adds gamma_16 (|c_0| + C), as m + w <= 1. The
sum is 2e-13 (|c_0| + C): values and motions of a joint are off by less than delta = 2e-11 (|c_0| + C).
[6] Forward kinematics. A joint's rotation is off by less than 5e-12 + 3 eps in norm, by [2], [4] and 3e-13 of f q + z.
It moves points beyond the joint by at most L times that, L the sum of link lengths, travel of prismatic joints and the
largest item or tool, at least 1 m. With products of errors (1e-3 of it), two points and the sums of [9] are off by less
than (dof + 1) (2e-11 + 8 eps) L.
[7] Motion of a joint. On [l, h] with middle m as rounded and w = max(h - m, m - l), Taylor's coefficients at m give
|q(s) - q(m)| <= mu = delta + sum over k >= 1 of |c_k(m)| w^k, times |f| for a joint that follows. Sums of products of
non-negative numbers are too small by less than 1e-12 of them.
[8] Motion of a body. A joint that turns by dq moves a point by at most |dq| times its distance from the axis, one that
slides by |dq|. From the body to the base: points of the joint's own body are within max |p x a| + r of its axis a. All
beyond the next joint is within max |p| + r, plus its travel, of that joint's origin o, so within that plus |o x a| of
the axis before. That distance is R, at least 1e-9 for joints that carry the body, else 0. Joints that carry both bodies
do not change their distance: R(A, B) is 0 for them, else R(A) + R(B).
[9] The gap. For |n| = 1, g = min_B n.x - max_A n.x is at most the distance of A and B. The support of a hull is that of
its points plus the radius, of a cylinder that of its ends plus r |n x a|. No n makes a false witness.
[10] The inequality. On the line from q(m) to q(s) the distance changes by at most sum_j R_j mu_j, so the checker
requires g > margin + (1 + 1e-12) sum_j R_j mu_j + sigma, where sigma = (dof + 1) (2e-11 + 8 eps) L (usually 1e-9 m).
[11] Limits. A polynomial lies between its least and largest Bernstein coefficient; pieces beyond a limit are halved (de
Casteljau). The k-th derivative multiplies c_j by j!/(j-k)! / h^k. The terms of the third, the largest, sum to at most
4338 C/h^3 (columns 780, 408, 372, 75, 57) with 19 roundings each: 9.2e-12 C/h^3. Forty halvings of eight roundings of
at most 60 C/h^3 add 2.2e-12, Bernstein's form 0.1e-12: less than the 2e-11 C/h^k that is added (delta to positions).
[12] The floor. w is the product of the singular values of J, the Jacobian of the tree's joints times the matrix of f.
A = J(q(m)), J(q(s)) = A + E, and sigma_k moves by at most ||E||_F (Weyl, Mirsky). For any U, S, V with A = USV + R,
sigma_k(USV) >= S_k (1 - ||U^T U - I||_F - ||V V^T - I||_F) where not negative. So w >= product over k of max(0, S_k (1
- ||U^T U - I|| - ||V V^T - I||) - ||R|| - ||E||). Columns of U and V are below 2: sums of 100 products are off by less
than 2e-13, those of R by 1e-13 of the largest S_k; the checker takes 1e-12. Joint k before i turns column i: R_i above,
1 below. Other joints move the tool: R_k above. So e_i = sum_k sqrt(R_max(i,k)^2 + [k < i, six rows]) mu_k, ||E|| <=
||e||, each column times |f|. A's columns are off by less than 4 dof sigma (z: sigma, z x (p - o): 1.2 sigma) times the
largest sum of |f| of a planned joint.
[13] The ends. Joint values agree to 1e-8 (up to whole turns without limits), positions and rotation entries to 2e-6.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray
Data = dict[str, Any]
Shape = tuple[Array, float, bool]  # points (k, 3), the radius around their convex hull, whether it is a cylinder
FORMAT, MOST = 5, 1000.0  # rad, m, also velocities times seconds and so on: larger numbers are refused [1]
TURNED = 2e-11  # largest error of a joint's rotation [6]
OFF = 2e-11  # largest error of a polynomial [5] and its derivatives [11], as a share of the sum of its coefficients
ROUNDED = 1.0 + 1e-12  # factor for the rounding of sums of products of non-negative numbers [7]
ROWS = {"planar": 2, "translation": 3, "pose": 6}  # of the tool's Jacobian, for w
ENDS = {"q": 0, "xyz": 3, "pose": 7}  # count of numbers of an end, 0: one per joint
SAME, REACHED = 1e-8, 2e-6  # rad or m: tolerances of an end in joint values, and in position and pose [13]
LIMIT = FORGIVEN = 1e-6  # tolerances: relative on limits of the motion, rad or m on positions
PROVEN, EXEMPT, OPEN = range(3)  # a pair: apart; left out by the robot's files or the scene; no plane is known
MOVING = ("revolute", "continuous", "prismatic")
WORDS = {*"format robot scene joints tree items cuts clouds held widened rows states identity".split(), "tool link"}  # noqa: SIM905
TERMS = ("covering", "noise", "calibration")  # of the radius of points that a sensor saw, m; the first may be estimated
KINDS, INTERPOLATED = ["velocity", "acceleration", "jerk"], ["lines", "cubics", "quintics"]
# arrays of the file: names; type, shape (a name is one size in all arrays), least and largest value [1]
LAYOUT: dict[str, tuple[str, tuple[int | str, ...], float, float]] = {
    "meta": ("u1", ("bytes",), 0, 255),  # JSON
    "parent": ("i8", ("joints",), 0, 100),  # of each joint: the number of the one before it, from 1; 0 the base
    "prismatic": ("u1", ("joints",), 0, 1),  # joints that slide
    "turn": ("f8", ("joints", 3, 3), -2, 2),  # a joint's frame in the frame of that joint: rotation and origin
    "shift axis": ("f8", ("joints", 3), -MOST, MOST),
    "leader": ("i8", ("joints",), 0, 99),  # the planned joint q of a joint's value factor q + zero
    "factor zero": ("f8", ("joints",), -MOST, MOST),
    "wraps": ("u1", ("dof",), 0, 1),  # planned joints without limits
    "lower upper": ("f8", ("dof",), -1e300, 1e300),
    "base tool": ("f8", (4, 4), -MOST, MOST),  # the tool of w is in the frame of its joint
    "carrier": ("i8", (), 0, 100),  # that joint
    "margin floor": ("f8", (), 0, MOST),  # m; under w
    "joint": ("i8", ("items",), -1, 100),  # the joint of a body, 0 the base, -1 the world
    "count": ("i8", ("items",), 1, 1 << 30),  # number of points
    "cylinder": ("u1", ("items",), 0, 1),  # else the convex hull of points, with a radius around it
    "radius": ("f8", ("items",), 0, MOST),
    "points": ("f8", ("points", 3), -MOST, MOST),  # in the joint's frame, item by item; of a cylinder both ends
    "left": ("u1", ("moving",), PROVEN, OPEN),  # of each pair of items that a joint moves against each other
    "path": ("f8", ("waypoints", "dof"), -MOST, MOST),
    "clock": ("i8", ("knots",), -2e15, 2e15),  # ns
    "knots": ("f8", ("columns", "knots", "dof"), -1e9, 1e9),  # positions, perhaps velocities, perhaps accelerations
    "limits": ("f8", ("kinds", "dof"), -1e300, 1e300),  # on velocity, acceleration, jerk
    "parts": ("i4", ("pairs and w", "pieces"), 1, 1 << 30),  # numbers of intervals of segments, then of the motion
    "high": ("f8", ("witnesses",), 0, 1),  # the end of each interval
    "normal": ("f4", ("witnesses", 3), -1e6, 1e6),  # of a plane in the middle, first to second; for w: 0 or not
}
FIELDS = {name: row for names, row in LAYOUT.items() for name in names.split()}


class Refused(Exception):
    """An unproven statement, as a sentence."""


def require(holds: Any, why: str) -> None:
    if not np.all(holds):
        raise Refused(why)


def check(out: Path, urdf: Path | None = None) -> str:
    """Return the proven statements about the plan in a folder, or raise :class:`Refused`."""
    require((out / "proof.npz").is_file(), f"{out / 'proof.npz'} not found: plan with --certificate to write it.")
    try:
        data, meta = read(out / "proof.npz")
        compared = "" if urdf is None else apply_urdf(data, meta, urdf)
        require_sound(data, meta)
        plan, pieces = require_same_files(data, meta, out), curves(data)
        assign_witnesses(data, meta, pieces)
        rounding, kinds = require_witnesses(data, meta, pieces), require_limits(data, meta, pieces)
        ends = f"{require_ends(data, meta, plan)}\n{describe_floor(data, meta, plan)}"
        return describe(data, meta, rounding, kinds, ends, compared)
    except Refused:
        raise
    except Exception as error:  # any error of a damaged zip, JSON or URDF
        raise Refused(f"a file is missing or damaged ({type(error).__name__}: {error}).") from error


def read(file: Path) -> tuple[Data, Data]:
    """Return the arrays of a certificate, of the right types, shapes and sizes [1], and its words."""
    with np.load(file, allow_pickle=False) as arrays:
        held, names = arrays.zip.infolist(), sorted(f"{name}.npy" for name in FIELDS)
        there = sorted(item.filename for item in held) == names and sum(item.file_size for item in held) < 1 << 30
        require(there, f"{file} must hold the arrays of format {FORMAT}: write it again.")
        data: Data = {name: arrays[name] for name in FIELDS}
    sizes: dict[int | str, int] = {}
    for name, (kind, shape, least, most) in FIELDS.items():
        array = data[name]
        require(array.dtype == np.dtype(f"<{kind}") and array.ndim == len(shape), f"{name} is of another kind.")
        for size, key in zip(array.shape, shape, strict=True):
            require(size == (key if isinstance(key, int) else sizes.setdefault(key, size)), f"{name} is short.")
        require((array >= least) & (array <= most), f"{name} holds a number that is not finite, or too large.")
    points = np.split(data["points"], np.cumsum(data["count"])[:-1])
    data["shapes"] = list(zip(points, data["radius"].tolist(), (data["cylinder"] > 0).tolist(), strict=True))
    return data, json.loads(data["meta"].tobytes(), object_pairs_hook=reject_duplicates)


def reject_duplicates(named: list[tuple[str, Any]]) -> Data:
    """Return an object of JSON; a duplicate name is refused, as readers differ in the value they take."""
    require(len(dict(named)) == len(named), "a name stands twice in a file.")
    return dict(named)


def require_sound(data: Data, meta: Data) -> None:
    """Require valid indices, unit axes [2], valid shapes and increasing times."""
    tree, dof, count = len(data["parent"]), len(data["wraps"]), data["count"]
    require(meta["format"] == FORMAT and meta.keys() == WORDS, "the certificate has another format: write it again.")
    for names, size in ((meta["joints"], dof), (meta["tree"], tree), (meta["items"], len(count))):
        require(len(names) == size == len({str(name) for name in names}), "joints and items need a name each.")
    require((data["parent"] <= np.arange(tree)) & (1 <= dof <= tree <= 100), "a joint stands before what carries it.")
    require(np.append(data["joint"], data["carrier"]) <= tree, "an item or the tool has no joint.")
    require(data["leader"] < dof, "a joint follows one that is not planned.")
    steps = (data["prismatic"] > 0) | (data["factor"] % 1.0 != 0.0)  # the joint moves in a whole turn of its leader
    require((data["wraps"][data["leader"]] == 0) | ~steps, "a joint slides and turns, or follows in parts of turns.")
    require(np.abs(np.linalg.norm(data["axis"], axis=1) - 1.0) <= 1e-13, "a joint's axis is no unit vector.")
    require(((count == 2) | (data["cylinder"] == 0)) & (count.sum() == len(data["points"])), "an item is no shape.")
    require(len(data["clock"]) != 1 and (np.diff(data["clock"]) > 0).all(), "times do not increase.")
    for name, terms in meta["clouds"].items():
        own = [k for k, item in enumerate(meta["items"]) if item.partition(", slab ")[0] == name]
        same = len(own) > 0 and (data["radius"][own] == sum(terms[key] for key in TERMS)).all()
        require(same and min(terms.values()) >= 0, f"the radius of {name!r} is not the sum of its terms.")


def require_same_files(data: Data, meta: Data, folder: Path) -> Data:
    """Return plan.json; require its path and the motion of trajectory.json, number by number."""
    plan = json.loads((folder / "plan.json").read_bytes(), object_pairs_hook=reject_duplicates)
    beside = folder / "trajectory.json"
    for key, own in (*((key, meta[key]) for key in ("robot", "scene", "joints")), ("path", data["path"].tolist())):
        require(plan[key] == own, f"plan.json is of another {key}.")
    require(data["margin"] >= plan["config"]["margin"], "plan.json asks for a larger margin.")
    require(beside.exists() == (len(data["clock"]) > 0), "trajectory.json is missing, or not certified.")
    if beside.exists():
        motion, knots = json.loads(beside.read_bytes(), object_pairs_hook=reject_duplicates), data["knots"]
        other = [[point[key] for point in motion["points"]] for key in ("t", "q", "qd", "qdd")[: len(knots) + 1]]
        other += [motion["joints"], motion["interpolation"], [motion["limits"][kind] for kind in KINDS]]
        own = [(data["clock"] / 1e9).tolist(), *knots.tolist(), meta["joints"], INTERPOLATED[len(knots) - 1]]
        same = other == [*own, data["limits"].tolist()] and not motion.get("events")
        require(same, "trajectory.json is of another motion.")
        require(np.abs(knots[0][[0, -1]] - data["path"][[0, -1]]) <= FORGIVEN, "the motion has other ends.")
    return plan


def require_ends(data: Data, meta: Data, plan: Data) -> str:
    """Require the path's ends to be those of plan.json [13]; return sentences on them."""
    config, goal, sentences = plan["config"], plan["goal"], []
    if config.get("request") is not None:
        return f"Whether its ends are those of {config['request']!r} is not judged."
    choices = re.findall(r"[^;,:]*:[^;]*|[^;,]+", str(config.get("goal")))  # numbers, or a name
    require(goal in (None, *map(str.strip, choices)), "plan.json reaches a goal that it does not ask for.")
    for end, text, q in (("start", config.get("start"), data["path"][0]), ("goal", goal, data["path"][-1])):
        texts = [text] if ":" in str(text) else meta["states"].get(text, [])
        offs = [end_error(data, q, each) for each in texts]
        require(not offs or not all(off > 1.0 for off in offs), f"the path's {end} is not {text!r}.")
        met = [each for each, off in zip(texts, offs, strict=True) if off <= 1.0]
        reached = f"Its {end} is {text!r}, {met[0]!r}." if met else f"Whether its {end} is {text!r} is not judged."
        sentences.append(reached)
    return " ".join(sentences)


def end_error(data: Data, q: Array, text: str) -> float:
    """Return the error of a configuration for joint values, a position or a pose, over its tolerance.

    It is NaN for other texts.
    """
    kind, _, rest = text.partition(":")
    if kind not in ENDS or "&" in text:
        return np.nan
    target = np.array(rest.split(","), dtype=float)
    require(len(target) == (ENDS[kind] or len(q)), f"{text!r} has too many numbers, or too few.")
    if kind == "q":
        off = q - target - data["wraps"] * 2.0 * np.pi * np.rint((q - target) / (2.0 * np.pi))
        return float(np.abs(off).max()) / SAME
    turn, origin = (each[data["carrier"], 0] for each in frames(data, q[None]))
    off = [origin + turn @ data["tool"][:3, 3] - target[:3]]
    if kind == "pose":
        x, y, z, w = target[3:] / np.linalg.norm(target[3:])
        cross = np.cross([x, y, z], np.eye(3)).T
        off += list(turn @ data["tool"][:3, :3] - np.eye(3) - 2.0 * (w * cross + cross @ cross))
    return float(np.abs(off).max()) / REACHED


# c_1, c_2 ... from the rise, the slopes and second derivatives at both ends: Hermite, as in ROS 2 controllers [3]
QUINTIC = ((0, 1, 0, 0, 0), (0, 0, 0, 0.5, 0), (10, -6, -4, -1.5, 0.5), (-15, 8, 7, 1.5, -1), (6, -3, -3, -0.5, 0.5))
HERMITE = (((1,),), ((0, 1, 0), (3, -2, -1), (-2, 1, 1)), QUINTIC)


def curves(data: Data) -> Array:
    """Return coefficients (pieces, 6, dof) of q(s) = sum of c_k s^k, s in [0, 1] [3].

    The segments of the path come first, then the polynomial pieces of the motion.
    """
    path, h, knots = data["path"], np.diff(data["clock"])[:, None] / 1e9, data["knots"]
    path = path if len(path) > 1 else np.repeat(path, 2, axis=0)
    result = np.zeros((len(path) - 1 + len(h), 6, path.shape[1]))
    result[: len(path) - 1, 0], result[: len(path) - 1, 1] = path[:-1], np.diff(path, axis=0)
    if len(h):
        result[-len(h) :, 0], ends = knots[0][:-1], [np.diff(knots[0], axis=0)]
        ends += [end * h**k for k, rows in enumerate(knots[1:], start=1) for end in (rows[:-1], rows[1:])]
        result[-len(h) :, 1 : 2 * len(knots)] = np.einsum("kc,cnd->nkd", HERMITE[len(knots) - 1], ends)
    require(np.abs(result).sum(axis=1) <= MOST, "a joint turns or slides too far.")  # [1]
    return result


def require_limits(data: Data, meta: Data, pieces: Array) -> list[str]:
    """Require positions within limits, the motion's derivatives within theirs; return the kinds of these."""
    free, off = np.where(data["wraps"] > 0, np.inf, FORGIVEN), OFF * np.abs(pieces).sum(axis=1)
    require_between(pieces, data["lower"] - free, data["upper"] + free, off, "a joint leaves its limits", meta)
    judged, h = KINDS[: len(data["knots"])], np.diff(data["clock"])[:, None] / 1e9
    slope = pieces[len(pieces) - len(h) :]
    off = OFF * np.abs(slope[:, 1:]).sum(axis=1)
    for kind, most in zip(judged, data["limits"] * (1.0 + LIMIT), strict=False):
        slope, off = slope[:, 1:] * np.arange(1, slope.shape[1])[:, None] / h[:, None], off / h
        require_between(slope, -most, most, off, f"the motion's {kind} exceeds its limit", meta)
    return judged


def require_between(pieces: Array, low: Array, high: Array, off: Array, why: str, meta: Data) -> None:
    """Require polynomials, off by ``off``, within bounds, by Bernstein coefficients of their halves [11]."""
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
    """Return rotations (..., 3, 3) about a unit vector (3,) by angles (..., 1, 1), Rodrigues' formula [4]."""
    require(np.abs(angle) <= MOST, "a joint turns too far.")
    turned: Any = np.ones_like(angle, dtype=complex)
    cross = np.cross(axis, np.eye(3)).T
    for k in range(20, 0, -1):
        turned = 1.0 + angle / (1024 * k) * 1j * turned
    for _ in range(10):
        turned = turned * turned
    return np.eye(3) + turned.imag * cross + (1.0 - turned.real) * (cross @ cross)


def frames(data: Data, q: Array) -> tuple[Array, Array]:
    """Return rotations (joints + 1, n, 3, 3) and origins (joints + 1, n, 3) at q (n, dof) [6].

    Row 0 is the base.
    """
    q = data["factor"] * q[:, data["leader"]] + data["zero"]  # now of all joints
    turn, origin = np.empty((q.shape[1] + 1, len(q), 3, 3)), np.zeros((q.shape[1] + 1, len(q), 3))
    turn[0] = np.eye(3)
    for j, (before, axis, slides) in enumerate(zip(data["parent"], data["axis"], data["prismatic"] > 0, strict=True)):
        turn[j + 1] = turn[before] @ data["turn"][j] @ rotation(axis, np.where(slides, 0.0, q[:, j, None, None]))
        origin[j + 1] = origin[before] + turn[before] @ data["shift"][j]
        origin[j + 1] += np.where(slides, q[:, j, None], 0.0) * (turn[j + 1] @ axis)
    return turn, origin


def reaches(data: Data, pieces: Array) -> tuple[Array, float]:
    """Return the largest rates (items + 1, joints) of items and tool [8], and the rounding, m.

    A rate is 0 for joints that do not carry the item.
    """
    result, joints = [*data["shapes"], (data["tool"][None, :3, 3], 0.0)], np.append(data["joint"], data["carrier"])
    most = np.abs(pieces).sum(axis=1).max(axis=0)[data["leader"]] * np.abs(data["factor"]) + np.abs(data["zero"])
    require(most <= MOST, "a joint follows another farther than any goes.")  # [1]
    travel = np.where(data["prismatic"] > 0, ROUNDED * most, 0.0)
    rates, size = np.zeros((len(result), len(travel))), 1.0
    for item, (points, radius, *_) in enumerate(result):
        joint, far = joints[item] - 1, np.linalg.norm(points, axis=1).max() + radius
        across = np.linalg.norm(np.cross(points, data["axis"][max(joint, 0)]), axis=1).max() + radius
        size = max(size, far)
        while joint >= 0:
            rates[item, joint] = 1.0 if data["prismatic"][joint] else max(across, 1e-9)
            before, shift = data["parent"][joint] - 1, data["shift"][joint]
            across = far + travel[joint] + np.linalg.norm(np.cross(shift, data["axis"][before]))
            far, joint = far + travel[joint] + np.linalg.norm(shift), before
    size += np.linalg.norm(data["shift"], axis=1).sum() + travel.sum()
    require(np.linalg.det(data["turn"]) > 0.0, "a joint's frame is no rotation.")
    stretched = np.abs(data["turn"].transpose(0, 2, 1) @ data["turn"] - np.eye(3)).max()  # [2]
    return rates, float((TURNED + 8.0 * stretched) * (len(travel) + 1) * size)  # [10]


def farthest(shape: Shape, direction: Array) -> Array:
    """Return (n,) the support of a shape in unit directions (n, 3) of its frame [9]."""
    points, radius, cylinder = shape
    reached = (direction @ points.T).max(axis=1)
    if not cylinder:
        return reached + radius
    along, length = points[1] - points[0], np.linalg.norm(points[1] - points[0])
    require(length > 1e-9, "a cylinder is too short to have an axis.")
    return reached + radius * np.linalg.norm(np.cross(direction, along / length), axis=1)


def assign_witnesses(data: Data, meta: Data, pieces: Array) -> None:
    """Set the proven pairs, and the pair, or w, and the interval of each witness."""
    joint, parts, high, names = data["joint"], data["parts"], data["high"], meta["items"]
    pairs = np.argwhere(np.triu((joint[:, None] != joint) & (np.maximum(joint[:, None], joint) > 0)))
    require(len(pairs) == len(data["left"]), "not every pair is proven apart or left out.")
    for a, b in pairs[data["left"] == OPEN]:
        raise Refused(f"{names[a]!r} and {names[b]!r} are not proven apart: are their hulls too close?")
    data["pairs"], data["exempt"] = pairs[data["left"] == PROVEN], pairs[data["left"] == EXEMPT]
    require(len(data["pairs"]) > 0, f"no pair of bodies is proven apart, {len(data['exempt'])} are left out.")
    require(parts.shape == (len(data["pairs"]) + 1, len(pieces)) and parts.sum() == len(high), "parts are missing.")
    data["pair"], data["piece"] = np.divmod(np.repeat(np.arange(parts.size), parts.ravel()), len(pieces))
    first = np.cumsum(parts) - parts.ravel()
    data["low"] = np.append(0.0, high[:-1])  # a part begins where the one before it ends
    data["low"][first] = 0.0
    require((data["low"] < high) & (high[first - 1] == 1.0).all(), "a piece is not covered from 0 to 1.")


def describe_floor(data: Data, meta: Data, plan: Data) -> str:
    """Return a sentence on where w is shown to exceed the floor, and on the requested floor."""
    of_w, request = data["pair"] == len(data["pairs"]), float(plan["config"].get("min_manipulability", 0.0))
    low, high, piece, shown = (data[name][of_w] for name in ("low", "high", "piece", "normal"))
    gaps = [f"{low[k]} to {high[k]} of piece {piece[k]}" for k in np.flatnonzero(~shown.any(axis=1))]
    where = "no piece" if not shown.any() else f"every piece but for {', '.join(gaps)}" if gaps else "every piece"
    shown_floor = f"Of w ({meta['rows']}) of {meta['tool link']!r} at least {data['floor']} is shown on {where}"
    return f"{shown_floor}; plan.json asks for {request}{'' if request <= data['floor'] else ', which is more'}."


def require_witnesses(data: Data, meta: Data, pieces: Array) -> float:
    """Require each witness; return the distance lost to rounding, m."""
    reach, spare = reaches(data, pieces)
    require(spare <= 1e-5, "the numbers are too large for their rounding.")
    for rows in np.array_split(np.arange(len(data["piece"])), len(data["piece"]) // 20_000 + 1):
        of_pairs = data["pair"][rows] < len(data["pairs"])
        planes, floor = rows[of_pairs], rows[~of_pairs & data["normal"][rows].any(axis=1)]
        apart, need = gaps_and_motions(data, pieces, reach, planes)
        for k in planes[~(apart > data["margin"] + ROUNDED * need + spare)]:  # [10]
            a, b = data["pairs"][data["pair"][k]]
            raise Refused(f"witness {k} does not show {meta['items'][a]!r} and {meta['items'][b]!r} apart.")
        for k in floor[~(least_w(data, pieces, reach[-1], spare, ROWS[meta["rows"]], floor) >= data["floor"])]:  # [12]
            raise Refused(f"witness {k} does not show that w keeps its floor.")
    return spare


def middles(data: Data, pieces: Array, rows: Array) -> tuple[Array, Array]:
    """Return configurations (n, dof) in interval middles, and the motions (n, joints) from there [7]."""
    low, high, c = data["low"][rows], data["high"][rows], pieces[data["piece"][rows]]
    middle, off = 0.5 * (low + high), OFF * np.abs(c).sum(axis=1)
    half = np.maximum(high - middle, middle - low)
    for k in range(5):  # Taylor's expansion at the middle, by Horner's scheme once a power
        for j in range(4, k - 1, -1):
            c[:, j] += middle[:, None] * c[:, j + 1]
    moved = off + sum(np.abs(c[:, k]) * half[:, None] ** k for k in range(1, 6))
    return c[:, 0], np.abs(data["factor"]) * moved[:, data["leader"]]


def gaps_and_motions(data: Data, pieces: Array, reach: Array, rows: Array) -> tuple[Array, Array]:
    """Return (n,) the gaps between the planes in interval middles [9], and the motions from there [7], m."""
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
    """Return (n,) a lower bound on w of the tool Jacobian's first rows on the intervals of witnesses [12]."""
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


def apply_urdf(data: Data, meta: Data, file: Path) -> str:
    """Replace the certificate's joints, tool and shapes by the URDF's; return a sentence on the rest."""
    root: Any = ET.parse(file).getroot()
    joints, unread = {joint.get("name"): joint for joint in root.findall("joint")}, list[str]()
    links = {joint.find("child").get("link"): joint for joint in joints.values()}
    led = {name: resolve_mimic(joints, name) for name in joints}
    moved = data["moved"] = {name for name, (leader, factor, _) in led.items() if leader in meta["joints"] and factor}
    for k, name in enumerate(meta["tree"]):
        own = led.get(name, [""])[0] == name if name in meta["joints"] else name in moved
        require(own and joints[name].get("type") in MOVING, f"joint '{name}' does not move by itself in {file}.")
        joint, (leader, factor, zero) = joints[name], led[name]
        kind, limit, row = joint.get("type"), joint.find("limit"), meta["joints"].index(leader)
        data["leader"][k], data["factor"][k], data["zero"][k] = row, factor, zero
        data["parent"][k], at = locate_link(data, meta, links, joint.find("parent").get("link"))
        at = at @ origin_in(joint)
        data["turn"][k], data["shift"][k], data["axis"][k] = at[:3, :3], at[:3, 3], axis_of(joint)
        data["prismatic"][k], data["wraps"][row] = kind == "prismatic", data["wraps"][row] and kind == "continuous"
        most = sum(float(each.get("velocity", "0")) for each in joint.findall("limit")[:1])  # 0: unknown
        fast = data["limits"][:1, row] * abs(factor)
        require(most <= 0 or fast <= most * (1 + LIMIT), f"'{name}' may not be that fast in {file}.")
        if kind != "continuous" and not meta["widened"]:
            low, high = sorted((float(limit.get(side, "0")) - zero) / factor for side in ("lower", "upper"))
            data["lower"][row], data["upper"][row] = max(data["lower"][row], low), min(data["upper"][row], high)
    for link in root.findall("link"):
        for k, element in enumerate(link.iter("collision")):
            name, geometry = f"{link.get('name')}_{k}", element.find("geometry")[0]
            joint, at = locate_link(data, meta, links, link.get("name"))
            named = [n for n, body in enumerate(meta["items"]) if f"{body}, ".startswith(f"{name}, ")]
            here = [
                n for n in named if data["joint"][n] == joint and (geometry.tag == "mesh" or meta["items"][n] == name)
            ]
            require(len(here) > 0, f"'{name}' hangs on another joint in {file}, or is no body of the certificate.")
            cut = meta["items"][here[0]] != name  # into pieces or slabs: not compared
            unread += [repr(name)] * ((shape := None if cut else shape_in(geometry, file)) is None)
            if shape is not None:
                require(shape[1] >= 0.0, f"'{name}' has no shape in {file}.")
                at = at @ origin_in(element)
                data["shapes"][here[0]] = shape[0] @ at[:3, :3].T + at[:3, 3], *shape[1:]
    if own := root.find(f"link[@name='{meta['tool link']}']") is not None:
        data["carrier"], data["tool"] = locate_link(data, meta, links, meta["tool link"])
    but = f" but for {len(unread)} meshes not found, cut or of another kind: {', '.join(unread)}" if unread else ""
    return f"Joints and shapes are those of {file.name}{but}{'' if own else '; the tool is not in there'}."


def resolve_mimic(joints: Data, name: str) -> tuple[str, float, float]:
    """Return the joint that leads ``name`` through all <mimic>, and its factor and zero."""
    factor, zero = 1.0, 0.0
    for _ in joints:
        if (mimic := joints[name].find("mimic")) is None:
            break
        zero += factor * float(mimic.get("offset", "0"))
        factor, name = factor * float(mimic.get("multiplier", "1")), mimic.get("joint")
    return name, factor, zero


def locate_link(data: Data, meta: Data, links: Data, link: str) -> tuple[int, Array]:
    """Return the number of the joint that carries a link, 0 the base, and the link's frame in it (4, 4)."""
    if link not in links:
        return 0, data["base"]
    joint, held = links[link], np.eye(4)
    name, kind, value = joint.get("name"), joint.get("type"), float(meta["held"].get(joint.get("name"), 0.0))
    if name in meta["tree"]:
        return meta["tree"].index(name) + 1, held
    require(kind == "fixed" or (kind in MOVING and name not in data["moved"]), f"'{name}' moves, not planned.")
    held[:3, 3] = value * (kind == "prismatic") * axis_of(joint)
    held[:3, :3] = rotation(axis_of(joint), value * (kind in MOVING[:2]))
    number, at = locate_link(data, meta, links, joint.find("parent").get("link"))
    return number, at @ origin_in(joint) @ held


def read_vector(element: Any, key: str, otherwise: str = "0 0 0") -> Array:
    return np.array((otherwise if element is None else element.get(key, otherwise)).split(), dtype=float)


def axis_of(joint: Any) -> Array:
    return (axis := read_vector(joint.find("axis"), "xyz", "1 0 0")) / max(np.linalg.norm(axis), 1e-300)


def origin_in(element: Any) -> Array:
    """Return the origin (4, 4) of a joint or shape: turns about x, y and z in this order, then a shift."""
    pose = np.eye(4)
    for axis, angle in zip(np.eye(3), read_vector(element.find("origin"), "rpy"), strict=True):
        pose[:3, :3] = rotation(axis, angle) @ pose[:3, :3]
    pose[:3, 3] = read_vector(element.find("origin"), "xyz")
    return pose


def shape_in(shape: Any, file: Path) -> Shape | None:
    """Return a shape of the URDF in its own frame; None for an unreadable mesh."""
    if shape.tag == "box":
        return (np.indices((2, 2, 2)).reshape(3, 8).T - 0.5) * read_vector(shape, "size"), 0.0, False
    if shape.tag in ("sphere", "cylinder", "capsule"):
        ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * float(shape.get("length", "0"))
        return ends, float(shape.get("radius")), shape.tag == "cylinder"
    name = shape.get("filename", "").rpartition("://")[2].lstrip("/")
    for mesh in (folder / name for folder in file.resolve().parents if (folder / name).is_file()):
        kind, content = mesh.suffix.lower(), mesh.read_bytes()
        if kind == ".stl" and len(content) == 84 + 50 * int.from_bytes(content[80:84], "little"):
            points = np.frombuffer(content[84:], dtype="(4,3)<f4,<u2")["f0"][:, 1:].reshape(-1, 3)
        else:  # as text, in which lines may end anywhere
            mark = "none" if b"\0" in content else {".stl": "vertex", ".obj": "v"}.get(kind, "none")
            points = re.findall(rf"(?i)\b{mark}\s+(\S+)\s+(\S+)\s+(\S+)", content.decode(errors="replace"))
        if len(points):
            return np.unique(np.array(points, dtype=float), axis=0) * read_vector(shape, "scale", "1 1 1"), 0.0, False
    return None


def describe(data: Data, meta: Data, rounding: float, judged: list[str], ends: str, urdf: str) -> str:
    """Return the verdict: the proven statements, and the statements that are only quoted."""
    by_scene, bodies = data["joint"][data["exempt"]].min(axis=1, initial=0) < 0, meta["items"]
    exempt = [f"{bodies[a]!r} and {bodies[b]!r}" for a, b in data["exempt"][np.argsort(by_scene, kind="stable")]]
    quoted = [f"the pose of the base {data['base'].tolist()}", "the hashes of robot and scene"]
    quoted += ["limits on position that are not those of the robot's files"] * bool(meta["widened"])
    quoted += [f"joint {name!r} held at {value!r}" for name, value in meta["held"].items()]
    quoted += [f"mesh {name!r} cut into {count!r} slabs" for name, count in meta["cuts"].items()]
    quoted += [f"the radius of {name!r} as a sum of {terms!r}" for name, terms in meta["clouds"].items()]
    quoted += [f"obstacle {name!r}" for name, joint in zip(bodies, data["joint"], strict=True) if joint < 0]
    quoted += [f"state {name!r}" for name in meta["states"]]
    motion = f" and of the motion of {np.ptp(data['clock']) / 1e9:g} s" if judged else ""
    return (
        f"Proven: along all of the path of {len(data['path'])} waypoints from "
        f"{' to '.join(map(str, data['path'][[0, -1]].tolist()))}{motion}, {meta['robot']!r} in {meta['scene']!r} "
        f"keeps its limits on position{', those of trajectory.json on ' * bool(judged)}{', '.join(judged)}, to "
        f"{FORGIVEN:g}, and each of {len(data['pairs'])} pairs of bodies stays farther apart than {data['margin']} m "
        f"(by {len(data['high'])} witnesses, {rounding:.0e} m for rounding).\n{ends}\nLeft out: pairs that no joint "
        "moves against each other.\nSaid to be left out, by files that are not read here: "
        f"{(~by_scene).sum()} pairs that the robot's files list and {by_scene.sum()} that the scene allows: "
        f"{', '.join(exempt) or 'none'}.\n"
        f"{urdf or 'The robot is as the certificate has it, without a URDF.'}\nNot read here, so as the certificate "
        f"says: {', '.join(quoted)}.\nNothing is proven of obstacles that move, of the "
        "model and its calibration, of the controller, and of conditions and tubes to be kept."
    )


if __name__ == "__main__":
    reader = argparse.ArgumentParser(description="Check the certificate of a plan.")
    reader.add_argument("out", type=Path, help="the folder with plan.json and proof.npz")
    reader.add_argument("--urdf", type=Path, help="the robot's URDF, whose frames and shapes then count")
    try:
        print(check(**vars(reader.parse_args())))
    except Refused as why:
        sys.exit(f"NOT proven: {why}")
