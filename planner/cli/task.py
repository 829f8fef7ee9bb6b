"""``planner task``."""

from __future__ import annotations

from pathlib import Path

import tyro

from planner.base.files import json_text
from planner.cli.common import Debug, Flag, Out, timing_of, written
from planner.cli.terminal import complain, facts, say, show
from planner.problem.request import TaskQuality, TaskRequest, TaskWorldRequest, TimingRequest


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
    found, record, files, code = written(lambda progress: plan_task(file, progress, motion, request), out)
    if json:
        say(json_text(record.to_dict()))
    else:
        show(facts(f"{found.task.name}: {record.robot} in {record.scene}", record.rows))
    (complain if json else say)(f"{found.message} {files}")
    return code
