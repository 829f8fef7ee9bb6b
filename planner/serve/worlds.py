"""The worlds of a server: each has a gate, which knows every change at once, and a session, which plans in it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from planner.base.errors import OptionError, PlannerError, choices
from planner.base.notes import Note
from planner.base.progress import Progress
from planner.planning.motion import timed
from planner.planning.result import Plan
from planner.problem.request import LimitsRequest, TimingRequest
from planner.query.robots import robot_sources, scene_sources
from planner.robot.model_checks import notes
from planner.robot.scene import mesh_notes, obstacle_of
from planner.serve import messages as ask
from planner.serve.files import require_models
from planner.session.gate import JUDGED, Gate
from planner.session.session import Session
from planner.trajectory.file import trajectory_record
from planner.trajectory.trajectory import Trajectory

Tell = Callable[[dict[str, Any]], None]
_MOST = 64  # worlds


@dataclass(eq=False)
class World:
    """One robot in one scene. A change reaches the gate at once, and the session before its next plan."""

    name: str
    gate: Gate
    session: Session
    beta: float | None = None  # of plans that say none; the session's own where left out
    listeners: dict[object, Tell] = field(default_factory=dict)
    replaced: bool = False  # another one has its name
    _of_added: list[Note] = field(default_factory=list)  # what was passed over in files of obstacles that were added
    _waiting: list[Callable[[Session], object]] = field(default_factory=list)
    _apart: str | None = None  # why the session is not in the gate's world
    _order: threading.Lock = field(default_factory=threading.Lock)
    _planning: threading.Lock = field(default_factory=threading.Lock)
    _notes: list[str] = field(init=False)

    def __post_init__(self) -> None:
        self._notes = self._noted()

    @staticmethod
    def of(asked: ask.Load, progress: Progress) -> World:
        """What a client asked for; :class:`PlannerError` for what cannot be loaded, or is to end before it is."""
        numbers = asked.limits.model_dump()
        limits = LimitsRequest(limits=numbers.pop("file"), **numbers)
        judged = JUDGED if asked.judged is None else tuple(asked.judged)
        floor = asked.min_manipulability
        kept = {"margin": asked.margin, "tool": asked.tool, "min_manipulability": floor, "keep": asked.keep}
        gate = Gate(asked.robot, asked.scene, limits, judged=judged, **kept)
        _go_on(progress)
        given: dict[str, Any] = {} if asked.nodes is None else {"nodes": asked.nodes}
        session = Session(asked.robot, asked.scene, seed=asked.seed, **kept, **given)
        return World(asked.world, gate, session, asked.beta)

    def record(self) -> dict[str, Any]:
        """The world as plain data."""
        robot, scene = self.gate.robot, self.gate.scene
        return {
            "world": self.name,
            "robot": robot.name,
            "scene": scene.name,
            "joints": list(robot.joints),
            **self.gate.to_dict(),
            "obstacles": [item.name for item in scene.obstacles],
            "carried": [item.name for item in scene.carried],
            "notes": self._notes,
        }

    def _noted(self) -> list[str]:
        """What is doubtful about robot and scene as they are now, and what of their files was passed over."""
        found = (*notes(self.gate.robot, self.gate.scene), *self._of_added)
        return list(dict.fromkeys(note.text for note in found))

    def check(self, asked: ask.Check) -> dict[str, Any]:
        """The gate's verdict on a chunk."""
        rows = (asked.state.q, asked.state.qd, asked.state.qdd) if asked.state else ()
        verdict = self.gate.check(
            asked.positions,
            asked.velocities,
            asked.accelerations,
            times=asked.times,
            state=[row for row in rows if row is not None] or None,
            stop=asked.stop,
        )
        found = {"world": self.name, **verdict.to_dict()}
        if "stop" in asked.want:
            found["stop"] = _record(verdict.stop, self.gate.robot.name, self.gate.scene.name)
        if "clearance" in asked.want:
            found["clearance"] = verdict.clearance
        return found

    def change(self, asked: ask.Change) -> dict[str, Any]:
        """Apply changes to the gate now, and to the session before it plans again; what comes first is done first."""
        begin, done, before = time.perf_counter(), 0, self._notes
        try:
            for each in asked.changes:
                with self._order:
                    self._waiting.append(_applied(each, self.gate))
                if isinstance(each, ask.Add):
                    self._of_added += mesh_notes([each.obstacle])
                done += 1
        finally:
            if not all(isinstance(each, ask.Move) for each in asked.changes[:done]):
                self._notes = self._noted()
            if done:
                self.tell({"event": "world", **self.record()})
        new = [note for note in self._notes if note not in before]
        seconds, revision = time.perf_counter() - begin, self.record()["revision"]
        return {"changes": done, "revision": revision, "seconds": seconds, "notes": new}

    def plan(self, question: Callable[[Session, Progress], Plan], motion: bool, progress: Progress) -> dict[str, Any]:
        """The answer to a question, asked in the world as it is when its turn comes."""
        while not self._planning.acquire(timeout=0.05):
            _go_on(progress)
        try:
            self._catch_up()
            _go_on(progress)
            plan = question(self.session, progress)
            made = self._motion(plan) if motion and plan.solved and len(plan.path) > 1 else None
            _go_on(progress)
        except PlannerError as error:
            if self.replaced:  # its session is closed: that is why
                raise PlannerError(f"world '{self.name}' was replaced meanwhile: ask again.") from None
            if type(error) is PlannerError:  # of no input: where it was ended, the session's sentence is not a client's
                _go_on(progress)
            raise
        finally:
            self._planning.release()
        self.tell({"event": "field", "world": self.name, **_field(plan)})
        return _answer(plan, made)

    def _catch_up(self) -> None:
        """Let the session take what the gate has taken; :class:`PlannerError` from then on where it cannot."""
        self.session.leave()  # the gate knows no place of the arm: a plan from where it touches now is refused
        while self._waiting:
            if self._apart is None:
                try:
                    self._waiting[0](self.session)
                except PlannerError as error:
                    self._apart = str(error)
            del self._waiting[0]
        if self._apart is not None:
            why = self._apart.rstrip(".")
            raise PlannerError(f"the planner cannot take a change that the gate has taken ({why}): load it anew.")

    def _motion(self, plan: Plan) -> Trajectory:
        return timed(plan, TimingRequest(), self.gate.limits)

    def tell(self, event: dict[str, Any]) -> None:
        """Tell all who listen."""
        for listener in list(self.listeners.values()):
            listener(event)


