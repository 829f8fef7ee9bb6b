"""The published files: source distribution, citation and licences. ``make pythons`` installs the wheel and plans."""

import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import yaml

from planner.base.resources import robot_names

ROOT = Path(__file__).resolve().parents[1]


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
