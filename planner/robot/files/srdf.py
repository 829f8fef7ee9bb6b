"""SRDF, MoveIt's semantic companion of a URDF: pairs that need no check, planning groups, named group states.

Pinocchio reads these too, but skips what it cannot use without a word, and knows no groups.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pinocchio as pin

from planner.base.errors import Note, RobotError, choices
from planner.base.yamlfile import FARTHEST, repeated, shown
from planner.robot.files import urdf
from planner.robot.files.urdf_rules import floats
from planner.robot.files.xacro import read_root

_NEEDED = {  # the attributes that an element must have, by its place
    **dict.fromkeys(("group", "group/joint", "group/link", "group/group", "group/passive_joint"), ("name",)),
    **dict.fromkeys(("group_state", "passive_joint"), ("name",)),
    "group/chain": ("base_link", "tip_link"),
    "group_state/joint": ("name", "value"),
    "virtual_joint": (),
    "disable_collisions": ("link1", "link2"),
    "enable_collisions": ("link1", "link2"),
    "disable_default_collisions": ("link",),
}
_HARMLESS = ("end_effector", "link_sphere_approximation", "joint_property")  # no path depends on them


@dataclass(frozen=True)
class GroupState:
    """Named values (rad, m) of the joints of a group that have one."""

    name: str
    group: str
    values: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Srdf:
    """The parts of an SRDF that count here; ``disabled`` are pairs of links that need no collision check.

    Nor do the links ``unchecked`` against any other link, but for the pairs ``enabled``. The robot's base stands in
    ``world_frame``, and ``moves`` there if not fixed; ``other`` are the parts of the file that are not read.
    """

    path: Path
    robot: str  # the name of its robot
    disabled: frozenset[frozenset[str]]
    enabled: frozenset[frozenset[str]]
    unchecked: tuple[str, ...]
    groups: Mapping[str, ET.Element]
    states: tuple[GroupState, ...]
    passive: frozenset[str]
    world_frame: str
    moves: str
    other: tuple[str, ...]

    def disabled_among(self, links: Iterable[str]) -> frozenset[frozenset[str]]:
        """The pairs of a robot's ``links`` that need no collision check."""
        pairs = {frozenset((one, other)) for one in self.unchecked for other in links if one != other}
        return self.disabled | (frozenset(pairs) - self.enabled)

    def notes(self, description: urdf.Description, is_own: bool) -> Iterator[Note]:
        """Notes on the parts that are not followed as they stand; a robot file says that an SRDF is the robot's own."""
        links = {link for pair in self.disabled | self.enabled for link in pair} | {*self.unchecked}
        joints = {*self.passive, *(joint for state in self.states for joint in state.values)}
        parts = {
            "it is of another robot than the URDF": {self.robot} - {description.name, "" if not is_own else self.robot},
            "a virtual_joint moves the base, which stands here: give it a base": {self.moves} - {"fixed"},
            "links and joints that the URDF lacks are skipped": links - description.links
            | joints - {*description.joints},
            "elements and values that are not supported are skipped": self.other,
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
    other = list(_unread(root, path))
    _require_once(root, path)
    virtual = root.find("virtual_joint")
    return Srdf(
        path=path,
        robot=root.get("name", ""),
        disabled=_pairs(root, "disable_collisions"),
        enabled=_pairs(root, "enable_collisions"),
        unchecked=tuple(item.attrib["link"] for item in root.findall("disable_default_collisions")),
        groups={item.attrib["name"]: item for item in root.findall("group")},
        states=tuple(_state(item, path, other) for item in root.findall("group_state")),
        passive=frozenset(_names(root, "passive_joint") + _names(root, "group/passive_joint")),
        world_frame="" if virtual is None else virtual.get("parent_frame", ""),
        moves="fixed" if virtual is None else virtual.get("type", "fixed"),
        other=tuple(dict.fromkeys(other)),
    )


def _unread(element: ET.Element, path: Path, at: str = "") -> Iterator[str]:
    """The places of elements that are not read; :class:`RobotError` for incomplete elements."""
    for child in element:
        place = f"{at}{child.tag}"
        for name in _NEEDED.get(place, ()):
            if not child.get(name, "").strip():
                raise RobotError(f"SRDF {path} has a <{child.tag}> without attribute '{name}'; add it.")
        if place in _NEEDED:
            yield from _unread(child, path, f"{place}/")
        elif place not in _HARMLESS:
            yield place


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
    name, found = element.attrib["name"], dict[str, float]()
    for joint, text in ((item.attrib["name"], item.attrib["value"]) for item in element.findall("joint")):
        values = floats(text)
        if len(values) > 1:
            other.append(f"several values of joint {shown(joint)} in state {shown(name)}")
        elif not abs(values[0]) <= FARTHEST:
            raise RobotError(
                f"SRDF {path}: state {shown(name)} sets joint {shown(joint)} to {shown(text)}: give a number of at "
                f"most {FARTHEST:g}."
            )
        else:
            found[joint] = values[0]
    return GroupState(name, element.get("group", ""), found)


def require_fitting(srdf: Srdf, model: pin.Model) -> None:
    """Raise :class:`RobotError` for an SRDF that speaks of other links only: it is another robot's."""
    named = {link for pair in srdf.disabled for link in pair}
    if named and not named & {frame.name for frame in model.frames}:
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
    chains = [item.attrib for item in srdf.groups[name].findall("chain")]
    joints, links = (_names(srdf.groups[name], kind) for kind in ("joint", "link"))
    ends = [chain[end] for chain in chains for end in ("base_link", "tip_link")]
    unknown = [each for each in joints if each not in description.joints]
    if unknown := unknown + [each for each in (*links, *ends) if each not in description.links]:
        raise RobotError(f"{where} names {shown(unknown[0])}, which the URDF lacks: mend one of the two.")
    parents = {child: joint for joint, (_, child) in description.joints.items()}
    yield from joints
    yield from (parents[link] for link in links if link in parents)
    for chain in chains:
        link = chain["tip_link"]
        while link != chain["base_link"]:
            if link not in parents:
                ends = f"{shown(chain['base_link'])} to {shown(chain['tip_link'])}"
                raise RobotError(f"{where} has a chain from {ends}, but no joints lead there: mend it.")
            yield parents[link]
            link = description.joints[parents[link]][0]
    for inner in _names(srdf.groups[name], "group"):
        yield from _joints_of(srdf, inner, description, (*outer, name))
