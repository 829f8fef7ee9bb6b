"""Roadmaps on disk: one ``.npz`` of plain arrays and a JSON header, no pickles.

A file is believed when it is whole: sizes are compared before anything is unpacked, shapes, types and numbers before
anything is used, and a hash over everything last. A hash is no signature: what the certificates say is proven anew by
:func:`planner.construction.repair.verify`.
"""

from __future__ import annotations

import io
import json
import logging
import zipfile
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from planner.base.arrays import frozen
from planner.base.beside import warn_of_mismatch
from planner.base.errors import FileError
from planner.base.files import is_file, is_folder, write_whole
from planner.base.hashing import content_hash
from planner.base.npz import DAMAGE, require_sane_sizes
from planner.base.places import Place, place
from planner.base.resolutions import W_STATES_PER_EDGE
from planner.base.yamlfile import Strict, Whole, shown, validate
from planner.collision.checker import CollisionChecker
from planner.objective.scale import COSTS, CostScale, mean_manipulability_cost
from planner.roadmap.node_checks import nobody
from planner.roadmap.roadmap import ARRAYS, DTYPES, LIBRARIES, Origin, Roadmap
from planner.roadmap.world_record import changes, holds_limits, unproven_pairs

_log = logging.getLogger(__name__)

FORMAT = "gabf-planner roadmap"
VERSION = 3  # 2: what the world was made of, a certificate for every edge; 3: who checked nodes, the cost along edges
_ADDED = {2: ("checked_by", "edge_cost")}  # arrays that files of an earlier version lack
_LEVEL = 1  # of compression: a seventh of the usual one's time, and a tenth more bytes
_LARGEST = 4 << 30  # bytes unpacked: beyond any roadmap that fits this planner, so a hostile file
_MOST = 1e9  # of a number in the arrays: nodes in rad or m, lengths, manipulability, indices
_AMOUNTS = (  # never negative
    *("manipulability", "joint_length", "tool_length", "edge_manipulability", "edge_cost"),
    *("clearance", "samples"),
)
_LARGEST_HEADER, _SLACK = 64 << 20, 1 << 20  # bytes


class _Header(Strict):
    """The header as it must be, number by number."""

    format: Literal["gabf-planner roadmap"]
    version: Whole
    sha256: str
    checksum: str
    origin: Origin
    scale: CostScale


def save_roadmap(roadmap: Roadmap, path: Place) -> None:
    """Write ``path`` whole or not at all; the same roadmap gives the same bytes.

    Integers and truth values are compressed; real numbers hardly can be, and are stored as they are.
    """
    header: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "sha256": roadmap.sha256,
        "origin": asdict(roadmap.origin),
        "scale": asdict(roadmap.scale),
    }
    arrays: dict[str, Any] = {name: getattr(roadmap, name) for name in DTYPES}
    header["checksum"] = _checksum(header, arrays)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in {"header": np.array(_text(header)), **arrays}.items():
            packed = zipfile.ZIP_STORED if array.dtype.kind == "f" else zipfile.ZIP_DEFLATED
            member = zipfile.ZipInfo(f"{name}.npy")  # of 1980: the same bytes at any time
            archive.writestr(member, _npy(array), packed, _LEVEL)
    write_whole(place(path), buffer.getvalue())


def _npy(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, array, allow_pickle=False)
    return buffer.getvalue()


def load_roadmap(path: Place) -> Roadmap:
    """Read a roadmap and check that it is whole; :class:`FileError` says what is wrong with it.

    A warning is logged where the record of the run beside it was written with another one.
    """
    path = place(path)
    if is_folder(path):
        raise FileError(f"roadmap {path} is a folder: name the roadmap.npz in it.")
    if not is_file(path):
        raise FileError(f"roadmap {path} not found: 'planner roadmap build' makes one, 'planner plan' writes one too.")
    try:
        header, arrays, checksum = _read(path)
        roadmap = _build(header, _with_what_it_lacks(arrays, header.scale, path))
        if header.checksum != checksum or header.sha256 != roadmap.sha256:
            raise FileError(f"roadmap {path} is damaged: its content does not match its hash; build it again.")
    except FileError:
        raise
    except PermissionError as error:
        raise FileError(
            f"roadmap {path} cannot be read: {error.strerror}; give yourself the right to read it."
        ) from None
    except DAMAGE as error:
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise FileError(f"roadmap {path} is damaged or no roadmap ({reason}): build it again.") from None
    warn_of_mismatch(path)
    return roadmap


