"""A websocket server at the loopback address, or at another one for who knows a token."""

from __future__ import annotations

import ipaddress
import logging
import secrets
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from pathlib import Path
from typing import Any

from planner.base.errors import FileError, InstallationError, OptionError, PlannerError
from planner.base.interrupts import until_signal
from planner.base.yamlfile import read_text
from planner.serve.worlds import Worlds
from planner.view.serve import HOST, require_port

_LARGEST = 1 << 24  # bytes of a message
_SHORTEST = 16  # characters of a token
_SWITCH = 5e-4  # s after which a thread that plans lets one that checks go on; Python's own is 5 ms
_PATIENCE = 2.0  # s in which clients may end their connections when the server does
_AWAY = "left without waiting for what was being answered."


def serve(host: str = HOST, port: int = 0, token: str | None = None, announce: Any = lambda sentence: None) -> None:
    """Serve until SIGINT or SIGTERM, then end what is under way; from the main thread only."""
    asked = threading.Event()
    with until_signal(asked, _AWAY), running(host, port, token) as address:
        announce(f"Serving {address}; Ctrl-C ends it.")
        while not asked.wait(0.5):
            pass


@contextmanager
def running(host: str = HOST, port: int = 0, token: str | None = None) -> Iterator[str]:
    """A server, gone when the block ends: its address.

    ``token``: only who sends it, as ``Authorization: Bearer <token>``, is served; needed where ``host`` is not of this
    machine alone. Pages in a browser, which send an Origin, are not. Raises :class:`OptionError` for a port or a host
    that cannot be used so, :class:`InstallationError` where the packages are missing.
    """
    require_port(port)
    require_token(host, token)
    Connection, hang_up, websocket_server, closed = _library()
    worlds, talking = Worlds(), set[Any]()

    def talk(socket: Any) -> None:
        """One client from its first frame to its last."""
        connection = Connection(socket, worlds)
        talking.add(socket)
        try:
            for frame in socket:
                connection.take(frame)
        except closed:  # without a word: its work ends all the same
            pass
        finally:
            connection.close()
            talking.discard(socket)

    def leave() -> None:
        """Wait no longer for who does not say goodbye, nor read what it is sent."""
        for socket in list(talking):
            hang_up(socket)

    def admit(socket: Any, request: Any) -> Any:
        """None for who knows the token, else the answer that turns it away."""
        given = request.headers.get("Authorization", "")
        if token is None or secrets.compare_digest(given.encode(), f"Bearer {token}".encode()):
            return None
        return socket.respond(HTTPStatus.UNAUTHORIZED, "Send the token, as Authorization: Bearer TOKEN.\n")

    quiet = logging.getLogger("planner.serve.websockets")
    quiet.setLevel(logging.CRITICAL)  # who hangs up early is nobody's fault
    how = {"origins": [None], "process_request": admit, "max_size": _LARGEST, "compression": None, "logger": quiet}
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
        worlds.close()
        patience = threading.Timer(_PATIENCE, leave)
        patience.start()
        server.shutdown()
        patience.cancel()
        thread.join()
        sys.setswitchinterval(before)


def require_token(host: str, token: str | None) -> None:
    """Raise :class:`OptionError` where others than this machine could ask without a token, or for one that is short."""
    if token is None and not _is_of_this_machine(host):
        raise OptionError(f"host {host} can be reached from elsewhere: give a --token-file, or leave --host out.")
    if token is not None and len(token) < _SHORTEST:
        raise OptionError(f"the token is shorter than {_SHORTEST} characters: 'openssl rand -hex 32' makes one.")


def read_token(path: Path) -> str:
    """The token in a file that others cannot read."""
    text = read_text(path, "token file").strip()
    if path.stat().st_mode & 0o077:
        raise FileError(f"token file {path} can be read by others: run chmod 600 {path}.")
    if not text.isascii() or not text.isprintable() or " " in text:
        raise FileError(f"token file {path} holds more than one word of plain characters: write the token alone.")
    return text


def _is_of_this_machine(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _library() -> tuple[Any, Any, Any, Any]:
    """The connection, what ends and what serves it, and what is raised when a client is gone."""
    try:
        from websockets.exceptions import ConnectionClosed
        from websockets.sync.server import serve as websocket_server

        from planner.serve.connection import Connection, hang_up
    except ModuleNotFoundError as error:
        if error.name not in ("websockets", "msgpack"):
            raise
        raise InstallationError(
            f"serving needs the Python package {error.name}: run pip install 'gabf-planner[serve]'."
        ) from None
    return Connection, hang_up, websocket_server, ConnectionClosed
