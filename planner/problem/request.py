"""The requests: a frozen dataclass per command, composed of the groups of options in ``--help``.

    request = PlanRequest.from_options(robot="panda", scene="shelf", beta=0.2)
    request.what.robot, request.quality.beta
    request.with_options(seed=3)

``what`` is the problem, ``quality`` the effort; :class:`LimitsRequest` and :class:`TimingRequest` are the limits.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Self, TypeVar

from planner.base.arrays import Cost, combine_costs
from planner.base.errors import KeywordError, OptionError, choices
from planner.base.yamlfile import suggest_name
from planner.problem import options as option
from planner.problem.conditions import AND, Condition
from planner.problem.options import PAPER_NODES
from planner.problem.targets import Named, Target
from planner.problem.validation import options

DEFAULT_BETA = 0.5
DEFAULT_COST: option.ManipulabilityCost = "log"
DEFAULT_METRIC: option.Metric = "joint"
DEFAULT_COST_INTEGRATION: option.CostIntegration = "edges"
DEFAULT_MEASURE: option.Measure = "yoshikawa"
DEFAULT_REFINEMENT_ROUNDS = 12  # rounds
DEFAULT_EXTRA_CLEARANCE = 5e-3  # m
_FILE_KEYS = {"motion_plan_request": "request"}  # in files and on the command line
R = TypeVar("R", bound="Request")


@options
class Objective:
    """Minimise (1 - beta) Omega + beta D of a path, eq. (finew), above a ``floor`` under w.

        planner.Objective(beta=0.2, jacobian_rows="translation")
        planner.Objective(beta=0.2, manipulability=lambda q: 1.0 / robot.condition_number(q))

    D is the length by ``metric``: joint motion, or the tool's path. Omega is the ``manipulability_cost``: with
    ``cost_integration`` "edges" integrated along its length, with "nodes" that of the nodes it leads to, as in the
    paper. ``jacobian_rows`` are the rows of the tool's Jacobian that w is computed from. ``manipulability`` names
    another measure, or is a function of configurations (n, dof); it is sampled, and no floor is proven for it.
    """

    beta: option.Beta = DEFAULT_BETA
    manipulability_cost: option.WCost = DEFAULT_COST
    metric: option.Distance = DEFAULT_METRIC
    cost_integration: option.Integration = DEFAULT_COST_INTEGRATION
    floor: option.MinManipulability = 0.0
    jacobian_rows: option.JacobianRows = None
    manipulability: option.Manipulability = DEFAULT_MEASURE

    def at(self, beta: float) -> Objective:
        """Return the objective at another ``beta``."""
        return replace(self, beta=beta)

    def options(self) -> dict[str, Any]:
        """Return the fields by the names of the options."""
        return {"min_manipulability" if name == "floor" else name: value for name, value in vars(self).items()}

    def total(self, omega: Cost, distance: Cost) -> Cost:
        """Return the cost of a motion or path with the normalised ``omega`` and ``distance``."""
        return combine_costs(self.beta, omega, distance)


@options
class PartialWorld:
    """A robot in a scene, and the collision library; a plan.json completes it."""

    robot: option.RecordedRobot = None
    scene: option.RecordedScene = None
    cell: option.Cell = None
    tool: option.Tool = None
    srdf: option.Srdf = None
    group: option.Group = None
    joints: option.Joints = None
    base: option.Placement = None
    base_limits: option.BaseLimits = None
    jacobian_rows: option.JacobianRows = None
    manipulability: option.Manipulability = DEFAULT_MEASURE
    collision: option.Collision = "fcl"
    margin: option.RecordedMargin = None
    constraint: option.Constraint = ()

    def __post_init__(self) -> None:
        if self.group is not None and self.joints is not None:
            raise OptionError("--group and --joints exclude each other: give one of them.")
        alone = (None, str(option.ROBOT), str(option.SCENE))
        own = [
            name
            for name in ("robot", "scene", "srdf", "group", "joints", "base", "base_limits")
            if getattr(self, name) not in alone
        ]
        if self.cell is not None and own:
            raise OptionError(f"--cell names robots and scene: leave out --{own[0]}.")


@options
class WorldRequest(PartialWorld):
    """A robot in a scene, and the collision library."""

    robot: option.Robot = str(option.ROBOT)
    scene: option.Scene = str(option.SCENE)
    margin: option.Margin = 0.0


@options
class ProblemRequest(WorldRequest):
    """A robot in a scene, a start and a goal."""

    start: option.Start = Named(("start",))
    goal: option.Goal = (Named(("goal",)),)
    motion_plan_request: option.MotionPlanRequest = None
    widen_limits: option.WidenLimits = False
    ik_solutions: option.IkSolutions = 8
    ik_tolerance: option.IkTolerance = option.Tolerance((1e-6, 1e-4))


@options
class MotionRequest(ProblemRequest):
    """A robot in a scene, a start and a goal, and straight lines of the tool at both."""

    approach: option.Approach = 0.0
    retreat: option.Retreat = 0.0
    in_turn: option.InTurn = False


@options
class FollowedRequest(WorldRequest):
    """The world of a tool path, and the start of a free motion to it, if any."""

    start: option.FreeStart = None
    ik_tolerance: option.IkTolerance = option.Tolerance((1e-6, 1e-4))
    tool_speed: option.ToolSpeed = None
    ladder_density: option.LadderDensity = 1


@options
class TaskWorldRequest:
    """Options of a task's world that its file does not have."""

    collision: option.Collision = "fcl"
    margin: option.Margin = 0.0
    ik_solutions: option.IkSolutions = 4
    ik_tolerance: option.IkTolerance = option.Tolerance((1e-6, 1e-4))


