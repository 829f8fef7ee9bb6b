"""The built wheel carries robots and scenes and plans outside the checkout."""

import json
import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml

from planner.base.resources import robot_names

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    code = f"from scikit_build_core.build import build_wheel; print(build_wheel({str(out)!r}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    name = done.stdout.split()[-1]
    return out / name


def test_the_wheel_holds_the_data(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    for name in (
        "planner/py.typed",
        "planner/_data/robots/iiwa14/iiwa14.urdf",
        "planner/_data/robots/iiwa14/visual/link_0.stl",
        "planner/_data/robots/panda/robot.yaml",
        "planner/_data/scenes/paper.yaml",
        "planner/_data/scenes/published/gcs.yaml",
        "planner/view/page.js",
        "planner/native/compiled.pyi",
    ):
        assert name in names
    assert [name.endswith(".so") for name in names].count(True) == 1
    assert not any(name.startswith(("reproduce/", "benchmarks/", "tests/", "planner/native/source/")) for name in names)


def test_the_source_distribution_can_be_built_from(tmp_path: Path) -> None:
    code = f"from scikit_build_core.build import build_sdist; print(build_sdist({str(tmp_path)!r}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    with tarfile.open(tmp_path / done.stdout.split()[-1]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    inside = (ROOT / "planner" / "native" / "source").rglob("*.?pp")
    sources = {str(path.relative_to(ROOT)) for path in inside}
    assert (
        sources
        | {
            "CMakeLists.txt",
            "tools/build_backend.py",
            "LICENSE",
            "LICENSES.md",
            "CITATION.cff",
            "robots/iiwa14/iiwa14.urdf",
            "reproduce/commands.py",
        }
        <= names
    )
    assert not any(name.endswith((".so", ".pyc")) for name in names), "compiled where it is installed"


def test_the_citation_names_the_version() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert (cited["version"], cited["license"]) == (project["version"], project["license"])


def test_every_robot_has_its_licence_listed() -> None:
    listed = (ROOT / "LICENSES.md").read_text()
    for name in robot_names():
        assert f"`{name}`" in listed, name


def test_the_installed_wheel_plans_outside_the_checkout(wheel: Path, tmp_path: Path) -> None:
    """Installed without its dependencies into a folder of its own; those come from this environment."""
    target = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(target)
    environment = {**os.environ, "PYTHONPATH": str(target)}
    code = "import planner.cli, sys; assert planner.__file__.startswith(sys.argv.pop(1)); planner.cli.main()"
    done = subprocess.run(
        [sys.executable, "-c", code, str(target), "plan", "--nodes", "60"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "out" / "plan.json").read_text())["outcome"] == "solved"
