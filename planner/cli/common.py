"""What the commands share: when the process began, flags, --jobs and its like, and the option --request."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Optional

import tyro

from planner.problem.request import Message, WorkersRequest

STARTED = time.perf_counter()

Flag = tyro.conf.FlagCreatePairsOff[bool]
Debug = Annotated[Flag, tyro.conf.arg(help="Show tracebacks of errors.")]  # looked for before a command is read
Out = Annotated[Path, tyro.conf.arg(help="Folder to write into.")]
Workers = Annotated[WorkersRequest, tyro.conf.arg(name="")]

# in Python a request's request would say nothing, --motion-plan-request is long to type, and only this door knows tyro
Message.__annotations__["motion_plan_request"] = Annotated[Optional[Path], tyro.conf.arg(name="request")]  # noqa: UP045
