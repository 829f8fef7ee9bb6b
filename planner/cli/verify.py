"""``planner verify``."""

from __future__ import annotations

import os
from pathlib import Path

import tyro

from planner.cli.check import EXIT_NOT_USABLE
from planner.cli.common import Debug, world_of_plan
from planner.cli.terminal import complain, say


def verify(out: tyro.conf.Positional[Path] = Path("out"), debug: Debug = False) -> int:
    """Check the certificate of a plan, proof.npz: that its path and its motion touch nothing and keep their limits.

    OUT is the folder that 'planner plan --certificate' wrote into. Robot and scene are loaded as plan.json names them
    and have to be, to the last bit, those that the certificate speaks of; then each of its witnesses is checked. That
    is done by tools/verify_proof.py and proof_inequalities.py, which need Python and numpy and no planner: run these
    where you would rather not believe this package. It says what is proven, and what is not. Examples:

    planner plan --certificate && planner verify out

    python tools/verify_proof.py out --urdf robot.urdf

    Exit code 0: proven; 4: not, and why; 2: a wrong option; 3: an unusable robot, scene or file.

    Args:
        out: The folder with plan.json, roadmap.npz and proof.npz, or one of these files.
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
