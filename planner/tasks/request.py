"""What can be asked of the planning of a task; loads no library."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

from planner.base.kinds import checks_kinds
from planner.problem.objective import ManipulabilityCost, Metric, Objective
from planner.problem.request import Backend, CostField, Growth, IkSolutions, LawName, TradeOff, require_margin


@checks_kinds
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
