"""Parallel cases, by processes of this machine (joblib's loky) or by workers of a Dask cluster."""

import concurrent.futures as cf
import logging
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any, TypeAlias, TypeVar

from planner.base.errors import FileError, InstallationError, require_extra
from planner.base.progress import Progress
from planner.base.resources import software
from planner.problem.request import WorkersRequest

C = TypeVar("C")
T = TypeVar("T")
Measure: TypeAlias = Callable[[C, Progress], T]
Executor: TypeAlias = tuple[cf.Executor, int, type[Exception]]  # its number of workers, and the error after a death

_ANSWER, _WORKERS = 10, 60  # s for a Dask scheduler to answer, and for a worker to start, the first or after a death
_IDLE = 10  # s after which a worker without work ends, also where this process was killed
_ONE_AT_A_TIME = threading.Lock()  # OMPL has one seed per process, and a Dask worker may have several threads


def measure_cases(
    cases: Sequence[C], measure: Measure[C, T], workers: WorkersRequest, progress: Progress
) -> Iterator[tuple[int, T | None]]:
    """Yield (index, ``measure(case, progress)``) as cases end, (index, None) if a case kills its worker.

    One job is a loop in this process; otherwise all arguments are pickled. After the death of a worker its cases run
    again, one at a time: the case whose worker dies again is at fault. After a stop of ``progress`` no case begins, and
    the workers of this machine end.
    """
    waiting = deque(enumerate(cases))
    if workers.serial:
        while waiting and not progress.stopped:
            k, case = waiting.popleft()
            yield k, measure(case, progress)
        return
    while waiting and not progress.stopped:
        for suspect in (yield from _measure_at_once(waiting, measure, workers, progress)):
            died = yield from _measure_at_once(deque([suspect]), measure, workers, progress)
            yield from ((k, None) for k, _ in died)


def _measure_at_once(
    waiting: deque[tuple[int, C]], measure: Measure[C, T], workers: WorkersRequest, progress: Progress
) -> Generator[tuple[int, T], None, list[tuple[int, C]]]:
    """Yield the results until a worker dies or all are complete; return the cases that ran then."""
    running: dict[cf.Future[T], tuple[int, C]] = {}
    died: list[tuple[int, C]] = []
    call = partial(_call, measure, None if workers.workers else os.getpid())
    with _executor(workers, len(waiting)) as (executor, at_once, death):
        while not progress.stopped:
            with suppress(death):  # a worker that died since; cases that ran then fail below
                while waiting and not died and len(running) < at_once:
                    running[executor.submit(call, waiting[0][1])] = waiting[0]
                    waiting.popleft()
            if not running:
                break
            for future in cf.wait(running, 0.1, cf.FIRST_COMPLETED).done:
                k, case = running.pop(future)
                try:
                    yield k, future.result()
                except death:
                    died.append((k, case))
    return died


def _call(measure: Measure[C, T], parent: int | None, case: C) -> T:
    """Measure a case in a worker; a worker of this machine stops when its parent process has ended."""
    with _ONE_AT_A_TIME:
        return measure(case, Progress(stop=lambda: parent not in (None, os.getppid())))


@contextmanager
def _executor(workers: WorkersRequest, cases: int) -> Iterator[Executor]:
    if workers.workers:
        with _cluster(workers.workers.removeprefix("dask:")) as cluster:
            yield cluster
        return
    from joblib.externals.loky import ProcessPoolExecutor  # Parallel loses results when a worker dies

    jobs = min(workers.jobs, cases)
    ignoring = {"initializer": signal.signal, "initargs": (signal.SIGINT, signal.SIG_IGN)}  # Ctrl-C is for the command
    executor = ProcessPoolExecutor(jobs, timeout=_IDLE, **ignoring)
    try:
        yield executor, jobs, cf.BrokenExecutor
    finally:
        executor.shutdown(kill_workers=True)


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    """Connect to a Dask scheduler; joblib's Dask backend hangs when a task kills its worker."""
    require_extra("distributed", "cluster")  # here, and where the workers are
    from distributed import Client, KilledWorker
    from distributed.comm.addressing import get_address_host_port

    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # a scheduler that goes away is one sentence
    missing = f"no Dask scheduler with workers answers at '{address}': start 'dask scheduler', 'dask worker'."
    try:
        get_address_host_port(address)  # a Client takes 20 s to refuse a text that is not an address
        client: Any = Client(address, timeout=_ANSWER, set_as_default=False)
    except (OSError, ValueError):
        raise FileError(missing) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=_WORKERS)
        except TimeoutError:
            raise FileError(missing) from None
        there = list(client.run(_here, on_error="return").values())
        if other := next((each for each in there if each != _here()), None):
            raise InstallationError(
                f"workers of {address} must have {_here()}, got {other!r}: install the same planner there, and give "
                f"'dask worker {address}' in the same, shared folder."
            )
        try:
            yield client.get_executor(pure=False), len(there), KilledWorker
        except cf.CancelledError:
            raise FileError(f"the Dask scheduler at {address} went away: start it, and repeat the command.") from None


def _here() -> str:
    return f"{software()} in {os.getcwd()}"
