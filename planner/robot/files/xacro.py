"""The door to xacro: URDF and SRDF that are written as xacro, expanded. An extra: other files need none of it.

As in ROS, a xacro file holds expressions that are evaluated, and names other files: expand those that you trust.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from planner.base.errors import InstallationError, RobotError, choices
from planner.base.silenced import PROCESS
from planner.base.yamlfile import read_bytes, shown
from planner.robot.files.packages import find_package

_XACRO = "/xacro}"  # ends the names of its namespace, http://www.ros.org/wiki/xacro and others


class _Arguments(dict[str, str]):
    """Values of arguments, and the names that the file has ``asked`` for: xacro passes over the others."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)


def read_root(path: Path, what: str, arguments: Mapping[str, str] | None = None) -> ET.Element:
    """The root element of an XML file, expanded with ``arguments`` where its name ends in .xacro.

    Raises :class:`RobotError` for a file that cannot be read, :class:`InstallationError` without xacro.
    """
    content, is_xacro = read_bytes(path, what), path.suffix.lower() == ".xacro"
    if arguments and not is_xacro:
        raise RobotError(f"{what} {path} must be xacro, as it has args: call it {path.name}.xacro.")
    try:
        root = ET.fromstring(_expanded(path, arguments or {}) if is_xacro else content)
    except (ET.ParseError, ValueError, LookupError) as error:  # the latter two of encodings
        raise RobotError(f"{what} {path} is not well-formed XML ({error}): mend the file.") from None
    if any(_XACRO in str(element.tag) for element in root.iter()):
        raise RobotError(f"{what} {path} holds elements of xacro that are not expanded: call it {path.name}.xacro.")
    return root


def _expanded(path: Path, arguments: Mapping[str, str]) -> bytes:
    try:
        import xacro  # pyright: ignore[reportMissingImports]  # an extra
        from xacro import substitution_args  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InstallationError(
            f"{path} needs the Python package xacro: pip install 'gabf-planner[xacro]', or expand it to a URDF first."
        ) from None
    given = _Arguments(arguments)
    try:
        with PROCESS:  # xacro keeps the files that it is in as a global list; by itself it finds packages of ROS 2 only
            substitution_args._eval_find = lambda name: str(find_package(name, *map(Path, reversed(xacro.filestack))))
            document: Any = xacro.process_file(str(path.absolute()), mappings=given)
    except Exception as error:  # whatever an expression in the file raises
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise RobotError(
            f"xacro file {path} cannot be expanded ({reason}): mend it, or give its arguments in a robot.yaml, as "
            "urdf: {file: ..., args: {...}}."
        ) from None
    if unknown := sorted({*arguments} - given.asked):
        raise RobotError(
            f"xacro file {path} has no argument {shown(unknown[0])}; it has {choices(sorted(given.asked))}: mend args."
        )
    return document.toxml("utf-8")
