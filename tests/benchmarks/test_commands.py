"""``python -m benchmarks`` as its users type it: help, wrong options, exit codes, Ctrl-C."""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest

from benchmarks.agreement.run import bench_agreement
from benchmarks.attack.run import bench_attack
from benchmarks.commands import agreement, attack, gate, misses, roadmap, tasks
from benchmarks.gate.run import bench_gate
from benchmarks.misses.run import bench_misses
from benchmarks.roadmap.run import bench_roadmap
from benchmarks.tasks.run import bench_tasks
from tests.command_line import Run, assert_refused


@pytest.mark.parametrize(
    "name",
    [
        "gabf",
        "plan",
        "first-motion",
        "proofs",
        "gate",
        "misses",
        "agreement",
        "attack",
        "certificate",
        "roadmap",
        "tasks",
    ],
)
def test_every_benchmark_has_help(name: str, run: Run) -> None:
    code, text, _ = run(name, "--help", program="benchmarks")
    assert code == 0
    assert "--out" in text
    assert "--debug" in text


def test_the_commands_defaults_are_the_librarys() -> None:
    """The command line spells them out, so that its help loads nothing heavy."""
    pairs = (
        (gate, bench_gate),
        (misses, bench_misses),
        (agreement, bench_agreement),
        (attack, bench_attack),
        (roadmap, bench_roadmap),
        (tasks, bench_tasks),
    )
    for command_, function in pairs:
        library = inspect.signature(function).parameters
        for name, option in inspect.signature(command_).parameters.items():
            if name in library and library[name].default is not inspect.Parameter.empty:
                assert option.default == library[name].default, name


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (("plan", "nowhere"), 3, "nowhere holds no problems"),
        (("plan", "."), 3, "holds no problems"),
        (("plan", ".", "--beta", "2"), 2, "beta 2 is outside"),
        (("plan", ".", "--time-limit", "0"), 2, "time limit above 0"),
        (("plan", ".", "--nodes", "many"), 2, "nodes"),
        (("plan", ".", "--collision", "bullet"), 2, "fcl"),
        (("first-motion", ".", "--python", "vamp=x"), 2, "python 'vamp=x' is not usable"),
        (("first-motion", ".", "--jerk", "0"), 2, "jerk limit 0 is not usable"),
        (("proofs", "nowhere", "--python", "x"), 3, "nowhere holds no problems"),
        (("gate", "--chunks", "0"), 2, "at least 1 chunk"),
        (("gate", "--robots", "marvin"), 3, "robot 'marvin' not found"),
        (("misses", "--edges", "0"), 2, "at least 1 edge"),
        (("tasks", "--scenes", "0"), 2, "at least 1 scene"),
        (("misses", "--robots", "marvin"), 3, "robot 'marvin' not found"),
        (("misses", "--seed", "-1"), 2, "seed -1"),
        (("agreement", "--states", "3"), 2, "3 states are too few"),
        (("agreement", "--margin", "-1"), 2, "margin -1"),
        (("attack", "--tries", "0"), 2, "at least 1 try"),
        (("attack", "--robots", "marvin"), 3, "robot 'marvin' not found"),
        (("attack", "--libraries", "bullet"), 2, "fcl"),
        (("certificate", "--changes", "0"), 2, "at least 1 change"),
        (("certificate", "--robots", "marvin"), 3, "robot 'marvin' not found"),
        (("roadmap", "--robot", "marvin"), 3, "robot 'marvin' not found"),
        (("roadmap", "--scene", "moon"), 3, "scene 'moon' not found"),
        (("roadmap", "--queries", "0"), 2, "at least one query"),
    ],
)
def test_wrong_input_is_one_sentence(
    arguments: tuple[str, ...], code: int, text: str, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "out"
    assert_refused(run(*arguments, "--out", str(out), program="benchmarks"), code, text, out)
