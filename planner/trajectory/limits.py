"""Limits on the velocity, acceleration and jerk of each joint, with their source."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen, plain_numbers
from planner.base.errors import FileError, OptionError, PlannerError, choices
from planner.base.files import StrPath
from planner.base.yamlfile import Number, Strict, parse_yaml, read_text, suggest_name, validate
from planner.problem.request import LimitsRequest
from planner.robot.robot import Robot

KINDS = ("velocity", "acceleration", "jerk")
LEAST_JERK = 15 / 8, 10 / np.sqrt(3), 60.0  # largest derivatives of 10 u³ - 15 u⁴ + 6 u⁵, quintics from rest to rest
USED = 0.999  # share of every limit that motions use; braking along the same curve may use all of it
UNITS = {"velocity": "/s", "acceleration": "/s²", "jerk": "/s³"}

ASSUMED_VELOCITY = 1.0  # rad/s, m/s
ASSUMED_ACCELERATION = 5.0  # rad/s², m/s²
ASSUMED_JERK_PER_ACCELERATION = 100.0  # 1/s: full acceleration is there 10 ms after none
_SMALLEST = 1e-6
_LARGEST = {"velocity": 1e4, "acceleration": 1e4, "jerk": 1e7}  # beyond any joint; rounding would dominate the times


class LimitError(PlannerError):
    """A motion limit that no motion can keep, or that exceeds the robot's."""


@dataclass(frozen=True, eq=False)
class MotionLimits:
    """Limits (dof,) on the absolute velocity, acceleration and jerk of each joint, in the robot's order.

    Units are rad (m for sliding joints) and s. ``source`` names the origin of each of the three.

        MotionLimits.from_robot(robot)                                          # of the URDF and the robot's file
        MotionLimits.from_robot(robot, LimitsRequest(velocity_scale=0.2))
    """

    joints: tuple[str, ...]
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    source: dict[str, str]

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", tuple(self.joints))
        object.__setattr__(self, "source", dict(self.source))
        if missing := [kind for kind in KINDS if kind not in self.source]:
            raise LimitError(f"source must name the origin of every limit, got none of {choices(missing)}: add it.")
        for kind in KINDS:
            values = frozen(plain_numbers(f"{kind} limits", getattr(self, kind), LimitError))
            _require_usable(self.joints, values, kind, self.source[kind])
            object.__setattr__(self, kind, values)

    @staticmethod
    def from_robot(robot: Robot, request: LimitsRequest | None = None) -> MotionLimits:
        """Return the robot's limits as changed by ``request``; velocities above the URDF's are refused.

        A limit that neither the URDF nor the robot's file gives is assumed, and its ``source`` begins with "assumed".
        The limit scales of a MoveIt request precede a file's default factors, and ``request`` precedes both. Raises
        :class:`LimitError` for limits of a file that no motion can keep, and for those above the robot's.
        """
        request = request or LimitsRequest()
        limits, scales = _robot_limits(robot), {}
        if request.limits is not None:
            limits, scales = _apply_file(limits, request.limits, robot)
        for kind in ("acceleration", "jerk"):
            value = getattr(request, kind)
            if value is not None:
                limits = _replace_limit(limits, kind, np.full(robot.dof, float(value)), f"--{kind} {value:g}")
        if request.acceleration is not None and request.jerk is None and "assumed" in limits.source["jerk"]:
            limits = _replace_limit(limits, "jerk", ASSUMED_JERK_PER_ACCELERATION * limits.acceleration, _jerk_source())
        for kind in ("velocity", "acceleration"):
            own, share = getattr(request, f"{kind}_scale"), robot.shares.get(kind)
            limits = _scale(limits, kind, scales.get(kind, 1.0) if share is None else share, own, share)
        _require_within_urdf(robot, limits)
        return limits

    def is_given(self, kind: str) -> bool:
        """Return whether this kind of limit comes from a file or an option; otherwise it is assumed."""
        if kind not in KINDS:
            raise OptionError(f"kind must be one of {choices(KINDS)}, got {kind!r}.")
        return not self.source[kind].startswith("assumed")

    @property
    def rows(self) -> Floats:
        """(3, dof), one row per kind."""
        return np.stack([self.velocity, self.acceleration, self.jerk])

    def scale_all(self, share: float) -> MotionLimits:
        """Return these limits times ``share``."""
        return replace(self, **{kind: frozen(share * getattr(self, kind)) for kind in KINDS})

    def to_dict(self) -> dict[str, Any]:
        """Return the limits with the keys of ``trajectory.json``."""
        return {kind: getattr(self, kind).tolist() for kind in KINDS} | {"source": dict(self.source)}

    def text(self, robot: Robot | None = None) -> str:
        """Return the limits in words; with a ``robot``, rad and m are separate."""
        units = {"rad (m)": slice(None)} if robot is None else {"rad": ~robot.prismatic, "m": robot.prismatic}
        ranges = {
            kind: [f"{_range(row[of])} {unit}{UNITS[kind]}" for unit, of in units.items() if row[of].size]
            for kind, row in zip(KINDS, self.rows, strict=True)
        }
        return "; ".join(f"{kind} up to {' and '.join(ranges[kind])} ({self.source[kind]})" for kind in KINDS)


