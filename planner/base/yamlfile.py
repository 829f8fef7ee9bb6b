"""Files that people write: YAML through the safe loader, checked against a pydantic model."""

from __future__ import annotations

import difflib
import math
import re
import reprlib
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import is_dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_type_hints

import pydantic
import pydantic_core
import yaml

from planner.base.errors import FileError, PlannerError, choices
from planner.base.words import number

Model = TypeVar("Model", bound=pydantic.BaseModel)

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
    """The text of ``path``, or a :class:`FileError` that names ``what`` was wanted."""
    try:
        return read_bytes(path, what).decode("utf-8")
    except UnicodeDecodeError:
        raise FileError(f"{what} {path} cannot be read: it is not UTF-8 text; give a readable text file.") from None


def read_bytes(path: Path, what: str) -> bytes:
    """The content of ``path``, or a :class:`FileError` that names ``what`` was wanted."""
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)  # a device may have no end
        if len(content) > _LARGEST:
            raise FileError(f"{what} {path} is larger than {_LARGEST >> 20} MiB: give a smaller file.")
        return content
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

_DEEPEST = 200  # levels: on deep nesting libyaml's loader overflows the stack, its parser of events does not
_LEVELS = {
    yaml.MappingStartEvent: 1,
    yaml.SequenceStartEvent: 1,
    yaml.MappingEndEvent: -1,
    yaml.SequenceEndEvent: -1,
}


def parse_yaml(text: str, where: str) -> Any:
    """Plain data out of YAML text; no tag can construct an object, and no key may stand twice in one mapping."""
    try:
        _require_plain(_require_small(yaml.parse(text, yaml.CSafeLoader)))
        return yaml.load(text, _Loader)
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f" at line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or "the nesting is too deep"
        raise FileError(f"{where} is not valid YAML{line}: {problem}; mend the file.") from None
    except (ValueError, TypeError, ArithmeticError, LookupError, AttributeError) as error:
        # PyYAML's own constructors of dates, whole numbers (5000 digits) and tagged scalars (!!int "")
        problem = str(error).partition(";")[0]
        raise FileError(f"{where} holds a value that YAML cannot make sense of: {problem}; mend the file.") from None


_MOST_REPEATED = 1_000_000  # values that aliases and merges (<<) may add: forty lines can make more than memory holds
_LONGEST_NUMBER = 5000  # characters: of a number to base 60 (1:30:00) the time to read it grows with their square


def _require_small(events: Iterable[Any]) -> Iterator[Any]:
    """The events as they are; raises where a value contains itself, or aliases unfold to more than makes sense."""
    known: dict[str | None, tuple[int, int] | None] = {}  # values and levels below each anchor; None while it is open
    open_: list[tuple[str | None, int]] = []  # anchor, and how many values there were before it
    depths: list[int] = [0]  # the deepest level within each that is open, aliases unfolded
    total = written = 0
    for event in events:
        step, anchor, problem = _LEVELS.get(type(event), 0), getattr(event, "anchor", None), None
        if isinstance(event, yaml.AliasEvent):
            size, height = known.get(anchor, (0, 0)) or (0, 0)
            total, depths[-1] = total + size, max(depths[-1], len(open_) + height)
            if anchor in known and known[anchor] is None:
                problem = f"{shown(anchor)} contains itself"
            elif total - written > _MOST_REPEATED:
                problem = f"its aliases repeat more than {_MOST_REPEATED} values"
        elif step < 0:
            (name, before), depth = open_.pop(), depths.pop()
            known[name], depths[-1] = (total - before, depth - len(open_)), max(depths[-1], depth)
        elif isinstance(event, yaml.NodeEvent):
            total, written, known[anchor] = total + 1, written + 1, None if step else (1, 0)
            if step:
                open_.append((anchor, total - 1))
                depths.append(len(open_))
            elif _is_long_number(event):
                problem = f"a number has more than {_LONGEST_NUMBER} characters"
        if problem:
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=event.start_mark)
        if depths[-1] > _DEEPEST:
            raise RecursionError
        yield event


def _is_long_number(event: Any) -> bool:
    """Whether a scalar that may be read as a number is longer than one is."""
    plain = event.implicit[0] or event.tag
    return len(event.value) > _LONGEST_NUMBER and plain and not event.value.strip("+-.:_0123456789")


def _require_plain(events: Iterable[Any]) -> None:
    """Raise where YAML says a key twice: the loader would take the last and drop the others."""
    open_: list[tuple[set[str] | None, bool]] = []  # keys of each mapping that is open, and whether one comes next
    for event in events:
        step = _LEVELS.get(type(event), 0)
        if step < 0:
            open_.pop()
        keys, is_key = open_[-1] if open_ else (None, False)
        if step >= 0 and keys is not None:
            open_[-1] = keys, not is_key
            name = event.value if is_key and isinstance(event, yaml.ScalarEvent) else "<<"  # merging may be repeated
            if name in keys:
                raise yaml.MarkedYAMLError(problem=f"key {shown(name)} stands twice", problem_mark=event.start_mark)
            keys |= {name} - {"<<"}
        if step > 0:
            open_.append((set() if isinstance(event, yaml.MappingStartEvent) else None, True))


_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")  # of a model, of a dataclass


def validate(model: type[Model], data: Any, where: str, error_type: type[PlannerError] = FileError) -> Model:
    """``data`` as a ``model``, or one sentence naming the first key that is wrong."""
    if not isinstance(data, dict):
        keys = [field.alias or name for name, field in model.model_fields.items()]
        raise error_type(f"{where} holds no mapping of keys to values: give its keys, out of {choices(keys)}.")
    try:
        return model.model_validate(data)
    except pydantic.ValidationError as error:
        errors = error.errors(include_url=False)  # a key that is misspelt is missing too: of the two say the former
        first = next((each for each in errors if each["type"] in _UNKNOWN), errors[0])
        raise error_type(f"{where}: {_sentence(first, model)}") from None


def _sentence(error: Any, model: type[pydantic.BaseModel]) -> str:
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


def _keys_at(model: type[pydantic.BaseModel], place: Iterable[Any]) -> list[str]:
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
