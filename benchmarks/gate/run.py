"""``benchmarks gate``: a chunk of 50 steps for a Panda among ten obstacles, and an optimiser against the verdicts."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.bench import run_bench, software
from benchmarks.gate.attack import Attack
from benchmarks.gate.chunks import KINDS, Chunk, Rng, clutter, random_chunk
from benchmarks.gate.hpp import proven_by_hpp
from benchmarks.gate.judge import motion_of, possible_stops, reach_of, states_on
from benchmarks.gate.report import Row, to_markdown
from benchmarks.results import Results
from planner.base.arrays import Bools
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker, keeping
from planner.gate.gate import Gate
from planner.gate.verdict import Verdict
from planner.models.poses import pose
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.problem.request import SERIAL, WorkersRequest, require_seed

OBSTACLES, PER_STEP = 10, 1.0 / 30.0  # s
FREE = (5e-3, 20e-3)  # m
_SCENES = 10
_EVERY = 1e-3  # m


def bench_gate(
    folder: Path,
    chunks: int = 300,
    attack: int = 300,
    robots: Sequence[str] = ("panda",),
    steps: int = 50,
    seed: int = 0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
    python: str | None = None,
) -> Results[Row]:
    """Check ``chunks`` of each kind and try ``attack`` cases against each; write ``gate.csv`` and ``gate.md``.

    ``python``: that of an environment with HPP, which proves the chunks of lines too.

    Raises OptionError for numbers out of range, RobotError for an unknown robot, FileError for an unusable folder.
    """
    require_seed(seed)
    if chunks < 1 or attack < 0 or steps < 2:
        raise OptionError("give at least 1 chunk of 2 steps, and 0 tries or more.")
    for name in robots:
        Robot.load(name)
    here = software()
    return run_bench(
        folder,
        "gate",
        Row,
        [(name, kind) for name in robots for kind in KINDS],
        lambda table, case: table.find((*case, steps, chunks, attack, seed, here)),
        partial(_measure, steps=steps, chunks=chunks, attack=attack, seed=seed, python=python),
        to_markdown,
        "kinds of chunks",
        progress,
        workers=workers,
    )


def _measure(
    case: tuple[str, str], progress: Progress, steps: int, chunks: int, attack: int, seed: int, python: str | None
) -> list[Row] | None:
    name, kind = case
    robot, rng = Robot.load(name), np.random.default_rng([seed, KINDS.index(kind), *name.encode()])
    moves = np.random.default_rng(seed)
    times: list[tuple[float, ...]] = []
    verdicts: list[tuple[Chunk, Verdict]] = []
    free, changes, hpp = np.zeros((chunks, 2), dtype=bool), [], []
    for first in range(0, chunks, -(-chunks // _SCENES)):
        gate = Gate(robot, Scene("clutter", clutter(OBSTACLES, rng)))
        for k in range(first, min(first + -(-chunks // _SCENES), chunks)):
            chunk = random_chunk(robot, kind, steps, steps * PER_STEP, rng)
            taken, verdict = _timed(gate, chunk)
            times.append(taken)
            verdicts.append((chunk, verdict))
            free[k] = _free_by(gate.checker, chunk, verdict)
            changes.append(_changed(gate, moves))
            if progress.stopped:
                return None
        if python is not None and kind == "lines":
            hpp.append(_by_hpp(python, gate, [chunk for chunk, _ in verdicts[first:]]))
    attacked = Attack(robot, (kind,))
    if not attacked.run(attack, rng, progress):
        return None
    safe, found = np.array([verdict.safe for _, verdict in verdicts]), attacked.found
    asked, proven, seconds = np.sum(hpp, axis=0) if hpp else (0, 0, 0.0)
    change, changed_again = np.median(1e3 * np.array(changes), axis=0)
    p50, p99 = np.percentile(1e3 * np.array(times), [50, 99], axis=0)
    return [
        Row(
            robot=name,
            kind=kind,
            steps=steps,
            chunks=chunks,
            attack=attack,
            seed=seed,
            p50_ms=float(p50[0]),
            p99_ms=float(p99[0]),
            p50_cpu_ms=float(p50[1]),
            p99_cpu_ms=float(p99[1]),
            p50_again_ms=float(p50[2]),
            p99_again_ms=float(p99[2]),
            p50_alone_ms=float(p50[3]),
            p99_alone_ms=float(p99[3]),
            change_ms=float(change),
            change_again_ms=float(changed_again),
            safe_chunks=int(safe.sum()),
            free_5=int(free[:, 0].sum()),
            accepted_5=int((free[:, 0] & safe).sum()),
            free_20=int(free[:, 1].sum()),
            accepted_20=int((free[:, 1] & safe).sum()),
            tries=found.tries,
            safe=found.safe,
            false=len(found.false),
            beyond=found.beyond,
            least_mm=float(1e3 * found.least),
            touching=found.touching,
            sampled=found.sampled,
            hpp_pieces=int(asked) if asked else None,
            hpp_proven=int(proven) if asked else None,
            hpp_ms=float(1e3 * seconds * steps / asked) if asked else None,
            software=software(),
        )
    ]


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
    return np.array([keeping(judge, apart).first_contact(states) is None for apart in FREE])


def _by_hpp(python: str, gate: Gate, chunks: Sequence[Chunk]) -> tuple[int, int, float]:
    """Pieces of those chunks that are proven without stops, how many HPP proves, and its seconds."""
    asked = [(chunk, chunk.arguments()) for chunk in chunks]
    free = [c for c, (columns, named) in asked if gate.check(*columns, **named, stop=False).safe]  # pyright: ignore[reportArgumentType]
    return (sum(len(chunk.times) - 1 for chunk in free), *proven_by_hpp(python, gate, free))


def _changed(gate: Gate, rng: Rng) -> tuple[float, float]:
    """Seconds of the thread that it takes to move an obstacle after other work, and to move it back."""
    found = []
    for placement in (pose(rng.uniform(0.4, 0.8, 3).tolist()), gate.scene.obstacles[0].placement):
        begin = time.thread_time()
        gate.move("box0", placement)
        found.append(time.thread_time() - begin)
    return found[0], found[1]
