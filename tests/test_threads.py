"""The same request gives the same bits whatever other threads of the process do."""

import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from planner.collision import make_checker
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.session.session import Session

THREADS = 4
REQUESTS = [
    PlanRequest.from_options(robot="planar_2r", scene="cage", nodes=40, refinement_rounds=2),
    PlanRequest.from_options(robot="planar_2r", scene="cage", nodes=40, refinement_rounds=2, seed=1, collision="coal"),
    PlanRequest.from_options(robot="panda", scene="shelf", path_only=True, refinement_rounds=0),
    PlanRequest.from_options(robot="ur5", scene="table", nodes=40, refinement_rounds=2, beta=0.2, collision="coal"),
]


@pytest.fixture(autouse=True)
def _threads_alternate() -> Any:
    """Threads change places every 0.1 ms in place of every 5 ms, so that they meet at every step."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    yield
    sys.setswitchinterval(before)


def at_once(work: Callable[[Any], Any], items: list[Any]) -> list[Any]:
    """The results of ``work`` for the items, all begun together."""
    gate = threading.Barrier(len(items))

    def begin(item: Any) -> Any:
        gate.wait()
        return work(item)

    with ThreadPoolExecutor(len(items)) as pool:
        return list(pool.map(begin, items))


def _answer(request: PlanRequest) -> tuple[str, bytes]:
    found = plan(request=request, timing=None)
    assert found.cost is not None
    return found.roadmap.sha256, found.path.tobytes()


def test_plans_in_four_threads_are_those_of_one() -> None:
    alone = [_answer(request) for request in REQUESTS]
    for _ in range(2):
        assert at_once(_answer, REQUESTS) == alone


def _session(position: float) -> list[bytes]:
    session = Session("planar_2r", "cage", nodes=40)
    paths = [session.plan(timing=None).path.tobytes()]
    name = session.scene.obstacles[0].name
    session.move(name, position=session.scene.obstacles[0].placement[:3, 3] + [position, 0.0, 0.0])
    return [*paths, session.replan().path.tobytes()]


def test_sessions_in_threads_of_their_own_answer_as_alone() -> None:
    shifts = [0.0, 0.05, -0.05, 0.1]
    alone = [_session(shift) for shift in shifts]
    assert at_once(_session, shifts) == alone


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_one_checker_answers_four_threads_as_one(backend: str) -> None:
    robot, scene = Robot.load("panda"), Scene.load("shelf")
    checker = make_checker(robot, scene, backend)
    q = np.random.default_rng(0).uniform(robot.lower, robot.upper, (THREADS, 150, robot.dof))

    def contacts(rows: np.ndarray) -> list[str]:
        return [str(checker.first_contact(row[None])) for row in rows]

    alone = [contacts(rows) for rows in q]
    assert at_once(contacts, list(q)) == alone
