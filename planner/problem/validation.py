"""Dataclasses whose fields pydantic checks: the first wrong one becomes one sentence."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any, TypeVar, dataclass_transform

import pydantic

from planner.base.errors import OptionError

T = TypeVar("T")


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def options(cls: type[T]) -> type[T]:
    """A frozen dataclass of options: pydantic checks their ranges, and the first error becomes one OptionError."""
    config = pydantic.ConfigDict(arbitrary_types_allowed=True, allow_inf_nan=False, extra="forbid")
    made: Any = pydantic.dataclasses.dataclass(frozen=True, config=config)(cls)
    validated = made.__init__

    @functools.wraps(validated)
    def init(self: object, *args: object, **values: object) -> None:
        try:
            validated(self, *args, **values)
        except pydantic.ValidationError as error:
            names = [field.name for field in dataclasses.fields(made)]
            raise OptionError(_sentence(error, names)) from None

    made.__init__ = init
    return made


def _sentence(error: pydantic.ValidationError, names: Sequence[str]) -> str:
    """The first error as one sentence: "nodes must be greater than or equal to 2, got 1."."""
    first = error.errors(include_url=False, include_context=False)[0]
    place = first["loc"][0] if first["loc"] else "options"  # a number where it was given by position
    name = (names[place] if isinstance(place, int) else place).replace("_", " ")
    if first["type"] == "unexpected_keyword_argument":
        return f"there is no option '{name}': options are {', '.join(names)}."
    wish = first["msg"].removeprefix("Value error, ").replace("Input should", "must")
    return f"{name} {wish}, got {' '.join(repr(first['input']).split()):.100}."
