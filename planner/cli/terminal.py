"""Output on the terminal: lines, tables, progress bars. No other module prints."""

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
_OF_TEXT = "\n\t\x7f"  # JSON may hold the last one, which does nothing


def say(text: str) -> None:
    """Print text on standard output, with control characters escaped."""
    print(
        printable(text, _OF_TEXT), flush=True
    )  # flush: the address of a page must arrive at once, also through a pipe


def complain(text: str) -> None:
    """Print one line on standard error, with line breaks and control characters escaped."""
    with contextlib.suppress(OSError):  # a full disk
        print(f"planner: {printable(text)}", file=sys.stderr, flush=True)


def open_in_browser(address: str, announce: Callable[[str], None]) -> None:
    """Open a page in the browser; without a screen print its address, as a text browser would block."""
    screen = sys.platform != "linux" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    if not (screen and webbrowser.open(address)):
        announce(f"No browser was found: open {address} yourself.")


def release_output() -> None:
    """Redirect standard output to nowhere if it is closed, or Python would fail again at its exit."""
    try:
        sys.stdout.flush()
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def facts(title: str, rows: Iterable[tuple[str, str]]) -> Table:
    """Return a table of names and texts under a title."""
    table = Table("", "", title=_cell(title), show_header=False)
    for name, value in rows:
        table.add_row(_cell(name), _cell(value))
    return table


def _cell(text: str) -> str:
    """Escape text for rich."""
    return escape(printable(text, _OF_TEXT))


def show(renderable: Any) -> None:
    Console(soft_wrap=not sys.stdout.isatty()).print(renderable)


@contextmanager
def working() -> Iterator[Progress]:
    """Yield a progress with a bar per stage on standard error, and with Ctrl-C as a request to stop.

    The block is the work and the saving of its result.
    """
    stages = _Stages()
    with StopRequest(drawn=lambda: len(stages.drawn)) as stop, stages:
        yield Progress(stages.report, stop)


@contextmanager
def watching() -> Iterator[Progress]:
    """Yield a progress with bars; Ctrl-C ends the work at once, as it has nothing to save."""
    with _Stages() as stages:
        yield Progress(stages.report)


def run_into(folder: Path, run: Callable[[Progress], T]) -> T:
    """Run long work whose result goes into ``folder``; an unusable folder is refused before the work."""
    require_writable_folder(folder)
    with working() as progress:
        return run(progress)


class _Stages:
    """A progress bar for each stage of work, from its first report on."""

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
        before += last if done < last else 0  # a stage that begins again continues its bar
        whole = before + total if total else None
        count = f"{before + done}{f'/{whole}' if whole else ''} {UNITS.get(stage, '')}"
        self._bars.update(bar.id, completed=before + done, total=whole, count=count, before=before, last=done)


def report_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Return the table of a report for the terminal."""
    table = Table(*map(_cell, rows[0]))
    for row in rows:
        table.add_row(*(_cell(_text_of(value)) for value in row.values()))
    return table


def _text_of(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.5g}" if isinstance(value, float) else str(value)
