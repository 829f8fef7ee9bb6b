"""Everything that a request reads from the disk, as one hash: the files that it names, and those that these name."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

from planner.base.errors import PlannerError
from planner.base.files import StrPath
from planner.base.resources import scene_file
from planner.base.yamlfile import parse_yaml, read_text
from planner.problem.request import PlanRequest, SweepRequest
from planner.robot.files.robot_files import find_robot, robot_file
from planner.robot.files.urdf import Description, read_description
from planner.robot.files.urdf_geometry import mesh_files

Stamp: TypeAlias = tuple[str, int, int]
"""The path of a file, when it was last changed (ns; programs can set back mtime), and its size (bytes)."""


def stamp_of(path: Path) -> Stamp | None:
    """The stamp of a file; None where there is none."""
    try:
        stat = path.stat()
    except (OSError, ValueError):
        return None
    return str(path), stat.st_ctime_ns, stat.st_size


def sources_hash(request: PlanRequest | SweepRequest) -> str:
    """SHA-256 (hex) over the files of a request: robot.yaml, URDF, SRDF, scene, the meshes of both, request, roadmap.

    What is not there, or cannot be made sense of, is hashed as far as it can be: the plan will be refused, until it
    changes. A file that has not been touched is read once a process.
    """
    digest = hashlib.sha256()
    for path in _sources(request):
        stamp = stamp_of(path)
        digest.update(b"missing" if stamp is None else _content(stamp))
    return digest.hexdigest()


def _sources(request: PlanRequest | SweepRequest) -> Iterator[Path]:
    yield from robot_sources(str(request.what.robot), request.what.srdf)
    yield from scene_sources(str(request.what.scene))
    yield from (Path(path) for path in (request.what.motion_plan_request, request.quality.roadmap) if path is not None)


def robot_sources(name: str, srdf: StrPath | None = None) -> Iterator[Path]:
    """robot.yaml or URDF, then files that they name: URDF, SRDF, meshes; each before it is read, if it can be."""
    yield robot_file(name)
    with contextlib.suppress(PlannerError):
        folder, file = find_robot(name)
        found = file.urdf.path(folder) if file else robot_file(name)
        own = file.srdf.path(folder) if file and file.srdf else None
        yield from (Path(path) for path in (found, srdf or own) if path is not None)
        if found.suffix.lower() == ".xacro":  # it may name any of these
            yield from (path for kind in ("*.xacro", "*.yaml") for path in sorted(found.parent.parent.rglob(kind)))
        stamp = stamp_of(found)
        if stamp is not None:
            yield from mesh_files(_description(stamp, tuple(sorted(file.urdf.args.items())) if file else ()))


def scene_sources(name: str) -> Iterator[Path]:
    """The scene's file before it is read, and its meshes."""
    path = scene_file(name) or Path(name)
    stamp = stamp_of(path)
    yield path
    if stamp is not None and path.suffix.lower() in (".yaml", ".yml"):
        with contextlib.suppress(PlannerError):
            yield from (path.parent / name for name in _scene_meshes(stamp))


@lru_cache(maxsize=4096)
def _content(stamp: Stamp) -> bytes:
    try:
        with open(stamp[0], "rb") as file:
            return hashlib.file_digest(file, "sha256").digest()
    except OSError:  # the plan will say so
        return b"unreadable"


@lru_cache(maxsize=64)
def _description(stamp: Stamp, arguments: tuple[tuple[str, str], ...]) -> Description:
    return read_description(Path(stamp[0]), dict(arguments))


@lru_cache(maxsize=4096)
def _scene_meshes(stamp: Stamp) -> tuple[str, ...]:
    """The mesh files that a scene of our own names."""
    data = parse_yaml(read_text(Path(stamp[0]), "scene file"), "scene file")
    things = [data.get(key) for key in ("obstacles", "carried")] if isinstance(data, dict) else []
    items = [item for each in things if isinstance(each, list) for item in each if isinstance(item, dict)]
    return tuple(item["file"] for item in items if isinstance(item.get("file"), str))
