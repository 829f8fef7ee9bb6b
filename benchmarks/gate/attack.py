"""An optimiser that moves chunk and obstacle towards a chunk that the gate calls safe, and that touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from benchmarks.attack.climb import climb
from benchmarks.gate.chunks import KINDS, Chunk, Rng, random_chunk, thin_obstacle
from benchmarks.gate.judge import Spline, beyond_limits, motion_of, stops_of, touches
from planner.base.arrays import Floats
from planner.base.progress import QUIET, Progress
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalChecker
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle
from planner.session.gate import Gate

_STEPS, _SECONDS, _SIZES = 3, (0.2, 0.8), (0.05, 0.3)
_APART = 0.05  # rad between two samples of those who sample


@dataclass(frozen=True, eq=False)
class Case:
    """A chunk and what stands in its way."""

    chunk: Chunk
    obstacle: Obstacle


@dataclass
class Found:
    """What an attack counts. ``sampled``: touching ones that samples every 0.05 rad call free, of ``touching`` seen."""

    tries: int = 0
    safe: int = 0
    false: list[Case] = field(default_factory=list)
    beyond: int = 0
    least: float = np.inf
    touching: int = 0
    sampled: int = 0


class Attack:
    """The attack on one robot's gate by chunks of some ``kinds``; ``found`` grows with every try."""

    def __init__(self, robot: Robot, kinds: Sequence[str] = KINDS) -> None:
        self.robot, self.kinds, self.found = robot, kinds, Found()
        self._gate = Gate(robot, Scene("attack", (thin_obstacle(robot, _zero(robot), np.random.default_rng(0)),)))

    def run(self, tries: int, rng: Rng, progress: Progress = QUIET) -> bool:
        """Try so many cases; False where it was stopped."""
        return climb(tries, rng, self._begin, self._step, self._score, progress)

    def _begin(self, rng: Rng) -> Case:
        kind = self.kinds[int(rng.integers(len(self.kinds)))]
        chunk = random_chunk(self.robot, kind, _STEPS, rng.uniform(*_SECONDS), rng, rng.uniform(*_SIZES))
        near = chunk.knots[int(rng.integers(len(chunk.knots))), 0]
        return Case(chunk, thin_obstacle(self.robot, near, rng))

    def _step(self, case: Case, size: float, rng: Rng) -> Case:
        chunk, placement = case.chunk, case.obstacle.placement.copy()
        if rng.random() < 0.5:
            turn = pose([0.0, 0.0, 0.0], rpy=rng.normal(0.0, 0.3 * size, 3).tolist())[:3, :3]
            placement[:3, 3] += rng.normal(0.0, 0.1 * size, 3)
            placement[:3, :3] = turn @ placement[:3, :3]
            return replace(case, obstacle=replace(case.obstacle, placement=placement))
        knots = chunk.knots + rng.normal(0.0, 0.1 * size, chunk.knots.shape) * np.array([1.0, 3.0, 10.0])[:, None]
        low, high = np.where(self.robot.continuous, -np.inf, self.robot.lower), self.robot.upper
        knots[0, 0] = np.clip(knots[0, 0], low, np.where(self.robot.continuous, np.inf, high))
        return replace(case, chunk=replace(chunk, knots=knots))

    def _score(self, cases: Sequence[Case]) -> list[float]:
        return [self.judge(case) for case in cases]

    def judge(self, case: Case) -> float:
        """The score: safe ones before others, of these the nearest to a contact."""
        found, gate = self.found, self._gate
        found.tries += 1
        try:
            gate.world.remove("thin")
            gate.world.add(case.obstacle)
        except Exception as error:  # it stands in the base: the gate says so
            if "thin" not in str(error):
                raise
            gate.world.add(replace(case.obstacle, placement=pose([0.0, 0.0, 50.0])))
            return -np.inf
        columns, named = case.chunk.arguments()
        verdict = gate.check(*columns, **named)  # pyright: ignore[reportArgumentType]
        coal = second_checker(gate.checker)
        assert isinstance(coal, CoalChecker)
        judges = coal, gate.checker
        motion = motion_of(case.chunk)
        if not verdict.safe:
            if verdict.reason is not None and verdict.reason.kind == "contact" and verdict.reason.on == "motion":
                found.touching += 1
                found.sampled += _sampled_free(motion, judges[0])
            return -2.0 + verdict.safe_until / float(case.chunk.times[-1])
        found.safe += 1
        stops = stops_of(case.chunk, verdict)
        known = stops or []
        found.beyond += beyond_limits(motion, known, gate.limits, case.chunk.kind) > 0
        least, touched = touches([*motion, *known], judges)
        found.least = min(found.least, least)
        if stops is None or touched:
            found.false.append(case)
        return -min(least, 1.0)


def _sampled_free(motion: Sequence[Spline], judge: CollisionChecker) -> bool:
    """Whether samples at 0.05 rad, and both ends, see no contact."""
    states = np.concatenate([one.at(np.linspace(0.0, one.seconds, 100)) for one in motion])
    taken = [states[0]]
    for q in states:
        if np.abs(q - taken[-1]).max() >= _APART:
            taken.append(q)
    return judge.first_contact(np.array([*taken, states[-1]])) is None


def _zero(robot: Robot) -> Floats:
    return np.zeros(robot.dof)
