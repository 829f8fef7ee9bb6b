"""Several cases measured at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import TypeVar

from planner.base.errors import OptionError
from planner.base.progress import Progress

C = TypeVar("C")
T = TypeVar("T")


def require_jobs(jobs: int) -> None:
    """Raise :class:`OptionError` unless so many cases can be measured at once."""
    if not 1 <= jobs <= 10_000:
        raise OptionError(f"{jobs} jobs are not usable: give a whole number from 1 to 10000.")


def measured_cases(
    cases: Sequence[C], measure: Callable[[C], T], jobs: int, progress: Progress
) -> Iterator[tuple[int, T]]:
    """(index, result) of each case as soon as it is there, ``jobs`` of them at once.

    With more than one job ``measure`` runs in threads, so it has to leave the work to a process of its own, as
    :func:`planner.studies.process.run_module` does: one that is killed takes no other with it. No case is begun once
    ``progress`` is stopped.
    """

    def begun(case: C) -> list[T]:
        return [] if progress.stopped else [measure(case)]

    if jobs == 1:
        for k, case in enumerate(cases):
            for result in begun(case):
                yield k, result
        return
    with ThreadPoolExecutor(jobs) as pool:
        running = {pool.submit(begun, case): k for k, case in enumerate(cases)}
        try:
            for future in as_completed(running):
                for result in future.result():
                    yield running[future], result
        finally:
            pool.shutdown(cancel_futures=True)
