"""The documentation: every page is reached, its code and its commands run, and it keeps up with the program."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

from planner.models.scene import SceneFile
from tests.command_line import Run
from tests.documents import ROOT, assert_options_are_known, assert_they_run, blocks, commands

DOCS = ROOT / "docs"
PAGES = [path for path in sorted(DOCS.rglob("*.md")) if "_build" not in path.parts]
SHELL = {
    path: commands([line for block in blocks(path.read_text(), "sh") for line in block.splitlines()]) for path in PAGES
}
IDS = [str(path.relative_to(DOCS)) for path in PAGES]


def name_of(path: Path) -> str:
    return path.relative_to(DOCS).with_suffix("").as_posix()


def test_every_page_and_notebook_is_in_the_table_of_contents() -> None:
    listed = [
        line.strip()
        for block in re.findall(r"```\{toctree\}\n(.*?)```", (DOCS / "index.md").read_text(), re.DOTALL)
        for line in block.splitlines()
        if line.strip() and not line.startswith(":")
    ]
    notebooks = [name_of(path) for path in (DOCS / "notebooks").glob("*.ipynb")]
    assert sorted(listed) == sorted({*map(name_of, PAGES), *notebooks} - {"index"})


@pytest.mark.parametrize("path", PAGES, ids=IDS)
def test_what_a_page_refers_to_is_there(path: Path) -> None:
    text = path.read_text()
    for _, target in re.findall(r"\{doc\}`([^`<]*)<?([^`>]*)>?`", text):
        assert not target or (path.parent / target).with_suffix(".md").exists() or target.startswith("../notebooks")
    for name in re.findall(r"!?\[[^\]]*\]\(([^)#:]+)\)", text) + re.findall(r"```\{include\} (\S+)", text):
        assert (path.parent / name).exists(), name
    for name in re.findall(r"`((?:planner|tests|robots|scenes)/[\w/]+(?:\.\w+)?)`", text):
        assert (ROOT / name).exists() or "NAME" in name, name


def test_the_readme_refers_to_pages_that_are_there() -> None:
    for name in re.findall(r"\]\((docs/[^)]+)\)", (ROOT / "README.md").read_text()):
        assert (ROOT / name).is_file(), name


@pytest.mark.parametrize("path", [path for path in PAGES if blocks(path.read_text(), "python")], ids=name_of)
def test_the_python_of_a_page_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "robots").symlink_to(ROOT / "robots")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in blocks(path.read_text(), "python"):
        exec(block.replace("beta=0.2)", "beta=0.2, nodes=60, effort=0)"), names)


@pytest.mark.parametrize("path", [path for path in PAGES if SHELL[path]], ids=name_of)
def test_the_commands_of_a_page_run(path: Path, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for words in SHELL[path]:
        assert_options_are_known(words, run)
    assert_they_run(SHELL[path], run, tmp_path, monkeypatch)


def test_the_scene_example_shows_every_kind_of_obstacle() -> None:
    texts = blocks((DOCS / "howto" / "own_scene.md").read_text(), "yaml")
    still, moving = (SceneFile.model_validate(yaml.safe_load(text)).obstacles for text in texts)
    assert all(obstacle.motion or obstacle.speed_limit for obstacle in moving)
    assert {obstacle.type for obstacle in still} == {"box", "cylinder", "sphere", "capsule", "mesh"}


def test_the_reference_has_every_command() -> None:
    from docs.site_parts import commands as documented

    listed = documented()
    assert {("plan",), ("schema",), ("roadmap", "check"), ("reproduce", "laws")} <= set(listed)
    assert {("plan",), ("first-path",)} <= set(documented("python -m benchmarks"))
    assert len(set(listed)) == len(listed)
    assert not any(word == "None" for words in listed for word in words)


def test_the_moving_picture_is_small_and_moves() -> None:
    from PIL import Image

    path = DOCS / "_static" / "plan.webp"
    assert path.stat().st_size < 1_000_000
    with Image.open(path) as picture:
        assert picture.n_frames > 10  # type: ignore[attr-defined]