@options
class RoadmapQuality:
    """The size of a roadmap, and its floor under manipulability."""

    nodes: option.Nodes = PAPER_NODES
    seed: option.Seed = 0
    min_manipulability: option.MinManipulability = 0.0


@options
class SweepQuality(RoadmapQuality):
    """The roadmap, the costs and the dynamics, for every beta."""

    roadmap: option.RoadmapFile = None
    law: option.Law = "singularity-free"
    prescribed_time: option.PrescribedTime = 4.0
    metric: option.Distance = DEFAULT_METRIC
    manipulability_cost: option.WCost = DEFAULT_COST
    cost_integration: option.Integration = DEFAULT_COST_INTEGRATION
    refinement_rounds: option.RefinementRounds = None
    extra_clearance: option.ExtraClearance = DEFAULT_EXTRA_CLEARANCE

    @property
    def rounds(self) -> int:
        """The rounds of refinement: by default 12, or 0 for a saved roadmap."""
        if self.refinement_rounds is not None:
            return self.refinement_rounds
        return DEFAULT_REFINEMENT_ROUNDS if self.roadmap is None else 0

    def objective_at(self, beta: float) -> Objective:
        """Return the objective of a path at ``beta``."""
        return Objective(beta, self.manipulability_cost, self.metric, self.cost_integration, self.min_manipulability)


@options
class PlanQuality(SweepQuality):
    """The trade-off, the roadmap, the costs and the dynamics."""

    beta: option.Beta = DEFAULT_BETA
    path_only: option.PathOnly = False

    def __post_init__(self) -> None:
        if self.path_only and (self.nodes != PAPER_NODES or self.roadmap is not None):
            raise OptionError("path-only excludes nodes and roadmap: leave out one of them.")

    @property
    def rounds(self) -> int:
        """As for a sweep, but by default 0 for ``path_only``."""
        return 0 if self.path_only and self.refinement_rounds is None else super().rounds

    @property
    def objective(self) -> Objective:
        """The objective of the path."""
        return self.objective_at(self.beta)


@options
class TaskQuality:
    """The roadmap that all modes share, its costs and the dynamics."""

    nodes: option.Nodes = 500
    seed: option.Seed = 0
    beta: option.Beta = DEFAULT_BETA
    law: option.Law = "singularity-free"
    prescribed_time: option.PrescribedTime = 4.0
    metric: option.Distance = DEFAULT_METRIC
    manipulability_cost: option.WCost = DEFAULT_COST

    @property
    def objective(self) -> Objective:
        """The objective of the path."""
        return Objective(self.beta, self.manipulability_cost, self.metric)


class Request:
    """Base of the requests, whose fields are groups of options; options are read and changed by name."""

    @classmethod
    def from_options(cls, **values: Any) -> Self:
        """Return the request with these options; :class:`KeywordError` for an unknown one."""
        return cls().with_options(**values)

    @classmethod
    def from_config(cls, config: Mapping[str, Any]) -> Self:
        """Return the request of a record's ``config``, see :meth:`config`; other keys are ignored."""
        known = {
            name: config[_FILE_KEYS.get(name, name)] for name in cls.names() if _FILE_KEYS.get(name, name) in config
        }
        return cls.from_options(**known)

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of all options."""
        return tuple(cls().values())

    def with_options(self, **values: Any) -> Self:
        """Return the request with other ``values``; :class:`KeywordError` for an option that it lacks."""
        reject_unknown(values, self.names(), type(self).__name__.removesuffix("Request").lower())
        changed: dict[str, Any] = {}
        for name, part in vars(self).items():
            own = {key: value for key, value in values.items() if hasattr(part, key)}
            changed |= {name: replace(part, **own)} if own else {}
        return replace(self, **changed) if changed else self  # type: ignore[type-var]

    def values(self) -> dict[str, Any]:
        """Return the options by name."""
        return {option.name: getattr(part, option.name) for part in vars(self).values() for option in fields(part)}  # type: ignore[arg-type]

    def config(self) -> dict[str, Any]:
        """Return the options by command-line name as plain data: objects by name, targets as text."""
        values = self.values()
        of_cell = ("robot", "scene") if values.get("cell") is not None else ()
        return {_FILE_KEYS.get(name, name): _plain(value) for name, value in values.items() if name not in of_cell}


@options
class RoadmapRequest(Request):
    """A roadmap around a start and a goal."""

    what: ProblemRequest = ProblemRequest()
    quality: RoadmapQuality = RoadmapQuality()


def _require_provable_floor(what: WorldRequest, quality: RoadmapQuality) -> None:
    if quality.min_manipulability > 0 and what.manipulability != DEFAULT_MEASURE:
        raise OptionError(
            "min-manipulability needs Yoshikawa's w, the only measure with proofs: leave out one of the two options."
        )


@options
class SweepRequest(Request):
    """The paths of all betas on one roadmap."""

    what: ProblemRequest = ProblemRequest()
    quality: SweepQuality = SweepQuality()

    def __post_init__(self) -> None:
        _require_provable_floor(self.what, self.quality)


@options
class PlanRequest(Request):
    """One plan. With no options this is the paper's scenario: a KUKA LBR iiwa 14 among obstacles."""

    what: MotionRequest = MotionRequest()
    quality: PlanQuality = PlanQuality()

    def __post_init__(self) -> None:
        _require_provable_floor(self.what, self.quality)


