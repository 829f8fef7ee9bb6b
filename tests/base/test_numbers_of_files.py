"""Every number of every file and message that people write: no boolean, and no text that looks like one, is taken."""

import importlib
import pkgutil
from collections.abc import Iterator
from typing import Any

import numpy as np
import pydantic
import pytest

import planner
from planner.base.arrays import numbers
from planner.base.errors import ArrayError, FileError
from planner.base.yamlfile import Number, Strict, Whole, parse_yaml, validate
from planner.roadmap.storage import _Header


class Said(Strict):
    x: Number | None = None
    n: Whole | None = None


def models() -> list[type[pydantic.BaseModel]]:
    """Every pydantic model of the package, whichever module it stands in."""
    for module in pkgutil.walk_packages(planner.__path__, "planner."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    found, open_ = set(), [pydantic.BaseModel]
    while open_:
        kinds = set(open_.pop().__subclasses__()) - found
        found |= kinds
        open_ += kinds
    ours = (kind for kind in found - {_Header} if kind.__module__.startswith("planner."))  # a checksum covers that one
    return sorted(ours, key=lambda kind: (kind.__module__, kind.__qualname__))


def loose(schema: Any, place: str, judged: bool = False) -> Iterator[str]:
    """The numbers in a core schema that pydantic would make of a boolean or a text."""
    if isinstance(schema, dict):
        kind = schema.get("type")
        if kind in ("float", "int") and not (judged or schema.get("strict")):
            yield f"{place}: {kind}"
        for key, part in schema.items():
            if key not in ("metadata", "serialization"):
                yield from loose(part, f"{place}.{key}", judged or kind == "function-before")
    elif isinstance(schema, list | tuple):
        for part in schema:
            yield from loose(part, place, judged)


@pytest.mark.parametrize("model", models(), ids=lambda kind: f"{kind.__module__}.{kind.__qualname__}")
def test_no_number_of_a_model_is_made_of_a_boolean_or_a_text(model: type[pydantic.BaseModel]):
    model.model_rebuild()
    assert not list(loose(model.__pydantic_core_schema__, model.__name__))


def test_the_search_for_loose_numbers_finds_them():
    class Loose(pydantic.BaseModel):
        x: list[float | None]
        n: int

    assert len(list(loose(Loose.__pydantic_core_schema__, "Loose"))) == 2
    assert not list(loose(Said.__pydantic_core_schema__, "Said"))


@pytest.mark.parametrize(("text", "x"), [("1e-3", 1e-3), ("-2E4", -2e4), ("+.5e1", 5.0), ("3.e2", 300.0), ("7", 7.0)])
def test_a_number_is_one_in_every_way_that_yaml_writes_it(text: str, x: float):
    assert validate(Said, parse_yaml(f"x: {text}", "file"), "file").x == x


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x: yes", "'x' is wrong: true is no number (yes, no, on and off are none either)."),
        ("n: off", "'n' is wrong: false is no number (yes, no, on and off are none either)."),
        ("x: '1.5'", "(got '1.5'); write it without quotes."),
        ("n: '3'", "(got '3'); write it without quotes."),
        ("x: wide", "Input should be a valid number (got 'wide')."),
        ("n: 1.5", "got a number with a fractional part (got 1.5)."),
        ("x: 1e999", "(got inf)."),
    ],
)
def test_what_is_no_number_is_refused_with_the_remedy(text: str, said: str):
    with pytest.raises(FileError) as refused:
        validate(Said, parse_yaml(text, "file"), "file")
    assert str(refused.value).endswith(said)


def test_a_whole_number_may_be_written_as_json_of_other_languages_writes_it():
    assert validate(Said, {"n": 3.0}, "file").n == 3


@pytest.mark.parametrize("values", [[True, False], np.array([1.0, "0_3"], dtype=object), [None, True], ["1", "2"]])
def test_an_array_of_texts_or_booleans_is_no_array_of_numbers(values: Any):
    with pytest.raises(ArrayError, match="q is no array of numbers"):
        numbers("q", values, (2,))
