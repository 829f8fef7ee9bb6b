"""What else has changed in a scene file that is read again: a session takes obstacles that stand, and nothing more."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from planner.base.errors import choices
from planner.models.scene import Scene


def left_as_opened(opened: Scene, now: Scene) -> list[tuple[str, str]]:
    """Rows of a report on what a file says ``now`` besides its obstacles that the scene of a session does not."""
    before, after = _besides(opened), _besides(now)
    changed = [what for what in after if not _same(before[what], after[what])]
    rows = [("changed too, and left", f"{choices(changed)}: open the live view again for that")] if changed else []
    return rows + [("noted", note.text) for note in now.notes if note not in opened.notes]


def _besides(scene: Scene) -> dict[str, Any]:
    """All that counts of a scene but its obstacles that stand, in words."""
    message = scene.message
    return {
        "states": scene.states,
        "how robots are set up": scene.robots,
        "obstacles that move": scene.moving,
        "what is carried": scene.carried,
        "what may touch": (scene.allowed, message and message.checked),
        "what motions keep": scene.keep,
        "robot_state and frames": message and (message.robot, message.state, message.frames),
    }


def _same(one: Any, other: Any) -> bool:
    """Whether two values are equal, arrays and what holds some included."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(_same(one[name], other[name]) for name in one)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    if is_dataclass(one):
        return all(_same(getattr(one, item.name), getattr(other, item.name)) for item in fields(one))
    return bool(one == other)
