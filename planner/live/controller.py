"""Answers the live page: every request changes the session as a whole, or not at all."""

from __future__ import annotations

import json
import logging
import secrets
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.errors import PlannerError
from planner.base.hashing import content_hash
from planner.base.progress import Stopwatch
from planner.base.yamlfile import object_of, validate
from planner.live.messages import Change, Look, MoveGoal, MoveObstacle, Reload, Request, Save, SetBeta, SetStart, Undo
from planner.live.reloaded import left_as_opened
from planner.live.state import Question, Report, State, page_of, report_of, update_of
from planner.models.files.scene_writer import write_scene
from planner.models.poses import quaternion_of
from planner.models.scene import Scene
from planner.models.shapes import Obstacle
from planner.planning.replanned import Change as WorldChange
from planner.planning.replanned import Edges
from planner.problem.targets import HOME, Named, Pose, Target, follow, joints_text, parse_target, parse_targets
from planner.session.session import Session
from planner.setup.open import states_of

_MOST_UNDO = 50  # states: each holds its world and its roadmap

_log = logging.getLogger(__name__)


class LiveController:
    """One session and the page that changes it; requests wait for each other.

    ``out`` is the file that the page's scene is saved to, ``source`` reads the scene anew. ``token``: who does not know
    it is not answered, see :func:`planner.view.serve.serve`. Raises :class:`PlannerError` for an unusable question.
    """

    def __init__(self, session: Session, question: Question, source: Callable[[], Scene], out: Path) -> None:
        self.token = secrets.token_urlsafe(24)
        self._session, self._source, self._out = session, source, out
        self._alone = threading.Lock()
        clock = Stopwatch()
        with clock("planning"):
            plan = session.plan(question.start, question.goal, question.beta)
        self._state = State.of(session, question, plan)
        self._report = report_of("opened", self._state, None, clock.seconds)
        self._past: deque[State] = deque(maxlen=_MOST_UNDO)

    def stop(self) -> None:
        """End what is being answered; every later request gets an error."""
        self._session.close()

    @property
    def message(self) -> str:
        """The outcome of the current question, as a sentence."""
        return self._state.message

    def page(self) -> str:
        """The page as things stand."""
        with self._alone:
            return page_of(self._state, self._report, len(self._past), token=self.token, file=str(self._out))

    def answer(self, request: bytes) -> bytes:
        """JSON: what changes in the page, or an ``error`` as a sentence, with the names that are to be ``red``."""
        with self._alone:
            try:
                result = self._answer(validate(Request, _parsed(request), "the request", PlannerError))
            except PlannerError as error:
                self._session.restore(self._state.snapshot)
                result = {"error": str(error), "red": sorted(error.reason.names) if error.reason else []}
            except Exception:
                self._session.restore(self._state.snapshot)
                _log.debug("a request of the page failed", exc_info=True)
                result = {"error": "The planner failed at this; the scene is as it was.", "red": []}
            return json.dumps(result, allow_nan=False).encode()

    def _answer(self, request: Request) -> dict[str, Any]:
        match request.order:
            case Save():
                written = write_scene(self._scene_to_save(), self._out)
                return {"saved": f"Written: {', '.join(map(str, written))}"}
            case Undo():
                return self._undo()
            case Look(name=name, position=position, quaternion=quaternion):
                self._session.move(name, position, quaternion=quaternion)
                holds = self._session.holds()
                self._session.restore(self._state.snapshot)
                return {"holds": holds}
            case change:
                return self._change(change)

    def _undo(self) -> dict[str, Any]:
        if not self._past:
            raise PlannerError("there is nothing to undo: nothing has been changed.")
        before, self._state = self._state, self._past.pop()
        self._session.restore(self._state.snapshot)
        self._report = Report("undone", [("total cost", report_of("", self._state, before, {}).rows[-1][1])], {})
        return self._update(before)

    def _change(self, change: Change) -> dict[str, Any]:
        clock, before = Stopwatch(), self._state
        with clock("change"):
            question, edges, told = self._apply(change)
        with clock("planning"):
            if question == before.question:
                plan = self._session.replan()
            else:
                plan = self._session.plan(question.start, question.goal, question.beta)
        plan = replace(plan, replanned=replace(plan.replanned, edges=edges + plan.edges))
        self._past.append(before)
        self._state = State.of(self._session, question, plan)
        self._report = report_of(change.what, self._state, before, clock.seconds, told)
        return self._update(before)

    def _update(self, before: State) -> dict[str, Any]:
        clock = Stopwatch()
        with clock("drawing"):
            made = update_of(self._state, before, self._report, len(self._past))
        made["live"]["seconds"] |= {name: round(value, 4) for name, value in clock.seconds.items()}
        return made

    def _apply(self, change: Change) -> tuple[Question, Edges, list[tuple[str, str]]]:
        """The question after a change of it or of the world, what that meant for edges, and what else to tell."""
        question = self._state.question
        match change:
            case MoveObstacle(name=name, position=position, quaternion=quaternion):
                return question, self._session.move(name, position, quaternion=quaternion).edges, []
            case MoveGoal(position=position):
                return replace(question, goal=self._goal_at(position)), Edges(), []
            case SetStart(joints=joints):
                return replace(question, start=joints_text(joints)), Edges(), []
            case SetBeta(beta=beta):
                return replace(question, beta=beta), Edges(), []
            case Reload():
                opened, scene = self._session.scene, self._source()
                edges = sum((each.edges for each in self._put_back(scene.obstacles)), Edges())
                return question, edges, left_as_opened(opened, scene)

    def _put_back(self, wanted: tuple[Obstacle, ...]) -> list[WorldChange]:
        """The session's obstacles made those of a scene."""
        session, new = self._session, {item.name: item for item in wanted}
        made = []
        for old in session.scene.obstacles:
            item = new.pop(old.name, None)
            if item is not None and _apart_from_place(item) == _apart_from_place(old):
                quaternion = quaternion_of(item.placement[:3, :3])
                if not np.allclose(item.placement, old.placement, atol=1e-12):
                    made.append(session.move(old.name, item.placement[:3, 3], quaternion=quaternion))
                continue
            made.append(session.remove(old.name))
            if item is not None:
                made.append(session.add(item))
        return [*made, *(session.add(item) for item in new.values())]

    def _goal_at(self, position: tuple[float, float, float]) -> str:
        """A goal at a tool position, as text; with the orientation of the current one, where it is a pose."""
        numbers = ",".join(repr(value) for value in position)
        target = self._current_goal()
        if isinstance(target, Pose):
            return f"pose:{numbers},{','.join(repr(value) for value in target.quaternion)}"
        return f"xyz:{numbers}"

    def _current_goal(self) -> Target:
        (_, target), *_ = parse_targets(self._state.question.goal)
        if isinstance(target, Named):
            states = states_of(self._session.robot, self._session.scene)
            return parse_target(follow(target.names[0], states)[0])
        return target

    def _scene_to_save(self) -> Scene:
        """The scene as it is, with what is asked as the robot's start and goal."""
        scene, question, robot = self._session.scene, self._state.question, self._session.robot
        known = {HOME: joints_text(robot.home), **states_of(robot, scene)}
        own = {
            role: _numbers_if_one(text, known) for role, text in (("start", question.start), ("goal", question.goal))
        }
        states = {**scene.states, robot.name: {**scene.states_of(robot.name), **own}}
        return replace(scene, name=self._out.stem, states=states)


def _apart_from_place(item: Obstacle) -> str:
    """A hash of all that an obstacle is, but for where."""
    return content_hash([*item.shape.content(), item.part_of, item.speed_limit])


def _numbers_if_one(text: str, known: Mapping[str, str]) -> str:
    """What a name stands for in the end, or the names of its alternatives; other text as it is."""
    found = follow(text, known)
    return found[0] if len(found) == 1 else known.get(text, text)


def _parsed(request: bytes) -> Any:
    try:
        return json.loads(request, object_pairs_hook=object_of)
    except (ValueError, RecursionError):
        raise PlannerError("the request is not JSON: reload the page.") from None
