"""Files that people write: YAML through the safe loader, checked against a pydantic model."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

import pydantic
import yaml

from planner.base.errors import FileError, PlannerError

Model = TypeVar("Model", bound=pydantic.BaseModel)


class Strict(pydantic.BaseModel):
    """Base of every file model: an unknown key, a NaN or an infinity is an error, not a guess."""

    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def read_text(path: Path, what: str) -> str:
    """The text of ``path``, or a :class:`FileError` that names ``what`` was wanted."""
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise FileError(f"{what} {path} not found: check the path.") from None
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise FileError(f"{what} {path} cannot be read: {reason}; give a readable text file.") from None


def parse_yaml(text: str, where: str) -> Any:
    """Plain data out of YAML text; no tag can construct an object."""
    try:
        return yaml.safe_load(text)  # libyaml's loader is faster and overflows the stack on deep nesting
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f" at line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or "the nesting is too deep"
        raise FileError(f"{where} is not valid YAML{line}: {problem}; mend the file.") from None


def validate(model: type[Model], data: Any, where: str, error_type: type[PlannerError] = FileError) -> Model:
    """``data`` as a ``model``, or one sentence naming the first key that is wrong."""
    if not isinstance(data, dict):
        raise error_type(f"{where} holds no mapping of keys to values; see the README for the format.")
    try:
        return model.model_validate(data)
    except pydantic.ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise error_type(f"{where}: {_sentence(first)}") from None


def _sentence(error: Any) -> str:
    key = ".".join(str(part) for part in error["loc"]) or "the file"
    more = f" (got {error['input']!r})" if not isinstance(error["input"], dict | list) else ""
    if error["type"] == "extra_forbidden":
        return f"unknown key '{key}'; remove it or check its spelling."
    if error["type"] == "union_tag_not_found":
        return f"'{key}' says no type; add 'type'."
    if error["type"] == "missing":
        return f"key '{key}' is missing; add it."
    if error["type"] == "union_tag_invalid":
        context = error.get("ctx", {})
        return f"'{key}' has type '{context.get('tag')}'; types are {context.get('expected_tags')}."
    return f"'{key}' is wrong: {error['msg'].removeprefix('Value error, ')}{more}."
