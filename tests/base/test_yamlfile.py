"""Text that people write: read, parsed without constructing objects, and checked against a model."""

from __future__ import annotations

from pathlib import Path

import pydantic
import pytest

from planner.base.errors import FileError, PlannerError, SceneError
from planner.base.yamlfile import Coordinate, Size, Strict, parse_yaml, read_text, shown, validate


def test_whatever_is_quoted_is_short() -> None:
    assert shown("a.b") == "'a.b'"
    assert len(shown("x" * 10_000)) < 200
    assert len(shown([["x" * 100] * 100] * 100)) < 2000
    assert "thousands of digits" in shown(1 << 100_000)
    with pytest.raises(FileError):
        parse_yaml("!!timestamp x", "it")
    assert issubclass(SceneError, PlannerError)


class Ball(Strict):
    radius: Size
    at: list[Coordinate] = pydantic.Field(default_factory=list)


def test_text_becomes_a_model() -> None:
    found = validate(Ball, parse_yaml("{radius: 0.1, at: [0, -1.5]}", "it"), "it")
    assert (found.radius, found.at) == (0.1, [0.0, -1.5])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{radius: 0.1, colour: red}", "unknown key 'colour'"),
        ("{at: [0]}", "key 'radius' is missing"),
        ("{radius: .nan}", "'radius'"),
        ("{radius: 1.0e-9}", "greater than or equal to"),
        ("{radius: 1, at: [1.0e+9]}", "'at.0' is wrong"),
        ("- 1", "no mapping of keys to values: give its keys, out of radius, at"),
    ],
)
def test_what_does_not_fit_is_named(text: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        validate(Ball, parse_yaml(text, "it"), "it", SceneError)


@pytest.mark.parametrize("text", ["a: 1\nb: 2\na: 3", "{x: {a: 1, a: 2}}", "- {a: [1], b: {a: 1}, a: 2}"])
def test_a_key_that_stands_twice_is_no_guess(text: str) -> None:
    with pytest.raises(FileError, match=r"it is not valid YAML at line \d: key 'a' stands twice; mend the file\."):
        parse_yaml(text, "it")


def test_aliases_that_repeat_little_are_unfolded() -> None:
    text = "size: &s [1, 2]\nshared: &b {size: *s, colour: red}\nall:\n" + "- {<<: *b, name: x}\n" * 4000
    assert parse_yaml(text, "it")["all"][-1] == {"size": [1, 2], "colour": "red", "name": "x"}


def test_a_key_may_stand_in_several_mappings_and_merging_may_be_repeated() -> None:
    text = "x: &x {a: 1}\ny: {<<: *x, <<: *x, a: 2}\nz: [{a: a}, {a: 1}]\na: a"
    assert parse_yaml(text, "it") == {"x": {"a": 1}, "y": {"a": 2}, "z": [{"a": "a"}, {"a": 1}], "a": "a"}


def test_a_misspelt_key_is_told_with_what_was_meant() -> None:
    with pytest.raises(FileError, match=r"unknown key 'raduis' \(did you mean 'radius'\?\)"):
        validate(Ball, {"raduis": 1}, "it")  # which leaves radius missing


@pytest.mark.parametrize(
    "text",
    ["a: [", "!!python/object/apply:os.getcwd []", "a: &x [*x]\n<<: 1", "2001-13-45"],
)
def test_no_text_constructs_anything_or_overflows(text: str) -> None:
    with pytest.raises(FileError, match="mend the file"):
        parse_yaml(text, "it")


def test_unreadable_files_say_what_was_wanted(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xff\xfe\x00")
    for path, words in (
        (tmp_path / "none", "not found"),
        (tmp_path / "a", "not UTF-8"),
        (tmp_path, "Is a directory"),
    ):
        with pytest.raises(FileError, match=f"scene .*{words}"):
            read_text(path, "scene")
