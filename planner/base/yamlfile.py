"""Files that people write: YAML through the safe loader, checked against a pydantic model."""

from __future__ import annotations

import reprlib
from pathlib import Path
from typing import Annotated, Any, TypeVar

import pydantic
import yaml

from planner.base.errors import FileError, PlannerError, choices

Model = TypeVar("Model", bound=pydantic.BaseModel)

_LARGEST = 256 << 20  # bytes: text that people or robots exchange is far smaller
FARTHEST = (
    1e4  # m (or rad): ten kilometres; of numbers far beyond it collision libraries crash, hang or lose all digits
)
SMALLEST = 1e-6  # m: what is thinner than the libraries' own tolerance has no size

Coordinate = Annotated[float, pydantic.Field(ge=-FARTHEST, le=FARTHEST)]
Size = Annotated[float, pydantic.Field(ge=SMALLEST, le=FARTHEST)]
Name = Annotated[str, pydantic.Field(max_length=1000)]


class Strict(pydantic.BaseModel):
    """Base of every file model: an unknown key, a NaN or an infinity is an error, not a guess."""

    # built when first used: most are parts of other models, or of files that a command does not read
    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


def read_text(path: Path, what: str) -> str:
    """The text of ``path``, or a :class:`FileError` that names ``what`` was wanted."""
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)  # a device may have no end
        if len(content) > _LARGEST:
            raise FileError(f"{what} {path} is larger than {_LARGEST >> 20} MiB: give a smaller file.")
        return content.decode("utf-8")
    except FileNotFoundError:
        raise FileError(f"{what} {path} not found: check the path.") from None
    except UnicodeDecodeError:
        raise FileError(f"{what} {path} cannot be read: it is not UTF-8 text; give a readable text file.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"{what} {path} cannot be read: {reason}; give a readable text file.") from None


_DEEPEST = 200  # levels: on deep nesting libyaml's loader overflows the stack, its parser of events does not
_LEVELS = {
    yaml.MappingStartEvent: 1,
    yaml.SequenceStartEvent: 1,
    yaml.MappingEndEvent: -1,
    yaml.SequenceEndEvent: -1,
}


def parse_yaml(text: str, where: str) -> Any:
    """Plain data out of YAML text; no tag can construct an object."""
    try:
        depth = 0
        for event in yaml.parse(text, yaml.CSafeLoader):
            depth += _LEVELS.get(type(event), 0)
            if depth > _DEEPEST:
                raise RecursionError
        return yaml.load(text, yaml.CSafeLoader)
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f" at line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or "the nesting is too deep"
        raise FileError(f"{where} is not valid YAML{line}: {problem}; mend the file.") from None
    except (ValueError, TypeError, ArithmeticError, LookupError, AttributeError) as error:
        # PyYAML's own constructors of dates, whole numbers (5000 digits) and tagged scalars (!!int "")
        problem = str(error).partition(";")[0]
        raise FileError(f"{where} holds a value that YAML cannot make sense of: {problem}; mend the file.") from None


def validate(model: type[Model], data: Any, where: str, error_type: type[PlannerError] = FileError) -> Model:
    """``data`` as a ``model``, or one sentence naming the first key that is wrong."""
    if not isinstance(data, dict):
        keys = [field.alias or name for name, field in model.model_fields.items()]
        raise error_type(f"{where} holds no mapping of keys to values: give its keys, out of {choices(keys)}.")
    try:
        return model.model_validate(data)
    except pydantic.ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise error_type(f"{where}: {_sentence(first)}") from None


def _sentence(error: Any) -> str:
    key = shown(".".join(map(str, error["loc"])))
    more = f" (got {shown(error['input'])})" if not isinstance(error["input"], dict | list) else ""
    if error["type"] == "extra_forbidden":
        return f"unknown key {key}; remove it or check its spelling."
    if error["type"] == "union_tag_not_found":
        return f"{key} says no type; add 'type'."
    if error["type"] == "missing":
        return f"key {key} is missing; add it."
    if error["type"] == "union_tag_invalid":
        context = error.get("ctx", {})
        return f"{key} has type {shown(context.get('tag'))}; types are {context.get('expected_tags')}."
    about = f"{key} is wrong: " if error["loc"] else ""
    return f"{about}{error['msg'].removeprefix('Value error, ')}{more}."


_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 120
_SHORT.maxlevel = 2


def shown(value: Any) -> str:
    """A value out of a file as a message quotes it: on one line of at most 200 characters, whatever it is."""
    try:
        return _SHORT.repr(value)[:200]
    except ValueError:  # a whole number of more digits than Python prints
        return "a number of thousands of digits"
