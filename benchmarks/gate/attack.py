"""An optimiser that moves chunk and obstacle towards a chunk that the gate calls safe, and that touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from benchmarks.attack.climb import climb
from benchmarks.gate.chunks import KINDS, Chunk, Rng, random_chunk, thin_obstacle
from benchmarks.gate.false_stops import least_gap
from benchmarks.gate.judge import Spline, beyond_limits, motion_of, states_apart, stops_of, touches
from planner.base.arrays import Floats
from planner.base.progress import QUIET, Progress
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalChecker
from planner.kinematics.forward import tool_pose
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle
from planner.session.gate import Gate
from planner.session.verdict import Verdict

_STEPS, _SECONDS, _SIZES = 3, (0.2, 0.8), (0.05, 0.3)
_MEASURED = 60  # states without an allowed contact whose distances are measured, for the climb
_APART = 0.05  # rad between two samples of those who sample


AIMS = ("safe", "allowed", "slowed")


@dataclass(frozen=True, eq=False)
class Case:
    """A chunk and what stands in its way; ``contact``: a link that may touch it, for so many s or in a box (6,)."""

    chunk: Chunk
    obstacle: Obstacle
    contact: tuple[str, float | None, Floats | None] | None = None


@dataclass
class Found:
    """What an attack counts. ``sampled``: touching ones that samples every 0.05 rad call free, of ``touching`` seen.

    ``slowed``: unsafe ones that are called safe in more time.
    """

    tries: int = 0
    safe: int = 0
    slowed: int = 0
    false: list[Case] = field(default_factory=list)
    beyond: int = 0
    least: float = np.inf
    touching: int = 0
    sampled: int = 0


class Attack:
    """The attack on one robot's gate by chunks of some ``kinds``; ``found`` grows with every try.

    It aims at chunks that are called safe, at those with an allowed contact, or at those that are called safe slowed.
    """

    def __init__(self, robot: Robot, kinds: Sequence[str] = KINDS, aim: str = "safe") -> None:
        self.robot, self.kinds, self.aim, self.found = robot, kinds, aim, Found()
        self._gate = Gate(robot, Scene("attack", (thin_obstacle(robot, _zero(robot), np.random.default_rng(0)),)))

    def run(self, tries: int, rng: Rng, progress: Progress = QUIET) -> bool:
        """Try so many cases; False where it was stopped."""
        return climb(tries, rng, self._begin, self._step, self._score, progress)

    def _begin(self, rng: Rng) -> Case:
        kind = self.kinds[int(rng.integers(len(self.kinds)))]
        chunk = random_chunk(self.robot, kind, _STEPS, rng.uniform(*_SECONDS), rng, rng.uniform(*_SIZES))
        near = chunk.knots[int(rng.integers(len(chunk.knots))), 0]
        if self.aim == "slowed":  # where a stop from the end leads
            near = chunk.knots[-1, 0] + rng.uniform(0.0, 0.2) * chunk.knots[-1, 1]
        return Case(chunk, thin_obstacle(self.robot, near, rng), self._contact(near, rng))

    def _contact(self, near: Floats, rng: Rng) -> tuple[str, float | None, Floats | None] | None:
        """A contact that is allowed for a part of the chunk, or in a box around the tool in a configuration."""
        if self.aim != "allowed":
            return None
        links = list(dict.fromkeys(body.link for body in self.robot.bodies))
        link = links[int(rng.integers(len(links) // 2, len(links)))]
        if rng.random() < 0.5:
            return link, float(rng.uniform(0.02, 1.5)), None
        tool = tool_pose(self.robot, near).translation
        return link, None, np.concatenate([tool - rng.uniform(0.02, 0.5, 3), tool + rng.uniform(0.02, 0.5, 3)])

    def _step(self, case: Case, size: float, rng: Rng) -> Case:
        chunk, placement = case.chunk, case.obstacle.placement.copy()
        if case.contact is not None and rng.random() < 0.3:
            link, seconds, box = case.contact
            if seconds is not None:
                return replace(case, contact=(link, max(1e-3, seconds + rng.normal(0.0, 0.3 * size)), None))
            assert box is not None
            moved = box + rng.normal(0.0, 0.1 * size, 6)
            moved[3:] = np.maximum(moved[3:], moved[:3] + 1e-3)
            return replace(case, contact=(link, None, moved))
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
        if case.contact is not None:
            gate.allow(case.contact[0], "thin", seconds=case.contact[1], box=case.contact[2])
        columns, named = case.chunk.arguments()
        verdict = gate.check(*columns, **named)  # pyright: ignore[reportArgumentType]
        slower = verdict.slower if self.aim == "slowed" else None
        if slower is not None:
            found.slowed += 1
            run = slower._run()
            return self._judge_proven(case, Chunk(case.chunk.kind, run.times, run.knots), slower, case.chunk)
        if not verdict.safe:
            if verdict.reason is not None and verdict.reason.kind == "contact" and verdict.reason.on == "motion":
                found.touching += 1
                found.sampled += _sampled_free(motion_of(case.chunk), second_checker(gate.checker))
            slowable = self.aim == "slowed" and verdict.reason is not None and verdict.reason.on == "stop"
            return -2.0 + verdict.safe_until / float(case.chunk.times[-1]) + slowable
        found.safe += 1
        score = self._judge_proven(case, case.chunk, verdict, case.chunk)
        return score if self.aim != "slowed" else -1.5

    def _judge_proven(self, case: Case, chunk: Chunk, verdict: Verdict, asked: Chunk) -> float:
        """Look at a motion that is called safe; ``asked`` has the same start and the same end."""
        found, gate = self.found, self._gate
        guard = gate._current_guard()  # without the pair that may touch
        coal = second_checker(guard.checker)
        assert isinstance(coal, CoalChecker)
        motion, stops = motion_of(chunk), stops_of(chunk, verdict)
        known = stops or []
        found.beyond += beyond_limits(motion, known, gate.limits, chunk.kind) > 0
        least, touched = touches([*motion, *known], (coal, guard.checker))
        jumps = np.abs(chunk.knots[[0, -1], 0] - asked.knots[[0, -1], 0]).max()
        if chunk.kind != "lines":
            jumps = max(jumps, np.abs(chunk.knots[0, 1] - asked.knots[0, 1]).max())
        if case.contact is not None:
            link, seconds, box = case.contact
            left = np.inf if seconds is None else gate.world.permissions[0].until - verdict._guard.now
            states = states_apart(self.robot, [*motion, *known], link, left, box)
            full = second_checker(gate.checker)
            touched = touched or (len(states) > 0 and full.first_contact(states) is not None)
            least = min(least, least_gap(full, states[:: len(states) // _MEASURED + 1]))
        found.least = min(found.least, least)
        if stops is None or touched or jumps > 1e-9:
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
