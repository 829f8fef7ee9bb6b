"""``planner follow``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from planner.cli.common import Debug, Flag, Out, timing_of
from planner.cli.plan import written_and_told
from planner.problem.request import FollowedRequest, FollowRequest, PlanQuality, TimingRequest

if TYPE_CHECKING:
    from planner.base.progress import Progress
    from planner.planning.result import Plan


def follow(
    path: tyro.conf.Positional[Path],
    what: FollowedRequest = FollowedRequest(),  # noqa: B008 (frozen)
    quality: PlanQuality = PlanQuality(),  # noqa: B008
    limits: TimingRequest = TimingRequest(),  # noqa: B008
    no_timing: Flag = False,
    out: Out = Path("out"),
    view: Flag = False,
    json: Flag = False,
    debug: Debug = False,
) -> int:
    """Follow a tool path: a joint motion that keeps the tool within a tube around lines and arcs, proven throughout.

    PATH is a YAML file with tube (position in m, angle in rad) and points, each with a position and a quaternion
    (x, y, z, w), an axis that the tool's z axis points along while it may turn about it, or a cone about an axis; via:
    arc makes a point the middle of an arc; approach and retreat are straight legs (m) along the tool's z axis before
    and behind. Or a CSV with columns x, y, z and qx, qy, qz, qw or ax, ay, az. Positions are of the tool frame in the
    world.

    Without --start the plan begins at the first point; with it a free motion leads there. No joint jumps: every motion
    between two solutions of inverse kinematics is proven to stay in the tube and free, and so is the motion in time.
    Where not all can be followed, what can be is planned, and the reason names the point. Examples:

    planner follow seam.yaml --robot panda --scene table

    planner follow seam.yaml --robot panda --scene table --start home --tool-speed 0.05 --beta 0.2

    Writes what 'planner plan' writes; plan.json says under tool_path what is followed. Exit code 0: all is followed and
    proven; 2: a wrong option; 3: an unusable robot, scene, state or file; 4: less than all; 130: interrupted.

    Args:
        path: A .yaml or .csv file of a tool path.
        no_timing: Leave the path without times: no trajectory.json.
        view: Serve the page on this machine when it is written, until Ctrl-C.
        json: Print plan.json on standard output, and nothing else there.
    """
    from planner.base.files import require_writable_folder

    motion = timing_of(limits, no_timing)
    require_writable_folder(out)
    from planner.planning.follow import follow as find_plan

    def find(progress: Progress) -> Plan:
        return find_plan(path, FollowRequest(what, quality), progress, motion)

    return written_and_told(find, out, view, json)
