"""Roadmaps on disk: one ``.npz`` of plain arrays and a JSON header, no pickles."""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

import numpy as np

from planner.collision.checker import CollisionChecker
from planner.errors import FileError
from planner.files import write_whole
from planner.roadmap.build import origin_of
from planner.roadmap.roadmap import CostScale, Origin, Roadmap
from planner.yamlfile import Strict, validate

FORMAT = "gabf-planner roadmap"
VERSION = 1
_ARRAYS = ("nodes", "edges", "proven", "starts", "goals", "manipulability", "joint_length", "tool_length")
_LARGEST = 4 << 30  # bytes unpacked: beyond any roadmap that fits this planner, so a hostile file


# what a zip or npy reader, or a header that is not ours, can end in
_DAMAGE = (
    *(OSError, EOFError, ValueError, KeyError, TypeError, AttributeError, MemoryError, RecursionError, RuntimeError),
    *(zipfile.BadZipFile, zlib.error),
)


class _Header(Strict):
    """The header as it must be, number by number."""

    format: Literal["gabf-planner roadmap"]
    version: int
    sha256: str
    origin: Origin
    scale: CostScale


def save_roadmap(roadmap: Roadmap, path: Path) -> None:
    """Write ``path`` whole or not at all; the same roadmap gives the same bytes."""
    header = {
        "format": FORMAT,
        "version": VERSION,
        "sha256": roadmap.sha256,
        "origin": asdict(roadmap.origin),
        "scale": asdict(roadmap.scale),
    }
    arrays: dict[str, Any] = {name: getattr(roadmap, name) for name in _ARRAYS}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, header=np.array(json.dumps(header, sort_keys=True)), **arrays)
    write_whole(path, buffer.getvalue())


def load_roadmap(path: Path) -> Roadmap:
    """Read a roadmap and check that it is whole; :class:`FileError` says what is wrong with it."""
    if not path.is_file():
        raise FileError(f"roadmap {path} not found: 'planner plan' writes roadmap.npz into its --out folder.")
    try:
        header, arrays = _read(path)
        roadmap = _build(header, arrays)
        if roadmap.sha256 != header.sha256:
            raise FileError(f"roadmap {path} is damaged: its content does not match its hash; build it again.")
    except FileError:
        raise
    except _DAMAGE as error:
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise FileError(f"roadmap {path} is damaged or no roadmap ({reason}): build it again.") from None
    return roadmap


def require_same_world(roadmap: Roadmap, checker: CollisionChecker, path: Path) -> None:
    """Refuse a roadmap that was grown for another robot, another scene or a smaller margin."""
    mine, wanted = roadmap.origin, origin_of(checker, roadmap.origin.seed)
    for what, a, b in (
        ("robot", mine.robot, wanted.robot),
        ("joints", mine.joints, wanted.joints),
        ("tool frame", mine.tool, wanted.tool),
        ("scene", mine.scene, wanted.scene),
    ):
        if a != b:
            raise FileError(f"roadmap {path} is for {what} {_text(a)}, not {_text(b)}: build one for this {what}.")
    if mine.robot_identity != wanted.robot_identity:
        raise FileError(f"roadmap {path} is for a '{mine.robot}' of other geometry or set-up: build it again.")
    if mine.scene_identity != wanted.scene_identity:
        raise FileError(f"roadmap {path} is for a scene '{mine.scene}' with other obstacles: build it again.")
    if mine.margin < wanted.margin:
        raise FileError(
            f"roadmap {path} was proven with a margin of {mine.margin:g} m, less than the {wanted.margin:g} m "
            "asked for: build it again, or ask for less."
        )


def _text(value: Any) -> str:
    return ", ".join(value) if isinstance(value, tuple) else f"'{value}'"


def _read(path: Path) -> tuple[_Header, dict[str, Any]]:
    with zipfile.ZipFile(path) as archive:
        if sum(item.file_size for item in archive.infolist()) > _LARGEST:
            raise FileError(f"roadmap {path} would unpack to more than {_LARGEST >> 30} GiB: it is no roadmap of ours.")
    with np.load(path, allow_pickle=False) as content:
        header = json.loads(str(content["header"]))
        if not isinstance(header, dict) or header.get("format") != FORMAT:
            raise FileError(f"{path} is not a roadmap of this planner.")
        if header.get("version") != VERSION:
            raise FileError(
                f"roadmap {path} has format version {header.get('version')}, this planner reads {VERSION}: "
                "build it again."
            )
        return validate(_Header, header, f"roadmap {path} is damaged"), {name: content[name] for name in _ARRAYS}


def _build(header: _Header, arrays: dict[str, Any]) -> Roadmap:
    scale = header.scale
    if not (0 < scale.w_low <= scale.w_high and min(scale.joint_length, scale.tool_length, scale.zeta) > 0):
        raise ValueError("its cost scale is not positive")
    if header.origin.margin < 0:
        raise ValueError("its margin is negative")
    _check(arrays, len(header.origin.joints))
    return Roadmap(scale=scale, origin=header.origin, **arrays)


def _check(arrays: dict[str, Any], dof: int) -> None:
    n, m = len(arrays["nodes"]), len(arrays["edges"])
    if n == 0:
        raise ValueError("it has no nodes")
    shapes = {
        "nodes": (n, dof),
        "edges": (m, 2),
        "proven": (m,),
        "manipulability": (n,),
        "joint_length": (m,),
        "tool_length": (m,),
        "starts": arrays["starts"].shape[:1],
        "goals": arrays["goals"].shape[:1],
    }
    for name, shape in shapes.items():
        if arrays[name].shape != shape or arrays[name].dtype.kind not in "fib":
            raise ValueError(f"array '{name}' has shape {arrays[name].shape}, expected {shape}")
        if not np.isfinite(arrays[name]).all():
            raise ValueError(f"array '{name}' holds values that are not finite")
    for name in ("edges", "starts", "goals"):
        if arrays[name].size and not (arrays[name].min() >= 0 and arrays[name].max() < n):
            raise ValueError(f"array '{name}' points at nodes that are not there")
    if (arrays["edges"][:, 0] >= arrays["edges"][:, 1]).any():
        raise ValueError("an edge does not name its lower node first")
