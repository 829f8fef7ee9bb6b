#!/usr/bin/env python3
"""Checks the certificate of a plan without its planner: this file needs Python and numpy, nothing else.

    python verify_proof.py OUT [--urdf ROBOT.urdf]

OUT is what `planner plan --certificate` wrote. Exit code 0 and what is proven and what is not, else 1 and why not.
Each inequality, as [5], holds in real arithmetic, whoever wrote the numbers: docs/explanation/certificate.md has them.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray
Data = dict[str, np.ndarray]
Words = dict[str, Any]
FORMAT, MOST = 1, 1000.0  # rad, m, also velocities times seconds and so on: larger numbers are refused [1]
TURNED, FRAME = 1e-11, 1e-6  # what a joint's rotation is off at most, computed [6]; the frames that are read [2]
ANGLE = 1e-12  # of the size of a joint's numbers: what its value is off at most, computed [5]
ROUNDED = 1.0 + 1e-12  # what sums of products of non-negative numbers are too small by at most [7]
SLOPE = 1e-11  # of the size of a piece, over its time to the order: what a derivative is off at most, computed [11]
LIMIT = FORGIVEN = 1e-6  # relative, of limits on the motion, and rad or m, on positions: what may be exceeded
MEETS, LISTED, ALLOWED, OPEN = range(4)  # why a pair is not proven apart; the last is no reason
MOVING = ("revolute", "continuous", "prismatic")
KINDS, INTERPOLATED = ["velocity", "acceleration", "jerk"], ["lines", "cubics", "quintics"]
# what the file holds: names, the kind of number, and the shape, in which each name stands for one number throughout
LAYOUT: list[tuple[str, str, tuple[int | str, ...]]] = [
    ("meta", "u1", ("bytes",)),  # JSON
    ("parent", "i8", ("dof",)),  # of each joint: the number of the joint before it, counted from 1; 0 the base
    ("prismatic wraps", "u1", ("dof",)),  # joints that slide, joints without limits
    ("turn", "f8", ("dof", 3, 3)),  # a joint's frame in the frame of that joint: rotation and origin
    ("shift axis", "f8", ("dof", 3)),
    ("lower upper", "f8", ("dof",)),
    ("joint count", "i8", ("items",)),  # what carries a body, 0 the base, -1 the world; how many points are its own
    ("cylinder", "u1", ("items",)),  # else the convex hull of points, with a radius around it
    ("radius", "f8", ("items",)),
    ("points", "f8", ("points", 3)),  # in the frame of the joint, item by item; of a cylinder the middles of its discs
    ("pairs", "i8", ("pairs", 2)),  # of items that are proven apart
    ("exempt", "i8", ("exempt", 2)),  # of items that are not
    ("reason", "u1", ("exempt",)),
    ("path", "f8", ("waypoints", "dof")),
    ("clock", "i8", ("knots",)),  # ns
    ("knots", "f8", ("columns", "knots", "dof")),  # positions, perhaps velocities, perhaps accelerations
    ("limits", "f8", ("kinds", "dof")),  # on velocity, acceleration, jerk
    ("piece pair", "i4", ("witnesses",)),  # segments of the path first, then pieces of the motion
    ("low high", "f8", ("witnesses",)),  # the interval of the piece that a witness speaks of
    ("normal", "f4", ("witnesses", 3)),  # of a plane between the pair in the interval's middle, first to second
]
FIELDS = {name: (kind, shape) for names, kind, shape in LAYOUT for name in names.split()}


class Refused(Exception):
    """What is not proven, as a sentence."""


def require(holds: Any, why: str) -> None:
    if not np.all(holds):
        raise Refused(why)


def main() -> None:
    """Read the command line; exit with 1 and the reason where the plan is not proven."""
    reader = argparse.ArgumentParser(description="Check the certificate of a plan.")
    reader.add_argument("out", type=Path, help="the folder with plan.json and proof.npz")
    reader.add_argument("--urdf", type=Path, help="the robot's URDF, whose frames and shapes then count")
    try:
        print(check(**vars(reader.parse_args())))
    except Refused as why:
        sys.exit(f"NOT proven: {why}")


def check(out: Path, urdf: Path | None = None) -> str:
    """What is proven of the plan in a folder, as a sentence; :class:`Refused` where something is not."""
    try:
        data, meta = read(out / "proof.npz")
        require_sound(data, meta)
        compared = "" if urdf is None else take_urdf(data, meta, urdf)
        require_same_files(data, meta, out)
        require_every_pair(data, meta)
        pieces = curves(data)
        require_covered(data, meta, len(pieces))
        rounding = require_witnesses(data, meta, pieces)
        return sentence(data, meta, rounding, require_limits(data, meta, pieces), compared)
    except Refused:
        raise
    except Exception as error:  # whatever a damaged zip, JSON or URDF ends in
        raise Refused(f"a file is missing or damaged ({type(error).__name__}: {error}).") from error


def read(file: Path) -> tuple[Data, Words]:
    """The arrays of a certificate, of the right kinds and shapes, finite, and what it says in words."""
    with zipfile.ZipFile(file) as archive:
        names, size = archive.namelist(), sum(item.file_size for item in archive.infolist())
    require(sorted(names) == sorted(f"{name}.npy" for name in FIELDS) and size < 1 << 30, f"{file} holds other arrays.")
    with np.load(file, allow_pickle=False) as arrays:
        data = {name: arrays[name] for name in FIELDS}
    sizes: dict[str, int] = {}
    for (name, array), (kind, shape) in zip(data.items(), FIELDS.values(), strict=True):
        require(array.dtype == np.dtype(f"<{kind}") and array.ndim == len(shape), f"{name} is of another kind.")
        for size, said in zip(array.shape, shape, strict=True):
            require(size == (said if isinstance(said, int) else sizes.setdefault(said, size)), f"{name} is short.")
        require(np.isfinite(array), f"{name} holds what is no finite number.")
    return data, json.loads(data["meta"].tobytes(), object_pairs_hook=once)


def once(named: list[tuple[str, Any]]) -> Words:
    """An object of JSON; refused where a name stands twice, of which readers take one or the other."""
    require(len(dict(named)) == len(named), "a name stands twice in a file.")
    return dict(named)


def require_sound(data: Data, meta: Words) -> None:
    """Indices point at what is there, sizes are sane [1], frames turn and do not stretch [2]."""
    dof, items, points = len(data["parent"]), len(data["joint"]), len(data["points"])
    require(meta["format"] == FORMAT, "the certificate is of another format.")
    for names, size in ((meta["joints"], dof), (meta["items"], items)):
        require(len(names) == size == len({str(name) for name in names}), "joints and items need a name each.")
    require(isinstance(meta["margin"], float) and 0.0 <= meta["margin"] <= MOST, "the margin is no distance.")
    require(1 <= dof <= 100, "no robot has so many joints.")
    require((data["parent"] >= 0) & (data["parent"] <= np.arange(dof)), "a joint stands before what carries it.")
    require((data["joint"] >= -1) & (data["joint"] <= dof), "an item hangs on no joint.")
    count = data["count"]
    require((count >= 1) & (count <= points) & (count.sum() == points), "the points are not those of the items.")
    require(((count == 2) | (data["cylinder"] == 0)) & (data["radius"] >= 0), "an item is no shape.")
    for name in ("points", "shift", "path", "radius", "knots"):
        require(np.abs(data[name]) <= (1e6 if name == "knots" else 1.0) * MOST, f"{name} holds an absurd number.")
    require(stretched(data) <= FRAME and (np.linalg.det(data["turn"]) > 0).all(), "a joint's frame is no rotation.")
    require(np.abs(np.linalg.norm(data["axis"], axis=1) - 1.0) <= 1e-13, "a joint's axis is no unit vector.")  # [2]
    knots, columns = len(data["clock"]), len(data["knots"])
    same = len(data["path"]) > 0 and (knots != 1 and 1 <= columns <= 3 if knots else columns == 0)
    require(same and len(data["limits"]) == 3 * (knots > 0), "path or motion have no points, or no limits.")
    require((np.diff(data["clock"]) > 0).all() and (np.abs(data["clock"] / 1e9) < 2e6).all(), "time does not go on.")


def stretched(data: Data) -> float:
    """By how much the joints' frames are no rotations [2]."""
    return float(np.abs(data["turn"].transpose(0, 2, 1) @ data["turn"] - np.eye(3)).max())


