"""The options of planner.plan: the fields of its request, and a name that is none of them is told from the nearest."""

# pyright: reportUnnecessaryTypeIgnoreComment=true
# so that pyright, which 'make test' runs, fails here should it no longer refuse what is marked as refused
from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Unpack, get_type_hints

import numpy as np
import pytest

import planner
from planner.base.errors import KeywordError, OptionError
from planner.planning.plan import plan
from planner.problem.options import PlanOptions, plan_request
from planner.problem.request import PlanRequest


def test_the_options_are_the_fields_of_the_request() -> None:
    """Both are written down, as no type checker reads one out of the other: names, order and types are the same."""
    options = {name: getattr(kind, "__forward_arg__", kind) for name, kind in PlanOptions.__annotations__.items()}
    assert options == {field.name: field.type for field in fields(PlanRequest)}
    assert not PlanOptions.__required_keys__
    assert get_type_hints(plan)["options"] == Unpack[PlanOptions]


def test_a_misspelt_option_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(
        KeywordError, match=r"plan knows no option 'betta' \(did you mean 'beta'\?\): options are robot,"
    ):
        planner.plan(betta=0.2)  # pyright: ignore[reportCallIssue]
    with pytest.raises(OptionError, match=r"knows no option 'velocity_scale': give it as timing=planner.TimingRequest"):
        planner.plan(velocity_scale=0.2)  # pyright: ignore[reportCallIssue]
    with pytest.raises(TypeError, match="knows no option 'colour': options are"):
        planner.plan(colour="red")  # pyright: ignore[reportCallIssue]


def test_an_objective_says_its_options_at_once_and_none_of_them_twice() -> None:
    objective = planner.Objective(0.2, "inverse", "workspace", "nodes", 0.01)
    request = plan_request(PlanRequest(seed=3), {"nodes": 7}, objective)
    assert request == PlanRequest(
        seed=3,
        nodes=7,
        beta=0.2,
        manipulability_cost="inverse",
        metric="workspace",
        charge="nodes",
        min_manipulability=0.01,
    )
    assert request.objective == objective
    with pytest.raises(KeywordError, match="beta is a part of the objective"):
        planner.plan(objective=objective, beta=0.5)
    with pytest.raises(KeywordError, match="min_manipulability is a part of the objective"):
        planner.plan(objective=objective, min_manipulability=0.0)
    one, other = (
        planner.plan(robot="planar_2r", scene="empty", path_only=True, beta=0.2),
        planner.plan(robot="planar_2r", scene="empty", path_only=True, objective=planner.Objective(0.2)),
    )
    np.testing.assert_array_equal(one.path, other.path)


def test_a_checker_of_types_takes_what_plan_takes_and_nothing_else() -> None:
    """What pyright has to accept, and, marked, what it has to refuse."""
    options: PlanOptions = {"robot": Path("a.urdf"), "roadmap": "r.npz", "start": np.zeros(2), "joints": ["a", "b"]}
    request = plan_request(None, options)
    assert (request.robot, request.roadmap, request.joints) == ("a.urdf", Path("r.npz"), "a,b")
    assert plan_request(PlanRequest(seed=3), {"nodes": 7}) == PlanRequest(seed=3, nodes=7)
    refused = (
        lambda: planner.plan(law="quick"),  # pyright: ignore[reportArgumentType]
        lambda: planner.plan(beta="a lot"),  # pyright: ignore[reportArgumentType]
        lambda: planner.plan(nodes=50.5),  # pyright: ignore[reportArgumentType]
        lambda: planner.plan(margin=None),  # pyright: ignore[reportArgumentType]
    )
    for call in refused:
        with pytest.raises(OptionError, match=r": give |; laws are "):
            call()
    assert plan_request(None, {"nodes": 7, "beta": 1, "effort": None}).nodes == 7
