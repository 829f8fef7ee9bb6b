"""Options are parts of requests: one definition each, which every command that has the option embeds."""

from __future__ import annotations

import dataclasses
import inspect

import pytest

from planner.problem.request import LimitsRequest, LiveRequest, PlanRequest, TimingRequest, WorkersRequest

REQUESTS = (PlanRequest, TimingRequest, LiveRequest)


def definers(kind: type, option: str) -> list[type]:
    return [base for base in kind.__mro__ if option in inspect.get_annotations(base)]


@pytest.mark.parametrize("kind", REQUESTS, ids=lambda kind: kind.__name__)
def test_a_requests_option_has_one_definition(kind: type) -> None:
    """Robot, scene and margin have a second one, for a roadmap whose file says them where they are left out."""
    for field in dataclasses.fields(kind):
        found = [base.__name__ for base in definers(kind, field.name)]
        assert found in ([found[0]], ["WorldRequest", "KeptWorld"]), field.name
        assert len(found) == 1 or field.name in ("robot", "scene", "margin")


def test_requests_share_them() -> None:
    where: dict[str, type] = {}
    for kind in (*REQUESTS, WorkersRequest, LimitsRequest):
        for field in dataclasses.fields(kind):
            part = definers(kind, field.name)[0]
            assert where.setdefault(field.name, part) is part, field.name
