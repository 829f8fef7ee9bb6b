"""Every option of the planner: its type, its range and its help, once. Requests are composed of these."""

import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, TypeAlias, runtime_checkable

from pydantic import AfterValidator, BeforeValidator, Field
from typing_extensions import Doc

from planner.base.errors import OptionError
from planner.problem.conditions import Condition, read_conditions
from planner.problem.targets import FARTHEST_BASE, Target, parse_base, read_goals, read_target
from planner.problem.validation import options as options


@runtime_checkable
class HasName(Protocol):
    """A robot or a scene itself, in place of its name."""

    @property
    def name(self) -> str: ...


def _name_or_object(value: object) -> object:
    return os.fspath(value) if isinstance(value, os.PathLike) else value


EMPTY, AS_PLANNED = "empty", ""  # the built-in scene that None stands for; that of the plan.json next to a file

RobotLike: TypeAlias = str | HasName
"""The name or the file of a robot or scene, or the object itself."""
SceneLike: TypeAlias = RobotLike | None
"""The same of a scene, or None for an empty one."""


class LeftOut(str):
    """The default of a public function's robot or scene: where it was left out, ``request=`` names one."""


ROBOT, SCENE = LeftOut("iiwa14"), LeftOut("paper")
Base: TypeAlias = tuple[float, ...]
"""x, y, z (m) or x, y, z, roll, pitch, yaw (m and rad)."""
Names: TypeAlias = tuple[str, ...]
Conditions: TypeAlias = tuple[Condition, ...]
Targets: TypeAlias = tuple[Target, ...]


class Tolerance(tuple[float, float]):
    """Metres and radians."""


class Area(tuple[float, float, float, float]):
    """x0, y0, x1, y1 in metres."""


Backend = Literal["fcl", "coal"]
LawName = Literal["nominal", "prescribed-time", "fixed-time", "singularity-free"]
Metric = Literal["joint", "workspace"]
CostIntegration = Literal["nodes", "edges"]
ManipulabilityCost = Literal["inverse", "log", "linear"]
Rows = Literal["pose", "translation", "rotation", "planar"]
MeasureName = Literal["yoshikawa", "inverse-condition", "min-singular-value", "joint-limits"]
TimeLaw = Literal["shortcuts", "blended", "stop-at-corners"]

Measure: TypeAlias = MeasureName | Callable[..., Any]
"""The name of a measure, or a function from configurations (n, dof) to values (n,) from 0 up, larger being better."""

PAPER_NODES, PAPER_EDGES = 1012, 2029  # section 4.2
IK_LEAST, IK_LARGEST = 1e-6, (0.1, 0.5)  # m or rad; m, rad: of a tolerance for poses


def _names(value: object) -> Names | None:
    """Names out of text with commas between, or out of a list."""
    if value is None:
        return None
    names = value.split(",") if isinstance(value, str) else list(value) if isinstance(value, Iterable) else [value]
    stripped = tuple(name.strip() if isinstance(name, str) else "" for name in names)
    if not all(stripped) or len(set(stripped)) < len(stripped):
        raise OptionError(f"joints must be different names, got '{str(value)[:200]}': name each once.")
    return stripped


def _tolerance(value: object) -> Tolerance:
    try:
        words = value.split(",") if isinstance(value, str) else value
        metres, radians = map(float, words)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        metres = radians = math.nan
    if not (IK_LEAST <= metres <= IK_LARGEST[0] and IK_LEAST <= radians <= IK_LARGEST[1]):
        raise OptionError(
            f"ik tolerance must be metres and radians from {IK_LEAST:g} to {IK_LARGEST[0]:g} m and "
            f"{IK_LARGEST[1]:g} rad, got '{str(value)[:100]}': give them as 1e-6,1e-4."
        )
    return Tolerance((metres, radians))


def _area(value: object) -> Area:
    try:
        words = value.split(",") if isinstance(value, str) else value
        x0, y0, x1, y1 = map(float, words)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        x0 = y0 = x1 = y1 = math.nan
    if not (-FARTHEST_BASE <= x0 < x1 <= FARTHEST_BASE and -FARTHEST_BASE <= y0 < y1 <= FARTHEST_BASE):
        text = f"base limits must be x0,y0,x1,y1 (m), the lesser corner first, got '{str(value)[:100]}'"
        raise OptionError(f"{text}: give them as -2,-1,2,1.")
    return Area((x0, y0, x1, y1))


def _number(value: object) -> object:
    if isinstance(value, bool):  # Python takes it for 0 or 1
        raise ValueError("must be a number")
    return value


def _leg(length: float) -> float:
    if length != 0 and not 1e-3 <= length <= 1.0:
        raise ValueError("must be from 0.001 to 1 m, or 0 for none")
    return length


def _start(value: object) -> Target:
    return read_target(value, "start")


