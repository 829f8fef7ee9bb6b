"""``trajectory.json``: a trajectory by the knots of its polynomials."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.errors import FileError, PlannerError, choices
from planner.base.files import StrPath, write_json
from planner.base.yamlfile import Number, Strict, read_text, repeated, shown, validate
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.trajectory import DEGREE, Interpolation, Trajectory

TRAJECTORY_NAME = "trajectory.json"
_LARGEST = 1e6  # rad, rad/s, rad/s², s: no motion of an arm goes there, and of such numbers polynomials become NaN


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
    """The keys of ``trajectory.json``; without ``interpolation`` pieces go through all that the points give."""

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


def trajectory_record(trajectory: Trajectory, robot: str | None = None, scene: str | None = None) -> dict[str, Any]:
    """The trajectory as plain data, the keys of ``trajectory.json``; s, rad, m.

    Between two points it is the polynomial that ``interpolation`` says: cubics take positions and velocities, quintics
    accelerations too.
    """
    columns = (trajectory.times.tolist(), *(trajectory.knots(order).tolist() for order in range(3)))
    return {
        "robot": robot,
        "scene": scene,
        "law": trajectory.time_law,
        "duration": trajectory.duration,
        "limits": trajectory.limits.to_dict() if trajectory.limits else None,
        "interpolation": trajectory.interpolation,
        "joints": list(trajectory.joints),
        "proven": trajectory.proven,
        "proof": trajectory.proof,
        **({"events": [dict(event) for event in trajectory.events]} if trajectory.events else {}),
        "points": [{"t": t, "q": q, "qd": qd, "qdd": qdd} for t, q, qd, qdd in zip(*columns, strict=True)],
    }


def save_trajectory(trajectory: Trajectory, path: StrPath, robot: str | None = None, scene: str | None = None) -> None:
    """Write ``trajectory.json`` whole or not at all; raises :class:`FileError` where that cannot be done."""
    write_json(Path(path), trajectory_record(trajectory, robot, scene))


def load_trajectory(path: StrPath) -> Trajectory:
    """The trajectory of a ``trajectory.json``, or of the folder that holds one.

    Raises :class:`FileError` for a file that is none, is damaged, or whose times do not increase.
    """
    path = Path(path)
    path = path / TRAJECTORY_NAME if os.path.isdir(path) else path
    if not os.path.isfile(path):
        raise FileError(f"trajectory {path} not found: plan first, with times, or check the path.")
    where = f"trajectory {path}"
    return trajectory_in(validate(TrajectoryFile, parse_json(read_text(path, "trajectory"), where), where), where)


def parse_json(text: str, where: str) -> Any:
    """Plain data out of JSON text in which no key stands twice in one object."""
    try:
        return json.loads(text, object_pairs_hook=_object_of)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{where} is no JSON: {error}; mend the file.") from None


def _object_of(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if twice := repeated(key for key, _ in pairs):
        raise ValueError(f"key {shown(twice[0])} stands twice")
    return dict(pairs)


def trajectory_in(file: TrajectoryFile, where: str) -> Trajectory:
    """The trajectory that a file holds, its joints in the order of the file."""
    events = tuple(event.model_dump() for event in file.events)
    try:
        json.dumps([file.joints, events], ensure_ascii=False, allow_nan=False).encode()
    except ValueError:  # half of a surrogate pair, NaN
        raise FileError(f"{where}: its joints or events hold what is no text or no number; mend the file.") from None
    if len(set(file.joints)) < len(file.joints):
        raise FileError(f"{where} names a joint twice; it names {choices(file.joints)}: mend the file.")
    columns = [[getattr(point, key) for point in file.points] for key in ("q", "qd", "qdd")]
    given = None if file.interpolation is None else (DEGREE[file.interpolation] + 1) // 2
    rows = require_columns(columns[:given], len(file.joints), where)
    if given not in (None, len(rows)):
        raise FileError(f"{where}: {file.interpolation} need {given} of q, qd and qdd at each point; add them.")
    proof = file.proof.model_dump(exclude_unset=True)
    limits = _limits(file.limits, tuple(file.joints), where)
    told = {"time_law": file.law, "limits": limits, "proven": file.proven, "proof": proof, "events": events}
    return through_points(tuple(file.joints), np.array([point.t for point in file.points]), rows, where, **told)


def require_columns(columns: list[list[list[float] | None]], width: int, where: str) -> list[Floats]:
    """Positions, velocities and accelerations (k, width), as far as all points give them; :class:`FileError` else."""
    found: list[Floats] = []
    for order, rows in enumerate(columns):
        sizes = [len(row or ()) for row in rows]
        if order and not any(sizes):
            continue
        if order > len(found):
            raise FileError(
                f"{where} gives accelerations and no velocities, of which a ROS 2 joint trajectory controller makes "
                "zeros: give velocities too, or leave the accelerations out."
            )
        wrong = next((k for k, size in enumerate(sizes) if size != width), None)
        if wrong is not None:
            what = ("positions", "velocities", "accelerations")[order]
            raise FileError(f"{where}: point {wrong + 1} has {sizes[wrong]} {what} for {width} joints; mend the file.")
        found.append(np.array(rows, dtype=float))
    return found


def through_points(
    joints: tuple[str, ...], times: Floats, columns: list[Floats], where: str, **told: Any
) -> Trajectory:
    """The trajectory through the points of a file; :class:`FileError` for times and numbers that no motion has."""
    for rows in (times[:, None], *columns):
        bad = np.argwhere(~(np.abs(rows) <= _LARGEST))
        if len(bad):
            raise FileError(
                f"{where}: point {bad[0, 0] + 1} holds a number that is not finite or absurd; mend the file."
            )
    if len(times) < 2:
        raise FileError(f"{where} holds one point: a trajectory has two or more.")
    try:
        return Trajectory(joints, np.round(times * 1e9).astype(np.int64), tuple(columns), **told)
    except PlannerError as error:
        raise FileError(f"{where}: {error}") from None


def _limits(limits: _Limits | None, joints: tuple[str, ...], where: str) -> MotionLimits | None:
    if limits is None:
        return None
    rows = {kind: np.array(getattr(limits, kind)) for kind in KINDS}
    if {len(row) for row in rows.values()} != {len(joints)} or not set(KINDS) <= set(limits.source):
        raise FileError(f"{where}: its limits are not one value for each joint, each with its source; mend the file.")
    return MotionLimits(joints, **rows, source=limits.source)
