"""``planner check`` and ``planner verify``: check paths, motions and certificates of any source."""

import os
from pathlib import Path
from typing import Annotated

import tyro
from typing_extensions import Doc

from planner.base.files import json_text
from planner.cli.common import Debug, Json, world_of_plan
from planner.cli.terminal import complain, facts, say, show, watching
from planner.problem.request import LimitsRequest, PartialWorld

EXIT_NOT_USABLE = 4


def check(
    path: Annotated[tyro.conf.Positional[Path], Doc("A file with a path or a motion, or the folder of a plan.")],
    world: PartialWorld = PartialWorld(),  # noqa: B008 (frozen)
    limits: LimitsRequest = LimitsRequest(),  # noqa: B008
    step: Annotated[float, Doc("Metres of motion between two samples; proofs of whole segments are added.")] = 0.001,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Check a path, a trajectory or a task from any source.

    The report has limits, contacts, clearance and proofs. PATH is JSON, YAML, CSV or MCAP, of this planner, ROS 2 or
    MoveIt. Between two rows the motion is straight in joint space, or with times the one of a ROS 2 controller. Exit
    codes: 0 free and within limits, 4 not, 2 wrong option, 3 unusable robot, scene or file.
    """
    from planner.trajectory.check import require_step

    require_step(step)
    from planner.tasks.check import check_file

    own_limits = None if limits == LimitsRequest() else limits
    if json:
        report = check_file(path, world, own_limits, step)
        say(json_text(report.to_dict()))
    else:
        with watching() as progress:
            report = check_file(path, world, own_limits, step, progress)
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
