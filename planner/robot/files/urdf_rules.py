"""What a URDF must be before a native parser sees it: a tree of named links, with finite numbers of a sane size.

urdfdom and Pinocchio stop at most of what is refused here too, in words of their own on standard error; the rest
they let pass (an axis without direction, a box of 1e300 m) or do not survive (a joint called universe).
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from pathlib import Path

from planner.base.errors import RobotError, choices
from planner.base.words import number
from planner.base.yamlfile import FARTHEST, SMALLEST, nearest, shown

_SOFT = {"safety_controller": {"soft_lower_limit": 1, "soft_upper_limit": 1}}
_BOUNDLESS = ("limit", "safety_controller")  # nobody plans a propeller's 1e16 rad
_PLACES = {"origin": {"xyz": 3, "rpy": 3, "quat_xyzw": 4}, "axis": {"xyz": 3}, "limit": {"lower": 1, "upper": 1}}
_SIZES = {
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
}
_OTHERS = {"mesh": {"scale": 3}, "mimic": {"multiplier": 1, "offset": 1}}
_NUMBERS = _PLACES | _SIZES | _OTHERS | _SOFT
_INNER = {  # elements, and attributes, that have a meaning; others that are nothing like them are other programs' own
    "robot": ("link", "joint", "material", "gazebo", "transmission"),
    "link": ("inertial", "visual", "collision"),
    "joint": (*("origin", "parent", "child", "axis", "limit", "mimic"), *("dynamics", "calibration", *_SOFT)),
    "collision": ("origin", "geometry"),
    "geometry": (*_SIZES, "mesh"),
}
_ONCE = {  # of these the parser takes the first, and drops the others
    "joint": ("origin", "parent", "child", "axis", "limit", "mimic", "safety_controller"),
    "collision": ("origin", "geometry"),
}
_ALIKE = 0.65  # of attributes: that is how near "ryp" is to "rpy"
_ATTRIBUTES = {tag: tuple(numbers) for tag, numbers in _NUMBERS.items()} | {
    "limit": ("lower", "upper", "effort", "velocity", "gear_velocity"),
    "safety_controller": ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"),
    "mesh": ("filename", "scale"),
    "mimic": ("joint", "multiplier", "offset"),
}


def require_sane_urdf(root: ET.Element, path: Path) -> None:
    """Raise :class:`RobotError` for the first thing in the URDF at ``path`` that makes no robot."""
    links, joints = root.findall("link"), root.findall("joint")
    parts = (*root.iterfind("link//collision"), *root.iterfind("link//geometry"))
    _require_spelling([root, *links, *joints, *parts], path)
    _require_one_each([*joints, *parts], path)
    _require_in_place(root, path)
    _require_names(links, "link", path)
    _require_names(joints, "joint", path)
    _require_tree([link.get("name", "") for link in links], joints, path)
    for item in (*links, *joints):
        _require_numbers(item, f"URDF {path}: {item.tag} {shown(item.get('name'))}")
    for joint in joints:
        axis = joint.find("axis")
        if axis is None or axis.get("xyz") is None or joint.get("type") in ("fixed", "floating"):
            continue
        if math.hypot(*floats(axis.get("xyz", ""))) < 1e-6:
            name = shown(joint.get("name"))
            raise RobotError(f"URDF {path}: the axis of joint {name} has no direction; mend the file.")


def _require_spelling(elements: Sequence[ET.Element], path: Path) -> None:
    """Raise where an element or attribute is nearly one that means something: parsers pass over unknown ones.

    And for every unknown attribute of an origin: it says where something is, or how it is turned.
    """
    for element in elements:
        where = f"URDF {path}: <{element.tag}> {shown(element.get('name'))}" if element.get("name") else f"URDF {path}"
        for child in element:
            inner, known = _INNER[element.tag], _ATTRIBUTES.get(child.tag, ())
            wrong = [(child.tag, inner, 0.7), *((key, known, _ALIKE) for key in child.attrib if known)]
            for word, words, alike in wrong:
                meant = nearest(word, words, alike) if word not in words else ""
                if meant:
                    raise RobotError(f"{where} holds {shown(word)}{meant}, which means nothing; mend the file.")
            strange = [key for key in child.attrib if child.tag == "origin" and key not in known]
            if strange:
                said = f"an origin with {shown(strange[0])}, which means nothing"
                raise RobotError(f"{where} holds {said}; place it by {choices(known)}.")


def _require_one_each(elements: Sequence[ET.Element], path: Path) -> None:
    """Raise for what stands twice where only the first counts: two shapes in one geometry, two axes of a joint."""
    for element in elements:
        tags = [child.tag for child in element]
        twice = next((tag for tag in _ONCE.get(element.tag, ()) if tags.count(tag) > 1), None)
        shapes = [tag for tag in tags if tag in _INNER["geometry"]] if element.tag == "geometry" else []
        if twice is not None or len(shapes) > 1:
            of = f" {shown(element.get('name'))}" if element.get("name") else ""
            what = f"<{twice}> twice" if twice else f"several shapes, {choices(shapes)}"
            remedy = "" if element.tag == "joint" else ", and give each shape a <collision> of its own"
            raise RobotError(
                f"URDF {path}: a <{element.tag}>{of} holds {what}, of which only the first would count: leave "
                f"one{remedy}."
            )


def _require_in_place(root: ET.Element, path: Path) -> None:
    """Raise for a link, joint or collision in a link or joint, where parsers do not look for it."""
    for place in ("link/link", "link/joint", "joint/link", "joint/joint", "joint/collision"):
        lost = root.find(place)
        if lost is not None:
            name, holder = shown(lost.get("name")), place.partition("/")[0]
            raise RobotError(f"URDF {path}: <{lost.tag}> {name} stands inside a <{holder}>: move it out of there.")


def _require_names(items: Sequence[ET.Element], kind: str, path: Path) -> None:
    seen: set[str] = set()
    for item in items:
        name = item.get("name")
        if not name:
            raise RobotError(f"URDF {path} has a {kind} without a name: give it one.")
        if name == "universe":
            raise RobotError(f"URDF {path} calls a {kind} 'universe', which is the world's own name: rename it.")
        if name in seen:
            raise RobotError(f"URDF {path} has two {kind}s called {shown(name)}: rename one of them.")
        seen.add(name)


def _require_tree(links: Sequence[str], joints: Sequence[ET.Element], path: Path) -> None:
    if not links:
        raise RobotError(f"URDF {path} has no links: give it some.")
    parents: dict[str, str] = {}
    for joint in joints:
        name, (parent, child) = shown(joint.get("name")), ends(joint)
        for role, link in (("parent", parent), ("child", child)):
            if link not in links:
                raise RobotError(f"URDF {path}: {role} {shown(link)} of joint {name} is no link: mend the file.")
        if child in parents:
            raise RobotError(f"URDF {path}: link {shown(child)} is the child of two joints; give it one parent.")
        parents[child] = parent
    roots = [link for link in links if link not in parents]
    if len(roots) > 1:
        raise RobotError(
            f"URDF {path} is in {len(roots)} pieces, {shown(roots[0])} and {shown(roots[1])} have no parent: join them."
        )
    below: dict[str, list[str]] = {}
    for child, parent in parents.items():
        below.setdefault(parent, []).append(child)
    reached = list(roots)
    for link in reached:  # the loop appends to it
        reached += below.get(link, [])
    if len(reached) < len(links):
        lost = next(link for link in links if link not in set(reached))
        raise RobotError(f"URDF {path}: link {shown(lost)} hangs in a loop of joints; links must form a tree.")


def ends(joint: ET.Element) -> tuple[str, str]:
    """The names of a joint's parent and child link, empty where it has none."""
    parent, child = joint.find("parent"), joint.find("child")
    return "" if parent is None else parent.get("link", ""), "" if child is None else child.get("link", "")


