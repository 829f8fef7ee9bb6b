"""Roadmaps on disk: one ``.npz`` of plain arrays and a JSON header, no pickles.

A file is accepted when its arrays have the right shapes and its content matches its hash. A hash is no signature: in
another world all edges are proven again, see :func:`planner.roadmap.load_or_build.reprove`.
"""

import io
import json
import math
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen
from planner.base.cache import content_hash
from planner.base.errors import FileError, OptionError
from planner.base.files import DAMAGE, StrPath, write_whole
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.cost.scale import CostScale
from planner.problem.request import WorldRequest
from planner.query.query import make_checker_for
from planner.roadmap.roadmap import ARRAYS, DTYPES, LIBRARIES, Origin, Roadmap, world_hash
from planner.robot.robot import with_widened_limits

FORMAT = "gabf-planner roadmap"
VERSION = 4
_MOST = 1e9  # largest number in the arrays: nodes in rad or m, lengths, manipulability, indices
_AMOUNTS = (  # never negative
    *("manipulability", "joint_length", "tool_length", "edge_manipulability", "edge_cost"),
    *("clearance", "samples"),
)


@dataclass(frozen=True)
class _Header:
    """The JSON header of a file."""

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
    """Return the roadmap in a file; :class:`FileError` says how a file is damaged."""
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
    """Return whether ``checker`` checks the world of the roadmap, at most its margin, at least its limits."""
    mine, world, robot = roadmap.origin, checker.world, checker.robot
    if (mine.joints, mine.tool) != (robot.joints, robot.tool_text) or mine.margin < world.margin:
        return False
    if (robot.lower > mine.lower).any() or (robot.upper < mine.upper).any():
        return False
    # the nodes are within the recorded limits, so wider ones do not matter
    within = replace(robot, lower=frozen(mine.lower), upper=frozen(mine.upper))
    return (mine.robot_identity, mine.world) == (within.identity, world_hash(world))


def _checksum(header: dict[str, Any], arrays: dict[str, Any]) -> str:
    """Return a hash of everything in the file except the hash."""
    rest = json.dumps({key: value for key, value in header.items() if key != "checksum"}, sort_keys=True)
    return content_hash([rest, *(arrays[name] for name in DTYPES)])


def _read(path: Path) -> Roadmap:
    with path.open("rb") as file:
        if not zipfile.is_zipfile(file):
            raise ValueError("the file is not an .npz archive")
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
        raise ValueError("the content does not match the hash")
    valid = pydantic.TypeAdapter(_Header).validate_python(header)
    _check(arrays, len(valid.origin.joints))
    return Roadmap(scale=valid.scale, origin=valid.origin, **arrays)


def _check(arrays: dict[str, Any], dof: int) -> None:
    n, m = len(arrays["nodes"]), len(arrays["edges"])
    if n == 0:
        raise ValueError("the roadmap has no nodes")
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
        raise ValueError("array 'checked_by' holds unknown libraries")
    for name in ("edges", "starts", "goals"):
        if arrays[name].size and not (arrays[name].min() >= 0 and arrays[name].max() < n):
            raise ValueError(f"array '{name}' holds unknown nodes")
    first, second = arrays["edges"].T
    if (first >= second).any() or (np.diff(first * n + second) <= 0).any():
        raise ValueError("the edges are not in order")


def read_world_request(config: Mapping[str, Any], where: str) -> WorldRequest:
    """Return the robot and scene in the ``config`` of a plan.json; :class:`FileError` for invalid options."""
    names = {field.name for field in fields(WorldRequest)}  # type: ignore[arg-type]
    try:
        return WorldRequest(**{name: value for name, value in config.items() if name in names})
    except OptionError:
        raise FileError(f"the options in the plan.json {where} are invalid: plan again.") from None


def reopen_plan(config: Mapping[str, Any], path: StrPath) -> CollisionChecker:
    """Return a checker of a plan's world, by the ``config`` of its plan.json and its roadmap at ``path``.

    Raises :class:`PlannerError` where it cannot be opened, or differs from the roadmap's.
    """
    request = read_world_request(config, f"next to {path}")
    roadmap = load_roadmap(path)
    checker = make_checker_for(request, config.get("request"), lambda _: roadmap.nodes[roadmap.starts[0]])
    robot, origin = checker.robot, roadmap.origin
    if config.get("widen_limits") and robot.joints == origin.joints:
        wide = with_widened_limits(robot, np.array([origin.lower, origin.upper]))
        world = checker.world
        checker = make_checker(wide, world.scene, request.collision, request.margin, world.conditions)
    if not same_world(roadmap, checker):
        raise FileError(f"roadmap {path} was proven for another robot or scene than its plan.json names: plan again.")
    return checker


QUANTILES = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)


def summarize(roadmap: Roadmap) -> dict[str, Any]:
    """Return a summary of ``roadmap`` for one page; lengths in m, joint motion in rad, None if not finite.

    ``components`` are sizes, largest first; ``clearance`` is the certified one beyond the margin.
    """
    origin, n = roadmap.origin, len(roadmap.nodes)
    degree = np.bincount(roadmap.edges.ravel(), minlength=n)
    return {
        "robot": origin.robot,
        "scene": origin.scene,
        "joints": list(origin.joints),
        "limits": [list(pair) for pair in zip(origin.lower, origin.upper, strict=True)],
        "tool": origin.tool,
        "margin": origin.margin,
        "seed": origin.seed,
        "versions": dict(origin.versions),
        "nodes": n,
        "edges": len(roadmap.edges),
        "edges_certified": int(roadmap.proven.sum()),
        "nodes_checked": roadmap.nodes_checked,
        "starts": roadmap.starts.tolist(),
        "goals": roadmap.goals.tolist(),
        "connected": roadmap.is_connected,
        "components": sorted(np.bincount(roadmap.components).tolist(), reverse=True),
        "degree": {"min": int(degree.min()), "mean": float(degree.mean()), "max": int(degree.max())},
        "manipulability": {f"{q:g}": float(np.quantile(roadmap.manipulability, q)) for q in QUANTILES},
        "joint_length": _spread(roadmap.joint_length),
        "tool_length": _spread(roadmap.tool_length),
        "clearance": _spread(roadmap.clearance[roadmap.proven]),
        "samples": int(roadmap.samples.sum()),
        "scale": asdict(roadmap.scale),
        "robot_identity": origin.robot_identity,
        "scene_identity": origin.scene_identity,
        "sha256": roadmap.sha256,
    }


def _spread(values: Floats) -> dict[str, float | None]:
    if not len(values):
        return dict.fromkeys(("min", "median", "max"))
    ends = float(values.min()), float(np.median(values)), float(values.max())
    return {key: end if math.isfinite(end) else None for key, end in zip(("min", "median", "max"), ends, strict=True)}
