"""Measures verdicts on chunks of joint targets: their time, what they refuse without need, and an attack on them.

How. A chunk is a smooth random motion of a robot among ten boxes of 4 to 20 cm; every check goes from the present state
on and proves a stop from every point, on one thread, after work that leaves nothing of it in the caches; "again" is the
same check again, "alone" without stops, so the difference is their price. A chunk counts as free by 5 or 20 mm
where the motion and all stops that the limits allow are so far from everything at every millimetre, by coal. In the
attack hill climbing moves targets and a thin obstacle towards a chunk that is called safe and touches; the judge builds
the controller's splines by itself, looks at them every 0.05 mm where anything may touch, by coal and by FCL (what
coal's own distances clear is passed over), and finds the extrema of their derivatives by roots. The attack is made
three times: on safe chunks, on chunks with a contact that is allowed for a time or in a region, and on chunks that are
called safe in more time. For false stops an obstacle comes near a slow motion of a Panda, until coal finds the given
distance beyond a margin of 5 mm at every millimetre, stops included. Limitations. Times are those of the machine as it
was; states every 0.05 mm (0.5 mm where an allowed contact ends) are no proof.

Columns. Chunks of one kind for one robot: times of a check, what is refused without need, and an attack.

``p50_ms``, ``p99_ms``: of ``chunks`` checks on one thread after other work, ``_cpu`` by the thread's own clock, which
other work on the machine does not count in; by that clock ``_again``: the same again, ``_alone``: without stops.
``free_5``, ``free_20``: chunks that keep, stops included, 5 and 20 mm from everything as coal sees it every millimetre,
and how many of these are called safe. ``change_ms``: the median of moving one obstacle after other work,
``change_again_ms``: of moving it back, by that clock. ``tries``: of the attack, of which ``safe`` were called safe,
``false`` of these touch or have no stop, ``beyond`` a limit. ``touching``: refused for a contact on the motion, of
which samples every 0.05 rad call ``sampled`` free. ``allowed``: safe ones of as many tries with an allowed contact;
``slowed``: of as many tries, unsafe ones that are called safe in more time. False stops: chunks ``made`` with a
``clearance`` (mm) in a situation, ``accepted`` of these, ``slowed`` of the others, and the ``reasons``.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import bench
from benchmarks.gate.attack import AIMS, Attack
from benchmarks.gate.chunks import KINDS, Chunk, Rng, clutter, random_chunk
from benchmarks.gate.false_stops import CLASSES, SITUATIONS, judged_at
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
_TRIES = 10  # random chunks for one that is suitable
_NEAR = "clearance steps free seed"


def gate(
    out: bench.Out = Path("bench-gate"),
    chunks: int = 300,
    attack: int = 300,
    robots: tuple[str, ...] = ("panda",),
    free: int = 20,
    clearances: tuple[int, ...] = CLASSES,
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
        free: Chunks in each situation and at each clearance, of a Panda with its hand.
        clearances: Distances of these, mm beyond a margin of 5 mm.
        steps: Targets in a chunk, 1/30 s apart.
        seed: Seed of chunks and obstacles.
    """
    RoadmapQuality(seed=seed)  # refuses a seed out of range
    if chunks < 1 or min(attack, free) < 0 or steps < 2 or min(clearances, default=1) < 1:
        raise OptionError("give at least 1 chunk of 2 steps, 0 tries or free chunks, and clearances of 1 mm.")
    for name in robots:
        Robot.load(name)
    names, settings = "robot kind steps chunks attack seed", (steps, chunks, attack, seed)
    rows = [bench.make_settings(names, name, kind, *settings) for name in robots for kind in KINDS]
    places = [(situation, clearance) for situation in SITUATIONS for clearance in clearances] if free else []
    rows += [bench.make_settings(f"{names[:10]} {_NEAR}", "panda", *place, steps, free, seed) for place in places]
    cases = [bench.Case((row,), row) for row in rows]
    return bench.run_bench(BENCH, out, cases, _measure, workers)


def _measure(row: bench.Row, progress: Progress) -> dict[str, Any] | None:
    return _measure_chunks(row, progress) if row.clearance is None else _measure_free(row, progress)


def _measure_free(row: bench.Row, progress: Progress) -> dict[str, Any] | None:
    """The chunks of one situation and clearance that are accepted, and why the others are not."""
    robot, rng = Robot.load(row.robot), np.random.default_rng([row.seed, row.clearance, *row.kind.encode()])
    verdicts: list[Verdict] = []
    for _ in range(_TRIES * row.free):
        if len(verdicts) == row.free or progress.stopped:
            break
        verdict = judged_at(robot, row.kind, 1e-3 * row.clearance, row.steps, rng)
        verdicts += [] if verdict is None else [verdict]
    if progress.stopped:
        return None
    reasons = Counter(str(verdict.reason) for verdict in verdicts if not verdict.safe)
    return {
        "made": len(verdicts),
        "accepted": sum(verdict.safe for verdict in verdicts),
        "slowed": sum(verdict.slowed is not None for verdict in verdicts),
        "reasons": "; ".join(f"{count} {text}" for text, count in reasons.most_common()),
    }


def _measure_chunks(row: bench.Row, progress: Progress) -> dict[str, Any] | None:
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
    attacks = [Attack(robot, (row.kind,), aim) for aim in AIMS]
    if not all(one.run(row.attack, rng, progress) for one in attacks):
        return None
    columns = _of_times(times, changes) | _of_verdicts(free, np.array([verdict.safe for _, verdict in verdicts]))
    first, allowed, slowed = (one.found for one in attacks)
    columns |= {name: getattr(first, name) for name in ("tries", "safe", "touching", "sampled")}
    columns |= {"allowed": allowed.safe, "slowed": slowed.slowed}
    columns |= {
        "false": sum(len(one.found.false) for one in attacks),
        "beyond": sum(one.found.beyond for one in attacks),
    }
    return columns | {"least_mm": 1e3 * min(float(one.found.least) for one in attacks)}


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
_ATTACK = ("tries", "safe", "allowed", "slowed", "false", "beyond", "least_mm", "touching", "sampled")
_FREE = ("clearance", "made", "accepted", "slowed", "reasons")


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """Return a table of times, one of accepted chunks, one of the attack, and one of false stops."""
    lines, moved = [], [row for row in rows if row.clearance is None]
    for title, names in (("Times", _TIMES), ("Accepted", _ACCEPTED), ("Attacked", _ATTACK)):
        lines += [f"## {title}", "", *bench.row_table(moved, ("robot", "kind"), names)]
    free = [row for row in rows if row.clearance is not None]
    return [*lines, "## False stops", "", *bench.row_table(free, ("robot", "kind"), _FREE)] if free else lines


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """What must hold of chunks that are called safe."""
    moved = [row for row in rows if row.clearance is None]
    counts = (sum(getattr(row, name) for row in moved) for name in ("safe", "allowed", "slowed"))
    note = "{} chunks of the attack are called safe, {} with an allowed contact, {} slowed.".format(*counts)
    return (
        bench.tally("No chunk that is called safe touches or has no stop.", (row.false == 0 for row in moved), note),
        bench.tally("No chunk that is called safe exceeds a limit.", (row.beyond == 0 for row in moved), ""),
    )


BENCH = bench.Bench("gate", __doc__, tables, aims, must_hold=True)
