"""``python -m benchmarks``: measurements, as ratios within one run."""

from __future__ import annotations

from pathlib import Path

import tyro

from benchmarks.problem_commands import first_motion, motion, plan, proofs, quality
from benchmarks.terminal import measure, measured
from planner.cli.common import Debug, Out, Workers
from planner.problem.request import SERIAL, Backend, WorldRequest


def gabf(
    out: Out = Path("bench-gabf"),
    seed: int = 0,
    sizes: tuple[int, ...] = (1_000, 4_000, 10_000, 20_000, 100_000),
    debug: Debug = False,
) -> int:
    """The dynamics against SciPy's RK45 and scipy.sparse.csgraph.dijkstra on random geometric networks.

    Args:
        seed: Seed of the networks.
        sizes: Numbers of nodes; 1000000 takes minutes and 1.3 GiB.
    """
    from benchmarks.gabf.run import bench_gabf

    return measure(out, lambda progress: bench_gabf(out, sizes, seed=seed, progress=progress))


def optimum(
    out: Out = Path("bench-optimum"),
    nodes: tuple[int, ...] = (1000, 5000),
    efforts: tuple[int, ...] = (6, 30),
    betas: tuple[float, ...] = (0.0, 1.0),
    seeds: tuple[int, ...] = (0, 1, 2),
    arms: tuple[str, ...] = ("planar_2r", "planar_3r"),
    debug: Debug = False,
) -> int:
    """Planar arms with two and three joints against the optimum of a fine grid: the gap, and how it falls with effort.

    The grid has its own geometry and manipulability, computed in the plane. Writes optimum.csv, one row a plan, and
    optimum.md.

    Args:
        nodes: Configurations in the roadmaps.
        efforts: Rounds of refinement and search to plan with.
        betas: Trade-offs to plan at.
        seeds: Seeds to plan with.
        arms: Which arms, planar_2r or planar_3r.
    """
    from benchmarks.optimum.run import bench_optimum

    return measure(out, lambda progress: bench_optimum(out, nodes, efforts, betas, seeds, arms, progress))


