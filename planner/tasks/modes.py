"""Modes: what stands where and what is held, and what is proven of motions in each, part of the world by part."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen, ranges, so_far
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.collision.world import World
from planner.kinematics.forward import tool_pose
from planner.models.robot import Robot, held_in, with_carried
from planner.models.shapes import Carried, Obstacle
from planner.problem.conditions import Condition
from planner.tasks.file import Grasp, TaskError

OPEN, FREE, BLOCKED = 0, 1, 2
Pairs = frozenset[frozenset[str]]
NONE: Pairs = frozenset()
STRAYS = "strays"  # in the place of two names: what motions keep is not proven of it
Clause = tuple[Any, ...]
"""Two parts of the world: the arm, what it holds, what stands; and which of their pairs may touch."""


@dataclass(frozen=True)
class Mode:
    """``standing``: numbers of places, of the objects that stand; ``held``: number of the grasp that holds one.

    ``allowed``: pairs of names that may touch in it, as fingers and an object do while one goes to the other.
    """

    standing: tuple[int, ...]
    held: int | None = None
    allowed: Pairs = NONE

    def allowing(self, *pairs: tuple[str, str]) -> Mode:
        return replace(self, allowed=self.allowed | {frozenset(pair) for pair in pairs})


@dataclass(frozen=True, eq=False)
class Place:
    """Where an object stands, (4, 4) in the world, and on what."""

    object: str
    pose: Floats
    supports: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Held:
    """An object in a grasp, which the links ``touch`` may touch besides the tool's."""

    object: str
    grasp: Grasp
    touch: tuple[str, ...] = ()


