"""Frozen data classes that compile nothing when they are made.

:mod:`dataclasses` writes six methods of every class as text and compiles them: 0.4 ms a class, 0.15 s for those of a
plan, a fifth of the whole process. Here the methods are there once and look up what fields a class has; the parameters
of its ``__init__`` are named in a copy of compiled code. All else is as there: ``fields``, ``replace``, ``match``,
signatures, errors; only that the arrays of copies are read-only. What is not frozen, has slots, an order, an
``InitVar`` or a ``__setattr__`` of its own, is made by :mod:`dataclasses` itself.
"""

from __future__ import annotations

import dataclasses
import sys
from abc import update_abstractmethods
from collections.abc import Callable
from dataclasses import FrozenInstanceError, fields
from itertools import pairwise
from operator import attrgetter
from reprlib import recursive_repr
from types import FunctionType
from typing import TYPE_CHECKING, Any


def _dataclass(cls: Any = None, /, *, frozen: bool = False, eq: bool = True, kw_only: bool = False, **more: Any) -> Any:
    """As :func:`dataclasses.dataclass`."""
    if cls is None:
        return lambda cls: _dataclass(cls, frozen=frozen, eq=eq, kw_only=kw_only, **more)
    if not frozen or more or _is_beyond(cls):
        return dataclasses.dataclass(cls, frozen=frozen, eq=eq, kw_only=kw_only, **more)
    own = set(vars(cls))
    if "__eq__" in own and cls.__hash__ is None:
        own.remove("__hash__")  # it stands for none of its own beside an __eq__
    cls.__doc__ = cls.__doc__ or cls.__name__  # else its signature is asked for, which takes longer than all else
    if _extended(cls):
        _extend(cls, kw_only)
    else:
        dataclasses.dataclass(cls, init=False, repr=False, eq=False, kw_only=kw_only)
    cls.__dataclass_params__.frozen = cls.__dataclass_params__.repr = cls.__dataclass_params__.init = True
    cls.__dataclass_params__.eq = eq
    methods = {name: vars(_Methods)[name] for name in ("__setattr__", "__delattr__", "__setstate__", "__repr__")}
    methods["__init__"] = _init(cls)
    if eq:
        methods |= _compared(cls)
    for name in methods.keys() - own:
        setattr(cls, name, methods[name])
    return update_abstractmethods(cls)


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:
    dataclass = _dataclass


def _extend(cls: Any, kw_only: bool) -> None:
    """Give a class its fields, behind those of what it extends.

    Its own are found in a class that extends nothing: in one that does, :mod:`dataclasses` would compile what refuses
    changes anew.
    """
    hints = vars(cls).get("__annotations__", {})
    content = {name: value for name, value in vars(cls).items() if isinstance(value, dataclasses.Field)}
    content |= {name: getattr(cls, name) for name in hints if hasattr(cls, name)}
    alone: Any = type(cls.__name__, (), {**content, "__annotations__": hints, "__module__": cls.__module__})
    alone.__doc__ = cls.__doc__
    dataclasses.dataclass(alone, init=False, repr=False, eq=False, kw_only=kw_only)
    for name in [name for name in hints if isinstance(getattr(cls, name, None), dataclasses.Field)]:
        if name in vars(alone):
            setattr(cls, name, vars(alone)[name])
        else:
            delattr(cls, name)
    found: dict[str, Any] = {}
    for base in reversed(_extended(cls)):
        found |= base.__dataclass_fields__
    cls.__dataclass_fields__ = found | alone.__dataclass_fields__
    cls.__dataclass_params__ = alone.__dataclass_params__
    if "__match_args__" not in vars(cls):
        cls.__match_args__ = tuple(item.name for item in fields(cls) if item.init and not item.kw_only)


def _is_beyond(cls: type) -> bool:
    """Whether a class has what only :mod:`dataclasses` does."""
    bases = _extended(cls)
    hints = [*vars(cls).get("__annotations__", {}).values()]
    hints += [item.type for base in bases for item in base.__dataclass_fields__.values()]
    own = "__setattr__" in vars(cls) or "__delattr__" in vars(cls) or any("InitVar" in str(hint) for hint in hints)
    return own or any(not base.__dataclass_params__.frozen for base in bases)


def _extended(cls: type) -> list[Any]:
    """The data classes that a class extends, the nearest first."""
    return [base for base in cls.__mro__[1:] if dataclasses.is_dataclass(base)]


