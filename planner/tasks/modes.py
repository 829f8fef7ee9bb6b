"""Modes: what stands where and what is held, and what is proven of motions in each, part of the world by part."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from planner.base.arrays import Floats, Ints, cumulative_sums, frozen, ranges
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.forward import tool_pose
from planner.problem.conditions import Condition
from planner.robot.robot import Robot, frame_of_carried, with_carried
from planner.robot.shapes import Carried, Obstacle
from planner.tasks.task import TaskError

OPEN, FREE, BLOCKED = 0, 1, 2
Pairs = frozenset[frozenset[str]]
NONE: Pairs = frozenset()
STRAYS = "strays"  # in the place of two names: what motions keep is not proven of it


@dataclass(frozen=True)
class Mode:
    """Numbers of the placements at which objects stand, of the grasp that holds one, and pairs that may touch."""

    standing: tuple[int, ...]
    held: int | None = None
    allowed: Pairs = NONE

    def allow(self, *pairs: tuple[str, str]) -> Mode:
        return replace(self, allowed=self.allowed | {frozenset(pair) for pair in pairs})


ARM = Mode(())  # among what never moves


@dataclass(frozen=True, eq=False)
class Placement:
    """Where an object stands, (4, 4) in the world, and on what."""

    object: str
    pose: Floats
    supports: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Held:
    """An object in the hand: the tool's pose (4, 4) in its frame, and how wide (m) the gripper is, if that is known.

    The links ``touch`` may touch it besides the tool's.
    """

    object: str
    tool: Floats
    opening: float | None = None
    touch: tuple[str, ...] = ()


@dataclass(eq=False)
class Modes:
    """The worlds of all modes of one robot among fixed obstacles, and what is known of motions in them.

    ``checker`` knows the robot without what it picks, among what never moves. A motion is free in a mode where all
    clauses of the mode are proven. So a mode needs proofs only for pairs that no mode before it had, and a proof is
    made when a path asks for it.
    """

    checker: CollisionChecker
    objects: dict[str, Obstacle]
    placements: list[Placement] = field(default_factory=list)
    grasps: list[Held] = field(default_factory=list)
    verdicts: dict[Mode, Ints] = field(default_factory=dict)  # by clause: (motions,) of OPEN, FREE, BLOCKED
    blame: dict[tuple[Mode, int], str] = field(default_factory=dict)  # what a blocked motion touches, or STRAYS
    pieces_proven: int = 0
    progress: Progress = QUIET  # of proofs, which a request to stop leaves whole

    def __post_init__(self) -> None:
        self.robot = self.checker.robot
        self.motions = Motions(self.robot)
        self._provers = {ARM: EdgeProver(self.checker, self.progress, "proofs")}  # of what all motions keep too

    def take(self, item: Carried) -> int:
        """Let the arm hold something from the beginning: the number of its grasp."""
        robot, holder = self.robot, frame_of_carried(self.robot, item)
        tool = robot.model.frames[robot.tool_id]
        if holder.parentJoint != tool.parentJoint:
            raise TaskError(f"'{item.name}' is held by '{item.link}', which does not move with the tool: detach it.")
        in_hand = (tool.placement.inverse() * holder.placement).homogeneous @ item.placement
        at = tool_pose(robot, robot.home).homogeneous @ in_hand
        self.objects[item.name] = Obstacle(item.name, item.shape, at)
        touch = (item.link, *item.touch_links)
        self.grasps.append(Held(item.name, np.linalg.inv(in_hand), touch=touch))
        return len(self.grasps) - 1

    def clauses(self, mode: Mode) -> list[Mode]:
        """What has to be proven of a motion in ``mode``, each a mode in which one thing stands at most.

        The arm among what is fixed, which is the same for all; the arm against each object that stands; what is held
        against arm and fixed obstacles, and against each object that stands.
        """

        def among(name: str) -> Pairs:
            return frozenset(pair for pair in mode.allowed if name in pair)

        beside = {at: among(self.placements[at].object) for at in mode.standing}
        found = [ARM, *(Mode((at,), None, pairs) for at, pairs in beside.items())]
        if mode.held is not None:
            mine = among(self.grasps[mode.held].object)
            found.append(Mode((), mode.held, mine.difference(*beside.values())))
            found += [Mode((at,), mode.held, mine & pairs) for at, pairs in beside.items()]
        return found

    def checker_of(self, mode: Mode) -> CollisionChecker:
        """A checker of all that is there in a mode."""
        return self._make_checker(mode, self.checker.world.conditions)

    def _make_checker(self, mode: Mode, conditions: tuple[Condition, ...] = (), fixed: bool = True) -> CollisionChecker:
        base, robot = self.checker.world, self.robot
        if mode.held is not None:
            item = self.grasps[mode.held]
            at, shape = frozen(np.linalg.inv(item.tool)), self.objects[item.object].shape
            robot = with_carried(robot, [Carried(robot.tool, item.object, shape, at, item.touch)])
        placed = (self.placements[k] for k in mode.standing)
        standing = [replace(self.objects[each.object], placement=each.pose) for each in placed]
        obstacles = (*(base.obstacles if fixed else ()), *standing)
        scene = replace(base.scene, obstacles=obstacles, allowed=base.scene.allowed | mode.allowed)
        return type(self.checker)(replace(base.among(scene, robot), conditions=conditions), self.checker)

    def _prover(self, clause: Mode) -> EdgeProver:
        """A prover of a clause's own pairs: those of what stands, and of the last body, which is the one held."""
        if clause not in self._provers:
            checker = self._make_checker(clause, fixed=not clause.standing)
            world, last = checker.world, len(checker.world.bodies) - 1
            scene, own = np.ones_like(world.checked), np.full(len(world.self_pairs), not clause.standing)
            if clause.held is not None:
                scene[:last], own = False, own & (world.self_pairs == last).any(axis=1)
            self._provers[clause] = EdgeProver(checker, self.progress, "proofs").only(np.append(scene, own))
        return self._provers[clause]

    def known(self, clause: Mode) -> Ints:
        """(motions,) what is known of motions in a clause."""
        have = self.verdicts.get(clause, np.zeros(0, dtype=np.int64))
        if len(have) < self.motions.count:
            have = self.verdicts[clause] = np.append(have, np.zeros(self.motions.count - len(have), dtype=np.int64))
        return have

    def prove(self, clause: Mode, numbers: Ints) -> None:
        """Prove what is open of the motions ``numbers`` (k,) in a clause."""
        known = self.known(clause)
        todo = np.unique(numbers[known[numbers] == OPEN])
        if not len(todo):
            return
        prover, (start, delta, owner) = self._prover(clause), self.motions.select(todo)
        self.pieces_proven += len(start)
        proofs = prover.prove(start, delta, contacts=False)
        known[todo] = FREE
        for k in np.flatnonzero(~proofs.free).tolist():
            known[owner[k]] = BLOCKED
            pair = int(proofs.pair[k])
            contact = prover.static_contact if pair < 0 else prover.world.contact(pair)
            self.blame.setdefault((clause, int(owner[k])), STRAYS if contact is None else str(contact))

    def why(self, mode: Mode, motion: int) -> str | None:
        """What a motion touches in a mode, or ``STRAYS``; None where nothing is known to block it."""
        return next((self.blame[c, motion] for c in self.clauses(mode) if (c, motion) in self.blame), None)


