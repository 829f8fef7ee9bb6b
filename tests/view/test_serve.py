"""What may be served: a whole page of ours, at a port that there is; the signal's old handlers come back."""

from __future__ import annotations

import os
import signal
import socket
import threading
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from planner.base.errors import FileError, OptionError, PlannerError
from planner.view.serve import read_page, require_port, serve

PAGE = '<html><head><meta name="generator" content="gabf-planner"></head><body>{}</body></html>\n'


def test_only_whole_pages_of_ours_are_served(tmp_path: Path) -> None:
    page = tmp_path / "plan.html"
    page.write_text(PAGE)
    assert read_page(page) == PAGE.encode()
    for text in ("<html></html>", PAGE[:-20], ""):
        page.write_text(text)
        with pytest.raises(FileError, match="not a whole page"):
            read_page(page)
    for place in (tmp_path / "none", tmp_path, Path("/dev/zero")):
        with pytest.raises(FileError, match="not found"):
            read_page(place)


@pytest.mark.parametrize("port", [-1, 65536])
def test_ports_have_a_range(port: int) -> None:
    require_port(0)
    with pytest.raises(OptionError, match=f"port {port}"):
        require_port(port)


def test_a_port_in_use_is_a_sentence() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(PlannerError, match=f"port {port} cannot be used: .*; choose another"):
            serve(PAGE, port)


def test_it_serves_until_the_signal_and_gives_the_handlers_back() -> None:
    said, answers, before = [], [], [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM)]

    def visit(sentence: str) -> None:
        said.append(sentence)
        threading.Thread(target=ask, args=(sentence.split()[1],)).start()

    def ask(address: str) -> None:
        try:
            with urllib.request.urlopen(address, timeout=10) as answer:
                answers.append((answer.status, answer.read().decode()))
            with pytest.raises(urllib.error.HTTPError, match="404"):
                urllib.request.urlopen(address + "other", timeout=10)
        finally:
            os.kill(os.getpid(), signal.SIGTERM)

    serve(PAGE, announce=visit)
    assert answers == [(200, PAGE)]
    assert said[0].startswith("Serving http://127.0.0.1:")
    assert [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM)] == before
