"""What can be asked of the planner: parts that hold each option once, and the requests that are composed of them.

A part has an option's default, its help and what is refused of it; commands, sessions, batches and benchmarks embed the
parts that they need.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, fields
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias, get_args

from planner.base.errors import OptionError, PlannerError, choices, require_number
from planner.base.files import StrPath
from planner.base.shares import require_share
from planner.problem.conditions import Condition, keeps_text
from planner.problem.objective import (
    DEFAULT_BETA,
    DEFAULT_CHARGE,
    DEFAULT_COST,
    DEFAULT_METRIC,
    Charge,
    ManipulabilityCost,
    Metric,
    Objective,
    require_floor,
)
from planner.problem.targets import ToolGoal, parse_base, parse_target, parse_targets, state_text


class Named(Protocol):
    """A robot or a scene itself, in place of its name."""

    @property
    def name(self) -> str: ...


if TYPE_CHECKING:
    Thing: TypeAlias = StrPath | Named
    File: TypeAlias = StrPath
    State: TypeAlias = str | Iterable[float] | ToolGoal
    Names: TypeAlias = str | Iterable[str]
    Kept: TypeAlias = str | Condition | Iterable[str | Condition]
else:  # what the command line gives; from Python a robot, a scene, joint values and lists of names will do as well
    Thing = State = Names = Kept = str
    File = Path

LawName = Literal["nominal", "prescribed-time", "fixed-time", "singularity-free"]
Backend = Literal["fcl", "coal"]
TimeLaw = Literal["shortcuts", "blended", "stop-at-corners"]
DEFAULT_TIME_LAW: TimeLaw = "shortcuts"

PAPER_NODES, PAPER_EDGES = 1012, 2029  # section 4.2
DEFAULT_EFFORT = 12  # rounds
DEFAULT_ROOM = 5e-3  # m
IK_LEAST, IK_LARGEST = 1e-6, (0.1, 0.5)  # m or rad; m, rad: of a tolerance for poses


@dataclass(frozen=True)
class Part:
    """What all parts are: their values are judged as they are made, part by part."""

    def __post_init__(self) -> None:
        """Paths of a robot or a scene become text, all others paths; :class:`FileError` for what is neither."""
        for name in ("robot", "scene"):
            value = getattr(self, name, None)
            if isinstance(value, PathLike):
                object.__setattr__(self, name, os.fspath(value))
        for name in ("srdf", "motion_plan_request", "roadmap", "limits"):
            value = getattr(self, name, None)
            if value is not None:
                object.__setattr__(self, name, Path(value))

    def to_dict(self) -> dict[str, Any]:
        """The options by their names on the command line, as plain data: objects by their names, paths as text."""
        values = {field.name: _plain(getattr(self, field.name)) for field in fields(self)}
        return {"request" if name == "motion_plan_request" else name: value for name, value in values.items()}


@dataclass(frozen=True)
class KeptWorld(Part):
    """A robot in a scene, and how contacts are found; what is left out is a kept roadmap's own."""

    robot: Thing | None = None
    """Name of a built-in robot, or the path of a URDF or robot.yaml; the file's own if that is a built-in one."""
    scene: Thing | None = None
    """Name of a built-in scene or the path of a scene file; the file's own if that is a built-in one."""
    tool: str | None = None
    """Frame of the robot that targets and manipulability speak of; where left out the scene's, else the robot's, else
    the tip of --group, or of the group that --request names; of a kept roadmap its own."""
    srdf: File | None = None
    """An SRDF in place of the robot's own: link pairs that need no check, groups, named states."""
    group: str | None = None
    """Planning group of the SRDF: only its joints are planned."""
    joints: Names | None = None
    """Joints to plan, with commas between; all others are held: at fixed_joints of the scene or robot file, else as the
    state home has them."""
    collision: Backend = "fcl"
    """Collision library that checks every node, start, goal and answer: FCL, or coal, which is faster on meshes. Own
    separating planes prove the edges, and coal looks at every answer too."""
    margin: float | None = None
    """Distance in metres to keep from every obstacle, and between links; the file's own where left out."""
    keep: Kept | None = None
    """What motions keep all along, proven; repeatable, or with ';' between: axis:z,0,0,1,0.1 (the tool's z axis within
    0.1 rad of the world's direction 0,0,1), box:x0,y0,z0,x1,y1,z1 (its origin within, m), plane:nx,ny,nz,d
    (n.p >= d), turn:0.1 (its orientation within 0.1 rad of that at the start); ' of FRAME' at the end names another
    frame than the tool. What the scene keeps is kept besides."""
    base: str | None = None
    """Where the robot's base stands in the scene, in place of what the scene file says: x,y,z (m) or
    x,y,z,roll,pitch,yaw (m and rad)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.margin is not None:
            require_margin(self.margin)
        if self.base is not None:
            parse_base(self.base)
        if self.keep is not None:
            object.__setattr__(self, "keep", keeps_text(self.keep) or None)
        if self.joints is not None:
            object.__setattr__(self, "joints", names_text(self.joints))
        require_one_choice(self.group, self.joints)


@dataclass(frozen=True)
class WorldRequest(KeptWorld):
    """A robot in a scene, and how contacts are found."""

    robot: Thing = "iiwa14"
    """Name of a built-in robot (see 'planner robots') or of one in the package robot_descriptions, or the path of a
    URDF, xacro, MJCF or robot.yaml ('planner robot-yaml' writes one)."""
    scene: Thing = "paper"
    """Name of a built-in scene (see 'planner scenes') or the path of a scene file."""
    margin: float = 0.0
    """Distance in metres to keep from every obstacle, and between links."""

    @property
    def joint_names(self) -> tuple[str, ...] | None:
        """``joints`` by name; None where nobody has chosen."""
        return None if self.joints is None else tuple(str(self.joints).split(","))


@dataclass(frozen=True)
class Ends(Part):
    """Where a path begins and ends."""

    start: State = "start"
    """Where the arm starts."""
    goal: State = "goal"
    """Where the arm should go; several, with the option repeated or with ';' between them, are alternatives."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for role, parse in (("start", parse_target), ("goal", parse_targets)):
            value = getattr(self, role)
            object.__setattr__(self, role, state_text(value, role))
            parse(getattr(self, role))


