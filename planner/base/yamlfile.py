"""Files that people write: YAML through the safe loader, checked against a pydantic model."""

from __future__ import annotations

import difflib
import math
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
from planner.base.words import number

Model = TypeVar("Model")

_LARGEST = 256 << 20  # bytes: text that people or robots exchange is far smaller
FARTHEST = (
    1e4  # m (or rad): ten kilometres; of numbers far beyond it collision libraries crash, hang or lose all digits
)
SMALLEST = 1e-6  # m: what is thinner than the libraries' own tolerance has no size


def _count(value: Any) -> Any:
    if isinstance(value, bool | str | bytes):
        raise pydantic_core.PydanticCustomError("int_type", "Input should be a valid integer")
    return value


# What a number of a file or a message is: no boolean, and no text that happens to look like one (pydantic takes both).
Number = Annotated[float, pydantic.Strict()]
Whole = Annotated[int, pydantic.BeforeValidator(_count)]  # 3.0 is one too: so JSON of other languages says it
Coordinate = Annotated[Number, pydantic.Field(ge=-FARTHEST, le=FARTHEST)]
Size = Annotated[Number, pydantic.Field(ge=SMALLEST, le=FARTHEST)]
Name = Annotated[str, pydantic.Field(max_length=1000)]


class Strict(pydantic.BaseModel):
    """Base of every file model: an unknown key, a NaN or an infinity is an error, not a guess."""

    # built when first used: most are parts of other models, or of files that a command does not read
    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


def read_text(path: Path, what: str) -> str:
    """The text of ``path``; :class:`FileError` names ``what`` was expected there."""
    try:
        return read_bytes(path, what).decode("utf-8")
    except UnicodeDecodeError:
        raise FileError(f"{what} {path} cannot be read: it is not UTF-8 text; give a readable text file.") from None


def read_bytes(path: Path, what: str) -> bytes:
    """The content of ``path``; :class:`FileError` names ``what`` was expected there."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise FileError(f"{what} {path} not found: check the path.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"{what} {path} cannot be read: {reason}; give a readable text file.") from None


class _Loader(yaml.CSafeLoader):
    """PyYAML's safe loader, for which numbers are those of YAML 1.2.

    ``1e-3`` is one, not a text; 010 is ten, not eight; ``1:30`` and ``1_000`` are texts, not numbers.
    """


_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
_Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in _NUMBERS]
    for first, resolvers in _Loader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(_NUMBERS[0], re.compile(r"[-+]?\d+$|0o[0-7]+$|0x[0-9a-fA-F]+$"), list("-+0123456789"))
_Loader.add_implicit_resolver(
    _NUMBERS[1],
    re.compile(r"[-+]?(\d+\.\d*|\.\d+|\d+(?=[eE]))([eE][-+]?\d+)?$|[-+]?\.(inf|Inf|INF)$|\.(nan|NaN|NAN)$"),
    list("-+.0123456789"),
)


def _whole(loader: yaml.CSafeLoader, node: yaml.ScalarNode) -> int:
    """A whole number; its resolver knows the digits, a tag may stand at any text."""
    text = loader.construct_scalar(node)
    base = {"0o": 8, "0x": 16}.get(text[:2], 10)
    return int(text[2:] if base != 10 else text, base)


_Loader.add_constructor(_NUMBERS[0], _whole)


def _mapping(loader: yaml.CSafeLoader, node: yaml.MappingNode) -> dict[Any, Any]:
    """A mapping; an error for a key that is repeated, where PyYAML would drop all values but the last."""
    names = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode) and key.value != "<<")
    twice = next((name for name, count in names.items() if count > 1), None)
    if twice is not None:
        raise yaml.MarkedYAMLError(problem=f"key {shown(twice)} stands twice", problem_mark=node.start_mark)
    loader.flatten_mapping(node)
    return loader.construct_mapping(node, deep=True)


_Loader.add_constructor("tag:yaml.org,2002:map", _mapping)


def parse_yaml(text: str, where: str) -> Any:
    """Plain data from YAML text; no tag constructs an object, and no key is repeated in one mapping."""
    try:
        return yaml.load(text, _Loader)
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f" at line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or "the nesting is too deep"
        raise FileError(f"{where} is not valid YAML{line}: {problem}; mend the file.") from None
    except (ValueError, TypeError, ArithmeticError, LookupError, AttributeError) as error:
        # PyYAML's own constructors of dates, integers (5000 digits) and tagged scalars (!!int "")
        problem = str(error).partition(";")[0]
        raise FileError(f"{where} holds a value that YAML cannot make sense of: {problem}; mend the file.") from None


class _Dumper(yaml.SafeDumper):
    """PyYAML's safe dumper, which quotes the texts that the loader above would take for numbers."""


_Dumper.yaml_implicit_resolvers = _Loader.yaml_implicit_resolvers


