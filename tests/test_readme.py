"""What the README says runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from planner.models.scene import Scene
from tests.command_line import Run
from tests.documents import ROOT, assert_options_are_known, assert_they_run, blocks, commands
from tests.test_imports import MODULES, imported, room

README = (ROOT / "README.md").read_text()


def test_the_library_examples_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    short, steps = blocks(README, "python")
    exec(short.replace("beta=0.2)", "beta=0.2, nodes=60)"), names)
    assert len(names["found"].path) >= 2
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"plan.json", "plan.html", "roadmap.npz"}
    exec(steps, names)
    path = names["path"]
    assert np.allclose(path[0], [0, 0.5, 0, -1.2, 0, 0.8, 0])
    assert np.allclose(path[-1], [-2, 0.5, 0, -1.2, 0, 0.8, 0])


COMMANDS = commands([line for line in README.splitlines() if line.startswith("    ")])


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_command_and_option_of_the_readme_is_in_the_help(words: list[str], run: Run) -> None:
    assert_options_are_known(words, run)


def test_the_commands_run_as_they_stand(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert_they_run(COMMANDS, run, tmp_path, monkeypatch)


def test_the_changed_shelf_is_the_shelf_with_one_thing_more() -> None:
    today, then = Scene.load(str(ROOT / "scenes/examples/shelf-of-today.yaml")), Scene.load("shelf")
    same = [obstacle.name for obstacle in then.obstacles]
    assert [obstacle.name for obstacle in today.obstacles] == [*same, "pole"]
    for new, old in zip(today.obstacles, then.obstacles, strict=False):
        assert new.shape == old.shape
        np.testing.assert_array_equal(new.placement, old.placement)
    assert today.states == then.states


def test_the_readme_shows_every_command(run: Run) -> None:
    _, out, _ = run("--help")
    shown = {words[1] for words in COMMANDS if words[0] == "planner"}
    assert shown == set(re.search(r"\{([a-z,-]+)\}", out).group(1).split(","))  # type: ignore[union-attr]


def test_a_folder_of_the_map_imports_only_from_those_above_it() -> None:
    map_ = README.partition("<!-- map -->")[2].partition("<!-- end of map -->")[0]
    order = re.findall(r"planner/(\w+)(?:/|\.py)", map_)
    assert len(order) == len(set(order))
    seen: dict[str, set[str]] = {room(module): set() for module in MODULES}
    for module, path in MODULES.items():
        seen[room(module)] |= {room(other) for other in imported(path) if other in MODULES} - {room(module)}
    assert set(order) == set(seen) - {"", "__main__", "benchmarks"}
    for place in order:
        above = set(order[: order.index(place)])
        assert seen[place] <= above, f"{place} imports {seen[place] - above}, which the map has below it"
    assert seen["gabf"] <= {"base", "native"}


def test_pictures_are_there() -> None:
    for name in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (ROOT / name).is_file()