@dataclass(frozen=True)
class Message(Part):
    """What another program asks for."""

    motion_plan_request: File | None = None
    """A MoveIt MotionPlanRequest (YAML) to take start, goal and the joints that are not planned from."""


@dataclass(frozen=True)
class IkSolutions(Part):
    """How many configurations bring the tool to one place, and how exactly."""

    ik_solutions: int = 8
    """Configurations that a position or pose as goal becomes at most: the best by manipulability and the nearest to the
    start, in turn; the dynamics picks one."""
    ik_tolerance: str = "1e-6,1e-4"
    """How far (m,rad) the tool may be off a pose that the arm cannot reach exactly, as with fewer than six axes."""

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.tolerance
        if not 1 <= self.ik_solutions <= 100:
            raise OptionError(f"{self.ik_solutions} IK solutions are not usable: give a whole number from 1 to 100.")

    @property
    def tolerance(self) -> tuple[float, float]:
        """``ik_tolerance`` in m and rad."""
        try:
            metres, radians = map(float, self.ik_tolerance.split(","))
        except ValueError:
            metres = radians = math.nan
        if not (IK_LEAST <= metres <= IK_LARGEST[0] and IK_LEAST <= radians <= IK_LARGEST[1]):
            raise OptionError(
                f"ik tolerance must be metres and radians from {IK_LEAST:g} to {IK_LARGEST[0]:g} m and "
                f"{IK_LARGEST[1]:g} rad, got '{self.ik_tolerance[:100]}': give them as 1e-6,1e-4."
            )
        return metres, radians


@dataclass(frozen=True)
class Targets(IkSolutions, Message, Ends):
    """What start and goal become."""

    widen_limits: bool = False
    """Widen joint limits that a start or goal given in joints exceeds, instead of refusing it."""


@dataclass(frozen=True)
class Growth(Part):
    """How a roadmap is grown."""

    nodes: int = PAPER_NODES
    """Configurations in the roadmap; more find better paths and take longer."""
    seed: int = 0
    """Seed of all randomness: the same command, seed and versions give the same path on x86-64 processors with FMA."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_nodes(self.nodes)
        require_seed(self.seed)


@dataclass(frozen=True)
class KeptRoadmap(Part):
    """A roadmap that is there."""

    roadmap: File | None = None
    """A roadmap.npz to plan on, instead of growing one: of the same robot and scene; on the live page of the same
    joints, and what does not hold in the scene is left out."""


@dataclass(frozen=True)
class TradeOff(Part):
    """Which of the two costs counts how much."""

    beta: float = DEFAULT_BETA
    """Trade-off in [0, 1]: 0 optimises manipulability only, 1 distance only."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_share(self.beta)


