"""Progress of long work: what it reports, whether it is asked to stop, and seconds per stage."""

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
    """What long work reports to, and asks whether it is to stop.

        progress = Progress(report=print, stop=stop_request)
        progress("links", 3, 10)          # called with (stage, done, total), in the stage's unit of ``UNITS``
        if progress.stopped: ...          # end as soon as possible and hand back the partial result

    A stage ends with all of ``total`` done and may begin again, with 0; where its end is not known ``total`` is 0.
    Work without a name for its stage reports nothing.
    Stopping is asked for, never raised: an exception must not fly through OMPL's C++.
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
        """Another report under the same request to stop."""
        return Progress(report, self._stop)


QUIET = Progress()


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
        return round_seconds(self.seconds | {"total": time.perf_counter() - self._began})


def round_seconds(seconds: dict[str, float]) -> dict[str, float]:
    """Seconds per stage, to the microsecond, as records hold them."""
    return {stage: round(value, 6) for stage, value in seconds.items()}