def same_world(roadmap: Roadmap, checker: CollisionChecker) -> bool:
    """Whether everything that the roadmap was proven against is what ``checker`` checks, with no larger margin.

    Limits wider than the roadmap's do not matter: its configurations are within them.
    """
    mine, world, record = roadmap.origin, checker.world, roadmap.origin.world
    robot = world.robot
    if holds_limits(record, world):
        robot = replace(robot, lower=frozen(record.lower), upper=frozen(record.upper))
    return (
        (mine.robot, mine.joints, mine.tool, mine.scene) == (robot.name, robot.joints, robot.tool, world.scene.name)
        and mine.margin >= world.margin
        and mine.robot_identity == robot.identity
        and mine.scene_identity == world.scene.identity
        # which pairs of links can never touch may have been worked out by the other backend
        and not any(pairs.any() for pairs in unproven_pairs(record, world))
    )


def require_same_world(roadmap: Roadmap, checker: CollisionChecker, path: Place) -> None:
    """Refuse a roadmap that was grown for another robot, another scene or a smaller margin."""
    if same_world(roadmap, checker):
        return
    mine, world = roadmap.origin, checker.world
    robot, scene = world.robot, world.scene
    kept = f"or keep what holds here with {_REPAIR}"
    for what, a, b, remedy in (
        ("robot", mine.robot, robot.name, f"build one for this robot, {kept}"),
        ("joints", mine.joints, robot.joints, "choose the same ones with --joints or --group, or build one for these"),
        ("tool frame", mine.tool, robot.tool, f"build one for this tool frame, {kept}"),
        ("scene", mine.scene, scene.name, f"build one for this scene, {kept}"),
    ):
        if a != b:
            raise FileError(f"roadmap {path} is for {what} {_quoted(a)}, not {_quoted(b)}: {remedy}.")
    if mine.margin < world.margin:
        raise FileError(
            f"roadmap {path} was proven with a margin of {mine.margin:g} m, less than the {world.margin:g} m "
            f"asked for: build it again, ask for less, or keep what holds here with {_REPAIR}."
        )
    differences = changes(mine.world, world)
    obstacles = mine.scene_identity != scene.identity and not any(item.startswith("body") for item in differences)
    other = f"scene '{mine.scene}' with other obstacles" if obstacles else f"'{mine.robot}' of other geometry or set-up"
    what = f" ({_some(differences)})" if differences else ""
    raise FileError(f"roadmap {path} is for a {other}{what}: build it again, {kept}.")


_REPAIR = "'planner roadmap check --repair'"


def _some(items: list[str], most: int = 4) -> str:
    more = f" and {len(items) - most} more" if len(items) > most else ""
    return ", ".join(items[:most]) + more


def _quoted(value: Any) -> str:
    return ", ".join(value) if isinstance(value, tuple) else f"'{value}'"


def _text(header: dict[str, Any]) -> str:
    return json.dumps(header, sort_keys=True)


def _checksum(header: dict[str, Any], arrays: dict[str, Any]) -> str:
    """A hash over everything in the file but itself."""
    rest = {key: value for key, value in header.items() if key != "checksum"}
    return content_hash([_text(rest), *(arrays[name] for name in DTYPES if name in arrays)])


