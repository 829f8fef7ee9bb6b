"""What is of another kind than hints ask for is refused in a sentence; what is meant is taken."""

# pyright: reportArgumentType=false, reportCallIssue=false
from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import pytest

from planner.base.arrays import Floats
from planner.base.errors import ArrayError, KindError, OptionError, PlannerError
from planner.base.kinds import checks_kinds, kind_of, kinds_of
from planner.base.places import Place


class Shape(Protocol):
    @property
    def name(self) -> str: ...
    def area(self) -> float: ...


class Square:
    name = "square"

    def area(self) -> float:
        return 1.0


NUMBERS = [np.float32(1.0), 3, True, 2.5, np.int8(3), np.array(1.0)]
TAKEN: list[tuple[Any, list[object], list[object]]] = [
    (float, NUMBERS, ["x", None, [1.0], np.ones(1), 1j, 10**400]),
    (int, [3, np.int64(3)], [3.0, "3", None, 10**400]),
    (bool, [True, np.bool_(True)], [1, None, "yes"]),
    (str, ["x"], [3, None, b"x", Path()]),
    (Place, ["x", Path()], [3, None, ["x"]]),
    (Literal["a", "b"], ["a"], [3, None, np.ones(2)]),
    (Floats, [np.ones(3), [1, 2], 3.0, ((1.0,),)], ["x", None, ["a"], [[1.0], 2], np.array(["a"]), Square()]),
    (Sequence[float], [[1.0], (1, 2), np.ones(2), []], ["x", None, 3.0, ["x"], {1.0: 2.0}, np.array(["a"])]),
    (Iterable[float], [[1.0], iter([1.0]), np.ones(2)], ["x", None, 3.0, ["x"]]),
    (Sequence[str], [["x"], ()], ["x", None, 3, ["x", 3]]),
    (tuple[Square, ...], [(Square(),), [Square()], ()], [Square(), None, (Square(), 3)]),
    (tuple[int, float], [(1, 2.0), [1, 2]], [3, None, ("a", "b")]),
    (Mapping[str, float], [{}, {"a": 1.0}], ["x", None, [1.0], {"a": "b"}, {1: 1.0}]),
    (Callable[[float], float], [float, lambda x: x], ["x", None]),
    (Square, [Square()], [Square, None, "x"]),
    (Shape, [Square()], [Square, None, "x", 3]),
    (Square | None, [Square(), None], [3, "x"]),
    (float | Floats | None, [None, 3.0, np.ones(2)], ["x", Square()]),
]


@pytest.mark.parametrize(("hint", "right", "wrong"), TAKEN)
def test_what_a_hint_takes(hint: Any, right: list[object], wrong: list[object]) -> None:
    kind = kind_of(hint)
    assert kind is not None
    assert [value for value in right if not kind.fits(value)] == []
    assert [value for value in wrong if kind.fits(value)] == []


@checks_kinds
def as_they_come(real: float, whole: int | None, true: bool, rest: Any = None, *, last: float = 0.0) -> list[object]:
    return [real, whole, true, rest, last]


@pytest.mark.parametrize("real", [np.float32(0.5), np.longdouble(0.5), Fraction(1, 2), np.array(0.5)])
def test_numbers_of_other_libraries_are_handed_on_as_own(real: Any) -> None:
    got = as_they_come(real, np.int64(3), np.bool_(True), real, last=real)
    assert got[:3] + got[4:] == [0.5, 3, True, 0.5]
    assert [type(value) for value in got] == [float, int, bool, type(real), float]


def test_what_is_too_large_is_not_written_out() -> None:
    with pytest.raises(OptionError, match=r"^as_they_come: real is too large a number: give a number\.$"):
        as_they_come(10**5000, 3, True)


@checks_kinds
def scaled(values: Floats, by: float = 1.0, *, name: str | None = None, **more: Any) -> Floats:
    """Values, scaled."""
    return np.asarray(values) * by


@checks_kinds
@dataclass(frozen=True)
class Sized:
    size: float

    @staticmethod
    def of(square: Square) -> Sized:
        return Sized(square.area())

    def grown(self, by: float) -> Sized:
        return Sized(self.size + by)


@pytest.mark.parametrize(
    ("call", "error", "sentence"),
    [
        (lambda: scaled("x"), ArrayError, "scaled: values is the text 'x': give an array of numbers."),
        (lambda: scaled(None, 2.0), ArrayError, "scaled: values is None: give an array of numbers."),
        (lambda: scaled([1.0], by="a"), OptionError, "scaled: by is the text 'a': give a number."),
        (
            lambda: scaled([1.0], np.ones((2, 3))),
            OptionError,
            "scaled: by is a ndarray of shape (2, 3): give a number.",
        ),
        (lambda: scaled([1.0], name=3), OptionError, "scaled: name is 3: give text."),
        (lambda: Sized([1.0]), OptionError, "Sized: size is a list: give a number."),
        (lambda: Sized.of(3), KindError, "Sized.of: square is 3: give a Square."),
        (lambda: Sized(1.0).grown(None), OptionError, "Sized.grown: by is None: give a number."),
        (lambda: replace(Sized(1.0), size="x"), OptionError, "Sized: size is the text 'x': give a number."),
    ],
)
def test_the_sentence(call: Callable[[], object], error: type[PlannerError], sentence: str) -> None:
    with pytest.raises(error) as caught:
        call()
    assert str(caught.value) == sentence


def test_what_is_right_passes_as_it_is() -> None:
    assert scaled([1.0, 2.0], 2, name="x", other=3).tolist() == [2.0, 4.0]
    assert Sized.of(Square()).grown(by=1.0) == Sized(2.0)
    assert scaled.__doc__ == "Values, scaled."
    assert kinds_of(scaled)["name"] is not None


def test_mistakes_in_the_call_itself_stay_pythons_own() -> None:
    with pytest.raises(TypeError, match="missing 1 required positional argument"):
        scaled()
