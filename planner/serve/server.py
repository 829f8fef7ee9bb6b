"""A websocket server for clients that know its token, and one world for each of them.

Quick requests are answered in order; loading and planning happen in a second thread.
"""

import json
import logging
import os
import re
import secrets
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from http import HTTPStatus
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pydantic_core
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.sync.connection import Connection as Socket
from websockets.sync.server import ServerConnection
from websockets.sync.server import serve as websocket_server

from planner.base.errors import FileError, Note, OptionError, PlannerError, SceneError
from planner.base.interrupts import catch_signals
from planner.base.progress import QUIET, Progress
from planner.base.yamlfile import read_text
from planner.planning.solve import time_plan
from planner.problem.conditions import read_conditions
from planner.problem.request import TimingRequest, WorldRequest
from planner.query.robots import robot_sources, scene_sources
from planner.robot.clouds import Points, notes_on_clouds
from planner.robot.robot_in_scene import notes
from planner.robot.scene import mesh_notes, read_obstacle
from planner.serve import messages as ask
from planner.session.gate import Gate
from planner.session.live_world import LiveWorld
from planner.session.session import Session
from planner.trajectory.trajectory import Trajectory

_log = logging.getLogger(__name__)
HOST = "127.0.0.1"
_LARGEST = 1 << 24  # bytes of a message
_SHORTEST = 16  # characters of a token
_SWITCH = 5e-4  # s after which a thread that plans lets one that checks go on; Python's own is 5 ms
_MOST_JOBS = 16  # of one client, under way or waiting
_REPORT_EVERY = 0.05  # s between two events
_KEYS = b"urdf|obstacles|carried|states|robots|constraints|world|robot_model_name|allowed_collision_matrix|joint_limits"
_MODEL = re.compile(rb"<(robot|mujoco)[\s>]|^[\"']?(" + _KEYS + rb")[\"']?:(\s|$)|\A[^\n]*\n(\* \w|\.\s)", re.MULTILINE)
_MESHES = (".stl", ".obj", ".ply", ".dae", ".glb")


def serve(host: str, port: int, token_file: Path | None, allow_xacro: bool, announce: Callable[[str], None]) -> None:
    """Serve until SIGINT or SIGTERM, then end what is under way; from the main thread only."""
    asked = threading.Event()
    with (
        catch_signals(asked, "left without waiting for what was being answered."),
        TemporaryDirectory(prefix="planner-serve-") as folder,
    ):
        path = token_file or Path(folder) / "token"
        with run_server(load_token(path), host, port, allow_xacro) as address:
            announce(f"Serving {address}; token in {path}; Ctrl-C ends it.")
            while not asked.wait(0.5):
                pass


@contextmanager
def run_server(token: str, host: str = HOST, port: int = 0, allow_xacro: bool = False) -> Iterator[str]:
    """Run a server inside the block, and yield its address.

    Clients must send the ``token``, as ``Authorization: Bearer <token>``; pages in a browser, which send an Origin, are
    refused. Raises :class:`PlannerError` for a port that cannot be used.
    """
    if not 0 <= port <= 65535:
        raise OptionError(f"port must be from 1 to 65535, or 0 for any free one, got {port}.")
    connections: set[Connection] = set()

    def talk(client: ServerConnection) -> None:
        """Serve one client from its first frame to its last."""
        connection = Connection(client, allow_xacro)
        connections.add(connection)
        with suppress(ConnectionClosed):
            for frame in client:
                connection.take(frame)
        connection.close()
        connections.discard(connection)

    def admit(client: ServerConnection, request: Request) -> Response | None:
        """Return None for a client with the token, else the refusal."""
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


def load_token(path: Path) -> str:
    """Return the token in a file that others cannot read; write a random one if there is no file."""
    try:
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(f"{secrets.token_hex(32)}\n")
    except FileExistsError:
        pass
    except OSError as error:
        raise FileError(f"token file {path} cannot be written: {error.strerror}; choose another place.") from None
    text = read_text(path, "token file").strip()
    if path.stat().st_mode & 0o077:
        raise FileError(f"token file {path} can be read by others: run chmod 600 {path}.")
    if len(text) < _SHORTEST or not text.isascii() or not text.isprintable() or " " in text:
        raise FileError(f"token file {path} must hold one word of {_SHORTEST} plain characters or more: remove it.")
    return text


