"""Shared by the commands: groups of options, plans on disk, and how a result is saved and reported."""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import tyro
from typing_extensions import Doc

from planner.base.errors import FileError, OptionError
from planner.base.files import json_text, require_writable_folder
from planner.base.interrupts import exit_on_interrupt
from planner.base.progress import Progress, Stopwatch
from planner.cli import STARTED
from planner.cli.terminal import complain, facts, say, show, working
from planner.problem import options as option
from planner.problem.outcome import Outcome
from planner.problem.request import MotionRequest, ProblemRequest, TimingRequest
from planner.problem.validation import options

if TYPE_CHECKING:
    from planner.collision.checker import CollisionChecker
    from planner.planning.base_result import Result, RunRecord

R = TypeVar("R", bound="Result[Any]")
# --debug is searched for before a command is read
Debug = Annotated[tyro.conf.FlagCreatePairsOff[bool], tyro.conf.arg(help="Show tracebacks of errors.")]
Out = Annotated[Path, Doc("Folder to write into.")]
Json = Annotated[bool, Doc("Print the JSON file on standard output, and nothing else there.")]
_Named = Annotated[option.MotionPlanRequest, tyro.conf.arg(name="request")]


@options
class Problem(ProblemRequest):
    """The world, the start and the goal."""

    motion_plan_request: _Named = None


@options
class Motion(MotionRequest):
    """The world, the start and the goal."""

    motion_plan_request: _Named = None


@options
class SweepOutput:
    """Files and messages."""

    out: Out = Path("out")
    no_timing: Annotated[bool, Doc("Leave paths without times: write no trajectory.")] = False
    verbose: Annotated[bool, Doc("Print every measure, the bounds and the settling of the dynamics.")] = False
    debug: Debug = False

    def timing(self, limits: TimingRequest) -> TimingRequest | None:
        """The time parametrization, None for ``no_timing``; :class:`OptionError` for both."""
        if self.no_timing and limits != TimingRequest():
            raise OptionError("--no-timing leaves out the motion: leave it out, or all options of the motion.")
        return None if self.no_timing else limits


@options
class TaskOutput(SweepOutput):
    """Files and messages."""

    json: Json = False


@options
class FollowOutput(TaskOutput):
    """Files and messages."""

    no_page: Annotated[bool, Doc("Write no page, which saves a second.")] = False
    view: Annotated[bool, Doc("Open the page in the browser, or print its address where there is none.")] = False

    def __post_init__(self) -> None:
        if self.view and self.no_page:
            raise OptionError("--view opens the page: leave out --no-page.")


@options
class PlanOutput(FollowOutput):
    """Files and messages."""

    certificate: Annotated[bool, Doc("Write proof.npz for 'planner verify', which trusts no planner.")] = False


def run_and_save(
    find: Callable[[Progress], R], out: Path, certificate: bool = False, page: bool = True
) -> tuple[R, Any, str, int]:
    """Find a result and write it; return result, record, a sentence with the files, and exit code.

    After Ctrl-C the partial result is written without the page, and never over an earlier result.
    """
    require_writable_folder(out)
    clock = Stopwatch({"import": time.perf_counter() - STARTED})
    with working() as progress:
        result = find(progress)
        progress("files", 0, 2)
        place = choose_folder(out, result.FILES) if result.outcome is Outcome.INTERRUPTED else out
        record = result.save_without_page(place, clock, certificate and not progress.stopped)
        progress("files", 1, 2)
        with exit_on_interrupt(f"stopping without the page. Written: {_files(result, place)}."):
            if page and not progress.stopped:
                record = result.save_page(place, record, clock)
                progress("files", 2, 2)
    code = Outcome.INTERRUPTED.exit_code if progress.stopped else result.outcome.exit_code
    return result, record, f"Written: {_files(result, place)}{other_place(out, place)}", code


def report(record: RunRecord, title: str, ending: str, output: TaskOutput) -> None:
    """Print the summary of a record, or its JSON text, and the sentence of its ``ending``."""
    if output.json:
        say(json_text(record.to_dict()))
        complain(ending)
        return
    rows = record.rows if output.verbose else record.summary
    show(facts(title, [*rows, ("time", seconds_text(record.timings_s, output.verbose))]))
    say(ending)


def seconds_text(seconds: dict[str, float], verbose: bool) -> str:
    """Return the total of ``seconds`` and the stages above a tenth of it, or all if ``verbose``."""
    total = seconds["total"]
    stages = {stage: value for stage, value in seconds.items() if stage != "total"}
    shown = [f"{stage} {value:.2f}" for stage, value in stages.items() if verbose or value > 0.1 * total]
    return f"{total:.2f} s" + (f": {', '.join(shown)}" if shown else "")


def _files(result: Result[Any], place: Path) -> str:
    return ", ".join(str(place / name) for name in result.files(place) if (place / name).exists())


def record_of_plan(folder: Path) -> dict[str, Any]:
    """Return the content of plan.json or sweep.json in ``folder``; :class:`PlannerError` without a config."""
    from planner.base.yamlfile import read_text
    from planner.planning.base_result import JSON_NAME
    from planner.tradeoff.record import SWEEP_NAME
    from planner.trajectory.file import parse_json

    is_sweep = not os.path.isfile(folder / JSON_NAME) and os.path.isfile(folder / SWEEP_NAME)
    where = folder / (SWEEP_NAME if is_sweep else JSON_NAME)
    record = parse_json(read_text(where, "plan"), f"plan {where}")
    if not isinstance(record, dict) or not isinstance(record.get("config"), dict):
        raise FileError(f"{where} must hold a config: plan again.")
    return record


def world_of_plan(folder: Path) -> CollisionChecker:
    """Return a checker in the world of the plan in ``folder``; :class:`PlannerError` without a plan."""
    from planner.planning.base_result import ROADMAP_NAME
    from planner.roadmap.storage import reopen_plan

    return reopen_plan(record_of_plan(folder)["config"], folder / ROADMAP_NAME)


def choose_folder(folder: Path, names: tuple[str, ...]) -> Path:
    """Return ``folder`` if it has none of the files ``names``, else a new folder inside it."""
    return _first_free(folder, lambda name: folder / name, lambda place: any(os.path.isfile(place / n) for n in names))


def choose_file(file: Path) -> Path:
    """Return ``file`` if it does not exist, else a new one next to it."""
    return _first_free(file, lambda name: file.with_name(f"{file.stem}.{name}{file.suffix}"), os.path.isfile)


def _first_free(place: Path, named: Callable[[str], Path], is_taken: Callable[[Path], bool]) -> Path:
    names = itertools.chain(["interrupted"], (f"interrupted-{k}" for k in itertools.count(2)))
    return next(each for each in itertools.chain([place], map(named, names)) if not is_taken(each))


def other_place(requested: Path, place: Path) -> str:
    """Return the sentence on a ``place`` that differs from the ``requested`` one; else an empty text."""
    return "" if place == requested else f". {requested} holds an earlier result, so this one is in {place}"
