"""A websocket server for clients that know its token."""

from __future__ import annotations

import logging
import os
import secrets
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.sync.server import ServerConnection
from websockets.sync.server import serve as websocket_server

from planner.base.errors import FileError, OptionError, PlannerError
from planner.base.interrupts import until_signal
from planner.base.yamlfile import read_text
from planner.serve.connection import Connection

HOST = "127.0.0.1"
_LARGEST = 1 << 24  # bytes of a message
_SHORTEST = 16  # characters of a token
_SWITCH = 5e-4  # s after which a thread that plans lets one that checks go on; Python's own is 5 ms


def serve(host: str, port: int, token_file: Path | None, allow_xacro: bool, announce: Callable[[str], None]) -> None:
    """Serve until SIGINT or SIGTERM, then end what is under way; from the main thread only."""
    asked = threading.Event()
    with (
        until_signal(asked, "left without waiting for what was being answered."),
        TemporaryDirectory(prefix="planner-serve-") as folder,
    ):
        path = token_file or Path(folder) / "token"
        with running(token_in(path), host, port, allow_xacro) as address:
            announce(f"Serving {address}; token in {path}; Ctrl-C ends it.")
            while not asked.wait(0.5):
                pass


@contextmanager
def running(token: str, host: str = HOST, port: int = 0, allow_xacro: bool = False) -> Iterator[str]:
    """A server, gone when the block ends: its address.

    Only clients that send the ``token``, as ``Authorization: Bearer <token>``, are served; pages in a browser, which
    send an Origin, are not. Raises :class:`PlannerError` for a port that cannot be used.
    """
    if not 0 <= port <= 65535:
        raise OptionError(f"port must be from 1 to 65535, or 0 for any free one, got {port}.")
    connections: set[Connection] = set()

    def talk(client: ServerConnection) -> None:
        """One client from its first frame to its last."""
        connection = Connection(client, allow_xacro)
        connections.add(connection)
        with suppress(ConnectionClosed):
            for frame in client:
                connection.take(frame)
        connection.close()
        connections.discard(connection)

    def admit(client: ServerConnection, request: Request) -> Response | None:
        """None for a client that knows the token, else the answer that turns it away."""
        given = request.headers.get("Authorization", "")
        if secrets.compare_digest(given.encode(), f"Bearer {token}".encode()):
            return None
        return client.respond(HTTPStatus.UNAUTHORIZED, "Send the token, as Authorization: Bearer TOKEN.\n")

    quiet = logging.getLogger("planner.serve.websockets")
    quiet.setLevel(logging.CRITICAL)  # clients may hang up early
    how: Any = {"origins": [None], "process_request": admit, "max_size": _LARGEST, "compression": None, "logger": quiet}
    try:
        server = websocket_server(talk, host, port, **how)
    except OSError as error:
        raise PlannerError(
            f"host {host}, port {port} cannot be used: {error.strerror or error}; choose another --port or --host."
        ) from None
    before = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH)
    thread = threading.Thread(target=server.serve_forever, name="server")
    thread.start()
    try:
        name = f"[{host}]" if ":" in host else host
        yield f"ws://{name}:{server.socket.getsockname()[1]}/"
    finally:
        for connection in list(connections):
            connection.hang_up()
        server.shutdown()
        thread.join()
        sys.setswitchinterval(before)


def token_in(path: Path) -> str:
    """The token in a file that others cannot read; a random one is written where there is no file."""
    try:
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(f"{secrets.token_hex(32)}\n")
    except FileExistsError:
        if not os.path.isfile(path):
            raise FileError(f"token file {path} is a folder, a pipe or a device: give a file.") from None
    except OSError as error:
        raise FileError(f"token file {path} cannot be written: {error.strerror}; choose another place.") from None
    text = read_text(path, "token file").strip()
    if path.stat().st_mode & 0o077:
        raise FileError(f"token file {path} can be read by others: run chmod 600 {path}.")
    if len(text) < _SHORTEST or not text.isascii() or not text.isprintable() or " " in text:
        raise FileError(f"token file {path} must hold one word of {_SHORTEST} plain characters or more: remove it.")
    return text
