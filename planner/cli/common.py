"""Shared by the commands: flags, the option --request, plans on disk, and how a result is written."""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import tyro

from planner.base.errors import FileError, OptionError
from planner.base.files import require_writable_folder
from planner.base.interrupts import leaving_on_interrupt
from planner.base.progress import Progress, Stopwatch
from planner.cli import STARTED
from planner.cli.terminal import working
from planner.problem import options as of
from planner.problem.checked import options
from planner.problem.outcome import Outcome
from planner.problem.request import MotionRequest, ProblemRequest, TimingRequest

if TYPE_CHECKING:
    from planner.collision.checker import CollisionChecker
    from planner.planning.base_result import Result

R = TypeVar("R", bound="Result[Any]")
Flag = tyro.conf.FlagCreatePairsOff[bool]
NoPage = Annotated[Flag, tyro.conf.arg(help="Write no page, which saves a second.")]
Debug = Annotated[Flag, tyro.conf.arg(help="Show tracebacks of errors.")]  # looked for before a command is read
Out = Annotated[Path, tyro.conf.arg(help="Folder to write into.")]
_Named = Annotated[of.MotionPlanRequest, tyro.conf.arg(name="request")]


@options
class Problem(ProblemRequest):
    """A start and a goal in the world of a robot and a scene."""

    motion_plan_request: _Named = None


@options
class Motion(MotionRequest):
    """A start and a goal, and straight lines of the tool at both."""

    motion_plan_request: _Named = None


def timing_of(timing: TimingRequest, no_timing: bool) -> TimingRequest | None:
    """How a path becomes a motion, None for ``no_timing``; :class:`OptionError` for both."""
    if no_timing and timing != TimingRequest():
        raise OptionError("with --no-timing there is no motion: leave it out, or all options of the motion.")
    return None if no_timing else timing


def written(
    find: Callable[[Progress], R], out: Path, certificate: bool = False, page: bool = True
) -> tuple[R, Any, str, int]:
    """Find a result and write it into ``out``; return it, its record, a sentence with the files, and the exit code.

    After Ctrl-C the partial result is written without the page, and never over an earlier result.
    """
    require_writable_folder(out)
    clock = Stopwatch({"import": time.perf_counter() - STARTED})
    with working() as progress:
        result = find(progress)
        progress("files", 0, 2)
        place = folder_for_interrupted(out, result.FILES) if result.outcome is Outcome.INTERRUPTED else out
        record = result.save_without_page(place, clock, certificate and not progress.stopped)
        progress("files", 1, 2)
        with leaving_on_interrupt(f"stopping without the page. Written: {_files(result, place)}."):
            if page and not progress.stopped:
                record = result.save_page(place, record, clock)
                progress("files", 2, 2)
    code = Outcome.INTERRUPTED.exit_code if progress.stopped else result.outcome.exit_code
    return result, record, f"Written: {_files(result, place)}{kept(out, place)}", code


def _files(result: Result[Any], place: Path) -> str:
    return ", ".join(str(place / name) for name in result.FILES if (place / name).exists())


def record_of_plan(folder: Path) -> dict[str, Any]:
    """The content of the plan.json, or sweep.json, in ``folder``; :class:`PlannerError` where it has no config."""
    from planner.base.yamlfile import read_text
    from planner.planning.base_result import JSON_NAME
    from planner.tradeoff.record import SWEEP_NAME
    from planner.trajectory.file import parse_json

    is_sweep = not os.path.isfile(folder / JSON_NAME) and os.path.isfile(folder / SWEEP_NAME)
    where = folder / (SWEEP_NAME if is_sweep else JSON_NAME)
    record = parse_json(read_text(where, "plan"), f"plan {where}")
    if not isinstance(record, dict) or not isinstance(record.get("config"), dict):
        raise FileError(f"{where} holds no config: plan again.")
    return record


def world_of_plan(folder: Path) -> CollisionChecker:
    """A checker in the world of the plan in ``folder``; :class:`PlannerError` where there is none."""
    from planner.planning.base_result import ROADMAP_NAME
    from planner.roadmap.storage import reopen_plan

    return reopen_plan(record_of_plan(folder)["config"], folder / ROADMAP_NAME)


def folder_for_interrupted(folder: Path, names: tuple[str, ...]) -> Path:
    """``folder`` if it has none of the files ``names``; else a new one inside it: no earlier result is lost."""
    return _first_free(folder, lambda name: folder / name, lambda place: any(os.path.isfile(place / n) for n in names))


def file_for_interrupted(file: Path) -> Path:
    """``file`` if there is none yet; else a new one next to it."""
    return _first_free(file, lambda name: file.with_name(f"{file.stem}.{name}{file.suffix}"), os.path.isfile)


def _first_free(place: Path, named: Callable[[str], Path], taken: Callable[[Path], bool]) -> Path:
    names = itertools.chain(["interrupted"], (f"interrupted-{k}" for k in itertools.count(2)))
    return next(found for found in itertools.chain([place], map(named, names)) if not taken(found))


def kept(place: Path, instead: Path) -> str:
    """The sentence for the user; empty where the result went into its own place."""
    return "" if place == instead else f". What was in {place} is kept; this is in {instead}"
