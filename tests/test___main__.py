"""The program: Ctrl-C is handled before the other modules load."""

import signal
import subprocess
import sys

EARLIEST = """
import os, signal, sys

class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == "planner.base.interrupts":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
import planner.__main__
"""


def test_while_the_first_modules_are_loaded_an_interrupt_ends_in_no_traceback() -> None:
    done = subprocess.run([sys.executable, "-c", EARLIEST], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_errors_are_printed_when_the_output_is_closed() -> None:
    command = 'exec "$0" -m planner plan --robot nowhere >&-'
    done = subprocess.run(["sh", "-c", command, sys.executable], stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 3
    assert done.stderr.strip().startswith("planner: error: robot 'nowhere' not found")
    assert "Traceback" not in done.stderr
