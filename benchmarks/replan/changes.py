"""Seeded changes of a session's world: things moved, added and removed, and a box put on the route."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planner.base.errors import SceneError, StateError
from planner.kinematics.forward import tool_positions
from planner.models.poses import pose
from planner.models.shapes import Box, Obstacle
from planner.planning.replanned import Change
from planner.planning.result import Plan
from planner.session.session import Session

KINDS = ("moved", "added", "removed", "blocking the route")
_TRIES = 30  # places drawn for one change: many touch the arm, the start or the goal
_BOXES = 8  # of ours in the scene at most
_SIZE = (0.04, 0.12)  # m, sides of the boxes
_FARTHEST = 0.15  # m, in each direction


@dataclass(frozen=True, eq=False)
class Step:
    """A change and the answer after it."""

    kind: str
    change: Change
    plan: Plan


class Changer:
    """Draws changes one after the other; the same for the same ``seed``. ``path``: the last one that was found."""

    def __init__(self, session: Session, answer: Plan, seed: int) -> None:
        self._session, self._rng, self._count = session, np.random.default_rng(seed), 0
        self._path = answer.path
        self._ours: list[str] = []

    def step(self, kind: str) -> Step | None:
        """A change of the ``kind`` and the answer after it; None where no usable place was found.

        What leaves the start or the goal in collision is undone: that is no question of replanning.
        """
        if kind in ("added", "blocking the route") and len(self._ours) >= _BOXES:
            self._remove(self._ours[0])
        for _ in range(_TRIES):
            try:
                change, undo = self._draw(kind)
            except SceneError:
                continue
            try:
                answer = self._session.replan()
            except StateError:
                undo()
                continue
            if answer.solved:
                self._path = answer.path
            return Step(kind, change, answer)
        return None

    def _draw(self, kind: str) -> tuple[Change, Callable[[], object]]:
        match kind:
            case "moved":
                return self._move()
            case "removed" if self._ours:
                return self._remove(str(self._rng.choice(self._ours)))
        positions = tool_positions(self._session.robot, self._path)
        where = positions[len(positions) // 2] if kind == "blocking the route" else self._rng.choice(positions)
        spread = 0.02 if kind == "blocking the route" else 2 * _FARTHEST
        return self._add((where + self._rng.uniform(-spread, spread, 3)).tolist())

    def _add(self, position: list[float]) -> tuple[Change, Callable[[], object]]:
        self._count += 1
        size = self._rng.uniform(*_SIZE, 3)
        box = Obstacle(f"box {self._count}", Box((float(size[0]), float(size[1]), float(size[2]))), pose(position))
        change = self._session.add(box)
        self._ours.append(box.name)
        return change, lambda: self._remove(box.name)

    def _remove(self, name: str) -> tuple[Change, Callable[[], object]]:
        item = next(obstacle for obstacle in self._session.scene.obstacles if obstacle.name == name)
        change = self._session.remove(name)
        self._ours.remove(name)

        def undo() -> None:
            self._session.add(item)
            self._ours.append(name)

        return change, undo

    def _move(self) -> tuple[Change, Callable[[], object]]:
        obstacles = self._session.scene.obstacles
        item = obstacles[int(self._rng.integers(len(obstacles)))]
        before = item.placement[:3, 3]
        to = before + self._rng.uniform(-_FARTHEST, _FARTHEST, 3)
        return self._session.move(item.name, position=to), lambda: self._session.move(item.name, position=before)
