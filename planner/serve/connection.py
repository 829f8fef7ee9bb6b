"""One client and its world: quick requests are answered in order, loading and planning happen in a second thread."""

from __future__ import annotations

import json
import logging
import os
import re
import socket
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

import pydantic
import pydantic_core
from websockets.exceptions import ConnectionClosed
from websockets.sync.connection import Connection as Socket

from planner.base.errors import Note, OptionError, PlannerError
from planner.base.progress import QUIET, Progress
from planner.planning.motion import timed
from planner.problem.conditions import conditions_of
from planner.problem.request import TimingRequest, WorldRequest
from planner.query.robots import robot_sources, scene_sources
from planner.robot.model_checks import notes
from planner.robot.scene import mesh_notes, obstacle_of
from planner.serve import messages as ask
from planner.session.gate import Gate
from planner.session.live_world import LiveWorld
from planner.session.session import Session
from planner.trajectory.file import trajectory_record
from planner.trajectory.trajectory import Trajectory

_log = logging.getLogger(__name__)
_ID = pydantic.TypeAdapter[str | int](ask.Id)
_MOST_JOBS = 16  # of one client, under way or waiting
_REPORT_EVERY = 0.05  # s between two events
_KEYS = b"urdf|obstacles|carried|states|robots|keep|world|robot_model_name|allowed_collision_matrix|joint_limits"
_MODEL = re.compile(rb"<(robot|mujoco)[\s>]|^[\"']?(" + _KEYS + rb")[\"']?:(\s|$)|\A[^\n]*\n(\* \w|\.\s)", re.MULTILINE)
_MESHES = (".stl", ".obj", ".ply", ".dae", ".glb")


