"""``planner check`` and ``planner verify``: check paths, motions and certificates of any source."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro
from typing_extensions import Doc

from planner.base.errors import OptionError
from planner.base.files import json_text
from planner.base.progress import QUIET
from planner.cli.common import Debug, Json, world_of_plan
from planner.cli.terminal import complain, facts, say, show, watching
from planner.problem.request import LimitsRequest, PartialWorld

if TYPE_CHECKING:
    from planner.base.progress import Progress
    from planner.trajectory.report import Report

EXIT_NOT_USABLE = 4


def check(
    paths: Annotated[
        tyro.conf.Positional[tuple[Path, ...]],
        Doc("A file with a path or a motion, or the folder of a plan; with --cell a file of each robot."),
    ],
    world: PartialWorld = PartialWorld(),  # noqa: B008 (frozen)
    limits: LimitsRequest = LimitsRequest(),  # noqa: B008
    step: Annotated[float, Doc("Metres of motion between two samples; proofs of whole segments are added.")] = 0.001,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Check a path, a trajectory or a task from any source.

    The report has limits, contacts, clearance and proofs. A file is JSON, YAML, CSV or MCAP, of this planner, ROS 2 or
    MoveIt. Between two rows the motion is straight in joint space, or with times the one of a ROS 2 controller. The
    files of a cell run on one clock, and a robot without one rests. Exit codes: 0 free and within limits, 4 not, 2
    wrong option, 3 unusable robot, scene or file.
    """
    from planner.trajectory.check import require_step

    require_step(step)
    from planner.cells.check import check_files
    from planner.tasks.check import check_file

    if not paths:
        raise OptionError("check must have a file or more, got none: name one.")
    own_limits, files = None if limits == LimitsRequest() else limits, list(paths)
    path = " ".join(map(str, files))

    def find(progress: Progress) -> Report:
        if len(files) > 1 or (world.cell is not None and not os.path.isdir(files[0])):
            return check_files(files, world, own_limits, step, progress)
        return check_file(files[0], world, own_limits, step, progress)

    if json:
        report = find(QUIET)
        say(json_text(report.to_dict()))
    else:
        with watching() as progress:
            report = find(progress)
        against = report.checker.world
        show(facts(f"{path}: {against.robot.name} in {against.scene.name}", report.rows()))
        say(report.sentence)
    return 0 if report.ok else EXIT_NOT_USABLE


def verify(
    out: Annotated[tyro.conf.Positional[Path], Doc("The folder of the plan, or one of its files.")] = Path("out"),
    debug: Debug = False,
) -> int:
    """Check the certificate of a plan.

    The certificate, proof.npz, is written by 'planner plan --certificate'. Robot and scene must be those of the
    certificate to the last bit. tools/verify_proof.py does the same with numpy alone. Exit codes: 0 proven, 4 not
    proven, 2 wrong option, 3 unusable robot, scene or file.
    """
    from planner.certificate import verify as verified
    from planner.certificate.certificate import require_certificate
    from planner.certificate.verify_proof import Refused

    out = out.parent if os.path.isfile(out) else out
    require_certificate(out)
    try:
        say(verified(out, world_of_plan(out).world))
    except Refused as why:
        complain(f"NOT proven: {why}")
        return EXIT_NOT_USABLE
    return 0
