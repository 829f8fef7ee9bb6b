"""What the README says runs as it stands."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import yaml

from planner.world.scene import Scene
from tests.command_line import Run

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_the_library_examples_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    short, steps = blocks("python")
    exec(short.replace("beta=0.2)", "beta=0.2, nodes=60)"), names)
    assert len(names["found"].path) >= 2
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"plan.json", "plan.html", "roadmap.npz"}
    exec(steps, names)
    path = names["path"]
    assert np.allclose(path[0], [0, 0.5, 0, -1.2, 0, 0.8, 0])
    assert np.allclose(path[-1], [-2, 0.5, 0, -1.2, 0, 0.8, 0])


def test_the_scene_example_is_a_scene(tmp_path: Path) -> None:
    from planner.world.scene import SceneFile

    scene = SceneFile.model_validate(yaml.safe_load(blocks("yaml")[0]))
    assert {obstacle.type for obstacle in scene.obstacles} == {"box", "cylinder", "sphere", "capsule", "mesh"}


LINES = [line.split("#")[0].strip() for line in README.splitlines() if line.startswith("    planner ")]
COMMANDS = [shlex.split(line) for line in LINES]
SLOW = ("reproduce", "bench")  # minutes each, and they have their own tests
GROUPS = ("roadmap", "reproduce", "bench")


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_command_and_option_of_the_readme_is_in_the_help(words: list[str], run: Run) -> None:
    names = words[1 : 3 if words[1] in GROUPS else 2]
    code, out, _ = run(*names, "--help")
    assert code == 0
    for option in (word for word in words if word.startswith("--")):
        assert re.search(rf"{option}\b", out), option


def quicker(words: list[str]) -> list[str]:
    """The command with fewer nodes, where it has any."""
    if words[1] in ("plan", "sweep") or words[1:3] == ["roadmap", "build"]:
        return [*words, "--nodes", "80"] if "--roadmap" not in words else words
    return ["20" if before == "--nodes" else word for before, word in zip(["", *words], words, strict=False)]


def test_the_commands_run_as_they_stand(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One after the other, as they use each other's files; with fewer nodes, and pages are not served."""
    for name in ("robots", "scenes"):
        (tmp_path / name).symlink_to(ROOT / name)
    served: list[str] = []
    monkeypatch.setattr("planner.view.serve.serve", lambda page, *_, **__: served.append(str(page)[:80]))
    monkeypatch.chdir(tmp_path)
    for words in COMMANDS:
        if words[1] not in SLOW:
            served.clear()
            code, out, err = run(*quicker(words)[1:])
            assert code == 0, (words, err)
            assert out or served, words
            assert len(served) == (words[1] == "view" or "--view" in words), words


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
    shown = {words[1] for words in COMMANDS}
    assert shown == set(re.search(r"\{([a-z,-]+)\}", out).group(1).split(","))  # type: ignore[union-attr]


def test_pictures_are_there() -> None:
    for name in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (ROOT / name).is_file()
