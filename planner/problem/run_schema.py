"""What every run writes, whatever it was."""

from __future__ import annotations

from typing import Any

import pydantic
from pydantic import BaseModel, Field

Nodes = list[pydantic.NonNegativeInt]


class Written(BaseModel):
    """Base of the models of written files: further keys are allowed."""

    model_config = pydantic.ConfigDict(extra="allow", allow_inf_nan=False)


class ScaleRecord(Written):
    """What manipulability and lengths were divided by to become costs."""

    w_low: float
    w_high: float
    joint_length: float = Field(description="rad")
    tool_length: float = Field(description="m")
    zeta: float = Field(description="the least cost of an arc")


class RoadmapRecord(Written):
    """Size, proofs and hash of the roadmap."""

    nodes: int
    nodes_checked: dict[str, int] = Field(description="how many nodes each collision library has found free")
    edges: int = Field(description="counted undirected")
    components: int
    edges_certified: int = Field(description="edges that are proven free")
    edges_removed: int = Field(description="edges that failed the second check")
    sha256: str
    scale: ScaleRecord


class RunRecord(Written):
    """How a run ended, what it was asked for, and with which software."""

    format_version: int
    outcome: str = Field(description="solved, no_path, too_singular or interrupted")
    message: str = Field(description="the outcome as a sentence, with its reason and the remedy")
    robot: str
    scene: str
    seed: int
    config: dict[str, Any] = Field(description="every option")
    versions: dict[str, str]
    joints: list[str] = Field(description="names of the planned joints, in the order of the columns of a path")
    tool: str
    notes: list[str] = Field(description="what was noticed about the model")
    roadmap: RoadmapRecord
    timings_s: dict[str, float]
    files: dict[str, str] = Field(default_factory=dict, description="SHA-256 of the files written beside this one")