def misses(
    out: Out = Path("bench-misses"),
    seed: int = 0,
    edges: int = 40,
    robots: tuple[str, ...] = ("iiwa14", "panda", "ur5", "planar_2r", "kinova"),
    thicknesses: tuple[float, ...] = (1.0, 2.0, 3.0, 4.0, 5.0),
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """Edges past walls, poles and windows of a few millimetres: which of those called free touch at 0.1 mm of motion.

    Of the edges that the proof certifies, with either collision library, none may touch as the other one sees it; of
    those that OMPL's default resolution calls free some do. Writes misses.csv and misses.md.

    Args:
        seed: Seed of obstacles and edges.
        edges: Edges for each robot, kind of obstacle and thickness.
        robots: Names of built-in robots or paths of URDFs.
        thicknesses: Of the obstacles, in millimetres.
    """
    from benchmarks.misses.run import bench_misses

    return measure(out, lambda progress: bench_misses(out, edges, robots, thicknesses, seed, progress, workers))


def attack(
    out: Out = Path("bench-attack"),
    seed: int = 0,
    tries: int = 1000,
    segments: int = 100,
    robots: tuple[str, ...] = ("planar_2r", "iiwa14"),
    libraries: tuple[Backend, ...] = ("fcl", "coal"),
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """An optimiser against every claim that proofs rest on: distances, bounds, motions, and segments called free.

    It looks for the largest claim minus truth over shapes, sizes and poses, for every pair of kinds of shapes and both
    collision libraries; the truth is computed by a slow method of its own that proves it. Writes attack.csv and
    attack.md.

    Args:
        seed: Seed of the searches.
        tries: Pairs of shapes for each two kinds and library, and motions of each robot.
        segments: Segments put to the proof for each two kinds of shapes, and each robot, and library.
        robots: Names of built-in robots or paths of URDFs whose segments and reach are attacked too.
        libraries: Collision libraries to attack.
    """
    from benchmarks.attack.run import bench_attack

    return measure(out, lambda progress: bench_attack(out, tries, segments, robots, libraries, seed, progress, workers))


def agreement(
    out: Out = Path("bench-agreement"),
    seed: int = 0,
    states: int = 100_000,
    robots: tuple[str, ...] = (),
    scenes: tuple[str, ...] = (),
    margin: float = 0.0,
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """FCL against coal on random configurations of every robot in every scene: verdicts, contact band, speed.

    Every disagreement is listed with the pair that one of them finds touching, as both measure it. Compared are
    verdicts on single states, neither distances nor proofs of motions: 'attack' is for those. Writes
    agreement.csv and agreement.md.

    Args:
        seed: Seed of the configurations.
        states: Configurations in all, shared out among the robots and scenes.
        robots: Names of built-in robots or paths of URDFs; all built-in ones where none is given.
        scenes: Names of built-in scenes or paths of scene files; all built-in ones where none is given.
        margin: Distance in metres below which a pair counts as touching.
    """
    from benchmarks.agreement.run import bench_agreement

    return measure(out, lambda progress: bench_agreement(out, states, robots, scenes, margin, seed, progress, workers))


def certificate(
    out: Out = Path("bench-certificate"),
    changes: int = 10_000,
    robots: tuple[str, ...] = ("iiwa14", "panda", "ur5"),
    scenes: tuple[str, ...] = ("shelf", "table"),
    seed: int = 0,
    debug: Debug = False,
) -> int:
    """Certificates of plans: what they cost, and whether one that was changed and is false is ever accepted.

    Changes are made at random, and by an adversary who looks for the largest one that is still accepted; whatever is
    accepted is judged by another method. What was tried is kept in --out, and not tried again. Writes certificate.md.
    Exit code 4 where a false one was accepted.

    Args:
        changes: Changed certificates to try.
        robots: Robots to plan with.
        scenes: Scenes to plan in, each with each robot.
        seed: Seed of the plans and the changes.
    """
    from benchmarks.certificate.run import bench_certificate

    result = measured(out, lambda progress: bench_certificate(out, changes, robots, scenes, seed, progress))
    return 130 if not result.complete else 4 * bool(result.attack.false)


def roadmap(
    out: Out = Path("bench-roadmap"),
    robot: str = "panda",
    scene: str = "shelf",
    collision: Backend = "coal",
    nodes: int = 1000,
    sizes: tuple[int, ...] = (),
    queries: int = 20,
    seed: int = 0,
    time_limit: float = 600.0,
    debug: Debug = False,
) -> int:
    """A kept roadmap: building it and asking it, against the PRMs of OMPL and of pyroboplan, where that is installed.

    Also the speed of the state checks of both collision libraries on the same edges, and with --sizes 4000 20000 how
    our time and memory grow. Writes roadmap.csv and roadmap.md.

    Args:
        robot: Name of a built-in robot or the path of a URDF.
        scene: Name of a built-in scene or the path of a scene file.
        collision: Collision library.
        nodes: Configurations in each roadmap.
        sizes: Configurations in further roadmaps of ours, each built, asked, and planned on from the scene's start.
        queries: Random starts and goals that each roadmap is asked about.
        seed: Seed of the roadmaps and the queries.
        time_limit: Seconds after which a method is killed and recorded as timed out.
    """
    from benchmarks.roadmap.run import bench_roadmap

    world = WorldRequest(robot, scene, collision=collision)
    return measure(out, lambda progress: bench_roadmap(out, world, nodes, queries, seed, time_limit, progress, sizes))


def tables(
    folder: tyro.conf.Positional[Path | None] = None,
    out: Out = Path("bench-tables"),
    nodes: int = 1000,
    betas: tuple[float, ...] = (1.0, 0.5, 0.0),
    seed: int = 0,
    debug: Debug = False,
) -> int:
    """Problems that were published with results: ours beside the published numbers, their sources, and what differs.

    The five tasks of the GCS paper on the iiwa 14; with a FOLDER, its problems for the Panda, as 'plan'
    has them, beside what VAMP publishes for MotionBenchMaker's. Writes tables.csv and tables.md, which also names what
    could not be had.

    Args:
        folder: Folder of MotionBenchMaker's problems for the Panda; the tables of these are left out without it.
        nodes: Configurations in the roadmaps.
        betas: Trade-offs to plan at.
        seed: Seed of the roadmaps.
    """
    from benchmarks.tables.run import bench_tables

    return measure(out, lambda progress: bench_tables(out, folder, nodes, betas, seed, progress))


def tool_paths(
    out: Out = Path("bench-tool-paths"),
    robots: tuple[str, ...] = ("panda", "iiwa14", "ur5"),
    scenes: tuple[str, ...] = ("empty", "table"),
    kinds: tuple[str, ...] = ("raster", "line", "circle"),
    paths: int = 3,
    seed: int = 0,
    python: tuple[str, ...] = (),
    debug: Debug = False,
) -> int:
    """Rasters, lines and circles of the tool: what share is followed, how fast, and what a judge of its own sees.

    It looks at the motion every 0.05 mm. Writes tool-paths.csv, one row a path, and tool-paths.md.

    Args:
        robots: Names of built-in robots.
        scenes: Names of built-in scenes.
        kinds: Kinds of paths.
        paths: Paths of each kind, for every robot in every scene.
        seed: Seed of the first path.
        python: roboplan=PATH, the Python of an environment with roboplan, whose Cartesian planner is asked too.
    """
    from benchmarks.first_motion.run import environments
    from benchmarks.tool_paths.run import bench_tool_paths

    other = environments(python).get("roboplan", "")
    return measure(out, lambda progress: bench_tool_paths(out, robots, scenes, kinds, paths, seed, other, progress))


def gate(
    out: Out = Path("bench-gate"),
    chunks: int = 300,
    attack: int = 300,
    robots: tuple[str, ...] = ("panda",),
    steps: int = 50,
    seed: int = 0,
    workers: Workers = SERIAL,
    python: str | None = None,
    debug: Debug = False,
) -> int:
    """Verdicts on chunks of joint targets: how long they take, what they refuse without need, and an attack on them.

    A chunk is a random motion among ten boxes, on one thread, with a stop proven from every target. An optimiser then
    moves targets and thin obstacles towards a chunk that is called safe and touches, as coal and FCL see it every 0.05
    mm of the controller's own splines. Writes gate.csv, one row for lines, cubics and quintics each, and gate.md.

    Args:
        chunks: Chunks of each kind to time and to look at; run it on a quiet machine.
        attack: Cases of each kind that the optimiser tries; 10 ms each for a Panda.
        robots: Names of built-in robots or paths of URDFs.
        steps: Targets in a chunk, 1/30 s apart.
        seed: Seed of chunks and obstacles.
        python: Python of an environment of its own with hpp-python in it, to prove the same lines.
    """
    from benchmarks.gate.run import bench_gate

    asked = chunks, attack, robots, steps, seed
    return measure(out, lambda progress: bench_gate(out, *asked, progress, workers, python))


def tasks(
    out: Out = Path("bench-tasks"),
    scenes: int = 8,
    nodes: int = 500,
    seed: int = 0,
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """Something taken and put elsewhere in seeded scenes: success, contacts, times, and against a greedy chain.

    Writes tasks.csv, one row a task, and tasks.md.

    Args:
        scenes: Scenes of each kind: things on a table, in a bin, on a shelf.
        nodes: Configurations in the roadmaps.
        seed: Seed of scenes and roadmaps.
    """
    from benchmarks.tasks.run import bench_tasks

    return measure(out, lambda progress: bench_tasks(out, scenes, nodes, seed=seed, progress=progress, workers=workers))


bench = tyro.extras.SubcommandApp()
bench.command(gabf)
bench.command(plan)
bench.command(first_motion)
bench.command(proofs)
bench.command(quality)
bench.command(optimum)
bench.command(motion)
bench.command(misses)
bench.command(gate)
bench.command(attack)
bench.command(agreement)
bench.command(certificate)
bench.command(roadmap)
bench.command(tables)
bench.command(tool_paths)
bench.command(tasks)


def run(arguments: list[str]) -> int:
    """The exit code of the benchmark that ``arguments`` ask for; help and what is wrong with them ends the process."""
    return bench.cli(
        prog="python -m benchmarks",
        description="Measure success, safety and speed; speed as ratios within one run. Rows that the folder already "
        "holds are not measured again, so an interrupted run goes on where it stopped.",
        args=arguments,
    )
