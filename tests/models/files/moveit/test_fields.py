"""Marks of fields: what is refused or noted, wherever in a message it stands."""

from __future__ import annotations

from typing import Annotated

import pytest

from planner.base.errors import SceneError
from planner.base.notes import Note
from planner.base.yamlfile import Strict, models_in
from planner.models.files.moveit.fields import Label, Noted, Refused, notes_of, says_something
from planner.models.files.moveit.requests import MotionPlanRequestMessage
from planner.models.files.moveit.scenes import PlanningSceneMessage

_IDLE = Noted("idle")


class Inner(Strict):
    name: Annotated[str, Label] = ""
    size: Annotated[float, Refused("is a size")] = 0.0
    weight: Annotated[float, _IDLE] = 0.0


class Outer(Strict):
    items: tuple[Inner, ...] = ()
    one: Inner = Inner()
    other: Annotated[Inner, Noted("grave", grave=True)] = Inner()
    weight: Annotated[float, _IDLE] = 0.0


def test_fields_of_one_reason_are_one_note() -> None:
    found = Outer(items=(Inner(), Inner(weight=1)), one=Inner(weight=2), weight=3)
    assert notes_of(found, "file") == (Note("file: idle: items.1.weight, one.weight, weight.", grave=False),)
    assert notes_of(Outer(other=Inner(name="x")), "file") == ()
    assert notes_of(Outer(other=Inner(weight=1)), "file")[0] == Note("file: grave: other.")


def test_the_first_that_is_refused_is_named() -> None:
    with pytest.raises(SceneError, match=r"^file: 'items\.1\.size' is a size\.$"):
        notes_of(Outer(items=(Inner(), Inner(size=1)), one=Inner(size=2)), "file")


def test_what_says_something() -> None:
    assert not any(map(says_something, (0.0, "", [], [0.0, ""], False, None, Inner(name="a"), [Inner(name="a")])))
    assert all(map(says_something, (1.0, "a", [0, 1], True, Inner(size=1), [Inner(weight=1)])))


def test_every_message_refuses_what_it_does_not_know() -> None:
    kinds, open_ = set(), [PlanningSceneMessage, MotionPlanRequestMessage]
    while open_:
        kind = open_.pop()
        kinds.add(kind)
        open_ += [inner for field in kind.model_fields.values() for inner in models_in(field) if inner not in kinds]
    assert len(kinds) > 30
    assert all(kind.model_config.get("extra") == "forbid" for kind in kinds)