class Worlds:
    """The worlds of a server by name; clients share them. Xacro is expanded only where that is allowed."""

    def __init__(self, allow_xacro: bool = False) -> None:
        self._allow_xacro = allow_xacro
        self._alone, self._known = threading.Lock(), dict[str, World]()

    def load(self, asked: ask.Load, progress: Progress) -> World:
        """A world anew; none where that is to end before it is there."""
        self._require_new(asked)
        limits = [] if asked.limits.file is None else [Path(asked.limits.file)]
        for paths in (robot_sources(asked.robot), scene_sources(asked.scene), limits):
            require_models(paths, self._allow_xacro)
        world = World.of(asked, progress)
        with self._alone:
            _go_on(progress)
            self._require_new(asked)
            old = self._known.get(asked.world)
            self._known[asked.world] = world
            if old is not None:
                world.listeners.update(old.listeners)
        if old is not None:
            old.replaced = True
            old.session.close()
            world.tell({"event": "world", **world.record()})
        return world

    def _require_new(self, asked: ask.Load) -> None:
        if asked.world in self._known and not asked.replace:
            raise OptionError(f"world '{asked.world}' is there already: name another, or say replace.")
        if asked.world not in self._known and len(self._known) >= _MOST:
            raise OptionError(f"there are {_MOST} worlds already: replace one.")

    def __getitem__(self, name: str) -> World:
        world = self._known.get(name)
        if world is None:
            there = f"there are {choices(self._known)}" if self._known else "there is none yet"
            raise OptionError(f"world '{name}' not found, {there}: load it first.")
        return world

    def all(self) -> list[World]:
        """All of them."""
        return list(self._known.values())

    def forget(self, listener: object) -> None:
        """A client is gone."""
        with self._alone:
            for world in self.all():
                world.listeners.pop(listener, None)

    def close(self) -> None:
        """End all plans that are under way."""
        for world in self.all():
            world.session.close()


def _go_on(progress: Progress) -> None:
    if progress.stopped:
        raise PlannerError("stopped before it was done: it was cancelled, or its time is over.")


def _applied(asked: ask.Changing, gate: Gate) -> Callable[[Session], object]:
    """Apply a change to the gate; the same for a session."""
    match asked:
        case ask.Move(name=name):
            gate.move(name, asked.matrix())
            turned = {"quaternion": asked.quaternion or (0, 0, 0, 1)} if asked.rpy is None else {"rpy": asked.rpy}
            return lambda session: session.move(name, asked.position, **turned)
        case ask.Add():
            if asked.obstacle.type == "mesh":
                require_models([Path(asked.obstacle.file)])
            given: dict[str, Any] = {"obstacle": obstacle_of(asked.obstacle)}
        case _:
            given = asked.model_dump(exclude={"do"})
    getattr(gate, asked.do)(**given)
    return lambda session: getattr(session, asked.do)(**given)


def _field(plan: Plan) -> dict[str, Any]:
    """The state of the field that a plan has left."""
    cost = None if plan.cost is None else plan.cost.total
    return {
        "outcome": plan.outcome.key,
        "nodes": len(plan.roadmap.nodes),
        "cost": cost,
        "error": plan.max_error_vs_oracle,
    }


def _answer(plan: Plan, motion: Trajectory | None) -> dict[str, Any]:
    return {
        "outcome": plan.outcome.key,
        "message": plan.message,
        "joints": list(plan.robot.joints),
        "path": plan.path.tolist(),
        "reason": None if plan.reason is None else plan.reason.to_dict(),
        "field": _field(plan),
        "motion": _record(motion, plan.robot.name, plan.scene.name),
        "notes": list(plan.end_notes),
    }


def _record(trajectory: Trajectory | None, robot: str, scene: str) -> dict[str, Any] | None:
    return None if trajectory is None else trajectory_record(trajectory, robot, scene)
