"""The commands that plan: ``planner plan``, ``follow``, ``sweep``, ``task`` and ``batch``."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro
from typing_extensions import Doc

from planner.base.errors import OptionError
from planner.cli.common import (
    Debug,
    FollowOutput,
    Motion,
    Out,
    PlanOutput,
    Problem,
    SweepOutput,
    TaskOutput,
    report,
    run_and_save,
    seconds_text,
)
from planner.cli.terminal import complain, open_in_browser, report_table, run_into, say, show
from planner.problem.outcome import Outcome
from planner.problem.request import (
    SERIAL,
    FollowedRequest,
    FollowRequest,
    PlanQuality,
    PlanRequest,
    SweepQuality,
    SweepRequest,
    TaskQuality,
    TaskRequest,
    TaskWorldRequest,
    TimingRequest,
    WorkersRequest,
)
from planner.problem.validation import options

if TYPE_CHECKING:
    from planner.base.progress import Progress
    from planner.planning.result import Plan
    from planner.tradeoff.result import Tradeoff


def plan(
    problem: Motion = Motion(),  # noqa: B008 (frozen)
    quality: PlanQuality = PlanQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    output: PlanOutput = PlanOutput(),  # noqa: B008
) -> int:
    """Plan a path and its motion from a start to a goal.

    The path keeps away from obstacles and singular configurations, and becomes a motion in time; both are proven free.
    STATE is a name from the scene, home, q:0.1,-0.4,... (rad), xyz:x,y,z (m), pose:x,y,z,qx,qy,qz,qw, or conditions
    joined by &; in a cell ROBOT:STATE, repeatable, and a robot without a goal stays. Writes plan.json, plan.html,
    roadmap.npz and trajectory.json, of a cell also one of each robot. Exit codes: 0 solved, 2 wrong
    option, 3 unusable robot, scene, state or file, 4 no path, 130 interrupted.
    """
    timing = output.timing(limits)
    if problem.in_turn and problem.cell is None:
        raise OptionError("--in-turn plans several robots: give --cell.")
    from planner.planning.plan import plan as find_plan
    from planner.tradeoff.sweep import add_alternatives

    def find(progress: Progress) -> Plan:
        request = PlanRequest(problem, quality)
        if problem.in_turn:
            from planner.cells.planner import plan_in_turn

            return plan_in_turn(request, timing, progress)
        return add_alternatives(find_plan(request=request, timing=timing, progress=progress), progress)

    return _save_plan(find, output, output.certificate)


def follow(
    path: Annotated[tyro.conf.Positional[Path], Doc("A .yaml or .csv file of a tool path.")],
    problem: FollowedRequest = FollowedRequest(),  # noqa: B008 (frozen)
    quality: PlanQuality = PlanQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    output: FollowOutput = FollowOutput(),  # noqa: B008
) -> int:
    """Follow a tool path within a tube.

    The motion keeps the tool within a tube around lines and arcs, and is proven throughout. With --start a free motion
    leads to the first point. Writes the files of 'planner plan'. Exit codes: 0 all is followed and proven, 2 wrong
    option, 3 unusable robot, scene, state or file, 4 less than all, 130 interrupted.
    """
    timing = output.timing(limits)
    from planner.planning.follow import follow as find_plan
    from planner.tradeoff.sweep import add_alternatives

    def find(progress: Progress) -> Plan:
        request = FollowRequest(problem, quality)
        return add_alternatives(find_plan(path, request=request, timing=timing, progress=progress), progress)

    return _save_plan(find, output)


def sweep(
    problem: Problem = Problem(),  # noqa: B008 (frozen)
    quality: SweepQuality = SweepQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    output: SweepOutput = SweepOutput(Path("sweep")),  # noqa: B008
) -> int:
    """Find every path that some beta makes optimal.

    The intervals of beta are exact; each path has its motion. Starts and goals are those of 'planner plan'. Writes
    sweep.json, sweep.csv, sweep.html, roadmap.npz and trajectory-1.json, trajectory-2.json, ... in the order of the
    intervals. Exit codes are those of 'planner plan'; Ctrl-C saves the intervals that are proven so far.
    """
    timing = output.timing(limits)
    from planner.tradeoff.sweep import sweep as find_tradeoff

    def find(progress: Progress) -> Tradeoff:
        return find_tradeoff(request=SweepRequest(problem, quality), timing=timing, progress=progress)

    result, record, files, code = run_and_save(find, output.out)
    ending, count = result.outcome.value, len(result.intervals)
    if result.outcome is Outcome.SOLVED:
        ending = f"{count} path{'s' if count != 1 else ''} of this roadmap, each optimal in its interval of beta."
    if record.intervals:
        show(report_table(record.table))
    for line in [*record.lines, *([record.theory] if output.verbose and record.solves else [])]:
        say(line)
    if timing is not None and (chosen := result.knee or next(iter(result.intervals), None)):
        say(f"To run one: planner export {shlex.quote(str(output.out))} --beta {chosen.beta:g}")
    say(f"Time: {seconds_text(record.timings_s, output.verbose)}.")
    say(f"{ending} {files}")
    return code


def task(
    file: Annotated[tyro.conf.Positional[Path], Doc("The task file (YAML).")],
    problem: TaskWorldRequest = TaskWorldRequest(),  # noqa: B008 (frozen)
    quality: TaskQuality = TaskQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    output: TaskOutput = TaskOutput(),  # noqa: B008
) -> int:
    """Plan a pick-and-place task.

    Grasps, arm configurations, paths and placements are chosen together; motions are proven with the object in the
    hand. The file names robot, scene and steps. Writes plan.json with segments and events, plan.html, roadmap.npz and
    trajectory.json. Exit codes: 0 solved, 2 wrong option, 3 unusable robot, scene, task or file, 4 a step cannot be
    done, 130 interrupted.
    """
    timing = output.timing(limits)
    from planner.tasks.plan import task as find_task

    request = TaskRequest(problem, quality)
    result, record, files, code = run_and_save(
        lambda progress: find_task(file, request=request, timing=timing, progress=progress), output.out
    )
    report(record, f"{result.task.name}: {record.robot} in {record.scene}", f"{result.message} {files}", output)
    return code


@options
class BatchOutput:
    """Files, and when a plan stops."""

    out: Out = Path("batch")
    pages: Annotated[bool, Doc("Write the page of each plan too.")] = False
    time_limit: Annotated[float, Doc("Seconds after which a plan stops and its row says so.")] = 600.0
    debug: Debug = False


def batch(
    source: Annotated[tyro.conf.Positional[Path], Doc("The plans: a .yaml or .csv file, or a folder.")],
    problem: Motion = Motion(),  # noqa: B008 (frozen)
    quality: PlanQuality = PlanQuality(),  # noqa: B008
    workers: WorkersRequest = SERIAL,
    output: BatchOutput = BatchOutput(),  # noqa: B008
) -> int:
    """Plan many problems, one row each.

    SOURCE is a YAML file, plans: [{name: left, scene: shelf}, ...], a CSV file with a column per option, or a folder of
    MoveIt requests. A plan takes the options that it leaves out from those given here. Writes batch.csv and a folder
    per plan. The same command again plans only the rows that are missing, crashed or ran out of time. Exit codes: 0
    all solved, 4 some are not, 130 interrupted.
    """
    from planner.batch.run import SOLVED, run_batch

    request, more = PlanRequest(problem, quality), (workers, output.pages, output.time_limit)
    result = run_into(output.out, lambda progress: run_batch(source, output.out, request, *more, progress))
    say(result.report)
    if not result.complete:
        return Outcome.INTERRUPTED.exit_code
    return 0 if all(row["outcome"] == SOLVED for row in result.rows) else 4


def _save_plan(find: Callable[[Progress], Plan], output: FollowOutput, certificate: bool = False) -> int:
    """Save, report and show the plan that ``find`` returns; the exit code."""
    result, record, files, code = run_and_save(find, output.out, certificate, not output.no_page)
    report(record, f"{record.robot} in {record.scene}", f"{result.message} {files}", output)
    if output.view and code != Outcome.INTERRUPTED.exit_code:
        open_in_browser((output.out / result.PAGE).resolve().as_uri(), complain if output.json else say)
    is_complete = result.tool_path is None or result.tool_path.record.proven
    return code if code or is_complete else Outcome.PARTLY_FOLLOWED.exit_code
