"""SRDF, MoveIt's semantic companion of a URDF: pairs that need no check, planning groups, named group states.

Pinocchio reads these too, and drops in silence what it cannot use: pairs of unknown links, misspelt elements, links
that are off by default, the second of two states of one name; a joint that a state does not name becomes 0.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from planner.base.errors import RobotError, choices
from planner.base.notes import Note
from planner.base.words import number
from planner.base.yamlfile import FARTHEST, nearest, repeated, shown
from planner.robot.files import urdf
from planner.robot.files.xacro import read_root

_ATTRIBUTES = {  # of elements by their place: those that an element needs, then the others, after a /
    "group": "name /",
    "group/joint": "name /",
    "group/link": "name /",
    "group/group": "name /",
    "group/passive_joint": "name /",
    "group/chain": "base_link tip_link /",
    "group_state": "name / group",
    "group_state/joint": "name value /",
    "passive_joint": "name /",
    "virtual_joint": "/ name type parent_frame child_link",
    "disable_collisions": "link1 link2 / reason",
    "enable_collisions": "link1 link2 / reason",
    "disable_default_collisions": "link /",
}
_HARMLESS = ("end_effector", "link_sphere_approximation", "joint_property")  # no path depends on them
_BASES = ("fixed", "planar", "floating")  # types of virtual_joint


@dataclass(frozen=True)
class GroupState:
    """Named values (rad, m) of the joints of a group that have one."""

    name: str
    group: str
    values: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Srdf:
    """The parts of an SRDF that count here; ``disabled`` are pairs of links that need no collision check.

    Nor do the links ``unchecked`` against any other link, but for the pairs ``enabled``. The ``virtual`` joint
    holds the robot's root in the world; ``other`` are its elements, attributes and values that mean nothing here.
    """

    path: Path
    robot: str  # the name of its robot
    disabled: frozenset[frozenset[str]]
    enabled: frozenset[frozenset[str]]
    unchecked: tuple[str, ...]
    groups: Mapping[str, ET.Element]
    states: tuple[GroupState, ...]
    passive: frozenset[str]
    passive_in_groups: tuple[str, ...]
    virtual: Mapping[str, str]
    other: tuple[str, ...]

    @property
    def world_frame(self) -> str:
        """Its name of the frame that the robot's root stands or moves in."""
        return self.virtual.get("parent_frame", "")

    def disabled_among(self, links: Iterable[str]) -> frozenset[frozenset[str]]:
        """The pairs of a robot's ``links`` that need no collision check."""
        pairs = {frozenset((one, other)) for one in self.unchecked for other in links if one != other}
        return self.disabled | (frozenset(pairs) - self.enabled)

    def notes(self, description: urdf.Description, is_own: bool) -> Iterator[Note]:
        """Notes on the parts that are not followed as they stand; a robot file says that an SRDF is the robot's own."""
        links = {link for pair in self.disabled | self.enabled for link in pair} | {*self.unchecked}
        joints = {*self.passive, *(joint for state in self.states for joint in state.values)}
        roots = description.links - {child for _, child in description.joints.values()}
        held, moves = self.virtual.get("child_link", ""), self.virtual.get("type", "fixed")
        strangers = (links - description.links) | (joints - description.joints.keys())
        parts = {
            "it is of another robot than the URDF": {self.robot} - {description.name, "" if not is_own else self.robot},
            "joints that a group calls passive are not planned in any group": self.passive_in_groups,
            "a virtual_joint moves the base, which stands here: give it a base": {moves} - {"fixed"},
            "its virtual_joint holds a link that is not the root, which stands in its place": {held} - {"", *roots},
            "links and joints that the URDF has not are passed over": strangers,
            "elements, attributes and values that mean nothing here are passed over": self.other,
            "links off by default are checked against obstacles only": self.unchecked,
        }
        for text, names in parts.items():
            if names:
                yield Note(f"SRDF {self.path}: {text}: {choices(sorted(names))}.", names == self.unchecked)


