"""The commands that plan: ``planner plan``, ``follow``, ``sweep``, ``task`` and ``batch``."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from planner.base.errors import OptionError
from planner.base.files import json_text
from planner.cli.common import Debug, Flag, Motion, NoPage, Out, Problem, timing_of, written
from planner.cli.terminal import complain, facts, open_in_browser, report_table, run_into, say, show
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

if TYPE_CHECKING:
    from planner.base.progress import Progress
    from planner.planning.result import Plan
    from planner.tradeoff.result import Tradeoff


def plan(
    what: Motion = Motion(),  # noqa: B008 (frozen)
    quality: PlanQuality = PlanQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    no_timing: Flag = False,
    certificate: Flag = False,
    out: Out = Path("out"),
    no_page: NoPage = False,
    view: Flag = False,
    json: Flag = False,
    debug: Debug = False,
) -> int:
    """Plan a joint path from a start to a goal that keeps away from obstacles and singular configurations.

    A start or goal is a name from the scene file, home, q:0.1,-0.4,... (joints, rad), xyz:0.92,-0.10,0.42 (tool
    position, m), pose:x,y,z,qx,qy,qz,qw, or with tolerance conditions as --constraint has them, with & between. With no
    options this is the paper's scenario: a KUKA LBR iiwa 14 among obstacles. Examples:

    planner plan --robot panda --scene shelf --beta 0 --seed 3 --out shelf

    planner plan --start home --goal goal --goal xyz:0.5,0.3,0.6 --roadmap out/roadmap.npz

    planner plan --robot panda --scene empty --start home --goal "xyz:0.4,0.4,0.5 & axis:z,0,0,-1" --constraint turn:0.1

    The path becomes the quickest motion within the limits that is proven as a curve in time, corners rounded. Where
    obstacles move along known motions (motion: in the scene file) the plan is the earliest motion through the roadmap
    that keeps clear of them, waiting included. Of obstacles with a speed_limit plan.json says until when they cannot
    touch. The same command, seed and versions give the same path and roadmap on every x86-64 processor with FMA.

    Writes plan.json, plan.html (open it in a browser), roadmap.npz and trajectory.json in place of an earlier run's,
    also where no path is found. Exit code 0: solved; 2: a wrong option; 3: an unusable robot, scene, state or file
    (both write nothing); 4: no path within the budget; 130: interrupted. Ctrl-C saves the partial plan, without the
    page; where --out holds a plan already, in a new folder 'interrupted' inside it.

    Args:
        no_timing: Leave the path without times: no trajectory.json.
        certificate: Write proof.npz too, which can be checked without the planner: see 'planner verify'.
        view: Open the page in the browser when it is written; where there is none, print its place.
        json: Print plan.json on standard output, and nothing else there.
    """
    motion = timing_of(limits, no_timing)
    from planner.planning.plan import plan as find_plan
    from planner.tradeoff.sweep import add_alternatives

    def find(progress: Progress) -> Plan:
        return add_alternatives(
            find_plan(request=PlanRequest(what, quality), timing=motion, progress=progress), progress
        )

    return _told(find, out, view, json, no_page, certificate)


def follow(
    path: tyro.conf.Positional[Path],
    what: FollowedRequest = FollowedRequest(),  # noqa: B008 (frozen)
    quality: PlanQuality = PlanQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    no_timing: Flag = False,
    out: Out = Path("out"),
    no_page: NoPage = False,
    view: Flag = False,
    json: Flag = False,
    debug: Debug = False,
) -> int:
    """Follow a tool path: a joint motion that keeps the tool within a tube around lines and arcs, proven throughout.

    PATH is a YAML file with tube (position in m, angle in rad) and points, each with a position and a quaternion
    (x, y, z, w), an axis that the tool's z axis points along while it may turn about it, or a cone about an axis; via:
    arc makes a point the middle of an arc; approach and retreat are straight legs (m) along the tool's z axis before
    and behind. Or a CSV with columns x, y, z and qx, qy, qz, qw or ax, ay, az. Positions are of the tool frame in the
    world. Without --start the plan begins at the first point; with it a free motion leads there. Every motion is proven
    to stay in the tube and free. Where not all can be followed, the reason names the point. Examples:

    planner follow seam.yaml --robot panda --scene table

    planner follow seam.yaml --robot panda --scene table --start home --tool-speed 0.05 --beta 0.2

    Writes what 'planner plan' writes, and tool_path in plan.json. Exit code 0: all is followed and proven; 2: a wrong
    option; 3: an unusable robot, scene, state or file; 4: less than all; 130: interrupted.

    Args:
        path: A .yaml or .csv file of a tool path.
        no_timing: Leave the path without times: no trajectory.json.
        view: Open the page in the browser when it is written; where there is none, print its place.
        json: Print plan.json on standard output, and nothing else there.
    """
    motion = timing_of(limits, no_timing)
    from planner.planning.follow import follow as find_plan
    from planner.tradeoff.sweep import add_alternatives

    def find(progress: Progress) -> Plan:
        return add_alternatives(
            find_plan(path, request=FollowRequest(what, quality), timing=motion, progress=progress), progress
        )

    return _told(find, out, view, json, no_page)


def sweep(
    what: Problem = Problem(),  # noqa: B008 (frozen)
    quality: SweepQuality = SweepQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    no_timing: Flag = False,
    out: Out = Path("sweep"),
    debug: Debug = False,
) -> int:
    """The whole trade-off between manipulability and distance: every path in a roadmap that some beta makes optimal.

    Finds all values of beta at which the best path changes, exactly and without a grid, on one roadmap, and the motion
    along each path. Starts, goals and all other options are those of 'planner plan'. Examples:

    planner sweep --seed 3

    planner sweep --roadmap out/roadmap.npz && planner export sweep --beta 0.2

    Writes sweep.json, sweep.csv, sweep.html (open it in a browser), roadmap.npz, and the motions trajectory-1.json,
    trajectory-2.json, ... in the order of the intervals. Exit codes are those of 'planner plan'; Ctrl-C saves the
    intervals that are proven so far, without the page; where --out holds a sweep already, in a new folder 'interrupted'
    inside it.

    Args:
        no_timing: Leave the paths without times: no trajectory-1.json, ...
    """
    motion = timing_of(limits, no_timing)
    from planner.tradeoff.sweep import sweep as find_tradeoff

    def find(progress: Progress) -> Tradeoff:
        return find_tradeoff(request=SweepRequest(what, quality), timing=motion, progress=progress)

    result, record, files, code = written(find, out)
    ending, count = result.outcome.value, len(result.intervals)
    if result.outcome is Outcome.SOLVED:
        ending = f"{count} path{'s' if count != 1 else ''} of this roadmap, each optimal in its interval of beta."
    if record.intervals:
        show(report_table(record.table))
    for line in record.lines:
        say(line)
    if motion is not None and (chosen := result.knee or next(iter(result.intervals), None)):
        say(f"To run one: planner export {shlex.quote(str(out))} --beta {chosen.beta:g}")
    say("Seconds: " + ", ".join(f"{stage} {value:.2f}" for stage, value in record.timings_s.items()) + ".")
    say(f"{ending} {files}")
    return code


def task(
    file: tyro.conf.Positional[Path],
    what: TaskWorldRequest = TaskWorldRequest(),  # noqa: B008 (frozen)
    quality: TaskQuality = TaskQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    no_timing: Flag = False,
    out: Out = Path("out"),
    json: Flag = False,
    debug: Debug = False,
) -> int:
    """Plan a task: objects picked and placed, with grasps, arm configurations, paths and placements chosen together.

    The task file says robot, scene and steps, the scene's obstacles being what is picked. One roadmap serves every
    mode (the empty hand, each object in each grasp), one field over all of them finds the cheapest way by beta, and
    its motions are proven with the object in the hand. Example:

    planner task scenes/examples/tidy.yaml --beta 0.2 --nodes 1000 --out tidy

    Writes plan.json with segments and events, plan.html, roadmap.npz, and trajectory.json: one motion of all segments,
    at rest where the gripper moves. Exit code 0: solved; 2: a wrong option; 3: an unusable robot, scene, task or file;
    4: a step cannot be done, and plan.json says which and why; 130: interrupted.

    Args:
        file: The task file (YAML).
        no_timing: Leave the segments without times: no trajectory.json.
        json: Print plan.json on standard output, and nothing else there.
    """
    motion = timing_of(limits, no_timing)
    from planner.tasks.plan import task as plan_task

    request = TaskRequest(what, quality)
    found, record, files, code = written(
        lambda progress: plan_task(file, request=request, timing=motion, progress=progress), out
    )
    if json:
        say(json_text(record.to_dict()))
    else:
        show(facts(f"{found.task.name}: {record.robot} in {record.scene}", record.rows))
    (complain if json else say)(f"{found.message} {files}")
    return code


def batch(
    source: tyro.conf.Positional[Path],
    what: Motion = Motion(),  # noqa: B008 (frozen)
    quality: PlanQuality = PlanQuality(),  # noqa: B008
    out: Out = Path("batch"),
    workers: WorkersRequest = SERIAL,
    pages: Flag = False,
    time_limit: float = 600.0,
    debug: Debug = False,
) -> int:
    """Plan many times: one row and one folder for each start, goal, scene or robot that SOURCE asks for.

    SOURCE is a YAML file, plans: [{name: left, scene: shelf, goal: "xyz:0.5,0.3,0.6"}, ...], a CSV file with a line of
    option names and a line per plan, or a folder of MoveIt's requests with their scenes. Options have the names of
    'planner plan'; a plan that leaves one out takes it from the options given here.

    Writes batch.csv, and for each plan NAME/plan.json, NAME/roadmap.npz and NAME/row.json. Run again, the same command
    plans what is missing, has crashed or ran out of time. Exit code 0: all solved; 4: some are not; 130: interrupted.

    Args:
        source: The plans: a .yaml or .csv file, or a folder.
        pages: Write the page of each plan too.
        time_limit: Seconds after which a plan stops and is recorded as timed out; the budget is in nodes.
    """
    from planner.batch.run import SOLVED, run_batch

    result = run_into(
        out, lambda progress: run_batch(source, out, PlanRequest(what, quality), workers, pages, time_limit, progress)
    )
    say(result.report)
    if not result.complete:
        return 130
    return 0 if all(row["outcome"] == SOLVED for row in result.rows) else 4


def _told(
    find: Callable[[Progress], Plan], out: Path, view: bool, json: bool, no_page: bool, certificate: bool = False
) -> int:
    """Write what is found into the folder ``out``, tell of it, show it where that is asked; the exit code."""
    if view and no_page:
        raise OptionError("--view opens the page: leave out --no-page.")
    result, record, files, code = written(find, out, certificate, not no_page)
    tell = complain if json else say
    if json:
        say(json_text(record.to_dict()))
    else:
        seconds = ", ".join(f"{stage} {value:.2f}" for stage, value in record.timings_s.items())
        show(facts(f"{record.robot} in {record.scene}", [*record.rows, ("seconds", seconds)]))
    tell(f"{result.message} {files}")
    if view and code != Outcome.INTERRUPTED.exit_code:
        open_in_browser((out / result.PAGE).resolve().as_uri(), tell)
    followed = result.tool_path is None or result.tool_path.record.proven
    return code if code or followed else Outcome.PARTLY_FOLLOWED.exit_code
