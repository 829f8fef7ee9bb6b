"""ROS packages by the name in their package.xml: upwards from a file, then along the paths that ROS keeps."""

from __future__ import annotations

import importlib.metadata
import itertools
import os
import xml.etree.ElementTree as ET
from functools import cache
from glob import glob
from pathlib import Path

from planner.base.errors import RobotError
from planner.base.resources import robots_folder
from planner.base.yamlfile import shown

PATHS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")


def find_package(name: str, *files: Path) -> Path:
    """The folder of the package that ``files`` call ``name``, or else a near folder of that name; else LookupError."""
    above = [file.resolve().parents for file in files]
    said = (os.environ.get(path, "").split(os.pathsep) for path in PATHS)
    ros, prefixes = ([Path(part).absolute() for part in parts if part] for parts in said)
    around, near = itertools.chain(*above), [folder for folders in above for folder in folders[:4]]
    shared = [*(prefix / "share" for prefix in prefixes), robots_folder(), example_robot_data().parent]
    for folders, inside in ((around, ""), (near, "*/"), (ros, "*/"), (ros, "**/"), (shared, "*/")):
        for folder in folders:
            if inside and os.path.isdir(folder / name):
                return folder / name
            for file in sorted(glob(f"{inside}package.xml", root_dir=folder, recursive=True)):  # folders may vanish
                if _name_in(folder / file) == name:
                    return (folder / file).parent
    raise LookupError(f"package {shown(name)} not found: name its folder in ROS_PACKAGE_PATH")


def _name_in(file: Path) -> str:
    try:
        return (ET.parse(file).findtext("name") or "").strip()
    except (OSError, ET.ParseError, ValueError, LookupError):  # the latter two of encodings
        return ""


@cache
def example_robot_data() -> Path:
    """The folder of example-robot-data's files; its wheel holds no Python module to ask."""
    installed = importlib.metadata.distribution("example-robot-data")
    record = installed.read_text("RECORD") or ""  # a line for each of a thousand files: the path comes first
    for path in (line.partition(",")[0] for line in record.splitlines()):
        if path.endswith("/package.xml"):
            return Path(str(installed.locate_file(path))).resolve().parent
    raise RobotError("example-robot-data is installed without its data: reinstall it with pip.")
