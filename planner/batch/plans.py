"""The plans of a batch, out of a YAML or CSV file, or out of a folder of MoveIt's scenes and motion plan requests."""

from __future__ import annotations

import csv
import glob
import hashlib
import io
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pydantic

from planner.base.errors import FileError, PlannerError
from planner.base.yamlfile import Strict, parse_yaml, read_text, repeated, validate
from planner.problem.request import PlanRequest
from planner.query.robots import sources_hash

_FILES = ("robot", "scene", "srdf", "motion_plan_request", "roadmap")  # options that may be the path of a file


@dataclass(frozen=True)
class Task:
    """One plan of a batch."""

    name: str
    request: PlanRequest

    @property
    def asked(self) -> str:
        """A hash of the options and of all files that are read for them."""
        asked = json.dumps([self.request.config(), sources_hash(self.request)], sort_keys=True)
        return hashlib.sha256(asked.encode()).hexdigest()[:16]


class BatchFile(Strict):
    """A batch file: the options of each plan, and its name."""

    plans: list[dict[str, Any]] = pydantic.Field(min_length=1)


def read_plans(source: Path, plain: PlanRequest) -> list[Task]:
    """The plans of ``source``; an option that a plan leaves out is that of ``plain``.

    A ``.yaml`` file holds a list of ``plans``; a ``.csv`` file holds a line of option names and a line for each plan.
    A folder, or folders in it, hold MoveIt's problems as MotionBenchMaker lays them out: ``request<X>.yaml`` with
    ``scene<X>.yaml`` (``.yml``, ``.scene``). A :class:`FileError` names the plan and the option.
    """
    where, beside = f"batch file {source}", source.parent
    if os.path.isdir(source):
        where, beside = f"folder {source}", source
        entries = _problems(source)
    elif source.suffix.lower() in (".yaml", ".yml"):
        entries = validate(BatchFile, parse_yaml(read_text(source, "batch file"), where), where).plans
    elif source.suffix.lower() == ".csv":
        entries = _csv_entries(read_text(source, "batch file"), where)
    else:
        raise FileError(f"{where} must be a .yaml or .csv file, or a folder.")
    tasks = [_task(entry, k, plain, where, beside) for k, entry in enumerate(entries, start=1)]
    if twice := repeated(task.name for task in tasks):
        raise FileError(f"{where} has two plans called '{twice[0]}': rename one.")
    return tasks


def _problems(folder: Path) -> list[dict[str, Any]]:
    """Paths are relative to the folder. The planner refuses a request without a scene, and names the scene."""
    entries = []
    for path in sorted(map(Path, glob.glob("**/request*.y*ml", root_dir=folder, recursive=True))):
        number = path.stem.removeprefix("request")
        scenes = [path.with_name(f"scene{number}{suffix}") for suffix in (".yaml", ".yml", ".scene")]
        scene = next((scene for scene in scenes if os.path.isfile(folder / scene)), scenes[0])
        kind = path.parent.as_posix() if path.parent.parts else folder.resolve().name
        entries.append({"name": f"{kind}/{number}", "scene": str(scene), "request": str(path)})
    if not entries:
        raise FileError(
            f"{folder} holds no problems: give a folder with request0001.yaml and scene0001.yaml and so on."
        )
    return entries


def _csv_entries(text: str, where: str) -> list[dict[str, Any]]:
    """An empty cell leaves its option out."""
    try:
        names, *rows = csv.reader(io.StringIO(text.removeprefix("\ufeff"), newline=""))  # Excel writes this mark
    except (csv.Error, ValueError):  # ValueError: the file is empty
        names, rows = [], []
    names, rows = [name.strip() for name in names], [row for row in rows if row]
    if not rows or repeated(names) or any(len(row) != len(names) for row in rows):
        raise FileError(
            f"{where} must be a line of different option names and a line of as many cells for each plan: "
            "quote cells that hold a comma."
        )
    return [{name: cell.strip() for name, cell in zip(names, row, strict=True) if cell.strip()} for row in rows]


def _task(entry: Mapping[str, Any], number: int, plain: PlanRequest, where: str, beside: Path) -> Task:
    given = {key.replace("-", "_"): value for key, value in entry.items()}
    if "request" in given:  # as the command line spells it
        given["motion_plan_request"] = given.pop("request")
    name = str(given.pop("name", f"{number:04d}"))
    where = f"{where}, plan '{name:.100}'"
    if not Path(name).parts or Path(name).is_absolute() or ".." in Path(name).parts:
        raise FileError(f"{where}: its name must be that of a folder below --out.")
    for key, value in given.items():
        if key in _FILES and isinstance(value, str) and os.path.isfile(beside / value):
            given[key] = str(beside / value)
    try:
        return Task(name, plain.with_options(**given))
    except PlannerError as error:
        raise FileError(f"{where}: {error}") from None
