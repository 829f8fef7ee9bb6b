"""The documentation: every page is reached, its code and its commands run, and it keeps up with the program."""

import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import resolve_name
from types import ModuleType

import numpy as np
import pytest
import yaml

from planner.robot.scene import Scene, SceneFile
from tests.command_line import Run
from tests.documents import ROOT, assert_options_are_known, assert_they_run, blocks, commands, exit_codes
from tests.test_imports import MODULES, imported, room

DOCS = ROOT / "docs"
PAGES = [path for path in sorted(DOCS.rglob("*.md")) if "_build" not in path.parts]
LINES = {path: [line for block in blocks(path.read_text(), "sh") for line in block.splitlines()] for path in PAGES}
SHELL = {path: commands(lines) for path, lines in LINES.items()}
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
        assert (
            not target
            or (path.parent / target).with_suffix(".md").exists()
            or target.removeprefix("../").startswith("notebooks")
        )
    for name in re.findall(r"!?\[[^\]]*\]\(([^)#:]+)\)", text) + re.findall(r"```\{include\} (\S+)", text):
        assert (path.parent / name).exists(), name
    for name in re.findall(r"`((?:planner|benchmarks|tests|robots|scenes)/[\w/]+(?:\.\w+)?)`", text):
        assert (ROOT / name).exists() or "NAME" in name, name


def test_names_that_pages_and_docstrings_refer_to_are_there() -> None:
    prose = r"`(planner(?:\.\w+)+)"
    roles = r":(?:mod|class|func|meth|attr|data):`[~.]?(planner(?:\.\w+)+)`"
    names = {name for path in (*PAGES, ROOT / "README.md") for name in re.findall(prose, path.read_text())}
    names |= {name for path in MODULES.values() for name in re.findall(roles, path.read_text())}
    assert {"planner.time_path", "planner.planning.plan"} <= names
    for name in sorted(names - {"planner.NAME"}):
        resolve_name(name)


@pytest.mark.parametrize("path", [path for path in PAGES if blocks(path.read_text(), "python")], ids=name_of)
def test_the_python_of_a_page_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "robots").symlink_to(ROOT / "robots")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    lacks = [f"import {name}\n" for name in ("networkx", "pandas") if find_spec(name) is None]  # of an extra
    left_out = [block for block in blocks(path.read_text(), "python") if any(each in block for each in lacks)]
    for block in blocks(path.read_text(), "python"):
        if block not in left_out:
            exec(block.replace("beta=0.2)", "beta=0.2, nodes=60, refinement_rounds=0)"), names)
    if name_of(path) == "reference/library":
        assert np.allclose(names["path"][[0, -1]], [[q, 0.5, 0, -1.2, 0, 0.8, 0] for q in (0, -2)])
        assert names["motion"].proven
    if left_out:
        pytest.skip(f"blocks that need an extra were left out: {left_out}")


