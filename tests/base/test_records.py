"""Records are what dataclasses makes of the same class, but for how they are made."""

from __future__ import annotations

import abc
import copy
import dataclasses
import inspect
import pickle
import subprocess
import sys
from collections.abc import Callable
from dataclasses import FrozenInstanceError, InitVar, field, fields, replace
from functools import cached_property
from typing import Any, ClassVar, get_type_hints

import numpy as np
import pytest

from planner.base.arrays import frozen
from planner.base.errors import OptionError
from planner.base.kinds import checks_kinds
from planner.base.records import dataclass


def point(made_by: Any, **options: Any) -> Any:
    @made_by(frozen=True, **options)
    class Point:
        x: float
        y: float = 2.0
        tags: list[str] = field(default_factory=list)
        secret: str = field(default="s", repr=False, compare=False)
        length: float = field(init=False)

        def __post_init__(self) -> None:
            object.__setattr__(self, "length", (self.x**2 + self.y**2) ** 0.5)

        @cached_property
        def half(self) -> float:
            return self.length / 2

    return Point


def both(**options: Any) -> tuple[Any, Any]:
    return point(dataclass, **options), point(dataclasses.dataclass, **options)


@dataclass(frozen=True)
class Named:
    name: str
    """Of what it is."""
    size: int = 1


@dataclass(frozen=True)
class Coloured(Named):
    colour: str = "red"


@dataclass(frozen=True, eq=False)
class Measured:
    values: np.ndarray


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda made: pickle.loads(pickle.dumps(made))])
def test_arrays_of_copies_are_read_only(copied: Callable[[Any], Any]) -> None:
    """A roadmap's could be changed, and it was called proven as before."""
    made = copied(Measured(frozen([1.0, 2.0])))
    assert made.values.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        made.values[0] = 3.0


@dataclass(frozen=True, eq=False)
class Link:
    to: list[Any]


@dataclass(frozen=True, kw_only=True)
class Sized(Named):
    length: float
    width: float = 1.0


@pytest.mark.parametrize(
    ("args", "named"),
    [((1.0,), {}), ((3.0, 4.0), {}), ((), {"y": 1.0, "x": 2.0}), ((1.0, 2.0, ["a"]), {"secret": "t"})],
)
def test_they_hold_what_they_are_given(args: tuple[Any, ...], named: dict[str, Any]) -> None:
    ours, theirs = (made(*args, **named) for made in both())
    assert vars(ours) == vars(theirs)
    assert list(vars(ours)) == list(vars(theirs))
    assert repr(ours) == repr(theirs)
    assert dataclasses.asdict(ours) == dataclasses.asdict(theirs)
    assert [item.name for item in fields(ours)] == [item.name for item in fields(theirs)]
    assert vars(replace(ours, x=5.0)) == vars(replace(theirs, x=5.0))
    assert ours.half == theirs.half
    assert type(ours)(*args, **named).tags is not type(ours)(*args[:2], **named).tags or len(args) > 2


@pytest.mark.parametrize("options", [{}, {"kw_only": True}])
@pytest.mark.parametrize(
    ("args", "named"),
    [
        ((), {}),
        ((), {"y": 1.0}),
        ((1.0,), {"x": 2.0}),
        ((1.0,), {"z": 2.0}),
        ((), {"y": 1.0, "z": 2.0}),
        ((1.0,), {"length": 2.0}),
        ((1.0, 2.0, [], "s", 5.0), {}),
    ],
)
def test_what_does_not_fit_is_refused_as_python_does(args: Any, named: Any, options: Any) -> None:
    told: list[str] = []
    for made in both(**options):
        with pytest.raises(TypeError) as refused:
            made(*args, **named)
        told.append(str(refused.value))
    assert told[0] == told[1]


def test_by_name_only() -> None:
    ours, theirs = both(kw_only=True)
    assert vars(ours(x=1.0)) == vars(theirs(x=1.0))


