"""Progress of long work: what it reports, whether it is asked to stop, Ctrl-C as such a request, seconds per stage."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType, MappingProxyType, TracebackType

from planner.base.interrupts import leave, stop_requests, tell_at_once

Report = Callable[[str, int, int], None]


class Progress:
    """What long work reports to, and asks whether it is to stop.

        progress = Progress(report=print, stop=stop_request)
        progress("links", 3, 10)          # called with (stage, done, total)
        if progress.stopped: ...          # end as soon as possible and hand back what there is

    ``report`` is called with (stage, done, total), ``stop`` tells whether somebody has asked to stop. Stopping is
    asked for, never raised: an exception must not fly through OMPL's C++.
    """

    def __init__(self, report: Report | None = None, stop: Callable[[], bool] | None = None) -> None:
        self._report, self._stop = report, stop

    def __call__(self, stage: str, done: int, total: int) -> None:
        if self._report is not None:
            self._report(stage, done, total)

    @property
    def stopped(self) -> bool:
        return self._stop is not None and self._stop()

    def renamed(self, report: Report) -> Progress:
        """Another report under the same request to stop."""
        return Progress(report, self._stop)


QUIET = Progress()


_SAVING = (
    "stopping, saving what there is (Ctrl-C twice more: leave without saving).",
    "still saving (Ctrl-C once more: leave without saving).",
)


class StopRequest:
    """While entered, SIGINT only sets a flag and says so; calling the object tells whether the flag is set.

    As long as nobody has called it there is nothing to save, and SIGINT does what it did before. The second one is told
    to wait, the third ends the process. ``drawn`` tells how many lines of progress are on the terminal.
    """

    def __init__(self, drawn: Callable[[], int] = lambda: 1) -> None:
        self._presses, self._called, self._drawn = 0, False, drawn
        self._previous = None

    def __call__(self) -> bool:
        self._called = True
        return self._presses > 0

    def __enter__(self) -> StopRequest:
        if threading.current_thread() is threading.main_thread():
            self._previous = signal.signal(signal.SIGINT, self._handle)
            stop_requests.append(self._pressed)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._previous is not None:
            signal.signal(signal.SIGINT, self._previous)
            stop_requests.remove(self._pressed)

    def _pressed(self) -> bool:
        return self._presses > 0

    def _handle(self, signum: int, frame: FrameType | None) -> None:
        if not self._called and callable(self._previous):
            self._previous(signum, frame)
        self._presses += 1
        if self._presses > 2:
            leave("left without saving.")
        tell_at_once(_SAVING[self._presses - 1], self._drawn())


class Stopwatch:
    """Seconds per stage, summed where a stage is entered again; ``seconds`` are of stages that have just passed."""

    def __init__(self, seconds: Mapping[str, float] = MappingProxyType({})) -> None:
        self.seconds = dict(seconds)
        self._began = time.perf_counter() - sum(seconds.values())

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - begin

    def record(self) -> dict[str, float]:
        """The seconds of every stage, and the ``total`` since the first began, with all between."""
        return rounded(self.seconds | {"total": time.perf_counter() - self._began})


def rounded(seconds: dict[str, float]) -> dict[str, float]:
    """Seconds per stage, to the microsecond, as records hold them."""
    return {stage: round(value, 6) for stage, value in seconds.items()}
