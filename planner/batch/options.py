"""The options of a plan or a sweep as JSON holds them: how a process of its own is told what to plan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from planner.problem.request import PlanRequest, SweepRequest

_PATHS = ("srdf", "motion_plan_request", "roadmap")  # options that are paths, which JSON holds as text


def plain_options(request: SweepRequest) -> dict[str, Any]:
    """The options of a plan or a sweep as JSON holds them."""
    values = {field.name: getattr(request, field.name) for field in fields(request)}
    return {name: str(value) if isinstance(value, Path) else value for name, value in values.items()}


def plan_request(options: Mapping[str, Any]) -> PlanRequest:
    """The request whose :func:`plain_options` these are."""
    paths: dict[str, Any] = {name: Path(options[name]) for name in _PATHS if options.get(name)}
    return PlanRequest(**{**options, **paths})
