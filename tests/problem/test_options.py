"""Options by name: each belongs to one part, a wrong one is refused with the nearest name, ranges hold everywhere."""

from __future__ import annotations

import inspect
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

import planner
from planner.base.errors import KeywordError, OptionError
from planner.problem.request import (
    FollowRequest,
    PlanRequest,
    Request,
    RoadmapRequest,
    SweepRequest,
    TaskRequest,
    build_request,
)

REQUESTS = (PlanRequest, SweepRequest, FollowRequest, RoadmapRequest, TaskRequest)


@pytest.mark.parametrize("kind", REQUESTS)
def test_an_option_is_in_one_part_and_has_one_type_in_all_requests(kind: type[Request]) -> None:
    assert len(set(kind.names())) == len(kind.names())
    of_plan = {field.name: field.type for part in vars(PlanRequest()).values() for field in fields(part)}
    for part in vars(kind()).values():
        for field in fields(part):
            if field.name in of_plan and field.name != "start":  # a tool path needs none
                assert field.type == of_plan[field.name]


def test_a_misspelt_option_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(
        KeywordError, match=r"option 'betta' of plan not found \(did you mean 'beta'\?\): options are robot,"
    ):
        planner.plan(betta=0.2)
    with pytest.raises(
        OptionError, match=r"option 'velocity_scale' of plan not found: give it as timing=planner.TimingRequest"
    ):
        planner.plan(velocity_scale=0.2)
    with pytest.raises(TypeError, match="option 'colour' of plan not found: options are"):
        planner.plan(colour="red")


def test_an_objective_says_its_options_at_once_and_none_of_them_twice() -> None:
    objective = planner.Objective(0.2, "inverse", "workspace", "nodes", 0.01)
    own: dict[str, Any] = {
        "beta": 0.2,
        "manipulability_cost": "inverse",
        "metric": "workspace",
        "cost_integration": "nodes",
    }
    plain = PlanRequest.from_options(seed=3, nodes=7)
    request = build_request(plain, objective, {"nodes": 7})
    assert request == plain.with_options(**own, min_manipulability=0.01)
    assert request.quality.objective == objective
    for name in (*own, "min_manipulability"):
        with pytest.raises(KeywordError, match=f"{name} must be given once"):
            planner.plan(objective=objective, **{name: {**own, "min_manipulability": 0.0}[name]}, timing=None)
    small: dict[str, Any] = {"robot": "planar_2r", "scene": "empty", "path_only": True}
    by_objective = planner.plan(objective=planner.Objective(0.2), **small, timing=None)
    np.testing.assert_array_equal(planner.plan(beta=0.2, **small, timing=None).path, by_objective.path)


SHARED = ["robot", "scene", "request", "timing", "objective", "progress", "options"]


@pytest.mark.parametrize("name", ["plan", "sweep", "follow", "task", "check", "Session", "Gate"])
def test_the_front_is_one(name: str) -> None:
    """Functions take what they share under the same names, in the same order, and times by default."""
    given = inspect.signature(getattr(planner, name)).parameters
    shared = [each for each in given if each in SHARED]
    assert shared == [each for each in SHARED if each in shared]
    assert {"robot", "scene"} <= set(shared)
    assert "timing" not in given or given["timing"].default == planner.TimingRequest()
    positional = [each for each, said in given.items() if said.kind is said.POSITIONAL_OR_KEYWORD]
    assert positional == (["robot", "scene"] if name in ("plan", "sweep", "Session", "Gate") else [next(iter(given))])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("beta", value) for value in (-0.1, 1.1, np.nan, "a lot", None)),
        *(("nodes", value) for value in (1, 50.5, True, None, 10**8)),
        *(
            ("law", "quick"),
            ("margin", None),
            ("margin", -1.0),
            ("seed", -1),
            ("seed", 2**31),
            ("refinement_rounds", -1),
        ),
        *(("approach", 2.0), ("approach", 1e-4), ("prescribed_time", 0.0), ("ik_solutions", 0), ("robot", 3)),
        *(("joints", "a,,b"), ("joints", ["a", "a"]), ("base", "1,2"), ("constraint", 3), ("constraint", "axis:z")),
    ],
)
def test_a_value_out_of_range_is_one_sentence_with_its_name(name: str, value: object) -> None:
    with pytest.raises(OptionError) as refused:
        PlanRequest.from_options(**{name: value})
    text = str(refused.value)
    assert text.endswith(".")
    assert "\n" not in text
    assert name.replace("_", " ") in text or name in text or "condition" in text
