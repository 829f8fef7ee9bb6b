"""ROS packages by name, and xacro, an optional extra.

A xacro file evaluates expressions and reads other files, as in ROS: expand only files that you trust.
"""

import contextlib
import importlib.metadata
import itertools
import os
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from functools import cache
from glob import glob
from pathlib import Path
from typing import Any

from planner.base.captured_output import PROCESS
from planner.base.errors import RobotError, require_extra
from planner.base.resources import robots_folder
from planner.base.yamlfile import quote, read_bytes

PATHS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
_XACRO = "/xacro}"  # ends the names of its namespace, http://www.ros.org/wiki/xacro and others


def find_package(name: str, *files: Path) -> Path:
    """Return the folder of the package ``name`` that ``files`` refer to; LookupError otherwise.

    Searched upwards from the files, including folders of that name, then along the ROS paths.
    """
    above = [file.resolve().parents for file in files]
    paths = (os.environ.get(path, "").split(os.pathsep) for path in PATHS)
    ros, prefixes = ([Path(part).absolute() for part in parts if part] for parts in paths)
    around, near = itertools.chain(*above), [folder for folders in above for folder in folders[:4]]
    shared = [*(prefix / "share" for prefix in prefixes), robots_folder(), example_robot_data().parent]
    for folders, inside in ((around, ""), (near, "*/"), (ros, "*/"), (ros, "**/"), (shared, "*/")):
        for folder in folders:
            if inside and os.path.isdir(folder / name):
                return folder / name
            for file in sorted(glob(f"{inside}package.xml", root_dir=folder, recursive=True)):  # folders may vanish
                if _package_name(folder / file) == name:
                    return (folder / file).parent
    raise LookupError(f"package {quote(name)} not found: name its folder in ROS_PACKAGE_PATH")


def find_meshes(root: ET.Element, path: Path) -> None:
    """Replace package URLs of meshes by paths; names of unknown packages stay."""
    find = cache(find_package)
    for mesh in root.iter("mesh"):
        kind, _, place = mesh.get("filename", "").partition("://")
        name, _, inside = place.lstrip("/").partition("/")  # talos writes package:///
        if kind in ("package", "model"):
            with contextlib.suppress(LookupError):
                mesh.set("filename", f"file://{find(name, path) / inside}")


def _package_name(file: Path) -> str:
    try:
        return (ET.parse(file).findtext("name") or "").strip()
    except (OSError, ET.ParseError, ValueError, LookupError):  # the latter two of encodings
        return ""


@cache
def example_robot_data() -> Path:
    """Return the folder of example-robot-data, whose wheel has no Python module."""
    files = importlib.metadata.files("example-robot-data") or []
    return next(Path(str(file.locate())).resolve().parent for file in files if file.name == "package.xml")


def read_root(path: Path, what: str, arguments: Mapping[str, str] | None = None, text: str | None = None) -> ET.Element:
    """Return the root element of an XML file or ``text``; .xacro files are expanded with ``arguments``.

    Raises :class:`RobotError` for a file that cannot be read, :class:`InstallationError` without xacro.
    """
    content = read_bytes(path, what) if text is None else text.strip()
    try:
        root = ET.fromstring(_expand(path, arguments or {}) if path.suffix.lower() == ".xacro" else content)
    except (ET.ParseError, ValueError, LookupError) as error:  # the latter two of encodings
        raise RobotError(f"{what} {path} is not well-formed XML ({error}): mend the file.") from None
    if any(_XACRO in str(element.tag) for element in root.iter()):
        remedy = "expand them first" if text is not None else f"call it {path.name}.xacro"
        raise RobotError(f"{what} {path} holds elements of xacro that are not expanded: {remedy}.")
    return root


def _expand(path: Path, arguments: Mapping[str, str]) -> bytes:
    xacro, substitution_args = (require_extra(name, "xacro") for name in ("xacro", "xacro.substitution_args"))
    try:
        with PROCESS:  # xacro keeps the files that it is in as a global list; by itself it finds packages of ROS 2 only
            substitution_args._eval_find = lambda name: str(find_package(name, *map(Path, reversed(xacro.filestack))))
            document: Any = xacro.process_file(str(path.absolute()), mappings=dict(arguments))
    except Exception as error:  # whatever an expression in the file raises
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise RobotError(
            f"xacro file {path} cannot be expanded ({reason}): mend it, or give its arguments in a robot.yaml, as "
            "urdf: {file: ..., args: {...}}."
        ) from None
    return document.toxml("utf-8")
