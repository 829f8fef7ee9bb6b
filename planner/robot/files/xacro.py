"""The door to xacro: URDF and SRDF that are written as xacro, expanded. An extra: other files need none of it.

As in ROS, a xacro file holds expressions that are evaluated, and names other files: expand those that you trust.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from planner.base.errors import InstallationError, RobotError, choices
from planner.base.process_lock import PROCESS
from planner.base.yamlfile import nearest, read_bytes, shown
from planner.robot.files.packages import find_package

_XACRO = "/xacro}"  # ends the names of its namespace, http://www.ros.org/wiki/xacro and others


def read_xml(path: Path, what: str, arguments: Mapping[str, str] | None = None) -> bytes:
    """The content of an XML file, expanded with ``arguments`` where it ends in .xacro.

    Raises :class:`RobotError` where it cannot be expanded, :class:`InstallationError` without xacro.
    """
    content = read_bytes(path, what)
    if path.suffix.lower() != ".xacro":
        if arguments:
            raise RobotError(f"{what} {path} is no xacro, and would not look at args: call it {path.name}.xacro.")
        return content
    try:
        import xacro  # pyright: ignore[reportMissingImports]  # an extra
        from xacro import substitution_args  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InstallationError(
            f"{path} needs the Python package xacro: pip install 'gabf-planner[xacro]', or expand it to a URDF first."
        ) from None
    given = _Arguments(arguments or {})
    try:
        with PROCESS:  # xacro keeps the files that it is in as a global list
            # itself it asks an installed ROS 2 for packages, knows no folder, and reads in the encoding of the locale
            substitution_args._eval_find = lambda name: str(find_package(name, *map(Path, reversed(xacro.filestack))))
            substitution_args._eval_dirname = lambda _: str(Path(xacro.filestack[-1]).parent)
            xacro.__dict__["open"] = partial(open, mode="rb")
            document: Any = xacro.process_file(str(path.absolute()), mappings=given)
    except Exception as error:  # whatever an expression in the file raises
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise RobotError(
            f"xacro file {path} cannot be expanded ({reason}): mend it, or give its arguments in a robot.yaml, as "
            "urdf: {file: ..., args: {...}}."
        ) from None
    if unknown := sorted({*(arguments or {})} - given.asked):
        raise RobotError(
            f"xacro file {path} has no argument {shown(unknown[0])}{nearest(unknown[0], given.asked)}; it has "
            f"{choices(sorted(given.asked))}: mend the args."
        )
    return document.toxml("utf-8")


class _Arguments(dict[str, str]):
    """Values of arguments, and the names that the file has ``asked`` for: xacro passes over the others."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def read_root(path: Path, what: str, arguments: Mapping[str, str] | None = None) -> ET.Element:
    """The root element of an XML file, read by :func:`read_xml`.

    :class:`RobotError` where it is not well-formed, or holds xacro that is not expanded.
    """
    content = read_xml(path, what, arguments)
    try:
        root = ET.fromstring(content)
    except (ET.ParseError, ValueError, LookupError) as error:  # the latter two of encodings
        raise RobotError(f"{what} {path} is not well-formed XML ({error}): mend the file.") from None
    if any(_XACRO in str(element.tag) for element in root.iter()):
        raise RobotError(f"{what} {path} holds elements of xacro, which nobody would read: call it {path.name}.xacro.")
    return root