def _unless_none(read: Callable[[Any], object]) -> BeforeValidator:
    return BeforeValidator(lambda value: None if value is None else read(value))


Real: TypeAlias = Annotated[float, BeforeValidator(_number)]
Integer: TypeAlias = Annotated[int, BeforeValidator(_number)]
Share: TypeAlias = Annotated[Real, Field(gt=0, le=1)]
Positive: TypeAlias = Annotated[Real, Field(gt=0)]
_Like = Annotated[RobotLike, BeforeValidator(_name_or_object)]
_Margin = Annotated[Real, Field(ge=0, le=100)]
_EMPTY = BeforeValidator(lambda value: EMPTY if value is None else value)

# the world
_ROBOT = "Built-in robot ('planner robots'), one of robot_descriptions, or a URDF, xacro, MJCF or robot.yaml"
_SCENE = "Built-in scene ('planner scenes') or the path of a scene file"
_MARGIN = "Distance in metres to keep from every obstacle, and between links"
_RECORDED = "left out, that of the plan.json next to the file"
Robot = Annotated[_Like, Doc(f"{_ROBOT} ('planner robot-yaml' writes one).")]
Scene = Annotated[_Like, _EMPTY, Doc(f"{_SCENE}.")]
Margin = Annotated[_Margin, Doc(f"{_MARGIN}.")]
RecordedRobot = Annotated[_Like | None, Doc(f"{_ROBOT}; {_RECORDED}, else iiwa14.")]
RecordedScene = Annotated[_Like | None, Doc(f"{_SCENE}; {_RECORDED}, else paper.")]
RecordedMargin = Annotated[_Margin | None, Doc(f"{_MARGIN}; {_RECORDED}, else 0.")]
Cell = Annotated[
    _Like | None,
    Doc("File of a cell: several robots in one scene, in place of robot and scene; states are then ROBOT:STATE."),
]
Tool = Annotated[
    str | None,
    BeforeValidator(lambda value: ",".join(value) if isinstance(value, tuple | list) else value),
    Doc(
        "Frame of targets and manipulability; left out the scene's, the robot's, or the tip of its group. Several, "
        "with commas between, are the tools of several arms, the main one first: the least w of any of them counts."
    ),
]
Srdf = Annotated[Path | None, Doc("An SRDF in place of the robot's own: pairs without a check, groups, named states.")]
Group = Annotated[str | None, Doc("Planning group of the SRDF: only its joints are planned.")]
Joints = Annotated[
    Names | None,
    BeforeValidator(_names),
    Doc("Joints to plan, with commas between; others are held at fixed_joints of scene or robot, else as at home."),
]
Placement = Annotated[
    Base | None,
    _unless_none(parse_base),
    Doc("Where the robot's base stands in place of the scene's: x,y,z (m) or x,y,z,roll,pitch,yaw (m and rad)."),
]
BaseLimits = Annotated[
    Area | None,
    _unless_none(_area),
    Doc("Where a base with a planar joint, or slides without limits, may move: x0,y0,x1,y1 (m)."),
]
Collision = Annotated[
    Backend,
    Doc(
        "Library that checks every node, start, goal and answer: FCL, or coal, which is faster on meshes. Separating "
        "planes prove the edges."
    ),
]
Constraint = Annotated[
    Conditions,
    BeforeValidator(read_conditions),
    Doc(
        "What motions keep all along, proven; repeatable: axis:z,0,0,1,0.1 (the tool's z axis within 0.1 rad of the "
        "world's direction 0,0,1), box:x0,y0,z0,x1,y1,z1 (its origin within, m), plane:nx,ny,nz,d (n.p >= d), turn:0.1 "
        "(its orientation within 0.1 rad of that at the start), near:0.01 (its origin within 0.01 m of that at the "
        "start), keep:0.01,0.1 (both); ' of FRAME in OTHER' names another frame, in another one than the world."
    ),
]

# start and goal
Start = Annotated[Target, BeforeValidator(_start), Doc("Where the arm starts.")]
FreeStart = Annotated[
    Target | None,
    _unless_none(_start),
    Doc("Where a free motion to the tool path starts; left out, the plan begins on the path."),
]
Goal = Annotated[
    Targets, BeforeValidator(read_goals), Doc("Where the arm should go; several (repeat the option) are alternatives.")
]
MotionPlanRequest = Annotated[
    Path | None, Doc("A MoveIt MotionPlanRequest (YAML): start, goal and the joints that are not planned.")
]
IkSolutions = Annotated[
    Integer,
    Field(ge=1, le=100),
    Doc("Configurations at most of a goal position or pose: the best by manipulability and the nearest, in turn."),
]
IkTolerance = Annotated[
    Tolerance,
    BeforeValidator(_tolerance),
    Doc("How far (m,rad) the tool may be off a pose that the arm cannot reach exactly, as with fewer than six axes."),
]
WidenLimits = Annotated[bool, Doc("Widen joint limits that a start or goal given in joints exceeds.")]
Approach = Annotated[
    Real,
    AfterValidator(_leg),
    Doc("Metres that the tool goes straight along its z axis into the goal, proven within 1 mm and 0.5 degrees."),
]
Retreat = Annotated[
    Real, AfterValidator(_leg), Doc("Metres that it first goes straight back along its z axis from the start.")
]
InTurn = Annotated[
    bool, Doc("For a cell: a roadmap of each robot, and a search for who moves when, in place of one roadmap.")
]
ToolSpeed = Annotated[
    Annotated[Real, Field(ge=1e-5, le=10)] | None,
    Doc("Speed of the tool along the path, m/s: at most so much, and just that where the joints' limits allow it."),
]
LadderDensity = Annotated[
    Integer,
    Field(ge=1, le=100),
    Doc("How many times as many solutions of inverse kinematics stand along the path."),
]

