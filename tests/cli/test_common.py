"""What the commands share."""

from __future__ import annotations

import time
from typing import get_type_hints

import pytest

from planner.cli import common
from planner.problem.request import RoadmapRequest
from tests.command_line import Run


@pytest.mark.parametrize("kind", [RoadmapRequest])
def test_the_option_is_called_request(kind: type) -> None:
    hints = get_type_hints(kind, include_extras=True)
    assert hints["motion_plan_request"].__metadata__[0].name == "request"


@pytest.mark.parametrize("command", [("plan",), ("roadmap", "build")])
def test_help_shows_it_and_flags_without_their_opposite(run: Run, command: tuple[str, ...]) -> None:
    code, text, _ = run(*command, "--help")
    assert code == 0
    assert "--request " in text
    assert "--motion-plan-request" not in text
    assert "--debug" in text
    assert "--no-debug" not in text


def test_the_clock_began_before_any_command() -> None:
    assert time.perf_counter() > common.STARTED