def require_same_files(data: Data, meta: Words, folder: Path) -> None:
    """The path is that of plan.json, the motion that of trajectory.json, number by number."""
    plan, beside = (folder / name for name in ("plan.json", "trajectory.json"))
    plan = json.loads(plan.read_bytes(), object_pairs_hook=once)
    for key in ("robot", "scene", "joints"):
        require(plan[key] == meta[key], f"plan.json is of another {key}.")
    require(np.array_equal(np.array(plan["path"], dtype=float), data["path"]), "the path in plan.json is another one.")
    require(meta["margin"] >= plan["config"]["margin"], "plan.json asks for a larger margin.")
    require(beside.exists() == bool(len(data["clock"])), "trajectory.json is missing, or not certified.")
    if not beside.exists():
        return
    motion, columns = json.loads(beside.read_bytes(), object_pairs_hook=once), len(data["knots"])
    same = [motion["joints"], motion["interpolation"]] == [meta["joints"], INTERPOLATED[columns - 1]]
    times, *rows = ([point[key] for point in motion["points"]] for key in ("t", "q", "qd", "qdd")[: columns + 1])
    limits = [motion["limits"][kind] for kind in KINDS]
    for said, meant in ((times, data["clock"] / 1e9), (rows, data["knots"]), (limits, data["limits"])):
        same &= np.array_equal(np.array(said, dtype=float), meant)
    require(same, "the motion in trajectory.json is another one.")
    ends = np.abs(data["knots"][0][[0, -1]] - data["path"][[0, -1]])
    require(ends <= FORGIVEN, "the motion has other ends than the path.")


