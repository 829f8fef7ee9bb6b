"""A cluster of Dask: what runs where, a stop that reaches the workers, and what is no cluster."""

from __future__ import annotations

import math
import os
import sys
from types import SimpleNamespace

import pytest

from planner.base.cluster import cluster, local_cluster
from planner.base.errors import FileError, InstallationError, OptionError, PlannerError


def test_functions_run_on_every_worker_or_on_one(scheduler: str) -> None:
    with cluster(scheduler) as found:
        assert found.threads == 2
        assert found.on_each(os.getpid) == [os.getpid()] * 2
        executor = found.executor()
        assert list(executor.map(pow, (2, 3), (5, 2))) == [32, 9]
        with pytest.raises(ValueError, match="math domain"):
            executor.submit(math.sqrt, -1.0).result()


def test_a_stop_is_heard_within_a_second_and_only_by_its_own(scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr("planner.base.cluster.time", SimpleNamespace(monotonic=lambda: clock.now))
    with cluster(scheduler) as other, cluster(scheduler) as found:
        own, others = found.signal.progress(), other.signal.progress()
        found.stop()
        assert not own.stopped  # asked a moment ago
        clock.now = 1.1
        assert own.stopped
        assert not others.stopped
        assert own.stopped


def test_the_workers_of_a_local_cluster_are_processes_of_this_machine() -> None:
    pytest.importorskip("distributed")
    with local_cluster(2) as address:
        assert address.startswith("tcp://127.0.0.1:")
        with cluster(address) as found:
            workers = found.on_each(os.getpid)
    assert len({os.getpid(), *workers}) == 3
    for worker in workers:
        with pytest.raises(ProcessLookupError):
            os.kill(worker, 0)


def test_what_is_no_cluster_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("planner.base.cluster._SECONDS", 0.1)
    with pytest.raises(OptionError, match=r"'gopher://x' is no address .* give one like tcp://"), cluster("gopher://x"):
        pass
    with pytest.raises(FileError, match="no Dask scheduler of this version answers"), cluster("tcp://127.0.0.1:1"):
        pass


def test_a_scheduler_without_workers_says_how_to_start_some() -> None:
    distributed = pytest.importorskip("distributed")
    own = {"processes": False, "host": "127.0.0.1", "protocol": "tcp://", "dashboard_address": "127.0.0.1:0"}
    with (
        distributed.LocalCluster(n_workers=0, **own) as empty,
        pytest.raises(FileError, match="no workers: start some with 'dask worker tcp://"),
        cluster(empty.scheduler_address),
    ):
        pass


def test_workers_that_keep_dying_are_one_sentence(scheduler: str) -> None:
    distributed = pytest.importorskip("distributed")
    with pytest.raises(PlannerError, match="workers died one after the other"), cluster(scheduler):
        raise distributed.KilledWorker("task", SimpleNamespace(address="tcp://x"), 3)


def test_without_dask_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InstallationError, match=r"pip install 'gabf-planner\[cluster\]'"), cluster("tcp://x:1"):
        pass
