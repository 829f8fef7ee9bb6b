"""The errors that this package raises, notes on input, and text for messages.

A message is one sentence built from the data: the fault, its place and the remedy.
"""

import importlib
import logging
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar

LOGGER = "planner.notes"  # the command line prints what it logs
_LONGEST_NAME, _MOST_NAMES = 200, 50  # characters, names: a sentence stays one


@dataclass(frozen=True)
class Reason:
    """Base of all reasons: ``plan.json`` holds the fields, and their docstrings are the schema."""

    __pydantic_config__: ClassVar = {"extra": "allow", "allow_inf_nan": False, "use_attribute_docstrings": True}

    kind: str = field(kw_only=True)

    def to_dict(self) -> dict[str, Any]:
        """Return the kind, then the other fields, as plain data."""
        return asdict(self)

    @property
    def names(self) -> frozenset[str]:
        """The links and obstacles at fault, which a page draws red."""
        return frozenset(getattr(self, "obstacles", ()))

    @property
    def sentence(self) -> str:
        """The reason and a remedy; empty if the message of the error has both."""
        return ""


class PlannerError(Exception):
    """Base of the errors of this package: robot, scene, state or file cannot be used.

    ``reason`` is the cause as data, or None: a contact, a limit that is exceeded.
    """

    exit_code = 3

    def __init__(self, message: str = "", reason: Reason | None = None) -> None:
        super().__init__(message)
        self.reason = reason


class OptionError(PlannerError):
    """A value outside an option's own range, for any robot or scene."""

    exit_code = 2


class KeywordError(OptionError, TypeError):
    """An option that a function does not have."""


class RobotError(PlannerError):
    """A robot that cannot be found or loaded, or a frame or joint that it lacks."""


class SceneError(PlannerError):
    """A scene that cannot be found or read, or an obstacle that cannot be used."""


class StateError(PlannerError):
    """A start or goal that is malformed, out of limits, in collision or out of reach."""


class FileError(PlannerError):
    """A file that is missing, damaged, of another format, or cannot be written."""


class ArrayError(PlannerError, ValueError):
    """An array of a wrong shape, or with values that a function cannot use."""


class AssumptionError(PlannerError):
    """Data that break an assumption of the paper, without which the theorem does not hold."""


class InstallationError(PlannerError):
    """A package that is missing or of another version."""


def require_extra(module: str, extra: str) -> Any:
    """Import a module of an ``extra`` of this package; :class:`InstallationError` if it is missing."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        missing = f"the Python package {error.name or module} is missing"
        raise InstallationError(f"{missing}: run pip install 'gabf-planner[{extra}]'.") from None


@dataclass(frozen=True)
class Note:
    """A sentence about a model or a file; ``grave`` if a plan may be wrong because of it."""

    text: str
    grave: bool = True


def log_notes(*notes: str) -> None:
    """Log notes at DEBUG: a caller of the library reads them in the result."""
    for note in notes:
        logging.getLogger(LOGGER).debug("%s", note)


def format_quantity(value: float, unit: str) -> str:
    """Return a length or an angle >= 0 as text, with three digits and an SI prefix."""
    for least, size, prefix in ((0.1, 1.0, ""), (1e-3, 1e-3, "m"), (1e-6, 1e-6, "µ"), (1e-9, 1e-9, "n")):
        if value >= least:
            return f"{value / size:.3g} {prefix}{unit}"
    return f"{value:.1g} {unit}"


def choices(names: Iterable[object]) -> str:
    """Return names for a message: "a, b, c"; long names and lists are cut."""
    listed = [str(name)[:_LONGEST_NAME] for name in names]
    more = f" and {len(listed) - _MOST_NAMES} more" if len(listed) > _MOST_NAMES else ""
    return ", ".join(listed[:_MOST_NAMES]) + more or "none"


def printable(text: str, allowed: str = "") -> str:
    """Return ``text`` with control characters escaped, except ``allowed``, to protect the terminal."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in allowed else c.encode("unicode_escape").decode() for c in text)
