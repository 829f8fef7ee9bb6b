"""Measures plans of several robots in one cell, in turn and together, proven and looked at by coal.

How. Every ordered pair of the named states of a cell is a problem, as in the benchmark of VAMP-MR (Huang, Gao, Li, IROS
2026), whose robots, boxes, rods and states a folder of JSON files holds. Pandas have closed fingers. A rod is a
cylinder in the frame of the hand's tool, at 5 mm and turned by 90 degrees about y as the source has it; the source does
not name its frame. A base may touch the tables. States that touch here are listed and left out. In turn: a roadmap of
each robot is kept from pair to pair. Together: one tree of all joints per pair. Work stops on counts; 5 s only classify
a plan. Both times are of the wall, on a machine with other work. Every motion is looked at by coal at each 0.1 mm of
the motion of a point, and an optimiser searches its times for the smallest distance. Another one searches for straight
motions of all robots that are proven and touch, in place and length. Makespan and flowtime are those of the limits of
the robot's file, and at 1 rad/s with acceleration and jerk lifted (1e4 rad/s², 1e7 rad/s³).

Limitations. Looks are no proof; the shapes are the meshes of our Panda, and theirs are spheres.

Columns. One plan. ``least_m``: the smallest distance that an optimiser found in ``tries`` of a motion's times, or of
proven motions.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from functools import cache
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import bench
from benchmarks.attack.climb import climb
from benchmarks.looks import STEP, motion_contact
from planner.base.arrays import Floats
from planner.base.errors import FileError, OptionError
from planner.base.progress import Progress
from planner.base.yamlfile import read_text
from planner.batch.run import SOLVED
from planner.cells.planner import CellPlanner
from planner.collision.checker import CollisionChecker, contact_at
from planner.collision.edge_prover import EdgeProver
from planner.collision.recheck import Clearance, sample_segment
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.planning.solve import time_plan
from planner.problem.request import RoadmapQuality, TimingRequest
from planner.problem.targets import joints_text
from planner.robot.cell import Cell
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Carried, Cylinder, Obstacle
from planner.trajectory.limits import MotionLimits
from planner.trajectory.parts import busy_seconds, split_trajectory
from planner.trajectory.trajectory import Trajectory

METHODS = ("in turn", "together")
LEFT_OUT, ATTACK = "left out", "attack"
Segment = tuple[Floats, Floats]  # start and delta
_HAND = ("panda_hand", "panda_leftfinger", "panda_rightfinger")  # what may touch a rod
_CLASS = 5.0  # s


def cells(
    folder: bench.Folder,
    out: bench.Out = Path("bench-cells"),
    pairs: int = 0,
    nodes: int = 200,
    seed: int = 1,
    tries: int = 240,
    rod_frame: str = "panda_hand_tcp",
    cells: tuple[str, ...] = (),
    methods: tuple[str, ...] = METHODS,
    workers: bench.Workers = bench.SERIAL,
    debug: bench.Debug = False,
) -> int:
    """All ordered pairs of named states of cells with several arms: success, seconds, times, proofs and contacts.

    Writes cells.csv, one row per plan, and cells.md.

    Args:
        folder: Folder of cells as JSON files.
        pairs: Pairs of each cell, spread over all of them; 0 for all.
        nodes: Configurations in the roadmap of each robot.
        seed: Seed of roadmaps and trees.
        tries: Times of each motion that the optimiser looks at.
        rod_frame: Frame of the Panda that holds the rods.
        cells: Names of cells; all by default.
        methods: in turn, together.
    """
    RoadmapQuality(nodes, seed)  # refuses what is out of range
    files = sorted(folder.glob("*.json"))
    files = [file for file in files if not cells or file.stem in cells]
    if not files:
        raise FileError(f"{folder} holds no cells of these names: give a folder with JSON files of cells.")
    if pairs < 0 or tries < 1 or not set(methods) <= set(METHODS):
        raise OptionError(f"give pairs of 0 or more, tries of 1 or more, and methods out of {', '.join(METHODS)}.")
    found = [
        bench.Case((row,), row) for file in files for row in _rows(file, pairs, nodes, seed, tries, rod_frame, methods)
    ]
    return bench.run_bench(BENCH, out, found, _measure, workers)


def _rows(
    file: Path, pairs: int, nodes: int, seed: int, tries: int, frame: str, methods: Sequence[str]
) -> list[bench.Row]:
    """Return the settings of each plan, and of each state that is left out."""
    planner, states = open_cell(str(file), nodes, seed, frame)
    free = [name for name, q in states.items() if contact_at(planner.checker, q) is None]
    every = list(permutations(free, 2))
    count = len(every) if pairs == 0 else min(pairs, len(every))
    chosen = [every[k] for k in np.linspace(0, len(every) - 1, count).round().astype(int).tolist()]
    ends = [(start, goal, method) for method in methods for start, goal in chosen]
    ends += [(name, "", LEFT_OUT) for name in states if name not in free] + [("", "", ATTACK)]
    names = "cell file start goal method nodes seed tries frame"
    return [bench.make_settings(names, file.stem, str(file), *each, nodes, seed, tries, frame) for each in ends]


@cache
def open_cell(file: str, nodes: int, seed: int, frame: str) -> tuple[CellPlanner, dict[str, Floats]]:
    """Return the planner of a cell, and its named states (dof,)."""
    data = json.loads(read_text(Path(file), "cell"))
    closed = {"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0}
    robots = {
        item["name"]: Robot.load(item["robot"], fixed_joints=closed, base=pose(item["position"], [0, 0, item["yaw"]]))
        for item in data["robots"]
    }
    boxes = tuple(Obstacle(box["name"], Box(box["size"]), pose(box["position"])) for box in data["boxes"])
    rod, held = data["carried_rod"], tuple[Carried, ...]()
    if rod is not None:
        shape, at = Cylinder(rod["radius"], rod["length"]), pose([0, 0, -0.005], [0, 0.5 * np.pi, 0])
        held = tuple(
            Carried(f"{name}_{frame}", f"rod of {name}", shape, at, tuple(f"{name}_{link}" for link in _HAND))
            for name in robots
        )
    allowed = frozenset(frozenset((f"{name}_panda_link0", box.name)) for name in robots for box in boxes)
    cell = Cell(data["name"], robots, Scene(data["name"], boxes, carried=held, allowed=allowed))
    states = {name: np.concatenate(rows) for name, rows in data["states"].items()}
    return CellPlanner(cell, nodes=nodes, seed=seed, collision="coal"), states


def _measure(row: bench.Row, progress: Progress) -> dict[str, Any] | None:
    cell_planner, states = open_cell(row.file, row.nodes, row.seed, row.frame)
    if row.method == LEFT_OUT:
        return {"outcome": LEFT_OUT, "message": str(contact_at(cell_planner.checker, states[row.start]))}
    if row.method == ATTACK:
        return _attack_proofs(cell_planner, np.array(list(states.values())), row.tries, row.seed, progress)
    ends, begun = [joints_text(states[name]) for name in (row.start, row.goal)], time.perf_counter()
    if row.method == "in turn":
        found = cell_planner.plan(*ends, progress=progress)
    else:
        options: dict[str, Any] = {"path_only": True, "extra_clearance": 0.0, "seed": row.seed, "collision": "coal"}
        found = plan(cell=cell_planner.cell, start=ends[0], goal=ends[1], progress=progress, **options)
    seconds = time.perf_counter() - begun
    if progress.stopped:
        return None
    how = found.end_notes[-1] if found.end_notes else row.method
    columns = {"outcome": found.outcome.key, "message": found.message, "seconds": seconds, "how": how}
    if found.trajectory is None:
        return columns
    slow = time_plan(found, TimingRequest(), _slow_limits(found))
    return columns | {
        "proven": found.trajectory.proven and slow.proven,
        "makespan": found.makespan,
        "flowtime": found.flowtime,
        "makespan_1": busy_seconds(slow),
        "flowtime_1": sum(map(busy_seconds, split_trajectory(slow, found.robot).values())),
        "contact": motion_contact(found.trajectory, found.checker),
        "contact_1": motion_contact(slow, found.checker),
        "least_m": _attack_times(found.trajectory, found.checker, row.tries, row.seed, progress),
    }


def _slow_limits(found: Plan) -> MotionLimits:
    """Return 1 rad/s, with limits of acceleration and jerk that never bind."""
    one, robot = np.ones(found.robot.dof), found.robot
    return MotionLimits(
        robot.joints, one, 1e4 * one, 1e7 * one, dict.fromkeys(("velocity", "acceleration", "jerk"), "VAMP-MR")
    )


def _attack_times(motion: Trajectory, checker: CollisionChecker, tries: int, seed: int, progress: Progress) -> float:
    """Return the smallest distance (m) of a pair that a climb over the times of a motion finds."""
    clearance, found = Clearance(checker), [np.inf]

    def score(times: Sequence[float]) -> list[float]:
        near = clearance(motion.at(np.array(times)))
        found[0] = min(found[0], float(near.min()))
        return (-near).tolist()

    def begin(rng: np.random.Generator) -> float:
        return float(rng.uniform(0.0, motion.duration))

    def step(t: float, size: float, rng: np.random.Generator) -> float:
        return float(np.clip(t + size * motion.duration * rng.normal(), 0.0, motion.duration))

    climb(tries, np.random.default_rng(seed), begin, step, score, progress)
    return found[0]


def _attack_proofs(
    cell_planner: CellPlanner, states: Floats, tries: int, seed: int, progress: Progress
) -> dict[str, Any] | None:
    """Search for a straight motion of all robots that is proven, and touches at a look every 0.1 mm."""
    checker = cell_planner.checker
    prover, clearance, least = EdgeProver(checker), Clearance(checker), [np.inf]
    counts = {"tried": 0, "free": 0, "false_free": 0}

    def begin(rng: np.random.Generator) -> Segment:
        one, other = states[rng.integers(len(states), size=2)]
        delta = rng.normal(size=len(one)) * 10.0 ** rng.uniform(-3.0, 0.0)
        return one + rng.random() * (other - one) + 0.1 * rng.normal(size=len(one)) - 0.5 * delta, delta

    def step(case: Segment, size: float, rng: np.random.Generator) -> Segment:
        start, delta = case
        return start + 0.3 * size * rng.normal(size=len(start)), delta + 0.3 * size * rng.normal(size=len(start))

    def score(cases: Sequence[Segment]) -> list[float]:
        values = []
        for start, delta in cases:
            free = bool(prover.free(start, delta)[0])
            near = float(clearance(start + np.linspace(0.0, 1.0, 9)[:, None] * delta).min())
            counts["tried"] += 1
            counts["free"] += free
            counts["false_free"] += free and sample_segment(checker, start, delta, STEP) is not None
            least[0] = min(least[0], near) if free else least[0]
            values.append(-near - (not free))
        return values

    done = climb(tries, np.random.default_rng(seed), begin, step, score, progress)
    return {"outcome": ATTACK, "least_m": least[0], **counts} if done else None


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """A line per cell and method, and the states that are left out."""
    plans = [row for row in rows if row.method in METHODS]
    columns: dict[str, bench.Pick] = {
        "plans": len,
        "solved": lambda some: sum(row.outcome == SOLVED for row in some),
        "within 5 s": lambda some: sum(row.outcome == SOLVED and row.seconds <= _CLASS for row in some),
        "median (s)": bench.middle("seconds"),
        "largest (s)": bench.most("seconds"),
        "proven": bench.total("proven"),
        "contacts": lambda some: sum(bool(row.contact) + bool(row.contact_1) for row in some),
        "smallest distance (mm)": lambda some: min((1e3 * v for v in bench.values(some, "least_m")), default=None),
        "makespan (s)": bench.middle("makespan"),
        "flowtime (s)": bench.middle("flowtime"),
        "makespan at 1 rad/s (s)": bench.middle("makespan_1"),
        "flowtime at 1 rad/s (s)": bench.middle("flowtime_1"),
    }
    lines = bench.table(plans, ["cell", "method"], columns)
    ways = {"plans": len, "median (s)": bench.middle("seconds")}
    lines += bench.table(plans, ["cell", "method", "how"], ways)
    attacks = [row for row in rows if row.method == ATTACK]
    lines += bench.row_table(attacks, ["cell", "method"], ["tried", "free", "false_free", "least_m"])
    return lines + [f"- left out: {row.cell}, {row.start}: {row.message}" for row in rows if row.method == LEFT_OUT]


def fault(row: bench.Row) -> str:
    """Return what is wrong with a plan."""
    where = f"{row.cell}, {row.start} to {row.goal}, {row.method}"
    if row.contact or row.contact_1:
        return f"CONTACT: {where}: {row.contact or row.contact_1}"
    if row.method not in METHODS:
        return f"FALSE: {row.cell}: {row.false_free} motions are proven and touch" if row.false_free else ""
    if row.outcome != SOLVED:
        return f"{where}: {row.message}"
    return "" if row.proven else f"not proven: {where}"


BENCH = bench.Bench("cells", __doc__, tables, fault=fault)