# the roadmap, its costs and the dynamics
Nodes = Annotated[
    Integer, Field(ge=2, le=10_000_000), Doc("Configurations in the roadmap; more find better paths and take longer.")
]
Seed = Annotated[Integer, Field(ge=0, lt=2**31), Doc("Seed of all randomness: the same seed gives the same path.")]
RoadmapFile = Annotated[
    Path | None, Doc("A roadmap.npz to plan on, instead of growing one; in another scene all edges are proven again.")
]
Beta = Annotated[Real, Field(ge=0, le=1), Doc("Trade-off in [0, 1]: 0 optimises manipulability only, 1 distance only.")]
MinManipulability = Annotated[
    Real,
    Field(ge=0, le=1e9),
    Doc(
        "A floor under manipulability w, 0 for none: once reached, paths stay above it until the last stretch to a "
        "goal below it. Where start and goal lie below, a path may stay there, no lower than they are."
    ),
]
Law = Annotated[LawName, Doc("Control law under which the dynamics runs.")]
PrescribedTime = Annotated[
    Real, Field(ge=1e-9, le=1e9), Doc("T_p in seconds: the field settles before it, by laws with a prescribed time.")
]
Distance = Annotated[
    Metric, Doc("Distance: joint motion (rad), or the length of the tool's path in the workspace (m).")
]
JacobianRows = Annotated[
    Rows | None,
    Doc("Rows of the tool's Jacobian that w is computed from: linear and angular, or fewer; left out, the robot's."),
]
Manipulability = Annotated[
    Measure,
    Doc(
        "Measure in place of Yoshikawa's w: inverse condition number, smallest singular value, or w with joint limits "
        "(Chan and Dubey 1995). No floor is proven for these."
    ),
]
WCost = Annotated[ManipulabilityCost, Doc("Cost of a configuration by manipulability w: 1/w, -ln w or -w, normalised.")]
Integration = Annotated[
    CostIntegration,
    Doc("Where that cost is charged: along edges, where singularities hide, or at nodes, as in the paper."),
]
RefinementRounds = Annotated[
    Annotated[Integer, Field(ge=0, le=1_000_000)] | None,
    Doc(
        "Rounds of refinement at most, half of them per beta: 0.5, 0, 1 and --beta. Left out, 12, or 0 with --roadmap."
    ),
]
ExtraClearance = Annotated[
    Real,
    Field(ge=0, le=100),
    Doc("Metres beyond --margin that refined paths and shortcuts keep, or a half, a quarter ... where it is narrow."),
]
PathOnly = Annotated[bool, Doc("Only a path, the first that is proven, after shortcuts: no roadmap grows around it.")]

# the motion
LimitsFile = Annotated[
    Path | None, Doc("A MoveIt joint_limits.yaml with velocities, accelerations and jerks of the joints.")
]
VelocityScale = Annotated[Share | None, Doc("Share of the velocity limits to use, above 0 up to 1.")]
AccelerationScale = Annotated[Share | None, Doc("Share of the acceleration limits to use, above 0 up to 1.")]
Acceleration = Annotated[
    Positive | None, Doc("Acceleration limit of every joint, rad/s² (m/s²), in place of the robot's own.")
]
Jerk = Annotated[Positive | None, Doc("Jerk limit of every joint, rad/s³ (m/s³), in place of the robot's own.")]
TimeLawOption = Annotated[
    TimeLaw, Doc("Corners rounded as far as that is proven free, with or without shortcuts in time; or a stop at each.")
]
ExtraCost = Annotated[
    Real, Field(ge=0, le=100), Doc("Share by which shortcuts in time may raise the cost of the path: more is quicker.")
]

# many plans
Jobs = Annotated[Integer, Field(ge=1, le=10_000), Doc("Tasks at once, each in a process of this machine.")]
Workers = Annotated[
    str | None, Doc("Instead of jobs a Dask cluster by its scheduler's address, as in dask:tcp://127.0.0.1:8786.")
]
