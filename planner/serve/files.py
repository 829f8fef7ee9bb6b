"""The files of a server that a client may name: robots, scenes, joint limits and meshes."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

from planner.base.errors import OptionError

_KEYS = b"urdf|obstacles|carried|states|robots|keep|world|robot_model_name|allowed_collision_matrix|joint_limits"
_MODEL = re.compile(rb"<(robot|mujoco)[\s>]|^[\"']?(" + _KEYS + rb")[\"']?:(\s|$)|\A[^\n]*\n(\* \w|\.\s)", re.MULTILINE)
_MESHES = (".stl", ".obj", ".ply", ".dae", ".glb")


def require_models(paths: Iterable[Path], allow_xacro: bool = False) -> None:
    """Raise :class:`OptionError` for what is no regular file, for xacro, and where the first file holds no model.

    Errors about a model quote it, and nothing of other files may reach a client. Missing files are left to the reader.
    """
    for k, path in enumerate(paths):
        if os.path.exists(path) and not os.path.isfile(path):
            raise OptionError(f"{path} is a folder, a pipe or a device: give the path of a file.")
        is_xacro = path.suffix.lower() == ".xacro"
        if is_xacro and not allow_xacro:
            raise OptionError(f"{path} is xacro, whose expressions are run: start the server with --allow-xacro.")
        if k == 0 and path.suffix.lower() not in _MESHES and os.access(path, os.R_OK):
            with path.open("rb") as file:
                if not _MODEL.search(file.read(1 << 20)):
                    raise OptionError(f"{path} holds no robot, scene or joint limits: give the path of one.")
        if is_xacro:  # which may name any file
            return
