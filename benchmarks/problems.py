"""Planning problems in folders: a MoveIt scene and a motion plan request each, as ``planner batch`` reads them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from planner.base.errors import FileError
from planner.batch.run import Task, read_plans
from planner.problem.request import PlanRequest


@dataclass(frozen=True)
class Problem:
    """``request`` in ``scene``; ``kind`` is the name of the folder that holds the two."""

    name: str
    scene: str
    request: Path

    @property
    def kind(self) -> str:
        return self.name.rpartition("/")[0]

    def asked(self, plain: PlanRequest) -> PlanRequest:
        """``plain`` with this problem's scene and request."""
        return plain.with_options(scene=self.scene, motion_plan_request=self.request)

    def content(self, plain: PlanRequest) -> str:
        """Eight digits of a hash of the options and of all files that are read for them."""
        return str(Task(self.name, self.asked(plain)).asked["asked"])[:8]


def find_problems(folder: Path) -> list[Problem]:
    """The problems in ``folder``, sorted by name; see :func:`planner.batch.run.read_plans`."""
    if not folder.is_dir():
        raise FileError(f"{folder} holds no problems: give a folder with them.")
    tasks = read_plans(folder, PlanRequest())
    return [
        Problem(task.name, str(task.request.what.scene), Path(str(task.request.what.motion_plan_request)))
        for task in tasks
    ]


def read_request(options: Mapping[str, Any]) -> PlanRequest:
    """Return the request whose ``config()`` these options are."""
    return PlanRequest.from_options(
        **{"motion_plan_request" if name == "request" else name: value for name, value in options.items()}
    )
