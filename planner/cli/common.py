"""Shared by the commands: the time when the process began, flags, and the option --request."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from planner.base.errors import FileError, OptionError
from planner.base.progress import Stopwatch
from planner.cli import STARTED
from planner.problem import options as of
from planner.problem.request import MotionRequest, ProblemRequest, TimingRequest

if TYPE_CHECKING:
    from planner.collision.checker import CollisionChecker

Flag = tyro.conf.FlagCreatePairsOff[bool]
Debug = Annotated[Flag, tyro.conf.arg(help="Show tracebacks of errors.")]  # looked for before a command is read
Out = Annotated[Path, tyro.conf.arg(help="Folder to write into.")]
_Named = Annotated[of.MotionPlanRequest, tyro.conf.arg(name="request")]


@of.options
class Problem(ProblemRequest):
    """A start and a goal in the world of a robot and a scene."""

    motion_plan_request: _Named = None


@of.options
class Motion(MotionRequest):
    """A start and a goal, and straight lines of the tool at both."""

    motion_plan_request: _Named = None


def timing_of(timing: TimingRequest, no_timing: bool) -> TimingRequest | None:
    """How a path becomes a motion, None for ``no_timing``; :class:`OptionError` where that is said all the same."""
    if not no_timing:
        return timing
    if timing != TimingRequest():
        raise OptionError(
            "with --no-timing there is no motion: leave it out, or all that says how the motion is to be."
        )
    return None


def command_clock() -> Stopwatch:
    """The seconds of a command that has imported all it needs."""
    return Stopwatch({"import": time.perf_counter() - STARTED})


def record_of_plan(folder: Path) -> dict[str, Any]:
    """The content of the plan.json in ``folder``; :class:`PlannerError` where it has no config."""
    from planner.base.yamlfile import read_text
    from planner.planning.run import JSON_NAME
    from planner.trajectory.file import parse_json

    where = folder / JSON_NAME
    record = parse_json(read_text(where, "plan"), f"plan {where}")
    if not isinstance(record, dict) or not isinstance(record.get("config"), dict):
        raise FileError(f"{where} holds no config: plan again.")
    return record


def world_of_plan(folder: Path) -> CollisionChecker:
    """A checker in the world of the plan in ``folder``; :class:`PlannerError` where there is none."""
    from planner.planning.run import ROADMAP_NAME
    from planner.roadmap.storage import reopen_plan

    return reopen_plan(record_of_plan(folder)["config"], folder / ROADMAP_NAME)
