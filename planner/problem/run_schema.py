"""A record is what is written, and its attributes' docstrings are its schema."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields, is_dataclass
from dataclasses import Field as Attribute
from typing import Annotated, Any, ClassVar

from pydantic import Field

Nodes = list[Annotated[int, Field(ge=0)]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """Base of what is written as it stands: further keys are allowed; a key is left out where it has its default."""

    __pydantic_config__: ClassVar = {"extra": "allow", "allow_inf_nan": False, "use_attribute_docstrings": True}

    def to_dict(self) -> dict[str, Any]:
        """The keys in their order, as plain data."""
        return {field.name: _plain(getattr(self, field.name)) for field in fields(self) if _is_said(field, self)}


def _is_said(field: Attribute[Any], record: Record) -> bool:
    return field.default is MISSING or getattr(record, field.name) is not field.default


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.to_dict()
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value