def read_srdf(path: Path, arguments: Mapping[str, str] | None = None) -> Srdf:
    """The SRDF at ``path``, xacro with ``arguments`` included; :class:`RobotError` says what is wrong with it."""
    root = read_root(path, "SRDF", arguments)
    if root.tag != "robot":
        raise RobotError(f"{path} is no SRDF: its root element is <{shown(root.tag)[1:-1]}>, not <robot>.")
    other = [*_unread(root, path), *(f"virtual_joint {k}" for k in range(2, len(root.findall("virtual_joint")) + 1))]
    _require_once(root, path)
    virtual = [item.attrib for item in root.findall("virtual_joint")]
    for kind in (item.get("type", "fixed") for item in virtual):
        if kind not in _BASES:
            meant = nearest(kind, _BASES)
            raise RobotError(f"SRDF {path}: a virtual_joint has type {shown(kind)}{meant}; use {choices(_BASES)}.")
    return Srdf(
        path=path,
        robot=root.get("name", ""),
        disabled=_pairs(root, "disable_collisions"),
        enabled=_pairs(root, "enable_collisions"),
        unchecked=tuple(item.attrib["link"] for item in root.findall("disable_default_collisions")),
        groups={item.attrib["name"]: item for item in root.findall("group")},
        states=tuple(_state(item, path, other) for item in root.findall("group_state")),
        passive=frozenset(_names(root, "passive_joint") + _names(root, "group/passive_joint")),
        passive_in_groups=tuple(_names(root, "group/passive_joint")),
        virtual=virtual[0] if virtual else {},
        other=tuple(dict.fromkeys(other)),
    )


def _unread(element: ET.Element, path: Path, at: str = "") -> Iterator[str]:
    """The elements and attributes that mean nothing here; :class:`RobotError` for misspelt or incomplete elements."""
    siblings = [place.removeprefix(at) for place in _ATTRIBUTES if place.startswith(at)]
    for child in element:
        place = f"{at}{child.tag}"
        if place not in _ATTRIBUTES:
            if place in _HARMLESS:
                continue
            if meant := nearest(str(child.tag), [*siblings, *_HARMLESS]):
                raise RobotError(f"SRDF {path} has an unknown element {shown(place)}{meant}; mend the file.")
            yield place
            continue
        needed, optional = (part.split() for part in _ATTRIBUTES[place].split("/"))
        if lacking := [name for name in needed if not child.get(name, "").strip()]:
            meant = nearest(lacking[0], child.attrib)
            raise RobotError(f"SRDF {path} has a <{child.tag}> without attribute '{lacking[0]}'{meant}; add it.")
        yield from (f"{place}'s {shown(key)}" for key in child.attrib if key not in (*needed, *optional))
        yield from _unread(child, path, f"{place}/")


def _require_once(root: ET.Element, path: Path) -> None:
    """Raise :class:`RobotError` for two groups, states of a group, or joints of a state with one name."""
    names = [f"group {shown(each.get('name'))}" for each in root.findall("group")]
    for state in root.findall("group_state"):
        text = f"state {shown(state.get('name'))} of group {shown(state.get('group'))}"
        names += [text, *(f"joint {shown(joint.get('name'))} in {text}" for joint in state.findall("joint"))]
    if twice := repeated(names):
        raise RobotError(f"SRDF {path} says {twice[0]} twice, and only the last would count: leave one of them.")


def _pairs(root: ET.Element, kind: str) -> frozenset[frozenset[str]]:
    return frozenset(frozenset((pair.attrib["link1"], pair.attrib["link2"])) for pair in root.findall(kind))


def _names(element: ET.Element, kind: str) -> list[str]:
    return [item.attrib["name"] for item in element.findall(kind)]


