"""Where the robots and scenes that travel with the package are: inside the wheel, or beside it in a checkout."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def data_folder(kind: str) -> Path:
    """The folder of built-in files of one ``kind``: "robots" or "scenes"."""
    packaged = _PACKAGE / "_data" / kind
    return packaged if packaged.is_dir() else _PACKAGE.parent / kind


def robots_folder() -> Path:
    return data_folder("robots")


def scenes_folder() -> Path:
    return data_folder("scenes")


def robot_names() -> list[str]:
    """Names of the built-in robots, sorted."""
    return sorted(path.parent.name for path in robots_folder().glob("*/robot.yaml"))


def scene_names() -> list[str]:
    """Names of the built-in scenes that every built-in robot has states in, sorted."""
    return sorted(path.stem for path in scenes_folder().glob("*.yaml"))


def published_scene_names() -> list[str]:
    """Names of the built-in scenes of published problems, each for the robots that it names, sorted."""
    return sorted(path.stem for path in _published_folder().glob("*.yaml"))


def scene_file(name: str) -> Path | None:
    """The file of a built-in scene; None where there is none of that name."""
    if name in scene_names():
        return scenes_folder() / f"{name}.yaml"
    return _published_folder() / f"{name}.yaml" if name in published_scene_names() else None


def _published_folder() -> Path:
    return scenes_folder() / "published"
