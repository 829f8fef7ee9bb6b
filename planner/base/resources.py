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
    """Names of the built-in scenes, sorted."""
    return sorted(path.stem for path in scenes_folder().glob("*.yaml"))