class Connection:
    """A gate and a session on the live world of one client; :meth:`take` its frames, then :meth:`close`."""

    def __init__(self, client: Socket, allow_xacro: bool) -> None:
        self._socket, self._allow_xacro = client, allow_xacro
        self._world: tuple[Gate, Session] | None = None
        self._jobs: dict[Any, threading.Event] = {}  # by the ids of requests; a job ends once its event is set
        self._worker = ThreadPoolExecutor(1, "work")

    def take(self, frame: str | bytes) -> None:
        """Answer a frame, or begin the work that will; never raises for what a frame may hold."""
        name = None
        try:
            data = _decoded(frame)
            name = _id_in(data)
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
        """End the connection at once, also while a thread waits in ``send``; then its work ends too."""
        with suppress(OSError):
            self._socket.socket.shutdown(socket.SHUT_RDWR)

    def _begin(self, request: ask.Request) -> None:
        """Load or plan in the second thread, with events on progress."""
        name, last = request.id, 0.0
        if name in self._jobs:
            raise OptionError(f"request {name!r} is under way already: give each an id of its own.")
        if len(self._jobs) >= _MOST_JOBS:
            raise OptionError(f"{_MOST_JOBS} requests are under way already: wait for one, or cancel it.")
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
                del self._jobs[name]  # a client that has the answer may use the id again

        self._worker.submit(self._answer, name, work)

    def _do(self, asked: Any, progress: Progress) -> dict[str, Any]:
        """The result of a message."""
        if isinstance(asked, ask.Load):
            return self._load(asked, progress)
        if isinstance(asked, ask.Cancel):
            cancelled = self._jobs.get(asked.id)
            if cancelled is None:
                raise OptionError(f"request {asked.id!r} is not under way: it is answered already, or never came.")
            cancelled.set()
            return {"cancelled": asked.id}
        if self._world is None:
            raise OptionError("there is no world yet: load one first.")
        gate, session = self._world
        if isinstance(asked, ask.Check):
            return _check(gate, asked)
        if isinstance(asked, ask.Change):
            return _change(gate, asked)
        _go_on(progress.stopped)
        again = isinstance(asked, ask.Replan)
        plan = session.replan(progress) if again else session.plan(asked.start, asked.goal, asked.beta, progress)
        has_motion = asked.motion and plan.solved and len(plan.path) > 1
        motion = timed(plan, TimingRequest(), gate.limits) if has_motion else None
        _go_on(progress.stopped)
        return {
            "outcome": plan.outcome.key,
            "message": plan.message,
            "joints": list(plan.robot.joints),
            "path": plan.path.tolist(),
            "cost": None if plan.cost is None else plan.cost.total,
            "reason": None if plan.reason is None else plan.reason.to_dict(),
            "motion": _record(motion, gate),
            "notes": list(plan.end_notes),
        }

    def _load(self, asked: ask.Load, progress: Progress) -> dict[str, Any]:
        limits = asked.limits.limits
        for paths in (robot_sources(asked.robot), scene_sources(asked.scene), [limits] if limits else []):
            _require_models(paths, self._allow_xacro)
        keep, floor = conditions_of(asked.keep), asked.min_manipulability
        world = LiveWorld(WorldRequest(asked.robot, asked.scene, asked.tool, margin=asked.margin, keep=keep))
        gate = Gate(world, limits=asked.limits, judged=asked.judged, min_manipulability=floor)
        _go_on(progress.stopped)
        self._world = gate, Session(world, nodes=asked.nodes, seed=asked.seed, min_manipulability=floor)
        return {
            "robot": world.robot.name,
            "scene": world.scene.name,
            "joints": list(world.robot.joints),
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
            answer = _refusal(PlannerError("the planner failed on this request: its log says where."))
        self._send(name, answer)

    def _send(self, name: Any, message: dict[str, Any]) -> None:
        with suppress(OSError, EOFError, ConnectionClosed):  # the client is gone, and its work ends with it
            self._socket.send(json.dumps({"id": name, **message}, ensure_ascii=False))


def _refusal(error: PlannerError) -> dict[str, Any]:
    reason = {} if error.reason is None else {"reason": error.reason.to_dict()}
    return {"error": {"kind": type(error).__name__, "message": str(error), **reason}}


def _go_on(stopped: bool) -> None:
    if stopped:
        raise PlannerError("stopped before it was done: it was cancelled, or its time is over.")


def _change(gate: Gate, asked: ask.Change) -> dict[str, Any]:
    said: list[Note] = []
    for each in asked.changes:
        if isinstance(each, ask.Move):
            gate.move(each.name, each.matrix())
        elif isinstance(each, ask.Add):
            if each.obstacle.type == "mesh":
                _require_models([Path(each.obstacle.file)])
            gate.add(obstacle_of(each.obstacle))
            said += mesh_notes([each.obstacle])
        else:
            getattr(gate, each.do)(**each.model_dump(exclude={"do"}))
    if any(isinstance(each, ask.Add) for each in asked.changes):
        said += notes(gate.robot, gate.scene)
    return {"changes": len(asked.changes), "revision": gate.world.now[1], "notes": _texts(said)}


def _check(gate: Gate, asked: ask.Check) -> dict[str, Any]:
    now = asked.state
    state = None if now is None else [row for row in (now.q, now.qd, now.qdd) if row is not None]
    columns = asked.positions, asked.velocities, asked.accelerations
    verdict = gate.check(*columns, times=asked.times, state=state, stop=asked.stop)
    found = verdict.to_dict()
    if "stop" in asked.want:
        found["stop"] = _record(verdict.stop, gate)
    if "clearance" in asked.want:
        found["clearance"] = verdict.clearance
    return found


def _texts(said: Iterable[Note]) -> list[str]:
    return list(dict.fromkeys(note.text for note in said))


def _record(trajectory: Trajectory | None, gate: Gate) -> dict[str, Any] | None:
    return None if trajectory is None else trajectory_record(trajectory, gate.robot.name, gate.scene.name)


def _decoded(frame: str | bytes) -> Any:
    """The data of a frame; :class:`OptionError` for a frame that is not JSON."""
    try:
        if isinstance(frame, bytes):
            raise ValueError("it is binary")
        return pydantic_core.from_json(frame)
    except ValueError as error:
        raise OptionError(f"a frame must be JSON ({str(error)[:100]}): send it as text.") from None


def _id_in(data: Any) -> str | int | None:
    """The id of a message that may be no request."""
    try:
        return _ID.validate_python(data["id"])
    except (TypeError, LookupError, ValueError):
        return None


def _require_models(paths: Iterable[Path], allow_xacro: bool = False) -> None:
    """Raise :class:`OptionError` unless all are regular files, the first one with a model, and none is xacro.

    Errors about a model quote it, and no other file may reach a client so. Missing files are left to the reader.
    """
    for k, path in enumerate(paths):
        if os.path.exists(path) and not os.path.isfile(path):
            raise OptionError(f"{path} is a folder, a pipe or a device: give the path of a file.")
        if path.suffix.lower() == ".xacro" and not allow_xacro:
            raise OptionError(f"{path} is xacro, whose expressions are run: start the server with --allow-xacro.")
        if k == 0 and path.suffix.lower() not in _MESHES and os.access(path, os.R_OK):
            with path.open("rb") as file:
                if not _MODEL.search(file.read(1 << 20)):
                    raise OptionError(f"{path} holds no robot, scene or joint limits: give the path of one.")
        if path.suffix.lower() == ".xacro":  # which may name any file
            return
