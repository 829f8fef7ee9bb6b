"""SRDF, MoveIt's semantic companion of a URDF: pairs that need no check, planning groups, named group states."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pinocchio as pin

from planner.base.errors import RobotError, choices
from planner.base.words import number
from planner.base.yamlfile import FARTHEST, nearest, repeated, shown
from planner.models.files import urdf
from planner.models.files.xacro import read_root

_ELEMENTS = {  # with the attributes without which they mean nothing
    "group": ("name",),
    "group_state": ("name",),
    "passive_joint": ("name",),
    "virtual_joint": (),
    "disable_collisions": ("link1", "link2"),
    "enable_collisions": ("link1", "link2"),
    "disable_default_collisions": ("link",),
}
_OPTIONAL = {
    "group_state": ("group",),
    "virtual_joint": ("name", "type", "parent_frame", "child_link"),
    "disable_collisions": ("reason",),
    "enable_collisions": ("reason",),
}
_HARMLESS = ("end_effector", "link_sphere_approximation", "joint_property")  # no path depends on them
_INNER = {
    "group": {"joint": ("name",), "link": ("name",), "group": ("name",), "chain": ("base_link", "tip_link")},
    "group_state": {"joint": ("name", "value")},
}
_BASES = ("fixed", "planar", "floating")  # types of virtual_joint
_DEEPEST = 100  # groups within groups: of more, one contains itself


@dataclass(frozen=True)
class Group:
    """A planning group: joints and links by name, chains as (base link, tip link), and other groups."""

    name: str
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    chains: tuple[tuple[str, str], ...] = ()
    groups: tuple[str, ...] = ()


@dataclass(frozen=True)
class GroupState:
    """Named values (rad, m) of the joints of a group; those ``of_several`` degrees of freedom have more than one."""

    name: str
    group: str
    values: Mapping[str, float]
    of_several: tuple[str, ...] = ()


@dataclass(frozen=True)
class Srdf:
    """What we take from an SRDF; ``disabled`` are pairs of links that need no collision check.

    Nor do the links ``unchecked`` against any other link, but for the pairs ``enabled``. ``world_frame`` is how it
    calls the frame that the robot's root, to it ``virtual_child``, stands or moves in; ``other`` are its elements that
    mean nothing here, and attributes that do not.
    """

    path: Path
    disabled: frozenset[frozenset[str]]
    groups: Mapping[str, Group] = field(default_factory=dict)
    states: tuple[GroupState, ...] = ()
    passive: frozenset[str] = frozenset()
    unchecked: tuple[str, ...] = ()
    enabled: frozenset[frozenset[str]] = frozenset()
    world_frame: str = ""
    base_moves: bool = False
    virtual_joints: int = 0
    virtual_child: str = ""
    other: tuple[str, ...] = ()
    robot: str = ""  # which it says that it is of

    def disabled_among(self, links: Iterable[str]) -> frozenset[frozenset[str]]:
        """The pairs of a robot's ``links`` that need no collision check."""
        pairs = {frozenset((one, other)) for one in self.unchecked for other in links if one != other}
        return self.disabled | (frozenset(pairs) - self.enabled)

    def strangers(self, description: urdf.Description) -> list[str]:
        """The links and joints that the SRDF speaks of and the URDF does not have, sorted."""
        links = {link for pair in self.disabled | self.enabled for link in pair} | {*self.unchecked}
        joints = {*self.passive, *(joint for state in self.states for joint in state.values)}
        return sorted((links - description.links) | (joints - description.joints.keys()))


def read_srdf(path: Path, arguments: Mapping[str, str] | None = None) -> Srdf:
    """The SRDF at ``path``, xacro with ``arguments`` included; :class:`RobotError` says what is wrong with it."""
    root = read_root(path, "SRDF", arguments)
    if root.tag != "robot":
        raise RobotError(f"{path} is no SRDF: its root element is <{shown(root.tag)[1:-1]}>, not <robot>.")
    _require_known(root, path)
    _require_in_place(root, path)
    _require_once(root, path)
    groups = [_group(item) for item in root.findall("group")]
    virtual = root.find("virtual_joint")
    for kind in (item.get("type", "fixed") for item in root.findall("virtual_joint")):
        if kind not in _BASES:
            raise RobotError(
                f"SRDF {path} has a <virtual_joint> of type {shown(kind)}{nearest(kind, _BASES)}; "
                f"use {choices(_BASES)}."
            )
    return Srdf(
        path=path,
        disabled=_pairs(root, "disable_collisions"),
        groups={group.name: group for group in groups},
        states=tuple(_state(item, path) for item in root.findall("group_state")),
        passive=frozenset(item.get("name", "") for item in root.findall("passive_joint")),
        unchecked=tuple(item.get("link", "") for item in root.findall("disable_default_collisions")),
        enabled=_pairs(root, "enable_collisions"),
        world_frame="" if virtual is None else virtual.get("parent_frame", ""),
        base_moves=virtual is not None and virtual.get("type", "fixed") != "fixed",
        other=tuple(dict.fromkeys(_others(root))),
        virtual_joints=len(root.findall("virtual_joint")),
        virtual_child="" if virtual is None else virtual.get("child_link", ""),
        robot=root.get("name", ""),
    )