@dataclass(frozen=True)
class LiveRequest(KeptRoadmap, Growth, TradeOff, Ends):
    """What the live page asks of the planner when it opens."""


# the parts stand last first: their options come in the order of the bases from the last to the first


@dataclass(frozen=True)
class RoadmapRequest(Growth, Targets, WorldRequest):
    """A roadmap around a start and a goal.

    Each is a name from the scene file, home, q:0.1,-0.4,... (joints, rad), xyz:0.92,-0.10,0.42 (tool position, m)
    or pose:x,y,z,qx,qy,qz,qw; with tolerance, conditions as --keep has them, with & between.
    """

    min_manipulability: float = 0.0
    """A floor under manipulability w, 0 for none: once reached, paths stay above it until the last stretch to a goal
    below it. Where start and goal lie below, a path may stay there, no lower than they are. Growth keeps above too."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_floor(self.min_manipulability)


@dataclass(frozen=True)
class CostField(Part):
    """What costs are, and the dynamics whose field they become."""

    law: LawName = "singularity-free"
    """Control law under which the dynamics runs."""
    prescribed_time: float = 4.0
    """T_p in seconds: the field settles before it (laws without a prescribed time ignore it)."""
    metric: Metric = DEFAULT_METRIC
    """What distance means: joint motion (rad), or the length of the tool's path in the workspace (m)."""
    manipulability_cost: ManipulabilityCost = DEFAULT_COST
    """How the cost of a configuration falls with its manipulability w: 1/w, -ln w or -w, normalised."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 1e-9 <= self.prescribed_time <= 1e9:
            raise OptionError(
                f"prescribed time {self.prescribed_time:g} s is not usable: give a positive number up to 1e9."
            )


@dataclass(frozen=True)
class SweepRequest(CostField, KeptRoadmap, RoadmapRequest):
    """A roadmap and what its costs and its dynamics are, for every beta."""

    charge: Charge = DEFAULT_CHARGE
    """Where that cost is charged: integrated along edges, where singularities hide, or at nodes, as the paper does."""
    effort: int | None = None
    """Rounds in which the best path is refined and others searched, fewer where two thirds gain nothing; left out,
    12, or 0 with --roadmap: as it is."""
    room: float = DEFAULT_ROOM
    """Clearance in metres beyond --margin that refined paths and shortcuts in time keep; half of it, a quarter and so
    on where start, goal or the narrowest passage leave no more. 0 for none."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.effort is not None and not 0 <= self.effort <= 1_000_000:
            raise OptionError(f"effort {self.effort} is not usable: give a whole number from 0 to 1000000.")
        require_margin(self.room, "room")

    @property
    def rounds(self) -> int:
        """The effort, or what stands for it where it was left out."""
        if self.effort is not None:
            return self.effort
        return DEFAULT_EFFORT if self.roadmap is None else 0

    def objective_at(self, beta: float) -> Objective:
        """What a path at ``beta`` is to be good for."""
        return Objective(beta, self.manipulability_cost, self.metric, self.charge, self.min_manipulability)


@dataclass(frozen=True)
class PlanRequest(TradeOff, SweepRequest):
    """One plan. With no options this is the paper's scenario: a KUKA LBR iiwa 14 among obstacles."""

    approach: float = 0.0
    """Metres that the tool goes straight along its z axis into the goal, proven within 1 mm and 0.5 degrees."""
    retreat: float = 0.0
    """Metres that it first goes straight back along its z axis from the start."""
    path_only: bool = False
    """Only a path, the first that is proven, after shortcuts: no roadmap grows around it, so beta has next to nothing
    to choose from, and it is refined only where --effort is given."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("approach", "retreat"):
            length = getattr(self, name)
            require_number(name, length)
            if length != 0 and not 1e-3 <= length <= 1.0:
                raise OptionError(f"{name} {length:g} m is not usable: give one from 0.001 to 1, or 0 for none.")
        if self.path_only and (self.nodes != PAPER_NODES or self.roadmap is not None):
            raise OptionError("a path only has no roadmap around it: leave out nodes and roadmap, or path-only.")

    @property
    def objective(self) -> Objective:
        """What the path is to be good for."""
        return self.objective_at(self.beta)

    @property
    def rounds(self) -> int:
        """As without ``path_only``, but none where the effort was left out."""
        return 0 if self.path_only and self.effort is None else super().rounds


@dataclass(frozen=True)
class TaskRequest(CostField, IkSolutions, TradeOff, Growth):
    """How a task is planned; what is to be done stands in its file."""

    nodes: int = 500
    """Configurations in the roadmap, which all modes share; more find better paths and take longer."""
    ik_solutions: int = 4
    """Configurations of the arm for every grasp and every placement at most."""
    collision: Backend = "fcl"
    """Collision library that checks nodes and answers: FCL, or coal."""
    margin: float = 0.0
    """Distance in metres to keep from every obstacle, and between links."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_margin(self.margin)

    @property
    def objective(self) -> Objective:
        """What the path is to be good for."""
        return Objective(self.beta, self.manipulability_cost, self.metric)


