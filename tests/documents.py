"""Blocks of code and commands in the README and the documentation."""

import re
import shlex
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.command_line import Run

ROOT = Path(__file__).resolve().parents[1]
GROUPS = ("roadmap",)
_PROGRAMS = ("planner ", "benchmarks ", "reproduce ")
_BESIDE = ("python -m benchmarks ", "python -m reproduce ")


def blocks(text: str, language: str) -> list[str]:
    """The code blocks in ``language``."""
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def commands(lines: list[str]) -> list[list[str]]:
    """The words of every command of the planner, and of the programs next to it with their name as the first word."""
    stripped = [line.strip() for line in lines]
    named = [line.removeprefix("python -m ") if line.startswith(_BESIDE) else line for line in stripped]
    return [shlex.split(line.split("#")[0]) for line in named if line.startswith(_PROGRAMS)]


def exit_codes(lines: list[str]) -> dict[tuple[str, ...], int]:
    """The exit code of each command whose line ends in '# exit code N'; the others end with 0."""
    coded = [(line, re.search(r"# exit code (\d+)$", line.strip())) for line in lines]
    return {tuple(words): int(code[1]) for line, code in coded if code for words in commands([line])}


def assert_options_are_known(words: list[str], run: Run) -> None:
    """Every option of a command is in its help."""
    code, out, _ = run(*words[1 : 3 if words[1] in GROUPS else 2], "--help", program=words[0])
    assert code == 0
    for option in (word for word in words if word.startswith("--")):
        assert re.search(rf"{option}\b", out), option


def assert_they_run(
    all_words: list[list[str]],
    run: Run,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    codes: Mapping[tuple[str, ...], int] | None = None,
) -> None:
    """One after the other, as they use each other's files; with fewer nodes, and without opening or serving pages.

    ``codes`` are exit codes other than 0.
    """
    for name in ("robots", "scenes"):
        (folder / name).symlink_to(ROOT / name)
    served: list[str] = []
    for server in (
        "planner.cli.view.open_in_browser",
        "planner.cli.plan.open_in_browser",
        "planner.cli.view._serve",
        "planner.serve.server.serve",
    ):
        monkeypatch.setattr(server, lambda page, *_, **__: served.append(str(page)[:80]))
    monkeypatch.chdir(folder)
    for k, words in enumerate(all_words):
        if words[0] == "planner" and words not in all_words[:k]:
            served.clear()
            code, out, err = run(*_quicker(words)[1:])
            assert code == (codes or {}).get(tuple(words), 0), (words, err)
            assert out or served, words
            page = words[1] in ("view", "serve") and "--out" not in words
            assert len(served) == (page or "--view" in words), words


def _quicker(words: list[str]) -> list[str]:
    """Return the command with fewer nodes, no refinement, and without a page that no later command opens."""
    words = ["20" if before == "--nodes" else word for before, word in zip(["", *words], words, strict=False)]
    options, name = set(words), words[1]
    if (name in ("plan", "sweep", "batch") or words[1:3] == ["roadmap", "build"]) and not options & {
        "--roadmap",
        "--path-only",
        "--nodes",
    }:
        words = [*words, "--nodes", "80"]
    if name in ("plan", "sweep", "batch") and "--refinement-rounds" not in options:
        words = [*words, "--refinement-rounds", "0"]
    if name in ("plan", "follow") and "--out" in options and "--view" not in options:
        words = [*words, "--no-page"]
    return words
