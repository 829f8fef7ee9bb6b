"""COLLADA files: elements that trimesh would pass over in silence, and notes on their unit and up axis."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from pathlib import Path

from planner.base.errors import choices
from planner.base.notes import Note
from planner.base.yamlfile import shown
from planner.robot.files.urdf_rules import floats

_UNNEEDED = {f"library_{name}" for name in ("effects", "materials", "images", "cameras", "lights", "animations")} | {
    *("library_controllers", "bind_material", "instance_camera", "instance_light")
}
_PASSED_OVER = ("instance_controller", "skew", "ph", "convex_mesh", "spline", "brep")  # by pycollada
_NOT_NUMBERS = {"float_array": re.compile(r"[^\s\d.eE+-]"), **dict.fromkeys(("p", "vcount"), re.compile(r"[^\s\d]"))}
_UNIT_LENGTH = 1e-3  # by how much the axis of a rotation may miss it: pycollada would shear
_HEAD = 1 << 16  # bytes in which a file says its unit and axis
_ASSET_ENDS = b"</asset>"
_UNIT = re.compile(rb"<unit\b[^>]*?\bmeter\s*=\s*[\"']([^\"'<>]{1,40})")
_AXIS = re.compile(rb"<up_axis>\s*([XY]_UP)\b")


def bare_collada(content: bytes) -> bytes:
    """The file without materials, cameras, lights and motions; ValueError names an element that would be misread."""
    root = ET.fromstring(content)
    for element in root.iter():
        for child in [child for child in element if _name(child) in _UNNEEDED]:
            element.remove(child)
        _check(element)
    return ET.tostring(root)


def _check(element: ET.Element) -> None:
    name, text = _name(element), element.text or ""
    if name in _PASSED_OVER:
        raise ValueError(f"<{name}> is not supported")
    if name in _NOT_NUMBERS and (wrong := _NOT_NUMBERS[name].search(text)):  # pycollada makes 0 of NaN
        raise ValueError(f"<{name}> holds {shown(wrong[0])}, not only numbers")
    if name == "rotate" and abs(math.hypot(*list(floats(text))[:3]) - 1.0) > _UNIT_LENGTH:
        raise ValueError(f"the axis of <rotate> {shown(text.strip())} does not have length 1")
    params = [child.get("name") for child in element] if name == "accessor" else []
    if params[:1] == ["X"] and (element.get("offset", "0"), element.get("stride")) != ("0", str(len(params))):
        raise ValueError("an <accessor> of positions skips numbers")


def _name(element: ET.Element) -> str:
    return element.tag.rpartition("}")[2]


def collada_notes(files: Iterable[Path]) -> Iterator[Note]:
    """Notes on COLLADA files among ``files`` whose unit or axis is not followed.

    Nor do MoveIt and most readers of URDF: numbers count as they stand, times what scale the URDF or the scene gives.
    """
    turned: list[str] = []
    for path in dict.fromkeys(files):
        if path.suffix.lower() != ".dae":
            continue
        try:
            with path.open("rb") as file:
                head = file.read(_HEAD)
                if _ASSET_ENDS not in head:  # its comments are long
                    head += file.read()
        except OSError:  # who reads its triangles says so
            continue
        unit, axis = _UNIT.search(head), _AXIS.search(head)
        metres = unit[1].decode(errors="replace") if unit else "1"
        if [abs(value - 1.0) <= 1e-9 for value in floats(metres)] != [True]:
            text = f"mesh file {path} says that its unit is {shown(metres)} m, which is not followed: its numbers are "
            yield Note(f"{text}metres, unless its 'scale' makes them so; give it that, or export the file in metres.")
        turned += [path.name] if axis else []
    if turned:
        text = f"an up_axis other than Z_UP is not followed, as in MoveIt: of {choices(turned)} z stays z."
        yield Note(text, grave=False)
