"""A client for tests, and the code of the page that tells users how."""

import itertools
import json
import re
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

from websockets.sync.client import ClientConnection, connect

TOKEN = "0123456789abcdef-secret"
PAGE = Path(__file__).parents[2] / "docs" / "howto" / "serve.md"


class Refused(Exception):
    """The error that was answered."""


class Client:
    """Asks, and keeps the ``events`` that come meanwhile."""

    def __init__(self, address: str, token: str = TOKEN, **more: Any) -> None:
        self._held = ExitStack()
        more["additional_headers"] = {"Authorization": f"Bearer {token}"}
        self.socket: ClientConnection = connect(address, compression=None, **more)
        self._held.enter_context(self.socket)
        self.events, self._ids = list[dict[str, Any]](), itertools.count(1)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._held.close()

    def send(self, method: str, timeout: float | None = None, **params: Any) -> int:
        """Ask; the request's id."""
        name = next(self._ids)
        message = {"id": name, "method": method, "params": params} | ({"timeout": timeout} if timeout else {})
        self.socket.send(json.dumps(message))
        return name

    def read(self, patience: float | None = 60.0) -> dict[str, Any]:
        """The next message."""
        return json.loads(self.socket.recv(timeout=patience))

    def answer(self, name: object) -> dict[str, Any]:
        """The answer to a request; :class:`Refused` for an error."""
        while True:
            message = self.read()
            if "event" in message:
                self.events.append(message)
            elif message["id"] == name:
                if "error" in message:
                    raise Refused(message["error"]["message"])
                return message["result"]

    def ask(self, method: str, timeout: float | None = None, **params: Any) -> dict[str, Any]:
        """Ask, and wait for the answer."""
        return self.answer(self.send(method, timeout, **params))


def code_on_page(language: str, number: int = 0) -> str:
    """A block of code of that page."""
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[number]
