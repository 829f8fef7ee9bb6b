"""Serves one page to this machine only: at the loopback address, until the process ends."""

from __future__ import annotations

import math
import os
import secrets
import socket
import sys
import threading
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

from planner.base.errors import FileError, OptionError, PlannerError
from planner.base.interrupts import until_signal

HOST = "127.0.0.1"
TOKEN_HEADER = "X-Planner-Token"
_LARGEST = 1 << 20  # bytes of a request
_DEADLINE = 10.0  # s in which a request has to be here whole, however its bytes trickle in
_MOST_CONNECTIONS = 32  # at once: a browser opens six
_AWAY = "left without waiting for what was being answered."


class Controller(Protocol):
    """What a live page talks to: it draws the page as things stand, and answers the page's requests, one at a time."""

    token: str

    def page(self) -> str:
        """The page's HTML text."""
        ...

    def answer(self, request: bytes) -> bytes:
        """The answer (JSON) to a request of the page; never raises for what a request may hold."""
        ...

    def stop(self) -> None:
        """End what is being answered as soon as can be, and take nothing up any more."""
        ...


def serve(
    page: Path | str | Controller,
    port: int = 0,
    open_browser: bool = False,
    announce: Callable[[str], None] = lambda sentence: None,
) -> None:
    """Serve a page until SIGINT or SIGTERM, then free the port and return; from the main thread only.

    It returns once every thread that answers has ended, as one that is in compiled code while Python is taken down
    crashes the process; a second signal ends the process at once.

    ``page`` is the HTML text itself, or a file, which is read again for every request: a reload shows a newer plan;
    or a :class:`Controller`, whose page may change things: only who knows its token sees it, and only the page
    itself, by its origin and the token, is answered. ``port`` 0 takes any free one. ``announce`` is called with the
    address once it can be opened. Raises :class:`FileError` for a file that is no page, :class:`PlannerError` for a
    port that cannot be used.
    """
    with running(page, port) as (address, asked):
        announce(f"Serving {address} on this machine only; Ctrl-C ends it.")
        if open_browser:
            announce(_open(address))
        while not asked.wait(0.5):  # a signal that reaches another thread does not wake this one
            pass


def require_port(port: int) -> None:
    """Raise :class:`OptionError` unless ``port`` is a port's number, or 0 for any."""
    if not 0 <= port <= 65535:
        raise OptionError(f"port {port} is not usable: give a number from 1 to 65535, or 0 for any free one.")


def require_free_port(port: int) -> None:
    """The same, and :class:`PlannerError` where something serves on it: before there is a page to serve."""
    require_port(port)
    if port:
        with _bound(port):
            socket.create_server((HOST, port)).close()


@contextmanager
def _bound(port: int) -> Iterator[None]:
    """A port that cannot be served on is refused in a sentence."""
    try:
        yield
    except OSError as error:
        raise PlannerError(f"port {port} cannot be used: {error.strerror or error}; choose another --port.") from None


@contextmanager
def running(page: Path | str | Controller, port: int = 0) -> Iterator[tuple[str, threading.Event]]:
    """A server of a page, gone when the block ends: its address, and what SIGINT and SIGTERM set."""
    live = not isinstance(page, Path | str)
    content: Callable[[], bytes]
    if isinstance(page, str):
        content = page.encode
    else:
        content = (lambda: read_page(page)) if isinstance(page, Path) else (lambda: page.page().encode())
    content()
    asked = threading.Event()
    with until_signal(asked, _AWAY), _server(content, port, page if live else None) as address:
        yield (f"{address}?token={page.token}" if live else address), asked


def read_page(path: Path) -> bytes:
    """A page's bytes; :class:`FileError` unless it is one of ours."""
    if not os.path.isfile(path):  # a device may have no end
        raise FileError(f"page {path} not found: check the path, or plan again.")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FileError(f"page {path} cannot be read: {error.strerror or error}; check the path.") from None
    if b'<meta name="generator" content="gabf-planner">' not in content[:4096] or b"</html>" not in content[-64:]:
        raise FileError(f"{path} is not a whole page of this planner: plan again to write it anew.")
    return content


@contextmanager
def _server(content: Callable[[], bytes], port: int, controller: Controller | None = None) -> Iterator[str]:
    require_port(port)
    with _bound(port):
        server = _Server(content, port, controller)
    thread = threading.Thread(target=server.serve_forever, name="page", daemon=True)
    thread.start()
    try:
        yield f"http://{HOST}:{server.server_port}/"
    finally:
        server.shutdown()
        if controller is not None:
            controller.stop()
        server.hang_up()
        server.server_close()
        thread.join()


