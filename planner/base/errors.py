"""One base for every error this package raises, notes on input, and text for messages.

A message is one sentence built from the data: what is wrong, where, and the remedy.
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
    """Base of all reasons: a class is what ``plan.json`` holds of it, and its attributes' docstrings the schema."""

    __pydantic_config__: ClassVar = {"extra": "allow", "allow_inf_nan": False, "use_attribute_docstrings": True}

    kind: str = field(kw_only=True)

    def to_dict(self) -> dict[str, Any]:
        """The kind, then the other fields as plain data."""
        return asdict(self)

    @property
    def names(self) -> frozenset[str]:
        """The links and obstacles that it blames: a page draws them red."""
        return frozenset(getattr(self, "obstacles", ()))

    @property
    def sentence(self) -> str:
        """The reason and a remedy; empty where the error that carries the reason says both."""
        return ""


class PlannerError(Exception):
    """Anything that needs the robot, the scene or the disk to judge, and was judged unusable.

    ``reason`` says why as data, where there is such a thing to say: what touches, which limit is broken.
    """

    exit_code = 3

    def __init__(self, message: str = "", reason: Reason | None = None) -> None:
        super().__init__(message)
        self.reason = reason


class OptionError(PlannerError):
    """A number or a name outside an option's own range: wrong whatever the robot or the scene."""

    exit_code = 2


class KeywordError(OptionError, TypeError):
    """An option of a name that a function does not know."""


class RobotError(PlannerError):
    """A robot that cannot be found or loaded, or a frame or joint that it does not have."""


class SceneError(PlannerError):
    """A scene that cannot be found or read, or an obstacle that makes no sense."""


class StateError(PlannerError):
    """A start or goal that is malformed, out of limits, in collision or out of reach."""


class FileError(PlannerError):
    """A file that is missing, damaged, foreign, or cannot be written."""


class ArrayError(PlannerError, ValueError):
    """An array of another shape than a function takes, or with values that it cannot use."""


class AssumptionError(PlannerError):
    """An assumption of the paper that the given data breaks: the theorem would not hold."""


class InstallationError(PlannerError):
    """A part of the planner itself that is missing or of another version."""


def require_extra(module: str, extra: str) -> Any:
    """A module that the ``extra`` of this package brings; :class:`InstallationError` names that where it is missing."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        missing = f"the Python package {error.name or module} is missing"
        raise InstallationError(f"{missing}: run pip install 'gabf-planner[{extra}]'.") from None


@dataclass(frozen=True)
class Note:
    """A sentence about a model or a file; ``grave`` where a plan may well be wrong because of it."""

    text: str
    grave: bool = True


def log_notes(*notes: str) -> None:
    """Log notes that a result holds too: at DEBUG, as a library's caller reads them there."""
    for note in notes:
        logging.getLogger(LOGGER).debug("%s", note)


def format_quantity(value: float, unit: str) -> str:
    """A length or an angle, 0 or more, with three digits in a unit in which it does not look like zero."""
    for least, size, prefix in ((0.1, 1.0, ""), (1e-3, 1e-3, "m"), (1e-6, 1e-6, "µ"), (1e-9, 1e-9, "n")):
        if value >= least:
            return f"{value / size:.3g} {prefix}{unit}"
    return f"{value:.1g} {unit}"


def choices(names: Iterable[object]) -> str:
    """The valid choices as they stand in an error message: "a, b, c"; of very long names and lists their beginning."""
    listed = [str(name)[:_LONGEST_NAME] for name in names]
    more = f" and {len(listed) - _MOST_NAMES} more" if len(listed) > _MOST_NAMES else ""
    return ", ".join(listed[:_MOST_NAMES]) + more or "none"


def printable(text: str, keep: str = "") -> str:
    """``text`` with what is not printable escaped, so that no name steers a terminal; ``keep`` stays as it is."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode() for c in text)
