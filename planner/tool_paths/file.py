"""Files of tool paths: YAML with lines and arcs, or CSV with one row per point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.errors import ArrayError, FileError
from planner.base.files import StrPath
from planner.base.yamlfile import Coordinate, Number, Strict, parse_yaml, read_text, validate
from planner.robot.poses import pose
from planner.tool_paths.tool_path import POINT_ARRAYS, SAGITTA, ToolPath, TubeSize, align_z, arc_points
from planner.trajectory.recorded import csv_table, matrix

_UNIT = 1e-3  # of a quaternion's or an axis's length
_COLUMNS = {"quaternion": ("qx", "qy", "qz", "qw"), "axis": ("ax", "ay", "az")}

Vector = Annotated[list[Coordinate], pydantic.Field(min_length=3, max_length=3)]


class _Tube(Strict):
    position: Number = TubeSize.position
    angle: Number = TubeSize.angle


class _Cone(Strict):
    axis: Vector
    angle: Annotated[Number, pydantic.Field(gt=0)]


class _Point(Strict):
    position: Vector
    quaternion: Annotated[list[Coordinate], pydantic.Field(min_length=4, max_length=4)] | None = None
    axis: Vector | None = None
    cone: _Cone | None = None
    via: Literal["arc"] | None = None

    @pydantic.model_validator(mode="after")
    def _one_orientation(self) -> _Point:
        if sum(given is not None for given in (self.quaternion, self.axis, self.cone)) != 1:
            raise ValueError("give one of quaternion, axis and cone")
        return self


class ToolPathFile(Strict):
    """A tool path: points in m in the world, the tool's orientation at each, and the tolerances."""

    name: str = ""
    tube: _Tube = _Tube()
    points: list[_Point]
    approach: Annotated[Number, pydantic.Field(ge=0, le=1)] = 0.0
    retreat: Annotated[Number, pydantic.Field(ge=0, le=1)] = 0.0


def read_tool_path(path: StrPath | Mapping[str, Any]) -> ToolPath:
    """Return the tool path of a .yaml or .csv file, or of a mapping with its keys.

        read_tool_path({"points": [{"position": [0.4, y, 0.3], "axis": [0, 0, -1]} for y in (-0.1, 0.1)]})

    Raises :class:`FileError` for another file.
    """
    if isinstance(path, Mapping):
        return build_tool_path(validate(ToolPathFile, dict(path), "tool path"), "the tool path", "tool path")
    path = Path(path)
    where, text = f"tool path {path}", read_text(path, "tool path")
    if path.suffix.lower() not in (".yaml", ".yml", ".csv"):
        raise FileError(f"{where} must end in .yaml or .csv, got '{path.suffix}'.")
    data = _rows(text, where) if path.suffix.lower() == ".csv" else parse_yaml(text, where)
    return build_tool_path(validate(ToolPathFile, data, where), where, path.stem)


def build_tool_path(file: ToolPathFile, where: str, name: str) -> ToolPath:
    """Return the tool path of a file, arcs as lines; :class:`FileError` names ``where`` and the point."""
    positions = np.array([point.position for point in file.points], dtype=float).reshape(-1, 3)
    free = np.array([point.quaternion is None for point in file.points])
    cones = np.array([0.0 if point.cone is None else point.cone.angle for point in file.points])
    turns, given = _orientations(file.points, where), np.arange(len(positions)) + 1
    try:
        tube = TubeSize(file.tube.position, file.tube.angle)
        path = ToolPath(file.name or name, positions, turns, free, cones, given, tube)
    except ArrayError as error:
        raise FileError(f"{where}: {error}") from None
    vias = [k for k, point in enumerate(file.points) if point.via]
    return _add_legs(_expand_arcs(path, vias, where), file.approach, file.retreat)


