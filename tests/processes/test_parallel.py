"""Cases at once: the same results whoever measures, processes that are killed, errors, and what a stop leaves."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.attack.report import Row
from benchmarks.attack.run import attack
from planner.base.cluster import local_cluster
from planner.base.errors import FileError, OptionError
from planner.base.progress import QUIET, Progress
from planner.batch.results import read_rows
from planner.batch.run import run_batch
from planner.problem.request import SERIAL, PlanRequest, WorkersRequest
from planner.processes.parallel import measured_cases
from tests.batch.test_run import PLAIN, timeless
from tests.processes.functions import killed_at_first, process_id, refused, slow, square

TWO = WorkersRequest(2)
PLANS = "plans:\n  - {name: one}\n  - {name: two, beta: 0.2}\n"


@pytest.fixture(scope="module")
def dask_cluster() -> Iterator[WorkersRequest]:
    """A scheduler and two workers on the loopback address, in processes of their own."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
    ) as cluster:
        yield WorkersRequest(backend="dask", scheduler=cluster.scheduler_address)


def test_every_case_is_measured_once_whoever_measures() -> None:
    expected = {0: 9, 1: 16, 2: 25}
    for workers in (SERIAL, TWO, WorkersRequest(8)):
        assert dict(measured_cases([3, 4, 5], square, workers, QUIET)) == expected


def test_one_job_is_this_process_and_more_have_one_each() -> None:
    assert dict(measured_cases([0, 1], process_id, SERIAL, QUIET)) == {0: os.getpid(), 1: os.getpid()}
    others = dict(measured_cases([0, 1], process_id, TWO, QUIET))
    assert len({os.getpid(), *others.values()}) == 3


@pytest.mark.parametrize("workers", [SERIAL, TWO])
def test_none_is_begun_after_a_stop(workers: WorkersRequest) -> None:
    measured: list[int] = []
    progress = Progress(stop=lambda: len(measured) >= 2)
    for _, case in measured_cases(range(50), square, workers, progress):
        measured.append(case)
    assert 2 <= len([case for case in measured if case is not None]) <= 2 + (workers.jobs or 0)


def test_a_process_that_is_killed_is_run_once_more(tmp_path: Path) -> None:
    found = dict(measured_cases([tmp_path / "a", tmp_path / "b"], killed_at_first, TWO, QUIET))
    assert found == {0: "a", 1: "b"}


def test_errors_come_back_as_they_were() -> None:
    with pytest.raises(OptionError, match="7 is refused"):
        list(measured_cases([7, 7], refused, TWO, QUIET))


def test_a_benchmark_has_the_same_rows_from_two_processes(tmp_path: Path) -> None:
    def rows(workers: WorkersRequest) -> tuple:
        out = tmp_path / str(workers.jobs)
        assert attack(out, ("misses",), edges=1, robots=("planar_2r",), thicknesses=(5.0,), workers=workers) == 0
        return tuple(sorted(read_rows(out / "attack.csv", Row, "it"), key=lambda row: row.key))

    assert rows(SERIAL) == rows(TWO)


@pytest.mark.parametrize(
    "options", [{"backend": "dask"}, {"scheduler": "tcp://127.0.0.1:1"}, {"jobs": 0}, {"jobs": 20_000}]
)
def test_workers_that_make_no_sense_are_refused(options: dict) -> None:
    with pytest.raises(OptionError):
        WorkersRequest(**options)


def test_a_cluster_measures_the_same_rows(dask_cluster: WorkersRequest, tmp_path: Path) -> None:
    assert dict(measured_cases([3, 4, 5], square, dask_cluster, QUIET)) == {0: 9, 1: 16, 2: 25}
    source = tmp_path / "batch.yaml"
    source.write_text(PLANS)
    here, there = (run_batch(source, tmp_path / name, PLAIN, who) for name, who in (("h", TWO), ("t", dask_cluster)))
    assert timeless(here) == timeless(there)
    assert (tmp_path / "t" / "two" / "plan.json").is_file()
    with pytest.raises(OptionError, match="7 is refused"):
        list(measured_cases([7], refused, dask_cluster, QUIET))


def test_a_worker_of_a_cluster_that_is_killed_costs_its_own_row_which_is_planned_again(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    psutil = pytest.importorskip("psutil")  # Dask brings it along
    source, seen = tmp_path / "batch.yaml", {}
    source.write_text(f"{PLANS}  - {{name: three, beta: 0.8}}\n")

    def look() -> bool:
        """Note which processes plan which row, ten times a second; kill the worker that the first one belongs to."""
        for process in psutil.process_iter(["pid", "cmdline"]):
            words = process.info["cmdline"] or []
            if "planner.batch.case" not in words or str(tmp_path / "there") not in " ".join(words):
                continue
            if not seen:
                process.parent().kill()
            seen[process.pid] = Path(words[-2]).name
        return False

    with local_cluster(2) as address:
        workers = WorkersRequest(backend="dask", scheduler=address)
        there = run_batch(source, tmp_path / "there", PLAIN, workers, progress=Progress(stop=look))
    here = run_batch(source, tmp_path / "here", PLAIN, TWO)
    assert there.complete
    assert timeless(there) == timeless(here)
    planned = list(seen.values())
    assert {name: planned.count(name) for name in planned} == {
        name: 1 + (name == planned[0]) for name in ("one", "two", "three")
    }


def test_a_scheduler_that_goes_away_in_the_middle_is_one_sentence() -> None:
    pytest.importorskip("distributed")
    looks = iter(range(10_000))
    code = "from planner.base.cluster import local_cluster\nwith local_cluster(1) as it: print(it, flush=True); input()"
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as host:
        assert host.stdout is not None
        address = host.stdout.readline().strip()
        progress = Progress(stop=lambda: bool(next(looks) == 3 and host.kill()))
        workers = WorkersRequest(backend="dask", scheduler=address)
        with pytest.raises(FileError, match=f"scheduler at {address} went away in the middle"):
            list(measured_cases([3.0], slow, workers, progress, isolated=True))


def test_a_stop_reaches_the_workers_of_a_cluster(dask_cluster: WorkersRequest, tmp_path: Path) -> None:
    """One plan of a few seconds: it is cut off, and leaves no row."""
    source = tmp_path / "batch.yaml"
    source.write_text("plans: [{name: long, nodes: 20000, robot: iiwa14, scene: paper}]\n")
    asked = iter([False, False])
    progress = Progress(stop=lambda: next(asked, True))
    done = run_batch(source, tmp_path / "out", PlanRequest(collision="coal"), dask_cluster, progress=progress)
    assert (done.rows, done.complete) == ((), False)


@pytest.mark.parametrize("address", ["gopher://x", "tcp://x"])
def test_a_scheduler_that_is_no_address_is_one_sentence(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """No client is made of it: that would take 20 s to close, and say so in a traceback."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(distributed, "Client", None)
    with pytest.raises(OptionError, match="is no address"):
        list(measured_cases([1], square, WorkersRequest(backend="dask", scheduler=address), QUIET))


def test_nothing_imports_dask_unless_asked() -> None:
    code = "import planner.processes.parallel, sys; print('distributed' in sys.modules or 'dask' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