def _others(root: ET.Element) -> Iterator[str]:
    """The elements that mean nothing here, and attributes of elements that do, as ``tag's attribute``."""
    for element in root:
        if element.tag in _ELEMENTS:
            yield from (f"{element.tag}'s {shown(key)}" for key in element.attrib if key not in _attributes(element))
            for child in element:
                known = _INNER.get(element.tag, {}).get(child.tag, child.attrib)
                yield from (f"{child.tag}'s {shown(key)}" for key in child.attrib if key not in known)
        elif element.tag not in _HARMLESS:
            yield element.tag


def _attributes(element: ET.Element) -> tuple[str, ...]:
    return (*_ELEMENTS[element.tag], *_OPTIONAL.get(element.tag, ()))


def _pairs(root: ET.Element, kind: str) -> frozenset[frozenset[str]]:
    return frozenset(frozenset((pair.get("link1", ""), pair.get("link2", ""))) for pair in root.iter(kind))


def _require_known(root: ET.Element, path: Path) -> None:
    """Raise :class:`RobotError` for an element that is misspelt, or without the attributes that give it a meaning.

    Elements that are nothing like those of an SRDF are other programs' own.
    """
    for element in root:
        known = *_ELEMENTS, *_HARMLESS
        meant = "" if element.tag in known else nearest(element.tag, known)
        if meant:
            raise RobotError(f"SRDF {path} has an unknown element {shown(element.tag)}{meant}; mend the file.")
        _require_attributes(element, _ELEMENTS.get(element.tag, ()), path)
        absent = [key for key in _OPTIONAL.get(element.tag, ()) if key not in element.attrib]
        for key in element.attrib if absent else ():
            if key not in _attributes(element) and (meant := nearest(key, absent)):
                raise RobotError(f"SRDF {path} has a <{element.tag}> with {shown(key)}{meant}; mend the file.")
        inner = _INNER.get(element.tag, {})
        for child in element if inner else ():
            if child.tag not in inner:
                raise RobotError(
                    f"SRDF {path}: <{element.tag}> {shown(element.get('name'))} holds an unknown element "
                    f"{shown(child.tag)}{nearest(str(child.tag), inner)}; use {choices(inner)}."
                )
            _require_attributes(child, inner[child.tag], path)


def _require_in_place(root: ET.Element, path: Path) -> None:
    """Raise :class:`RobotError` for what stands inside an element where MoveIt does not look for it."""
    for element in root:
        for outer in element.iter():
            for lost in outer:
                held = outer is element and lost.tag in _INNER.get(element.tag, {})
                if not held and (lost.tag in _ELEMENTS or element.tag in _INNER):
                    raise RobotError(
                        f"SRDF {path}: a <{lost.tag}> stands inside a <{shown(outer.tag)[1:-1]}>: move it out of there."
                    )


def _require_once(root: ET.Element, path: Path) -> None:
    """Raise :class:`RobotError` for groups, states of a group, or joints of a state, that are said twice."""
    said = [f"group {shown(each.get('name'))}" for each in root.findall("group")]
    for state in root.findall("group_state"):
        what = f"state {shown(state.get('name'))} of group {shown(state.get('group'))}"
        said += [what, *(f"joint {shown(joint.get('name'))} in {what}" for joint in state.findall("joint"))]
    if twice := repeated(said):
        raise RobotError(f"SRDF {path} says {twice[0]} twice, and only the last would count: leave one of them.")


def _require_attributes(element: ET.Element, names: Iterable[str], path: Path) -> None:
    lacking = [name for name in names if not element.get(name, "").strip()]
    if lacking:
        meant = nearest(lacking[0], (key for key in element.attrib if key not in names))
        raise RobotError(f"SRDF {path} has a <{element.tag}> without attribute '{lacking[0]}'{meant}; add it.")


def _group(element: ET.Element) -> Group:
    named = {kind: tuple(item.get("name", "") for item in element.findall(kind)) for kind in ("joint", "link", "group")}
    chains = tuple((item.get("base_link", ""), item.get("tip_link", "")) for item in element.findall("chain"))
    return Group(element.get("name", ""), named["joint"], named["link"], chains, named["group"])


