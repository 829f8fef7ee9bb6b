"""Faults of a URDF that urdfdom and Pinocchio do not report: they misread such a file, or crash."""

from __future__ import annotations

import itertools
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from pathlib import Path

from planner.base.errors import RobotError
from planner.base.yamlfile import FARTHEST, SMALLEST, nearest, number, shown

_SIZES = {"box": {"size": 3}, "sphere": {"radius": 1}, "cylinder": {"radius": 1, "length": 1}}
_SIZES["capsule"] = _SIZES["cylinder"]
_BOUNDLESS = {"limit": {"lower": 1, "upper": 1}, "safety_controller": {"soft_lower_limit": 1, "soft_upper_limit": 1}}
_NUMBERS = {
    **{"origin": {"xyz": 3, "rpy": 3, "quat_xyzw": 4}, "axis": {"xyz": 3}, **_SIZES, **_BOUNDLESS},
    **{"mesh": {"scale": 3}, "mimic": {"multiplier": 1, "offset": 1}},
}
_OTHER_KEYS = {
    "limit": ("effort", "velocity", "gear_velocity"),
    "safety_controller": ("k_position", "k_velocity"),
    "mesh": ("filename",),
    "mimic": ("joint",),
}
_CHILDREN = {
    "robot": ("link", "joint", "material", "gazebo", "transmission"),
    "link": ("inertial", "visual", "collision"),
    "joint": ("origin", "parent", "child", "axis", "limit", "mimic", "dynamics", "calibration", "safety_controller"),
    "collision": ("origin", "geometry"),
    "geometry": (*_SIZES, "mesh"),
}
_AT_FIXED_PLACES = ("link", "joint", "collision")
_ALIKE, _ALIKE_KEY = 0.7, 0.65  # of elements, and of attributes: "ryp" is so near to "rpy"


def require_sane_urdf(root: ET.Element, path: Path) -> None:
    """Raise :class:`RobotError` for the first part of the URDF at ``path`` that its readers would misread."""
    for fault in itertools.chain(_misspelt(root), *map(_faults, root), _faults_of_tree(root.findall("joint"))):
        raise RobotError(f"URDF {path}: {fault}; mend the file.")


def _faults(item: ET.Element) -> Iterator[str]:
    """Faults of a link or a joint."""
    if item.tag not in ("link", "joint"):
        return
    where = f"{item.tag} {shown(item.get('name'))}"
    if item.get("name") == "universe":
        yield f"{where} has the name of the world itself"
    for element in item.iter():
        yield from (f"{where}: {fault}" for part in (_misspelt, _repeated, _numbers) for fault in part(element))
    axis = item.find("axis[@xyz]")
    if axis is not None and item.get("type") not in ("fixed", "floating") and _length(axis.get("xyz", "")) < 1e-6:
        yield f"{where}: the axis has no direction"


def _misspelt(element: ET.Element) -> Iterator[str]:
    """Elements and attributes that nearly have a meaning, and elements that have one elsewhere: readers skip these."""
    children, keys = _CHILDREN.get(element.tag, ()), (*_NUMBERS.get(element.tag, ()), *_OTHER_KEYS.get(element.tag, ()))
    words = [(child.tag, children, _ALIKE) for child in element]
    for word, known, alike in (*words, *((key, keys, _ALIKE_KEY) for key in element.attrib)):
        meant = nearest(word, known, alike) if word not in known else ""
        strange = element.tag == "origin" or (children and word in _AT_FIXED_PLACES)
        if meant or (strange and word not in known):
            yield f"<{element.tag}> holds {shown(word)}{meant}, which has no meaning there"


def _repeated(element: ET.Element) -> Iterator[str]:
    """Elements of which readers take the first only: two axes of a joint, two shapes of a geometry."""
    tags = [child.tag for child in element if child.tag in _CHILDREN.get(element.tag, ())]
    if element.tag in ("joint", "collision", "geometry") and len(tags) > (
        1 if element.tag == "geometry" else len(set(tags))
    ):
        yield f"<{element.tag}> holds {', '.join(tags)}, and only the first one of a kind would count"


def _numbers(element: ET.Element) -> Iterator[str]:
    for key, count in _NUMBERS.get(element.tag, {}).items():
        if (text := element.get(key)) is None:
            continue
        quoted, values = f"{key}={shown(text)} of <{element.tag}>", floats(text)
        if len(values) != count or not all(map(math.isfinite, values)):
            yield f"{quoted} is not {'a finite number' if count == 1 else f'{count} finite numbers'}"
        elif max(map(abs, values)) > FARTHEST and element.tag not in _BOUNDLESS:  # a propeller turns to 1e16 rad
            yield f"{quoted} is beyond {FARTHEST:g}"
        elif element.tag in _SIZES and min(values) < SMALLEST:
            yield f"{quoted} must be a size above 0 m"
        elif (key == "quat_xyzw" and _length(text) < 1e-6) or (key == "scale" and min(map(abs, values)) < 1e-9):
            yield f"{quoted} must not be 0"


def _faults_of_tree(joints: Sequence[ET.Element]) -> Iterator[str]:
    parents: dict[str, str] = {}
    for joint in joints:
        parent, child = ends(joint)
        if child in parents:
            yield f"link {shown(child)} is the child of two joints"
        parents[child] = parent
    for link in parents:
        above = parents[link]
        for _ in range(len(parents)):
            above = parents.get(above, "")
        if above in parents:
            yield f"link {shown(link)} hangs in a loop of joints"


def ends(joint: ET.Element) -> tuple[str, str]:
    """The names of a joint's parent and child link, empty where it has none."""
    parent, child = joint.find("parent"), joint.find("child")
    return "" if parent is None else parent.get("link", ""), "" if child is None else child.get("link", "")


def floats(text: str) -> list[float]:
    """The numbers of a text, NaN for a word that is none."""
    return [_float(word) for word in text.split()]


def _float(word: str) -> float:
    try:
        return number(word)
    except ValueError:
        return math.nan


def _length(text: str) -> float:
    return math.hypot(*floats(text))
