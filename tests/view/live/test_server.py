"""The live page's server: on this machine only, for its own page only; and the page in a real browser."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from planner.session.session import Session
from planner.view.live import LivePage, Question, start_server
from tests.browser import browser


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = start_server()
    yield server
    server.stop()


def test_it_listens_on_the_loopback_address_only(server: viser.ViserServer) -> None:
    port = server.get_port()
    socket.create_connection(("127.0.0.1", port), timeout=5).close()
    with socket.socket() as other:  # the same port of another address is free
        other.bind(("127.0.0.2", port))


def test_only_its_own_page_may_connect(server: viser.ViserServer) -> None:
    port = server.get_port()
    address, protocol = f"ws://127.0.0.1:{port}", f"viser-v{viser.__version__}"
    for origin in (f"http://127.0.0.1:{port}", f"http://localhost:{port}"):
        with connect(address, origin=origin, subprotocols=[protocol]) as own:
            assert own.recv(timeout=10)
    for origin in ("http://evil.example", f"http://evil.example:{port}", f"http://127.0.0.1:{port + 1}", "null", None):
        with pytest.raises(InvalidStatus, match="403"):
            connect(address, origin=origin, subprotocols=[protocol])


def test_the_page_in_a_browser(tmp_path: Path) -> None:
    """It sends no other request, shows the outcome, and its buttons work."""
    session = Session("planar_2r", "empty", nodes=60)
    page = LivePage(session, Question("q:0,1", "q:1,1", 0.5), tmp_path / "saved.yaml")
    try:
        with browser() as tab:
            tab.call("Page.navigate", url=f"http://127.0.0.1:{page.server.get_port()}/")
            outcome = "[...document.querySelectorAll('textarea')].map(e => e.value).join()"
            wait(lambda: "A collision-free path was found." in tab.run(outcome))
            button = "[...document.querySelectorAll('button')].find(b => b.innerText === '{}').click()"
            page.beta.value = 1.0
            tab.run(button.format("Plan"))
            wait(lambda: len(page.answers) == 2)
            tab.run(button.format("Undo"))
            wait(lambda: len(page.answers) == 1)
            tab.run(button.format("Save"))
            wait(lambda: "saved.yaml" in tab.run(outcome))
            own = (f"http://127.0.0.1:{page.server.get_port()}/", f"ws://127.0.0.1:{page.server.get_port()}")
            assert tab.requests
            assert all(request.startswith(own) for request in tab.requests), tab.requests
    finally:
        page.close()


def wait(done) -> None:
    end = time.monotonic() + 60
    while not done():
        assert time.monotonic() < end
        time.sleep(0.2)