def _read(path: Path) -> tuple[_Header, dict[str, Any], str]:
    """The header, the arrays, and the hash that the file should name."""
    require_sane_sizes(path, f"roadmap {path}", _SLACK, _LARGEST)
    with np.load(path, allow_pickle=False) as content:
        size = content.zip.getinfo("header.npy").file_size
        if size > _LARGEST_HEADER:
            raise ValueError(f"its header has {size} bytes")
        header = json.loads(str(content["header"]))
        if not isinstance(header, dict) or header.get("format") != FORMAT:
            raise FileError(f"{path} is not a roadmap of this planner.")
        version = header.get("version")
        if version not in (VERSION, *_ADDED):
            raise FileError(
                f"roadmap {path} has format version {shown(version)}, this planner reads {VERSION}: "
                "build it again with 'planner roadmap build'."
            )
        names = [name for name in DTYPES if name not in _ADDED.get(version, ())]
        missing, foreign = [n for n in names if n not in content.files], set(content.files) - {"header", *names}
        if missing or foreign:
            raise ValueError(
                f"it lacks {', '.join(missing)}" if missing else f"it holds {', '.join(sorted(foreign))} too"
            )
        arrays = {name: content[name] for name in names}
        checked, checksum = validate(_Header, header, f"roadmap {path} is damaged"), _checksum(header, arrays)
        return checked, arrays, checksum


def _with_what_it_lacks(arrays: dict[str, Any], scale: CostScale, path: Path) -> dict[str, Any]:
    """The arrays of a file of an earlier version and those it lacks: nobody's checks, and costs over a few states."""
    w = arrays["edge_manipulability"]
    if "edge_cost" in arrays or w.shape != (len(arrays["edges"]), W_STATES_PER_EDGE):
        return arrays
    _log.warning(
        "roadmap %s is of an earlier version, which took the cost along long edges from %d states of them: "
        "'planner roadmap check --repair' measures it finer",
        path, W_STATES_PER_EDGE,
    )  # fmt: skip
    costs = np.stack([mean_manipulability_cost(w, scale, name) for name in COSTS], axis=1)
    return arrays | {"edge_cost": costs, "checked_by": nobody(len(arrays["nodes"]))}


def _build(header: _Header, arrays: dict[str, Any]) -> Roadmap:
    scale, origin = header.scale, header.origin
    if not (0 < scale.w_low <= scale.w_high and min(scale.joint_length, scale.tool_length, scale.zeta) > 0):
        raise ValueError("its cost scale is not positive")
    if origin.margin < 0:
        raise ValueError("its margin is negative")
    dof, bodies = len(origin.joints), len(origin.world.bodies)
    if not dof == len(origin.world.lower) == len(origin.world.upper):
        raise ValueError(f"it has {dof} joints and limits of {len(origin.world.lower)}")
    if not all(0 <= body < bodies for pair in origin.world.self_pairs for body in pair):
        raise ValueError("its pairs of links point at bodies that are not there")
    _check(arrays, dof)
    return Roadmap(scale=scale, origin=origin, **arrays)


def _check(arrays: dict[str, Any], dof: int) -> None:
    n, m = len(arrays["nodes"]), len(arrays["edges"])
    if n == 0:
        raise ValueError("it has no nodes")
    for name, (dtype, of, row) in ARRAYS.items():
        array = arrays[name]
        count = {"node": (n,), "edge": (m,), "end": array.shape[:1]}[of]
        shape = (*count, *(dof if size == "dof" else size for size in row))
        if array.shape != shape or array.dtype.newbyteorder("=") != dtype:
            raise ValueError(f"array '{name}' has shape {array.shape} of {array.dtype}, expected {shape}")
        if np.isnan(array).any() or (name != "clearance" and not np.isfinite(array).all()):
            raise ValueError(f"array '{name}' holds values that are not finite")
        if array.size and name not in ("clearance", "samples") and not (np.abs(array) <= _MOST).all():
            raise ValueError(f"array '{name}' holds values beyond {_MOST:g}")
    for name in _AMOUNTS:
        if (arrays[name] < 0).any():
            raise ValueError(f"array '{name}' holds negative values")
    if not np.isin(arrays["checked_by"], range(len(LIBRARIES))).all():
        raise ValueError("array 'checked_by' names libraries that are not there")
    for name in ("edges", "starts", "goals"):
        if arrays[name].size and not (arrays[name].min() >= 0 and arrays[name].max() < n):
            raise ValueError(f"array '{name}' points at nodes that are not there")
    first, second = arrays["edges"].T
    if (first >= second).any():
        raise ValueError("an edge does not name its lower node first")
    if (np.diff(first * n + second) <= 0).any():
        raise ValueError("its edges are not in order")