def test_signatures_are_told() -> None:
    for ours, theirs in (both(), both(kw_only=True)):
        for how in (inspect.signature, inspect.getfullargspec):
            assert str(how(ours)) == str(how(theirs))
            assert str(how(ours.__init__)) == str(how(theirs.__init__))
    assert str(inspect.signature(Coloured)) == "(name: 'str', size: 'int' = 1, colour: 'str' = 'red') -> None"
    assert list(inspect.signature(Sized).parameters) == ["name", "size", "length", "width"]
    assert vars(Sized("a", length=2.0)) == {"name": "a", "size": 1, "length": 2.0, "width": 1.0}

    class Own(Named):
        def __init__(self, one: int) -> None:
            super().__init__(str(one))

    assert list(inspect.signature(Own).parameters) == ["one"]
    assert vars(Own(3)) == {"name": "3", "size": 1}


class Kept:
    """A name of this module only."""


@dataclass(frozen=True)
class Keeps:
    kept: Kept


def test_hints_are_read_in_the_module_of_the_class() -> None:
    assert get_type_hints(Keeps) == {"kept": Kept}
    assert get_type_hints(Keeps.__init__) == {"kept": Kept, "return": type(None)}
    assert inspect.signature(Keeps, eval_str=True).parameters["kept"].annotation is Kept


def test_of_a_module_that_is_not_there() -> None:
    Odd = dataclass(frozen=True)(type("Odd", (), {"__module__": "nowhere", "__annotations__": {"x": int}}))
    assert repr(Odd(1)) == "Odd(x=1)"


def test_equal_where_fields_are_and_hashed_alike() -> None:
    ours, _ = both()
    assert ours(1.0) == ours(1.0, secret="t") != ours(2.0)
    assert Named("a") == Named("a")
    assert hash(Named("a")) == hash(Named("a"))
    assert Named("a") != Named("b")
    assert Named("a") != Coloured("a")
    assert (Named("a") == "a") is False
    assert {Named("a"): 1}[Named("a", 1)] == 1
    nan: Any = float("nan")
    assert Named(nan) == Named(nan)  # one object is itself, as in tuples
    one, other = Link([]), Link([])
    assert one != other
    assert hash(one) != hash(other)
    with pytest.raises(TypeError, match="unhashable"):
        hash(ours(1.0))


def test_fields_of_other_kinds_are_as_there() -> None:
    for made_by in (dataclass, dataclasses.dataclass):

        @made_by(frozen=True)
        class Odd:
            x: int
            named: int = field(default=1, kw_only=True)
            twice: InitVar[int] = 2
            part: list[int] = field(default_factory=list, hash=False)
            seen: int = field(default=1, compare=False, hash=True)
            made: list[int] = field(init=False, default_factory=list)
            fixed: int = field(init=False, default=4)

            def __post_init__(self, twice: int = 0) -> None:
                self.made.append(2 * twice)

        @made_by(frozen=True)
        class Made:
            x: int
            part: list[int] = field(default_factory=list, hash=False)
            seen: int = field(default=1, compare=False, hash=True)
            made: tuple[int, ...] = field(init=False, default_factory=tuple)
            fixed: int = field(init=False, default=4)

        assert Odd(1, 3).made == [6]
        assert (Made(1).part, Made(1).made, Made(1).fixed) == ([], (), 4)
        assert hash(Made(1)) == hash(Made(1, [2]))
        assert Made(1, [], 2) == Made(1, [], 3)
        assert hash(Made(1, [], 2)) != hash(Made(1, [], 3))


def test_what_dataclasses_refuses_is_refused() -> None:
    for made_by in (dataclass, dataclasses.dataclass):
        with pytest.raises(TypeError, match="non-default argument 'y' follows default argument"):

            @made_by(frozen=True)
            class Mixed:
                x: int = 1
                y: int  # pyright: ignore[reportGeneralTypeIssues]

        with pytest.raises(TypeError, match="Cannot overwrite attribute __setattr__"):

            @made_by(frozen=True)
            class Loose:
                x: int = 1

                def __setattr__(self, name: str, value: object) -> None: ...

        @made_by(frozen=True)
        class Unhashed:
            x: int = 1
            __hash__ = None  # pyright: ignore[reportAssignmentType]

        with pytest.raises(TypeError, match="unhashable"):
            hash(Unhashed())


