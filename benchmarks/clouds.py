"""Measures plans among points that were sampled on the true shapes, and looks for contacts with these shapes.

How. VAMP's recipe: 10,000 samples on the surface of each obstacle (trimesh, seed 0), of which some are dropped until no
two are nearer than a filter. The radius is the covering radius, by 200,000 more samples; the estimate that a user gets
without giving one; or VAMP's 2.5 mm. Each problem is planned with `--path-only` by this package in one process, robot
and libraries in memory, after one plan that is not counted. Ready is from the points to a checker, first from there to
the first proven path; medians of the wall clock, to be read as ratios. Contacts: path segments on which coal, with the
true shapes, finds a contact at every millimetre of motion. Limitations. The true shapes are primitives: their samples
are without noise. With a covering radius near the distance of a start or goal to an obstacle the problem is refused.

Columns. ``outcome`` and ``message``; ``points``, their ``radius_mm`` and true covering radius ``covering_mm``;
``ready_s`` and ``first_s``; ``contacts`` with the true shapes.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import trimesh
from scipy.spatial import KDTree

from benchmarks import bench
from benchmarks.looks import FirstPath, other_checker, path_contacts
from benchmarks.problems import Problem, find_problems
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.progress import Progress
from planner.batch.run import NO_PATH, REFUSED, SOLVED
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, RoadmapRequest
from planner.problem.targets import joints_text
from planner.query.query import make_query
from planner.robot.clouds import Points
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Cylinder, Mesh, Obstacle, Shape, Sphere

TRUE, COVERING, ESTIMATED, VAMP = "true shapes", "covering radius", "estimated radius", "2.5 mm (VAMP)"
_DENSE = 200_000  # samples that stand for the surface


def clouds(
    folder: bench.Folder,
    plain: Annotated[RoadmapRequest, bench.Flat] = RoadmapRequest.from_options(robot="panda", collision="coal"),  # noqa: B008 (frozen)
    out: bench.Out = Path("bench-clouds"),
    filters: tuple[float, ...] = (5.0, 20.0),
    samples: int = 10_000,
    debug: bench.Debug = False,
) -> int:
    """Plan in worlds of points, and count contacts with the true shapes.

    Writes clouds.csv, a row per problem and world, and clouds.md: success, times, radii and contacts per world.

    Args:
        folder: Folder of the problems.
        filters: Smallest distances of two points, mm.
        samples: Samples on the surface of each obstacle.
    """
    request, cases = PlanRequest.from_options(**plain.values(), path_only=True), []
    bench.require_left_to_problems(request)
    worlds = [(TRUE, 0.0), *itertools.product((COVERING, ESTIMATED, VAMP), filters)]
    for problem, (world, filter_mm) in itertools.product(find_problems(folder), worlds):
        row = bench.make_settings("problem world filter_mm samples", problem.name, world, filter_mm, samples)
        cases.append(bench.Case((row,), (problem, request, row)))
    return bench.run_bench(BENCH, out, cases, measure)


def measure(task: tuple[Problem, PlanRequest, bench.Row], progress: Progress) -> bench.Columns:
    """Return the columns of one row."""
    problem, plain, row = task
    try:
        query = make_query(problem.asked(plain).what)
    except PlannerError as error:
        return {"outcome": REFUSED, "message": str(error)}
    columns: bench.Columns = {}
    scene = replace(query.scene, carried=())
    if row.world != TRUE:
        xyz, dense = sample_surfaces(scene, row.samples, row.filter_mm * 1e-3)
        covering = float(KDTree(xyz).query(dense)[0].max()) * (1 + 1e-9)
        radius = {COVERING: covering, ESTIMATED: None, VAMP: 2.5e-3}[row.world]
        cloud = Points(xyz, radius)
        scene = replace(scene, obstacles=(Obstacle("cloud", cloud, np.eye(4)),), notes=())
        columns = {"points": len(xyz), "radius_mm": 1e3 * cloud.radius, "covering_mm": 1e3 * covering}
    ends = {"start": joints_text(query.starts[0]), "goal": joints_text(query.goals[0])}
    asked = plain.with_options(robot=query.robot, scene=scene, **ends)
    watch, begin = FirstPath(), time.perf_counter()
    try:
        found = plan(request=asked, progress=Progress(watch, lambda: progress.stopped), timing=None)
    except PlannerError as error:
        return columns | {"outcome": REFUSED, "message": str(error)}
    columns |= {"ready_s": found.timings["setup"]}
    if not found.solved:
        return columns | {"outcome": NO_PATH, "message": found.message}
    seconds = time.perf_counter() - begin if watch.seconds is None else watch.seconds
    judge = other_checker(query.robot, query.scene, plain.what.collision)
    contacts = path_contacts(judge, found.path)
    return columns | {"outcome": SOLVED, "first_s": seconds - columns["ready_s"], "contacts": len(contacts)}


def sample_surfaces(scene: Scene, samples: int, spacing: float) -> tuple[Floats, Floats]:
    """Return points (n, 3), no two of an obstacle nearer than ``spacing`` (m), and denser samples of the surface."""
    points, dense = [], []
    for item in scene.obstacles:
        mesh = surface_of(item.shape)
        mesh.apply_transform(item.placement)
        drawn = np.asarray(trimesh.sample.sample_surface(mesh, samples, seed=0)[0])
        points.append(drawn[_thin(drawn, spacing)])
        dense.append(np.asarray(trimesh.sample.sample_surface(mesh, _DENSE // len(scene.obstacles), seed=1)[0]))
    return np.concatenate(points), np.concatenate(dense)


def _thin(points: Floats, spacing: float) -> np.ndarray:
    """Return which points (n,) stay when each drops all later ones that are nearer than ``spacing`` (m)."""
    stay, tree = np.ones(len(points), dtype=bool), KDTree(points)
    for k, near in enumerate(tree.query_ball_point(points, spacing)):
        if stay[k]:
            stay[[j for j in near if j > k]] = False
    return stay


def surface_of(shape: Shape) -> Any:
    """Return a shape as a mesh of trimesh, in its own frame; round ones as polygons that lie on the surface."""
    match shape:
        case Box(size):
            return trimesh.creation.box(size)
        case Cylinder(radius, length):
            return trimesh.creation.cylinder(radius, length, sections=128)
        case Sphere(radius):
            return trimesh.creation.icosphere(4, radius)
        case Mesh(vertices, triangles):
            return trimesh.Trimesh(vertices, triangles, process=False)
    raise TypeError(f"no surface is made of a {type(shape).__name__}.")


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """Return a line per world and filter."""
    columns = {
        "problems": len,
        "solved": bench.total(lambda row: row.outcome == SOLVED),
        "points": bench.middle("points"),
        "radius (mm)": bench.middle("radius_mm"),
        "ready (ms)": bench.middle("ready_s", 1e3),
        "first path (ms)": bench.middle("first_s", 1e3),
        "contacts": bench.total("contacts"),
        "estimate below truth": bench.total(_is_below),
    }
    return bench.table(rows, ("world", "filter_mm"), columns)


def _is_below(row: bench.Row) -> bool | None:
    return None if row.radius_mm is None or row.covering_mm is None else row.radius_mm < row.covering_mm


def aims(rows: Sequence[bench.Row]) -> list[Any]:
    """Return the promise: no contact with the true shapes where the radius is the covering radius."""
    safe = [row.contacts == 0 for row in rows if row.world == COVERING and row.contacts is not None]
    return [bench.tally("paths at the covering radius touch none of the true shapes.", safe, "")]


def fault(row: bench.Row) -> str:
    """Return a sentence on a contact that the promise rules out."""
    if row.world != COVERING or not row.contacts:
        return ""
    return f"{row.problem}, filter {row.filter_mm:g} mm: {row.contacts} contacts."


BENCH = bench.Bench("clouds", __doc__, tables, aims, fault, must_hold=True)
