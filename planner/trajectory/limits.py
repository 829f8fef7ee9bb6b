"""How fast each joint may move, accelerate and jerk, and who says so."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen, plain_numbers
from planner.base.errors import FileError, OptionError, PlannerError, choices
from planner.base.files import StrPath
from planner.base.yamlfile import Number, Strict, nearest, parse_yaml, read_text, validate
from planner.problem.request import LimitsRequest
from planner.robot.robot import Robot

KINDS = ("velocity", "acceleration", "jerk")
LEAST_JERK = 15 / 8, 10 / np.sqrt(3), 60.0  # largest derivatives of 10 u³ - 15 u⁴ + 6 u⁵, quintics from rest to rest
USED = 0.999  # share of every limit that motions use, so that braking along the same curve can keep to all of it
UNITS = {"velocity": "/s", "acceleration": "/s²", "jerk": "/s³"}

ASSUMED_VELOCITY = 1.0  # rad/s, m/s
ASSUMED_ACCELERATION = 5.0  # rad/s², m/s²
ASSUMED_JERK_PER_ACCELERATION = 100.0  # 1/s: full acceleration is there 10 ms after none
_SMALLEST = 1e-6
_LARGEST = {"velocity": 1e4, "acceleration": 1e4, "jerk": 1e7}  # no joint comes near; times would drown in rounding


class LimitError(PlannerError):
    """A motion limit that no motion can keep, or that the robot does not allow."""


@dataclass(frozen=True, eq=False)
class MotionLimits:
    """Limits (dof,) on the absolute velocity, acceleration and jerk of each joint, in the robot's order of joints.

    Units are rad (m where a joint slides) and s. ``source`` says for each of the three where they come from.

        MotionLimits.from_robot(robot)                                          # the URDF's and the robot file's
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
            raise LimitError(f"source does not say where limits come from: add {choices(missing)}.")
        for kind in KINDS:
            values = frozen(plain_numbers(f"{kind} limits", getattr(self, kind), LimitError))
            _require_usable(self.joints, values, kind, self.source[kind])
            object.__setattr__(self, kind, values)

    @staticmethod
    def from_robot(robot: Robot, request: LimitsRequest | None = None) -> MotionLimits:
        """The robot's limits as ``request`` changes them; velocities beyond the URDF's are refused.

        Where the URDF or the robot's file says nothing a figure is assumed, and ``source`` says so. The shares that a
        MoveIt request asks of the robot come before a file's default factors, and after those of ``request``. Raises
        :class:`LimitError` for limits of a file that no motion can keep, and for those beyond the robot's.
        """
        request = request or LimitsRequest()
        limits, scales = _of_robot(robot), {}
        if request.limits is not None:
            limits, scales = _with_file(limits, request.limits, robot)
        for kind in ("acceleration", "jerk"):
            value = getattr(request, kind)
            if value is not None:
                limits = _with(limits, kind, np.full(robot.dof, float(value)), f"--{kind} {value:g}")
        if request.acceleration is not None and request.jerk is None and "assumed" in limits.source["jerk"]:
            limits = _with(limits, "jerk", ASSUMED_JERK_PER_ACCELERATION * limits.acceleration, _assumed_jerk())
        for kind in ("velocity", "acceleration"):
            asked, share = getattr(request, f"{kind}_scale"), robot.shares.get(kind)
            limits = _scaled(limits, kind, scales.get(kind, 1.0) if share is None else share, asked, share)
        _require_within_urdf(robot, limits)
        return limits

    def is_given(self, kind: str) -> bool:
        """Whether somebody gives a limit of this kind; else it is assumed for want of any."""
        if kind not in KINDS:
            raise OptionError(f"there is no {kind!r} limit: give one of {choices(KINDS)}.")
        return not self.source[kind].startswith("assumed")

    @property
    def rows(self) -> Floats:
        """(3, dof), one row of each of the ``KINDS``."""
        return np.stack([self.velocity, self.acceleration, self.jerk])

    def scale_all(self, share: float) -> MotionLimits:
        """A share of all of them."""
        return replace(self, **{kind: frozen(share * getattr(self, kind)) for kind in KINDS})

    def to_dict(self) -> dict[str, Any]:
        """The limits as ``trajectory.json`` has them."""
        return {kind: getattr(self, kind).tolist() for kind in KINDS} | {"source": dict(self.source)}

    def text(self, robot: Robot | None = None) -> str:
        """The limits in words, as they stand beside every duration: the ``robot`` says which joints slide (m)."""
        units = {"rad (m)": slice(None)} if robot is None else {"rad": ~robot.prismatic, "m": robot.prismatic}
        said = {
            kind: [f"{_range(row[of])} {unit}{UNITS[kind]}" for unit, of in units.items() if row[of].size]
            for kind, row in zip(KINDS, self.rows, strict=True)
        }
        return "; ".join(f"{kind} up to {' and '.join(said[kind])} ({self.source[kind]})" for kind in KINDS)


