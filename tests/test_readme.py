"""What the README says runs as it stands."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

README = (Path(__file__).resolve().parents[1] / "README.md").read_text()


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", README, re.DOTALL)
    assert found
    return found.group(1)


def test_the_library_example_runs_and_is_short() -> None:
    code = block("python")
    names: dict = {}
    exec(code, names)
    path = names["path"]
    assert np.allclose(path[0], [0, 0.5, 0, -1.2, 0, 0.8, 0])
    assert np.allclose(path[-1], [-2, 0.5, 0, -1.2, 0, 0.8, 0])


def test_the_scene_example_is_a_scene(tmp_path: Path) -> None:
    from planner.world.scene import SceneFile

    scene = SceneFile.model_validate(yaml.safe_load(block("yaml")))
    assert {obstacle.type for obstacle in scene.obstacles} == {"box", "cylinder", "sphere", "capsule", "mesh"}


COMMANDS = [line.split("#")[0].split() for line in README.splitlines() if line.startswith("    planner ")]
GROUPS = ("roadmap", "reproduce", "bench")


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_command_and_option_of_the_readme_is_in_the_help(
    words: list[str], run: Callable[..., tuple[int, str, str]]
) -> None:
    names = words[1 : 3 if words[1] in GROUPS else 2]
    code, out, _ = run(*names, "--help")
    assert code == 0
    for option in (word for word in words if word.startswith("--")):
        assert re.search(rf"{option}\b", out), option


def test_the_readme_shows_every_command(run: Callable[..., tuple[int, str, str]]) -> None:
    _, out, _ = run("--help")
    shown = {words[1] for words in COMMANDS}
    assert shown == set(re.search(r"\{([a-z,]+)\}", out).group(1).split(","))  # type: ignore[union-attr]


def test_pictures_are_there() -> None:
    for name in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (Path(__file__).resolve().parents[1] / name).is_file()