def test_a_slot_or_a_property_of_another_class_is_not_passed_by() -> None:
    class Slot:
        __slots__ = ("x",)

    for made_by in (dataclass, dataclasses.dataclass):

        @made_by(frozen=True)
        class Slotted(Slot):
            x: int

        class Fixed(Named):
            @property
            def size(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
                return 9

        assert Slotted(1).x == 1
        with pytest.raises(AttributeError, match="has no setter"):
            Fixed("a")


def test_a_class_keeps_what_it_has_of_its_own() -> None:
    @dataclass(frozen=True)
    class Odd:
        x: int

        def __repr__(self) -> str:
            return "odd"

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Odd)

        def __hash__(self) -> int:
            return 7

    assert repr(Odd(1)) == "odd"
    assert Odd(1) == Odd(2)
    assert hash(Odd(1)) == 7

    @dataclass(frozen=True)
    class Alike:
        x: int

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Alike)

    assert Alike(1) == Alike(2)
    assert hash(Alike(1)) == hash(Alike(1)) != hash(Alike(2)), "as dataclasses has it"


@pytest.mark.parametrize("made", [Named("a"), Coloured("a", 2, "blue")])
def test_nothing_is_changed(made: Any) -> None:
    for name in ("name", "size", "other"):
        with pytest.raises(FrozenInstanceError, match=name):
            setattr(made, name, 1)
        with pytest.raises(FrozenInstanceError, match=name):
            delattr(made, name)


def wider(made_by: Any, **options: Any) -> Any:
    """What extends two others, takes fields of theirs over, and has fields of every kind."""

    @made_by(frozen=True)
    class Base:
        a: int
        b: int = 1
        c: list[int] = field(default_factory=list)

    @made_by(frozen=True)
    class Beside:
        e: int = 5

    @made_by(frozen=True, **options)
    class Wide(Beside, Base):
        kinds: ClassVar[int] = 3
        b: float
        c: Any = None
        d: int = field(default=4, repr=False, compare=False)
        f: dict[str, int] = field(default_factory=dict, kw_only=True)
        g: int = field(default=7, init=False)
        h: int = field(init=False, compare=False, default_factory=int)

    return Wide


@pytest.mark.parametrize("options", [{}, {"kw_only": True}, {"eq": False}])
def test_what_extends_others_is_as_dataclasses_makes_it(options: dict[str, bool]) -> None:
    ours, theirs = wider(dataclass, **options), wider(dataclasses.dataclass, **options)
    assert str(inspect.signature(ours)) == str(inspect.signature(theirs))
    assert [str(item) for item in ours.__dataclass_fields__.values()] == [
        str(item) for item in theirs.__dataclass_fields__.values()
    ]
    assert str(ours.__dataclass_params__) == str(theirs.__dataclass_params__)
    assert ours.__match_args__ == theirs.__match_args__
    names = [{name for name in vars(made) if not name.startswith("__")} for made in (ours, theirs)]
    assert names[0] == names[1]
    one, other = ours(1, f={"x": 1}), theirs(1, f={"x": 1})
    assert repr(one) == repr(other)
    assert vars(one) == vars(other)
    assert vars(replace(one, a=2, f={})) == vars(replace(other, a=2, f={}))
    with pytest.raises(FrozenInstanceError, match="cannot assign to field 'd'"):
        one.d = 1


def unhinted(made_by: Any) -> Any:
    @made_by(frozen=True)
    class Unhinted(made_by(frozen=True)(type("Base", (), {}))):
        a = field(default=3)

    return Unhinted


def of_a_mixin(made_by: Any) -> Any:
    class Mixin(made_by(frozen=True)(type("Base", (), {}))):
        a: int = field(default=3)

    @made_by(frozen=True)
    class Mixed(Mixin):
        a: int

    return Mixed.a


def lets_delete(made_by: Any) -> Any:
    class Mixin:
        def __delattr__(self, name: str) -> None:
            object.__delattr__(self, name)

    @made_by(frozen=True)
    class Lax(Mixin, made_by(frozen=True)(type("Base", (), {}))):
        a: int = 3

    del Lax().a
    return Lax


def abstract(made_by: Any) -> Any:
    class Named(abc.ABC):
        @property
        @abc.abstractmethod
        def a(self) -> int: ...

    @made_by(frozen=True)
    class Base(Named):
        b: int = 1

    @made_by(frozen=True)
    class Abstract(Base):
        a: int = field(kw_only=True)

    return Abstract(a=1)


