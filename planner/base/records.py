"""Frozen data classes that compile nothing when they are made.

:mod:`dataclasses` writes six methods of every class as text and compiles them: 0.4 ms a class, 0.15 s for those of a
plan, a fifth of the whole process. Here the methods are there once and look up what fields a class has. All else is as
there: ``fields``, ``replace``, ``match``, signatures, errors. What is not frozen, or has slots or an order, is made by
:mod:`dataclasses` itself.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from dataclasses import FrozenInstanceError, fields
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

_REQUIRED = object()


def _dataclass(cls: Any = None, /, *, frozen: bool = False, eq: bool = True, kw_only: bool = False, **more: Any) -> Any:
    """As :func:`dataclasses.dataclass`."""
    if cls is None:
        return lambda cls: _dataclass(cls, frozen=frozen, eq=eq, kw_only=kw_only, **more)
    if not frozen or more:
        return dataclasses.dataclass(cls, frozen=frozen, eq=eq, kw_only=kw_only, **more)
    own = {name for name, member in vars(cls).items() if name != "__hash__" or member is not None}  # beside an __eq__
    extends = any(dataclasses.is_dataclass(base) for base in cls.__mro__[1:])
    cls.__doc__ = cls.__doc__ or cls.__name__  # else its signature is asked for, which takes longer than all else
    dataclasses.dataclass(cls, init=False, repr=False, eq=False, frozen=extends, kw_only=kw_only)
    cls.__dataclass_params__.frozen = cls.__dataclass_params__.repr = cls.__dataclass_params__.init = True
    cls.__dataclass_params__.eq = eq
    methods = {"__setattr__": _setattr, "__delattr__": _delattr, "__repr__": _repr, "__init__": _init(cls)}
    if eq:
        methods |= _compared(cls)
    for name, method in methods.items():
        if name not in own and not (extends and name in ("__setattr__", "__delattr__")):
            setattr(cls, name, method)
    if "__init__" not in own:
        cls.__signature__ = _Signature(methods["__init__"])
    return cls


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:
    dataclass = _dataclass


def _init(cls: type) -> Callable[..., None]:
    """The ``__init__`` of a class; ``parameters`` are those that may be given by place, and the others."""
    taken = [item for item in fields(cls) if item.init]
    places = tuple(item.name for item in taken if not item.kw_only)
    template = {item.name: _REQUIRED if item.default is dataclasses.MISSING else item.default for item in taken}
    factories = [(item.name, item.default_factory) for item in taken if item.default_factory is not dataclasses.MISSING]
    required = tuple({name for name, value in template.items() if value is _REQUIRED} - {name for name, _ in factories})
    count, finished = len(template), hasattr(cls, "__post_init__")

    def __init__(self: Any, /, *args: Any, **named: Any) -> None:
        values = template.copy()
        values.update(zip(places, args, strict=False))
        values.update(named)
        fits = len(values) == count and len(args) <= len(places)
        if args and named:
            fits = fits and named.keys().isdisjoint(places[: len(args)])
        for name in required:
            if values[name] is _REQUIRED:
                fits = False
        if not fits:
            raise _misfit(cls, args, named)
        for name, factory in factories:
            if values[name] is _REQUIRED:
                values[name] = factory()
        self.__dict__.update(values)
        if finished:
            self.__post_init__()

    vars(__init__)["parameters"] = ("self", *places), tuple(name for name in template if name not in places)
    __init__.__annotations__ = {item.name: item.type for item in taken} | {"return": None}
    __init__.__qualname__, __init__.__module__ = f"{cls.__qualname__}.__init__", cls.__module__
    return __init__


class _Signature:
    """The signature of a class as :mod:`inspect` asks for it, made then."""

    def __init__(self, init: Callable[..., None]) -> None:
        self._init = init

    def __get__(self, instance: object, owner: type) -> inspect.Signature:
        if instance is not None or inspect.unwrap(owner.__init__) is not self._init:
            raise AttributeError("__signature__")  # that of its own __init__, or none
        return _signature(owner)


def _signature(cls: type) -> inspect.Signature:
    taken = [_parameter(item) for item in fields(cls) if item.init]
    return inspect.Signature(sorted(taken, key=lambda parameter: parameter.kind))


def _parameter(item: dataclasses.Field[Any]) -> inspect.Parameter:
    kind = inspect.Parameter.KEYWORD_ONLY if item.kw_only is True else inspect.Parameter.POSITIONAL_OR_KEYWORD
    default = item.default if item.default_factory is dataclasses.MISSING else item.default_factory
    default = inspect.Parameter.empty if default is dataclasses.MISSING else default
    return inspect.Parameter(item.name, kind, default=default, annotation=item.type)


def _misfit(cls: type, args: tuple[Any, ...], named: dict[str, Any]) -> TypeError:
    """What Python says of arguments that do not fit a class."""
    try:
        _signature(cls).bind(*args, **named)
    except TypeError as error:
        return TypeError(f"{cls.__qualname__}() {error}")
    raise AssertionError("they fit")


def _setattr(self: Any, name: str, value: object) -> None:
    if "__dataclass_fields__" in vars(type(self)) or name in self.__dataclass_fields__:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")
    object.__setattr__(self, name, value)


def _delattr(self: Any, name: str) -> None:
    if "__dataclass_fields__" in vars(type(self)) or name in self.__dataclass_fields__:
        raise FrozenInstanceError(f"cannot delete field {name!r}")
    object.__delattr__(self, name)


@recursive_repr()
def _repr(self: Any) -> str:
    shown = ", ".join(f"{item.name}={getattr(self, item.name)!r}" for item in fields(self) if item.repr)
    return f"{type(self).__qualname__}({shown})"


def _compared(cls: type) -> dict[str, Callable[..., Any]]:
    """How the instances of a class are compared and hashed."""
    content = attrgetter("__class__", *(item.name for item in fields(cls) if item.compare))

    def __eq__(self: Any, other: object) -> bool:
        return content(self) == content(other) if type(other) is type(self) else NotImplemented

    return {"__eq__": __eq__, "__hash__": lambda self: hash(content(self))}
