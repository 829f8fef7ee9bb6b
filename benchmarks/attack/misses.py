"""Edges past walls, poles and windows of a few millimetres: which of those called free touch at 0.1 mm of motion."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from benchmarks.attack.thin_obstacles import KINDS, ThinCase, thin_case
from planner.base.arrays import Floats
from planner.base.progress import Progress
from planner.collision import BACKENDS, make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.collision.recheck import dense_states
from planner.collision.self_pairs import generate_disabled_pairs
from planner.robot.robot import Robot
from planner.robot.scene import Scene

ROBOTS = ("iiwa14", "panda", "ur5", "planar_2r", "kinova")
RULE = "OMPL's rule"
STEP = 1e-4  # m of motion between the states at which an edge is checked again
FRACTION = 0.01
"""OMPL's default longest valid segment, as a share of the space's extent."""


def states_by_ompls_rule(robot: Robot, start: Floats, delta: Floats) -> Floats:
    """The configurations (n, dof) that OMPL's DiscreteMotionValidator would check along an edge, both ends included.

    With its default settings it divides the edge into the least number of equal parts no longer than ``FRACTION``
    of the space's largest extent: for joints with limits, one real vector space, the diagonal of its box. A space with
    continuous joints is a compound of one space a joint, as this planner makes it for OMPL, and takes the
    largest of their numbers (a circle's extent is pi).
    """
    length = np.abs(delta)
    if robot.continuous.any():
        extent = np.where(robot.continuous, np.pi, robot.upper - robot.lower)
        parts = int(np.ceil(length / (FRACTION * extent)).max(initial=0.0))
    else:
        extent = float(np.linalg.norm(robot.upper - robot.lower))
        parts = int(np.ceil(np.linalg.norm(delta) / (FRACTION * extent)))
    return start + np.linspace(0.0, 1.0, max(parts, 1) + 1)[:, None] * delta


@cache
def _with_pairs(name: str) -> Robot:
    """The robot with its unchecked link pairs worked out once instead of in every scene."""
    robot = Robot.load(name)
    if robot.disabled_pairs is not None:
        return robot
    from planner.collision.coal import CoalChecker

    return replace(robot, disabled_pairs=generate_disabled_pairs(robot, CoalChecker))


def attack_edges(
    name: str, kind: str, thickness_mm: float, edges: int, seed: int, progress: Progress
) -> list[dict[str, Any]] | None:
    """Columns of OMPL's rule and of the proof with each library; None where stopped."""
    robot = _with_pairs(name)
    # each row has a stream of its own, so that it is the same whichever others were asked for
    rng = np.random.default_rng([seed, KINDS.index(kind), round(1000 * thickness_mm), *name.encode()])
    alone = make_checker(robot, Scene("empty"), "coal")
    judged: list[Judged] = []
    while len(judged) < edges:
        for one in judge(robot, thin_case(alone, kind, 1e-3 * thickness_mm, rng), edges - len(judged)):
            judged.append(one)
            if progress.stopped:
                return None
    rule = _columns(judged, lambda one: one.ompl_free, lambda one: one.ompl_free and one.touches["coal"])
    return [rule, *(_columns(judged, lambda one, b=b: one.proven[b], lambda one, b=b: one.missed(b)) for b in BACKENDS)]


def _columns(judged: list[Judged], free: Callable[[Judged], bool], missed: Callable[[Judged], bool]) -> dict[str, Any]:
    misses = [one.describe() for one in judged if missed(one)]
    return {
        "tried": len(judged),
        "touching": sum(one.touches["coal"] for one in judged),
        "free": sum(map(free, judged)),
        "false_free": len(misses),
        "left_out": sum(not free(one) and not one.touches["coal"] for one in judged),
        "looks": sum(one.looks for one in judged),
        "found": json.dumps(misses[:3]) if misses else "",
    }


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