def given_to_its_init(made_by: Any) -> Any:
    @made_by(frozen=True)
    class Base:
        a: int
        twice: InitVar[int] = 3

        def __post_init__(self, twice: int) -> None:
            object.__setattr__(self, "b", 2 * twice)

    @made_by(frozen=True)
    class More(Base):
        c: int = 1

    return sorted(vars(More(1, 2, 3)).items())


@pytest.mark.parametrize("case", [unhinted, of_a_mixin, lets_delete, abstract, given_to_its_init])
def test_what_extends_others_fails_and_fares_as_theirs(case: Callable[[Any], Any]) -> None:
    told: list[str] = []
    for made_by in (dataclass, dataclasses.dataclass):
        try:
            told.append(str(case(made_by)))
        except (TypeError, AttributeError) as error:
            told.append(f"{type(error).__name__}: {error}")
    assert told[0] == told[1]


def test_what_extends_a_record_may_have_more_of_its_own() -> None:
    class Counted(Named):
        count = 0

    counted = Counted("a")
    counted.count = 5
    assert counted.count == 5
    with pytest.raises(FrozenInstanceError):
        counted.name = "b"  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.parametrize(("inner", "outer"), [(dataclass, dataclasses.dataclass), (dataclasses.dataclass, dataclass)])
def test_records_and_data_classes_extend_each_other(inner: Any, outer: Any) -> None:
    @inner(frozen=True)
    class Base:
        a: int

    @outer(frozen=True)
    class More(Base):
        b: int = 2

    made = More(1)
    assert (made.a, made.b) == (1, 2)
    assert made == More(1, 2)
    assert hash(made) == hash(More(1))
    with pytest.raises(FrozenInstanceError):
        made.b = 3
    with pytest.raises(TypeError, match="frozen"):

        @dataclasses.dataclass
        class Loose(Base):
            c: int = 3


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda made: pickle.loads(pickle.dumps(made))])
def test_they_are_copied_and_kept(copied: Callable[[Any], Any]) -> None:
    for made in (Named("a", 3), Coloured("b", 2, "c")):
        assert copied(made) == made
        assert type(copied(made)) is type(made)


def test_what_stands_for_a_factory_is_kept_as_itself() -> None:
    default = inspect.signature(both()[0]).parameters["tags"].default
    assert pickle.loads(pickle.dumps(default)) is copy.deepcopy(default) is default


def test_a_debugger_that_looks_at_all_frames_changes_nothing() -> None:
    ours, _ = both()

    def look(frame: Any, event: str, arg: object) -> Any:
        while frame is not None:
            assert frame.f_locals is not None
            frame = frame.f_back
        return look

    before = sys.gettrace()
    sys.settrace(look)
    try:
        made = ours(3.0)
    finally:
        sys.settrace(before)
    assert vars(made) == vars(ours(3.0))


def test_matched_by_place() -> None:
    match Coloured("a", 2):
        case Coloured(name, size, colour):
            assert (name, size, colour) == ("a", 2, "red")


def test_one_that_holds_itself_is_shown() -> None:
    link = Link([])
    link.to.append(link)
    assert repr(link) == "Link(to=[...])"


def test_kinds_are_judged() -> None:
    @checks_kinds
    @dataclass(frozen=True)
    class Judged:
        name: str = field(default="a", kw_only=True)
        size: int

    assert Judged(3, name="b") == Judged(size=3, name="b")
    for wrong in (lambda: Judged("3"), lambda: Judged(size=None), lambda: Judged(3, name=4)):  # pyright: ignore[reportArgumentType]
        with pytest.raises(OptionError, match=r"Judged: (size|name) is"):
            wrong()


def test_no_method_is_compiled_for_a_record() -> None:
    counted = """
import builtins, dataclasses
texts = []
real = builtins.exec
dataclasses.exec = lambda text, *more: (texts.append(text), real(text, *more))
from planner.base.records import dataclass
@dataclass(frozen=True)
class One:
    a: int
    b: str = "x"
assert One(1) == One(1, "x")
print(len(texts))
"""
    done = subprocess.run([sys.executable, "-c", counted], capture_output=True, text=True, check=True)
    assert done.stdout == "0\n"
