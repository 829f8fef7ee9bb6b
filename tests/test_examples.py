"""The examples in the docstrings of public names run as they stand."""

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import networkx
import numpy as np
import pytest

import planner
import planner.figures
from tests.documents import ROOT

BLOCK = re.compile(r"(?:^|\n\n)((?:    [^\n]*\n?)+)")
ELSEWHERE = {  # what needs files or objects of its own, and runs in tests of its own
    "Cell", "Progress", "Robot.from_pinocchio", "Session.task", "TaskPlan.load", "TaskPlanner", "follow", "paths_from",
    "show", "task",
}  # fmt: skip


def described(room: Any) -> Iterator[tuple[str, Any]]:
    """The public names of a module, and the methods of its classes."""
    for name in vars(room).get("__all__", dir(room)):
        thing = getattr(room, name)
        if name.startswith("_") or inspect.ismodule(thing):
            continue
        yield name, thing
        for inner, method in vars(thing).items() if inspect.isclass(thing) else ():
            if not inner.startswith("_"):
                yield f"{name}.{inner}", getattr(method, "__func__", method)


def examples() -> dict[str, str]:
    found = {}
    for room in (planner, planner.figures):
        for name, thing in described(room):
            if blocks := BLOCK.findall(inspect.getdoc(thing) or ""):
                found[name] = "\n".join(map(inspect.cleandoc, blocks))
    return {name: text for name, text in found.items() if name not in ELSEWHERE}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The objects of the examples: two plans, a trade-off, a motion, a robot, and a ``folder`` with saved files."""
    robot, folder = planner.Robot.load("panda"), tmp_path_factory.mktemp("examples")
    plan, other = (planner.plan("planar_2r", "window", beta=beta, nodes=60) for beta in (0.2, 1.0))
    tradeoff = planner.sweep("planar_2r", "window", nodes=60)
    plan.save(folder / "out")
    tradeoff.save(folder / "sweep")
    start, goal = plan.path_nodes[[0, -1]].tolist()
    names = {name: getattr(planner, name) for name in dir(planner)}
    return names | {
        "planner": planner, "np": np, "networkx": networkx, "folder": folder, "robot": robot, "plan": plan,
        "other": other, "tradeoff": tradeoff, "motion": plan.trajectory, "roadmap": plan.roadmap,
        "start": start, "goal": goal, "q": robot.home, "qd": np.zeros(robot.dof),
        "cell": planner.Cell.load(ROOT / "scenes" / "examples" / "two-arms.yaml"),
        "targets": robot.home + 0.01 * np.arange(3)[:, None],
    }  # fmt: skip


@pytest.mark.parametrize("name", examples())
def test_an_example_runs(name: str, made: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(made["folder"]))
    text = examples()[name]
    calls = {"plan": planner.plan} if re.search(r"(?<![.\w])plan\(", text) else {}
    exec(text, made | calls)