@dataclass(eq=False)
class Modes:
    """The worlds of all modes of one robot among fixed obstacles, and what is known of motions in them.

    ``checker`` knows the robot without what it picks, among what never moves. A motion is free in a mode where all
    clauses of the mode are proven: the arm among what is fixed, which is the same for all; the arm against each object
    that stands; what is held against arm and fixed obstacles, and against each object that stands. So a mode needs
    proofs only for pairs that no mode before it had, and a proof is made when a path asks for it.
    """

    checker: CollisionChecker
    disabled: Pairs
    objects: dict[str, Obstacle]
    places: list[Place] = field(default_factory=list)
    grasps: list[Held] = field(default_factory=list)
    verdicts: dict[Clause, Ints] = field(default_factory=dict)  # (motions,) of OPEN, FREE, BLOCKED
    blame: dict[tuple[Clause, int], str] = field(default_factory=dict)  # what a blocked motion touches, or STRAYS
    pieces_proven: int = 0

    def __post_init__(self) -> None:
        self.motions = Motions(self.robot)
        self._provers: dict[Clause, EdgeProver] = {}
        self._checkers: dict[Mode, CollisionChecker] = {}
        self._holding: dict[int | None, Robot] = {None: self.robot}

    @property
    def robot(self) -> Robot:
        return self.checker.robot

    def take(self, item: Carried) -> int:
        """Let the arm hold something from the beginning: the number of its grasp."""
        robot, holder = self.robot, held_in(self.robot, item)
        tool = robot.model.frames[robot.tool_id]
        if holder.parentJoint != tool.parentJoint:
            raise TaskError(f"'{item.name}' is held by '{item.link}', which does not move with the tool: detach it.")
        in_hand = (tool.placement.inverse() * holder.placement).homogeneous @ item.placement
        at = tool_pose(robot, robot.home).homogeneous @ in_hand
        self.objects[item.name] = Obstacle(item.name, item.shape, at)
        touch = (item.link, *item.touch_links)
        self.grasps.append(Held(item.name, Grasp(np.linalg.inv(in_hand)), touch))
        return len(self.grasps) - 1

    def clauses(self, mode: Mode) -> list[Clause]:
        """What has to be proven of a motion in ``mode``."""

        def among(*names: str) -> Pairs:
            return frozenset(pair for pair in mode.allowed if not pair.isdisjoint(names))

        found: list[Clause] = [("arm",)]
        found += [("stands", place, among(self.places[place].object)) for place in mode.standing]
        if mode.held is not None:
            mine = self.grasps[mode.held].object
            others = {self.places[place].object for place in mode.standing}
            fixed = frozenset(pair for pair in among(mine) if pair.isdisjoint(others))
            found.append(("held", mode.held, fixed))
            found += [("beside", mode.held, p, among(mine) & among(self.places[p].object)) for p in mode.standing]
        return found

    def checker_of(self, mode: Mode) -> CollisionChecker:
        """A checker of all that is there in a mode."""
        if mode not in self._checkers:
            self._checkers[mode] = self._made(mode, self.checker.world.conditions)
        return self._checkers[mode]

    def _made(self, mode: Mode, conditions: tuple[Condition, ...] = (), fixed: bool = True) -> CollisionChecker:
        base, robot = self.checker.world, self._robot(mode.held)
        standing = [replace(self.objects[p.object], placement=p.pose) for p in (self.places[k] for k in mode.standing)]
        obstacles = (*(base.obstacles if fixed else ()), *standing)
        scene = replace(base.scene, obstacles=obstacles, allowed=base.scene.allowed | mode.allowed)
        world = World.of(robot, scene, self.disabled | robot.touching, base.margin, conditions)
        return type(self.checker)(world, self.checker)

    def _robot(self, held: int | None) -> Robot:
        """The robot with what a grasp holds."""
        if held is not None and held not in self._holding:
            item, pose = self.grasps[held], frozen(np.linalg.inv(self.grasps[held].grasp.pose))
            carried = Carried(self.robot.tool, item.object, self.objects[item.object].shape, pose, item.touch)
            self._holding[held] = with_carried(self.robot, [carried])
        return self._holding[held]

    def _prover(self, clause: Clause) -> EdgeProver:
        if clause not in self._provers:
            self._provers[clause] = self._prover_of(clause)
        return self._provers[clause]

    def _prover_of(self, clause: Clause) -> EdgeProver:
        """A prover of the pairs of a clause alone; what all motions keep is proven with those of the arm."""
        match clause:
            case ("arm",):
                return EdgeProver(self.checker)
            case ("stands", place, allowed):
                checker = self._made(Mode((place,), None, allowed), fixed=False)
                return EdgeProver(checker).only(_scene_pairs(checker.world))
            case ("held", held, allowed):
                checker = self._made(Mode((), held, allowed))
                return EdgeProver(checker).only(_of_last_body(checker.world))
            case (_, held, place, allowed):
                checker = self._made(Mode((place,), held, allowed), fixed=False)
                return EdgeProver(checker).only(_scene_pairs(checker.world) & _of_last_body(checker.world))
        raise AssertionError(clause)

    def known(self, clause: Clause) -> Ints:
        """(motions,) what is known of motions in a clause."""
        have, count = self.verdicts.get(clause, np.zeros(0, dtype=np.int64)), self.motions.count
        if len(have) < count:
            have = np.concatenate([have, np.zeros(count - len(have), dtype=np.int64)])
            self.verdicts[clause] = have
        return have

    def prove(self, clause: Clause, numbers: Ints) -> None:
        """Prove what is open of the motions ``numbers`` (k,) in a clause."""
        known = self.known(clause)
        todo = np.unique(numbers[known[numbers] == OPEN])
        if not len(todo):
            return
        prover, (start, delta, owner) = self._prover(clause), self.motions.of(todo)
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
        self.robot, self._start, self._delta = robot, [np.zeros((0, robot.dof))], [np.zeros((0, robot.dof))]
        self._counts: list[Ints] = [np.zeros(0, dtype=np.int64)]
        self._first = np.zeros(1, dtype=np.int64)
        self.count = 0

    def through(self, corners: Floats) -> int:
        """A motion through ``corners`` (k, dof), its number; one of a single corner stays there."""
        corners = corners if len(corners) > 1 else np.vstack([corners, corners])
        number = self.count
        self._add(corners[:-1], np.diff(corners, axis=0), np.array([len(corners) - 1]))
        return number

    def straight(self, start: Floats, end: Floats) -> Ints:
        """Straight motions between configurations (k, dof), their numbers (k,)."""
        first = self.count
        self._add(start, self.robot.difference(start, end), np.ones(len(start), dtype=np.int64))
        return first + np.arange(len(start))

    def _add(self, start: Floats, delta: Floats, counts: Ints) -> None:
        self._start.append(start)
        self._delta.append(delta)
        self._counts.append(counts)
        self.count += len(counts)

    def joined(self) -> tuple[Floats, Floats, Ints]:
        """All pieces: starts and motions (p, dof), and where those of each motion begin (motions + 1,)."""
        if len(self._start) > 1:
            self._start, self._delta = [np.concatenate(self._start)], [np.concatenate(self._delta)]
            self._counts = [np.concatenate(self._counts)]
            self._first = so_far(self._counts[0])
        return self._start[0], self._delta[0], self._first

    def of(self, motions: Ints) -> tuple[Floats, Floats, Ints]:
        """The pieces of ``motions``, and which motion each belongs to."""
        start, delta, first = self.joined()
        rows, counts = ranges(first[motions], np.diff(first)[motions]), np.diff(first)[motions]
        return start[rows], delta[rows], np.repeat(motions, counts)

    def corners(self, motion: int) -> Floats:
        """The corners (k, dof) of a motion."""
        start, delta, _ = self.of(np.array([motion]))
        return np.vstack([start, start[-1:] + delta[-1:]])


def _scene_pairs(world: World) -> Bools:
    return np.arange(world.checked.size + len(world.self_pairs)) < world.checked.size


def _of_last_body(world: World) -> Bools:
    """The pairs of the body that was added last, which is the one held."""
    last, count = len(world.bodies) - 1, len(world.obstacles)
    scene = np.repeat(np.arange(len(world.bodies)) == last, count)
    return np.concatenate([scene, (world.self_pairs == last).any(axis=1)])
