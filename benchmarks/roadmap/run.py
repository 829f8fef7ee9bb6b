"""Measures a kept roadmap, built and asked, against OMPL's PRM, each in its own process.

How. All methods get the same robot, scene, collision pairs and queries: random free starts and goals. Each runs in a
process of its own, one after the other; times are of the wall clock, once the libraries are loaded. Ours:
`planner.build_roadmap`, every edge proven; a query is `attach`, `build_network`, the field by GABF under the
singularity-free law, and the path. "Many starts" attaches all starts and one goal, computes one field, and reads every
path off it. OMPL's PRM has its defaults, its motions sampled at its default resolution, and a Python callback as state
check: "our checker" is the same as ours, "plain coal" asks Pinocchio about all pairs in turn, as its documentation
shows. A query is `solve` on the kept roadmap, which grows further where start and goal are not joined. Touching: edges,
at most 200 drawn at random, and answered paths, sampled every millimetre of motion by coal. Growth: roadmaps of ours of
more sizes, and whole plans, refined as by default, from the scene's start to its goal, each in a process of its own
whose peak memory is given. Limitations. OMPL's PRM alternates by the clock and is not reproducible. The roadmaps are
not alike: ours is sparse, grown from trees, and proven, theirs are denser, uniform, and not.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from benchmarks import bench
from benchmarks.roadmap.report import OURS, PEERS, PLAN, aims, fault, tables
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.problem.options import Backend
from planner.problem.request import RoadmapQuality, WorldRequest
from planner.query.query import make_checker_for


def roadmap(
    out: bench.Out = Path("bench-roadmap"),
    robot: str = "panda",
    scene: str = "shelf",
    collision: Backend = "coal",
    nodes: int = 1000,
    sizes: tuple[int, ...] = (),
    queries: int = 20,
    seed: int = 0,
    time_limit: float = 600.0,
    debug: bench.Debug = False,
) -> int:
    """A kept roadmap: building it and asking it, against OMPL's PRM.

    With --sizes 4000 20000 also how our time and memory grow. Writes roadmap.csv and roadmap.md.

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
    for size in (nodes, *sizes):
        RoadmapQuality(size, seed)  # refuses what is out of range
    if queries < 1 or not time_limit > 0:
        raise OptionError("give at least one query, and a time limit above 0 s.")
    make_checker_for(WorldRequest(robot, scene, collision=collision))  # refuses an unknown robot or scene
    methods = [(method, nodes) for method in (OURS, *PEERS)]
    methods += [(method, size) for size in dict.fromkeys((nodes, *sizes)) for method in (OURS, PLAN) if sizes]
    cases = []
    for method, size in dict.fromkeys(methods):
        asked = robot, scene, collision, size, queries, seed, time_limit
        options = {"method": method, "robot": robot, "scene": scene, "collision": collision, "nodes": size}
        names = "method robot scene collision nodes_asked queries seed time_limit_s"
        cases.append(
            bench.Case((bench.make_settings(names, method, *asked),), options | {"queries": queries, "seed": seed})
        )
    return bench.run_bench(BENCH, out, cases, partial(_measure, time_limit=time_limit))


def _measure(options: dict[str, Any], progress: Progress, time_limit: float) -> Any:
    return bench.measure_apart("benchmarks.roadmap.case", options, progress, time_limit)


BENCH = bench.Bench("roadmap", __doc__, tables, aims, fault)
