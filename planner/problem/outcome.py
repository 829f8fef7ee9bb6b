"""How a run ended, and what is written of it: the base class of records, their version, tables of a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass
from enum import Enum
from html import escape
from typing import Annotated, Any, ClassVar

from pydantic import Field

from planner.base.errors import FileError

FORMAT_VERSION = 1  # of plan.json and sweep.json: one more where a key goes or changes its meaning
Nodes = list[Annotated[int, Field(ge=0)]]
Rows = list[tuple[str, str]]
"""The rows of a table: names and texts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """Base of all records: a file holds the fields, and the docstrings of the fields are the schema of the file.

    A field is left out of the file where it has its default. Further keys in a file are read over.
    """

    __pydantic_config__: ClassVar = {"extra": "allow", "allow_inf_nan": False, "use_attribute_docstrings": True}

    def to_dict(self) -> dict[str, Any]:
        """The fields in their order, as plain data."""
        written = {field.name: (getattr(self, field.name), field.default) for field in fields(self)}
        return {
            name: _plain(value)
            for name, (value, default) in written.items()
            if default is MISSING or value is not default
        }


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.to_dict()
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


class Outcome(Enum):
    """An ending that is part of normal life; wrong input raises a :class:`~planner.base.errors.PlannerError` instead.

    ``name.lower()`` is what ``plan.json`` holds, the value is the sentence with the remedy.
    """

    SOLVED = "A collision-free path was found."
    NO_PATH = (
        "Start and goal were not connected within the budget: raise --nodes, try another --seed, "
        "or look at the roadmap in the page to see where it stops."
    )
    TOO_SINGULAR = (
        "No path above the manipulability floor was found within the budget: lower --min-manipulability, "
        "raise --nodes, or try another --seed."
    )
    PARTLY_FOLLOWED = (
        "The tool path could be followed in part only: move it, widen its tube, or let the tool turn about its axis."
    )
    INTERRUPTED = "Interrupted: this is what was done so far."

    @property
    def key(self) -> str:
        return self.name.lower()

    @property
    def exit_code(self) -> int:
        """The exit code of a command that ends so."""
        return {Outcome.SOLVED: 0, Outcome.INTERRUPTED: 130}.get(self, 4)


def require_readable_version(record: dict[str, Any], where: str) -> None:
    """Refuse a record of a later format than this planner knows; one that names none is of version 1."""
    version = record.get("format_version", 1)
    if not (isinstance(version, int) and 1 <= version <= FORMAT_VERSION):
        raise FileError(
            f"{where} has format version {version!r:.40}, this planner reads up to {FORMAT_VERSION}: "
            "update the planner, or make the file again with this one."
        )


def html_table(caption: str, rows: Sequence[Sequence[str]], head: Sequence[str] = ()) -> str:
    """A table of a notebook; names out of files cannot become markup."""
    top = f"<thead>{_html_row('th', head)}</thead>" if head else ""
    body = "".join(_html_row("td", row) for row in rows)
    return f"<p>{escape(caption)}</p><table>{top}<tbody>{body}</tbody></table>"


def _html_row(tag: str, cells: Sequence[str]) -> str:
    return "<tr>" + "".join(f'<{tag} style="text-align:left">{escape(cell)}</{tag}>' for cell in cells) + "</tr>"
