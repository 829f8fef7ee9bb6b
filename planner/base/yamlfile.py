"""YAML files that people write: the safe loader, and checks by a pydantic model."""

import difflib
import re
import reprlib
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_type_hints

import pydantic
import pydantic_core
import yaml

from planner.base.errors import FileError, PlannerError, choices

Model = TypeVar("Model")

FARTHEST = 1e4  # m (or rad): collision libraries crash, hang or lose digits far beyond
SMALLEST = 1e-6  # m: the tolerance of the collision libraries
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")  # of a model, of a dataclass
_UNPARSED = (RecursionError, ValueError, TypeError, ArithmeticError, LookupError, AttributeError)  # of dates, tags
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 120
_SHORT.maxlevel = 2


def _count(value: Any) -> Any:
    if isinstance(value, bool | str | bytes):
        raise pydantic_core.PydanticCustomError("int_type", "Input should be a valid integer")
    return value


# a number of a file or message: no boolean and no text, which pydantic would accept
Number = Annotated[float, pydantic.Strict()]
Whole = Annotated[int, pydantic.BeforeValidator(_count)]  # accepts 3.0, as JSON of other languages has it
Coordinate = Annotated[Number, pydantic.Field(ge=-FARTHEST, le=FARTHEST)]
Size = Annotated[Number, pydantic.Field(ge=SMALLEST, le=FARTHEST)]
Name = Annotated[str, pydantic.Field(max_length=1000)]


class Strict(pydantic.BaseModel):
    """Base of every file model: unknown keys, NaN and infinity are errors."""

    # deferred: most models are not used by a command
    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


def read_text(path: Path, what: str) -> str:
    """Return the text of ``path``; :class:`FileError` names the expected content, ``what``."""
    try:
        return read_bytes(path, what).decode("utf-8")
    except UnicodeDecodeError:
        raise FileError(f"{what} {path} must be UTF-8 text: give a text file.") from None


def read_bytes(path: Path, what: str) -> bytes:
    """Return the bytes of ``path``; :class:`FileError` names the expected content, ``what``."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise FileError(f"{what} {path} not found: check the path.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"{what} {path} cannot be read: {reason}; give a readable text file.") from None


def number(word: str) -> float:
    """Return the number in a ``word``; ValueError otherwise, also for 0_3, which float would accept."""
    if "_" in word or not word.isascii():
        raise ValueError(f"could not convert string to float: {word[:20]!r}")
    return float(word)


class _Loader(yaml.CSafeLoader):
    """PyYAML's safe loader that reads ``1e-3`` as a number and refuses a repeated key."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        names = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode) and key.value != "<<")
        for name, count in names.items():
            if count > 1:  # PyYAML would drop all values but the last
                raise yaml.MarkedYAMLError(problem=f"key {quote(name)} is repeated", problem_mark=node.start_mark)
        super().flatten_mapping(node)


class _Dumper(yaml.SafeDumper):
    """PyYAML's safe dumper that quotes the texts which the loader above would read as numbers."""


for _class in (_Loader, _Dumper):
    _class.add_implicit_resolver(
        "tag:yaml.org,2002:float",
        re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"),
        list("-+.0123456789"),
    )


def parse_yaml(text: str, where: str) -> Any:
    """Return plain data from YAML text; :class:`FileError` for tags that make objects and repeated keys."""
    try:
        return yaml.load(text, _Loader)
    except (yaml.YAMLError, *_UNPARSED) as error:
        mark = getattr(error, "problem_mark", None)
        line = f" at line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or str(error).partition(";")[0]
        raise FileError(f"{where} must be valid YAML{line}: {problem}; correct the file.") from None


def yaml_text(data: Any) -> str:
    """Return plain data as YAML text that :func:`parse_yaml` reads back."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, default_flow_style=None)


def validate(model: type[Model], data: Any, where: str, error_type: type[PlannerError] = FileError) -> Model:
    """Return ``data`` as a ``model``; the error is one sentence with the first wrong key."""
    if not isinstance(data, dict):
        keys = choices(_fields(model))
        raise error_type(f"{where} must be a mapping of keys to values, got {type(data).__name__}: keys are {keys}.")
    try:
        return _adapter(model).validate_python(data)
    except pydantic.ValidationError as error:
        errors = error.errors(include_url=False)  # a misspelt key is also a missing one: report the spelling
        first = next((each for each in errors if each["type"] in _UNKNOWN), errors[0])
        raise error_type(f"{where}: {_sentence(first, model)}") from None


@lru_cache
def _adapter(model: type[Model]) -> pydantic.TypeAdapter[Model]:
    return pydantic.TypeAdapter(model)


def _sentence(error: Any, model: type) -> str:
    key, given = quote(".".join(map(str, error["loc"]))), error["input"]
    if error["type"] in _UNKNOWN:
        name = str(error["loc"][-1])
        suggestion = suggest_name(name, _all_keys(model) - {name})
        return f"unknown key {key}{suggestion}; remove it or check its spelling."
    if error["type"] == "missing":
        return f"key {key} is missing; add it."
    if error["type"] == "union_tag_not_found":
        return f"{key} must have a type: add 'type'."
    if error["type"] == "union_tag_invalid":
        return f"{key} has type {quote(error['ctx']['tag'])}; types are {error['ctx']['expected_tags']}."
    about = f"{key} is wrong: " if error["loc"] else ""
    more = f" (got {quote(given)})" if not isinstance(given, dict | list) else ""
    return f"{about}{error['msg'].removeprefix('Value error, ').removesuffix('.')}{more}."


def find_duplicates(names: Iterable[str]) -> list[str]:
    """Return the names that occur more than once, sorted."""
    return sorted(name for name, count in Counter(names).items() if count > 1)


def suggest_name(name: str, known: Iterable[str], similarity: float = 0.7) -> str:
    """Return " (did you mean 'a'?)" with the most similar of the ``known`` names; else an empty text."""
    near = difflib.get_close_matches(name[:100], list(known), n=1, cutoff=similarity)
    return f" (did you mean {quote(near[0])}?)" if near else ""


def _fields(model: Any) -> dict[str, Any]:
    """Return the annotations of a model or a dataclass by the keys in a file."""
    if is_dataclass(model):
        return get_type_hints(model, include_extras=True)
    return {field.alias or name: field.annotation for name, field in model.model_fields.items()}


def _all_keys(model: Any) -> set[str]:
    """Return the keys of a model and of all models inside."""
    fields = _fields(model)
    return {*fields}.union(*(_all_keys(inner) for kind in fields.values() for inner in models_in(kind)))


def models_in(annotation: Any) -> Iterator[Any]:
    """Yield the file models and dataclasses inside an annotation or a field."""
    if isinstance(annotation, pydantic.fields.FieldInfo):
        annotation = annotation.annotation
    plain = isinstance(annotation, type) and not get_args(annotation)
    if plain and (is_dataclass(annotation) or issubclass(annotation, pydantic.BaseModel)):
        yield annotation
    for part in get_args(annotation):
        yield from models_in(part)


def quote(value: Any) -> str:
    """Return a value of a file as a message quotes it: one line of at most 200 characters."""
    try:
        return _SHORT.repr(value)[:200]
    except ValueError:  # Python refuses to print very long integers
        return "a number of thousands of digits"
