"""One client: its requests are read one after the other, long work is done beside them, and all of it ends with it."""

from __future__ import annotations

import json
import logging
import queue
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import msgpack
import pydantic_core
from websockets.exceptions import ConnectionClosed
from websockets.sync.connection import Connection as Socket

from planner.base.errors import OptionError, PlannerError
from planner.base.progress import Progress
from planner.base.yamlfile import object_of, validate
from planner.serve import messages as ask
from planner.serve.worlds import World, Worlds

_log = logging.getLogger(__name__)
_MOST_JOBS, _MOST_EVENTS = 16, 1000  # of one client: under way, not yet sent
_REPORT_EVERY = 0.05  # s between two messages on progress

Work = Callable[[Progress], dict[str, Any]]


def hang_up(on: Socket) -> None:
    """End a connection at once, also while a thread waits in ``send``, for which its own ``close`` would wait too."""
    with suppress(OSError):
        on.socket.shutdown(socket.SHUT_RDWR)


@dataclass(frozen=True)
class _To:
    """Whom a message is for: the request's id, and whether its frame was msgpack."""

    id: Any
    packed: bool


class _Job:
    """Work that is under way: ended by a cancel, by its time, or with its client."""

    def __init__(self, timeout: float | None) -> None:
        self._until = None if timeout is None else time.monotonic() + timeout
        self.cancelled, self.answered = threading.Event(), False

    def over(self) -> bool:
        """Whether it is to end."""
        return self.cancelled.is_set() or (self._until is not None and time.monotonic() >= self._until)


class Connection:
    """What a client asks of the ``worlds``, and the answers; :meth:`take` each of its frames, and :meth:`close`."""

    def __init__(self, socket: Socket, worlds: Worlds) -> None:
        self._socket, self._worlds = socket, worlds
        self._jobs: dict[str | int, _Job] = {}
        self._threads: set[threading.Thread] = set()
        self._alone, self._in_order = threading.Lock(), threading.Lock()
        self._events: queue.Queue[tuple[_To, dict[str, Any], _Job | None] | None] = queue.Queue(_MOST_EVENTS)
        self._teller = threading.Thread(target=self._tell_all, name="events")
        self._teller.start()

    def take(self, frame: str | bytes) -> None:
        """Answer one frame, or begin the work that will; never raises for what a frame may hold."""
        to = _To(None, isinstance(frame, bytes))
        try:
            data = _decoded(frame)
            to = replace(to, id=_id_in(data))
            request = validate(ask.Request, data, "the request", OptionError)
            self._answer(replace(to, id=request.id), request)
        except PlannerError as error:
            self._refuse(to, error)

    def close(self) -> None:
        """End all that is under way for this client, and wait for it."""
        with self._alone:
            for job in self._jobs.values():
                job.cancelled.set()
        self._worlds.forget(self)
        for thread in list(self._threads):
            thread.join()
        while True:
            try:
                self._events.put(None, timeout=0.05)
                break
            except queue.Full:  # nobody reads them
                self._events.queue.clear()
        self._teller.join()

    def _answer(self, to: _To, request: ask.Request) -> None:
        model = ask.METHODS.get(request.method)
        if model is None:
            raise OptionError(f"method '{request.method[:100]}' not found; methods are {', '.join(ask.METHODS)}.")
        asked = validate(model, request.params, f"params of '{request.method}'", OptionError)
        match asked:
            case ask.Check():
                self._done(to, lambda: self._worlds[asked.world].check(asked))
            case ask.Change():
                self._done(to, lambda: self._worlds[asked.world].change(asked))
            case ask.Cancel():
                self._done(to, lambda: self._cancel(asked))
            case ask.Subscribe():
                self._done(to, lambda: self._subscribe(to, self._worlds[asked.world]))
            case ask.Unsubscribe():
                self._done(to, lambda: self._unsubscribe(self._worlds[asked.world]))
            case ask.Worlds():
                self._done(to, lambda: {"worlds": [world.record() for world in self._worlds.all()]})
            case ask.Load():
                self._begin(to, request.timeout, lambda progress: self._worlds.load(asked, progress).record())
            case ask.Plan() | ask.Replan():
                world = self._worlds[asked.world]
                self._begin(to, request.timeout, lambda progress: _planned(world, asked, progress))

    def _begin(self, to: _To, timeout: float | None, work: Work) -> None:
        """Work that takes its time, in a thread of its own."""
        job = _Job(timeout)
        with self._alone:
            if to.id in self._jobs:
                raise OptionError(f"request {to.id!r} is under way already: give each an id of its own.")
            if len(self._jobs) >= _MOST_JOBS:
                raise OptionError(f"{_MOST_JOBS} requests are under way already: wait for one, or cancel it.")
            self._jobs[to.id] = job
        progress = Progress(self._reporter(to, job), job.over)

        def run() -> None:
            try:
                self._done(to, lambda: work(progress), job)
            finally:
                self._threads.discard(threading.current_thread())

        thread = threading.Thread(target=run, name="work")
        self._threads.add(thread)
        thread.start()

    def _done(self, to: _To, work: Callable[[], dict[str, Any]], job: _Job | None = None) -> None:
        """Work, and its answer: a client that has it may ask under the same name again."""
        failure: PlannerError | None = None
        result: dict[str, Any] = {}
        try:
            result = work()
        except PlannerError as error:
            failure = error
        except Exception:  # a fault of ours: the client is told, and the server lives
            _log.exception("a request failed")
            failure = PlannerError("the planner failed on this request: its log says where.")
        if job is not None:
            with self._alone:
                del self._jobs[to.id]
            with self._in_order:
                job.answered = True
        if failure is not None:
            self._refuse(to, failure)
        else:
            self._send(to, {"result": result})

    def _cancel(self, asked: ask.Cancel) -> dict[str, Any]:
        with self._alone:
            job = self._jobs.get(asked.id)
        if job is None:
            raise OptionError(f"no request {asked.id!r} is under way: it is answered already, or never came.")
        job.cancelled.set()
        return {"cancelled": asked.id}

    def _subscribe(self, to: _To, world: World) -> dict[str, Any]:
        world.listeners[self] = lambda event: self._tell(to, event)
        return world.record()

    def _unsubscribe(self, world: World) -> dict[str, Any]:
        return {"subscribed": world.listeners.pop(self, None) is not None}

    def _reporter(self, to: _To, job: _Job) -> Callable[[str, int, int], None]:
        last = 0.0

        def report(stage: str, done: int, total: int) -> None:
            """Tell the client, but not too often."""
            nonlocal last
            now = time.monotonic()
            if now - last >= _REPORT_EVERY:
                last = now
                self._tell(to, {"event": "progress", "stage": stage, "done": done, "total": total}, job)

        return report

    def _refuse(self, to: _To, error: PlannerError) -> None:
        reason = {} if error.reason is None else {"reason": error.reason.to_dict()}
        self._send(to, {"error": {"kind": type(error).__name__, "message": str(error), **reason}})

    def _tell(self, to: _To, event: dict[str, Any], job: _Job | None = None) -> None:
        """Send an event when there is time for it, that of a ``job`` until its answer: whoever tells does not wait.

        Who never reads is hung up on.
        """
        try:
            self._events.put_nowait((to, event, job))
        except queue.Full:
            hang_up(self._socket)

    def _tell_all(self) -> None:
        while (told := self._events.get()) is not None:
            to, event, job = told
            with self._in_order:
                if job is None or not job.answered:
                    self._send(to, event)

    def _send(self, to: _To, message: dict[str, Any]) -> None:
        message = {"id": to.id, **message}
        try:
            self._socket.send(_packed(message) if to.packed else json.dumps(message, ensure_ascii=False))
        except (OSError, EOFError, ConnectionClosed):  # it is gone: its requests are ended elsewhere
            _log.debug("a client was gone before its answer")