def _state(element: ET.Element, path: Path, other: list[str]) -> GroupState:
    """A state; joints of several degrees of freedom go to ``other``."""
    name, values = element.attrib["name"], dict[str, float]()
    for joint, text in ((item.attrib["name"], item.attrib["value"]) for item in element.findall("joint")):
        if len(text.split()) > 1:
            other.append(f"several values of joint {shown(joint)} in state {shown(name)}")
            continue
        try:
            values[joint] = number(text.strip())
        except ValueError:
            values[joint] = np.nan
        if not abs(values[joint]) <= FARTHEST:
            raise RobotError(
                f"SRDF {path}: state {shown(name)} sets joint {shown(joint)} to {shown(text)}: give a number of at "
                f"most {FARTHEST:g}."
            )
    return GroupState(name, element.get("group", ""), values)


def require_fitting(srdf: Srdf, model: pin.Model) -> None:
    """Raise :class:`RobotError` for an SRDF that speaks of other links only: it is another robot's."""
    links = {frame.name for frame in model.frames}
    named = {link for pair in srdf.disabled for link in pair}
    if named and not named & links:
        raise RobotError(
            f"SRDF {srdf.path} names no link of this robot, only {choices(sorted(named))}: give the SRDF of this URDF."
        )


def group_joints(srdf: Srdf, name: str, description: urdf.Description, model: pin.Model) -> list[str]:
    """The joints that move by themselves in the group ``name``, base first: not fixed, passive or mimicking ones.

    Raises :class:`RobotError` for an unknown group, or one that names unknown links or moves nothing.
    """
    found = set(_joints_of(srdf, name, description)) - srdf.passive - {item.joint for item in description.mimics}
    joints = [joint for joint in model.names[1:] if joint in found]
    if not joints:
        raise RobotError(f"group '{name}' of SRDF {srdf.path} moves no joint of this robot: choose another --group.")
    return joints


def group_tip(srdf: Srdf, name: str, description: urdf.Description, model: pin.Model) -> str:
    """The link at the end of the group: the tip of its chain, or else the link that its last joint moves."""
    tips = [chain.attrib["tip_link"] for chain in srdf.groups[name].findall("chain")]
    return tips[0] if len(tips) == 1 else description.child_of(group_joints(srdf, name, description, model)[-1])


def states_of_joints(srdf: Srdf, joints: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """The named states that say something of every one of ``joints``; of two with one name the smaller group's."""
    found: dict[str, tuple[float, ...]] = {}
    for state in sorted(srdf.states, key=lambda item: -len(item.values)):
        if all(joint in state.values for joint in joints):
            found[state.name] = tuple(state.values[joint] for joint in joints)
    return found


def _joints_of(srdf: Srdf, name: str, description: urdf.Description, outer: tuple[str, ...] = ()) -> Iterator[str]:
    """The joints, moving or fixed, that a group and the groups in it name by themselves, by links and by chains."""
    where = f"group '{name}' of SRDF {srdf.path}"
    if name not in srdf.groups:
        raise RobotError(f"group '{name}' not found in SRDF {srdf.path}; groups are {choices(srdf.groups)}.")
    if name in outer:
        raise RobotError(f"{where} contains itself: mend the file.")
    for joint in _names(srdf.groups[name], "joint"):
        if joint not in description.joints:
            raise RobotError(f"{where} names joint {shown(joint)}, which the URDF has not: mend one of the two.")
        yield joint
    parents = {child: joint for joint, (_, child) in description.joints.items()}
    chains = [item.attrib for item in srdf.groups[name].findall("chain")]
    links = _names(srdf.groups[name], "link")
    for link in (*links, *(end for chain in chains for end in (chain["base_link"], chain["tip_link"]))):
        if link not in description.links:
            raise RobotError(f"{where} names link {shown(link)}, which the URDF has not: mend one of the two.")
    yield from (parents[link] for link in links if link in parents)
    for chain in chains:
        base, link = chain["base_link"], chain["tip_link"]
        while link != base:
            if link not in parents:
                text = f"a chain from {shown(base)} to {shown(chain['tip_link'])}, but no joints lead there: mend it."
                raise RobotError(f"{where} has {text}")
            yield parents[link]
            link = description.joints[parents[link]][0]
    for inner in _names(srdf.groups[name], "group"):
        yield from _joints_of(srdf, inner, description, (*outer, name))
