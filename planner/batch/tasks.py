"""The plans that a batch asks for: from a YAML or CSV file, or from a folder of MoveIt's problems."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, get_type_hints

import pydantic

from planner.base.errors import FileError, PlannerError, choices
from planner.base.yamlfile import Strict, nearest, parse_yaml, read_text, repeated, validate
from planner.batch.options import plain_options
from planner.batch.problems import find_problems
from planner.problem.conditions import AND
from planner.problem.request import PlanRequest, SweepRequest
from planner.setup.sources import sources_hash

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]*(/[A-Za-z0-9_][A-Za-z0-9_.+-]*)*")  # a folder below the batch's own
CSV_NAME = "batch.csv"
_OUR_NAMES = re.compile(r"batch\.csv|row\.json|plan\.(json|html)|roadmap\.npz|trajectory\.json", re.IGNORECASE)
_OPTIONS = tuple(field.name for field in fields(PlanRequest))
_FILES = ("robot", "scene", "srdf", "motion_plan_request", "roadmap")  # options that may be the path of a file
_SWITCHES = tuple(name for name, kind in get_type_hints(PlanRequest).items() if kind is bool)
_SEVERAL = ("goal", "keep")  # options that may list texts: one text with ; between
_SPELLINGS = {"request": "motion_plan_request"}  # as the command line has it


@dataclass(frozen=True)
class Task:
    """One plan of a batch; ``asked`` is a hash of its options and of all that is read for them."""

    name: str
    request: PlanRequest

    @property
    def options(self) -> dict[str, Any]:
        """The options as JSON holds them."""
        return plain_options(self.request)

    @property
    def asked(self) -> str:
        """What the row is planned for, see :func:`request_hash`."""
        return request_hash(self.request)


def request_hash(request: SweepRequest) -> str:
    """A hash of the options and of all that is read for them: the files that they name, and those that these name."""
    asked = json.dumps([plain_options(request), sources_hash(request)], sort_keys=True)
    return hashlib.sha256(asked.encode()).hexdigest()[:16]


class BatchFile(Strict):
    """What a batch file holds: the options of each plan, and its name."""

    plans: list[dict[str, Any]] = pydantic.Field(min_length=1)


def read_tasks(source: Path, plain: PlanRequest) -> list[Task]:
    """The plans of ``source``, each as ``plain`` but for what it says itself.

    A ``.yaml`` file holds ``plans``, a ``.csv`` file one plan a line under a line of option names; a folder holds
    MoveIt's problems, see :func:`planner.batch.problems.find_problems`. Raises :class:`FileError` that
    names the plan and the option.
    """
    if os.path.isdir(source):
        found = find_problems(source)
        return [
            Task(each.name, replace(plain, scene=str(each.scene), motion_plan_request=each.request)) for each in found
        ]
    text = read_text(source, "batch file")
    match source.suffix.lower():
        case ".yaml" | ".yml":
            where = f"batch file {source}"
            entries = validate(BatchFile, parse_yaml(text, where), where).plans
        case ".csv":
            entries = _csv_entries(text, source)
        case other:
            raise FileError(f"batch file {source} ends in '{other}': give a .yaml or .csv file, or a folder.")
    tasks = [_task(entry, k, plain, source) for k, entry in enumerate(entries, start=1)]
    twice = repeated(task.name for task in tasks)
    if twice:
        raise FileError(f"batch file {source} has two plans called '{twice[0]}': their names must differ.")
    return tasks


def _csv_entries(text: str, source: Path) -> list[dict[str, Any]]:
    """One plan a line; an empty cell says nothing."""
    table = csv.DictReader(text.removeprefix("\ufeff").splitlines())  # as Excel begins a file
    try:
        names, rows = table.fieldnames or (), list(table)
    except csv.Error as error:  # a cell of more than 131,072 characters
        raise FileError(f"batch file {source} is no CSV: {error}; mend the file.") from None
    twice = repeated(map(str.strip, names))
    if twice:
        raise FileError(f"batch file {source} has two columns called '{twice[0]:.100}': keep one of them.")
    if not rows:
        raise FileError(f"batch file {source} holds no plans: give a line of option names and a line for each plan.")
    if any(None in row or None in row.values() for row in rows):
        raise FileError(f"batch file {source} has lines of different length: quote cells that hold a comma.")
    return [{key.strip(): value.strip() for key, value in row.items() if value.strip()} for row in rows]


def _task(entry: Mapping[str, Any], number: int, plain: PlanRequest, source: Path) -> Task:
    given = {_SPELLINGS.get(key, key.replace("-", "_")): value for key, value in entry.items()}
    name = str(given.pop("name", f"{number:04d}"))
    where = f"batch file {source}, plan '{name:.100}'"
    ours = next((part for part in name.split("/") if _OUR_NAMES.fullmatch(part)), None)
    if ours:
        raise FileError(f"{where}: '{ours}' is the name of a file that a batch writes; choose another one.")
    if not NAME.fullmatch(name) or ".." in name:
        raise FileError(f"{where}: it cannot be the name of a folder; use letters, digits, '_', '-', '.' and '/'.")
    unknown = [key for key in given if key not in _OPTIONS]
    if unknown:
        meant = nearest(unknown[0], _OPTIONS)
        raise FileError(f"{where}: option '{unknown[0]:.100}' not found{meant}; options are name, {choices(_OPTIONS)}.")
    switched = [key for key, value in given.items() if isinstance(value, bool) and key not in _SWITCHES]
    if switched:
        raise FileError(
            f"{where}: option '{switched[0]}' is {str(given[switched[0]]).lower()}, which it cannot be; "
            "put a text in quotes (yes, no, on and off are true and false in YAML)."
        )
    for key in _FILES:
        if isinstance(given.get(key), str) and os.path.isfile(source.parent / given[key]):
            given[key] = str(source.parent / given[key])
    for key in _SEVERAL:
        if isinstance(given.get(key), list) and all(isinstance(part, str) for part in given[key]):
            given[key] = AND.join(given[key])
    values = {key: getattr(plain, key) for key in _OPTIONS} | given
    try:
        return Task(name, pydantic.TypeAdapter(PlanRequest).validate_python(values))
    except pydantic.ValidationError as error:
        first = error.errors()[0]
        raise FileError(f"{where}: option '{first['loc'][0]}': {first['msg']}; mend the file.") from None
    except PlannerError as error:
        raise FileError(f"{where}: {error}") from None
