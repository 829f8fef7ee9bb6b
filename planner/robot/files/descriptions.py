"""Robots by the names of the package robot_descriptions, where it is installed and holds them already.

Its modules download what is not there as soon as they are imported. That is for the user to do: here they find what
is in their cache, or nothing.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from planner.base.errors import InstallationError, RobotError
from planner.base.process_lock import PROCESS

_PACKAGE = "robot_descriptions"
_ENDING = "_description"  # of every name there


@dataclass(frozen=True)
class Described:
    """The files of a robot: URDF, xacro or MJCF with its arguments, and SRDF where there is one."""

    file: Path
    arguments: dict[str, str] = field(default_factory=dict)
    srdf: Path | None = None
    srdf_arguments: dict[str, str] = field(default_factory=dict)


class _NotHere(Exception):
    """The files are not in the cache of the package."""


def is_description(name: str) -> bool:
    """Whether a robot's name has the form of those in robot_descriptions."""
    return name.endswith(_ENDING) and name.isidentifier()


def described(name: str) -> Described:
    """The files of the description ``name``. Nothing is downloaded.

    Raises :class:`InstallationError` without the package, :class:`RobotError` for what it does not know or have.
    """
    if importlib.util.find_spec(_PACKAGE) is None:
        raise InstallationError(
            f"robot '{name}' would come from the Python package robot_descriptions: run pip install "
            "'gabf-planner[descriptions]'."
        )
    if importlib.util.find_spec(f"{_PACKAGE}.{name}") is None:
        raise RobotError(
            f"robot '{name}' is not in robot_descriptions: see 'python -m robot_descriptions list' for what is."
        )
    try:
        module = _imported(name)
    except _NotHere:
        raise RobotError(
            f"robot '{name}' has not been downloaded: run 'python -m robot_descriptions pull {name}' once."
        ) from None
    said = {key: getattr(module, key, None) for key in ("URDF_PATH", "XACRO_PATH", "MJCF_PATH")}
    path = next((value for value in said.values() if value), None)
    if path is None:
        raise RobotError(f"robot '{name}' of robot_descriptions has neither URDF, xacro nor MJCF: choose another.")
    arguments = getattr(module, "XACRO_ARGS", None) if said["URDF_PATH"] is None else None
    srdf = getattr(module, "SRDF_PATH", None) or getattr(module, "SRDF_XACRO_PATH", None)
    srdf_arguments = getattr(module, "SRDF_XACRO_ARGS", None)
    return Described(Path(path), dict(arguments or {}), Path(srdf) if srdf else None, dict(srdf_arguments or {}))


def _imported(name: str) -> Any:
    """The module of a description, with a stand-in for the function that it calls to download its files."""
    with PROCESS:
        try:
            cache: Any = importlib.import_module(f"{_PACKAGE}._cache")
            repositories = importlib.import_module(f"{_PACKAGE}._repositories").REPOSITORIES
        except ImportError as error:  # it imports Git's program too
            raise InstallationError(
                f"robot_descriptions cannot be imported ({' '.join(str(error).split())[:200]}): run pip install "
                "'gabf-planner[descriptions]', and install git."
            ) from None
        downloads = cache.clone_to_cache

        def only_what_is_there(repository: str, commit: str | None = None) -> str:
            return _folder(repositories[repository].cache_path, commit)

        cache.clone_to_cache = only_what_is_there
        try:
            return importlib.import_module(f"{_PACKAGE}.{name}")
        finally:
            cache.clone_to_cache = downloads


def _folder(place: str, commit: str | None) -> str:
    """Where a repository has been downloaded to."""
    cache = Path(os.path.expanduser(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", "~/.cache/robot_descriptions")))
    folder = cache / (place if commit is None else f"{place}-{commit}/{place}")
    if not folder.is_dir():
        raise _NotHere
    return str(folder)