def require_every_pair(data: Data, meta: Words) -> None:
    """Each body with each other item is in one list, once; none is left out but for a reason."""
    joint = data["joint"]
    listed = np.sort(np.concatenate([data["pairs"], data["exempt"]]), axis=1)
    every = np.argwhere(np.triu(np.maximum(joint[:, None], joint[None, :]) >= 0, 1))
    require(np.array_equal(listed[np.lexsort(listed.T[::-1])], every), "not every pair is proven or left out, once.")
    first, second = joint[data["exempt"]].T
    rigid, own = (first == second) | (np.maximum(first, second) <= 0), np.minimum(first, second) >= 0
    may = np.select([data["reason"] == reason for reason in (MEETS, LISTED, ALLOWED)], [rigid, own, ~own], False)
    for pair in data["exempt"][~may]:
        raise Refused(f"{named(meta, pair)} are not proven apart, and nothing says why: are their hulls too close?")


def named(meta: Words, pair: Array) -> str:
    return " and ".join(repr(meta["items"][k]) for k in pair)


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


def require_limits(data: Data, meta: Words, pieces: Array) -> list[str]:
    """Positions within the robot's limits, the motion's derivatives within its own; which these are."""
    free = np.where(data["wraps"] > 0, np.inf, FORGIVEN)
    low, high = data["lower"] - free, data["upper"] + free
    require_between(pieces, low, high, np.zeros_like(pieces[:, 0]), "a joint leaves its limits", meta)
    if not len(data["clock"]):
        return []
    knots, h = data["knots"], np.diff(data["clock"])[:, None] / 1e9
    size = np.abs(np.diff(knots[0], axis=0))
    size += sum(np.maximum(np.abs(rows[1:]), np.abs(rows[:-1])) * h**k for k, rows in enumerate(knots[1:], start=1))
    slope, judged = pieces[-len(h) :], KINDS[: len(knots)]
    for order, (kind, most) in enumerate(zip(judged, data["limits"] * (1.0 + LIMIT), strict=False), start=1):
        slope = slope[:, 1:] * np.arange(1, slope.shape[1])[:, None] / h[:, None]
        require_between(slope, -most, most, SLOPE * size / h**order, f"the motion's {kind} exceeds its limit", meta)
    return judged