ON_TOOL_PATH = "tool-path"


@dataclass(frozen=True)
class FollowRequest(PlanRequest):
    """A tool path to be followed, and a free motion to it where there is a start."""

    start: State = ON_TOOL_PATH
    """Where the arm starts: a free motion leads from there to the tool path. Left out, the plan begins on it."""
    goal: State = ON_TOOL_PATH
    """The end of the tool path: no other goal can be given."""
    tool_speed: float | None = None
    """Speed of the tool along the path, m/s: at most so much, and just that where the joints' limits allow it."""
    ladder_density: int = 1
    """How many times as many solutions of inverse kinematics are spread along the path: more find better ways."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.goal != ON_TOOL_PATH:
            raise OptionError("a tool path is followed to its end: leave --goal out.")
        plain = PlanRequest()
        of_goals = ("motion_plan_request", "widen_limits", "ik_solutions", "approach", "retreat")
        of_free = ("roadmap", "path_only", "nodes", "effort", "room", "ik_tolerance")
        of_free = of_free if self.begins_on_path else ()
        for names, remedy in ((of_goals, "leave it out"), (of_free, "give a start, or leave it out")):
            for name in names:
                if getattr(self, name) != getattr(plain, name):
                    option = "request" if name == "motion_plan_request" else name.replace("_", "-")
                    raise OptionError(f"--{option} says nothing to a tool path: {remedy}.")
        if self.tool_speed is not None:
            require_number("tool speed", self.tool_speed)
            if not 1e-5 <= self.tool_speed <= 10.0:
                raise OptionError(f"tool speed {self.tool_speed:g} m/s is not usable: give one from 1e-5 to 10.")
        if not 1 <= self.ladder_density <= 100:
            raise OptionError(f"ladder density {self.ladder_density} is not usable: give a whole number from 1 to 100.")

    @property
    def begins_on_path(self) -> bool:
        """Whether there is no free motion to the tool path."""
        return self.start == ON_TOOL_PATH


@dataclass(frozen=True)
class LimitsRequest(Part):
    """The limits that a motion has to keep; whether the robot allows them is judged with the robot."""

    limits: File | None = None
    """A MoveIt joint_limits.yaml with velocities, accelerations and jerks of the joints."""
    velocity_scale: float | None = None
    """Share of the velocity limits to use, above 0 up to 1."""
    acceleration_scale: float | None = None
    """Share of the acceleration limits to use, above 0 up to 1."""
    acceleration: float | None = None
    """Acceleration limit of every joint, rad/s² (m/s² where a joint slides), in place of the robot's own."""
    jerk: float | None = None
    """Jerk limit of every joint, rad/s³ (m/s³), in place of the robot's own."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, scale in (("velocity", self.velocity_scale), ("acceleration", self.acceleration_scale)):
            if scale is not None:
                require_scale(name, scale)
        for name, limit in (("acceleration", self.acceleration), ("jerk", self.jerk)):
            if limit is None:
                continue
            require_number(f"{name} limit", limit)
            if not 0.0 < limit < math.inf:
                raise OptionError(f"{name} limit {limit:g} is not usable: give a number above 0.")


@dataclass(frozen=True)
class TimingRequest(LimitsRequest):
    """How a path becomes a motion."""

    time_law: TimeLaw = DEFAULT_TIME_LAW
    """Corners rounded as far as that is proven free, with proven shortcuts in time or without; or a stop at each."""
    extra_cost: float = 0.0
    """Share by which shortcuts in time may raise what the path costs (its objective): more is quicker."""

    def __post_init__(self) -> None:
        super().__post_init__()
        require_timing(self.time_law, 0.0, self.extra_cost)


@dataclass(frozen=True)
class WorkersRequest:
    """The workers of independent tasks. The results do not depend on them, but for their seconds."""

    jobs: int = 1
    """Tasks at once, each in a process of this machine; 1 is one task after the other in this process."""
    workers: str | None = None
    """Instead of jobs, the workers of a Dask cluster: dask: and the address of its scheduler, as in
    dask:tcp://127.0.0.1:8786."""

    def __post_init__(self) -> None:
        if not 1 <= self.jobs <= 10_000:
            raise OptionError(f"jobs must be a whole number from 1 to 10000, got {self.jobs}.")
        if self.workers is not None and not (self.workers.startswith("dask:") and self.jobs == 1):
            raise OptionError(f"workers must be dask:ADDRESS without --jobs, got '{self.workers}'.")

    @property
    def serial(self) -> bool:
        """Whether this process does one task after the other."""
        return self.workers is None and self.jobs == 1


