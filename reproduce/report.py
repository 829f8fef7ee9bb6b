"""The result of a simulation: a table, verdicts on the paper's sentences, figures; and its files."""

from __future__ import annotations

import io
import math
import multiprocessing
import signal
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np

from planner.base.errors import OptionError
from planner.base.files import make_folder, write_json, write_whole
from planner.base.progress import Progress
from planner.base.resources import versions
from reproduce.figures import Figure
from reproduce.verdict import Verdict, tally

C = TypeVar("C")
T = TypeVar("T")

Row: TypeAlias = Mapping[str, Any]
"""One line of a table: column names to numbers, texts or None."""

_DPI = 200
_DECISIVE = ("python", "gabf-planner", "numpy", "scipy")


@dataclass(frozen=True)
class Claim(Generic[C]):
    """A sentence of the paper and its check on one case; a sentence of ours begins with "(ours)".

    Each "{}" of ``note`` stands for the median and the range over all cases of one of ``values``.
    """

    sentence: str
    holds: Callable[[C], bool]
    note: str = ""
    values: tuple[Callable[[C], float | Iterable[float]], ...] = ()


@dataclass(frozen=True)
class Spread:
    """Numbers that a format string shows by median and range: "1.2 (0.9 to 3)"."""

    values: tuple[float, ...]

    def __format__(self, form: str) -> str:
        if not self.values:
            return "none"
        middle, low, high = (
            f"{value:{form or '.3g'}}" for value in (np.median(self.values), min(self.values), max(self.values))
        )
        return middle if low == high else f"{middle} ({low} to {high})"


def judge(claims: Iterable[Claim[C]], cases: Sequence[C]) -> tuple[Verdict, ...]:
    """A verdict per claim, which counts the cases where it holds."""
    return tuple(
        tally(
            claim.sentence,
            map(claim.holds, cases),
            claim.note.format(*(Spread(tuple(_numbers(map(value, cases)))) for value in claim.values)),
        )
        for claim in claims
    )


def _numbers(values: Iterable[float | Iterable[float]]) -> Iterable[float]:
    for value in values:
        yield from value if isinstance(value, Iterable) else (value,)


@dataclass(frozen=True, eq=False)
class Report:
    """The result of one simulation. ``figures`` by file name, ``more``: further keys of the JSON file.

    ``config`` holds the options, enough to run it again; ``complete`` is False after an interruption, when table and
    verdicts cover fewer cases.
    """

    name: str
    config: Mapping[str, Any]
    table: tuple[Row, ...]
    verdicts: tuple[Verdict, ...]
    figures: Mapping[str, Figure] = field(default_factory=dict)
    more: Mapping[str, Any] = field(default_factory=dict)
    complete: bool = True

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; numbers that are not finite become None."""
        record = {
            "experiment": self.name,
            "complete": self.complete,
            "config": self.config,
            "versions": versions(_DECISIVE),
            "table": self.table,
            "verdicts": [asdict(verdict) for verdict in self.verdicts],
            "figures": list(self.figures),
            **self.more,
        }
        return _plain(record)


def write_report(report: Report, folder: Path) -> list[Path]:
    """Write the figures as PNG and then ``<name>.json`` under ``folder``; the paths. Raises FileError."""
    make_folder(folder)
    for name, figure in report.figures.items():
        image = io.BytesIO()
        figure.savefig(image, format="png", dpi=_DPI)
        write_whole(folder / name, image.getvalue())
    write_json(folder / f"{report.name}.json", report.to_dict())
    return [folder / name for name in (*report.figures, f"{report.name}.json")]


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def collect(function: Callable[[int], T], count: int, jobs: int, stage: str, progress: Progress) -> list[T]:
    """``function(k)`` for each k below ``count``, in ``jobs`` processes; those that are done where it is stopped."""
    for name, number in ((stage, count), ("jobs", jobs)):
        if number < 1:
            raise OptionError(f"{name} must be at least 1, got {number}.")
    progress(stage, 0, count)
    results: list[T] = []
    if jobs == 1:
        for k in range(count):
            if progress.stopped:
                break
            results.append(function(k))
            progress(stage, len(results), count)
        return results
    processes = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, processes, signal.signal, (signal.SIGINT, signal.SIG_IGN)) as pool:
        futures = [pool.submit(function, k) for k in range(count)]
        for future in futures:
            if progress.stopped:
                pool.shutdown(wait=True, cancel_futures=True)
            if not future.cancelled():
                results.append(future.result())
                progress(stage, len(results), count)
    return results


def or_infinite(value: float | None) -> float:
    """+inf for None, a time that was not reached."""
    return np.inf if value is None else value
