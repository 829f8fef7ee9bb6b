"""Measures plans in worlds that sensors see, and looks for contacts with the true shapes.

How. VAMP's recipe: 10,000 samples on the surface of each obstacle (trimesh, seed 0), of which some are dropped until no
two are nearer than a filter; and 100,000 with a filter of 5 mm. The radius is the covering radius, by 200,000 more
samples; the estimate that a user gets without giving one; or VAMP's 2.5 mm. "Target touched": the obstacle nearest to
the hand at the goal is a declared region that the last link and what it holds may touch. Depth images: 320 x 240 rays
from above the robot's base, against the true shapes in closed form, with noise of 1 mm (at most 2 mm, declared), 2 % of
the pixels and some blobs missing; single ones are filled with the least of their neighbours. What is behind stays
unseen, free or solid as ``unknown`` says, except within 50 mm of the arm at its start. Each problem is planned with
`--path-only` in one process, robot and libraries in memory, after one plan that is not counted. OMPL:
RRTConnect with its defaults on the same samples (10,000, filter 5 mm) as coal's octree of 25 mm, states checked by
Pinocchio's loop. Ready is from the points to a checker, first from there to the first path, proven where it is ours;
medians of the wall clock, to be read as ratios: first path over OMPL's is the median over problems that both solve.
Contacts: path segments on which coal, with the true shapes, finds a contact at every millimetre of motion. Limitations.
The true shapes are primitives: samples on them have no noise. With a covering radius near the distance of a start or
goal to an obstacle the problem is refused.

Columns. ``outcome`` and ``message``; ``points``, their ``radius_mm`` and true covering radius ``covering_mm``;
``ready_s`` and ``first_s``; ``contacts`` with the true shapes.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import coal
import numpy as np
import pinocchio as pin
import trimesh
from scipy.ndimage import minimum_filter
from scipy.spatial import KDTree

from benchmarks import bench
from benchmarks.looks import FirstPath, other_checker, path_contacts
from benchmarks.others.ompl import OmplConnect
from benchmarks.problems import Problem, find_problems
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.progress import Progress
from planner.batch.run import NO_PATH, REFUSED, SOLVED
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalChecker
from planner.collision.self_filter import without_robot
from planner.kinematics.forward import joint_placements
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, RoadmapRequest
from planner.problem.targets import joints_text
from planner.query.query import Query, make_query
from planner.robot.clouds import Points, split_regions
from planner.robot.depth_image import DepthImage
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Cylinder, Mesh, Obstacle, Shape, Sphere

TRUE, COVERING, ESTIMATED, VAMP = "true shapes", "covering radius", "estimated radius", "2.5 mm (VAMP)"
TARGET, FREE, SOLID, OMPL = "target touched", "depth, unknown free", "depth, unknown solid", "OMPL, coal's octree"
_SAFE = (COVERING, TARGET)
_RADII = {ESTIMATED: None, VAMP: 2.5e-3}
_DENSE = 200_000  # samples that stand for the surface
_VIEW = (240, 320), (280.0, 280.0, 160.0, 120.0), 2.5  # pixels, intrinsics, far limit in m
_NOISE, _MARGIN = 1e-3, 0.05  # m of noise, and around the arm where it stood
_CELL, _WAIT = 0.025, 10.0  # m of an octree's cells, and s for OMPL


def clouds(
    folder: bench.Folder,
    plain: Annotated[RoadmapRequest, bench.Flat] = RoadmapRequest.from_options(robot="panda", collision="coal"),  # noqa: B008 (frozen)
    out: bench.Out = Path("bench-clouds"),
    filters: tuple[float, ...] = (5.0, 20.0),
    samples: int = 10_000,
    dense_samples: int = 100_000,
    debug: bench.Debug = False,
) -> int:
    """Plan in worlds of points, and count contacts with the true shapes.

    Writes clouds.csv, a row per problem and world, and clouds.md: success, times, radii and contacts per world.

    Args:
        folder: Folder of the problems.
        filters: Smallest distances of two points, mm.
        samples: Samples on the surface of each obstacle.
        dense_samples: The same where the covering radius is to be small.
    """
    request, cases = PlanRequest.from_options(**plain.values(), path_only=True), []
    bench.require_left_to_problems(request)
    sampled = [(*world, samples) for world in itertools.product((COVERING, ESTIMATED, VAMP), filters)]
    dense = [(world, min(filters, default=0.0), dense_samples) for world in (COVERING, TARGET)]
    images = [(FREE, 0.0, 0), (SOLID, 0.0, 0)]
    worlds = [(TRUE, 0.0, 0), *sampled, *dense, *images, (OMPL, min(filters, default=0.0), samples)]
    for problem, world in itertools.product(find_problems(folder), worlds):
        row = bench.make_settings("problem world filter_mm samples", problem.name, *world)
        cases.append(bench.Case((row,), (problem, request, row)))
    return bench.run_bench(BENCH, out, cases, measure)


def measure(task: tuple[Problem, PlanRequest, bench.Row], progress: Progress) -> bench.Columns:
    """Return the columns of one row."""
    problem, plain, row = task
    columns: bench.Columns = {}
    try:
        query = make_query(problem.asked(plain).what)
        scene, columns = see_world(row, query)
        found = _connect(query, scene, plain) if row.world == OMPL else _plan(query, scene, plain, progress)
    except PlannerError as error:
        return columns | {"outcome": REFUSED, "message": str(error)}
    path = found.pop("path")
    if path is None:
        return columns | found
    judge = other_checker(query.robot, replace(query.scene, allowed=scene.allowed), plain.what.collision)
    return columns | found | {"outcome": SOLVED, "contacts": len(path_contacts(judge, path))}


def _plan(query: Query, scene: Scene, plain: PlanRequest, progress: Progress) -> bench.Columns:
    ends = {"start": joints_text(query.starts[0]), "goal": joints_text(query.goals[0])}
    asked = plain.with_options(robot=query.robot, scene=scene, **ends)
    watch, begin = FirstPath(), time.perf_counter()
    found = plan(request=asked, progress=Progress(watch, lambda: progress.stopped), timing=None)
    ready = found.timings["setup"]
    if not found.solved:
        return {"path": None, "outcome": NO_PATH, "message": found.message, "ready_s": ready}
    seconds = time.perf_counter() - begin if watch.seconds is None else watch.seconds
    return {"path": found.path, "ready_s": ready, "first_s": seconds - ready}


def _connect(query: Query, scene: Scene, plain: PlanRequest) -> bench.Columns:
    begin = time.perf_counter()
    cloud = scene.obstacles[0].shape
    assert isinstance(cloud, Points)
    check = octree_check(make_checker(query.robot, None, "coal"), cloud.vertices, _CELL)
    connect = OmplConnect(query.robot, check, plain.quality.seed)
    ready = time.perf_counter() - begin
    ends = query.starts[0], query.goals[0]
    if not all(map(check, ends)):
        return {"path": None, "outcome": REFUSED, "message": "start or goal is in a cell", "ready_s": ready}
    solved = connect.solve(*ends, _WAIT)
    first = time.perf_counter() - begin - ready
    if not solved:
        return {"path": None, "outcome": NO_PATH, "message": f"none in {_WAIT:g} s", "ready_s": ready}
    return {"path": connect.simplify(), "ready_s": ready, "first_s": first}


def see_world(row: bench.Row, query: Query) -> tuple[Scene, bench.Columns]:
    """Return the scene of a row as its sensor sees it, and columns on its points."""
    scene = replace(query.scene, carried=(), notes=())
    if row.world == TRUE:
        return scene, {}
    if row.world in (FREE, SOLID):
        image, dense = take_image(scene, query.robot.base[:3, 3], "solid" if row.world == SOLID else "free")
        seen = [*without_robot(image.obstacles("camera"), query.robot, query.starts[0], _MARGIN)]
        cloud = seen[0].shape
    else:
        xyz, dense = sample_surfaces(scene, row.samples, row.filter_mm * 1e-3)
        cloud = Points(xyz, _RADII.get(row.world, _covering(xyz, dense)))
        seen = [Obstacle("cloud", cloud, np.eye(4))]
    assert isinstance(cloud, Points)
    allowed = scene.allowed
    if row.world == TARGET:
        target, links = _nearest_to_hand(query)
        surface = surface_of(target.shape).apply_transform(target.placement)
        low, high = surface.bounds + np.array([[-1e-3], [1e-3]])
        seen = split_regions("cloud", cloud, np.eye(4), {"target": (*low, *high)})
        allowed |= {frozenset((name, link)) for name in ("target", target.object) for link in links}
    columns = {"points": len(cloud.vertices), "radius_mm": 1e3 * cloud.radius}
    columns["covering_mm"] = 1e3 * _covering(cloud.vertices, dense)
    return replace(scene, obstacles=tuple(seen), allowed=allowed), columns


def _covering(xyz: Floats, dense: Floats) -> float:
    return float(KDTree(xyz).query(dense)[0].max()) * (1 + 1e-9)


def _nearest_to_hand(query: Query) -> tuple[Obstacle, set[str]]:
    """Return the obstacle nearest to the last joint's bodies at the goal, and the links of these."""
    world, last = query.checker.world, max(body.joint for body in query.robot.bodies)
    rotation, position = joint_placements(query.checker.chain, query.goals[:1])
    pairs = np.arange(len(world.bodies) * len(world.obstacles))
    gaps = query.checker.distances(rotation[:, 0], position[:, 0], pairs).reshape(len(world.bodies), -1)
    hand = [k for k, body in enumerate(world.bodies) if body.joint == last]
    return world.obstacles[int(gaps[hand].min(axis=0).argmin())], {world.bodies[k].link for k in hand}


