"""Files that people write: YAML through the safe loader, checked against a pydantic model."""

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

FARTHEST = 1e4  # m (or rad): collision libraries crash, hang or lose all digits of numbers far beyond
SMALLEST = 1e-6  # m: what is thinner than the libraries' own tolerance has no size
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")  # of a model, of a dataclass
_UNPARSED = (RecursionError, ValueError, TypeError, ArithmeticError, LookupError, AttributeError)  # of dates, tags
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 120
_SHORT.maxlevel = 2


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


def number(word: str) -> float:
    """The number that a ``word`` says; ValueError for one that is none, also for 0_3, which only Python takes."""
    if "_" in word or not word.isascii():
        raise ValueError(f"could not convert string to float: {word[:20]!r}")
    return float(word)


class _Loader(yaml.CSafeLoader):
    """PyYAML's safe loader, for which ``1e-3`` is a number, and a key that stands twice in a mapping an error."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        names = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode) and key.value != "<<")
        for name, count in names.items():
            if count > 1:  # PyYAML would drop all values but the last
                raise yaml.MarkedYAMLError(problem=f"key {quote(name)} stands twice", problem_mark=node.start_mark)
        super().flatten_mapping(node)


class _Dumper(yaml.SafeDumper):
    """PyYAML's safe dumper, which quotes the texts that the loader above would take for numbers."""


for _class in (_Loader, _Dumper):
    _class.add_implicit_resolver(
        "tag:yaml.org,2002:float",
        re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"),
        list("-+.0123456789"),
    )


def parse_yaml(text: str, where: str) -> Any:
    """Plain data from YAML text; no tag constructs an object, and no key is repeated in one mapping."""
    try:
        return yaml.load(text, _Loader)
    except (yaml.YAMLError, *_UNPARSED) as error:
        mark = getattr(error, "problem_mark", None)
        line = f" at line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or str(error).partition(";")[0]
        raise FileError(f"{where} is not valid YAML{line}: {problem}; mend the file.") from None


def yaml_text(data: Any) -> str:
    """Plain data as YAML text, from which :func:`parse_yaml` makes the same data."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, default_flow_style=None)


def validate(model: type[Model], data: Any, where: str, error_type: type[PlannerError] = FileError) -> Model:
    """``data`` as a ``model``, or one sentence naming the first key that is wrong."""
    if not isinstance(data, dict):
        keys = choices(_fields(model))
        raise error_type(f"{where} holds no mapping of keys to values: give its keys, out of {keys}.")
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
    key, given = quote(".".join(map(str, error["loc"]))), error["input"]
    if error["type"] in _UNKNOWN:
        name = str(error["loc"][-1])
        meant = suggest_name(name, _all_keys(model) - {name})
        return f"unknown key {key}{meant}; remove it or check its spelling."
    if error["type"] == "missing":
        return f"key {key} is missing; add it."
    if error["type"] == "union_tag_not_found":
        return f"{key} says no type; add 'type'."
    if error["type"] == "union_tag_invalid":
        return f"{key} has type {quote(error['ctx']['tag'])}; types are {error['ctx']['expected_tags']}."
    about = f"{key} is wrong: " if error["loc"] else ""
    more = f" (got {quote(given)})" if not isinstance(given, dict | list) else ""
    return f"{about}{error['msg'].removeprefix('Value error, ').removesuffix('.')}{more}."


def find_duplicates(names: Iterable[str]) -> list[str]:
    """The names that are given more than once, sorted."""
    return sorted(name for name, count in Counter(names).items() if count > 1)


def suggest_name(name: str, known: Iterable[str], alike: float = 0.7) -> str:
    """A question in brackets, behind a blank, which of the ``known`` names was meant; empty where none is ``alike``."""
    near = difflib.get_close_matches(name[:100], list(known), n=1, cutoff=alike)
    return f" (did you mean {quote(near[0])}?)" if near else ""


def _fields(model: Any) -> dict[str, Any]:
    """The fields of a model, or of a dataclass that is read as one, by their keys in a file."""
    if is_dataclass(model):
        return get_type_hints(model, include_extras=True)
    return {field.alias or name: field.annotation for name, field in model.model_fields.items()}


def _all_keys(model: Any) -> set[str]:
    """The keys of a model and of all models inside."""
    fields = _fields(model)
    return {*fields}.union(*(_all_keys(inner) for kind in fields.values() for inner in models_in(kind)))


def models_in(annotation: Any) -> Iterator[Any]:
    """The file models that a field, or what it is annotated with, is made of; dataclasses are some too."""
    if isinstance(annotation, pydantic.fields.FieldInfo):
        annotation = annotation.annotation
    plain = isinstance(annotation, type) and not get_args(annotation)
    if plain and (is_dataclass(annotation) or issubclass(annotation, pydantic.BaseModel)):
        yield annotation
    for part in get_args(annotation):
        yield from models_in(part)


def quote(value: Any) -> str:
    """A value out of a file as a message quotes it: on one line of at most 200 characters, whatever it is."""
    try:
        return _SHORT.repr(value)[:200]
    except ValueError:  # a whole number of more digits than Python prints
        return "a number of thousands of digits"
