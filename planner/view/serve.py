"""Serves one page to this machine only: at the loopback address, until the process ends."""

from __future__ import annotations

import os
import signal
import sys
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from planner.base.errors import FileError, OptionError, PlannerError
from planner.base.files import is_file

HOST = "127.0.0.1"
_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def serve(
    page: Path | str,
    port: int = 0,
    open_browser: bool = False,
    announce: Callable[[str], None] = lambda sentence: None,
) -> None:
    """Serve a page until SIGINT or SIGTERM, then free the port and return; from the main thread only.

    ``page`` is the HTML text itself, or a file, which is read again for every request: a reload shows a newer plan.
    ``port`` 0 takes any free one. ``announce`` is called with the address once it can be opened. Raises
    :class:`FileError` for a file that is no page, :class:`PlannerError` for a port that cannot be used.
    """
    content = _source(page)
    content()
    asked = threading.Event()
    with _until_signal(asked), _server(content, port) as address:
        announce(f"Serving {address} on this machine only; Ctrl-C ends it.")
        if open_browser:
            announce(_open(address))
        while not asked.wait(0.5):  # a signal that reaches another thread does not wake this one
            pass


def require_port(port: int) -> None:
    """Raise :class:`OptionError` unless ``port`` is a port's number, or 0 for any."""
    if not 0 <= port <= 65535:
        raise OptionError(f"port {port} is not usable: give a number from 1 to 65535, or 0 for any free one.")


def _source(page: Path | str) -> Callable[[], bytes]:
    if isinstance(page, str):
        return page.encode
    return lambda: read_page(page)


def read_page(path: Path) -> bytes:
    """A page's bytes; :class:`FileError` unless it is one of ours."""
    if not is_file(path):  # a device may have no end
        raise FileError(f"page {path} not found: check the path, or plan again.")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FileError(f"page {path} cannot be read: {error.strerror or error}; check the path.") from None
    if b'<meta name="generator" content="gabf-planner">' not in content[:4096] or b"</html>" not in content[-64:]:
        raise FileError(f"{path} is not a whole page of this planner: plan again to write it anew.")
    return content


@contextmanager
def _server(content: Callable[[], bytes], port: int) -> Iterator[str]:
    require_port(port)
    try:
        server = _Server(content, port)
    except OSError as error:
        raise PlannerError(f"port {port} cannot be used: {error.strerror or error}; choose another --port.") from None
    thread = threading.Thread(target=server.serve_forever, name="page", daemon=True)
    thread.start()
    try:
        yield f"http://{HOST}:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    allow_reuse_address = os.name == "posix"  # on other systems it would let two servers share a port

    def __init__(self, content: Callable[[], bytes], port: int) -> None:
        super().__init__((HOST, port), _Handler)
        self.content = content


class _Handler(BaseHTTPRequestHandler):
    server: _Server  # pyright: ignore[reportIncompatibleVariableOverride]
    timeout = 30  # s that a silent connection may hold its thread

    def handle(self) -> None:
        # a browser that leaves the page closes the connection early: there is nothing to answer
        with suppress(ConnectionError):
            super().handle()

    def do_GET(self) -> None:
        status, body = self._answer()
        self.send_response(status)
        self.send_header("Content-Type", "text/html; charset=utf-8" if status == HTTPStatus.OK else "text/plain")
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    do_HEAD = do_GET

    def _answer(self) -> tuple[HTTPStatus, bytes]:
        # a foreign name that resolves to this machine (DNS rebinding) shows in the Host header
        names = {f"{name}:{self.server.server_port}" for name in (HOST, "localhost")}
        if self.headers.get("Host") not in names:
            return HTTPStatus.FORBIDDEN, b"This page is for this machine only.\n"
        if self.path.split("?")[0] not in ("/", "/index.html"):
            return HTTPStatus.NOT_FOUND, b"There is one page here, at /.\n"
        try:
            return HTTPStatus.OK, self.server.content()
        except FileError as error:
            return HTTPStatus.NOT_FOUND, f"{error}\n".encode()

    def log_message(self, format: str, *args: object) -> None:
        """Print nothing: the terminal is not a log of requests."""


@contextmanager
def _until_signal(asked: threading.Event) -> Iterator[None]:
    """SIGINT and SIGTERM set ``asked`` instead of ending the process."""
    before = {number: signal.signal(number, lambda *_: asked.set()) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _open(address: str) -> str:
    """Open the page in a browser where there is a screen to show it on; a browser in the terminal would block."""
    screen = sys.platform == "darwin" or any(os.environ.get(k) for k in ("DISPLAY", "WAYLAND_DISPLAY"))
    if screen and webbrowser.open(address):
        return "Opened in the browser."
    return "No browser can be opened from here: open the address yourself."