@options
class FollowRequest(Request):
    """A tool path, and a free motion to it if there is a start."""

    what: FollowedRequest = FollowedRequest()
    quality: PlanQuality = PlanQuality()

    def __post_init__(self) -> None:
        _require_provable_floor(self.what, self.quality)
        plain = PlanQuality()
        for name in (
            () if self.what.start else ("roadmap", "path_only", "nodes", "refinement_rounds", "extra_clearance")
        ):
            if getattr(self.quality, name) != getattr(plain, name):
                raise OptionError(f"{name.replace('_', '-')} needs a start of a free motion to the path: give --start.")


@options
class TaskRequest(Request):
    """A task, whose steps its file has."""

    what: TaskWorldRequest = TaskWorldRequest()
    quality: TaskQuality = TaskQuality()


@options
class LiveRequest:
    """The first query of the live page, and its roadmap."""

    start: option.Start = Named(("start",))
    goal: option.Goal = (Named(("goal",)),)
    beta: option.Beta = DEFAULT_BETA
    nodes: option.Nodes = PAPER_NODES
    seed: option.Seed = 0
    roadmap: option.RoadmapFile = None


@options
class LimitsRequest:
    """The limits of a motion."""

    limits: option.LimitsFile = None
    velocity_scale: option.VelocityScale = None
    acceleration_scale: option.AccelerationScale = None
    acceleration: option.Acceleration = None
    jerk: option.Jerk = None


@options
class TimingRequest(LimitsRequest):
    """The limits of the motion, and the law that times the path."""

    time_law: option.TimeLawOption = "shortcuts"
    extra_cost: option.ExtraCost = 0.0


@options
class WorkersRequest:
    """The workers of independent tasks; only the seconds depend on them."""

    jobs: option.Jobs = 1
    workers: option.Workers = None

    def __post_init__(self) -> None:
        if self.workers is not None and not (self.workers.startswith("dask:") and self.jobs == 1):
            raise OptionError(f"workers must be dask:ADDRESS without --jobs, got '{self.workers}'.")

    @property
    def serial(self) -> bool:
        """Whether this process runs one task after the other."""
        return self.workers is None and self.jobs == 1


SERIAL = WorkersRequest()


def reject_unknown(values: Collection[str], known: Collection[str], what: str = "plan") -> None:
    """Raise :class:`KeywordError` for the first option that ``what`` does not have."""
    for name in sorted(set(values) - set(known)):
        remedy = f"options are {choices(known)}"
        if name in (field.name for field in fields(TimingRequest)):  # type: ignore[arg-type]
            remedy = f"give it as timing=planner.TimingRequest({name}=...)"
        raise KeywordError(f"option '{name}' of {what} not found{suggest_name(name, known)}: {remedy}.")


def build_request(
    request: R,
    objective: Objective | None,
    options: Mapping[str, Any],
    robot: Any = option.ROBOT,
    scene: Any = option.SCENE,
) -> R:
    """Return the request with the given robot, scene, ``options`` and objective in place of its own.

    Raises :class:`KeywordError` for an option that it lacks, or that the objective has too.
    """
    if isinstance(robot, Request):
        raise TypeError(f"robot must be a name, a file or a Robot, got a {type(robot).__name__}: give it as request=.")
    given = {key: value for key, value in (("robot", robot), ("scene", scene)) if not isinstance(value, option.LeftOut)}
    if objective is not None:
        known, own, plain = request.names(), objective.options(), Objective().options()
        if twice := [name for name in options if name in own]:
            raise KeywordError(f"{twice[0]} must be given once, got it in the objective too: leave out one of them.")
        given |= {key: value for key, value in own.items() if key in known or value != plain[key]}
    return request.with_options(**given, **options)


def _plain(value: Any) -> Any:
    """Return an option as plain data."""
    if isinstance(value, str | int | float | None):
        return value
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Target | Condition):
        return value.text
    if isinstance(value, tuple):
        separator = AND if any(isinstance(each, Target | Condition) for each in value) else ","
        return separator.join(str(_plain(each)) for each in value) or None
    return value.__qualname__ if callable(value) else value.name
