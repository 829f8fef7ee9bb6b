"""``planner bench``: measurements, as ratios within one run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Protocol, TypeVar

import tyro

from planner.base.progress import Progress
from planner.base.request import DEFAULT_CHARGE, PAPER_NODES, Backend, Charge, LimitsRequest, PlanRequest, WorldRequest
from planner.cli.common import Flag
from planner.cli.terminal import run_into, say

bench = tyro.extras.SubcommandApp()
bench.__doc__ = """Measure success, safety and speed; speed as ratios within one run.

Rows that the folder already holds are not measured again, so an interrupted run goes on where it stopped.
"""


@bench.command
def gabf(
    out: Path = Path("bench-gabf"),
    seed: int = 0,
    sizes: tuple[int, ...] = (1_000, 10_000, 100_000),
    debug: Flag = False,
) -> int:
    """The dynamics against SciPy's RK45 and scipy.sparse.csgraph.dijkstra on random geometric networks.

    Args:
        out: Folder to write into.
        seed: Seed of the networks.
        sizes: Numbers of nodes; 1000000 takes minutes and 1.3 GiB.
        debug: Show tracebacks of errors.
    """

    from planner.studies.bench_gabf.run import bench_gabf

    return measure(out, lambda progress: bench_gabf(out, sizes, seed=seed, progress=progress))


@bench.command
def plan(
    folder: tyro.conf.Positional[Path],
    out: Path = Path("bench-plan"),
    robot: str = "panda",
    collision: Backend = "fcl",
    nodes: int = PAPER_NODES,
    beta: float = 0.5,
    charge: Charge = DEFAULT_CHARGE,
    min_manipulability: float = 0.0,
    margin: float = 0.0,
    srdf: Path | None = None,
    group: str | None = None,
    base: str | None = None,
    widen_limits: Flag = False,
    seeds: tuple[int, ...] = (0, 1, 2),
    time_limit: float = 60.0,
    jobs: int = 1,
    debug: Flag = False,
) -> int:
    """A folder of planning problems, each planned with several seeds: success, times, lengths, manipulability, safety.

    A problem is request<X>.yaml, a MoveIt motion plan request, with scene<X>.yaml or scene<X>.scene beside it, in
    FOLDER or in folders inside it, which are the scene types. Run again with another --beta, --nodes or --collision
    and the same --out, and the report sets them side by side. Writes plan.csv, one row a run, plan.md, and
    logs/<problem>.log for ompl_benchmark_statistics and Planner Arena.

    Args:
        folder: Folder of the problems.
        out: Folder to write into.
        robot: Name of a built-in robot or the path of a URDF.
        collision: Collision library to plan with; the paths are checked by the other one.
        nodes: Configurations in the roadmap.
        beta: Trade-off in [0, 1]: 0 optimises manipulability only, 1 distance only.
        charge: Where the manipulability cost is charged: integrated along edges, or at nodes as in the paper.
        min_manipulability: A floor under manipulability w that paths stay above, as 'planner plan' has it; 0 for none.
        margin: Distance in metres to keep from every obstacle, and between links.
        srdf: An SRDF in place of the robot's own: link pairs that need no check, groups.
        group: Planning group of the SRDF: only its joints are planned.
        base: Where the robot's base stands in the scenes: x,y,z (m) or x,y,z,roll,pitch,yaw (m and rad).
        widen_limits: Widen joint limits that a start or goal exceeds, instead of refusing it.
        seeds: Seeds to plan every problem with.
        time_limit: Seconds after which a run is killed and recorded as timed out; the budget is in nodes and motions.
        jobs: Runs at once; their seconds are then those of a busy machine, all else is the same.
        debug: Show tracebacks of errors.
    """

    from planner.studies.bench_plan.run import bench_plan

    plain = PlanRequest(
        robot,
        collision=collision,
        margin=margin,
        srdf=srdf,
        group=group,
        base=base,
        widen_limits=widen_limits,
        nodes=nodes,
        min_manipulability=min_manipulability,
        charge=charge,
        beta=beta,
    )
    return measure(out, lambda progress: bench_plan(folder, out, plain, seeds, time_limit, progress, jobs))


@bench.command
def quality(
    folder: tyro.conf.Positional[Path],
    out: Path = Path("bench-quality"),
    robot: str = "panda",
    collision: Backend = "coal",
    nodes: int = 1000,
    seed: int = 0,
    betas: tuple[float, ...] = (0.0, 0.25, 0.5, 1.0),
    efforts: tuple[int, ...] = (0, 6),
    seconds: float = 5.0,
    above_ends: Flag = False,
    widen_limits: Flag = False,
    debug: Flag = False,
) -> int:
    """How good paths are: length, corners, manipulability and time, beside OMPL's RRTConnect, RRT* and BIT*.

    Problems are those of 'planner bench plan'. Writes quality.csv, one row a run, and quality.md: medians, and medians
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
    from planner.studies.bench_quality.run import bench_quality

    plain = PlanRequest(
        robot, collision=collision, nodes=nodes, seed=seed, widen_limits=widen_limits, above_ends=above_ends
    )
    return measure(out, lambda progress: bench_quality(folder, out, plain, betas, efforts, seconds, progress))