SERIAL = WorkersRequest()


def _plain(value: Any) -> Any:
    if isinstance(value, Path):
        return str(value)
    return value if isinstance(value, str | int | float | None) else value.name


def names_text(names: str | Iterable[str]) -> str:
    """Names as one text with commas between; :class:`OptionError` where one is missing or stands there twice."""
    given = names.split(",") if isinstance(names, str) else list(names) if isinstance(names, Iterable) else [names]
    if not all(isinstance(name, str) for name in given):
        raise OptionError(f"joints {str(given)[:200]} are not usable: give their names, as text.")
    found = [name.strip() for name in given]
    if not all(found) or len(set(found)) < len(found):
        raise OptionError(f"joints '{','.join(found)[:200]}' are not usable: name each once, with commas between.")
    return ",".join(found)


def require_one_choice(group: str | None, joints: object) -> None:
    """Raise :class:`OptionError` where both a group and joints say what is planned."""
    if group is not None and joints is not None:
        raise OptionError("--group and --joints both say which joints are planned: give one of them.")


def require_scale(kind: str, scale: float, error: type[PlannerError] = OptionError) -> None:
    """Raise an ``error`` unless a share of limits of that ``kind`` lies above 0 and is at most 1."""
    require_number(f"{kind} scale", scale)
    if not 0.0 < scale <= 1.0:
        raise error(f"{kind} scale {scale:g} is not usable: give a share of the limits, above 0 up to 1.")


def require_timing(law: str, floor: float, extra_cost: float) -> None:
    """Raise :class:`OptionError` unless a path can become a motion by these."""
    require_number("floor", floor)
    require_number("extra cost", extra_cost)
    if law not in get_args(TimeLaw):
        raise OptionError(f"time law '{law}' not found; laws are {choices(get_args(TimeLaw))}.")
    if not 0.0 <= floor < math.inf:
        raise OptionError(f"floor {floor:g} is not usable: give a manipulability of 0 or more.")
    if not 0.0 <= extra_cost <= 100.0:
        raise OptionError(f"extra cost {extra_cost:g} is not usable: give a share of 0 or more, 100 at most.")


def require_nodes(nodes: int) -> None:
    """Raise :class:`OptionError` unless a roadmap of so many nodes makes sense."""
    require_number("nodes", nodes, Integral)
    if not 2 <= nodes <= 10_000_000:
        raise OptionError(
            f"{nodes} nodes make no roadmap: give a whole number from 2 to 10000000; "
            "'planner plan --path-only' needs none."
        )


def require_seed(seed: int) -> None:
    """Raise :class:`OptionError` unless a seed fits every generator."""
    require_number("seed", seed, Integral)
    if not 0 <= seed < 2**31:
        raise OptionError(f"seed {seed} is not usable: give a whole number from 0 to 2147483647.")


def require_margin(margin: float, name: str = "margin") -> None:
    """Raise :class:`OptionError` unless a margin (m), or what else has that ``name``, is a distance."""
    require_number(name, margin)
    if not 0.0 <= margin <= 100.0:
        raise OptionError(f"{name} {margin:g} m is not usable: give a distance of 0 or more, 100 at most.")