class Connection:
    """A gate and a session on the live world of one client: :meth:`take` its frames, then :meth:`close`."""

    def __init__(self, client: Socket, allow_xacro: bool) -> None:
        self._socket, self._allow_xacro = client, allow_xacro
        self._world: tuple[Gate, Session] | None = None
        self._jobs: dict[Any, threading.Event] = {}  # by the ids of requests; a job ends once its event is set
        self._worker = ThreadPoolExecutor(1, "work")

    def take(self, frame: str | bytes) -> None:
        """Answer a frame, or begin its work; no content of a frame raises an error."""
        name = None
        try:
            data = _parse_frame(frame)
            name = ask.read_id(data)
            request = ask.read_request(data)
            if isinstance(request.params, ask.Load | ask.Plan | ask.Replan):
                self._begin(request)
            else:
                self._answer(name, lambda: self._do(request.params, QUIET))
        except PlannerError as error:
            self._send(name, _refusal(error))

    def close(self) -> None:
        """End all work, and wait for it."""
        for cancelled in list(self._jobs.values()):
            cancelled.set()
        self._worker.shutdown()

    def hang_up(self) -> None:
        """End the connection and its work at once, also while a thread waits in ``send``."""
        with suppress(OSError):
            self._socket.socket.shutdown(socket.SHUT_RDWR)

    def _begin(self, request: ask.Request) -> None:
        """Load or plan in the second thread, with events on progress."""
        name, last = request.id, 0.0
        if name in self._jobs:
            raise OptionError(f"id of a request must be new, got {name!r} again: give each request its own id.")
        if len(self._jobs) >= _MOST_JOBS:
            raise OptionError(f"requests at once must be at most {_MOST_JOBS}: wait for one, or cancel it.")
        cancelled = self._jobs[name] = threading.Event()
        until = time.monotonic() + (request.timeout or threading.TIMEOUT_MAX)

        def report(stage: str, done: int, total: int) -> None:
            nonlocal last
            if time.monotonic() - last >= _REPORT_EVERY:
                last = time.monotonic()
                self._send(name, {"event": "progress", "stage": stage, "done": done, "total": total})

        def is_over() -> bool:
            return cancelled.is_set() or time.monotonic() >= until

        def work() -> dict[str, Any]:
            try:
                return self._do(request.params, Progress(report, is_over))
            except PlannerError as error:
                if type(error) is PlannerError:  # not of bad input
                    _go_on(is_over())
                raise
            finally:
                del self._jobs[name]  # the client may use the id again after the answer

        self._worker.submit(self._answer, name, work)

    def _do(self, asked: Any, progress: Progress) -> dict[str, Any]:
        """Return the result of a message."""
        if isinstance(asked, ask.Load):
            return self._load(asked, progress)
        if isinstance(asked, ask.Cancel):
            if asked.id not in self._jobs:
                raise OptionError(f"request {asked.id!r} not found: it is answered, or did not arrive.")
            self._jobs[asked.id].set()
            return {"cancelled": asked.id}
        if self._world is None:
            raise OptionError("world not found: load one first.")
        gate, session = self._world
        if isinstance(asked, ask.Check):
            return _check(gate, asked)
        if isinstance(asked, ask.Change):
            return _change(gate, asked)
        if isinstance(asked, ask.Statistics):
            return gate.statistics.to_dict()
        _go_on(progress.stopped)
        if isinstance(asked, ask.Replan):
            plan = session.replan(progress=progress)
        else:
            plan = session.plan(asked.start, asked.goal, beta=asked.beta, timing=None, progress=progress)
        has_motion = asked.motion and plan.solved and len(plan.path) > 1
        motion = time_plan(plan, TimingRequest(), gate.limits) if has_motion else None
        _go_on(progress.stopped)
        return {
            "outcome": plan.outcome.key,
            "message": plan.message,
            "joints": list(plan.robot.joints),
            "path": plan.path.tolist(),
            "cost": plan.cost and plan.cost.total,
            "reason": plan.reason and plan.reason.to_dict(),
            "motion": _record(motion, gate),
            "notes": list(plan.end_notes),
        }

    def _load(self, asked: ask.Load, progress: Progress) -> dict[str, Any]:
        limits = asked.limits.limits
        for paths in (robot_sources(asked.robot), scene_sources(asked.scene), [limits] if limits else []):
            _require_models(paths, self._allow_xacro)
        constraint, floor = read_conditions(asked.constraint), asked.min_manipulability
        world = LiveWorld(
            WorldRequest(asked.robot, asked.scene, tool=asked.tool, margin=asked.margin, constraint=constraint)
        )
        gate = Gate(world, limits=asked.limits, judged=asked.judged, min_manipulability=floor)
        _go_on(progress.stopped)
        self._world = gate, Session(world, nodes=asked.nodes, seed=asked.seed, min_manipulability=floor)
        return {
            "robot": world.robot.name,
            "scene": world.scene.name,
            "joints": list(world.robot.joints),
            "lower": [_finite(value) for value in world.robot.lower],
            "upper": [_finite(value) for value in world.robot.upper],
            **gate.to_dict(),
            "obstacles": [item.name for item in world.scene.obstacles],
            "carried": [item.name for item in world.scene.carried],
            "notes": _texts(notes(world.robot, world.scene)),
        }

    def _answer(self, name: Any, work: Callable[[], dict[str, Any]]) -> None:
        try:
            answer = {"result": work()}
        except PlannerError as error:
            answer = _refusal(error)
        except Exception:  # a fault of ours: the server lives
            _log.exception("a request failed")
            answer = _refusal(PlannerError("the planner failed on this request: see its log."))
        self._send(name, answer)

    def _send(self, name: Any, message: dict[str, Any]) -> None:
        with suppress(OSError, EOFError, ConnectionClosed):  # the client is gone; its work ends too
            self._socket.send(json.dumps({"id": name, **message}, ensure_ascii=False))


