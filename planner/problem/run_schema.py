"""What every run writes, whatever it was. A record is what is written, and its attributes' docstrings its schema."""

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


@dataclass(frozen=True, kw_only=True, eq=False)
class ScaleRecord(Record):
    """What manipulability and lengths were divided by to become costs."""

    w_low: float
    w_high: float
    joint_length: float
    """rad"""
    tool_length: float
    """m"""
    zeta: float
    """the least cost of an arc"""


@dataclass(frozen=True, kw_only=True, eq=False)
class RoadmapRecord(Record):
    """Size, proofs and hash of the roadmap."""

    nodes: int
    nodes_checked: dict[str, int]
    """how many nodes each collision library has found free"""
    edges: int
    """counted undirected"""
    components: int
    edges_certified: int
    """edges that are proven free"""
    edges_removed: int
    """edges that failed the second check"""
    sha256: str
    scale: ScaleRecord


@dataclass(frozen=True, kw_only=True, eq=False)
class RunRecord(Record):
    """How a run ended, what it was asked for, and with which software."""

    format_version: int
    outcome: Annotated[str, Field(description="solved, no_path, too_singular, partly_followed or interrupted")]
    message: Annotated[str, Field(description="the outcome as a sentence, with its reason and the remedy")]
    robot: str
    scene: str
    seed: int
    config: Annotated[dict[str, Any], Field(description="every option")]
    versions: dict[str, str]
    joints: Annotated[list[str], Field(description="the planned ones, in the order of the columns of a path")]
    tool: str
    notes: Annotated[list[str], Field(description="what was noticed about the model and the start")]