def require_between(pieces: Array, low: Array, high: Array, off: Array, why: str, meta: Words) -> None:
    """Polynomials, off by ``off`` as computed, stay within bounds: so do Bernstein coefficients of their parts [11]."""
    degree = pieces.shape[1] - 1
    choose = np.array([[math.comb(j, k) for k in range(degree + 1)] for j in range(degree + 1)], dtype=float)
    piece, joint = (grid.ravel() for grid in np.indices((len(pieces), pieces.shape[2])))
    control = np.einsum("jk,nkd->ndj", choose / choose[-1], pieces).reshape(-1, degree + 1)
    half = choose / 2.0 ** np.arange(degree + 1)[:, None]  # de Casteljau: of a whole piece to its first half
    for _ in range(40):
        spare = 1e-13 * np.abs(control).max(axis=1, initial=0.0) + off[piece, joint]  # these sums too are rounded
        beyond = np.maximum(control - high[joint, None], low[joint, None] - control) + spare[:, None]
        open_ = beyond.max(axis=1, initial=-np.inf) > 0.0
        if not open_.any():
            return
        piece, joint, control = np.tile(piece[open_], 2), np.tile(joint[open_], 2), control[open_]
        if beyond[open_][:, [0, -1]].max() > 0.0 or len(control) > 1_000_000:  # its ends are values themselves
            break
        control = np.concatenate([control @ half.T, control[:, ::-1] @ half.T])
    raise Refused(f"{why}: joint {meta['joints'][joint[0]]} on piece {piece[0]}.")


# pi / 2 in three parts, of which the first two have 40 bits: their products with whole numbers up to 2^13 are exact [4]
HALF_TURNS = [float.fromhex(part) for part in ("0x1.921fb54442p+0", "0x1.a308d31318p-41", "0x1.8a2e03707344ap-81")]
SINE, COSINE = ([(-1) ** k / math.factorial(2 * k + odd) for k in range(10)] for odd in (1, 0))


def sine_and_cosine(q: Array) -> tuple[Array, Array]:
    """Of angles up to 1000 rad, each within 2e-15: nothing rests on the machine's library [4]."""
    turns = np.rint(q * (2.0 / math.pi))
    rest = q
    for part in HALF_TURNS:
        rest = rest - turns * part
    square = rest * rest
    sine, cosine = np.full_like(rest, SINE[-1]), np.full_like(rest, COSINE[-1])
    for a, b in zip(SINE[-2::-1], COSINE[-2::-1], strict=True):
        sine, cosine = sine * square + a, cosine * square + b
    sine, quarter = rest * sine, turns.astype(np.int64) % 4
    swapped = quarter % 2 == 1
    s, c = np.where(swapped, cosine, sine), np.where(swapped, sine, cosine)
    return np.where(quarter >= 2, -s, s), np.where((quarter == 1) | (quarter == 2), -c, c)


def rotation(axis: Array, sine: Any, cosine: Any) -> Array:
    """(..., 3, 3) about a unit vector (3,), by sines and cosines (..., 1, 1): Rodrigues' formula."""
    cross = np.cross(axis, np.eye(3)).T
    return np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)


def frames(data: Data, q: Array) -> tuple[Array, Array]:
    """Rotations (dof + 1, n, 3, 3) and origins (dof + 1, n, 3) of the base and all joints in configurations [6]."""
    n, dof = q.shape
    turn, origin = np.empty((dof + 1, n, 3, 3)), np.zeros((dof + 1, n, 3))
    turn[0] = np.eye(3)
    for j in range(dof):
        before, axis = int(data["parent"][j]), data["axis"][j]
        turn[j + 1] = turn[before] @ data["turn"][j]
        origin[j + 1] = origin[before] + turn[before] @ data["shift"][j]
        if data["prismatic"][j]:
            origin[j + 1] += q[:, j, None] * (turn[j + 1] @ axis)
        else:
            sine, cosine = sine_and_cosine(q[:, j, None, None])
            turn[j + 1] = turn[j + 1] @ rotation(axis, sine, cosine)
    return turn, origin


def reaches(data: Data, travel: Array) -> tuple[Array, float]:
    """(items, dof) how fast a joint moves an item's points at most [8], 0 where it does not carry it; and sizes, m."""
    found, size = np.zeros((len(data["joint"]), len(travel))), 0.0
    for item, (points, radius) in enumerate(shapes(data)):
        far, joint = float(np.linalg.norm(points, axis=1).max()) + radius, int(data["joint"][item]) - 1
        size = max(size, far)
        across = float(np.linalg.norm(np.cross(points, data["axis"][max(joint, 0)]), axis=1).max()) + radius
        while joint >= 0:
            found[item, joint] = 1.0 if data["prismatic"][joint] else max(across, 1e-9)
            far += travel[joint] if data["prismatic"][joint] else 0.0
            before, shift = int(data["parent"][joint]) - 1, data["shift"][joint]
            across = far + float(np.linalg.norm(np.cross(shift, data["axis"][before])))
            far, joint = far + float(np.linalg.norm(shift)), before
    return found, size + float(np.linalg.norm(data["shift"], axis=1).sum() + travel[data["prismatic"] > 0].sum())


