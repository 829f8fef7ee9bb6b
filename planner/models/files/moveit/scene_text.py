"""MoveIt's ``.scene`` text files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import SceneError, choices
from planner.base.notes import Note
from planner.base.words import number
from planner.base.yamlfile import shown, validate
from planner.models.files.moveit.messages import PoseMessage, SolidPrimitive
from planner.models.files.moveit.objects import require_once, solid
from planner.models.files.moveit.scenes import PlanningScene
from planner.models.shapes import Obstacle

_NUMBERS = {"box": 3, "sphere": 1, "cylinder": 2}


def scene_text(text: str, path: Path) -> PlanningScene:
    """MoveIt's ``.scene`` text format, with or without the object poses that newer versions write."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if not lines:
        raise SceneError(f"MoveIt scene {path} is empty; export it again.")
    file = _SceneText(lines[1:], path)
    found = tuple(file.obstacles())
    require_once(file.objects, f"MoveIt scene {path}")
    return PlanningScene(lines[0].strip("()")[:1000] or path.stem, "", found, notes=tuple(file.notes))


class _SceneText:
    def __init__(self, lines: Sequence[str], path: Path) -> None:
        self._lines, self._at, self._where = lines, 0, f"MoveIt scene {path}"
        self.objects, self.notes = list[str](), list[Note]()

    def obstacles(self) -> Iterator[Obstacle]:
        """Every shape of every object, up to the closing dot."""
        while (line := self._next()) != ".":
            if not line.startswith("*"):
                raise SceneError(
                    f"{self._where}: expected '* name' of an object, found {shown(line)}; export it again."
                )
            yield from self._object(line[1:].strip())
        if self._peek():
            raise SceneError(f"{self._where} goes on after its closing dot, with {shown(self._peek())}; take that out.")

    def _object(self, name: str) -> Iterator[Obstacle]:
        where = f"{self._where}: object {shown(name)}"
        whole = np.eye(4)
        if len(self._peek().split()) == 3:  # newer files place the object first
            whole = self._pose(where)
        count = self._count(where)
        if not count:
            raise SceneError(f"{where} has no shapes; take it out, or export it again.")
        self.objects.append(name)
        for k in range(count):
            kind = self._next()
            if kind not in _NUMBERS:
                raise SceneError(
                    f"{where}: a shape of type {shown(kind)} is not supported; use box, sphere or cylinder."
                )
            numbers = self._numbers(_NUMBERS[kind], where)
            size = numbers[::-1] if kind == "cylinder" else numbers  # the text has radius, length
            shape = solid(validate(SolidPrimitive, {"type": kind, "dimensions": size}, where, SceneError), where)
            placement = self._pose(where)
            self._numbers(4, where)  # colour
            yield Obstacle(name if count == 1 else f"{name}.{k}", shape, whole @ placement, name)
        if self._peek().isdecimal():
            subframes = [self._subframe(where) for _ in range(self._count(where))]
            if subframes:
                text = f"{where}: subframes {choices(subframes)} are passed over: nothing here refers to them."
                self.notes.append(Note(text, grave=False))

    def _subframe(self, where: str) -> str:
        name = self._next()
        self._pose(where)
        return name

    def _pose(self, where: str) -> Floats:
        position, rotation = self._numbers(3, where), self._numbers(4, where)
        return validate(PoseMessage, {"position": position, "orientation": rotation}, where, SceneError).matrix()

    def _count(self, where: str) -> int:
        value = self._numbers(1, where)[0]
        if not 0 <= value <= len(self._lines) or value % 1:
            raise SceneError(f"{where}: {value:g} is no count of what follows; export it again.")
        return int(value)

    def _peek(self) -> str:
        return self._lines[self._at] if self._at < len(self._lines) else ""

    def _next(self) -> str:
        if self._at >= len(self._lines):
            raise SceneError(f"{self._where} ends before its closing dot; export it again.")
        self._at += 1
        return self._lines[self._at - 1]

    def _numbers(self, count: int, where: str) -> list[float]:
        line = self._next()
        try:
            values = [number(part) for part in line.split()]
        except ValueError:
            values = []
        if len(values) != count or not np.isfinite(values).all():
            raise SceneError(f"{where}: expected {count} numbers, found {shown(line)}; export it again.")
        return values
