"""Measures verdicts on chunks of joint targets: their time, what they refuse without need, and an attack on them.

How. A chunk is a smooth random motion of a robot among ten boxes of 4 to 20 cm; every check goes from the present state
on and proves a stop from every point, on one thread, after work that leaves nothing of it in the caches; "again" is the
same check again, "alone" without stops, so the difference is their price. A chunk counts as free by 5 or 20 mm
where the motion and all stops that the limits allow are so far from everything at every millimetre, by coal. In the
attack hill climbing moves targets and a thin obstacle towards a chunk that is called safe and touches; the judge builds
the controller's splines by itself, looks at them every 0.05 mm where anything may touch, by coal and by FCL (what
coal's own distances clear is passed over), and finds the extrema of their derivatives by roots. Limitations. Times
are those of the machine as it was; states every 0.05 mm are no proof.

Columns. Chunks of one kind for one robot: times of a check, what is refused without need, and an attack.

``p50_ms``, ``p99_ms``: of ``chunks`` checks on one thread after other work, ``_cpu`` by the thread's own clock, which
other work on the machine does not count in; by that clock ``_again``: the same again, ``_alone``: without stops.
``free_5``, ``free_20``: chunks that keep, stops included, 5 and 20 mm from everything as coal sees it every millimetre,
and how many of these are called safe. ``change_ms``: the median of moving one obstacle after other work,
``change_again_ms``: of moving it back, by that clock. ``tries``: of the attack, of which ``safe`` were called safe,
``false`` of these touch or have no stop, ``beyond`` a limit. ``touching``: refused for a contact on the motion, of
which samples every 0.05 rad call ``sampled`` free.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import bench
from benchmarks.gate.attack import Attack
from benchmarks.gate.chunks import KINDS, Chunk, Rng, clutter, random_chunk
from benchmarks.gate.judge import motion_of, possible_stops, reach_of, states_on
from planner.base.arrays import Bools
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker, with_extra_margin
from planner.problem.request import RoadmapQuality
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.session.gate import Gate
from planner.session.verdict import Verdict

OBSTACLES, PER_STEP = 10, 1.0 / 30.0  # s
FREE = (5e-3, 20e-3)  # m
_SCENES = 10
_EVERY = 1e-3  # m


def gate(
    out: bench.Out = Path("bench-gate"),
    chunks: int = 300,
    attack: int = 300,
    robots: tuple[str, ...] = ("panda",),
    steps: int = 50,
    seed: int = 0,
    workers: bench.Workers = bench.SERIAL,
    debug: bench.Debug = False,
) -> int:
    """Verdicts on chunks of joint targets: how long they take, what they refuse without need, and an attack on them.

    A chunk is a random motion among ten boxes, on one thread, with a stop proven from every target. An optimiser then
    moves targets and thin obstacles towards a chunk that is called safe and touches, as coal and FCL see it every 0.05
    mm of the controller's own splines. Writes gate.csv, one row for lines, cubics and quintics each, and gate.md. Exit
    code 4 where a chunk that is called safe touches or exceeds a limit.

    Args:
        chunks: Chunks of each kind to time and to look at; run it on a quiet machine.
        attack: Cases of each kind that the optimiser tries; 10 ms each for a Panda.
        robots: Names of built-in robots or paths of URDFs.
        steps: Targets in a chunk, 1/30 s apart.
        seed: Seed of chunks and obstacles.
    """
    RoadmapQuality(seed=seed)  # refuses a seed out of range
    if chunks < 1 or attack < 0 or steps < 2:
        raise OptionError("give at least 1 chunk of 2 steps, and 0 tries or more.")
    for name in robots:
        Robot.load(name)
    names, settings = "robot kind steps chunks attack seed", (steps, chunks, attack, seed)
    rows = [bench.make_settings(names, name, kind, *settings) for name in robots for kind in KINDS]
    cases = [bench.Case((row,), row) for row in rows]
    return bench.run_bench(BENCH, out, cases, _measure, workers)


def _measure(row: bench.Row, progress: Progress) -> dict[str, Any] | None:
    robot, rng = Robot.load(row.robot), np.random.default_rng([row.seed, KINDS.index(row.kind), *row.robot.encode()])
    moves = np.random.default_rng(row.seed)
    times: list[tuple[float, ...]] = []
    verdicts: list[tuple[Chunk, Verdict]] = []
    free, changes = np.zeros((row.chunks, 2), dtype=bool), []
    for first in range(0, row.chunks, -(-row.chunks // _SCENES)):
        gate = Gate(robot, Scene("clutter", clutter(OBSTACLES, rng)))
        for k in range(first, min(first + -(-row.chunks // _SCENES), row.chunks)):
            chunk = random_chunk(robot, row.kind, row.steps, row.steps * PER_STEP, rng)
            taken, verdict = _timed(gate, chunk)
            times.append(taken)
            verdicts.append((chunk, verdict))
            free[k] = _free_by(gate.checker, chunk, verdict)
            changes.append(_changed(gate, moves))
            if progress.stopped:
                return None
    attacked = Attack(robot, (row.kind,))
    if not attacked.run(row.attack, rng, progress):
        return None
    columns = _of_times(times, changes) | _of_verdicts(free, np.array([verdict.safe for _, verdict in verdicts]))
    found = attacked.found
    columns |= {name: getattr(found, name) for name in ("tries", "safe", "beyond", "touching", "sampled")}
    return columns | {"false": len(found.false), "least_mm": float(1e3 * found.least)}


def _of_times(times: Sequence[tuple[float, ...]], changes: Sequence[tuple[float, float]]) -> dict[str, float]:
    """Percentiles of the seconds of checks, and medians of those of changes, in ms."""
    change, again = np.median(1e3 * np.array(changes), axis=0)
    found = {"change_ms": float(change), "change_again_ms": float(again)}
    for share in (50, 99):
        values = np.percentile(1e3 * np.array(times), share, axis=0).tolist()
        found |= {f"p{share}{name}_ms": v for name, v in zip(("", "_cpu", "_again", "_alone"), values, strict=True)}
    return found


def _of_verdicts(free: Bools, safe: Bools) -> dict[str, int]:
    """How many chunks are called safe, and how many of those that keep a distance."""
    found = {"safe_chunks": int(safe.sum())}
    for k, apart in enumerate((5, 20)):
        found |= {f"free_{apart}": int(free[:, k].sum()), f"accepted_{apart}": int((free[:, k] & safe).sum())}
    return found


def _timed(gate: Gate, chunk: Chunk) -> tuple[tuple[float, ...], Verdict]:
    """Seconds of a check after other work, by the wall's and the thread's own clock, of it again, of one without stops.

    And the verdict.
    """
    columns, named = chunk.arguments()
    begin, own = time.perf_counter(), time.thread_time()
    verdict = gate.check(*columns, **named)  # pyright: ignore[reportArgumentType]
    taken = [time.perf_counter() - begin, time.thread_time() - own]
    for stop in (True, False):
        own = time.thread_time()
        gate.check(*columns, **named, stop=stop)  # pyright: ignore[reportArgumentType]
        taken.append(time.thread_time() - own)
    return tuple(taken), verdict


def _free_by(checker: CollisionChecker, chunk: Chunk, verdict: Verdict) -> Bools:
    """Whether motion and stops keep each of ``FREE`` from everything; False where a limit allows no stop."""
    stops = possible_stops(verdict)
    if stops is None or (verdict.reason is not None and verdict.reason.kind == "limit"):
        return np.zeros(len(FREE), dtype=bool)
    judge, reach, curves = second_checker(checker), reach_of(checker.robot), (*motion_of(chunk), *stops)
    states = np.concatenate([states_on(one, reach, _EVERY) for one in curves])
    return np.array([with_extra_margin(judge, apart).first_contact(states) is None for apart in FREE])


def _changed(gate: Gate, rng: Rng) -> tuple[float, float]:
    """Seconds of the thread that it takes to move an obstacle after other work, and to move it back."""
    found = []
    for placement in (pose(rng.uniform(0.4, 0.8, 3).tolist()), gate.scene.obstacles[0].placement):
        begin = time.thread_time()
        gate.world.put("box0", placement)
        gate.to_dict()  # it looks at the world
        found.append(time.thread_time() - begin)
    return found[0], found[1]


_TIMES = ("p50_ms", "p99_ms", "p50_cpu_ms", "p99_cpu_ms", "p50_again_ms", "p99_again_ms")
_TIMES = (*_TIMES, "p50_alone_ms", "p99_alone_ms", "change_ms", "change_again_ms")
_ACCEPTED = ("chunks", "safe_chunks", "free_5", "accepted_5", "free_20", "accepted_20")
_ATTACK = ("tries", "safe", "false", "beyond", "least_mm", "touching", "sampled")


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """Return a table of times, one of accepted chunks and one of the attack."""
    lines = []
    for title, names in (("Times", _TIMES), ("Accepted", _ACCEPTED), ("Attacked", _ATTACK)):
        lines += [f"## {title}", "", *bench.row_table(rows, ("robot", "kind"), names)]
    return lines


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """What must hold of chunks that are called safe."""
    note = f"{sum(row.safe for row in rows)} chunks of the attack are called safe."
    return (
        bench.tally("No chunk that is called safe touches or has no stop.", (row.false == 0 for row in rows), note),
        bench.tally("No chunk that is called safe exceeds a limit.", (row.beyond == 0 for row in rows), ""),
    )


BENCH = bench.Bench("gate", __doc__, tables, aims, must_hold=True)