def shapes(data: Data) -> list[tuple[Array, float]]:
    """The points (k, 3) and the radius of every item."""
    return list(zip(np.split(data["points"], np.cumsum(data["count"])[:-1]), data["radius"].tolist(), strict=True))


def farthest(data: Data, item: int, direction: Array) -> Array:
    """(n,) how far an item goes in unit directions (n, 3) of its frame [9]."""
    points, radius = shapes(data)[item]
    reached = (direction @ points.T).max(axis=1)
    if not data["cylinder"][item]:
        return reached + radius
    along = points[1] - points[0]
    require(np.linalg.norm(along) > 1e-9, "a cylinder is too short to have an axis.")  # [9]
    return reached + radius * np.linalg.norm(np.cross(direction, along / np.linalg.norm(along)), axis=1)


def require_covered(data: Data, meta: Words, pieces: int) -> None:
    """The intervals of each pair on each piece overlap one another from 0 to 1."""
    piece, pair, low, high = (data[name] for name in ("piece", "pair", "low", "high"))
    pairs = len(data["pairs"])
    require((piece >= 0) & (piece < pieces) & (pair >= 0) & (pair < pairs), "a witness is of no piece or no pair.")
    require((low >= 0.0) & (low < high) & (high <= 1.0), "a witness has no interval.")
    group = piece.astype(np.int64) * pairs + pair
    order = np.lexsort((low, group))
    group, low, high = group[order], low[order], high[order]
    require(np.array_equal(np.unique(group), np.arange(pieces * pairs)), "a pair has no witness on some piece.")
    fresh = np.diff(group, prepend=-1) > 0
    bad = np.where(fresh, low != 0.0, low > np.roll(high, 1)) | (np.roll(fresh, -1) & (high != 1.0))
    if bad.any():
        k, p = divmod(int(group[bad][0]), pairs)
        raise Refused(f"{named(meta, data['pairs'][p])} are not covered on all of piece {k}.")


def require_witnesses(data: Data, meta: Words, pieces: Array) -> float:
    """Each witness holds: the pair is farther apart in the middle than it moves from there; what rounding took, m."""
    relative, spare = speeds(data, pieces)
    require(spare <= 1e-5, "the numbers are too large for their rounding.")
    for begin in range(0, len(data["piece"]), 20_000):
        rows = slice(begin, begin + 20_000)
        apart, need = gaps_and_motions(data, pieces, relative, rows)
        bad = np.flatnonzero(~(apart > meta["margin"] + ROUNDED * need + spare[data["pair"][rows]]))  # [10]
        for k in begin + bad:
            raise Refused(f"witness {k} does not show that {named(meta, data['pairs'][data['pair'][k]])} stay apart.")
    return float(spare.max(initial=0.0))


def speeds(data: Data, pieces: Array) -> tuple[Array, Array]:
    """(pairs, dof) how fast joints change a pair's distance at most [8]; (pairs,) what rounding takes of it, m [10]."""
    off, longest = np.abs(data["path"]).max(axis=0), np.diff(data["clock"]).max(initial=10**9) / 1e9
    off = ANGLE * (off + sum(np.abs(rows).max(axis=0) * longest**k for k, rows in enumerate(data["knots"])))  # [5]
    reach, size = reaches(data, np.abs(pieces).sum(axis=1).max(axis=0))
    first, second = reach[data["pairs"].T]
    relative = np.where((first > 0) & (second > 0), 0.0, first + second)  # joints that carry both do not count
    return relative, (TURNED + 8.0 * stretched(data)) * (len(off) + 1) * size + ROUNDED * (relative @ off)


