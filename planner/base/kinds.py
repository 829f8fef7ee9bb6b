"""Whether what is given to a public function is of the kinds that its hints ask for, said in one sentence if not.

    @checks_kinds
    def build_network(roadmap: Roadmap, ...): ...

    build_network(None)      # KindError: build_network: roadmap is None: give a Roadmap, as planner.build_roadmap ...

The hints are the one place where kinds are written. They are read at the first call, so that nothing loads early; a
check takes a few microseconds. Shapes, ranges and words are the functions' own to judge.
"""

from __future__ import annotations

import inspect
import os
import sys
import types
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from functools import wraps
from numbers import Integral, Real
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, Union, cast, get_args, get_origin

from planner.base.errors import ArrayError, FileError, KindError, OptionError, PlannerError, choices

Checked = TypeVar("Checked", bound=Callable[..., Any])

WIDER: dict[str, Any] = {}
"""Kinds by the names in hints that stand for less at run time, for the command line's sake."""

_WANTED = {
    "CollisionChecker": "a checker, as planner.make_checker makes it",
    "CostToGo": "a CostToGo, as planner.gabf.solve finds it",
    "HasPage": "a Plan, or a Tradeoff",
    "KnownMotion": "a planner.KnownMotion(times, poses)",
    "Law": "a law, as planner.gabf.SingularityFree(T=4.0)",
    "MotionLimits": "limits, as planner.MotionLimits.of(robot) makes them",
    "Network": "a Network, as planner.build_network makes it",
    "Obstacle": "a planner.Obstacle(name, shape, planner.pose(...))",
    "Plan": "a Plan, as planner.plan finds it",
    "Roadmap": "a Roadmap, as planner.build_roadmap or planner.load_roadmap makes it",
    "Robot": "a Robot, as planner.Robot.load makes it",
    "Scene": "a Scene, as planner.Scene.load makes it",
    "Snapshot": "a Snapshot, as Session.snapshot() hands it out",
}


class Kind(NamedTuple):
    """What fits a hint, what to say is wanted, the error for what does not, and whether it is a number.

    Everything whose type is one of ``exact`` fits as it is: most calls need no closer look.
    """

    fits: Callable[[Any], bool]
    wanted: str
    error: type[PlannerError] = KindError
    numbers: bool = False
    exact: frozenset[type] = frozenset()


def checks_kinds(thing: Checked) -> Checked:
    """A public function, or a class (how it is made, its public methods), that refuses what its hints do not name.

    Raises :class:`OptionError` for numbers and words, :class:`ArrayError` for arrays, :class:`FileError` for places,
    else :class:`KindError`. Where a hint asks for a number, that of another library (``numpy.float32``) is handed on as
    Python's own, which files and compiled code take.
    """
    if not inspect.isclass(thing):
        return _checking(thing)
    owner: type = thing
    for name, member in list(vars(owner).items()):
        if name != "__init__" and name.startswith("_"):
            continue
        if isinstance(member, staticmethod | classmethod):
            setattr(owner, name, type(member)(_checking(member.__func__)))
        elif inspect.isfunction(member):
            setattr(owner, name, _checking(member))
    return cast("Checked", owner)


def kinds_of(function: Callable[..., Any]) -> dict[str, Kind | None]:
    """The kind that each parameter of a function is checked for; None where anything will do."""
    plain = inspect.unwrap(function)
    names, hints = {**vars(sys.modules[plain.__module__]), **WIDER}, plain.__annotations__
    return {name: kind_of(_read(hints[name], names)) for name in _parameters(plain) if name in hints}


def _parameters(function: Any) -> tuple[str, ...]:
    """Those by name, the positional ones first: inspect takes ten times as long, which hundreds of functions feel."""
    code = function.__code__
    return code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]


