"""Roadmaps on disk: one ``.npz`` of plain arrays and a JSON header, no pickles.

A file is believed when its arrays have the right shapes and its content matches its hash. A hash is no signature: in
another world all edges are proven again, see :func:`planner.roadmap.reprove.reprove`.
"""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import frozen
from planner.base.cache import content_hash
from planner.base.errors import FileError
from planner.base.files import DAMAGE, StrPath, write_whole
from planner.collision.checker import CollisionChecker
from planner.cost.scale import CostScale
from planner.roadmap.roadmap import ARRAYS, DTYPES, LIBRARIES, Origin, Roadmap, world_hash

FORMAT = "gabf-planner roadmap"
VERSION = 4
_MOST = 1e9  # of a number in the arrays: nodes in rad or m, lengths, manipulability, indices
_AMOUNTS = (  # never negative
    *("manipulability", "joint_length", "tool_length", "edge_manipulability", "edge_cost"),
    *("clearance", "samples"),
)


@dataclass(frozen=True)
class _Header:
    """What the JSON header of a file holds."""

    format: str
    version: int
    origin: Origin
    scale: CostScale
    checksum: str = ""


def save_roadmap(roadmap: Roadmap, path: StrPath) -> None:
    """Write ``path`` completely or not at all; the same roadmap gives the same bytes."""
    arrays: dict[str, Any] = {name: getattr(roadmap, name) for name in DTYPES}
    header = asdict(_Header(FORMAT, VERSION, roadmap.origin, roadmap.scale))
    header["checksum"] = _checksum(header, arrays)
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, header=np.array(json.dumps(header, sort_keys=True)), **arrays)
    write_whole(Path(path), buffer.getvalue())


def load_roadmap(path: StrPath) -> Roadmap:
    """Read a roadmap; :class:`FileError` says how a file is damaged."""
    path = Path(path)
    try:
        roadmap = _read(path)
    except FileError:
        raise
    except FileNotFoundError:
        raise FileError(
            f"roadmap {path} not found: 'planner roadmap build' makes one, 'planner plan' writes one too."
        ) from None
    except OSError as error:
        raise FileError(f"roadmap {path} cannot be read: {error.strerror or error}; name a roadmap.npz.") from None
    except DAMAGE as error:
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise FileError(f"roadmap {path} is damaged or no roadmap ({reason}): build it again.") from None
    return roadmap


def same_world(roadmap: Roadmap, checker: CollisionChecker) -> bool:
    """Whether ``checker`` checks what the roadmap was proven against, with no larger margin and no narrower limits."""
    mine, world, robot = roadmap.origin, checker.world, checker.robot
    if (mine.joints, mine.tool) != (robot.joints, robot.tool) or mine.margin < world.margin:
        return False
    if (robot.lower > mine.lower).any() or (robot.upper < mine.upper).any():
        return False
    # wider limits do not matter: the nodes are within the recorded ones
    within = replace(robot, lower=frozen(mine.lower), upper=frozen(mine.upper))
    return (mine.robot_identity, mine.world) == (within.identity, world_hash(world))


def _checksum(header: dict[str, Any], arrays: dict[str, Any]) -> str:
    """A hash of everything in the file but itself."""
    rest = json.dumps({key: value for key, value in header.items() if key != "checksum"}, sort_keys=True)
    return content_hash([rest, *(arrays[name] for name in DTYPES)])


def _read(path: Path) -> Roadmap:
    with path.open("rb") as file:
        if not zipfile.is_zipfile(file):
            raise ValueError("it is no .npz archive")
        file.seek(0)
        content = np.load(file, allow_pickle=False)
        header = json.loads(str(content["header"]))
        if header.get("format") != FORMAT:
            raise FileError(f"{path} is not a roadmap of this planner.")
        if header["version"] != VERSION:
            raise FileError(
                f"roadmap {path} has format version {header['version']!r}, this planner reads {VERSION}: "
                "build it again with 'planner roadmap build'."
            )
        arrays = {name: content[name] for name in DTYPES}
    if header["checksum"] != _checksum(header, arrays):
        raise ValueError("its content does not match its hash")
    valid = pydantic.TypeAdapter(_Header).validate_python(header)
    _check(arrays, len(valid.origin.joints))
    return Roadmap(scale=valid.scale, origin=valid.origin, **arrays)


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
    if (first >= second).any() or (np.diff(first * n + second) <= 0).any():
        raise ValueError("its edges are not in order")
