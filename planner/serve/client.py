"""A client of ``planner serve``: websockets and the standard library, no robot library."""

import itertools
import json
import threading
import time
from typing import Any

from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from planner.base.errors import OptionError, PlannerError

_LARGEST = 1 << 24  # bytes of a message
_OPENING = 10.0  # s until a connection is open


class Client:
    """Sends a request and waits for its answer, at most ``timeout`` s; several threads may ask.

        client = Client("ws://127.0.0.1:8765/", token)
        client.ask("load", patience=600.0, robot="panda", scene="shelf")

    Raises :class:`PlannerError` for errors that the server answers, and if no answer comes.
    """

    def __init__(self, address: str, token: str, timeout: float = 1.0) -> None:
        self.timeout, self._address, self._ids, self._asking = timeout, address, itertools.count(1), threading.Lock()
        headers = {"Authorization": f"Bearer {token.strip()}"}
        try:
            self._socket = connect(
                address, additional_headers=headers, max_size=_LARGEST, compression=None, open_timeout=_OPENING
            )
        except (OSError, WebSocketException, ValueError) as error:
            raise OptionError(f"{address} must be a running 'planner serve' with this token: {error}.") from None

    def ask(self, method: str, patience: float | None = None, **params: Any) -> dict[str, Any]:
        """Return the result of a request; events on its progress are skipped."""
        seconds = self.timeout if patience is None else patience
        with self._asking:
            name, until = next(self._ids), time.monotonic() + seconds
            try:
                self._socket.send(json.dumps({"id": name, "method": method, "params": params}))
                while True:
                    answer = json.loads(self._socket.recv(timeout=max(0.0, until - time.monotonic())))
                    if answer["id"] == name and "event" not in answer:  # not a late answer to an earlier request
                        break
            except TimeoutError:
                raise PlannerError(
                    f"{self._address} must answer '{method}' within {seconds:g} s: see its load."
                ) from None
            except (OSError, WebSocketException) as error:
                raise PlannerError(f"{self._address} must stay connected, got {error}: start it again.") from None
        if "error" in answer:
            raise PlannerError(answer["error"]["message"])
        return answer["result"]

    def close(self) -> None:
        """End the connection, and the work of the server on it."""
        self._socket.close()
