"""Planning problems in folders: a MoveIt scene and a motion plan request each, as MotionBenchMaker lays them out."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from planner.base.errors import FileError
from planner.base.hashing import content_hash
from planner.base.yamlfile import repeated
from planner.batch.options import plain_options
from planner.problem.request import PlanRequest
from planner.setup.sources import sources_hash

_TOLD = ("robot", "scene", "motion_plan_request", "collision", "nodes", "seed")
_SCENES, _REQUESTS = (".yaml", ".yml", ".scene"), (".yaml", ".yml")


@dataclass(frozen=True)
class Problem:
    """``request`` in ``scene``; ``kind`` is the type of scene, the name of the folder that holds the two."""

    name: str
    kind: str
    scene: Path
    request: Path

    def asked(self, plain: PlanRequest) -> PlanRequest:
        """``plain`` with this problem's scene and request."""
        return replace(plain, scene=str(self.scene), motion_plan_request=self.request)

    def content(self, plain: PlanRequest) -> str:
        """Eight digits of a hash of both files and of all others that ``plain`` reads, the robot's and its meshes.

        Of options too that are not at their defaults, but for those that every row tells.
        """
        asked, default = self.asked(plain), PlanRequest()
        more = {k: v for k, v in plain_options(asked).items() if k not in _TOLD and v != getattr(default, k)}
        return content_hash([sources_hash(asked), json.dumps(more)])[:8] if more else sources_hash(asked)[:8]


def find_problems(folder: Path) -> list[Problem]:
    """The problems in ``folder`` and the folders below it, linked ones too, sorted by name.

    One is ``request<X>.yaml`` with ``scene<X>.yaml`` or ``scene<X>.scene`` beside it. A request whose scene is missing
    is a problem all the same, which the planner will refuse by the name of that file. Raises :class:`FileError` where
    there is none, and where two would have one name.
    """
    try:
        requests = sorted(p for p in _files(folder) if p.match("request*") and p.suffix.lower() in _REQUESTS)
    except OSError as error:
        raise FileError(
            f"{error.filename or folder} cannot be read: {error.strerror or error}; choose another folder."
        ) from None
    if not requests:
        raise FileError(
            f"{folder} holds no problems: give a folder with request0001.yaml beside scene0001.yaml and so on, "
            "or with such folders in it."
        )
    problems = [_problem(folder, request) for request in requests]
    for name in repeated(problem.name for problem in problems):
        first, second, *_ = (problem.request for problem in problems if problem.name == name)
        raise FileError(f"{first} and {second} would both be the plan '{name}': rename one, or move it elsewhere.")
    return problems


def _files(folder: Path, above: frozenset[Path] = frozenset()) -> Iterator[Path]:
    """All files in a folder and below it; no link leads back to one of the folders ``above``."""
    here = folder.resolve()
    if here in above or not folder.is_dir():
        return
    for path in folder.iterdir():
        if path.is_dir():
            yield from _files(path, above | {here})
        elif path.is_file():
            yield path


def _problem(folder: Path, request: Path) -> Problem:
    number = request.stem.removeprefix("request")
    scenes = [request.with_name(f"scene{number}{suffix}") for suffix in _SCENES]
    scene = next((path for path in scenes if path.is_file()), scenes[0])
    parent = request.parent.relative_to(folder)
    kind = parent.as_posix() if parent.parts else folder.resolve().name
    return Problem(f"{kind}/{number}", kind, scene, request)