def _planned(world: World, asked: ask.Plan | ask.Replan, progress: Progress) -> dict[str, Any]:
    if isinstance(asked, ask.Replan):
        return world.plan(lambda session, told: session.replan(told), asked.motion, progress)
    beta = world.beta if asked.beta is None else asked.beta
    return world.plan(lambda session, told: session.plan(asked.start, asked.goal, beta, told), asked.motion, progress)


def _decoded(frame: str | bytes) -> Any:
    """The data of a frame; :class:`OptionError` for what is none."""
    try:
        if isinstance(frame, bytes):
            return msgpack.unpackb(frame, object_pairs_hook=object_of)
        data = pydantic_core.from_json(frame)  # a quarter of the time of json's own, which tells what stands twice
        return data if frame.count(":") == _keys_in(data) else json.loads(frame, object_pairs_hook=object_of)
    except (ValueError, RecursionError, msgpack.UnpackException) as error:
        what = "msgpack" if isinstance(frame, bytes) else "JSON"
        raise OptionError(
            f"the frame is no {what} ({str(error)[:100] or type(error).__name__}): send text as JSON, bytes as msgpack."
        ) from None


def _keys_in(data: Any) -> int:
    """How many keys the objects of ``data`` have, or fewer: lists whose first item is none are not gone through."""
    if isinstance(data, dict):
        return len(data) + sum(map(_keys_in, data.values()))
    return sum(map(_keys_in, data)) if isinstance(data, list) and data and isinstance(data[0], (dict, list)) else 0


def _id_in(data: Any) -> str | int | None:
    """The id of what may be a request, where an answer in any format can say it."""
    named = data.get("id") if isinstance(data, dict) else None
    return named if isinstance(named, str) or (isinstance(named, int) and abs(named) < ask.LARGEST_ID) else None


def _packed(message: dict[str, Any]) -> bytes:
    packed = msgpack.packb(message)
    assert packed is not None  # no packer of its own was given
    return packed
