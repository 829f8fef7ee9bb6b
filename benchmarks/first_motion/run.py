"""Measures seconds from a problem to a motion, for our planner and others, each in a process of its own.

How. Every run has a process of its own, one after the other; libraries are loaded, and the robot, before the clocks
start. Times are medians of the wall clock over the problems that the method solved, the duration of motions is a mean;
ready is from a new scene to a checker of it, shortcuts count from the same moment as the first path, 98 % is of the
total, or of the time to the path where there is no motion. Ours: `planner plan --path-only` without its page, every
motion proven, after a plan of the same robot in an empty scene; with the whole roadmap, a plan whose path is there once
all is refined. Before ours and OMPL's Python collects what loading left behind, 0.03 s that would fall on one plan of a
process. OMPL: RRTConnect and `simplifyMax` with its defaults, a Python callback that asks Pinocchio and coal about all
pairs. roboplan (C++): RRT-Connect and its own shortcuts, states 0.05 rad apart, in the
environment given by `--python NAME=PATH`, with the same URDF, limits, link pairs and obstacles; roboplan's connection
distance is its default, 3 rad. roboplan's motion is that of its default spline and TOPP-RA, whose
samples a controller makes cubics of; it knows no limits on jerk, so its share is that of velocity and acceleration.
Shares are of exact extrema of the pieces between knots. hpp: BiRRTPlanner and RandomShortcut, every motion proven by
its continuous validation (Dichotomy, no tolerance); its seed cannot be set, and its motions are not timed here. Of
several goals the first is asked for. Touching: the collision library that we have not planned with looks at every
millimetre of the path, and every 0.1 mm of the motion. Limitations. The others stop by the clock: on a loaded machine
they solve fewer problems. All planners accept only boxes, spheres and cylinders. A path that is not proven can touch
less, or more, than this look sees.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Annotated, Any

from benchmarks import bench
from benchmarks.first_motion.report import OMPL, OURS, WHOLE, aims, fault, tables
from benchmarks.others.elsewhere import environments
from benchmarks.problems import find_problems
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.problem.request import LimitsRequest, PlanRequest, RoadmapRequest
from planner.robot.robot import Robot
from planner.trajectory.limits import MotionLimits


def first_motion(
    folder: bench.Folder,
    plain: Annotated[RoadmapRequest, bench.Flat] = RoadmapRequest.from_options(robot="panda", collision="coal"),  # noqa: B008 (frozen)
    limits: Annotated[LimitsRequest, bench.Flat] = LimitsRequest(),  # noqa: B008 (frozen)
    out: bench.Out = Path("bench-first-motion"),
    python: tuple[str, ...] = (),
    seconds: float = 10.0,
    debug: bench.Debug = False,
) -> int:
    """Time the way from a problem to a motion: our planner, with a path only and a whole roadmap, and other planners.

    Problems and options are those of 'plan'; paths and motions are checked by the library that has not planned. OMPL's
    RRTConnect always runs; roboplan and hpp take part where they are given, each in an environment of
    its own, as what they need clashes with this package:

    python -m benchmarks first-motion FOLDER --python roboplan=/opt/rp/bin/python hpp=/opt/hpp/bin/python

    Writes first-motion.csv, one row a run, and first-motion.md: the times of the stages, lengths and durations, what is
    proven, and how many paths and motions touch something when the other collision library looks closely.

    Args:
        folder: Folder of the problems.
        python: NAME=PATH: a planner, roboplan or hpp, and the Python of the environment it is installed in.
        seconds: Seconds after which the other planners give up.
    """
    request = PlanRequest.from_options(**plain.values(), path_only=True)
    methods = {OURS: "", WHOLE: "", OMPL: "", **environments(python)}
    bench.require_left_to_problems(request)
    if not seconds > 0:
        raise OptionError("give a time above 0 s.")
    robot = Robot.load(str(request.what.robot))
    words, cases = MotionLimits.from_robot(robot, limits).text(robot), []
    for problem, method in itertools.product(find_problems(folder), methods):
        settings = request.quality.seed, str(request.what.robot), request.what.collision, words, seconds
        names = "problem method seed robot collision limits seconds content"
        row = bench.make_settings(names, problem.name, method, *settings, problem.content(request))
        options = {"method": method, "python": methods[method], "seconds": seconds}
        options |= {"request": problem.asked(request).config(), "motion": bench.plain_limits(limits)}
        cases.append(bench.Case((row,), options))
    return bench.run_bench(BENCH, out, cases, _measure)


def _measure(options: dict[str, Any], progress: Progress) -> Any:
    return bench.measure_apart("benchmarks.first_motion.case", options, progress)


BENCH = bench.Bench("first-motion", __doc__, tables, aims, fault)
