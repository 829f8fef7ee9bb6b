"""What can be asked of the planning of a task; loads no library."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

from planner.base.errors import OptionError
from planner.base.kinds import checks_kinds
from planner.problem.objective import DEFAULT_COST, DEFAULT_METRIC, ManipulabilityCost, Metric, Objective
from planner.problem.request import Backend, Growth, LawName, TradeOff, require_margin


@checks_kinds
@dataclass(frozen=True)
class TaskRequest(TradeOff, Growth):
    """How a task is planned; what is to be done stands in its file."""

    nodes: int = 500
    """Configurations in the roadmap, which all modes share; more find better paths and take longer."""
    ik_solutions: int = 4
    """Configurations of the arm for every grasp and every placement at most."""
    collision: Backend = "fcl"
    """Collision library that checks nodes and answers: FCL, or coal."""
    margin: float = 0.0
    """Distance in metres to keep from every obstacle, and between links."""
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
        require_margin(self.margin)
        if not 1 <= self.ik_solutions <= 100:
            raise OptionError(f"{self.ik_solutions} IK solutions are not usable: give a whole number from 1 to 100.")
        if not 1e-9 <= self.prescribed_time <= 1e9:
            raise OptionError(
                f"prescribed time {self.prescribed_time:g} s is not usable: give a positive number up to 1e9."
            )

    @property
    def objective(self) -> Objective:
        """What the path is to be good for."""
        return Objective(self.beta, self.manipulability_cost, self.metric)


class TaskOptions(TypedDict, total=False):
    """The fields of :class:`TaskRequest` as keywords."""

    nodes: int
    seed: int
    beta: float
    ik_solutions: int
    collision: Backend
    margin: float
    law: LawName
    prescribed_time: float
    metric: Metric
    manipulability_cost: ManipulabilityCost
