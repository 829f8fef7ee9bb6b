"""``benchmarks plan|first-motion|proofs|quality|motion|replan``: the benchmarks over a folder of planning problems."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.terminal import measure
from planner.cli.common import Flag, Workers
from planner.problem.request import PAPER_NODES, SERIAL, Backend, LimitsRequest, PlanRequest


def plan(
    folder: tyro.conf.Positional[Path],
    plain: Annotated[PlanRequest, tyro.conf.arg(name="")] = PlanRequest("panda"),  # noqa: B008 (frozen)
    out: Path = Path("bench-plan"),
    seeds: tuple[int, ...] = (0, 1, 2),
    time_limit: float = 60.0,
    workers: Workers = SERIAL,
    debug: Flag = False,
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
        out: Folder to write into.
        seeds: Seeds to plan every problem with.
        time_limit: Seconds after which a run is killed and recorded as timed out; the budget is in nodes and motions.
        debug: Show tracebacks of errors.
    """
    from benchmarks.plan.run import bench_plan

    return measure(out, lambda progress: bench_plan(folder, out, plain, seeds, time_limit, progress, workers))


def first_motion(
    folder: tyro.conf.Positional[Path],
    limits: Annotated[LimitsRequest, tyro.conf.arg(name="")] = LimitsRequest(),  # noqa: B008 (frozen)
    out: Path = Path("bench-first-motion"),
    robot: str = "panda",
    collision: Backend = "coal",
    python: tuple[str, ...] = (),
    seed: int = 0,
    seconds: float = 10.0,
    widen_limits: Flag = False,
    debug: Flag = False,
) -> int:
    """From a problem to a motion: ours, proven, beside OMPL's RRTConnect and planners of other environments.

    Problems are those of 'plan'. roboplan, pyroboplan and hpp take part where they are given, each in an
    environment of its own, as what they need clashes with this package:

    python -m benchmarks first-motion FOLDER --python roboplan=/opt/rp/bin/python hpp=/opt/hpp/bin/python

    Writes first-motion.csv, one row a run, and first-motion.md: the times of the stages, lengths and durations, what is
    proven, and how many paths and motions touch something when the other collision library looks closely.

    Args:
        folder: Folder of the problems.
        out: Folder to write into.
        robot: Name of a built-in robot or the path of a URDF.
        collision: Collision library to plan with; paths and motions are checked by the other one.
        python: NAME=PATH: a planner, roboplan, pyroboplan or hpp, and the Python of the environment it is installed in.
        seed: Seed of all planners.
        seconds: Seconds after which the other planners give up.
        widen_limits: Widen joint limits that a start or goal exceeds, instead of refusing it.
        debug: Show tracebacks of errors.
    """
    from benchmarks.first_motion.run import bench_first_motion, environments

    plain = PlanRequest(robot, collision=collision, seed=seed, widen_limits=widen_limits, path_only=True)
    pythons = environments(python)
    return measure(out, lambda progress: bench_first_motion(folder, out, plain, limits, pythons, seconds, progress))


def proofs(
    folder: tyro.conf.Positional[Path],
    python: str,
    out: Path = Path("bench-proofs"),
    robot: str = "panda",
    motions: int = 2000,
    seed: int = 0,
    widen_limits: Flag = False,
    debug: Flag = False,
) -> int:
    """Our proofs of straight motions against those of HPP, the other planner that proves, motion by motion.

    Problems are those of 'plan'; random motions are drawn in their scenes. Those that only one of the two
    proves are looked at by coal at every 0.1 mm. Writes proofs.csv, two rows a scene, and proofs.md.

    Args:
        folder: Folder of the problems.
        python: Python of an environment of its own with hpp-python in it.
        out: Folder to write into.
        robot: Name of a built-in robot or the path of a URDF.
        motions: Motions in all, shared out among the scenes.
        seed: Seed of the motions.
        widen_limits: Widen joint limits that a start or goal exceeds, instead of refusing it.
        debug: Show tracebacks of errors.
    """
    from benchmarks.proofs.run import bench_proofs

    plain = PlanRequest(robot, collision="coal", seed=seed, widen_limits=widen_limits)
    return measure(out, lambda progress: bench_proofs(folder, out, plain, python, motions, progress))


