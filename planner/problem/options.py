"""The options of :func:`planner.plan` by name, as type checkers and people who mistype them are told."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields, replace
from typing import Any, TypedDict

from planner.base.errors import KeywordError, choices
from planner.base.yamlfile import nearest
from planner.problem.objective import Objective, said_twice
from planner.problem.request import (
    Backend,
    Charge,
    File,
    Kept,
    LawName,
    ManipulabilityCost,
    Metric,
    Names,
    PlanRequest,
    State,
    Thing,
    TimingRequest,
)


class RoadmapOptions(TypedDict, total=False):
    """Those of all that is planned on a roadmap."""

    collision: Backend
    margin: float
    ik_solutions: int
    ik_tolerance: str
    nodes: int
    seed: int
    law: LawName
    prescribed_time: float
    metric: Metric
    manipulability_cost: ManipulabilityCost


class TaskOptions(RoadmapOptions, total=False):
    """The fields of :class:`planner.TaskRequest`: a test holds both equal."""

    beta: float


class SessionOptions(RoadmapOptions, total=False):
    """Those that a session has for all its plans."""

    tool: str | None
    srdf: File | None
    group: str | None
    joints: Names | None
    keep: Kept | None
    base: str | None
    min_manipulability: float
    charge: Charge
    effort: int | None


class PlanOptions(SessionOptions, total=False):
    """The fields of :class:`PlanRequest` as :func:`planner.plan` takes them by name: a test holds both equal."""

    robot: Thing
    scene: Thing
    start: State
    goal: State
    motion_plan_request: File | None
    widen_limits: bool
    roadmap: File | None
    room: float
    beta: float
    approach: float
    retreat: float
    path_only: bool


_OPTIONS = tuple(field.name for field in fields(PlanRequest))
_OF_OBJECTIVE = {field.name: field.name for field in fields(Objective)} | {"floor": "min_manipulability"}


def plan_request(
    request: PlanRequest | None,
    options: PlanOptions | SessionOptions,
    objective: Objective | None = None,
    known: Collection[str] = _OPTIONS,
    what: str = "plan",
) -> PlanRequest:
    """A request, the default for None, with an ``objective`` and ``options`` in place of its fields.

    Raises :class:`KeywordError` for options that ``what`` does not take, which are not among those ``known``, and for
    those that the objective says already.
    """
    require_known(options, known, what)
    said: dict[str, Any] = {}
    if objective is not None:
        said = {option: getattr(objective, name) for name, option in _OF_OBJECTIVE.items()}
        twice = [name for name in options if name in said]
        if twice:
            raise said_twice(twice[0])
    asked = request or PlanRequest()
    return replace(asked, **options, **said) if options or said else asked


def require_known(options: Collection[str], known: Collection[str], what: str) -> None:
    """Raise :class:`KeywordError` for the first of ``options`` that ``what`` does not take."""
    for name in sorted(set(options) - set(known)):
        remedy = f"options are {choices(known)}"
        if name in (field.name for field in fields(TimingRequest)):
            remedy = f"give it as timing=planner.TimingRequest({name}=...)"
        raise KeywordError(f"{what} knows no option '{name}'{nearest(name, known)}: {remedy}.")
