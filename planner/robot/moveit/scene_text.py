"""MoveIt's ``.scene`` text files, read as the PlanningScene message that they stand for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from planner.base.errors import SceneError
from planner.base.words import number
from planner.base.yamlfile import shown
from planner.robot.moveit.scenes import PlanningScene, planning_scene


def scene_text(text: str, path: Path) -> PlanningScene:
    """MoveIt's ``.scene`` text format, with or without the object poses that newer versions write."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if not lines:
        raise SceneError(f"MoveIt scene {path} is empty; export it again.")
    objects = list(_Lines(lines[1:], f"MoveIt scene {path}").objects())
    return planning_scene({"name": lines[0].strip("()")[:1000], "world": {"collision_objects": objects}}, path)


class _Lines:
    """The lines of a file from the first object on, taken from the front."""

    def __init__(self, lines: list[str], where: str) -> None:
        self._lines, self._where = lines[::-1], where

    def objects(self) -> Iterator[dict[str, Any]]:
        """Every object as a message, up to the closing dot."""
        while (line := self._take()) != ".":
            if not line.startswith("*"):
                raise self._unexpected("'* name' of an object", line)
            yield self._object(line[1:].strip())
        if self._lines:
            raise self._unexpected("nothing after the closing dot", self._take())

    def _object(self, name: str) -> dict[str, Any]:
        item: dict[str, Any] = {"id": name, "primitives": [], "primitive_poses": []}
        if len(self._next.split()) == 3:  # newer files place the object first
            item["pose"] = self._pose()
        for _ in range(self._count()):
            kind = self._take()
            size = self._numbers()[:: -1 if kind == "cylinder" else 1]  # a message has the height before the radius
            item["primitives"].append({"type": kind, "dimensions": size})
            item["primitive_poses"].append(self._pose())
            self._take()  # colour
        if self._next.isdecimal():
            item["subframe_names"] = [(self._take(), self._pose())[0] for _ in range(self._count())]
        return item

    def _pose(self) -> dict[str, Any]:
        return {"position": self._numbers(), "orientation": self._numbers()}

    def _count(self) -> int:
        line = self._take()
        if not (line.isascii() and line.isdecimal()) or number(line) > len(self._lines):
            raise self._unexpected("how many follow", line)
        return int(line)

    @property
    def _next(self) -> str:
        return self._lines[-1] if self._lines else ""

    def _take(self) -> str:
        if not self._lines:
            raise SceneError(f"{self._where} ends before its closing dot; export it again.")
        return self._lines.pop()

    def _numbers(self) -> list[float]:
        line = self._take()
        try:
            return [number(part) for part in line.split()]
        except ValueError:
            raise self._unexpected("numbers", line) from None

    def _unexpected(self, wanted: str, line: str) -> SceneError:
        return SceneError(f"{self._where}: expected {wanted}, found {shown(line)}; export it again.")
