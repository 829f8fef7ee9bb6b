"""No process of ours is left where the one that started it has ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from planner.processes import with_parent

PARENT = """
import sys
from planner.processes.process import run_module
run_module("timeit", ["-n", "1", "-r", "1", sys.argv[1]])
"""


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_process_ends_with_its_parent_however_that_ends(how: signal.Signals, tmp_path: Path) -> None:
    said = tmp_path / "pid"
    work = f"import os, time; open({str(said)!r}, 'w').write(str(os.getpid()) + '.'); time.sleep(60)"
    parent = subprocess.Popen([sys.executable, "-c", PARENT, work])
    until(lambda: said.exists() and said.read_text().endswith("."))
    child = int(said.read_text().rstrip("."))
    os.kill(child, 0)
    parent.send_signal(how)
    parent.wait()
    until(lambda: not is_alive(child))


def until(there: Callable[[], bool]) -> None:
    begin = time.monotonic()
    while not there():
        assert time.monotonic() - begin < 20.0
        time.sleep(0.02)


def is_alive(process: int) -> bool:
    """Whether it runs: one that has ended may wait for somebody to take note of it."""
    status = Path(f"/proc/{process}/stat")
    return status.exists() and status.read_text().rpartition(")")[2].split()[0] != "Z"


def test_one_whose_parent_is_gone_does_not_begin() -> None:
    done = subprocess.run([sys.executable, "-P", with_parent.__file__, "1", "this"], capture_output=True, check=False)
    assert (done.returncode, done.stdout) == (-signal.SIGKILL, b"")