@pytest.mark.parametrize("path", [path for path in PAGES if SHELL[path]], ids=name_of)
def test_the_commands_of_a_page_run(path: Path, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for words in SHELL[path]:
        assert_options_are_known(words, run)
    assert_they_run(SHELL[path], run, tmp_path, monkeypatch, exit_codes(LINES[path]))


def test_the_scene_example_shows_every_kind_of_obstacle() -> None:
    texts = blocks((DOCS / "howto" / "own_scene.md").read_text(), "yaml")
    still, moving = (SceneFile.model_validate(yaml.safe_load(text)).obstacles for text in texts)
    assert all(obstacle.motion or obstacle.speed_limit for obstacle in moving)
    assert {obstacle.type for obstacle in still} == {"box", "cylinder", "sphere", "capsule", "mesh"}


MODULES_OF_THE_REFERENCE = {"planner": "library", "planner.figures": "library", "planner.gabf": "gabf"}


@pytest.mark.parametrize(("module", "page"), MODULES_OF_THE_REFERENCE.items())
def test_the_reference_lists_every_public_name(module: str, page: str) -> None:
    text = (DOCS / "reference" / f"{page}.md").read_text()
    blocks = re.findall(rf"currentmodule:: {module}\n\n.. autosummary::\n(?:   :.*\n)+\n((?:   \w+\n)+)", text)
    listed = [name for block in blocks for name in block.split()]
    public = {name for name in import_module(module).__all__ if name != "__version__"}
    modules = {name for name in public if isinstance(getattr(import_module(module), name), ModuleType)}
    assert sorted(listed) == sorted(public - modules)


@pytest.mark.parametrize("module", ["planner", "planner.gabf"])
def test_every_public_class_has_an_example_that_runs(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (DOCS / "reference" / f"examples_{module.rpartition('.')[2]}.py").read_text()
    names = re.findall(r"^# --- (\w+) ---$", text, re.MULTILINE)
    public = {name: getattr(import_module(module), name) for name in import_module(module).__all__}
    assert names == sorted(name for name, thing in public.items() if isinstance(thing, type))
    exec(text, {})


def test_the_reference_has_every_command() -> None:
    from docs.site_parts import commands as documented

    listed = documented()
    assert {("plan",), ("schema",), ("roadmap", "info"), ("robots",)} <= set(listed)
    assert {("plan",), ("first-motion",)} <= set(documented("python -m benchmarks"))
    assert {("example",), ("laws",), ("manipulator",), ("learning",)} == set(documented("python -m reproduce"))
    assert len(set(listed)) == len(listed)
    assert not any(word == "None" for words in listed for word in words)


def test_every_command_is_shown_in_use(run: Run) -> None:
    _, out, _ = run("--help")
    shown = {words[1] for words in SHELL[DOCS / "reference" / "commands.md"] if words[0] == "planner"}
    assert shown == set(re.search(r"\{([a-z,-]+)\}", out).group(1).split(","))


def test_a_folder_of_the_map_imports_only_from_those_above_it() -> None:
    text = (DOCS / "contributing.md").read_text()
    order = re.findall(
        r"`planner/([\w/]+?)(?:/|\.py)`", text.partition("<!-- map -->")[2].partition("<!-- end of map -->")[0]
    )
    assert len(order) == len(set(order))
    order = [place.replace("/", ".") for place in order]
    seen: dict[str, set[str]] = {room(module): set() for module in MODULES}
    for module, path in MODULES.items():
        seen[room(module)] |= {room(other) for other in imported(path) if other in MODULES} - {room(module)}
    assert set(order) == set(seen) - {"", "__main__", "reproduce", "benchmarks"}
    for place in order:
        above = set(order[: order.index(place)])
        assert seen[place] <= above, f"{place} imports {seen[place] - above}, which the map has below it"
    assert seen["gabf"] <= {"base", "native"}


def test_the_changed_shelf_is_the_shelf_with_one_thing_more() -> None:
    today, then = Scene.load(str(ROOT / "scenes/examples/shelf-of-today.yaml")), Scene.load("shelf")
    same = [obstacle.name for obstacle in then.obstacles]
    assert [obstacle.name for obstacle in today.obstacles] == [*same, "pole"]
    for new, old in zip(today.obstacles, then.obstacles, strict=False):
        assert new.shape == old.shape
        np.testing.assert_array_equal(new.placement, old.placement)
    assert today.states == then.states


def test_the_moving_picture_is_small_and_moves() -> None:
    from PIL import Image

    path = DOCS / "_static" / "plan.webp"
    assert path.stat().st_size < 1_000_000
    with Image.open(path) as picture:
        assert picture.n_frames > 10


def test_the_build_shows_the_figures_that_a_page_saves(tmp_path: Path) -> None:
    from docs.site_parts import PICTURES, with_pictures

    assert PICTURES in (DOCS / "howto" / "plot_figures.md").read_text()
    code = "from matplotlib.figure import Figure\nfigure = Figure()\nfigure.savefig('one.pdf')\n"
    text = with_pictures(f"before\n\n```python\n{code}```\n\nafter\n", tmp_path, "../made")
    assert text == f"before\n\n```python\n{code}```\n\n![one](../made/one.png)\n\nafter\n"
    assert (tmp_path / "one.png").read_bytes()[:4] == b"\x89PNG"
