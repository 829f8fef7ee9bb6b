"""What the commands share: when the process began, flags, --jobs and its like, and the option --request."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import tyro

from planner.base.request import KeptRequest, RoadmapRequest, WorkersRequest

STARTED = time.perf_counter()

Flag = tyro.conf.FlagCreatePairsOff[bool]
Workers = Annotated[WorkersRequest, tyro.conf.arg(name="")]

# a request's request would say nothing in Python, and --motion-plan-request is long to type
for _kind in (RoadmapRequest, KeptRequest):
    _kind.__annotations__["motion_plan_request"] = Annotated[Path | None, tyro.conf.arg(name="request")]
