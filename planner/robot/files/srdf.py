"""SRDF, MoveIt's companion of a URDF: disabled pairs, planning groups, named states.

Pinocchio reads pairs and states too, but skips invalid ones silently and ignores groups.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pinocchio as pin

from planner.base.errors import Note, RobotError, choices
from planner.base.yamlfile import quote
from planner.robot.files import urdf
from planner.robot.files.packages import read_root
from planner.robot.files.planar import REMEDY, VirtualJoint, part_names

_INSIDE = {"group": ("joint", "link", "chain", "group", "passive_joint"), "group_state": ("joint",)}
_READ = (*_INSIDE, "disable_collisions", "enable_collisions", "disable_default_collisions")
_READ += ("virtual_joint", "passive_joint")
_HARMLESS = ("end_effector", "link_sphere_approximation", "joint_property")  # no path depends on them


@dataclass(frozen=True)
class GroupState:
    """Named joint values (rad, m) of a group."""

    name: str
    values: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Srdf:
    """The parts of an SRDF that planning uses; ``disabled`` link pairs need no collision check.

    ``unchecked`` links are checked against no other link except in ``enabled`` pairs. The base stands in
    ``world_frame``; ``moves`` is the type of the virtual joint; ``other`` lists ignored elements.
    """

    path: Path
    robot: str  # the name of its robot
    disabled: frozenset[frozenset[str]]
    enabled: frozenset[frozenset[str]]
    unchecked: tuple[str, ...]
    groups: Mapping[str, ET.Element]
    states: tuple[GroupState, ...]
    passive: frozenset[str]
    effectors: frozenset[str]  # the groups of end effectors
    world_frame: str
    moves: str
    virtual: VirtualJoint | None  # by which the base moves in a plane
    other: tuple[str, ...]

    def pairs_without_check(self, links: Iterable[str]) -> frozenset[frozenset[str]]:
        """Return the pairs of ``links`` that need no collision check."""
        pairs = {frozenset((one, other)) for one in self.unchecked for other in links if one != other}
        return self.disabled | (frozenset(pairs) - self.enabled)

    def notes(self, description: urdf.Description, is_own: bool) -> Iterator[Note]:
        """Yield notes on content that is ignored; ``is_own``: a robot file names this SRDF as the robot's."""
        links = {link for pair in self.disabled | self.enabled for link in pair} | {*self.unchecked}
        joints = {*self.passive, *(joint for state in self.states for joint in state.values)}
        moves, base = {self.moves} - {"fixed"}, f"{REMEDY}, or a base" if self.virtual else "a base"
        if self.virtual and {*part_names(self.virtual.name)} <= description.joints.keys():
            moves = set()
        parts = {
            "it is of another robot than the URDF": {self.robot} - {description.name, "" if not is_own else self.robot},
            f"a virtual_joint moves the base, which stands here: give it {base}": moves,
            "links and joints that the URDF lacks are skipped": links - description.links
            | joints - {*description.joints},
            "elements and values that are not supported are skipped": self.other,
            "links off by default are checked against obstacles only": self.unchecked,
        }
        for text, names in parts.items():
            if names:
                yield Note(f"SRDF {self.path}: {text}: {choices(sorted(names))}.", names == self.unchecked)


def read_srdf(path: Path, arguments: Mapping[str, str] | None = None) -> Srdf:
    """Return the SRDF at ``path``, xacro expanded with ``arguments``; :class:`RobotError` if invalid."""
    root = read_root(path, "SRDF", arguments)
    if root.tag != "robot":
        raise RobotError(f"root element of SRDF {path} must be <robot>, got <{quote(root.tag)[1:-1]}>: choose an SRDF.")
    other = [child.tag for child in root if child.tag not in (*_READ, *_HARMLESS)]
    inside = [(outer, inner.tag) for outer in _INSIDE for child in root.iterfind(outer) for inner in child]
    other += [f"{outer}/{inner}" for outer, inner in inside if inner not in _INSIDE[outer]]
    virtual = root.find("virtual_joint")
    try:
        return Srdf(
            path=path,
            robot=root.get("name", ""),
            disabled=_pairs(root, "disable_collisions"),
            enabled=_pairs(root, "enable_collisions"),
            unchecked=tuple(item.attrib["link"] for item in root.findall("disable_default_collisions")),
            groups={item.attrib["name"]: item for item in root.findall("group")},
            states=tuple(_state(item, other) for item in root.findall("group_state")),
            passive=frozenset(_names(root, "passive_joint") + _names(root, "group/passive_joint")),
            effectors=frozenset(item.get("group", "") for item in root.findall("end_effector")),
            world_frame="" if virtual is None else virtual.get("parent_frame", ""),
            moves="fixed" if virtual is None else virtual.get("type", "fixed"),
            virtual=_planar_joint(virtual),
            other=tuple(dict.fromkeys(other)),
        )
    except KeyError as error:
        raise RobotError(f"SRDF {path} has an element without attribute {error}; add it.") from None


def _planar_joint(joint: ET.Element | None) -> VirtualJoint | None:
    if joint is None or joint.get("type") != "planar":
        return None
    return VirtualJoint(joint.attrib["name"], joint.get("parent_frame", ""), joint.attrib["child_link"])


