"""Output that C prints past Python's own streams is caught, and the streams come back."""

import ctypes
import os
import sys
import threading

import pytest

from planner.base.captured_output import CapturedOutput
from planner.base.interrupts import write_message

C = ctypes.CDLL(None)


def test_output_of_c_is_caught_and_the_streams_come_back(capfd: pytest.CaptureFixture[str]) -> None:
    sys.stdout.write("before\n")
    with CapturedOutput() as printed:
        C.printf(b"Error:   joint 'j' is not unique. at line 7\n")  # kept in C's own buffer
        os.write(2, b"to error\n")
        write_message("stopping.")  # as a signal handler does
    sys.stdout.write("after\n")
    sys.stdout.flush()
    assert sorted(printed.text.splitlines()) == ["Error:   joint 'j' is not unique. at line 7", "to error"]
    assert printed.first_error() == "joint 'j' is not unique"
    assert tuple(capfd.readouterr()) == ("before\nafter\n", "planner: stopping.\n")


def test_streams_come_back_when_threads_overlap(capfd: pytest.CaptureFixture[str]) -> None:
    """The second one enters before the first one leaves: it has to wait, or it would give back the first one's file."""
    inside, entered = threading.Event(), threading.Event()

    def second() -> None:
        inside.wait()
        with CapturedOutput():
            entered.set()

    thread = threading.Thread(target=second)
    thread.start()
    with CapturedOutput():
        inside.set()
        assert not entered.wait(0.1)
    thread.join()
    os.write(1, b"heard\n")
    assert capfd.readouterr().out == "heard\n"
