"""The gate behind a server answers as the one of this process; without an answer the robot holds."""

import subprocess
import sys
from collections.abc import Iterator

import numpy as np
import pytest

from planner.base.errors import OptionError, PlannerError
from planner.lerobot import ActionFilter, ServedGate
from planner.serve.server import run_server
from planner.session.gate import Gate
from tests.lerobot.conftest import FPS, NAMES, Clock, chunk_to

TOKEN = "0123456789abcdef-lerobot"
WALL = {"name": "wall", "type": "box", "size": [0.5, 0.02, 0.6], "position": [0.3, 0.2, 0.3]}


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with run_server(TOKEN) as there:
        yield there


@pytest.fixture
def served(address: str) -> Iterator[ServedGate]:
    there = ServedGate(address, TOKEN, timeout=20.0, robot="so101", scene="empty")
    there.client.ask("change", changes=[{"do": "add", "obstacle": WALL}])
    yield there
    there.client.close()


def test_both_gates_decide_alike(served: ServedGate, gate: Gate) -> None:
    for options in ({"unsafe": "stop"}, {"rest": "retime"}, {"units": "normalized"}):
        there, here = (
            ActionFilter(each, NAMES, fps=FPS, clock=Clock(), **options)  # type: ignore[arg-type]
            for each in (served, gate)
        )
        for chunk in (chunk_to(40.0), chunk_to(-80.0), chunk_to(60.0, 3), chunk_to(-80.0, 1), chunk_to(-80.0, 1)):
            results = []
            for each in (there, here):
                each.observe(np.zeros(6))
                results.append(each.judge(chunk))
            np.testing.assert_array_equal(results[0].actions, results[1].actions)
            assert results[0].to_dict() == results[1].to_dict()
        assert there.counts == here.counts


def test_a_server_that_is_gone_holds_the_robot(address: str) -> None:
    there = ServedGate(address, TOKEN, timeout=20.0, robot="so101", scene="empty")
    actions = ActionFilter(there, NAMES, fps=FPS, clock=Clock())
    actions.observe(np.ones(6))
    assert actions.judge(chunk_to(20.0)).outcome == "safe"
    there.client.close()
    actions.observe(np.ones(6))
    found = actions.judge(chunk_to(20.0))
    assert (found.outcome, found.proven) == ("held", False)
    assert "must stay connected" in str(found.reason)
    np.testing.assert_allclose(found.actions[0, :, :5], 1.0)


def test_a_late_answer_is_not_taken_for_that_of_a_later_request(served: ServedGate) -> None:
    served.client.timeout = 0.0
    with pytest.raises(PlannerError, match="within 0 s"):
        served.client.ask("check", positions=[[9.0] * 5], times=[0.1], stop=False)
    served.client.timeout = 20.0
    found = served.client.ask("check", positions=[[0.0] * 5, [0.01] * 5], times=[0.0, 0.5], stop=False)
    assert found["safe"]


def test_what_the_server_refuses_is_its_sentence(address: str) -> None:
    with pytest.raises(PlannerError, match="robot 'r2d2' not found"):
        ServedGate(address, TOKEN, timeout=20.0, robot="r2d2")
    with pytest.raises(OptionError, match="must be a running 'planner serve' with this token"):
        ServedGate(address, "of somebody else", robot="so101")


def test_a_served_gate_loads_no_robot_library() -> None:
    heavy = ("pinocchio", "scipy", "pydantic", "ompl", "fcl", "coal", "trimesh", "planner.native.compiled")
    code = f"import sys, planner.lerobot; print([name for name in {heavy} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