def quality(
    folder: tyro.conf.Positional[Path],
    out: Path = Path("bench-quality"),
    robot: str = "panda",
    collision: Backend = "coal",
    nodes: int = 1000,
    seed: int = 0,
    betas: tuple[float, ...] = (0.0, 0.25, 0.5, 1.0),
    efforts: tuple[int, ...] = (0, 12),
    seconds: float = 5.0,
    above_ends: Flag = False,
    widen_limits: Flag = False,
    workers: Workers = SERIAL,
    debug: Flag = False,
) -> int:
    """How good paths are: length, corners, manipulability and time, beside OMPL's RRTConnect, RRT* and BIT*.

    Problems are those of 'plan'. Writes quality.csv, one row a run, and quality.md: medians, and medians
    of ratios to RRTConnect with simplification on the same problem.

    Args:
        folder: Folder of the problems.
        out: Folder to write into.
        robot: Name of a built-in robot or the path of a URDF.
        collision: Collision library of all planners.
        nodes: Configurations in the roadmap.
        seed: Seed of all planners.
        betas: Trade-offs to plan at.
        efforts: Rounds of refinement and search to plan with.
        seconds: Processor time that OMPL's planners get.
        above_ends: Keep w above that of the lower end where such a path is found, as 'planner plan' has it.
        widen_limits: Widen joint limits that a start or goal exceeds, instead of refusing it.
        debug: Show tracebacks of errors.
    """
    from benchmarks.quality.run import bench_quality

    plain = PlanRequest(
        robot, collision=collision, nodes=nodes, seed=seed, widen_limits=widen_limits, above_ends=above_ends
    )
    return measure(out, lambda progress: bench_quality(folder, out, plain, betas, efforts, seconds, progress, workers))


def motion(
    folder: tyro.conf.Positional[Path],
    limits: Annotated[LimitsRequest, tyro.conf.arg(name="")] = LimitsRequest(),  # noqa: B008 (frozen)
    out: Path = Path("bench-motion"),
    robot: str = "panda",
    collision: Backend = "fcl",
    nodes: int = PAPER_NODES,
    beta: float = 0.5,
    min_manipulability: float = 0.0,
    margin: float = 0.0,
    widen_limits: Flag = False,
    seed: int = 0,
    python: str | None = None,
    workers: Workers = SERIAL,
    debug: Flag = False,
) -> int:
    """A folder of planning problems: the motions along their paths, how long they take and what they break or touch.

    A problem is as 'plan' has it. Durations are set against stopping at every corner and, where it is
    installed, against toppra along the same curve; with --python also against roboplan's time parametrization over the
    same path. Contacts are looked for at 0.1 mm of motion by the library that has not planned. Writes motion.csv and
    motion.md.

    Args:
        folder: Folder of the problems.
        out: Folder to write into.
        robot: Name of a built-in robot or the path of a URDF.
        collision: Collision library to plan and prove with.
        nodes: Configurations in the roadmap.
        beta: Trade-off in [0, 1]: 0 optimises manipulability only, 1 distance only.
        min_manipulability: A floor under manipulability w that paths and motions stay above; 0 for none.
        margin: Distance in metres to keep from every obstacle, and between links.
        widen_limits: Widen joint limits that a start or goal exceeds, instead of refusing it.
        seed: Seed to plan every problem with.
        python: Python of an environment of its own with roboplan in it.
        debug: Show tracebacks of errors.
    """
    from benchmarks.motion.run import bench_motion

    plain = PlanRequest(
        robot,
        collision=collision,
        margin=margin,
        widen_limits=widen_limits,
        nodes=nodes,
        seed=seed,
        min_manipulability=min_manipulability,
        beta=beta,
    )
    return measure(out, lambda progress: bench_motion(folder, out, plain, limits, progress, python, workers))


def replan(
    folder: tyro.conf.Positional[Path],
    out: Path = Path("bench-replan"),
    robot: str = "panda",
    collision: Backend = "coal",
    nodes: int = PAPER_NODES,
    changes: int = 100,
    simulations: int = 50,
    widen_limits: Flag = False,
    seed: int = 0,
    time_limit: float = 1200.0,
    workers: Workers = SERIAL,
    debug: Flag = False,
) -> int:
    """Problems whose world changes: time to a new proven path against planning anew, the field against D* Lite.

    Problems are those of 'plan'. Obstacles are moved, added, removed, and put on the route; then boxes
    move within their speed limits while the arm runs the last path. Writes replan.csv, one row a change, and replan.md.

    Args:
        folder: Folder of the problems.
        out: Folder to write into.
        robot: Name of a built-in robot or the path of a URDF.
        collision: Collision library to plan with; the paths are checked by the other one.
        nodes: Configurations in the roadmap.
        changes: Changes of each problem's world.
        simulations: Runs among moving boxes along each problem's last path.
        widen_limits: Widen joint limits that a start or goal exceeds, instead of refusing it.
        seed: Seed of the roadmaps and the changes.
        time_limit: Seconds after which a problem is killed and recorded as timed out.
        debug: Show tracebacks of errors.
    """
    from benchmarks.replan.run import bench_replan

    asked = folder, out, robot, collision, nodes, changes, simulations, seed, time_limit
    return measure(out, lambda progress: bench_replan(*asked, progress, workers, widen_limits))
