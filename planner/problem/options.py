"""The options of :func:`planner.plan` by name, as type checkers and people who mistype them are told."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TypedDict

from planner.base.errors import KeywordError, choices
from planner.base.yamlfile import nearest
from planner.problem.objective import Objective, said_twice
from planner.problem.request import (
    Backend,
    Charge,
    File,
    LawName,
    ManipulabilityCost,
    Metric,
    Names,
    PlanRequest,
    State,
    Thing,
    TimingRequest,
)


class PlanOptions(TypedDict, total=False):
    """The fields of :class:`PlanRequest` as :func:`planner.plan` takes them by name: a test holds both equal."""

    robot: Thing
    scene: Thing
    tool: str | None
    srdf: File | None
    group: str | None
    joints: Names | None
    collision: Backend
    margin: float
    base: str | None
    start: State
    goal: State
    motion_plan_request: File | None
    ik_solutions: int
    widen_limits: bool
    nodes: int
    seed: int
    min_manipulability: float
    roadmap: File | None
    law: LawName
    prescribed_time: float
    metric: Metric
    manipulability_cost: ManipulabilityCost
    charge: Charge
    effort: int | None
    room: float
    beta: float
    above_ends: bool
    path_only: bool


_OF_OBJECTIVE = {field.name: field.name for field in fields(Objective)} | {"floor": "min_manipulability"}


def plan_request(request: PlanRequest | None, options: PlanOptions, objective: Objective | None = None) -> PlanRequest:
    """A request, the default for None, with an ``objective`` and ``options`` in place of its fields.

    Raises :class:`KeywordError` for other options, and for those that the objective says already.
    """
    known = PlanOptions.__annotations__
    for name in sorted(options.keys() - known.keys()):
        remedy = f"options are {choices(known)}"
        if name in (field.name for field in fields(TimingRequest)):
            remedy = f"give it as timing=planner.TimingRequest({name}=...)"
        raise KeywordError(f"plan knows no option '{name}'{nearest(name, known)}: {remedy}.")
    if objective is None:
        return replace(request or PlanRequest(), **options)
    said = {option: getattr(objective, name) for name, option in _OF_OBJECTIVE.items()}
    twice = [name for name in options if name in said]
    if twice:
        raise said_twice(twice[0])
    return replace(request or PlanRequest(), **options, **said)
