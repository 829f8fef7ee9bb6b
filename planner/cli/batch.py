"""``planner batch``."""

from __future__ import annotations

from pathlib import Path

import tyro

from planner.cli.common import Debug, Flag, Motion, Out
from planner.cli.terminal import run_into, say
from planner.problem.request import SERIAL, PlanQuality, PlanRequest, WorkersRequest


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