class _Server(ThreadingHTTPServer):
    """A thread for each connection, which brings one request; who says nothing, or too slowly, is hung up on."""

    daemon_threads = False
    allow_reuse_address = os.name == "posix"  # on other systems it would let two servers share a port

    def __init__(self, content: Callable[[], bytes], port: int, controller: Controller | None) -> None:
        self.content, self.controller = content, controller
        self._known = threading.Lock()
        self._open: dict[socket.socket, float] = {}  # until when its request has to be here; inf once it is
        super().__init__((HOST, port), _Handler if controller is None else _LiveHandler)

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Whether a new connection is taken: where there are too many, in the place of the oldest one that waits."""
        with self._known:
            if len(self._open) >= _MOST_CONNECTIONS:
                oldest, until = min(self._open.items(), key=lambda item: item[1])
                if until == math.inf:
                    return False
                del self._open[oldest]
                _hang_up(oldest)
            self._open[request] = time.monotonic() + _DEADLINE
            return True

    def has_asked(self, connection: socket.socket) -> None:
        """The request of a connection is here: it has no deadline any more."""
        with self._known:
            if connection in self._open:
                self._open[connection] = math.inf

    def service_actions(self) -> None:
        """Hang up on those whose time is over; called twice a second."""
        self.hang_up(time.monotonic())

    def hang_up(self, now: float = math.inf) -> None:
        """Hang up on connections whose deadline has passed; left out: on all."""
        with self._known:
            for connection in [one for one, until in self._open.items() if until <= now]:
                del self._open[connection]
                _hang_up(connection)

    def shutdown_request(self, request: Any) -> None:
        """Forget a connection that has ended."""
        with self._known:
            self._open.pop(request, None)
        super().shutdown_request(request)


def _hang_up(connection: socket.socket) -> None:
    """End a connection that another thread reads from or writes to; that thread closes it."""
    with suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


class _Handler(BaseHTTPRequestHandler):
    server: _Server  # pyright: ignore[reportIncompatibleVariableOverride]
    timeout = 30  # s that one who takes no answer may hold its thread

    def handle(self) -> None:
        # a browser that leaves the page closes the connection early: there is nothing to answer
        with suppress(ConnectionError):
            super().handle()

    def do_GET(self) -> None:
        self.server.has_asked(self.connection)
        self._send(*self._answer(), kind="text/html; charset=utf-8")

    do_HEAD = do_GET

    def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind if status == HTTPStatus.OK else "text/plain")
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Frame-Options", "DENY")  # no other page may lay itself over this one
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    @property
    def _is_ours(self) -> bool:
        """Whether the request is for this machine: a foreign name that resolves to it (DNS rebinding) shows in Host."""
        names = {f"{name}:{self.server.server_port}" for name in (HOST, "localhost")}
        return self.headers.get("Host") in names

    def _answer(self) -> tuple[HTTPStatus, bytes]:
        if not self._is_ours:
            return HTTPStatus.FORBIDDEN, b"This page is for this machine only.\n"
        if self.path.split("?")[0] not in ("/", "/index.html"):
            return HTTPStatus.NOT_FOUND, b"There is one page here, at /.\n"
        try:
            return HTTPStatus.OK, self.server.content()
        except FileError as error:
            return HTTPStatus.NOT_FOUND, f"{error}\n".encode()

    def log_message(self, format: str, *args: object) -> None:
        """Print nothing: the terminal is not a log of requests."""


class _LiveHandler(_Handler):
    """The page for who knows the token, and answers for the page: other pages in the browser can drive nothing."""

    @property
    def _controller(self) -> Controller:
        assert self.server.controller is not None
        return self.server.controller

    def _answer(self) -> tuple[HTTPStatus, bytes]:
        given = parse_qs(urlsplit(self.path).query).get("token", [""])[0]
        if self._is_ours and not self._knows_token(given):
            return HTTPStatus.FORBIDDEN, b"Open the whole address that 'planner view --live' has printed.\n"
        return super()._answer()

    def do_POST(self) -> None:
        status, body = self._change()
        self.close_connection = status != HTTPStatus.OK  # what is left of a refused request is not read
        self._send(status, body, kind="application/json")

    def _change(self) -> tuple[HTTPStatus, bytes]:
        own = self.headers.get("Origin") == f"http://{self.headers.get('Host')}"
        if not (self._is_ours and own and self._knows_token(self.headers.get(TOKEN_HEADER, ""))):
            return HTTPStatus.FORBIDDEN, b"Only the live page itself may ask for this.\n"
        if self.path != "/act":
            return HTTPStatus.NOT_FOUND, b"Requests of the page go to /act.\n"
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit() and len(length) < 9 and int(length) <= _LARGEST):
            return HTTPStatus.REQUEST_ENTITY_TOO_LARGE, b"A request has a length, of 1 MiB at most.\n"
        request = self.rfile.read(int(length))
        if len(request) < int(length):
            raise ConnectionAbortedError  # it hung up in the middle: nothing is done
        self.server.has_asked(self.connection)
        return HTTPStatus.OK, self._controller.answer(request)

    def _knows_token(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self._controller.token.encode())


def _open(address: str) -> str:
    """Open the page in a browser where there is a screen to show it on; a browser in the terminal would block."""
    screen = sys.platform == "darwin" or any(os.environ.get(k) for k in ("DISPLAY", "WAYLAND_DISPLAY"))
    if screen and webbrowser.open(address):
        return "Opened in the browser."
    return "No browser can be opened from here: open the address yourself."