def octree_check(checker: CollisionChecker, points: Floats, cell: float) -> Callable[[Floats], bool]:
    """Return a test of configurations (dof,) by Pinocchio's loop, with coal's octree of ``points`` (n, 3) for all."""
    geometry = CoalChecker(checker.world).geometry_model.copy()
    tree = pin.GeometryObject("octree", 0, pin.SE3.Identity(), coal.makeOctree(np.array(points), cell))
    bodies, number = len(geometry.geometryObjects), geometry.addGeometryObject(tree)
    for k in range(bodies):
        geometry.addCollisionPair(pin.CollisionPair(k, number))
    model = checker.robot.model
    data, found = model.createData(), geometry.createData()
    return lambda q: not pin.computeCollisions(model, data, geometry, found, q, True)


def take_image(scene: Scene, base: Floats, unknown: Any) -> tuple[DepthImage, Floats]:
    """Return a noisy depth image of the scene, and the true points (n, 3) in its frame that it sees without a hole."""
    (height, width), intrinsics, far = _VIEW
    middle = np.mean([item.placement[:3, 3] for item in scene.obstacles], axis=0)
    away = (middle - base) * [1, 1, 0] / max(float(np.linalg.norm((middle - base)[:2])), 1e-9)
    camera = np.eye(4)
    camera[:3, 3] = base + np.array([0, 0, 1.3]) - 0.3 * away
    ahead = (middle - camera[:3, 3]) / np.linalg.norm(middle - camera[:3, 3])
    right = np.cross(ahead, [0, 0, 1]) / np.linalg.norm(np.cross(ahead, [0, 0, 1]))
    camera[:3, :3] = np.column_stack([right, np.cross(ahead, right), ahead])
    rng, corner = np.random.default_rng(0), intrinsics[2:]
    pixels = np.stack(np.meshgrid(np.arange(0, width, 0.5), np.arange(0, height, 0.5)), axis=2)
    rays = np.concatenate([(pixels - corner) / intrinsics[:2], np.ones((*pixels.shape[:2], 1))], axis=2)
    true = ray_depths(scene, camera[:3, 3], rays.reshape(-1, 3) @ camera[:3, :3].T).reshape(pixels.shape[:2])
    depth = true[::2, ::2] + np.clip(_NOISE * rng.normal(size=(height, width)), -2 * _NOISE, 2 * _NOISE)
    depth[rng.random(depth.shape) < 0.02] = 0.0
    for row, column in zip(rng.integers(height, size=5), rng.integers(width, size=5), strict=True):
        depth[row : row + 12, column : column + 12] = 0.0
    nearest = minimum_filter(np.where(depth > 0, depth, 10.0), size=3)
    depth = np.where((depth > 0) | (nearest == 10.0), depth, nearest)
    there = (depth > 0).repeat(2, axis=0).repeat(2, axis=1) & (true < far)
    image = DepthImage(np.minimum(depth, 10.0), intrinsics, camera, (0.1, far), 2 * _NOISE, unknown=unknown)
    return image, (rays * true[..., None])[there]