def _require_numbers(item: ET.Element, where: str) -> None:
    for element in item.iter():
        for attribute, count in _NUMBERS.get(element.tag, {}).items():
            text = element.get(attribute)
            if text is None:
                continue
            quoted, values = f"{where}: {attribute}={shown(text)} of <{element.tag}>", list(floats(text))
            if len(values) != count or not all(map(math.isfinite, values)):
                some = "a finite number" if count == 1 else f"{count} finite numbers"
                raise RobotError(f"{quoted} is not {some}; mend the file.")
            if max(map(abs, values)) > FARTHEST and element.tag not in _BOUNDLESS:
                raise RobotError(f"{quoted} is beyond {FARTHEST:g}; mend the file.")
            if element.tag in _SIZES and min(values) < SMALLEST:
                raise RobotError(f"{quoted} is no size in metres; mend the file.")
            if attribute == "quat_xyzw" and math.hypot(*values) < 1e-6:
                raise RobotError(f"{quoted} has no direction; mend the file.")
            if element.tag == "mesh" and min(map(abs, values)) < 1e-9:
                raise RobotError(f"{quoted} leaves nothing of the mesh; mend the file.")


def floats(text: str) -> Iterator[float]:
    """The numbers of a text, NaN for a word that is none."""
    for word in text.split():
        try:
            yield number(word)
        except ValueError:
            yield math.nan
