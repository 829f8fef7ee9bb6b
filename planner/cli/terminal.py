"""What the terminal shows: lines, tables, progress. The one place that prints."""

import contextlib
import os
import sys
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self, TypeVar

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.table import Table

from planner.base.errors import printable
from planner.base.files import require_writable_folder
from planner.base.interrupts import StopRequest
from planner.base.progress import UNITS, Progress

T = TypeVar("T")
_OF_TEXT = "\n\t\x7f"  # the last one does nothing, and JSON that is printed may hold it


def say(text: str) -> None:
    """Text on standard output; what names and files bring in that would steer a terminal is escaped."""
    print(printable(text, _OF_TEXT), flush=True)  # through a pipe, too, the address of a page arrives at once


def complain(text: str) -> None:
    """One line on standard error; what names and files bring in that would break it or steer a terminal is escaped."""
    with contextlib.suppress(OSError):  # a full disk
        print(f"planner: {printable(text)}", file=sys.stderr, flush=True)


def open_in_browser(address: str, tell: Callable[[str], None]) -> None:
    """Open a page in the browser; where there is no screen, say where it is (a browser in the terminal would block)."""
    screen = sys.platform != "linux" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    if not (screen and webbrowser.open(address)):
        tell(f"There is no browser here: open {address} yourself.")


def release_output() -> None:
    """Lead standard output nowhere if it cannot be written, or Python would fail once more when it ends."""
    try:
        sys.stdout.flush()
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def facts(title: str, rows: Iterable[tuple[str, str]]) -> Table:
    """Names and what is to be said of them, under a title."""
    table = Table("", "", title=_cell(title), show_header=False)
    for name, value in rows:
        table.add_row(_cell(name), _cell(value))
    return table


def _cell(text: str) -> str:
    """Text as rich shows it as it is."""
    return escape(printable(text, _OF_TEXT))


def show(renderable: Any) -> None:
    Console(soft_wrap=not sys.stdout.isatty()).print(renderable)


@contextmanager
def working() -> Iterator[Progress]:
    """Long work: a progress bar per stage on standard error, and Ctrl-C as a request to stop and save.

    Yields what the work reports to. Enter it where the work begins, and leave it when all is saved.
    """
    stages = _Stages()
    with StopRequest(drawn=lambda: len(stages.drawn)) as stop, stages:
        yield Progress(stages.report, stop)


@contextmanager
def watching() -> Iterator[Progress]:
    """Work that has nothing to save: progress bars only, Ctrl-C ends it at once."""
    with _Stages() as stages:
        yield Progress(stages.report)


def run_into(folder: Path, run: Callable[[Progress], T]) -> T:
    """The result of long work that is to be written into ``folder``, which is refused before the work begins."""
    require_writable_folder(folder)
    with working() as progress:
        return run(progress)


class _Stages:
    """A progress bar for each stage of work, drawn from its first report on."""

    def __init__(self) -> None:
        self.drawn: dict[str, Any] = {}  # rich's number of each stage
        self._bars: Bars | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._bars is not None:
            self._bars.live.transient = kind is not None  # an error is one sentence, with no bar above it
            self._bars.stop()

    def report(self, stage: str, done: int, total: int) -> None:
        """Draw the bar of a stage; see :class:`planner.base.progress.Progress`."""
        if self._bars is None:
            columns = TextColumn("{task.description:13}"), BarColumn(), TextColumn("{task.fields[count]:18}")
            self._bars = Bars(*columns, TimeElapsedColumn(), console=Console(stderr=True))
            self._bars.start()
        if stage not in self.drawn:
            self.drawn[stage] = self._bars.add_task(stage, total=None, count="", before=0, last=0)
        bar = self._bars.tasks[self.drawn[stage]]
        before, last = bar.fields["before"], bar.fields["last"]
        before += last if done < last else 0  # the stage begins again, and its bar goes on
        whole = before + total if total else None
        count = f"{before + done}{f'/{whole}' if whole else ''} {UNITS.get(stage, '')}"
        self._bars.update(bar.id, completed=before + done, total=whole, count=count, before=before, last=done)


def report_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A report's table as the terminal shows it."""
    table = Table(*map(_cell, rows[0]))
    for row in rows:
        table.add_row(*(_cell(_text_of(value)) for value in row.values()))
    return table


def _text_of(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.5g}" if isinstance(value, float) else str(value)
