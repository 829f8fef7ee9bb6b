"""What help, docstrings, documentation and README say of a default is what the code has."""

import re
from typing import Any

import numpy as np
import pytest

from planner import gabf
from planner.gabf.laws import SingularityFree
from planner.problem.request import PlanRequest
from planner.query.resolve import IK_STARTS
from planner.roadmap.grow import GrowthSettings, join_settings
from planner.session.session import Session
from planner.trajectory.limits import ASSUMED_JERK_PER_ACCELERATION
from tests.documents import ROOT
from tests.worlds import load

PLAIN, ARM = PlanRequest(), load("planar_2r")
SESSION = Session("planar_2r", "empty")._planning.request
JOIN = join_settings(GrowthSettings(), ARM).motions // ARM.dof
NETWORK = gabf.Network.from_arcs(*np.array([[1], [0], [1], [0]]), n_nodes=2, kernel=gabf.Additive())
HELD = float(np.array(NETWORK.source_values, dtype=float).sum())
NUMBERS = {"one": "1", "two": "2", "six": "6", "twelve": "12"}
# a file, words of it around what is told, and what the code has
TOLD: list[tuple[str, str, Any]] = [
    ("planner/problem/options.py", r"Left out, (\S+), or 0 with --roadmap", PLAIN.quality.rounds),
    (
        "planner/problem/options.py",
        r"Left out, \d+, or (\S+) with --roadmap",
        PlanRequest.from_options(roadmap="x").quality.rounds,
    ),
    ("planner/session/session.py", r"but for ``refinement_rounds``: (\S+) where left out", SESSION.quality.rounds),
    ("planner/session/session.py", r"gives up, (\S+) per joint where left out", JOIN),
    (
        "planner/roadmap/grow.py",
        r"before it gives up, (\S+) per joint",
        JOIN,
    ),
    ("planner/gabf/network.py", r"held at ``source_values`` \(k,\), (\S+) where left out", HELD),
    ("docs/howto/better_paths.md", r"(\w+) rounds are the default where a roadmap is grown", PLAIN.quality.rounds),
    ("docs/howto/better_paths.md", r"shortcuts in time keep: (\S+), or half of it", PLAIN.quality.extra_clearance),
    ("docs/howto/better_paths.md", r"plans keep (\S+) mm where there is space", 1000 * PLAIN.quality.extra_clearance),
    ("docs/howto/choose_beta.md", r"falls with w: .*?`(\w+)` \(default\)", PLAIN.quality.manipulability_cost),
    ("docs/howto/choose_beta.md", r": `(\w+)` \(default\) integrates", PLAIN.quality.cost_integration),
    ("docs/reference/commands.md", r"`--ik-solutions` \((\S+)\)", PLAIN.what.ik_solutions),
    ("docs/reference/commands.md", r"inverse kinematics starts from (\S+) seeds", IK_STARTS),
]


def _text(name: str) -> str:
    return " ".join((ROOT / name).read_text().split())


@pytest.mark.parametrize(("name", "words", "value"), TOLD, ids=[f"{name}: {words[:40]}" for name, words, _ in TOLD])
def test_the_default_that_is_told_is_the_codes(name: str, words: str, value: float | str) -> None:
    found = re.findall(words, _text(name))
    assert len(found) == 1, "the words have changed: hold the new ones"
    told = NUMBERS[found[0].lower()] if found[0].lower() in NUMBERS else found[0]
    assert told == value if isinstance(value, str) else float(told) == pytest.approx(value)


def test_the_defaults_of_the_library_are_those_of_the_command_line() -> None:
    """Functions that repeat a default of the request have the same one."""
    assert PLAIN.with_options(robot="planar_2r", scene="empty", refinement_rounds=0, extra_clearance=0.0) == SESSION
    assert SingularityFree(T=PLAIN.quality.prescribed_time) == gabf.named_law(
        PLAIN.quality.law, PLAIN.quality.prescribed_time
    )
    assert ASSUMED_JERK_PER_ACCELERATION == 100.0, "docs and plan.json say 100/s"
