"""Modes: the poses of objects and the held object, and the proofs of motions in each mode."""

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
VIOLATES = "violates"  # in place of two names: a constraint is not proven


@dataclass(frozen=True)
class Mode:
    """Placements of standing objects, the grasp of the held one, by number, and allowed contacts."""

    standing: tuple[int, ...]
    held: int | None = None
    allowed: Pairs = NONE

    def allow(self, *pairs: tuple[str, str]) -> Mode:
        """Return the mode with more allowed contacts."""
        return replace(self, allowed=self.allowed | {frozenset(pair) for pair in pairs})


ARM = Mode(())  # the arm among fixed obstacles


@dataclass(frozen=True, eq=False)
class Placement:
    """The pose (4, 4) of a standing object, and its supports."""

    object: str
    pose: Floats
    supports: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class HeldObject:
    """An object in the hand: the tool's pose (4, 4) in its frame, and the opening (m) of the gripper.

    The link of the tool and the links ``touch`` may touch it.
    """

    object: str
    tool: Floats
    opening: float | None = None
    touch: tuple[str, ...] = ()


@dataclass(eq=False)
class Modes:
    """The worlds of all modes of one robot among fixed obstacles, and the proofs of motions in them.

    ``checker`` has the robot with an empty hand among fixed obstacles. A motion is free in a mode if all clauses of the
    mode are proven. Modes share clauses, so only new pairs need a proof, and only when a path uses the motion.
    """

    checker: CollisionChecker
    objects: dict[str, Obstacle]
    placements: list[Placement] = field(default_factory=list)
    grasps: list[HeldObject] = field(default_factory=list)
    verdicts: dict[Mode, Ints] = field(default_factory=dict)  # (motions,) of OPEN, FREE, BLOCKED by clause
    blame: dict[tuple[Mode, int], str] = field(default_factory=dict)  # contact of a blocked motion, or VIOLATES
    pieces_proven: int = 0
    progress: Progress = QUIET  # a requested stop does not interrupt a proof

    def __post_init__(self) -> None:
        self.robot = self.checker.robot
        self.motions = Motions(self.robot)
        self._provers = {ARM: EdgeProver(self.checker, self.progress, "proofs")}  # includes constraints of all motions

    def take(self, item: Carried) -> int:
        """Add an object that the arm holds at the start; return the number of its grasp."""
        robot, holder = self.robot, frame_of_carried(self.robot, item)
        tool = robot.model.frames[robot.tool_id]
        if holder.parentJoint != tool.parentJoint:
            raise TaskError(f"'{item.name}' is held by '{item.link}', which does not move with the tool: detach it.")
        in_hand = (tool.placement.inverse() * holder.placement).homogeneous @ item.placement
        at = tool_pose(robot, robot.home).homogeneous @ in_hand
        self.objects[item.name] = Obstacle(item.name, item.shape, at)
        touch = (item.link, *item.touch_links)
        self.grasps.append(HeldObject(item.name, np.linalg.inv(in_hand), touch=touch))
        return len(self.grasps) - 1

    def clauses(self, mode: Mode) -> list[Mode]:
        """Return the clauses of a motion in ``mode``, each a mode with at most one standing object.

        They are the arm among fixed obstacles; the arm against each standing object; the held object against arm and
        fixed obstacles, and against each standing object.
        """

        def permissions_of(name: str) -> Pairs:
            return frozenset(pair for pair in mode.allowed if name in pair)

        allowed = {at: permissions_of(self.placements[at].object) for at in mode.standing}
        clauses = [ARM, *(Mode((at,), None, pairs) for at, pairs in allowed.items())]
        if mode.held is not None:
            mine = permissions_of(self.grasps[mode.held].object)
            clauses.append(Mode((), mode.held, mine.difference(*allowed.values())))
            clauses += [Mode((at,), mode.held, mine & pairs) for at, pairs in allowed.items()]
        return clauses

    def checker_of(self, mode: Mode) -> CollisionChecker:
        """Return the checker of the world of a mode."""
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
        """Return a prover of a clause's pairs: with the standing object, and with the last body, the held one."""
        if clause not in self._provers:
            checker = self._make_checker(clause, fixed=not clause.standing)
            world, last = checker.world, len(checker.world.bodies) - 1
            scene, own = np.ones_like(world.checked), np.full(len(world.self_pairs), not clause.standing)
            if clause.held is not None:
                scene[:last], own = False, own & (world.self_pairs == last).any(axis=1)
            self._provers[clause] = EdgeProver(checker, self.progress, "proofs").only(np.append(scene, own))
        return self._provers[clause]

    def verdicts_of(self, clause: Mode) -> Ints:
        """Return OPEN, FREE or BLOCKED (motions,) in a clause."""
        have = self.verdicts.get(clause, np.zeros(0, dtype=np.int64))
        if len(have) < self.motions.count:
            have = self.verdicts[clause] = np.append(have, np.zeros(self.motions.count - len(have), dtype=np.int64))
        return have

    def prove(self, clause: Mode, numbers: Ints) -> None:
        """Prove the open ones of the motions ``numbers`` (k,) in a clause."""
        known = self.verdicts_of(clause)
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
            self.blame.setdefault((clause, int(owner[k])), VIOLATES if contact is None else str(contact))

    def why(self, mode: Mode, motion: int) -> str | None:
        """Return the contact of a motion in a mode, or ``VIOLATES``; None if it is not blocked."""
        return next((self.blame[c, motion] for c in self.clauses(mode) if (c, motion) in self.blame), None)


class Motions:
    """Joint motions by number, each a run of straight pieces."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.count = robot, 0
        self._added: list[tuple[Floats, Floats, Ints]] = []  # starts and deltas of pieces, number per motion
        self._first = np.zeros(1, dtype=np.int64)  # first piece of each motion, and the number of pieces

    def add_path(self, corners: Floats) -> int:
        """Add a motion through ``corners`` (k, dof) and return its number; a single corner is a rest."""
        corners = corners if len(corners) > 1 else np.vstack([corners, corners])
        return int(self._add(corners[:-1], np.diff(corners, axis=0), np.array([len(corners) - 1]))[0])

    def add_edges(self, start: Floats, end: Floats) -> Ints:
        """Add straight motions between configurations (k, dof) and return their numbers (k,)."""
        return self._add(start, self.robot.difference(start, end), np.ones(len(start), dtype=np.int64))

    def _add(self, start: Floats, delta: Floats, counts: Ints) -> Ints:
        self._added.append((start, delta, counts))
        self.count += len(counts)
        return np.arange(self.count - len(counts), self.count)

    def select(self, motions: Ints) -> tuple[Floats, Floats, Ints]:
        """Return starts and deltas (p, dof) of the straight pieces of ``motions``, and the motion of each."""
        if len(self._first) <= self.count:
            start, delta, counts = map(np.concatenate, zip(*self._added, strict=True))
            self._added, self._first = [(start, delta, counts)], cumulative_sums(counts)
        start, delta, counts = self._added[0]
        rows = ranges(self._first[motions], counts[motions])
        return start[rows], delta[rows], np.repeat(motions, counts[motions])

    def corners(self, motion: int) -> Floats:
        """Return the corners (k, dof) of a motion."""
        start, delta, _ = self.select(np.array([motion]))
        return np.vstack([start, start[-1:] + delta[-1:]])
