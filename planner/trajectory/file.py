"""The content of ``trajectory.json``: a trajectory by the knots of its polynomials, as a file model."""

import json
from typing import Any, Literal

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.errors import FileError
from planner.base.yamlfile import Number, Strict, find_duplicates, quote
from planner.trajectory.limits import KINDS, MotionLimits

TRAJECTORY_NAME = "trajectory.json"
Interpolation = Literal["lines", "cubics", "quintics"]


class _Point(Strict):
    t: Number
    q: list[Number]
    qd: list[Number] | None = None
    qdd: list[Number] | None = None


class _Limits(Strict):
    velocity: list[Number]
    acceleration: list[Number]
    jerk: list[Number]
    source: dict[str, str]


class _Event(Strict):
    model_config = pydantic.ConfigDict(extra="allow")

    t: Number
    kind: str
    object: str
    link: str


class _Floor(Strict):
    model_config = pydantic.ConfigDict(extra="allow")

    asked: Number


class _Proof(Strict):
    model_config = pydantic.ConfigDict(extra="allow")

    floor: _Floor = _Floor(asked=0.0)


class TrajectoryFile(Strict):
    """The keys of ``trajectory.json``; without ``interpolation`` the columns of the points decide it."""

    robot: str | None = None
    scene: str | None = None
    law: str = "given"
    duration: Number | None = None
    interpolation: Interpolation | None = None
    joints: list[str]
    limits: _Limits | None = None
    proven: bool = False
    proof: _Proof = _Proof()
    events: list[_Event] = pydantic.Field(default_factory=list)
    points: list[_Point] = pydantic.Field(min_length=2)


def parse_json(text: str, where: str) -> Any:
    """Return plain data of JSON text without repeated keys; :class:`FileError` for other text."""
    try:
        return json.loads(text, object_pairs_hook=_build_object)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{where} must be JSON, got an error: {error}; mend the file.") from None


def _build_object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if twice := find_duplicates(key for key, _ in pairs):
        raise ValueError(f"key {quote(twice[0])} is repeated")
    return dict(pairs)


def require_columns(columns: list[list[list[float] | None]], width: int, where: str) -> list[Floats]:
    """Return positions, velocities and accelerations (k, width), if given; :class:`FileError` for gaps."""
    arrays: list[Floats] = []
    for order, rows in enumerate(columns):
        sizes = [len(row or ()) for row in rows]
        if order and not any(sizes):
            continue
        if order > len(arrays):
            raise FileError(
                f"{where}: accelerations must come with velocities, got none (a ROS 2 controller would take "
                "zeros then): give velocities, or leave the accelerations out."
            )
        wrong = next((k for k, size in enumerate(sizes) if size != width), None)
        if wrong is not None:
            kind = ("positions", "velocities", "accelerations")[order]
            raise FileError(f"{where}: point {wrong + 1} must have {width} {kind}, got {sizes[wrong]}; mend the file.")
        arrays.append(np.array(rows, dtype=float))
    return arrays


def read_limits(limits: _Limits | None, joints: tuple[str, ...], where: str) -> MotionLimits | None:
    """Return the limits in a file; :class:`FileError` unless every joint and kind is complete."""
    if limits is None:
        return None
    rows = {kind: np.array(getattr(limits, kind)) for kind in KINDS}
    if {len(row) for row in rows.values()} != {len(joints)} or not set(KINDS) <= set(limits.source):
        raise FileError(f"{where}: limits must be one value per joint, each with its source; mend the file.")
    return MotionLimits(joints, **rows, source=limits.source)
