"""``trajectory.json``: a trajectory by the knots of its polynomials."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError, choices
from planner.base.files import StrPath, write_json
from planner.base.yamlfile import Number, Strict, read_text, validate
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.path_file import parse
from planner.trajectory.trajectory import DEGREE, Interpolation, Trajectory

TRAJECTORY_NAME = "trajectory.json"
FAR = 1e6  # rad, rad/s, rad/s², s: no motion of an arm goes there, and of such numbers polynomials become NaN


class _Point(Strict):
    t: Number
    q: list[Number]
    qd: list[Number]
    qdd: list[Number]


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


class _File(Strict):
    robot: str | None = None
    scene: str | None = None
    law: str
    duration: Number | None = None
    interpolation: Interpolation
    joints: list[str]
    limits: _Limits | None = None
    proven: bool = False
    proof: _Proof = _Proof()
    events: list[_Event] = pydantic.Field(default_factory=list)
    points: list[_Point] = pydantic.Field(min_length=2)


KEYS, POINT_KEYS = tuple(_File.model_fields), tuple(_Point.model_fields)


def trajectory_record(trajectory: Trajectory, robot: str | None = None, scene: str | None = None) -> dict[str, Any]:
    """The trajectory as plain data, the keys of ``trajectory.json``; s, rad, m.

    Between two points it is the polynomial that ``interpolation`` says: cubics take positions and velocities, quintics
    accelerations too.
    """
    columns = (trajectory.times.tolist(), *(trajectory.knots(order).tolist() for order in range(3)))
    return {
        "robot": robot,
        "scene": scene,
        "law": trajectory.law,
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

    Raises :class:`FileError` for a file that is none, is damaged, or whose times do not increase; warns of one of
    another run than its plan.json.
    """
    path = Path(path)
    path = path / TRAJECTORY_NAME if os.path.isdir(path) else path
    if not os.path.isfile(path):
        raise FileError(f"trajectory {path} not found: plan first, with times, or check the path.")
    where = f"trajectory {path}"
    file = validate(_File, parse(read_text(path, "trajectory"), where), where)
    dof = len(file.joints)
    events = tuple(event.model_dump() for event in file.events)
    try:
        json.dumps([file.joints, events], ensure_ascii=False, allow_nan=False).encode()
    except ValueError:  # half of a surrogate pair, NaN
        raise FileError(f"{where}: its joints or events hold what is no text or no number; mend the file.") from None
    if len(set(file.joints)) < dof:
        raise FileError(f"{where} names a joint twice; it names {choices(file.joints)}: mend the file.")
    columns = [[getattr(point, key) for point in file.points] for key in ("q", "qd", "qdd")]
    if any(len(row) != dof for rows in columns for row in rows):
        raise FileError(f"{where}: a point has not one value for each of its {dof} joints; mend the file.")
    times = np.array([point.t for point in file.points])
    for rows in (times[:, None], *map(_rows, columns)):
        require_near(rows, where)
    if not (np.diff(times) > 0).all():
        raise FileError(f"{where}: its times do not increase strictly; mend the file.")
    given = (DEGREE[file.interpolation] + 1) // 2
    made = Trajectory.through(tuple(file.joints), times, *map(_rows, columns[:given]), law=file.law)
    limits = _limits(file.limits, made.joints, where)
    return replace(
        made, limits=limits, proven=file.proven, proof=file.proof.model_dump(exclude_unset=True), events=events
    )


def require_near(rows: Floats, where: str) -> None:
    """Raise :class:`FileError` for numbers (k, columns) of points that are not finite, or beyond :data:`FAR`."""
    bad = np.argwhere(~(np.abs(rows) <= FAR))
    if len(bad):
        raise FileError(f"{where}: point {bad[0, 0] + 1} holds a number that is not finite or absurd; mend the file.")


def _rows(rows: list[list[float]]) -> Floats:
    return np.array(rows, dtype=float)


def limits_in(data: Any, where: str) -> MotionLimits | None:
    """The limits that plain data of a ``trajectory.json`` hold, if they do; :class:`FileError` for damaged ones."""
    if not isinstance(data, dict) or not isinstance(data.get("limits"), dict):
        return None
    joints = data.get("joints")
    if not isinstance(joints, list):
        raise FileError(f"{where} names no joints, and limits are of joints: add their list 'joints'.")
    return _limits(validate(_Limits, data["limits"], where), tuple(map(str, joints)), where)


def _limits(limits: _Limits | None, joints: tuple[str, ...], where: str) -> MotionLimits | None:
    if limits is None:
        return None
    velocity, acceleration, jerk = (frozen(getattr(limits, kind)) for kind in KINDS)
    if {len(velocity), len(acceleration), len(jerk)} != {len(joints)} or not set(KINDS) <= set(limits.source):
        raise FileError(f"{where}: its limits are not one value for each joint, each with its source; mend the file.")
    return MotionLimits(joints, velocity, acceleration, jerk, limits.source)
