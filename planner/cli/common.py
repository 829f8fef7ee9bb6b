"""What the commands share: when the process began, flags, --jobs and its like, and the option --request."""

from __future__ import annotations

import time
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Optional, Union, get_args, get_type_hints

import tyro

from planner.problem.request import (
    KeptRequest,
    LimitsRequest,
    PlanRequest,
    RoadmapRequest,
    SweepRequest,
    TimingRequest,
    WorkersRequest,
    WorldRequest,
)

STARTED = time.perf_counter()

Flag = tyro.conf.FlagCreatePairsOff[bool]
Workers = Annotated[WorkersRequest, tyro.conf.arg(name="")]
_MessageFile = Annotated[Optional[Path], tyro.conf.arg(name="request")]  # noqa: UP045 (see below)


def _spelt_out(kind: type) -> dict[str, Any]:
    """The annotations of a request, ``X | None`` as ``Optional[X]``: tyro knows it without 30 ms of typeguard."""
    hints = get_type_hints(kind, include_extras=True)
    own = {name: hints[name] for name in kind.__annotations__}
    return {name: Union[get_args(hint)] if isinstance(hint, UnionType) else hint for name, hint in own.items()}  # noqa: UP007


for _kind in (WorldRequest, RoadmapRequest, SweepRequest, PlanRequest, KeptRequest, LimitsRequest, TimingRequest):
    _kind.__annotations__.update(_spelt_out(_kind))
# a request's request would say nothing in Python, and --motion-plan-request is long to type
for _kind in (RoadmapRequest, KeptRequest):
    _kind.__annotations__["motion_plan_request"] = _MessageFile
