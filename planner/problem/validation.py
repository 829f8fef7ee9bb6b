"""Dataclasses whose fields pydantic validates; the first error becomes one sentence."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any, TypeVar, dataclass_transform

import pydantic

from planner.base.errors import OptionError

T = TypeVar("T")


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def options(cls: type[T]) -> type[T]:
    """Make a frozen dataclass of options; its first validation error is an :class:`OptionError`."""
    config = pydantic.ConfigDict(arbitrary_types_allowed=True, allow_inf_nan=False, extra="forbid")
    model: Any = pydantic.dataclasses.dataclass(frozen=True, config=config)(cls)
    validate = model.__init__

    @functools.wraps(validate)
    def init(self: object, *args: object, **values: object) -> None:
        try:
            validate(self, *args, **values)
        except pydantic.ValidationError as error:
            names = [field.name for field in dataclasses.fields(model)]
            raise OptionError(_sentence(error, names)) from None

    model.__init__ = init
    return model


def _sentence(error: pydantic.ValidationError, names: Sequence[str]) -> str:
    """Return the first error as a sentence: "nodes must be greater than or equal to 2, got 1."."""
    first = error.errors(include_url=False, include_context=False)[0]
    place = first["loc"][0] if first["loc"] else "options"  # an index for a positional argument
    name = (names[place] if isinstance(place, int) else place).replace("_", " ")
    if first["type"] == "unexpected_keyword_argument":
        return f"option '{name}' not found; options are {', '.join(names)}."
    rule = first["msg"].removeprefix("Value error, ").replace("Input should", "must")
    return f"{name} {rule}, got {' '.join(repr(first['input']).split()):.100}."