def yaml_text(data: Any) -> str:
    """Plain data as YAML text, from which :func:`parse_yaml` makes the same data."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, default_flow_style=None)


_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")  # of a model, of a dataclass


def validate(model: type[Model], data: Any, where: str, error_type: type[PlannerError] = FileError) -> Model:
    """``data`` as a ``model``, or one sentence naming the first key that is wrong."""
    if not isinstance(data, dict):
        keys = [getattr(field, "alias", None) or name for name, field in _fields(model).items()]
        raise error_type(f"{where} holds no mapping of keys to values: give its keys, out of {choices(keys)}.")
    try:
        return _adapter(model).validate_python(data)
    except pydantic.ValidationError as error:
        errors = error.errors(include_url=False)  # a key that is misspelt is missing too: of the two say the former
        first = next((each for each in errors if each["type"] in _UNKNOWN), errors[0])
        raise error_type(f"{where}: {_sentence(first, model)}") from None


@lru_cache
def _adapter(model: type[Model]) -> pydantic.TypeAdapter[Model]:
    return pydantic.TypeAdapter(model)


def _sentence(error: Any, model: type) -> str:
    key = shown(".".join(map(str, error["loc"])))
    more = f" (got {shown(error['input'])})" if not isinstance(error["input"], dict | list) else ""
    if error["type"] in _UNKNOWN:
        *place, name = error["loc"]
        meant = nearest(str(name), (known for known in _keys_at(model, place) if known != name))
        return f"unknown key {key}{meant}; remove it or check its spelling."
    if error["type"] == "union_tag_not_found":
        return f"{key} says no type; add 'type'."
    if error["type"] == "missing":
        return f"key {key} is missing; add it."
    if error["type"] == "union_tag_invalid":
        context = error.get("ctx", {})
        return f"{key} has type {shown(context.get('tag'))}; types are {context.get('expected_tags')}."
    about = f"{key} is wrong: " if error["loc"] else ""
    if error["type"] in ("float_type", "int_type") and isinstance(error["input"], bool):
        return f"{about}{str(error['input']).lower()} is no number (yes, no, on and off are none either)."
    quoted = error["type"] in ("float_type", "int_type") and _reads_as_number(error["input"])
    remedy = "; write it without quotes" if quoted else ""
    return f"{about}{error['msg'].removeprefix('Value error, ').removesuffix('.')}{more}{remedy}."


def _reads_as_number(value: Any) -> bool:
    try:
        return isinstance(value, str) and math.isfinite(number(value))
    except ValueError:
        return False


def repeated(names: Iterable[str]) -> list[str]:
    """The names that are given more than once, sorted."""
    return sorted(name for name, count in Counter(names).items() if count > 1)


def object_of(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON or msgpack; ValueError for a key that stands twice, of which the last would count."""
    found = dict(pairs)
    if len(found) < len(pairs):
        often = Counter(key for key, _ in pairs).most_common(1)
        raise ValueError(f"key {shown(often[0][0])} stands twice")
    return found


def nearest(name: str, known: Iterable[str], alike: float = 0.7) -> str:
    """A question in brackets, behind a blank, which of the ``known`` names was meant; empty where none is ``alike``."""
    near = difflib.get_close_matches(name[:100], list(known), n=1, cutoff=alike)
    return f" (did you mean {shown(near[0])}?)" if near else ""


def _keys_at(model: type, place: Iterable[Any]) -> list[str]:
    """The keys of the models that may stand at ``place``, as pydantic says where something is."""
    here = [_fields(model)]
    for step in place:
        inner = [_fields(kind) for one in here if step in one for kind in models_in(one[step])]
        tagged = [one for one in here if "type" in one and step in get_args(one["type"].annotation)]
        here = inner or tagged or here  # a number, of a list's item, leads to no other model
    return [name for one in here for name in one]


def _fields(model: Any) -> dict[str, Any]:
    """The fields of a model, or of a dataclass that is read as one, and what they are annotated with."""
    return get_type_hints(model, include_extras=True) if is_dataclass(model) else model.model_fields


def models_in(annotation: Any) -> Iterator[Any]:
    """The file models that a field, or what it is annotated with, is made of; dataclasses are some too."""
    if isinstance(annotation, pydantic.fields.FieldInfo):
        annotation = annotation.annotation
    plain = isinstance(annotation, type) and not get_args(annotation)
    if plain and (is_dataclass(annotation) or issubclass(annotation, pydantic.BaseModel)):
        yield annotation
    for part in get_args(annotation):
        yield from models_in(part)


_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 120
_SHORT.maxlevel = 2


def shown(value: Any) -> str:
    """A value out of a file as a message quotes it: on one line of at most 200 characters, whatever it is."""
    try:
        return _SHORT.repr(value)[:200]
    except ValueError:  # a whole number of more digits than Python prints
        return "a number of thousands of digits"
