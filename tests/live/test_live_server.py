"""The live page's server: the page itself is answered, and nobody else."""

from __future__ import annotations

import http.client
import json
import socket
import struct
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from planner.live.controller import LiveController
from planner.view import serve
from planner.view.serve import TOKEN_HEADER, running
from tests.live.controllers import make_controller

PATIENCE = 60.0  # s
ORDER = json.dumps({"order": {"do": "beta", "beta": 0.25}}).encode()


@pytest.fixture
def served(tmp_path: Path) -> Iterator[tuple[LiveController, int]]:
    controller = make_controller(tmp_path)
    with running(controller) as (address, _):
        port = urlsplit(address).port
        assert port is not None
        assert address == f"http://127.0.0.1:{port}/?token={controller.token}"
        yield controller, port


def ask(
    port: int, method: str, path: str, body: bytes | None = None, **headers: str
) -> tuple[int, bytes, dict[str, str]]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    try:
        connection.request(method, path, body, {name.replace("_", "-"): value for name, value in headers.items()})
        answer = connection.getresponse()
        return answer.status, answer.read(), dict(answer.getheaders())
    finally:
        connection.close()


def own(controller: LiveController, port: int) -> dict[str, str]:
    return {"Origin": f"http://127.0.0.1:{port}", TOKEN_HEADER: controller.token}


def test_the_page_is_shown_to_who_knows_the_token(served: tuple[LiveController, int]) -> None:
    controller, port = served
    status, body, headers = ask(port, "GET", f"/?token={controller.token}")
    assert status == 200
    assert controller.token.encode() in body
    assert b"connect-src 'self'" in body
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Referrer-Policy"] == "no-referrer"
    for path in (
        "/",
        "/?token=",
        "/?token=wrong",
        f"/?other={controller.token}",
        f"/?token={controller.token}x",
        "/?token=%ff",
    ):
        status, body, _ = ask(port, "GET", path)
        assert status == 403
        assert controller.token.encode() not in body
    assert ask(port, "GET", f"/?token={controller.token}", Host="evil.example")[0] == 403
    assert ask(port, "GET", f"/act?token={controller.token}")[0] == 404


def test_only_the_page_changes_anything(served: tuple[LiveController, int]) -> None:
    controller, port = served
    good = own(controller, port)
    beta = controller._state.question.beta
    refused = [
        {"Origin": good["Origin"]},
        {TOKEN_HEADER: controller.token},
        {**good, TOKEN_HEADER: ""},
        {**good, TOKEN_HEADER: "wrong"},
        {**good, "Origin": "http://evil.example"},
        {**good, "Origin": f"http://127.0.0.1:{port + 1}"},
        {**good, "Origin": f"https://127.0.0.1:{port}"},
        {**good, "Origin": "null"},
        {**good, "Host": "evil.example", "Origin": "http://evil.example"},
        {**good, "Host": f"evil.example:{port}", "Origin": f"http://evil.example:{port}"},
    ]
    for headers in refused:
        assert ask(port, "POST", "/act", ORDER, **headers)[0] == 403, headers
    assert ask(port, "POST", f"/act?token={controller.token}", ORDER)[0] == 403
    assert controller._state.question.beta == beta
    status, body, headers = ask(port, "POST", "/act", ORDER, **good)
    assert (status, headers["Content-Type"]) == (200, "application/json")
    assert json.loads(body)["data"]["beta"] == 0.25
    local = {**good, "Host": f"localhost:{port}", "Origin": f"http://localhost:{port}"}
    assert ask(port, "POST", "/act", ORDER, **local)[0] == 200


def test_other_methods_paths_and_sizes(served: tuple[LiveController, int]) -> None:
    controller, port = served
    good = own(controller, port)
    assert ask(port, "POST", "/", ORDER, **good)[0] == 404
    assert ask(port, "OPTIONS", "/act", None, **good)[0] == 501
    assert ask(port, "PUT", "/act", ORDER, **good)[0] == 501
    for length in ("-1", "x", "9" * 5000, str(2 << 20), "٣"):
        assert ask(port, "POST", "/act", b"", Content_Length=length.encode().decode("latin-1"), **good)[0] == 413
    assert "not JSON" in json.loads(ask(port, "POST", "/act", b"{", **good)[1])["error"]