def _pairs(root: ET.Element, kind: str) -> frozenset[frozenset[str]]:
    return frozenset(frozenset((pair.attrib["link1"], pair.attrib["link2"])) for pair in root.findall(kind))


def _names(element: ET.Element, kind: str) -> list[str]:
    return [item.get("name", "") for item in element.findall(kind)]


def _state(element: ET.Element, other: list[str]) -> GroupState:
    """Return a state; joints with several values go to ``other``."""
    name, values = element.attrib["name"], dict[str, float]()
    for item in element.findall("joint"):
        joint = item.attrib["name"]
        numbers = item.attrib["value"].split()
        if len(numbers) == 1:
            values[joint] = urdf.read_number(item, "value")
        elif len(numbers) == 3:
            for part, number in zip(part_names(joint), numbers, strict=True):
                values[part] = urdf.read_number(ET.Element("joint", value=number), "value")
        else:
            other.append(f"several values of joint {quote(joint)} in state {quote(name)}")
    return GroupState(name, values)


def group_joints(srdf: Srdf, name: str, description: urdf.Description, model: pin.Model) -> list[str]:
    """Return the joints that a group moves, base first, without fixed, passive and mimic joints.

    Raises :class:`RobotError` for an unknown group, unknown links, or a group that moves nothing.
    """
    members = set(_joints_of(srdf, name, description)) - srdf.passive - {item.joint for item in description.mimics}
    joints = [joint for joint in model.names[1:] if joint in members]
    if not joints:
        raise RobotError(f"group '{name}' of SRDF {srdf.path} moves no joint of this robot: choose another --group.")
    return joints


def group_tips(srdf: Srdf, name: str, description: urdf.Description, joints: Sequence[str]) -> tuple[str, ...]:
    """Return the last links of a group, one for each arm.

    Those of the groups that it consists of, without end effectors and without links that carry another one: a torso is
    no arm. Else the tip of its only chain, or the child of its last joint.
    """
    group, parents = srdf.groups[name], {child: up for up, child in description.joints.values()}
    tips, inner = [chain.get("tip_link", "") for chain in group.findall("chain")], list[str]()
    for each in _names(group, "group"):
        movers = [joint for joint in joints if joint in {*_joints_of(srdf, each, description)}]
        if movers and each not in srdf.effectors:
            inner += group_tips(srdf, each, description, movers)
    if not inner:
        return (tips[0] if len(tips) == 1 else description.joints[joints[-1]][1],)
    carriers = set[str]()
    for link in (above := [parents.get(tip, "") for tip in (*tips, *inner)]):
        carriers.add(link)
        above += [parents[link]] if link in parents else []
    return tuple(tip for tip in dict.fromkeys((*tips, *inner)) if tip not in carriers)


def states_of_joints(srdf: Srdf, joints: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """Return the states that define all of ``joints``, of one group or of several with equal names.

    A group that defines them all wins over several, and the smaller one of two.
    """
    states = sorted(srdf.states, key=lambda state: -len(state.values))
    several = dict[str, dict[str, float]]()
    for state in states:
        several[state.name] = {**several.get(state.name, {}), **state.values}
    given = [*several.items(), *((state.name, state.values) for state in states)]
    return {name: tuple(values[joint] for joint in joints) for name, values in given if {*joints} <= values.keys()}


def _joints_of(srdf: Srdf, name: str, description: urdf.Description, outer: tuple[str, ...] = ()) -> Iterator[str]:
    """Yield the joints, also fixed ones, that a group and its subgroups name directly, by links or chains."""
    where = f"group '{name}' of SRDF {srdf.path}"
    if name not in srdf.groups:
        raise RobotError(f"group '{name}' not found in SRDF {srdf.path}; groups are {choices(srdf.groups)}.")
    if name in outer:
        raise RobotError(f"{where} contains itself: mend the file.")
    group, above = srdf.groups[name], {child: (joint, up) for joint, (up, child) in description.joints.items()}
    chains = [(item.get("base_link", ""), item.get("tip_link", "")) for item in group.findall("chain")]
    joints, links = list[str](), _names(group, "link")
    for joint in _names(group, "joint"):
        parts = part_names(joint)
        joints += parts if {*parts} <= description.joints.keys() else [joint]
        if joint not in description.joints and srdf.virtual and joint == srdf.virtual.name == joints[-1]:
            raise RobotError(f"{where} moves the base by '{joint}', which has no limits: give {REMEDY}.")
    unknown = [each for each in joints if each not in description.joints]
    if unknown := unknown + [each for each in (*links, *sum(chains, ())) if each not in description.links]:
        raise RobotError(f"{where} names {quote(unknown[0])}, which the URDF lacks: mend one of the two.")
    yield from joints
    yield from (above[link][0] for link in links if link in above)
    for base, tip in chains:
        link = tip
        while link != base:
            if link not in above:
                raise RobotError(f"{where} has a chain from {base} to {tip}, but no joints lead there: mend it.")
            joint, link = above[link]
            yield joint
    for inner in _names(group, "group"):
        yield from _joints_of(srdf, inner, description, (*outer, name))