def _refusal(error: PlannerError) -> dict[str, Any]:
    reason = {} if error.reason is None else {"reason": error.reason.to_dict()}
    return {"error": {"kind": type(error).__name__, "message": str(error), **reason}}


def _go_on(stopped: bool) -> None:
    if stopped:
        raise PlannerError("request stopped before its end: it was cancelled, or its time is over.")


def _change(gate: Gate, asked: ask.Change) -> dict[str, Any]:
    world, found = gate.world, list[Note]()
    for each in asked.changes:
        if isinstance(each, ask.Move):
            world.put(each.name, each.matrix())
        elif isinstance(each, ask.Add):
            if hasattr(each.obstacle, "file"):
                _require_models([Path(each.obstacle.file)])
            if each.obstacle.motion:
                raise SceneError(f"'{each.obstacle.name}' has a motion: give one that stands, or a speed_limit.")
            for item in read_obstacle(each.obstacle):
                world.add(item)
            found += mesh_notes([each.obstacle])
        elif isinstance(each, ask.Attach):
            world.attach(each.name, each.frame, np.array(each.at), each.touch_links)
        elif isinstance(each, ask.Detach):
            world.detach(each.name, np.array(each.at))
        elif isinstance(each, ask.Allow):
            world.allow(each.link, each.object, each.seconds, each.box)
        elif isinstance(each, ask.Forbid):
            world.forbid(each.link, each.object)
        elif isinstance(each, ask.See):
            cloud = Points(each.points, each.radius, each.noise, each.calibration)
            world.see(each.name, cloud, each.matrix(), None if each.at is None else np.array(each.at), each.margin)
            found += notes_on_clouds(item for item in gate.scene.obstacles if item.object == each.name)
        else:
            world.remove(each.name)
    if any(isinstance(each, ask.Add) for each in asked.changes):
        found += notes(gate.robot, gate.scene)
    return {"changes": len(asked.changes), "revision": gate.to_dict()["revision"], "notes": _texts(found)}


def _check(gate: Gate, asked: ask.Check) -> dict[str, Any]:
    now = asked.state
    state = now and [row for row in (now.q, now.qd, now.qdd) if row is not None]
    columns = asked.positions, asked.velocities, asked.accelerations
    verdict = gate.check(*columns, times=asked.times, state=state, stop=asked.stop)
    found = verdict.to_dict()
    if "stop" in asked.want:
        found["stop"] = _record(verdict.stop, gate)
    if "clearance" in asked.want:
        found["clearance"] = verdict.clearance
    if "slowed" in asked.want:
        found["slowed"] = _record(verdict.slowed, gate)
    slower = verdict.slower if "slower" in asked.want else None
    if {"slower", "slowed"} & set(asked.want):
        found["time_scale"] = verdict.time_scale or 1.0
    if asked.at:
        motion = slower or verdict
        found["positions"] = None if motion.stop is None else motion.positions_at(asked.at).tolist()
    return found


def _finite(value: float) -> float | None:
    """Return the number, None for infinity, which JSON lacks."""
    return float(value) if np.isfinite(value) else None


def _texts(said: Iterable[Note]) -> list[str]:
    return list(dict.fromkeys(note.text for note in said))


def _record(trajectory: Trajectory | None, gate: Gate) -> dict[str, Any] | None:
    return None if trajectory is None else trajectory.to_dict(gate.robot.name, gate.scene.name)


def _parse_frame(frame: str | bytes) -> Any:
    """Return the data of a frame; :class:`OptionError` for a frame that is not JSON."""
    try:
        if isinstance(frame, bytes):
            raise ValueError("it is binary")
        return pydantic_core.from_json(frame)
    except ValueError as error:
        raise OptionError(f"a frame must be JSON ({str(error)[:100]}): send it as text.") from None


def _require_models(paths: Iterable[Path], allow_xacro: bool = False) -> None:
    """Raise :class:`OptionError` unless all are regular files, the first one a model, and none is xacro.

    Errors quote a model, and a client must not read other files by them. The reader reports missing files.
    """
    for k, path in enumerate(paths):
        if os.path.exists(path) and not os.path.isfile(path):
            raise OptionError(f"{path} must be a regular file: give the path of one.")
        if path.suffix.lower() == ".xacro" and not allow_xacro:
            raise OptionError(
                f"{path} must not be xacro, whose expressions run on the server: start it with --allow-xacro."
            )
        if k == 0 and path.suffix.lower() not in _MESHES and os.access(path, os.R_OK):
            with path.open("rb") as file:
                if not _MODEL.search(file.read(1 << 20)):
                    raise OptionError(f"{path} must hold a robot, a scene or joint limits: give the path of one.")
        if path.suffix.lower() == ".xacro":  # which may name any file
            return
