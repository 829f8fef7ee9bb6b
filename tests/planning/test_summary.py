"""What the rows of a plan's summary promise is no more than what its record holds."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import planner
from planner.cost.scale import manipulability_cost
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.planning.result import plan_record
from planner.planning.summary import summary_rows
from planner.trajectory.measure import dense_path


@cache
def solved() -> planner.Plan:
    return planner.plan(robot="panda", scene="empty", start="home", goal="xyz:0.45,0.25,0.5", beta=1.0, nodes=60)


def rows(bound: float, gap: float | None, tau: float | None = 10.0, remaining: float = 0.0) -> dict[str, str]:
    record: dict[str, Any] = plan_record(solved())
    record["quality"] |= {"lower_bound": bound, "gap": gap}
    certificate = {"quantity": "settling tau", "applies": True, "proven": True, "name": "ours", "bound": tau}
    record["gabf"] |= {"certificate": [certificate | {"log10_remaining": remaining}]}
    return dict(summary_rows(record))


@pytest.mark.parametrize(
    ("bound", "gap", "told"),
    [
        (0.24637, 0.00032, ("0.2463;", "0.1 %")),
        (0.2463, 0.021, ("0.2463;", "2.1 %")),
        (0.2463, -1e-16, ("0.2463;", " 0.0 %")),
        (0.24631, None, ("less than 0.2463",)),
    ],
)
def test_a_bound_on_the_cost_is_rounded_to_the_side_on_which_it_holds(
    bound: float, gap: float | None, told: tuple[str, ...]
) -> None:
    assert all(words in rows(bound, gap)["bound"] for words in told)


def test_a_bound_on_the_settling_time_is_rounded_up_and_what_is_left_down() -> None:
    assert rows(0.1, 0.1, 12.34, np.log10(0.0468))["certified"].startswith("to settle by tau = 12.4, 0.046 s before")
    assert rows(0.1, 0.1, 1e40)["certified"].startswith("to settle by tau = 1000000")
    assert "certified" not in rows(0.1, 0.1, None)


def test_a_short_settling_time_is_not_rounded_to_none() -> None:
    record: dict[str, Any] = plan_record(solved())
    for time, T, told in (
        (3.4e-7, 1e-6, "at t = 3.4e-07 of T_p = 1e-06 s"),
        (3.99871, 4.0, "at t = 3.9987 of T_p = 4 s"),
    ):
        record["gabf"] |= {"settling_time": time, "prescribed_time": T}
        assert dict(summary_rows(record))["settled"].startswith(told)


@pytest.mark.parametrize(("latest", "told"), [(None, True), (9.0, False)])
def test_a_settling_time_that_is_not_enclosed_says_so(latest: float | None, told: bool) -> None:
    record: dict[str, Any] = plan_record(solved())
    record["gabf"] |= {"settling_tau_bracket": [0.0, latest]}
    assert dict(summary_rows(record))["settled"].endswith("; not enclosed: too many steps") == told


def test_another_configuration_of_the_same_tool_position_may_cost_less() -> None:
    plan, start = solved(), solved().path[0]
    bound = plan_record(plan)["quality"]["lower_bound"]
    target, q = tool_positions(plan.robot, plan.path[-1:])[0], plan.path[-1]
    for _ in range(200):  # towards the start in the null space of the tool's position, and back onto the target
        ahead = np.array([tool_positions(plan.robot, (q + step)[None])[0] for step in 1e-6 * np.eye(q.size)])
        here = tool_positions(plan.robot, q[None])[0]
        slope = (ahead - here).T / 1e-6
        inverse = np.linalg.pinv(slope)
        q = q + inverse @ (target - here) + 0.1 * (np.eye(q.size) - inverse @ slope) @ (start - q)
    assert np.abs(tool_positions(plan.robot, q[None])[0] - target).max() < 1e-6
    assert np.linalg.norm(q - start) / plan.roadmap.scale.joint_length < 0.99 * bound
    assert "between the roadmap's start and goal configurations" in dict(summary_rows(plan_record(plan)))["bound"]


def test_a_dip_of_w_between_the_states_of_edges_is_told() -> None:
    """Refinement seeks what is priced too low: with 1/w a path cost a quarter more than was said."""
    plan = planner.plan(
        robot="kinova", scene="empty", start="home", goal="xyz:0.3,0.3,0.5", beta=0.0, manipulability_cost="inverse",
        nodes=300,
    )  # fmt: skip
    record, scale = plan_record(plan), plan.roadmap.scale
    states = dense_path(plan.path, 1e-3)
    omega = manipulability_cost(manipulability(plan.robot, states), scale, "inverse")
    step = np.linalg.norm(np.diff(states, axis=0), axis=1) / scale.joint_length
    finely = float((0.5 * (omega[1:] + omega[:-1]) * step).sum())
    assert record["quality"]["manipulability_cost"] == pytest.approx(finely, rel=2e-3)
    assert finely > 1.1 * record["cost"]["manipulability"]
    assert dict(summary_rows(record))["integral"].startswith(f"{record['quality']['manipulability_cost']:.4f} ")
    assert "integral" not in dict(summary_rows(plan_record(solved())))
