"""A base that moves in a plane, as two slides and a turn.

A planar joint has three values, and proofs need joints of one. It becomes three, with the names that MoveIt has for its
values: ``base/x`` and ``base/y`` (m), and ``base/theta`` (rad), which turns without end. Files give no limits to such
slides, so the user gives the area in which the base may move.
"""

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from planner.base.errors import RobotError
from planner.base.yamlfile import quote

Area: TypeAlias = tuple[float, ...]
"""x0, y0, x1, y1 (m): the least and the largest coordinates of a base, in the frame in which it moves."""

PARTS = ("x", "y", "theta")
_AXES = {"x": "1 0 0", "y": "0 1 0", "theta": "0 0 1"}
REMEDY = "--base-limits x0,y0,x1,y1 (m) or base_limits in a robot.yaml"


@dataclass(frozen=True)
class VirtualJoint:
    """The joint of an SRDF by which the robot's root moves in a plane of the world."""

    name: str
    parent: str
    child: str


def part_names(joint: str) -> list[str]:
    """Return the names of the three joints that take the place of a planar one."""
    return [f"{joint}/{part}" for part in PARTS]


def split_planar_joints(root: ET.Element, path: Path, virtual: VirtualJoint | None = None) -> frozenset[str]:
    """Replace the planar joints of a URDF by slides and turns, and return the names of these.

    A ``virtual`` one is added above its root.
    Raises :class:`RobotError` for an axis other than z, and for a virtual joint on another link than the root.
    """
    made = list[str]()
    for joint in root.findall("joint[@type='planar']"):
        name, axis = joint.get("name", ""), joint.find("axis")
        numbers = [] if axis is None else axis.get("xyz", "").split()
        if numbers and not (len(numbers) == 3 and float(numbers[0]) == float(numbers[1]) == 0.0):
            raise RobotError(
                f"planar joint {quote(name)} of {path} must have the axis 0 0 1, got {quote(' '.join(numbers))}: turn "
                "its origin."
            )
        parent, child, limit = (joint.find(tag) for tag in ("parent", "child", "limit"))
        if parent is None or child is None:
            raise RobotError(f"joint {quote(name)} of {path} must have a parent and a child: mend the file.")
        root.remove(joint)
        velocity = "0" if limit is None else limit.get("velocity", "0")
        _add_joints(root, name, parent.get("link", ""), child.get("link", ""), joint.find("origin"), velocity)
        made += part_names(name)
    if virtual is not None:
        links = {link.get("name", "") for link in root.iterfind("link")}
        below = {child.get("link", "") for child in root.iterfind("joint/child")}
        if virtual.child not in links - below:
            raise RobotError(
                f"virtual joint {quote(virtual.name)} must carry the root of {path}, got {quote(virtual.child)}: mend "
                "the SRDF."
            )
        parent_link = virtual.parent if virtual.parent not in links | {"universe", ""} else f"{virtual.name}/world"
        ET.SubElement(root, "link", name=parent_link)
        _add_joints(root, virtual.name, parent_link, virtual.child, None, "0")
        made += part_names(virtual.name)
    return frozenset(made)


def _add_joints(root: ET.Element, name: str, parent: str, child: str, origin: ET.Element | None, velocity: str) -> None:
    for part, joint in zip(PARTS, part_names(name), strict=True):
        below = child if part == PARTS[-1] else f"{joint}_link"
        if below != child:
            ET.SubElement(root, "link", name=below)
        kind = "continuous" if part == PARTS[-1] else "prismatic"
        element = ET.SubElement(root, "joint", name=joint, type=kind)
        ET.SubElement(element, "parent", link=parent)
        ET.SubElement(element, "child", link=below)
        if origin is not None and part == PARTS[0]:
            element.append(origin)
        ET.SubElement(element, "axis", xyz=_AXES[part])
        ET.SubElement(element, "limit", effort="0", velocity=velocity)
        parent = below


def limit_slides(root: ET.Element, path: Path, area: Area | None) -> frozenset[str]:
    """Give ``area`` to the slides along x and y that have no limits; return those that still have none.

    Raises :class:`RobotError` for an area without such slides.
    """
    without, given = set[str](), False
    for joint in root.findall("joint[@type='prismatic']"):
        limit, name = joint.find("limit"), joint.get("name", "")
        if limit is not None and (limit.get("lower") is not None or limit.get("upper") is not None):
            continue
        without.add(name)
        axis = joint.find("axis")
        along = [float(word) for word in ("1 0 0" if axis is None else axis.get("xyz", "1 0 0")).split()]
        k = max(range(len(along)), key=lambda each: abs(along[each]))
        if area is None or k > 1:
            continue
        limit = ET.SubElement(joint, "limit", effort="0", velocity="0") if limit is None else limit
        sign = -1.0 if along[k] < 0 else 1.0
        low, high = sorted((sign * area[k], sign * area[k + 2]))
        limit.attrib |= {"lower": repr(low), "upper": repr(high)}
        without.remove(name)
        given = True
    if area is not None and not given:
        raise RobotError(
            f"base limits need a base that moves, got {path} without a planar joint or slides without limits: leave "
            "them out."
        )
    return frozenset(without)


def require_area(area: Area) -> Area:
    """Return the area; :class:`ValueError` unless it holds four finite numbers, the lesser ones first."""
    if len(area) != 4 or not all(map(math.isfinite, area)) or not (area[0] < area[2] and area[1] < area[3]):
        raise ValueError("must be x0,y0,x1,y1 (m), the lesser corner first")
    return area