def ray_depths(scene: Scene, eye: Floats, rays: Floats) -> Floats:
    """Return where rays (n, 3) from ``eye`` enter the first shape, in lengths of the ray; 10 where they meet none."""
    depth = np.full(len(rays), 10.0)
    for item in scene.obstacles:
        turn, start = item.placement[:3, :3], (eye - item.placement[:3, 3]) @ item.placement[:3, :3]
        begin, end = _crossing(item.shape, start, rays @ turn)
        depth = np.where((begin < end) & (begin > 0), np.minimum(depth, begin), depth)
    return depth


def _crossing(shape: Shape, start: Floats, rays: Floats) -> tuple[Floats, Floats]:
    """Return where rays (n, 3) from ``start`` enter and leave a shape; nowhere if the first is larger."""
    match shape:
        case Box(size):
            return _slab(start, rays, 0.5 * np.array(size))
        case Sphere(radius):
            return _round(start, rays, radius)
        case Cylinder(radius, length):
            side, ends = _round(start[:2], rays[:, :2], radius), _slab(start[2:], rays[:, 2:], np.array([0.5 * length]))
            return np.maximum(side[0], ends[0]), np.minimum(side[1], ends[1])
    raise TypeError(f"no ray is cast on a {type(shape).__name__}.")


def _slab(start: Floats, rays: Floats, half: Floats) -> tuple[Floats, Floats]:
    with np.errstate(divide="ignore"):
        low, high = (-half - start) / rays, (half - start) / rays
    return np.minimum(low, high).max(axis=1), np.maximum(low, high).min(axis=1)


