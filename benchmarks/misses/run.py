"""``benchmarks misses``: edges past walls, poles and windows of a few millimetres, proven and sampled closely."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import run_bench, software
from benchmarks.misses.report import Row, to_markdown
from benchmarks.misses.resolution import states_by_ompls_rule
from benchmarks.misses.thin_obstacles import KINDS, ThinCase, thin_case
from benchmarks.results import Results
from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.collision import BACKENDS, make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.collision.looks import dense_states
from planner.collision.self_pairs import generate_disabled_pairs
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.problem.request import SERIAL, WorkersRequest, require_seed

ROBOTS = ("iiwa14", "panda", "ur5", "planar_2r", "kinova")
THICKNESSES = (1.0, 2.0, 3.0, 4.0, 5.0)  # mm
STEP = 1e-4  # m of motion between the states at which an edge is checked again


def bench_misses(
    folder: Path,
    edges: int = 40,
    robots: Sequence[str] = ROBOTS,
    thicknesses: Sequence[float] = THICKNESSES,
    seed: int = 0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Results[Row]:
    """Judge ``edges`` edges for each robot, kind of obstacle and thickness (mm); write ``misses.csv``, ``misses.md``.

    Rows of the same robot, obstacle, edges, seed and software that are there already are kept. Once stopped
    the current row is abandoned. Raises OptionError for numbers out of range, RobotError for an unknown robot,
    FileError where the folder cannot be used.
    """
    require_seed(seed)
    if edges < 1 or not all(0.0 < t <= 100.0 for t in thicknesses):
        raise OptionError("give at least 1 edge, and thicknesses above 0 and up to 100 mm.")
    for name in robots:
        Robot.load(name)
    here = software()
    return run_bench(
        folder,
        "misses",
        Row,
        [(name, kind, float(t)) for name in robots for kind in KINDS for t in thicknesses],
        lambda table, case: table.find((*case, edges, seed, here)),
        partial(_measure, edges=edges, seed=seed),
        to_markdown,
        "obstacles",
        progress,
        workers=workers,
    )


@cache
def _with_pairs(name: str) -> Robot:
    """The robot with its unchecked link pairs worked out once instead of in every scene."""
    robot = Robot.load(name)
    if robot.disabled_pairs is not None:
        return robot
    from planner.collision.coal import CoalChecker

    return replace(robot, disabled_pairs=generate_disabled_pairs(robot, CoalChecker))


def _measure(case: tuple[str, str, float], progress: Progress, edges: int, seed: int) -> list[Row]:
    """Scene after scene until there are ``edges`` edges; no row where stopped."""
    name, kind, thickness_mm = case
    robot = _with_pairs(name)
    # each row has a stream of its own, so that it is the same whichever others were asked for
    rng = np.random.default_rng([seed, KINDS.index(kind), round(1000 * thickness_mm), *name.encode()])
    alone = make_checker(robot, Scene("empty"), "coal")
    judged: list[Judged] = []
    while len(judged) < edges:
        for one in judge(robot, thin_case(alone, kind, 1e-3 * thickness_mm, rng), edges - len(judged)):
            judged.append(one)
            if progress.stopped:
                return []
    misses = [one.describe() for one in judged if any(one.missed(backend) for backend in BACKENDS)]
    return [
        Row(
            robot=name,
            obstacle=kind,
            thickness_mm=thickness_mm,
            edges=edges,
            seed=seed,
            touching=sum(one.touches["coal"] for one in judged),
            ompl_free=sum(one.ompl_free for one in judged),
            ompl_missed=sum(one.ompl_free and one.touches["coal"] for one in judged),
            **{f"{b}_proven": sum(one.proven[b] for one in judged) for b in BACKENDS},
            **{f"{b}_missed": sum(one.missed(b) for one in judged) for b in BACKENDS},
            **{f"{b}_left_out": sum(not one.proven[b] and not one.touches["coal"] for one in judged) for b in BACKENDS},
            looks=sum(one.looks for one in judged),
            found=json.dumps(misses[:3]) if misses else "",
            software=software(),
        )
    ]


@dataclass(frozen=True, eq=False)
class Judged:
    """The results for one edge of a case.

    ``proven``: by backend. ``touches``: by backend, at 0.1 mm; FCL is asked only about what coal's prover certified.
    ``ompl_free``: OMPL's rule finds no contact. ``looks``: configurations sampled every 0.1 mm.
    """

    case: ThinCase
    edge: int
    proven: dict[str, bool]
    touches: dict[str, bool]
    ompl_free: bool
    looks: int

    def missed(self, backend: str) -> bool:
        """Certified with this backend, and touching for the other."""
        other = next(b for b in BACKENDS if b != backend)
        return self.proven[backend] and self.touches[other]

    def describe(self) -> dict[str, Any]:
        """Enough to look at the edge again."""
        return {
            "certified by": [backend for backend in BACKENDS if self.missed(backend)],
            "start": self.case.start[self.edge].tolist(),
            "delta": self.case.delta[self.edge].tolist(),
            "obstacles": [
                {"shape": repr(item.shape), "placement": item.placement.tolist()} for item in self.case.scene.obstacles
            ],
        }


def judge(robot: Robot, case: ThinCase, most: int) -> Iterator[Judged]:
    """The first ``most`` edges of a case: proven by both backends, sampled by OMPL's rule and every 0.1 mm."""
    checkers: dict[str, CollisionChecker] = {name: make_checker(robot, case.scene, name) for name in BACKENDS}
    start, delta = case.start[:most], case.delta[:most]
    free = {name: EdgeProver(checker).prove(start, delta).free for name, checker in checkers.items()}
    for k, (a, d) in enumerate(zip(start, delta, strict=True)):
        proven = {name: bool(free[name][k]) for name in BACKENDS}
        by_coal, looks = look_closely(checkers["coal"], a, d)
        by_fcl, more = look_closely(checkers["fcl"], a, d) if proven["coal"] else (False, 0)
        ompl_free = checkers["coal"].first_contact(states_by_ompls_rule(robot, a, d)) is None
        yield Judged(case, k, proven, {"coal": by_coal, "fcl": by_fcl}, ompl_free, looks + more)


def look_closely(checker: CollisionChecker, start: Floats, delta: Floats) -> tuple[bool, int]:
    """Whether an edge touches anything when sampled every 0.1 mm of motion, and how many states that took.

    State by state: whatever spares looks would be judged by itself.
    """
    states, _ = dense_states(checker.world, start, delta, STEP)
    found = checker.first_contact(states)
    return found is not None, len(states) if found is None else found[0] + 1