def gaps_and_motions(data: Data, pieces: Array, relative: Array, rows: slice) -> tuple[Array, Array]:
    """(n,) each: the width between the planes in the middles of the intervals [9], the motion from there [7], m."""
    low, high, pair = data["low"][rows], data["high"][rows], data["pair"][rows]
    middle = 0.5 * (low + high)
    half = np.maximum(high - middle, middle - low)
    c = pieces[data["piece"][rows]]
    for k in range(5):  # Taylor's expansion at the middle, by Horner's scheme once a power
        for j in range(4, k - 1, -1):
            c[:, j] += middle[:, None] * c[:, j + 1]
    moved = sum(np.abs(c[:, k]) * half[:, None] ** k for k in range(1, 6))
    normal = data["normal"][rows].astype(float)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    require((length > 1e-6) & (length < 1e6), "a plane has no normal.")
    normal /= length
    turn, origin = frames(data, c[:, 0])
    apart = np.zeros(len(pair))
    for sign, items in zip((1.0, -1.0), data["pairs"][pair].T, strict=True):
        for item in np.unique(items):
            mine = np.flatnonzero(items == item)
            joint, direction = max(int(data["joint"][item]), 0), sign * normal[mine]
            local = (direction[:, None, :] @ turn[joint][mine])[:, 0]
            apart[mine] -= farthest(data, int(item), local) + np.einsum("ni,ni->n", direction, origin[joint][mine])
    return apart, np.einsum("nd,nd->n", moved, relative[pair])


def take_urdf(data: Data, meta: Words, file: Path) -> str:
    """Joints as the URDF has them, else refused; its frames and shapes take the place of those in the certificate."""
    root: Any = ET.parse(file).getroot()
    joints = root.findall("joint")
    above, meta["moved"] = {joint.find("child").get("link"): joint for joint in joints}, set(meta["joints"])
    for joint in joints * len(joints):  # what mimics a planned joint moves too, and what mimics that
        leaders = {mimic.get("joint") for mimic in joint.findall("mimic")}
        meta["moved"] |= {joint.get("name")} if leaders & meta["moved"] else set()
    for k, name in enumerate(meta["joints"]):
        joint = next(joint for joint in joints if joint.get("name") == name)
        kind, limit = joint.get("type"), joint.find("limit")
        before, at = place(meta, above, joint.find("parent").get("link"))
        at = at @ origin_in(joint)
        same = before == data["parent"][k] and (kind == "prismatic") == bool(data["prismatic"][k])
        same &= kind in MOVING and joint.find("mimic") is None and (kind == "continuous") == bool(data["wraps"][k])
        for key, part in (("turn", at[:3, :3]), ("shift", at[:3, 3]), ("axis", axis_of(joint))):
            same &= np.abs(part - data[key][k]).max() <= 1e-9
            data[key][k] = part
        if kind != "continuous" and not meta.get("widened"):
            same &= float(limit.get("lower", "0")) - 1e-9 <= data["lower"][k]
            same &= float(limit.get("upper", "0")) + 1e-9 >= data["upper"][k]
        require(same, f"joint '{name}' is another one in {file}, or stands elsewhere.")
    made, unread = shapes(data), 0
    elements = [(link, *each) for link in root.findall("link") for each in enumerate(link.iter("collision"))]
    for link, k, element in elements:
        name, (joint, there) = f"{link.get('name')}_{k}", place(meta, above, link.get("name"))
        shape = element.find("geometry")[0]
        cut = shape.tag == "mesh" and name in meta["cuts"]  # into slabs, which are not compared
        points, radius, cylinder = (None, 0.0, 0) if cut else shape_in(shape, file)
        item = meta["items"].index(f"{name}, slab 1" if cut else name)
        require(data["joint"][item] == joint, f"'{name}' hangs on another joint in {file}.")
        unread += points is None
        if points is not None:
            at = there @ origin_in(element)
            made[item], data["cylinder"][item] = (points @ at[:3, :3].T + at[:3, 3], radius), cylinder
    data["points"], data["radius"] = np.concatenate([points for points, _ in made]), np.array([r for _, r in made])
    data["count"] = np.array([len(points) for points, _ in made])
    left = f" but for {unread} meshes that are cut or not read here" if unread else ""
    left += "; base, held joints and widened limits" if meta.get("widened") else "; base and held joints"
    return f"Joints and shapes are those of {file.name}{left} as the certificate has them."


def place(meta: Words, above: dict[Any, Any], link: Any) -> tuple[int, Array]:
    """The number of the planned joint that carries a link, 0 the base, and where the link is in its frame (4, 4)."""
    at = np.eye(4)
    while link in above:
        joint, held = above[link], np.eye(4)
        name, kind, value = joint.get("name"), joint.get("type"), float(meta["held"].get(joint.get("name"), 0.0))
        if name in meta["joints"]:
            return meta["joints"].index(name) + 1, at
        require(kind == "fixed" or (kind in MOVING and name not in meta["moved"]), f"'{name}' moves, not planned.")
        if kind == "prismatic":
            held[:3, 3] = value * axis_of(joint)
        elif kind != "fixed":
            held[:3, :3] = rotation(axis_of(joint), math.sin(value), math.cos(value))
        at, link = origin_in(joint) @ held @ at, joint.find("parent").get("link")
    return 0, np.array(meta["base"], dtype=float) @ at


