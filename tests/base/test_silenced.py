"""What C prints past Python's own streams is caught, and what Python prints is not."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from planner.base.interrupts import tell_at_once
from planner.base.silenced import Silenced

C = ctypes.CDLL(None)


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a process of one thread: pytest's workers have more."""
    monkeypatch.setattr(threading, "active_count", lambda: 1)


def test_what_c_prints_is_caught_and_the_streams_come_back(alone: None, capfd: pytest.CaptureFixture[str]) -> None:
    sys.stdout.write("before\n")
    with Silenced() as printed:
        C.printf(b"Error:   joint 'j' is not unique. at line 7\n")  # kept in C's own buffer
        os.write(2, b"to error\n")
    sys.stdout.write("after\n")
    sys.stdout.flush()
    assert sorted(printed.text.splitlines()) == ["Error:   joint 'j' is not unique. at line 7", "to error"]
    assert printed.complaint() == "joint 'j' is not unique"
    assert printed.complaint("Warning:") == ""
    assert tuple(capfd.readouterr()) == ("before\nafter\n", "")


def test_an_error_inside_gives_the_streams_back(capfd: pytest.CaptureFixture[str]) -> None:
    def fail() -> None:
        raise ValueError("inside")

    with pytest.raises(ValueError, match="inside"), Silenced():
        fail()
    os.write(1, b"heard\n")
    assert capfd.readouterr().out == "heard\n"


def test_no_file_stays_open() -> None:
    with Silenced():
        pass
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(5):
        with Silenced():
            pass
    assert len(os.listdir("/proc/self/fd")) == before


def test_silence_ends_with_an_exception(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ZeroDivisionError), Silenced():
        _ = 1 / 0
    np.testing.assert_equal(capfd.readouterr(), ("", ""))


def test_streams_come_back_when_threads_overlap(capfd: pytest.CaptureFixture[str]) -> None:
    """The second one enters before the first one leaves: it has to wait, or it would give back the first one's file."""
    inside, entered = threading.Event(), threading.Event()

    def second() -> None:
        inside.wait()
        with Silenced():
            entered.set()

    thread = threading.Thread(target=second)
    thread.start()
    with Silenced():
        inside.set()
        assert not entered.wait(0.1)
    thread.join()
    os.write(1, b"heard\n")
    assert capfd.readouterr().out == "heard\n"


def test_what_another_thread_prints_meanwhile_is_passed_on(capfd: pytest.CaptureFixture[str]) -> None:
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    with Silenced() as printed:
        os.write(1, b"out\n")
        os.write(2, b"Error:   joint 'j' is not unique.\n         at line 7 in /urdfdom/model.cpp\nerror\n")
    done.set()
    thread.join()
    assert printed.text.splitlines()[-2:] == ["error", "out"]
    assert printed.complaint() == "joint 'j' is not unique"
    assert capfd.readouterr() == ("out\n", "error\n")


def test_what_a_handler_says_meanwhile_is_heard(alone: None, capfd: pytest.CaptureFixture[str]) -> None:
    with Silenced(), Silenced() as printed:
        os.write(2, b"from C\n")
        tell_at_once("stopping.")
    tell_at_once("stopped.")
    assert (printed.text, capfd.readouterr().err) == ("from C\n", "planner: stopping.\nplanner: stopped.\n")


def test_ctrl_c_while_a_library_is_kept_silent_says_so_and_leaves_no_file(tmp_path: Path) -> None:
    program = """
import signal
from planner.base.interrupts import leave_on_interrupt
from planner.base.silenced import Silenced
leave_on_interrupt()
with Silenced():
    signal.raise_signal(signal.SIGINT)
"""
    there = {**os.environ, "TMPDIR": str(tmp_path)}
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=there, check=False)
    assert ended.returncode == 130
    assert ended.stderr == "planner: stopping; there is nothing to save.\n"
    assert not list(tmp_path.iterdir())
