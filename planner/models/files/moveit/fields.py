"""What becomes of a field of a message that is not honoured: refused by name, noted as passed over, or of no meaning.

A field without a mark is honoured, or says where other fields belong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import pydantic

from planner.base.errors import SceneError, choices
from planner.base.notes import Note
from planner.base.yamlfile import models_in


def none() -> Any:
    """The default of a list in a message: an empty one."""
    return pydantic.Field(default_factory=list)


def says_something(value: Any) -> bool:
    """Whether a value differs from what ROS fills a message with; labels do not count."""
    if isinstance(value, pydantic.BaseModel):
        return any(says_something(getattr(value, name)) for name in _others(type(value)))
    return any(map(says_something, value)) if isinstance(value, list | tuple) else bool(value)


@dataclass(frozen=True)
class Refused:
    """The field would change what is asked: a value of which ``when`` holds is refused; ``why`` ends the sentence."""

    why: str
    when: Callable[[Any], bool] = says_something


@dataclass(frozen=True)
class Noted:
    """The field changes nothing that is planned: a value of which ``when`` holds is noted, with ``why``."""

    why: str
    when: Callable[[Any], bool] = says_something
    grave: bool = False


class Label:
    """The field names or dates something, or paints it: it means nothing by itself."""


def notes_of(message: pydantic.BaseModel, where: str) -> tuple[Note, ...]:
    """What is passed over in ``message``, a sentence a reason; :class:`SceneError` for the first that is refused."""
    reasons: dict[Noted, dict[str, None]] = {}
    for mark, place in _marked(message, ""):
        if isinstance(mark, Refused):
            raise SceneError(f"{where}: '{place}' {mark.why}.")
        reasons.setdefault(mark, {})[place] = None
    return tuple(Note(f"{where}: {mark.why}: {choices(places)}.", mark.grave) for mark, places in reasons.items())


def _marked(message: pydantic.BaseModel, place: str) -> Iterator[tuple[Refused | Noted, str]]:
    """The marks that hold of a message and the messages in it, each with the place of its field."""
    for name, field in type(message).model_fields.items():
        value, here = getattr(message, name), f"{place}{name}"
        yield from ((mark, here) for mark in field.metadata if isinstance(mark, Refused | Noted) and mark.when(value))
        if any(map(_has_marks, models_in(field))):
            many = isinstance(value, list | tuple)
            for k, item in enumerate(value if many else [value]):
                yield from _marked(item, f"{here}.{k}." if many else f"{here}.")


@cache
def _has_marks(kind: type[pydantic.BaseModel]) -> bool:
    """Whether a field of the message, or of one in it, has a mark: of the triangles of a mesh none has."""
    return any(
        any(isinstance(mark, Refused | Noted) for mark in field.metadata) or any(map(_has_marks, models_in(field)))
        for field in kind.model_fields.values()
    )


@cache
def _others(kind: type[pydantic.BaseModel]) -> tuple[str, ...]:
    """The names of the fields that are no labels."""
    return tuple(name for name, field in kind.model_fields.items() if Label not in field.metadata)
