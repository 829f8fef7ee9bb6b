"""``benchmarks plan|first-motion|proofs|quality|motion|replan``: the benchmarks over a folder of planning problems."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.terminal import measure
from planner.cli.common import Debug, Out, Workers
from planner.problem.request import SERIAL, LimitsRequest, PlanRequest, RoadmapRequest


def plan(
    folder: tyro.conf.Positional[Path],
    plain: Annotated[PlanRequest, tyro.conf.arg(name="")] = PlanRequest("panda"),  # noqa: B008 (frozen)
    out: Out = Path("bench-plan"),
    seeds: tuple[int, ...] = (0, 1, 2),
    time_limit: float = 60.0,
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """A folder of planning problems, each planned with several seeds: success, times, lengths, manipulability, safety.

    A problem is request<X>.yaml, a MoveIt motion plan request, with scene<X>.yaml or scene<X>.scene beside it, in
    FOLDER or in folders inside it, which are the scene types. All options are those of 'planner plan', but for what
    each problem says itself (scene, request, start, goal) and --seed, in whose place --seeds stands. Run again with
    another --beta, --nodes or --collision and the same --out, and the report sets them side by side. Paths are checked
    by the library that has not planned. Writes plan.csv, one row a run, plan.md, and logs/<problem>.log for
    ompl_benchmark_statistics and Planner Arena.

    Args:
        folder: Folder of the problems.
        seeds: Seeds to plan every problem with.
        time_limit: Seconds after which a run is killed and recorded as timed out; the budget is in nodes and motions.
    """
    from benchmarks.plan.run import bench_plan

    return measure(out, lambda progress: bench_plan(folder, out, plain, seeds, time_limit, progress, workers))


def first_motion(
    folder: tyro.conf.Positional[Path],
    plain: Annotated[RoadmapRequest, tyro.conf.arg(name="")] = RoadmapRequest("panda", collision="coal"),  # noqa: B008
    limits: Annotated[LimitsRequest, tyro.conf.arg(name="")] = LimitsRequest(),  # noqa: B008 (frozen)
    out: Out = Path("bench-first-motion"),
    python: tuple[str, ...] = (),
    seconds: float = 10.0,
    debug: Debug = False,
) -> int:
    """From a problem to a motion: ours, proven, with a path only and with the whole roadmap, beside other planners'.

    Problems and options are those of 'plan'; paths and motions are checked by the library that has not planned. OMPL's
    RRTConnect is always beside; roboplan, pyroboplan and hpp take part where they are given, each in an environment of
    its own, as what they need clashes with this package:

    python -m benchmarks first-motion FOLDER --python roboplan=/opt/rp/bin/python hpp=/opt/hpp/bin/python

    Writes first-motion.csv, one row a run, and first-motion.md: the times of the stages, lengths and durations, what is
    proven, and how many paths and motions touch something when the other collision library looks closely.

    Args:
        folder: Folder of the problems.
        python: NAME=PATH: a planner, roboplan, pyroboplan or hpp, and the Python of the environment it is installed in.
        seconds: Seconds after which the other planners give up.
    """
    from benchmarks.first_motion.run import bench_first_motion, environments

    request, pythons = PlanRequest(**vars(plain), path_only=True), environments(python)
    return measure(out, lambda progress: bench_first_motion(folder, out, request, limits, pythons, seconds, progress))


def proofs(
    folder: tyro.conf.Positional[Path],
    python: str,
    plain: Annotated[PlanRequest, tyro.conf.arg(name="")] = PlanRequest("panda", collision="coal"),  # noqa: B008
    out: Out = Path("bench-proofs"),
    motions: int = 2000,
    debug: Debug = False,
) -> int:
    """Our proofs of straight motions against those of HPP, the other planner that proves, motion by motion.

    Problems are those of 'plan'; random motions are drawn in their scenes. Those that only one of the two
    proves are looked at by coal at every 0.1 mm. Writes proofs.csv, two rows a scene, and proofs.md.

    Args:
        folder: Folder of the problems.
        python: Python of an environment of its own with hpp-python in it.
        motions: Motions in all, shared out among the scenes.
    """
    from benchmarks.proofs.run import bench_proofs

    return measure(out, lambda progress: bench_proofs(folder, out, plain, python, motions, progress))


def quality(
    folder: tyro.conf.Positional[Path],
    plain: Annotated[PlanRequest, tyro.conf.arg(name="")] = PlanRequest("panda", collision="coal", nodes=1000),  # noqa: B008
    out: Out = Path("bench-quality"),
    betas: tuple[float, ...] = (0.0, 0.25, 0.5, 1.0),
    efforts: tuple[int, ...] = (0, 12),
    seconds: float = 5.0,
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """How good paths are: length, corners, manipulability and time, beside OMPL's RRTConnect, RRT* and BIT*.

    Problems and options are those of 'plan'. Writes quality.csv, one row a run, and quality.md: medians, and medians
    of ratios to RRTConnect with simplification on the same problem.

    Args:
        folder: Folder of the problems.
        betas: Trade-offs to plan at, in place of --beta.
        efforts: Rounds of refinement and search to plan with, in place of --effort.
        seconds: Processor time that OMPL's planners get.
    """
    from benchmarks.quality.run import bench_quality

    return measure(out, lambda progress: bench_quality(folder, out, plain, betas, efforts, seconds, progress, workers))


def motion(
    folder: tyro.conf.Positional[Path],
    plain: Annotated[PlanRequest, tyro.conf.arg(name="")] = PlanRequest("panda"),  # noqa: B008 (frozen)
    limits: Annotated[LimitsRequest, tyro.conf.arg(name="")] = LimitsRequest(),  # noqa: B008 (frozen)
    out: Out = Path("bench-motion"),
    python: str | None = None,
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """A folder of planning problems: the motions along their paths, how long they take and what they break or touch.

    Problems and options are those of 'plan'. Durations are set against stopping at every corner and, where it is
    installed, against toppra along the same curve; with --python also against roboplan's time parametrization over the
    same path. Contacts are looked for at 0.1 mm of motion by the library that has not planned. Writes motion.csv and
    motion.md.

    Args:
        folder: Folder of the problems.
        python: Python of an environment of its own with roboplan in it.
    """
    from benchmarks.motion.run import bench_motion

    return measure(out, lambda progress: bench_motion(folder, out, plain, limits, progress, python, workers))
