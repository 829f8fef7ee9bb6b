"""Cases at once: the same results for any workers, and none is lost when a worker dies, errs or is stopped."""

import logging
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from planner.base.errors import InstallationError, OptionError
from planner.base.progress import QUIET, Progress
from planner.batch import parallel
from planner.batch.parallel import measure_cases
from planner.problem.request import SERIAL, WorkersRequest
from tests.batch import functions

TWO = WorkersRequest(2)


@pytest.fixture(scope="module")
def dask() -> Iterator[WorkersRequest]:
    """A Dask cluster of one worker, a process; it gives a case up at the first death, not at the fourth."""
    distributed, dask_config = pytest.importorskip("distributed"), pytest.importorskip("dask.config")
    own = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
    once = dask_config.set({"distributed.scheduler.allowed-failures": 0})
    with once, distributed.LocalCluster(n_workers=1, threads_per_worker=2, **own) as cluster:
        yield WorkersRequest(workers=f"dask:{cluster.scheduler_address}")


@pytest.fixture(params=["loky", "dask"])
def workers(request: pytest.FixtureRequest) -> WorkersRequest:
    return TWO if request.param == "loky" else request.getfixturevalue("dask")


def until(is_so: Callable[[], bool]) -> None:
    begin = time.monotonic()
    while not is_so():
        assert time.monotonic() - begin < 120.0
        time.sleep(0.02)


def test_every_case_is_measured_in_another_process_and_none_is_lost_when_one_dies(workers: WorkersRequest) -> None:
    found = dict(measure_cases(range(6), functions.kill_at_two, workers, QUIET))
    assert sorted(found) == list(range(6))
    assert [case for case, process in found.items() if process is None] == [2]
    assert os.getpid() not in found.values()
    assert dict(measure_cases([0], functions.process_id, SERIAL, QUIET)) == {0: os.getpid()}


def test_errors_come_back_as_they_were() -> None:
    with pytest.raises(OptionError, match="7 is refused: give another number"):
        list(measure_cases([7, 7], functions.refused, TWO, QUIET))


def test_no_case_begins_after_a_stop() -> None:
    found: list[int | None] = []
    progress = Progress(stop=lambda: len(found) >= 2)
    for _, value in measure_cases(range(50), functions.square, SERIAL, progress):
        found.append(value)
    assert len(found) == 2


def test_workers_stop_where_the_command_is_killed(tmp_path: Path) -> None:
    code = (
        "from pathlib import Path\nfrom tests.batch.functions import wait_for_stop\n"
        "from tests.batch.test_parallel import TWO, QUIET, measure_cases\n"
        f"list(measure_cases([Path({str(tmp_path / 'case')!r})], wait_for_stop, TWO, QUIET))"
    )
    command = subprocess.Popen([sys.executable, "-c", code])
    until(lambda: (tmp_path / "case").exists())
    command.kill()
    command.wait()
    until(lambda: (tmp_path / "case").read_text() == "stopped")


def test_a_worker_of_other_software_is_refused(dask: WorkersRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parallel, "software", lambda: "another planner")
    with pytest.raises(InstallationError, match="must have another planner in"):
        list(measure_cases([1], functions.square, dask, QUIET))