@bench.command
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
    debug: Flag = False,
) -> int:
    """A folder of planning problems: the motions along their paths, how long they take and what they break or touch.

    A problem is as 'planner bench plan' has it. Durations are set against stopping at every corner and, where it is
    installed, against toppra along the same rounded path; contacts are looked for at 0.1 mm of motion by the library
    that has not planned. Writes motion.csv and motion.md.

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
        debug: Show tracebacks of errors.
    """
    from planner.studies.bench_motion.run import bench_motion

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
    return measure(out, lambda progress: bench_motion(folder, out, plain, limits, progress))


@bench.command
def misses(
    out: Path = Path("bench-misses"),
    seed: int = 0,
    edges: int = 40,
    robots: tuple[str, ...] = ("iiwa14", "panda", "ur5", "planar_2r", "kinova"),
    thicknesses: tuple[float, ...] = (1.0, 2.0, 3.0, 4.0, 5.0),
    debug: Flag = False,
) -> int:
    """Edges past walls, poles and windows of a few millimetres: which of those called free touch at 0.1 mm of motion.

    Of the edges that the proof certifies, with either collision library, none may touch as the other one sees it; of
    those that OMPL's default resolution calls free some do. Writes misses.csv and misses.md.

    Args:
        out: Folder to write into.
        seed: Seed of obstacles and edges.
        edges: Edges for each robot, kind of obstacle and thickness.
        robots: Names of built-in robots or paths of URDFs.
        thicknesses: Of the obstacles, in millimetres.
        debug: Show tracebacks of errors.
    """

    from planner.studies.bench_misses.run import bench_misses

    return measure(out, lambda progress: bench_misses(out, edges, robots, thicknesses, seed, progress))


@bench.command
def attack(
    out: Path = Path("bench-attack"),
    seed: int = 0,
    tries: int = 1000,
    segments: int = 100,
    robots: tuple[str, ...] = ("planar_2r", "iiwa14"),
    libraries: tuple[Backend, ...] = ("fcl", "coal"),
    debug: Flag = False,
) -> int:
    """An optimiser against every claim that proofs rest on: distances, bounds, motions, and segments called free.

    It looks for the largest claim minus truth over shapes, sizes and poses, for every pair of kinds of shapes and both
    collision libraries; the truth is computed by a slow method of its own that proves it. Writes attack.csv and
    attack.md.

    Args:
        out: Folder to write into.
        seed: Seed of the searches.
        tries: Pairs of shapes for each two kinds and library, and motions of each robot.
        segments: Segments put to the proof for each two kinds of shapes, and each robot, and library.
        robots: Names of built-in robots or paths of URDFs whose segments and reach are attacked too.
        libraries: Collision libraries to attack.
        debug: Show tracebacks of errors.
    """

    from planner.studies.bench_attack.run import bench_attack

    return measure(out, lambda progress: bench_attack(out, tries, segments, robots, libraries, seed, progress))


@bench.command
def agreement(
    out: Path = Path("bench-agreement"),
    seed: int = 0,
    states: int = 100_000,
    robots: tuple[str, ...] = (),
    scenes: tuple[str, ...] = (),
    margin: float = 0.0,
    debug: Flag = False,
) -> int:
    """FCL against coal on random configurations of every robot in every scene: verdicts, contact band, speed.

    Every disagreement is listed with the pair that one of them finds touching, as both measure it. Compared are
    verdicts on single states, neither distances nor proofs of motions: 'planner bench attack' is for those. Writes
    agreement.csv and agreement.md.

    Args:
        out: Folder to write into.
        seed: Seed of the configurations.
        states: Configurations in all, shared out among the robots and scenes.
        robots: Names of built-in robots or paths of URDFs; all built-in ones where none is given.
        scenes: Names of built-in scenes or paths of scene files; all built-in ones where none is given.
        margin: Distance in metres below which a pair counts as touching.
        debug: Show tracebacks of errors.
    """

    from planner.studies.bench_agreement.run import bench_agreement

    return measure(out, lambda progress: bench_agreement(out, states, robots, scenes, margin, seed, progress))