def three(element: Any, key: str, otherwise: str = "0 0 0") -> Array:
    return np.array((otherwise if element is None else element.get(key, otherwise)).split(), dtype=float)


def axis_of(joint: Any) -> Array:
    return (axis := three(joint.find("axis"), "xyz", "1 0 0")) / np.linalg.norm(axis)


def origin_in(element: Any) -> Array:
    """Where the origin of a joint or a shape is (4, 4): turned about x, y and z in this order, then shifted."""
    found = np.eye(4)
    for axis, angle in zip(np.eye(3), three(element.find("origin"), "rpy"), strict=True):
        found[:3, :3] = rotation(axis, math.sin(angle), math.cos(angle)) @ found[:3, :3]
    found[:3, 3] = three(element.find("origin"), "xyz")
    return found


def shape_in(shape: Any, file: Path) -> tuple[Array | None, float, int]:
    """Points, radius and whether it is a cylinder, of a shape in its own frame; no points where it is not read here."""
    if shape.tag == "box":
        return np.stack(np.meshgrid(*([-0.5, 0.5],) * 3), axis=-1).reshape(-1, 3) * three(shape, "size"), 0.0, 0
    if shape.tag in ("sphere", "cylinder", "capsule"):
        ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * float(shape.get("length", "0"))
        return ends, float(shape.get("radius")), int(shape.tag == "cylinder")
    name = shape.get("filename", "").rpartition("://")[2].lstrip("/")
    files = [folder / name for folder in file.resolve().parents if (folder / name).is_file()]
    kind, content = files[0].suffix.lower() if files else "", files[0].read_bytes() if files else b""
    if kind == ".stl" and len(content) == 84 + 50 * int.from_bytes(content[80:84], "little"):
        rows = np.frombuffer(content[84:], dtype=np.dtype([("at", "<f4", (4, 3)), ("word", "<u2")]))
        points = rows["at"][:, 1:].reshape(-1, 3).astype(float)
    else:  # as text, in which lines may end anywhere
        mark, words = {".stl": "vertex", ".obj": "v"}.get(kind), content.decode(errors="replace").lower().split()
        points = np.array([words[k + 1 : k + 4] for k, word in enumerate(words) if word == mark], dtype=float)
    return (np.unique(points.reshape(-1, 3), axis=0) * three(shape, "scale", "1 1 1") if len(points) else None), 0.0, 0


def sentence(data: Data, meta: Words, rounding: float, judged: list[str], compared: str) -> str:
    """What is proven of what, and what is not."""
    left = [data["exempt"][data["reason"] == reason].tolist() for reason in (MEETS, LISTED, ALLOWED)]
    names = ", ".join(named(meta, pair) for pair in left[1] + left[2]) or "none"
    motion = f" and of the motion of {np.ptp(data['clock']) / 1e9:g} s" if judged else ""
    limits = f", the motion within those on {', '.join(judged)} that it names" if judged else ""
    ends = " to ".join(str(q) for q in data["path"][[0, -1]].tolist())
    return (
        f"Proven: along all of the path of {len(data['path'])} waypoints from {ends}{motion}, {meta['robot']!r} in "
        f"{meta['scene']!r}, each of {len(data['pairs'])} pairs of bodies stays farther apart than {meta['margin']} m "
        f"(by {len(data['piece'])} witnesses, {rounding:.0e} m for rounding), joints keep their limits{limits}, "
        f"to {FORGIVEN:g}.\nLeft out: {len(left[0])} pairs that no joint moves against each other; {len(left[1])} that "
        f"the robot's files list and {len(left[2])} that the scene allows: {names}.\n"
        f"{compared or 'The robot is as the certificate has it: its URDF was not compared.'} The scene is as the "
        "certificate has it. Nothing is proven of obstacles that move, of the model and its calibration, of the "
        "controller, of the choice of these ends, of conditions and tubes to be kept, and of a floor under w."
    )


if __name__ == "__main__":
    main()
