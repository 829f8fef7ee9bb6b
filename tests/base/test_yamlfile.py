"""Text that people write: parsed without constructing objects, its numbers numbers, and checked against a model."""

import contextlib
import importlib
import pkgutil
from collections.abc import Iterator
from typing import Any

import pydantic
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import planner
from planner.base.errors import FileError, PlannerError
from planner.base.yamlfile import (
    Number,
    Strict,
    Whole,
    parse_yaml,
    validate,
    yaml_text,
)
from planner.roadmap.storage import _Header
from tests.any_data import data_of
from tests.random_shapes import QUICK

PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


class Said(Strict):
    x: Number | None = None
    n: Whole | None = None


@settings(QUICK, suppress_health_check=[HealthCheck.too_slow])
@given(PLAIN)
def test_reading_returns_the_written_data(data: Any) -> None:
    assert parse_yaml(yaml_text(data), "it") == data


@pytest.mark.parametrize("text", ["1e3", "1.5e3", "yes", "010", "1:30", "1_000", "0x1", ".5", "null", "2001-01-01"])
def test_a_text_that_looks_like_a_number_stays_a_text(text: str) -> None:
    assert parse_yaml(yaml_text({"a": text}), "it") == {"a": text}


@QUICK
@given(st.text(alphabet="a:1-{}[]&*<! \n.,e", max_size=30))
def test_any_text_is_data_or_refused(text: str) -> None:
    with contextlib.suppress(FileError):
        parse_yaml(text, "it")


@pytest.mark.parametrize(("text", "x"), [("1e-3", 1e-3), ("-2E4", -2e4), ("+.5e1", 5.0), ("3.e2", 300.0), ("7", 7.0)])
def test_a_number_is_one_in_every_way_that_yaml_writes_it(text: str, x: float) -> None:
    assert validate(Said, parse_yaml(f"x: {text}", "file"), "file").x == x
    assert validate(Said, {"n": 3.0}, "file").n == 3  # as JSON of other languages writes it


@pytest.mark.parametrize("text", ["a: 1\nb: 2\na: 3", "{x: {a: 1, a: 2}}", "- {a: [1], b: {a: 1}, a: 2}"])
def test_a_key_that_stands_twice_is_no_guess(text: str) -> None:
    with pytest.raises(FileError, match=r"at line \d: key 'a' is repeated"):
        parse_yaml(text, "it")


@pytest.mark.parametrize(
    "text", ["a: [", "!!python/object/apply:os.getcwd []", "a: &x [*x]\n<<: 1", "2001-13-45", "!!timestamp x"]
)
def test_no_text_constructs_anything_or_overflows(text: str) -> None:
    with pytest.raises(FileError, match="correct the file"):
        parse_yaml(text, "it")


def models() -> list[type[pydantic.BaseModel]]:
    """Every pydantic model of the package, whichever module it stands in."""
    for module in pkgutil.walk_packages(planner.__path__, "planner."):
        if not module.name.endswith(
            ("__main__", ".libplanner", ".compiled", ".ros.node", ".ros.messages", ".lerobot.steps")
        ):
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
def test_no_number_of_a_model_is_made_of_a_boolean_or_a_text(model: type[pydantic.BaseModel]) -> None:
    model.model_rebuild()
    assert not list(loose(model.__pydantic_core_schema__, model.__name__))


@pytest.mark.parametrize("model", models(), ids=lambda kind: f"{kind.__module__}.{kind.__qualname__}")
@settings(QUICK, max_examples=25, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(data=st.data())
def test_any_data_is_a_value_of_the_model_or_one_sentence(model: type[pydantic.BaseModel], data: st.DataObject) -> None:
    try:
        assert isinstance(validate(model, data.draw(data_of(model, unknown=True)), "it"), model)
    except PlannerError as error:
        text = str(error)
        assert text.startswith("it")
        assert text.endswith(".")
        assert "\n" not in text
        assert len(text) < 1000