@bench.command
def fuzz(
    out: Path = Path("bench-fuzz"),
    seed: int = 0,
    cases: int = 20_000,
    kinds: tuple[str, ...] = (),
    debug: Flag = False,
) -> int:
    """Files of every kind, changed at random: loading one ends in success or in one sentence, and in nothing else.

    Robots, scenes, meshes, requests, roadmaps and paths lose, double or rename parts, get huge, NaN or negative
    numbers, deep nesting, and cut or changed bytes. Writes fuzz.md, and the files that ended otherwise. Exit code 4
    where there are such files.

    Args:
        out: Folder to write into.
        seed: Seed of the changes.
        cases: Files to try.
        kinds: Kinds of files to try, as the report names them; all where none is given.
        debug: Show tracebacks of errors.
    """
    from planner.studies.bench_fuzz.run import bench_fuzz

    result = measured(out, lambda progress: bench_fuzz(out, cases, seed, kinds, progress))
    return 130 if not result.complete else 4 * bool(result.failures)


@bench.command
def roadmap(
    out: Path = Path("bench-roadmap"),
    robot: str = "panda",
    scene: str = "shelf",
    collision: Backend = "coal",
    nodes: int = 1000,
    queries: int = 20,
    seed: int = 0,
    time_limit: float = 600.0,
    debug: Flag = False,
) -> int:
    """A kept roadmap: building it and asking it, against the PRMs of OMPL and of pyroboplan, where that is installed.

    Also the speed of the state checks of both collision libraries on the same edges. Writes roadmap.csv and roadmap.md.

    Args:
        out: Folder to write into.
        robot: Name of a built-in robot or the path of a URDF.
        scene: Name of a built-in scene or the path of a scene file.
        collision: Collision library.
        nodes: Configurations in each roadmap.
        queries: Random starts and goals that each roadmap is asked about.
        seed: Seed of the roadmaps and the queries.
        time_limit: Seconds after which a method is killed and recorded as timed out.
        debug: Show tracebacks of errors.
    """

    from planner.studies.bench_roadmap.run import bench_roadmap

    world = WorldRequest(robot, scene, collision=collision)
    return measure(out, lambda progress: bench_roadmap(out, world, nodes, queries, seed, time_limit, progress))


@bench.command
def replan(
    folder: tyro.conf.Positional[Path],
    out: Path = Path("bench-replan"),
    robot: str = "panda",
    collision: Backend = "coal",
    nodes: int = PAPER_NODES,
    changes: int = 100,
    seed: int = 0,
    time_limit: float = 1200.0,
    debug: Flag = False,
) -> int:
    """Problems whose world changes: time to a new proven path against planning anew, the field against D* Lite.

    Problems are those of 'planner bench plan'. Obstacles are moved, added, removed, and put on the route. Writes
    replan.csv, one row a change, and replan.md.

    Args:
        folder: Folder of the problems.
        out: Folder to write into.
        robot: Name of a built-in robot or the path of a URDF.
        collision: Collision library to plan with; the paths are checked by the other one.
        nodes: Configurations in the roadmap.
        changes: Changes of each problem's world.
        seed: Seed of the roadmaps and the changes.
        time_limit: Seconds after which a problem is killed and recorded as timed out.
        debug: Show tracebacks of errors.
    """

    from planner.studies.bench_replan.run import bench_replan

    return measure(
        out,
        lambda progress: bench_replan(folder, out, robot, collision, nodes, changes, seed, time_limit, progress),
    )


class Measured(Protocol):
    """What a benchmark returns: its report, Markdown, and whether that is all that was asked for."""

    @property
    def report(self) -> str: ...
    @property
    def complete(self) -> bool: ...


M = TypeVar("M", bound=Measured)


def measured(folder: Path, run: Callable[[Progress], M]) -> M:
    """The result of a benchmark that writes into ``folder``; its report is shown."""
    result = run_into(folder, run)
    say(result.report)
    return result


def measure(folder: Path, run: Callable[[Progress], Measured]) -> int:
    """Run a benchmark and show its report; the exit code tells whether it is complete."""
    return 0 if measured(folder, run).complete else 130
