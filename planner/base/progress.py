"""Progress of long work: reports per stage, requests to stop, and seconds per stage."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType

Report = Callable[[str, int, int], None]

_COUNTED = {  # by unit, the stages of work that count it
    "steps": ("setup", "files"),
    "motions": ("first path", "shorter paths", "proofs", "timing"),
    "nodes": ("roadmap",),
    "edges": ("links", "clearance", "edges"),
    "rounds": ("improve",),
    "looks": ("second look", "contacts"),
    "pieces": ("nearest",),
    "paths": ("path", "modes"),
    "%": ("beta", "other betas"),
    "rungs": ("ladder",),
    "tries": ("grasps",),
    "plans": ("plans",),
}
UNITS = {stage: unit for unit, stages in _COUNTED.items() for stage in stages}


class Progress:
    """Takes reports of long work, and holds the request to stop.

        progress = Progress(report=print, stop=stop_request)
        progress("links", 3, 10)          # in the unit of the stage, see ``UNITS``
        if progress.stopped: ...          # return the partial result soon

    A stage ends when ``done`` is ``total``, and may begin again at 0. ``total`` is 0 if the end is not known. Work
    without a name of its stage reports nothing. No exception stops the work, as it must not pass OMPL's C++.
    """

    def __init__(self, report: Report | None = None, stop: Callable[[], bool] | None = None) -> None:
        self._report, self._stop = report, stop

    def __call__(self, stage: str, done: int, total: int) -> None:
        if self._report is not None and stage:
            self._report(stage, done, total)

    @property
    def stopped(self) -> bool:
        return self._stop is not None and self._stop()

    def with_report(self, report: Report) -> Progress:
        """Return a progress with another ``report`` and the same request to stop."""
        return Progress(report, self._stop)


QUIET = Progress()


class Stopwatch:
    """Seconds per stage, summed if a stage is entered again; ``seconds`` are those of earlier stages."""

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
        """Return the seconds of every stage, and the ``total`` since the first one began."""
        return round_seconds(self.seconds | {"total": time.perf_counter() - self._began})


def round_seconds(seconds: dict[str, float]) -> dict[str, float]:
    """Round seconds per stage to the microsecond, as records hold them."""
    return {stage: round(value, 6) for stage, value in seconds.items()}
