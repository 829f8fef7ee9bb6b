"""The threads of the compiled code: as few as calls want, the same ones every time, none in the way of the end."""

import os
import subprocess
import sys

import pytest

from tests.native.sanitized import MODULE

BEGIN = """
import os, sys, threading, time
import numpy as np
from planner.native.compiled import NativeChain, set_threads

set_threads(3)
turns = np.stack([np.eye(3), 0 * np.eye(3), 0 * np.eye(3)])[None]
x = np.array([[1.0, 0, 0]])
chain = NativeChain(np.zeros(1, dtype=int), np.ones(1, dtype=bool), turns, np.zeros((1, 3)), x, x)
q = np.linspace(-1, 1, 20_000)[:, None]
pieces = np.full(len(q), 4, dtype=np.int64)
ask = lambda: chain.path_lengths(q, -q, pieces, 1, np.ones(3)).tobytes()
threads = lambda: len(os.listdir("/proc/self/task"))
"""


def ends(script: str, seconds: float = 60.0) -> str:
    done = subprocess.run(
        [sys.executable, "-c", BEGIN + script], capture_output=True, text=True, timeout=seconds, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(sys.platform != "linux", reason="counts threads as Linux lists them")
def test_calls_share_their_threads() -> None:
    before, after, many = map(
        int,
        ends("""
before, first = threads(), ask()
after = threads()
assert all(ask() == first for _ in range(50))
several = [threading.Thread(target=ask) for _ in range(8)]
any(thread.start() for thread in several), any(thread.join() for thread in several)
until = time.monotonic() + 10
while threads() > after and time.monotonic() < until:  # a thread that was joined is listed a little longer
    time.sleep(0.01)
print(before, after, threads())
""").split(),
    )
    assert before < after <= before + 2
    assert many == after


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
@pytest.mark.skipif(MODULE in os.environ, reason="GCC's sanitizer leaves locks of its memory held in forked children")
def test_a_forked_child_has_threads_of_its_own() -> None:
    script = """
first = ask()
working = [threading.Thread(target=lambda: [ask() for _ in range(300)]) for _ in range(2)]
any(thread.start() for thread in working)
children = []
for _ in range(5):
    child = os.fork()
    if not child:
        os._exit(0 if ask() == first else 1)
    children.append(child)
codes = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
any(thread.join() for thread in working)
print(codes)
"""
    assert ends(script).strip() == str([0] * 5)


def test_the_process_ends_while_calls_are_under_way() -> None:
    script = """
def on_and_on():
    while True:
        ask()
ask()
for _ in range(3):
    threading.Thread(target=on_and_on, daemon=True).start()
time.sleep(0.2)
print("at the end")
"""
    for _ in range(5):
        assert ends(script, 20.0).strip() == "at the end"
