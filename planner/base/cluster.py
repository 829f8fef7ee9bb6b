"""The door to Dask: tasks on the workers of a cluster. Loads Dask when it is asked for a cluster."""

from __future__ import annotations

import concurrent.futures as cf
import logging
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from planner.base.errors import FileError, InstallationError, OptionError, PlannerError
from planner.base.progress import Progress

_SECONDS = 10.0  # to reach the scheduler within


@dataclass(frozen=True)
class StopSignal:
    """A flag on the scheduler that tasks ask for: a local Ctrl-C does not reach other machines."""

    name: str

    def progress(self) -> Progress:
        """For a task on a worker: it is stopped once the flag is set, and asks for it every second."""
        from distributed import Event  # pyright: ignore[reportMissingImports]

        flag, seen = Event(self.name), {"at": time.monotonic(), "set": False}

        def stopped() -> bool:
            if not seen["set"] and time.monotonic() - seen["at"] > 1.0:
                seen.update(at=time.monotonic(), set=flag.is_set())
            return bool(seen["set"])

        return Progress(stop=stopped)


class Cluster:
    """The workers of a Dask scheduler."""

    def __init__(self, client: Any) -> None:  # a Client: its methods are typed as those of an asynchronous one
        self._client = client
        self.signal = StopSignal(f"planner-stop-{uuid.uuid4().hex}")

    @property
    def threads(self) -> int:
        """Tasks that the cluster runs at once."""
        return sum(self._client.nthreads().values())

    def on_each(self, function: Callable[[], Any]) -> list[Any]:
        """What a function gives on every worker."""
        return list(self._client.run(function).values())

    def executor(self) -> cf.Executor:
        """Runs functions on the workers; those of a worker that dies run again on another one."""
        return self._client.get_executor(pure=False)

    def stop(self) -> None:
        """Set the flag that :attr:`signal` reads."""
        from distributed import Event  # pyright: ignore[reportMissingImports]

        Event(self.signal.name, client=self._client).set()


@contextmanager
def local_cluster(workers: int) -> Iterator[str]:
    """The address of a cluster of so many processes on 127.0.0.1, which end with the block."""
    from distributed import LocalCluster  # pyright: ignore[reportMissingImports]

    made: Any = LocalCluster
    with made(
        n_workers=workers,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
        silence_logs=logging.ERROR,
    ) as local:
        yield local.scheduler_address


@contextmanager
def cluster(address: str) -> Iterator[Cluster]:
    """The cluster whose scheduler listens at ``address`` ("tcp://127.0.0.1:8786").

    InstallationError where Dask is not installed, OptionError for text that is no address, FileError where nobody
    answers, or no longer, or no worker is there.
    """
    try:
        from distributed import Client, KilledWorker  # pyright: ignore[reportMissingImports]
        from distributed.comm.addressing import get_address_host_port  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InstallationError("a cluster needs Dask: pip install 'gabf-planner[cluster]', here and there.") from None
    logging.getLogger("distributed").setLevel(logging.ERROR)  # what it says while it closes is nobody's news
    try:
        get_address_host_port(address)  # a client that finds out what is wrong itself takes 20 s to close
        client = Client(address, timeout=_SECONDS, set_as_default=False, direct_to_workers=True)
    except ValueError as error:
        raise OptionError(f"scheduler '{address}' is no address ({error}): give one like tcp://host:8786.") from None
    except OSError:
        raise FileError(
            f"no Dask scheduler of this version answers at {address}: start one with 'dask scheduler', or mend "
            "the address."
        ) from None
    with client, client.as_current():
        workers = Cluster(client)
        if not workers.threads:
            raise FileError(f"the scheduler at {address} has no workers: start some with 'dask worker {address}'.")
        try:
            yield workers
        except KilledWorker as error:
            raise PlannerError(
                f"the cluster gave up on a task whose workers died one after the other: {error}."
            ) from None
        except cf.CancelledError:  # nobody here cancels a task
            raise FileError(
                f"the Dask scheduler at {address} went away in the middle: start it again, and give the command again."
            ) from None
