"""What an experiment hands back: a table, verdicts on the paper's sentences, figures; and how it is written."""

from __future__ import annotations

import importlib.util
import io
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np

from planner.base.errors import FileError, OptionError
from planner.base.files import make_folder, write_json, write_whole
from planner.base.versions import versions

Row: TypeAlias = Mapping[str, Any]
"""One line of a table: column names to numbers, texts or None."""

_DPI = 200

_DECISIVE = ("python", "gabf-planner", "numpy", "scipy")


class Picture(Protocol):
    """A figure that can write itself, as matplotlib's does."""

    def savefig(self, fname: Any, **options: Any) -> Any: ...


@dataclass(frozen=True)
class Verdict:
    """A sentence of the paper, in how many of the cases tried it held, and the numbers behind that.

    A sentence that the paper does not print, but that follows from trying it, is marked "(ours)".
    """

    sentence: str
    confirmed: int
    of: int
    note: str

    @property
    def holds(self) -> bool:
        """True in every case tried, of which there was at least one."""
        return 0 < self.of == self.confirmed


@dataclass(frozen=True, eq=False)
class Report:
    """The result of one experiment. ``figures`` by file name, ``more``: further keys of the JSON file.

    ``config`` is what the experiment was asked for, enough to run it again; ``complete`` is False where it was
    interrupted, so that the table and the verdicts speak of less than was asked for.
    """

    name: str
    config: Mapping[str, Any]
    table: tuple[Row, ...]
    verdicts: tuple[Verdict, ...]
    figures: Mapping[str, Picture] = field(default_factory=dict)
    more: Mapping[str, Any] = field(default_factory=dict)
    complete: bool = True

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; numbers that are not finite become None."""
        record = {
            "experiment": self.name,
            "complete": self.complete,
            "config": dict(self.config),
            "versions": versions(_DECISIVE),
            "table": [dict(row) for row in self.table],
            "verdicts": [asdict(verdict) for verdict in self.verdicts],
            "figures": list(self.figures),
            **self.more,
        }
        return _plain(record)


def tally(sentence: str, cases: Iterable[bool], note: str) -> Verdict:
    """A verdict from one truth value a case."""
    held = [bool(case) for case in cases]
    return Verdict(sentence, sum(held), len(held), note)


def spread(values: Iterable[float], form: str = ".3g") -> str:
    """Median and range as a note says them: "1.2 (0.9 to 3)"."""
    data = np.array(list(values))
    if not data.size:
        return "none"
    return f"{np.median(data):{form}} ({data.min():{form}} to {data.max():{form}})"


def write_report(report: Report, folder: Path) -> list[Path]:
    """Write the figures as PNG and ``<name>.json`` under ``folder``, each whole or not at all; returns the paths.

    The JSON file comes last, so that the figures it lists are there. :class:`FileError` where a file cannot be
    written.
    """
    make_folder(folder)
    paths = []
    for name, figure in report.figures.items():
        image = io.BytesIO()
        figure.savefig(image, format="png", dpi=_DPI)
        write_whole(folder / name, image.getvalue())
        paths.append(folder / name)
    write_json(folder / f"{report.name}.json", report.to_dict())
    return [*paths, folder / f"{report.name}.json"]


def require_counts(**counts: int) -> None:
    """Refuse counts, by their option's name, that are below 1; :class:`OptionError`."""
    for name, count in counts.items():
        if count < 1:
            raise OptionError(f"{name} must be at least 1, not {count}.")


def require_figures() -> None:
    """Refuse before the work starts where matplotlib is not installed; :class:`FileError`."""
    if importlib.util.find_spec("matplotlib") is None:
        raise FileError("figures need matplotlib, which is not installed: pip install 'gabf-planner[figures]'.")


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def or_infinite(value: float | None) -> float:
    """A time that was not reached, None, is +inf."""
    return np.inf if value is None else value