def kind_of(hint: Any) -> Kind | None:
    """What fits a type hint; None for everything."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return kind_of(args[0])
    if hint in _PLAIN:
        return _PLAIN[hint]
    if origin in (Union, types.UnionType):
        return _any_of([kind_of(arg) for arg in args])
    if origin is Literal:
        return _TEXT._replace(wanted=f"one of {choices(args)}")
    if getattr(origin, "__module__", "") == "numpy":
        return Kind(_holds_numbers, "an array of numbers", ArrayError)
    if origin is tuple:
        return _sequence([arg for arg in args if arg is not ...], args[-1] is not ...)
    if origin in (Sequence, Iterable, list):
        return _sequence(args, fixed=False)
    if origin in (Mapping, dict):
        return _mapping(*args)
    if origin in (Set, frozenset, set):
        return Kind(lambda value: isinstance(value, Set), "a set")
    if origin is Callable:
        return Kind(callable, "a function")
    kind = origin or hint
    return _instance(kind) if inspect.isclass(kind) and kind is not object else None


def _checking(function: Any) -> Any:
    """The function with a look at what it is given."""
    known: list[tuple[list[tuple[str, Kind | None]], dict[str, Kind | None]]] = []  # one: threads may ask at once
    title = function.__qualname__.removesuffix(".__init__")

    @wraps(function)
    def checked(*args: Any, **named: Any) -> Any:
        if not known:
            plain = inspect.unwrap(function)
            found = {**dict.fromkeys(_parameters(plain)), **kinds_of(plain)}
            known.append((list(found.items())[: plain.__code__.co_argcount], found))
        by_place, by_name = known[0]
        given = list(args)
        for place, ((name, kind), value) in enumerate(zip(by_place, args, strict=False)):
            if kind is not None and type(value) not in kind.exact:
                given[place] = _taken(title, name, value, kind)
        for name, value in named.items():
            if (kind := by_name.get(name)) is not None and type(value) not in kind.exact:
                named[name] = _taken(title, name, value, kind)
        return function(*given, **named)

    return checked


def _read(annotation: Any, names: Mapping[str, Any]) -> Any:
    """A hint that was kept as text, by what its ``names`` stand for; ``object`` where only type checkers know them."""
    if not isinstance(annotation, str):
        return annotation
    try:
        return eval(annotation, dict(names))  # as typing.get_type_hints does, hint by hint
    except NameError:
        return object


def _taken(title: str, name: str, value: Any, kind: Kind) -> Any:
    """The value if it fits; a number of another library as Python's own."""
    if not kind.fits(value):
        raise kind.error(f"{title}: {name} is {_shown(value)}: give {kind.wanted}.")
    return value if type(value) in _OWN or not kind.numbers else _own(value)


def _own(value: Any) -> Any:
    """Python's own number, or truth value, for that of another library; anything else as it is."""
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value)
    return value.item() if _is_array(value) and value.ndim == 0 and value.dtype.kind in "fiub" else value


def _shown(value: object) -> str:
    if isinstance(value, Integral) and not _is_whole(value):
        return "too large a number"
    if value is None or isinstance(value, Real):
        return str(value)
    if isinstance(value, str):
        return f"the text {value[:60]!r}"
    shape = getattr(value, "shape", None)
    return f"a {type(value).__name__}" + (f" of shape {shape}" if isinstance(shape, tuple) else "")


def _is_number(value: Any) -> bool:
    """Whether a float can stand for it."""
    if type(value) is float:
        return True
    if isinstance(value, Real):
        try:
            float(value)
        except OverflowError:
            return False
        return True
    return _is_array(value) and value.ndim == 0 and value.dtype.kind in "fiu"


def _is_whole(value: Any) -> bool:
    return isinstance(value, Integral) and -_MOST <= int(value) < _MOST


def _is_array(value: Any) -> bool:
    return type(value).__module__ == "numpy" and hasattr(value, "dtype")


def _holds_numbers(value: Any) -> bool:
    """Whether numpy makes numbers of it; of an array only its dtype is looked at."""
    if value is None or isinstance(value, str):
        return False
    if not _is_array(value):
        import numpy as np

        try:
            value = np.asarray(value)
        except (TypeError, ValueError, OverflowError, RuntimeError):  # the last of tensors that are to be detached
            return False
    return value.dtype.kind in "fiub"