def limits_or_default(limits: MotionLimits | None, robot: Robot) -> MotionLimits:
    """The ``limits``, the robot's own where left out; :class:`OptionError` for those of other joints."""
    if limits is None:
        return MotionLimits.from_robot(robot)
    if limits.joints != robot.joints:
        raise OptionError(
            f"the limits are of joints {choices(limits.joints)}, the robot has {choices(robot.joints)}: make them with "
            "planner.MotionLimits.from_robot(robot)."
        )
    return limits


def _range(values: Floats) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{high:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _with(limits: MotionLimits, kind: str, values: Floats, source: str) -> MotionLimits:
    return replace(limits, **{kind: frozen(values)}, source={**limits.source, kind: source})


def _scaled(limits: MotionLimits, kind: str, scale: float, asked: float | None, share: float | None) -> MotionLimits:
    """The limits times ``asked``, else times ``scale``; the source says what became of the ``share`` of a request."""
    scale = scale if asked is None else asked
    if not 0.0 < scale <= 1.0:
        raise LimitError(f"{kind} scale must be above 0 and at most 1, got {scale:g}: give a share of the limits.")
    instead = share is not None and share != scale
    if scale == 1.0 and not instead:
        return limits
    whose = (
        f" (in place of the request's {share:g})" if instead else " (the request's)" if asked is None and share else ""
    )
    return _with(limits, kind, scale * getattr(limits, kind), f"{limits.source[kind]}, times {scale:g}{whose}")


def _of_robot(robot: Robot) -> MotionLimits:
    unknown = ~((robot.velocity > 0) & np.isfinite(robot.velocity))
    velocity, says = np.where(unknown, ASSUMED_VELOCITY, robot.velocity), "URDF"
    if unknown.any():
        of = "" if unknown.all() else f" for {choices(np.array(robot.joints)[unknown])}"
        says = f"assumed{of}: the URDF gives none"
    motion = robot.motion
    if motion is None:
        acceleration, source = np.full(robot.dof, ASSUMED_ACCELERATION), "assumed: the robot's file gives none"
    else:
        acceleration, source = _each_joint(robot, motion.acceleration), motion.source
    if motion is None or motion.jerk is None:
        jerk, of_jerk = ASSUMED_JERK_PER_ACCELERATION * acceleration, _assumed_jerk()
    else:
        jerk, of_jerk = _each_joint(robot, motion.jerk), motion.source
    return MotionLimits(
        robot.joints,
        frozen(velocity),
        frozen(acceleration),
        frozen(jerk),
        {"velocity": says, "acceleration": source, "jerk": of_jerk},
    )


def _assumed_jerk() -> str:
    return f"assumed: {ASSUMED_JERK_PER_ACCELERATION:g}/s times the acceleration"


def _each_joint(robot: Robot, values: float | list[float]) -> Floats:
    """One number for all planned joints, or one for each."""
    return np.full(robot.dof, float(values)) if isinstance(values, float | int) else np.array(values, dtype=float)


def _require_usable(joints: tuple[str, ...], values: Floats, kind: str, source: str) -> None:
    if np.shape(values) != (len(joints),):
        raise LimitError(f"{kind} limits have shape {np.shape(values)}: give one for each of {choices(joints)}.")
    bad = np.flatnonzero(~((values >= _SMALLEST) & (values <= _LARGEST[kind])))
    if len(bad):
        raise LimitError(
            f"{kind} limit {values[bad[0]]:g} of joint '{joints[bad[0]]}' ({source}) is not usable: "
            f"give a number above 0, from {_SMALLEST:g} to {_LARGEST[kind]:g}."
        )


def _require_within_urdf(robot: Robot, limits: MotionLimits) -> None:
    known = robot.velocity > 0
    beyond = np.flatnonzero(known & (limits.velocity > robot.velocity * (1 + 1e-9)))
    if len(beyond):
        k = beyond[0]
        raise LimitError(
            f"velocity limit {limits.velocity[k]:g} of joint '{robot.joints[k]}' ({limits.source['velocity']}) is "
            f"beyond the URDF's {robot.velocity[k]:g}: give that or less."
        )


def require_within_robot(robot: Robot, limits: MotionLimits) -> None:
    """Raise :class:`LimitError` where ``limits`` out of a file are wider than the robot allows.

    So are velocities beyond the URDF's, and what is said to be the robot's own and is larger.
    """
    _require_within_urdf(robot, limits)
    own = _of_robot(robot)
    for kind in ("velocity", "acceleration"):
        given, known = getattr(limits, kind), getattr(own, kind)
        beyond = np.flatnonzero(given > known * (1 + 1e-9))
        if len(beyond) and limits.source[kind] == own.source[kind]:
            k = beyond[0]
            raise LimitError(
                f"{kind} limit {given[k]:g} of joint '{robot.joints[k]}' is said to be the robot's "
                f"({own.source[kind]}), which is {known[k]:g}: mend the file, or say the limits as options."
            )


class _JointLimit(Strict):
    """One joint of a joint_limits.yaml, as MoveIt and ros2_control write it; limits count unless has_ is false.

    Positions are the URDF's: narrower ones are refused. Efforts, gains and wider positions are passed over.
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
    def _said(self) -> _JointLimit:
        """A limit that is announced is there."""
        of_kinds = {kind: (f"max_{kind}",) for kind in ("velocity", "acceleration", "deceleration", "jerk")}
        of_places = {"position": ("min_position", "max_position"), "soft": ("soft_lower_limit", "soft_upper_limit")}
        for kind, values in (of_kinds | of_places).items():
            missing = [value for value in values if getattr(self, value) is None]
            if f"has_{kind}_limits" in self.model_fields_set and self._given(kind) and missing:
                raise ValueError(f"it has_{kind}_limits and no {missing[0]}; add it, or say false")
        return self

    def _given(self, kind: str) -> bool:
        return getattr(self, f"has_{kind}_limits")

    def value(self, kind: str) -> float | None:
        """A joint brakes as it speeds up here: of acceleration and deceleration the smaller one counts."""
        found = getattr(self, f"max_{kind}") if self._given(kind) else None
        if kind != "acceleration" or self.max_deceleration is None or not self._given("deceleration"):
            return found
        return abs(self.max_deceleration) if found is None else min(found, abs(self.max_deceleration))

    def bounds(self) -> tuple[float, float]:
        """The positions that the file allows."""
        lower, upper = [], []
        if self.has_position_limits:
            lower, upper = [self.min_position], [self.max_position]
        if self.has_soft_limits:
            lower, upper = [*lower, self.soft_lower_limit], [*upper, self.soft_upper_limit]
        return (
            max((value for value in lower if value is not None), default=-np.inf),
            min((value for value in upper if value is not None), default=np.inf),
        )

    def passed_over(self, lower: float, upper: float) -> list[str]:
        """What it says that no motion of a joint within ``lower`` and ``upper`` follows."""
        low, high = self.bounds()
        gains = self.has_soft_limits and (self.k_position is not None or self.k_velocity is not None)
        wider = -np.inf < low < lower - 1e-9 or upper + 1e-9 < high < np.inf
        said = {"efforts": self.max_effort is not None, "gains": gains, "wider positions": wider}
        return [what for what, so in {**said, "angle_wraparound": self.angle_wraparound}.items() if so]


class _LimitsFile(Strict):
    joint_limits: dict[str, _JointLimit]
    default_velocity_scaling_factor: Number = 1.0
    default_acceleration_scaling_factor: Number = 1.0


def _with_file(limits: MotionLimits, path: StrPath, robot: Robot) -> tuple[MotionLimits, dict[str, float]]:
    """The limits with those of a MoveIt joint_limits.yaml in their place, and its default scaling factors."""
    where = f"joint limits {path}"
    path = Path(path)
    data = parse_yaml(read_text(path, "joint limits"), where)
    if isinstance(data, dict) and "joint_limits" not in data:
        raise FileError(f"{where} has no key 'joint_limits': give a MoveIt joint_limits.yaml.")
    file = validate(_LimitsFile, data, where)
    missing = [joint for joint in limits.joints if joint not in file.joint_limits]
    unknown = [joint for joint in file.joint_limits if joint not in robot.source.joints]
    if misspelt := [joint for joint in missing if len(missing) == len(limits.joints) or nearest(joint, unknown)]:
        raise LimitError(f"{where} has no joint '{misspelt[0]}'; it has {choices(file.joint_limits)}: add it.")
    file = file.model_copy(update={"joint_limits": dict.fromkeys(missing, _JointLimit()) | file.joint_limits})
    _require_positions_within(file, robot, where)
    spans = zip(robot.joints, robot.lower, robot.upper, strict=True)
    passed = {what: None for joint, *span in spans for what in file.joint_limits[joint].passed_over(*span)}
    told = f" (of it {choices(passed)} are passed over)" if passed else ""
    told += f" (it names no {choices(missing)})" if missing else ""
    for kind in KINDS:
        found = [file.joint_limits[joint].value(kind) for joint in limits.joints]
        if any(value is not None for value in found):
            own = getattr(limits, kind)
            values = np.array([own[k] if value is None else value for k, value in enumerate(found)], dtype=float)
            partly = "" if all(value is not None for value in found) else f", the rest {limits.source[kind]}"
            limits = _with(limits, kind, values, f"{path.name}{told}{partly}")
    scales = {kind: getattr(file, f"default_{kind}_scaling_factor") for kind in ("velocity", "acceleration")}
    return limits, scales


def _require_positions_within(file: _LimitsFile, robot: Robot, where: str) -> None:
    """Raise where the file allows fewer positions than the path was planned in."""
    for joint, lower, upper in zip(robot.joints, robot.lower, robot.upper, strict=True):
        low, high = file.joint_limits[joint].bounds()
        if low > lower + 1e-9 or high < upper - 1e-9:
            raise LimitError(
                f"{where} allows joint '{joint}' positions from {max(low, lower):g} to {min(high, upper):g}, narrower "
                f"than the robot's [{lower:g}, {upper:g}]: narrow them in the URDF, which is what paths are planned in."
            )