def _init(cls: Any) -> Callable[..., None]:
    """The ``__init__`` of a class: the code of :func:`_like_this` with other parameters."""
    taken = sorted((item for item in fields(cls) if item.init), key=lambda item: bool(item.kw_only))
    places = [item for item in taken if not item.kw_only]
    defaults = {item.name: _default(item) for item in taken if _default(item) is not dataclasses.MISSING}
    for item, following in pairwise(places):
        if item.name in defaults and following.name not in defaults:
            raise TypeError(f"non-default argument {following.name!r} follows default argument")
    this = "self" if all(item.name != "self" for item in taken) else "__dataclass_self__"
    names = (this, *(item.name for item in taken))
    filling, like = _Filling(cls, this), _like_this.__code__
    code = like.replace(
        co_name="__init__",
        co_qualname=f"{cls.__qualname__}.__init__",
        co_argcount=1 + len(places),
        co_kwonlyargcount=len(taken) - len(places),
        co_nlocals=len(names),
        co_varnames=names,
        co_consts=tuple(filling if value == "filling" else value for value in like.co_consts),
    )
    by_place = tuple(defaults.pop(item.name) for item in places if item.name in defaults)
    names_there = vars(sys.modules[cls.__module__]) if cls.__module__ in sys.modules else {}
    init = FunctionType(code, names_there, "__init__", by_place)
    init.__kwdefaults__ = defaults or None
    init.__annotations__ = {item.name: item.type for item in taken} | {"return": None}
    init.__module__, init.__qualname__ = cls.__module__, code.co_qualname
    return init


def _like_this(self: Any) -> None:
    "filling".fill(self, "filling".locals())  # pyright: ignore[reportAttributeAccessIssue]


class _Filling:
    """What the ``__init__`` of a class does with its arguments."""

    locals = staticmethod(locals)

    def __init__(self, cls: type, this: str) -> None:
        self._this = this
        factories = ((item.name, item.default_factory) for item in fields(cls))
        self._factories = [(name, made) for name, made in factories if made is not dataclasses.MISSING]
        self._finished = hasattr(cls, "__post_init__")

    def fill(self, made: Any, values: dict[str, Any]) -> None:
        """Give a new instance its fields; ``values`` holds its arguments, itself among them."""
        values = values.copy()  # a debugger that looks at the caller writes into what locals() gave
        del values[self._this]
        for name, factory in self._factories:
            if values.get(name, _FACTORY) is _FACTORY:
                values[name] = factory()
        for name, value in values.items():
            object.__setattr__(made, name, value)
        if self._finished:
            made.__post_init__()


class _Factory:
    """Stands in a signature for what is made anew."""

    def __repr__(self) -> str:
        return "<factory>"

    def __reduce__(self) -> str:
        return "_FACTORY"


_FACTORY = _Factory()


def _default(item: dataclasses.Field[Any]) -> Any:
    return item.default if item.default_factory is dataclasses.MISSING else _FACTORY


class _Methods:
    """Those that are the same for all."""

    def __setattr__(self: Any, name: str, value: object) -> None:
        if "__dataclass_fields__" in vars(type(self)) or name in self.__dataclass_fields__:
            raise FrozenInstanceError(f"cannot assign to field {name!r}")
        object.__setattr__(self, name, value)

    def __delattr__(self: Any, name: str) -> None:
        if "__dataclass_fields__" in vars(type(self)) or name in self.__dataclass_fields__:
            raise FrozenInstanceError(f"cannot delete field {name!r}")
        object.__delattr__(self, name)

    def __setstate__(self: Any, state: dict[str, Any]) -> None:
        """Fill a copy, of ``copy`` or ``pickle``: its arrays are read-only, too."""
        for name, value in state.items():
            if hasattr(value, "setflags"):
                value.setflags(write=False)
            object.__setattr__(self, name, value)

    @recursive_repr()
    def __repr__(self: Any) -> str:
        shown = ", ".join(f"{item.name}={getattr(self, item.name)!r}" for item in fields(self) if item.repr)
        return f"{type(self).__qualname__}({shown})"


def _compared(cls: Any) -> dict[str, Callable[..., Any]]:
    """How the instances of a class are compared and hashed."""
    content = attrgetter("__class__", *(item.name for item in fields(cls) if item.compare))
    hashed = attrgetter(
        "__class__", *(item.name for item in fields(cls) if (item.compare if item.hash is None else item.hash))
    )

    def __eq__(self: Any, other: object) -> bool:
        return content(self) == content(other) if type(other) is type(self) else NotImplemented

    def __hash__(self: Any) -> int:
        return hash(hashed(self))

    return {"__eq__": __eq__, "__hash__": __hash__}
