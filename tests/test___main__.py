"""The program: Ctrl-C is seen to before anything of weight is loaded, and the end comes at once, with all said."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

ORDER = """
import sys
import planner.__main__ as program
early = {name for name in sys.modules if name.startswith("planner.")}
assert early <= {"planner.__main__", "planner.base", "planner.base.interrupts", "planner.base.printable"}, early
order = []
program.leave_on_interrupt = lambda: order.append("interrupts")
program.end_like_interrupt = lambda: order.append("ends")
import planner.cli
planner.cli.main = lambda: order.append("commands")
program.main()
print(order)
"""
EARLIEST = """
import os, signal, sys

class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == "planner.base.interrupts":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
import planner.__main__
"""
END = """
import atexit, os, sys, threading
import planner.__main__ as program
import planner.cli

def command():
    atexit.register(os.write, 2, b"last")
    {before}
    print("said")
    sys.exit({code})

class Telling:
    def __del__(self):
        os.write(2, b", taken apart")

kept = Telling()
planner.cli.main = command
program.main()
"""


def test_interrupts_come_first() -> None:
    done = subprocess.run([sys.executable, "-c", ORDER], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("['interrupts', 'ends', 'commands']\n", "")


def test_while_the_first_modules_are_loaded_an_interrupt_ends_in_no_traceback() -> None:
    done = subprocess.run([sys.executable, "-c", EARLIEST], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


@pytest.mark.parametrize(
    ("before", "code", "last"),
    [
        ("pass", 4, "last"),
        ("threading.Timer(0.3, os.write, (2, b'worked, ')).start()", 3, "worked, last, taken apart"),
        ("threading.Thread(target=threading.Event().wait, daemon=True).start()", 4, "last"),
        ("pass", "'a sentence'", "a sentence\nlast, taken apart"),
    ],
)
def test_the_end_waits_for_threads_and_runs_exit_functions(before: str, code: int | str, last: str) -> None:
    end = END.format(before=before, code=code)
    done = subprocess.run([sys.executable, "-c", end], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr, done.returncode) == ("said\n", last, code if isinstance(code, int) else 1)


@pytest.mark.parametrize("closed", [1, 2])
def test_a_stream_that_was_closed_before_is_not_missed(closed: int) -> None:
    end = END.format(before="pass", code=4)
    command = f'exec {closed}>&-; exec "$0" -c "$1"'
    done = subprocess.run(["sh", "-c", command, sys.executable, end], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr, done.returncode) == (("", "last", 4) if closed == 1 else ("said\n", "", 4))


def test_errors_are_told_where_nobody_reads_the_output() -> None:
    command = 'exec "$0" -m planner plan --robot nowhere >&-'
    done = subprocess.run(["sh", "-c", command, sys.executable], stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 3
    assert done.stderr.strip().startswith("planner: error: robot 'nowhere' not found")
    assert "Traceback" not in done.stderr