def test_who_hangs_up_changes_nothing_and_is_no_news(
    served: tuple[LiveController, int], capfd: pytest.CaptureFixture[str]
) -> None:
    controller, port = served
    lines = [f"{name}: {value}" for name, value in own(controller, port).items()]
    head = "\r\n".join(["POST /act HTTP/1.1", f"Host: 127.0.0.1:{port}", f"Content-Length: {len(ORDER)}", *lines])
    question = head.encode() + b"\r\n\r\n" + ORDER
    before = controller._state
    for cut, rude in [(n, rude) for n in (9, len(head) + 2, len(question) - 4) for rude in (False, True)]:
        with socket.create_connection(("127.0.0.1", port)) as client:
            if rude:
                client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            client.sendall(question[:cut])
    assert ask(port, "GET", f"/?token={controller.token}")[0] == 200
    assert controller._state is before
    with socket.create_connection(("127.0.0.1", port)) as client:  # all was said, the answer is not waited for
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        client.sendall(question)
    assert ask(port, "POST", "/act", ORDER, **own(controller, port))[0] == 200
    assert capfd.readouterr().err == ""


def half_open(port: int, said: bytes = b"GET / HT") -> socket.socket:
    client = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
    client.sendall(said)
    return client


def is_hung_up_on(client: socket.socket) -> bool:
    """Whether the server ends the connection."""
    try:
        return client.recv(1) == b""
    except ConnectionError:
        return True


def test_who_trickles_is_hung_up_on(served: tuple[LiveController, int], monkeypatch: pytest.MonkeyPatch) -> None:
    controller, port = served
    monkeypatch.setattr(serve, "_DEADLINE", 0.5)
    begin = time.monotonic()
    lines = [f"{name}: {value}" for name, value in own(controller, port).items()]
    head = "\r\n".join(["POST /act HTTP/1.1", f"Host: 127.0.0.1:{port}", "Content-Length: 1000", *lines])
    with half_open(port) as silent, half_open(port) as trickling, half_open(port, f"{head}\r\n\r\n".encode()) as body:
        for client in (trickling, body):
            client.settimeout(0.05)
            while True:  # a byte at a time, for ever
                try:
                    client.sendall(b"x")
                    if client.recv(1) == b"":
                        break
                except TimeoutError:
                    pass
                except ConnectionError:
                    break
                assert time.monotonic() - begin < 20
        assert is_hung_up_on(silent)
    assert ask(port, "GET", f"/?token={controller.token}")[0] == 200


def test_many_half_open_connections_keep_nobody_out(
    served: tuple[LiveController, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    controller, port = served
    monkeypatch.setattr(serve, "_MOST_CONNECTIONS", 8)
    before = threading.active_count()
    clients = [half_open(port) for _ in range(60)]
    try:
        assert ask(port, "GET", f"/?token={controller.token}")[0] == 200
        assert ask(port, "POST", "/act", ORDER, **own(controller, port))[0] == 200
        assert all(is_hung_up_on(client) for client in clients[:50])  # the oldest
        assert threading.active_count() - before <= 16
    finally:
        for client in clients:
            client.close()


def test_it_ends_while_connections_are_half_open(tmp_path: Path) -> None:
    controller, before = make_controller(tmp_path), threading.active_count()
    with running(controller) as (address, _):
        port = urlsplit(address).port
        assert port is not None
        client = half_open(port)
        while threading.active_count() < before + 2:
            time.sleep(0.01)
        begin = time.monotonic()
    assert time.monotonic() - begin < 5
    assert threading.active_count() == before  # no thread is left that Python's end would find in native code
    client.close()
