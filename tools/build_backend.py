"""scikit-build-core, but for two things.

Where the machine has no C++ compiler, the Python package ziglang is asked for. An editable install compiles into the
source tree and names that in a .pth file: no hook of the import system makes every start of Python slower, and a copy
of the tree on PYTHONPATH has its own compiled code.
"""

from __future__ import annotations

import os
import shutil
from typing import Any

from scikit_build_core import build
from scikit_build_core.build import (
    build_sdist,
    build_wheel,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]


def get_requires_for_build_wheel(config_settings: Any = None) -> list[str]:
    has_compiler = "CXX" in os.environ or any(map(shutil.which, ("c++", "g++", "clang++")))
    return build.get_requires_for_build_wheel(config_settings) + ([] if has_compiler else ["ziglang>=0.13"])


get_requires_for_build_editable = get_requires_for_build_wheel


def build_editable(wheel_directory: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    os.environ["PLANNER_IN_TREE"] = "yes"  # what pyproject.toml asks
    return build.build_wheel(wheel_directory, config_settings, metadata_directory)
