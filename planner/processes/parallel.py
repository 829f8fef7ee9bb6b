"""Several cases measured at once: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import concurrent.futures as cf
import itertools
import os
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeAlias, TypeVar

from planner.base.cluster import StopSignal, cluster
from planner.base.errors import InstallationError
from planner.base.progress import Progress
from planner.base.versions import versions
from planner.problem.request import WorkersRequest
from planner.processes.apart import call_apart
from planner.processes.source import source_hash

C = TypeVar("C")
T = TypeVar("T")
Measure: TypeAlias = Callable[[C, Progress], T]

_LOOK_EVERY = 0.1  # s: how soon a request to stop is seen
_LAST_CALL = 30.0  # s that tasks have to end in once they are asked to stop


def measured_cases(
    cases: Sequence[C], measure: Measure[C, T], workers: WorkersRequest, progress: Progress, isolated: bool = False
) -> Iterator[tuple[int, T]]:
    """(index, ``measure(case, progress)``) of each case as soon as it is there.

    With one job that is a plain loop. Else each case has a process of its own, so that one that is killed takes no
    other with it; it is then run once more (:func:`planner.processes.apart.call_apart`). ``isolated`` says that
    ``measure`` starts that process itself. ``measure`` and the cases have to be fit for pickling. No case is begun once
    ``progress`` is stopped; what a case that is cut off by that returns is ``measure``'s own affair.
    """
    if workers.serial:
        for k, case in enumerate(cases):
            if progress.stopped:
                return
            yield k, measure(case, progress)
        return
    function = measure if isolated else partial(call_apart, measure)
    with _pool(function, workers, progress) as pool:
        yield from pool.finished(cases, progress)


@dataclass(frozen=True)
class _Pool(Generic[C, T]):
    """What begins a case, how many may run at once, and what asks those that run elsewhere to stop."""

    submit: Callable[[C], cf.Future[T]]
    at_once: int
    stop: Callable[[], None]

    def finished(self, cases: Sequence[C], progress: Progress) -> Iterator[tuple[int, T]]:
        """The cases as they end; none is begun once ``progress`` is stopped."""
        waiting, running = iter(enumerate(cases)), {}
        while not progress.stopped:
            for k, case in itertools.islice(waiting, self.at_once - len(running)):
                running[self.submit(case)] = k
            if not running:
                return
            done, _ = cf.wait(running, _LOOK_EVERY, cf.FIRST_COMPLETED)
            for future in done:
                yield running.pop(future), future.result()
        self.stop()
        for future in cf.wait(running, _LAST_CALL).done:
            yield running[future], future.result()


@contextmanager
def _pool(function: Measure[C, T], workers: WorkersRequest, progress: Progress) -> Iterator[_Pool[C, T]]:
    if workers.scheduler is None:
        jobs = workers.jobs or 1
        with cf.ThreadPoolExecutor(jobs) as threads:  # each waits for its process
            yield _Pool(lambda case: threads.submit(function, case, progress), jobs, lambda: None)
        return
    with cluster(workers.scheduler) as found, found.executor() as remote:
        task = partial(_on_worker, function, _here(), found.signal)
        yield _Pool(lambda case: remote.submit(task, case), workers.jobs or found.threads, found.stop)


def _here() -> dict[str, object]:
    """What a worker has to have in common with the command: software, and the folder of files."""
    return {"source": source_hash(), **versions(), "folder": os.getcwd()}


def _on_worker(function: Measure[C, T], wanted: dict[str, object], signal: StopSignal, case: C) -> T:
    """What a worker of a cluster does."""
    differs = [f"{name} {value}" for name, value in _here().items() if value != wanted.get(name)]
    if differs:
        raise InstallationError(
            f"worker {socket.gethostname()} has {', '.join(differs)}, unlike this command: install the same planner "
            "there, and start the worker in the same, shared folder."
        )
    return function(case, signal.progress())
