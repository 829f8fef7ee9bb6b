"""What the README says runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
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
    from planner.scene import SceneFile

    scene = SceneFile.model_validate(yaml.safe_load(block("yaml")))
    assert {obstacle.type for obstacle in scene.obstacles} == {"box", "cylinder", "sphere", "capsule", "mesh"}


def test_every_option_in_the_examples_exists() -> None:
    from dataclasses import fields

    from planner.request import PlanRequest

    known = {field.name.replace("_", "-") for field in fields(PlanRequest)} | {"out", "debug", "help"}
    examples = [line for line in README.splitlines() if line.startswith("    planner plan")]
    assert examples
    for line in examples:
        assert set(re.findall(r"--([a-z-]+)", line)) <= known


def test_pictures_are_there() -> None:
    for name in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (Path(__file__).resolve().parents[1] / name).is_file()
