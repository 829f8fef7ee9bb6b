"""``benchmarks scaling``, ``partition`` and ``stale``: help, wrong options, and what is handed on."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.block_commands import partition, scaling, stale
from benchmarks.partition.run import bench_partition
from benchmarks.partition.stale import bench_stale
from benchmarks.scaling.run import bench_scaling
from tests.command_line import Run, assert_refused

LIBRARY: dict[str, Callable[..., Any]] = {"scaling": bench_scaling, "partition": bench_partition, "stale": bench_stale}


@pytest.mark.parametrize("name", LIBRARY)
def test_every_benchmark_has_help(name: str, run: Run) -> None:
    code, text, _ = run(name, "--help", program="benchmarks")
    assert code == 0
    assert "--out" in text
    assert f"{name}.csv and {name}.md" in " ".join(text.replace("│", " ").split())


@pytest.mark.parametrize("command", [scaling, partition, stale])
def test_the_commands_defaults_are_the_librarys(command: Callable[..., int]) -> None:
    """The command line spells them out, so that its help loads nothing heavy."""
    library = inspect.signature(LIBRARY[command.__name__]).parameters
    for name, option in inspect.signature(command).parameters.items():
        if name in library and library[name].default is not inspect.Parameter.empty:
            assert option.default == library[name].default, name


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (("scaling", "nowhere"), 3, "nowhere"),
        (("scaling", "plans.csv", "--jobs", "0"), 2, "jobs"),
        (("partition", "--arcs", "5"), 2, "arcs"),
        (("partition", "--blocks", "1"), 2, "blocks"),
        (("partition", "--steps", "0"), 2, "step"),
        (("stale", "--graphs", "0"), 2, "at least 1 graph"),
        (("stale", "--seed", "-1"), 2, "seed -1"),
    ],
)
def test_wrong_input_is_one_sentence(
    arguments: tuple[str, ...], code: int, text: str, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plans.csv").write_text("name,beta\none,0.5\n")
    out = tmp_path / "out"
    assert_refused(run(*arguments, "--out", str(out), program="benchmarks"), code, text, out)


@pytest.mark.parametrize(
    ("arguments", "module", "handed"),
    [
        (
            ("scaling", "plans.csv", "--nodes", "7", "--jobs", "1", "3", "--scheduler", "tcp://x:1"),
            "scaling.run",
            {"source": Path("plans.csv"), "jobs": (1, 3), "scheduler": "tcp://x:1"},
        ),
        (
            ("partition", "--arcs", "200", "300", "--blocks", "3", "--steps", "9", "--seed", "4"),
            "partition.run",
            {"arcs": (200, 300), "blocks": 3, "steps": 9, "seed": 4},
        ),
        (("stale", "--graphs", "2", "--seed", "4"), "partition.stale", {"graphs": 2, "seed": 4}),
    ],
)
@pytest.mark.parametrize("complete", [True, False])
def test_every_option_is_handed_on_and_a_stop_is_the_exit_code(
    arguments: tuple[str, ...],
    module: str,
    handed: dict[str, object],
    complete: bool,
    tmp_path: Path,
    run: Run,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found: dict[str, Any] = {}
    target = f"benchmarks.{module}.bench_{arguments[0]}"
    signature = inspect.signature(LIBRARY[arguments[0]])

    def bench(*args: object, **more: object) -> SimpleNamespace:
        found.update(signature.bind(*args, **more).arguments)
        return SimpleNamespace(report="what was measured", complete=complete)

    monkeypatch.setattr(target, bench)
    code, text, _ = run(*arguments, "--out", str(tmp_path / "out"), program="benchmarks")
    assert code == (0 if complete else 130)
    assert "what was measured" in text
    assert {name: found[name] for name in handed} == handed
    assert found["out"] == tmp_path / "out"
    if arguments[0] == "scaling":
        assert found["plain"].nodes == 7