def _state(element: ET.Element, path: Path) -> GroupState:
    name, values, of_several = element.get("name", ""), {}, list[str]()
    for joint in element.findall("joint"):
        text = joint.get("value", "").split()
        if len(text) > 1:
            of_several.append(joint.get("name", ""))
            continue
        try:
            value = number(text[0])
        except ValueError:
            value = np.nan
        if not abs(value) <= FARTHEST:
            raise RobotError(
                f"SRDF {path}: state {shown(name)} sets joint {shown(joint.get('name'))} to {shown(text[0])}: "
                f"give a number of at most {FARTHEST:g}."
            )
        values[joint.get("name", "")] = value
    return GroupState(name, element.get("group", ""), values, tuple(of_several))


def require_fitting(srdf: Srdf, model: pin.Model) -> None:
    """Raise :class:`RobotError` for an SRDF that speaks of other links only: it is another robot's."""
    links = {frame.name for frame in model.frames}
    named = {link for pair in srdf.disabled for link in pair}
    if named and not named & links:
        raise RobotError(
            f"SRDF {srdf.path} names no link of this robot, only {choices(sorted(named))}: give the SRDF of this URDF."
        )


def require_one_value_each(srdf: Srdf, model: pin.Model) -> None:
    """Raise :class:`RobotError` for a state that gives a joint of the model more than its one value."""
    for state in srdf.states:
        for joint in state.of_several:
            if model.existJointName(joint):
                raise RobotError(
                    f"SRDF {srdf.path}: state {shown(state.name)} gives joint {shown(joint)} several values, and it "
                    "has one degree of freedom: give one."
                )


def group_joints(srdf: Srdf, name: str, description: urdf.Description, model: pin.Model) -> list[str]:
    """The joints that move by themselves in the group ``name``, base first: not fixed, passive or mimicking ones.

    Raises :class:`RobotError` for an unknown group, or one that names unknown links or moves nothing.
    """
    found = {joint for group in _with_subgroups(srdf, name) for joint in _joints_of(group, srdf, description)}
    found -= srdf.passive | {item.joint for item in description.mimics}
    joints = [joint for joint in model.names[1:] if joint in found]
    if not joints:
        raise RobotError(f"group '{name}' of SRDF {srdf.path} moves no joint of this robot: choose another --group.")
    return joints


def group_tip(srdf: Srdf, name: str, description: urdf.Description, model: pin.Model) -> str:
    """The link at the end of the group: the tip of its chain, or else what its last joint moves."""
    tips = [tip for _, tip in srdf.groups[name].chains]
    return tips[0] if len(tips) == 1 else description.child_of(group_joints(srdf, name, description, model)[-1])


def states_of_joints(srdf: Srdf, joints: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """The named states that say something of every one of ``joints``; of two with one name the smaller group's."""
    found: dict[str, tuple[float, ...]] = {}
    for state in sorted(srdf.states, key=lambda item: -len(item.values)):
        if all(joint in state.values for joint in joints):
            found[state.name] = tuple(state.values[joint] for joint in joints)
    return found


def _with_subgroups(srdf: Srdf, name: str) -> Iterator[Group]:
    level = [name]
    for _ in range(_DEEPEST):
        for each in level:
            if each not in srdf.groups:
                raise RobotError(f"group '{each}' not found in SRDF {srdf.path}; groups are {choices(srdf.groups)}.")
            yield srdf.groups[each]
        level = sorted({each for outer in level for each in srdf.groups[outer].groups})
        if not level:
            return
    raise RobotError(f"group '{name}' of SRDF {srdf.path} contains itself: mend the file.")


def _joints_of(group: Group, srdf: Srdf, description: urdf.Description) -> Iterator[str]:
    where = f"group '{group.name}' of SRDF {srdf.path}"
    for joint in group.joints:
        if joint not in description.joints:
            raise RobotError(f"{where} names joint {shown(joint)}, which the URDF has not: mend one of the two.")
        yield joint
    yield from filter(None, (_parent_joint(description, link, where) for link in group.links))
    for base, tip in group.chains:
        yield from _between(description, base, tip, where)


def _between(description: urdf.Description, base: str, tip: str, where: str) -> Iterator[str]:
    _parent_joint(description, base, where)
    link = tip
    while link != base:
        joint = _parent_joint(description, link, where)
        if joint is None:
            raise RobotError(
                f"{where} has a chain from {shown(base)} to {shown(tip)}, but no joints lead there: mend it."
            )
        yield joint
        link = description.joints[joint][0]


def _parent_joint(description: urdf.Description, link: str, where: str) -> str | None:
    """The joint, moving or fixed, that holds ``link``; None for the root."""
    if link not in description.links:
        raise RobotError(f"{where} names link {shown(link)}, which the URDF has not: mend one of the two.")
    return next((joint for joint, (_, child) in description.joints.items() if child == link), None)