def _round(start: Floats, rays: Floats, radius: float) -> tuple[Floats, Floats]:
    square, along = np.einsum("ni,ni->n", rays, rays), rays @ start
    rest = along**2 - square * (start @ start - radius**2)
    root = np.sqrt(np.maximum(rest, 0.0))
    return np.where(rest > 0, (-along - root) / square, np.inf), (-along + root) / square


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
    for k, point in enumerate(points):
        if stay[k]:
            near = np.array(tree.query_ball_point(point, spacing))
            stay[near[near > k]] = False
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
    """Return a line per world, filter and number of samples."""
    theirs = {row.problem: row.first_s for row in rows if row.world == OMPL}
    columns = {
        "problems": len,
        "solved": bench.total(lambda row: row.outcome == SOLVED),
        "points": bench.middle("points"),
        "radius (mm)": bench.middle("radius_mm"),
        "ready (ms)": bench.middle("ready_s", 1e3),
        "first path (ms)": bench.middle("first_s", 1e3),
        "over OMPL's": bench.middle(lambda row: bench.ratio(row.first_s, theirs.get(row.problem))),
        "contacts": bench.total("contacts"),
        "estimate below truth": bench.total(_is_below),
    }
    return bench.table(rows, ("world", "filter_mm", "samples"), columns)


def _is_below(row: bench.Row) -> bool | None:
    return None if row.world == OMPL or row.radius_mm is None else row.radius_mm < row.covering_mm


def aims(rows: Sequence[bench.Row]) -> list[Any]:
    """Return the promise: no contact with the true shapes where the radius is the covering radius."""
    safe = [row.contacts == 0 for row in rows if row.world in _SAFE and row.contacts is not None]
    return [bench.tally("paths at the covering radius touch none of the true shapes.", safe, "")]


def fault(row: bench.Row) -> str:
    """Return a sentence on a contact that the promise rules out."""
    if row.world not in _SAFE or not row.contacts:
        return ""
    return f"{row.problem}, {row.world}, filter {row.filter_mm:g} mm: {row.contacts} contacts."


BENCH = bench.Bench("clouds", __doc__, tables, aims, fault, must_hold=True)