def limits_or_default(limits: MotionLimits | None, robot: Robot) -> MotionLimits:
    """Return ``limits``, or the robot's own for None; :class:`OptionError` for those of other joints."""
    if limits is None:
        return MotionLimits.from_robot(robot)
    if limits.joints != robot.joints:
        raise OptionError(
            f"limits must be for joints {choices(robot.joints)}, got {choices(limits.joints)}: make them with "
            "planner.MotionLimits.from_robot(robot)."
        )
    return limits


def _range(values: Floats) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{high:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _replace_limit(limits: MotionLimits, kind: str, values: Floats, source: str) -> MotionLimits:
    return replace(limits, **{kind: frozen(values)}, source={**limits.source, kind: source})


def _scale(limits: MotionLimits, kind: str, scale: float, own: float | None, share: float | None) -> MotionLimits:
    """Return the limits times ``own``, or else ``scale``; the source names the ``share`` of a request."""
    scale = scale if own is None else own
    if not 0.0 < scale <= 1.0:
        raise LimitError(f"{kind} scale must be above 0 and at most 1, got {scale:g}: give a share of the limits.")
    instead = share is not None and share != scale
    if scale == 1.0 and not instead:
        return limits
    whose = (
        f" (in place of the request's {share:g})" if instead else " (the request's)" if own is None and share else ""
    )
    return _replace_limit(limits, kind, scale * getattr(limits, kind), f"{limits.source[kind]}, times {scale:g}{whose}")


def _robot_limits(robot: Robot) -> MotionLimits:
    if robot.parts:
        own = [_robot_limits(part) for part in robot.parts.values()]
        texts = [dict.fromkeys(each.source[kind] for each in own) for kind in KINDS]
        sources = [sorted(each, key=lambda text: not text.startswith("assumed")) for each in texts]
        rows = {kind: frozen(np.concatenate([getattr(each, kind) for each in own])) for kind in KINDS}
        return MotionLimits(robot.joints, **rows, source=dict(zip(KINDS, map("; ".join, sources), strict=True)))
    unknown = ~((robot.velocity > 0) & np.isfinite(robot.velocity))
    velocity, source_of_velocity = np.where(unknown, ASSUMED_VELOCITY, robot.velocity), "URDF"
    if unknown.any():
        of = "" if unknown.all() else f" for {choices(np.array(robot.joints)[unknown])}"
        source_of_velocity = f"assumed{of}: the URDF gives none"
    motion = robot.motion
    if motion is None:
        acceleration, source = np.full(robot.dof, ASSUMED_ACCELERATION), "assumed: the robot's file gives none"
    else:
        acceleration, source = _each_joint(robot, motion.acceleration), motion.source
    if motion is None or motion.jerk is None:
        jerk, source_of_jerk = ASSUMED_JERK_PER_ACCELERATION * acceleration, _jerk_source()
    else:
        jerk, source_of_jerk = _each_joint(robot, motion.jerk), motion.source
    return MotionLimits(
        robot.joints,
        frozen(velocity),
        frozen(acceleration),
        frozen(jerk),
        {"velocity": source_of_velocity, "acceleration": source, "jerk": source_of_jerk},
    )


def _jerk_source() -> str:
    return f"assumed: {ASSUMED_JERK_PER_ACCELERATION:g}/s times the acceleration"


def _each_joint(robot: Robot, values: float | list[float]) -> Floats:
    """Return one value per planned joint of a number for all, or of a list."""
    return np.full(robot.dof, float(values)) if isinstance(values, float | int) else np.array(values, dtype=float)


def _require_usable(joints: tuple[str, ...], values: Floats, kind: str, source: str) -> None:
    if np.shape(values) != (len(joints),):
        raise LimitError(
            f"{kind} limits must have shape ({len(joints)},), got {np.shape(values)}: give one for each of "
            f"{choices(joints)}."
        )
    bad = np.flatnonzero(~((values >= _SMALLEST) & (values <= _LARGEST[kind])))
    if len(bad):
        raise LimitError(
            f"{kind} limit of joint '{joints[bad[0]]}' must be from {_SMALLEST:g} to {_LARGEST[kind]:g}, got "
            f"{values[bad[0]]:g} ({source}): give another."
        )


def _require_within_urdf(robot: Robot, limits: MotionLimits) -> None:
    known = robot.velocity > 0
    beyond = np.flatnonzero(known & (limits.velocity > robot.velocity * (1 + 1e-9)))
    if len(beyond):
        k = beyond[0]
        raise LimitError(
            f"velocity limit of joint '{robot.joints[k]}' must be at most the URDF's {robot.velocity[k]:g}, got "
            f"{limits.velocity[k]:g} ({limits.source['velocity']}): give that or less."
        )


def require_within_robot(robot: Robot, limits: MotionLimits) -> None:
    """Raise :class:`LimitError` if ``limits`` of a file exceed the robot's.

    This applies to velocities above the URDF's, and to limits whose source is the robot but whose value is larger.
    """
    _require_within_urdf(robot, limits)
    own = _robot_limits(robot)
    for kind in ("velocity", "acceleration"):
        values, known = getattr(limits, kind), getattr(own, kind)
        beyond = np.flatnonzero(values > known * (1 + 1e-9))
        if len(beyond) and limits.source[kind] == own.source[kind]:
            k = beyond[0]
            raise LimitError(
                f"{kind} limit of joint '{robot.joints[k]}' must be the robot's {known[k]:g} ({own.source[kind]}), got "
                f"{values[k]:g}: mend the file, or give the limits as options."
            )


class _JointLimit(Strict):
    """One joint of a joint_limits.yaml of MoveIt and ros2_control; ``has_...: false`` disables a limit.

    Positions come from the URDF: narrower ones are refused. Efforts, gains and wider positions are ignored.
    """

    has_position_limits: bool = True
    min_position: Number | None = None
    max_position: Number | None = None
    has_soft_limits: bool = True
    soft_lower_limit: Number | None = None
    soft_upper_limit: Number | None = None
    k_position: Number | None = None
    k_velocity: Number | None = None
    has_velocity_limits: bool = True
    max_velocity: Number | None = None
    has_acceleration_limits: bool = True
    max_acceleration: Number | None = None
    has_deceleration_limits: bool = True
    max_deceleration: Number | None = None
    has_jerk_limits: bool = True
    max_jerk: Number | None = None
    has_effort_limits: bool = True
    max_effort: Number | None = None
    angle_wraparound: bool = False

    @pydantic.model_validator(mode="after")
    def _require_values(self) -> _JointLimit:
        """Raise if a limit is announced but missing."""
        rates = {kind: (f"max_{kind}",) for kind in ("velocity", "acceleration", "deceleration", "jerk")}
        bounds = {"position": ("min_position", "max_position"), "soft": ("soft_lower_limit", "soft_upper_limit")}
        for kind, values in (rates | bounds).items():
            missing = [value for value in values if getattr(self, value) is None]
            if f"has_{kind}_limits" in self.model_fields_set and self._has(kind) and missing:
                raise ValueError(f"has_{kind}_limits must come with {missing[0]}, got none; add it, or set it to false")
        return self

    def _has(self, kind: str) -> bool:
        return getattr(self, f"has_{kind}_limits")

    def value(self, kind: str) -> float | None:
        """Return the limit of a kind; joints brake as they accelerate, so the smaller of both limits counts."""
        largest = getattr(self, f"max_{kind}") if self._has(kind) else None
        if kind != "acceleration" or self.max_deceleration is None or not self._has("deceleration"):
            return largest
        return abs(self.max_deceleration) if largest is None else min(largest, abs(self.max_deceleration))

    def bounds(self) -> tuple[float, float]:
        """Return the lower and the upper position that the file allows."""
        lower, upper = [], []
        if self.has_position_limits:
            lower, upper = [self.min_position], [self.max_position]
        if self.has_soft_limits:
            lower, upper = [*lower, self.soft_lower_limit], [*upper, self.soft_upper_limit]
        return (
            max((value for value in lower if value is not None), default=-np.inf),
            min((value for value in upper if value is not None), default=np.inf),
        )

    def list_unused_entries(self, lower: float, upper: float) -> list[str]:
        """Return the entries without effect on motions of a joint within ``lower`` and ``upper``."""
        low, high = self.bounds()
        gains = self.has_soft_limits and (self.k_position is not None or self.k_velocity is not None)
        wider = -np.inf < low < lower - 1e-9 or upper + 1e-9 < high < np.inf
        present = {"efforts": self.max_effort is not None, "gains": gains, "wider positions": wider}
        present["angle_wraparound"] = self.angle_wraparound
        return [entry for entry, is_present in present.items() if is_present]


class _LimitsFile(Strict):
    joint_limits: dict[str, _JointLimit]
    default_velocity_scaling_factor: Number = 1.0
    default_acceleration_scaling_factor: Number = 1.0


def _apply_file(limits: MotionLimits, path: StrPath, robot: Robot) -> tuple[MotionLimits, dict[str, float]]:
    """Return the limits with those of a MoveIt joint_limits.yaml in their place, and its default scales."""
    where = f"joint limits {path}"
    path = Path(path)
    data = parse_yaml(read_text(path, "joint limits"), where)
    if isinstance(data, dict) and "joint_limits" not in data:
        raise FileError(f"{where}: key 'joint_limits' not found: give a MoveIt joint_limits.yaml.")
    file = validate(_LimitsFile, data, where)
    missing = [joint for joint in limits.joints if joint not in file.joint_limits]
    unknown = [joint for joint in file.joint_limits if joint not in robot.source.joints]
    if misspelt := [joint for joint in missing if len(missing) == len(limits.joints) or suggest_name(joint, unknown)]:
        raise LimitError(f"{where}: joint '{misspelt[0]}' not found; joints are {choices(file.joint_limits)}: add it.")
    file = file.model_copy(update={"joint_limits": dict.fromkeys(missing, _JointLimit()) | file.joint_limits})
    _require_positions_within(file, robot, where)
    spans = zip(robot.joints, robot.lower, robot.upper, strict=True)
    ignored = {entry: None for joint, *span in spans for entry in file.joint_limits[joint].list_unused_entries(*span)}
    note = f" ({choices(ignored)} ignored)" if ignored else ""
    note += f" (without {choices(missing)})" if missing else ""
    for kind in KINDS:
        values = [file.joint_limits[joint].value(kind) for joint in limits.joints]
        if any(value is not None for value in values):
            rest = f", the rest {limits.source[kind]}" if None in values else ""
            own = getattr(limits, kind)
            row = np.array([own[k] if value is None else value for k, value in enumerate(values)], dtype=float)
            limits = _replace_limit(limits, kind, row, f"{path.name}{note}{rest}")
    scales = {kind: getattr(file, f"default_{kind}_scaling_factor") for kind in ("velocity", "acceleration")}
    return limits, scales


def _require_positions_within(file: _LimitsFile, robot: Robot, where: str) -> None:
    """Raise :class:`LimitError` if the file allows fewer positions than planning uses."""
    for joint, lower, upper in zip(robot.joints, robot.lower, robot.upper, strict=True):
        low, high = file.joint_limits[joint].bounds()
        if low > lower + 1e-9 or high < upper - 1e-9:
            raise LimitError(
                f"{where}: positions of joint '{joint}' must include the robot's [{lower:g}, {upper:g}], got "
                f"[{max(low, lower):g}, {min(high, upper):g}]: narrow them in the URDF, which paths are planned with."
            )