def _any_of(kinds: Sequence[Kind | None]) -> Kind | None:
    known = [kind for kind in kinds if kind is not None]
    if len(known) < len(kinds):
        return None
    named = [kind for kind in known if kind is not _PLAIN[type(None)]]
    wanted = dict.fromkeys(kind.wanted for kind in named)
    errors = {kind.error for kind in named}
    tests = [kind.fits for kind in known]
    error = errors.pop() if len(errors) == 1 else FileError if FileError in errors else KindError
    numbers = any(kind.numbers for kind in known)
    exact = frozenset().union(*(kind.exact for kind in known))
    return Kind(lambda value: any(fits(value) for fits in tests), ", or ".join(wanted), error, numbers, exact)


def _sequence(items: Sequence[Any], fixed: bool) -> Kind:
    """Of any length and one kind, or ``fixed`` with a kind for each place."""
    inner, numbers = [kind_of(item) for item in items], items[0] in (int, float)
    named = "numbers" if numbers else f"several: {inner[0].wanted}" if inner[0] else "several"
    dtypes = "iuO" if items[0] is int else "fiubO"
    tests = [(lambda _: True) if kind is None else kind.fits for kind in inner]

    def array_fits(array: Any) -> bool:
        right = array.dtype.kind in dtypes if numbers else array.ndim > 0 and all(map(tests[0], array))
        return right and (array.ndim == 1 if fixed else array.ndim > 0)

    def fits(value: object) -> bool:
        if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
            return False
        if _is_array(value):
            return array_fits(value)
        if not isinstance(value, Sequence):
            return True  # what can be looked through once only is the function's own to judge
        if fixed:
            return all(test(item) for test, item in zip(tests, value, strict=False))
        return all(map(tests[0], value))

    return Kind(fits, f"{len(items)} {named}" if fixed else named, ArrayError if numbers else KindError)


def _mapping(key: Any, item: Any) -> Kind:
    tests = [kind.fits if (kind := kind_of(of)) else lambda _: True for of in (key, item)]

    def fits(value: Any) -> bool:
        return isinstance(value, Mapping) and all(tests[0](name) and tests[1](value[name]) for name in value)

    inner = kind_of(item)
    return Kind(fits, f"a dict from names to {inner.wanted if inner else 'values'}")


def _instance(kind: type) -> Kind:
    article = "an" if kind.__name__[0] in "AEIO" else "a"
    wanted = _WANTED.get(kind.__name__, f"{article} {kind.__name__}")
    if not getattr(kind, "_is_protocol", False):
        return Kind(lambda value: isinstance(value, kind), wanted, exact=frozenset({kind}))
    members = [(name, member) for name, member in vars(kind).items() if not name.startswith("_")]
    required = [name for name, member in members if callable(member) or isinstance(member, property)]

    def fits(value: object) -> bool:
        own = getattr(value, "__dict__", {})
        return not isinstance(value, type) and all(hasattr(type(value), name) or name in own for name in required)

    return Kind(fits, wanted)


_MOST = 2**63
_OWN = frozenset({type(None), bool, int, float, str})
_PATH = Kind(lambda value: isinstance(value, os.PathLike), "a path", FileError)
_TEXT = Kind(lambda value: isinstance(value, str), "text", OptionError, exact=frozenset({str}))
_PLAIN: dict[Any, Kind | None] = {
    **dict.fromkeys((type(None), None), Kind(lambda value: value is None, "None", exact=frozenset({type(None)}))),
    bool: Kind(
        lambda value: isinstance(value, bool) or type(value).__name__ in ("bool_", "bool"),
        "True or False",
        OptionError,
        numbers=True,
        exact=frozenset({bool}),
    ),
    int: Kind(_is_whole, "a whole number", OptionError, numbers=True),
    float: Kind(_is_number, "a number", OptionError, numbers=True, exact=frozenset({float})),
    str: _TEXT,
    **dict.fromkeys((os.PathLike, os.PathLike[str]), _PATH),
    Any: None,
}