def _rows(text: str, where: str) -> dict[str, Any]:
    """Return the rows of a CSV with named columns, as the keys of a YAML file."""
    names, table = csv_table(text, where)
    headers = {kind: ("x", "y", "z", *columns) for kind, columns in _COLUMNS.items()}
    kind = next((kind for kind, columns in headers.items() if sorted(names or ()) == sorted(columns)), None)
    if names is None or kind is None:
        columns = ", ".join(names) if names else "none"
        raise FileError(f"{where}: columns must be x, y, z and qx, qy, qz, qw or ax, ay, az, got {columns}.")
    values = matrix(table, where)
    if len(table) and values.shape[1] != len(names):
        raise FileError(f"{where}: rows must have {len(names)} numbers, got {values.shape[1]}; mend the file.")
    ordered = values[:, [names.index(name) for name in headers[kind]]] if table else values
    return {"points": [{"position": row[:3], kind: row[3:]} for row in ordered.tolist()]}


def _orientations(points: list[_Point], where: str) -> Floats:
    """Return (k, 3, 3) orientations; free ones are nearest to the point before."""
    turns = np.empty((len(points), 3, 3))
    before = np.eye(3)
    for number, point in enumerate(points):
        values = np.array(point.quaternion or point.axis or (point.cone and point.cone.axis), dtype=float)
        length = float(np.linalg.norm(values))
        kind = "quaternion" if point.quaternion else "axis"
        if abs(length - 1.0) > _UNIT:
            raise FileError(f"{where}: the {kind} of point {number + 1} must have length 1, got {length:g}.")
        if point.quaternion:
            turns[number] = pose(quaternion=values.tolist())[:3, :3]
        else:
            turns[number] = align_z((values / length)[None], before[None])[0]
        before = turns[number]
    return turns


def _expand_arcs(path: ToolPath, vias: list[int], where: str) -> ToolPath:
    """Return the path with lines in place of the arcs through the points ``vias``."""
    if vias and (vias[0] == 0 or vias[-1] == len(path.positions) - 1 or 1 in np.diff(vias)):
        raise FileError(
            f"{where}: a point with 'via: arc' must be between two without: give each arc a start and an end."
        )
    parts = [path.rows(slice(1))]
    for k in range(1, len(path.positions)):
        if k in vias:
            try:
                parts.append(_sample_arc(path, k - 1, *arc_points(path.positions[k - 1 : k + 2], path.tube.position)))
            except ValueError as error:
                raise FileError(f"{where}: point {k + 1} must be the middle of an arc, but {error}: move it.") from None
        elif k - 1 not in vias:
            parts.append(path.rows(slice(k, k + 1)))
    bend = SAGITTA * path.tube.position if vias else 0.0
    return replace(path, **{name: np.concatenate([part[name] for part in parts]) for name in POINT_ARRAYS}, bend=bend)


def _sample_arc(path: ToolPath, first: int, points: Floats, angles: Floats) -> dict[str, Any]:
    """Return arrays of points on the arc from ``first``; orientations change linearly on each half."""
    at_middle = int(np.abs(points - path.positions[first + 1]).sum(axis=1).argmin())
    begin = np.where(np.arange(len(points)) <= at_middle, first, first + 1)
    low = np.where(begin == first, 0.0, angles[at_middle])
    high = np.where(begin == first, angles[at_middle], angles[-1])
    _, turns, free, cones = path.at(begin, (angles - low) / (high - low))
    return dict(zip(POINT_ARRAYS, (points, turns, free, cones, path.given[begin + 1]), strict=True))


def _add_legs(path: ToolPath, approach: float, retreat: float) -> ToolPath:
    """Return the path with straight legs along the tool's z axis, before and after it (m)."""
    last = len(path.positions) - 1
    rows = path.rows(np.array([*[0] * (approach > 0), *range(last + 1), *[last] * (retreat > 0)]))
    rows["positions"][0] -= approach * path.turns[0, :, 2]
    rows["positions"][-1] -= retreat * path.turns[-1, :, 2]
    return replace(path, **rows)