class Motions:
    """Joint motions by number, each a run of straight pieces."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.count = robot, 0
        self._added: list[tuple[Floats, Floats, Ints]] = []  # starts and deltas of pieces, and how many a motion has
        self._first = np.zeros(1, dtype=np.int64)  # piece of each motion, and how many pieces there are

    def add_path(self, corners: Floats) -> int:
        """A motion through ``corners`` (k, dof), its number; one of a single corner stays there."""
        corners = corners if len(corners) > 1 else np.vstack([corners, corners])
        return int(self._add(corners[:-1], np.diff(corners, axis=0), np.array([len(corners) - 1]))[0])

    def add_edges(self, start: Floats, end: Floats) -> Ints:
        """Straight motions between configurations (k, dof), their numbers (k,)."""
        return self._add(start, self.robot.difference(start, end), np.ones(len(start), dtype=np.int64))

    def _add(self, start: Floats, delta: Floats, counts: Ints) -> Ints:
        self._added.append((start, delta, counts))
        self.count += len(counts)
        return np.arange(self.count - len(counts), self.count)

    def select(self, motions: Ints) -> tuple[Floats, Floats, Ints]:
        """The pieces of ``motions``, starts and deltas (p, dof), and which motion each belongs to."""
        if len(self._first) <= self.count:
            start, delta, counts = map(np.concatenate, zip(*self._added, strict=True))
            self._added, self._first = [(start, delta, counts)], cumulative_sums(counts)
        start, delta, counts = self._added[0]
        rows = ranges(self._first[motions], counts[motions])
        return start[rows], delta[rows], np.repeat(motions, counts[motions])

    def corners(self, motion: int) -> Floats:
        """The corners (k, dof) of a motion."""
        start, delta, _ = self.select(np.array([motion]))
        return np.vstack([start, start[-1:] + delta[-1:]])
