"""A cell: several robots in one scene, as one composite robot or one by one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen
from planner.base.errors import PlannerError, RobotError, StateError, choices
from planner.base.files import StrPath
from planner.base.yamlfile import Name, find_duplicates, parse_yaml, quote, read_text, suggest_name, validate
from planner.problem.targets import HOME, Joints, follow_names, parse_target
from planner.robot.composite import combine_robots
from planner.robot.files.robot_files import JointChoice
from planner.robot.robot import Robot
from planner.robot.scene import PlacementFile, Scene, SceneFile, scene_from_file
from planner.robot.shapes import Obstacle

_ONE_SPOT = 1e-3  # m: the bases of two robots differ by more


class MemberFile(PlacementFile):
    """A robot of a cell: its model, and its set-up as in a scene file."""

    robot: Name
    prefix: Name | None = None
    srdf: Name | None = None
    group: Name | None = None


class CellFile(SceneFile):
    """Content of a cell file: a scene file whose ``robots`` name their models."""

    robots: dict[Name, MemberFile] = pydantic.Field(min_length=1)  # pyright: ignore[reportIncompatibleVariableOverride]


@dataclass(frozen=True, eq=False)
class Cell:
    """Robots by name in one scene; names of joints and links get a prefix, by default the name and ``_``.

        cell = planner.Cell.load("cell.yaml")
        planner.plan(cell=cell, start="here", goal="there")
        Cell("table", {"left": left, "right": right}, scene)

    ``scene`` holds obstacles, payloads on links with prefix, permissions, and named states by robot. ``robot`` is the
    composite: its joints are those of all robots in order. A state that all robots have is a state of the composite.
    Raises :class:`RobotError` for two robots on one spot and for prefixes that clash.
    """

    name: str
    robots: Mapping[str, Robot]
    scene: Scene = Scene()  # noqa: RUF009 (frozen)
    prefixes: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.robots:
            raise RobotError(f"cell '{self.name}' must have a robot or more, got none: name them under 'robots'.")
        robots = {name: replace(robot, name=name) for name, robot in self.robots.items()}
        object.__setattr__(self, "robots", robots)
        object.__setattr__(self, "prefixes", {name: self.prefixes.get(name, f"{name}_") for name in robots})
        if twice := find_duplicates(self.prefixes.values()):
            both = choices(name for name, prefix in self.prefixes.items() if prefix == twice[0])
            raise RobotError(f"prefixes must differ, got {quote(twice[0])} for {both}: give each robot its own.")
        for (one, first), (two, second) in combinations(robots.items(), 2):
            if np.linalg.norm(first.base[:3, 3] - second.base[:3, 3]) < _ONE_SPOT:
                at = ", ".join(f"{value:g}" for value in first.base[:3, 3])
                raise RobotError(
                    f"robots '{one}' and '{two}' must stand apart, got both at ({at}): give each its base."
                )

    def __repr__(self) -> str:
        return f"<Cell: {self.name}, {', '.join(self.robots)}, {self.scene}>"

    @staticmethod
    def load(path: StrPath) -> Cell:
        """Load a cell file; :class:`PlannerError` if it cannot be used."""
        path = Path(path)
        where = f"cell file {path}"
        file = validate(CellFile, parse_yaml(read_text(path, "cell file"), where), where, RobotError)
        if unknown := sorted({*file.states} - {*file.robots}):
            known = choices(file.robots)
            raise RobotError(f"{where}: states of {quote(unknown[0])} belong to no robot: robots are {known}.")
        robots = {name: _load_robot(name, member, path) for name, member in file.robots.items()}
        prefixes = {name: member.prefix for name, member in file.robots.items() if member.prefix is not None}
        return Cell(file.name or path.stem, robots, scene_from_file(file, path), prefixes)

    @cached_property
    def robot(self) -> Robot:
        """The composite robot, without payload, which is in ``scene``."""
        whole = combine_robots(self.name, {self.prefixes[name]: robot for name, robot in self.robots.items()})
        named = [self._states_of(name) for name in self.robots]
        common = {
            state: sum((own[state] for own in named), ()) for state in named[0] if all(state in own for own in named)
        }
        return replace(whole, states=common)

    @cached_property
    def columns(self) -> dict[str, slice]:
        """The columns of each robot in a configuration of the composite."""
        ends = np.cumsum([0, *(robot.dof for robot in self.robots.values())]).tolist()
        return {name: slice(*ends[k : k + 2]) for k, name in enumerate(self.robots)}

    def start_of(self, name: str) -> Floats:
        """Return the joint values (dof,) of a robot's state ``start``, or else of its home."""
        states = self._states_of(name)
        return frozen(states.get("start", states[HOME]))

    def owner(self, name: str) -> str | None:
        """Return the robot that has a joint, link or payload of the composite; None for an obstacle's name."""
        for item in self.scene.carried:
            name = item.link if name in (item.name, item.object) else name
        fits = [robot for robot, own in self._names.items() if name in own]
        return fits[0] if fits else None

    def scene_of(self, name: str) -> Scene:
        """Return the scene of one robot: the obstacles, its payload, and what the others never move.

        Names of its links have no prefix.
        """
        prefix = self.prefixes[name]

        def own(link: str) -> str:
            return link.removeprefix(prefix) if link in self._names[name] else link

        still = [
            Obstacle(self.prefixes[other] + body.name, body.shape, body.placement, self.prefixes[other] + body.link)
            for other, robot in self.robots.items()
            for body in (robot.bodies if other != name else ())
            if body.joint == 0
        ]
        carried = [item for item in self.scene.carried if self.owner(item.name) == name]
        return replace(
            self.scene,
            obstacles=(*self.scene.obstacles, *still),
            carried=tuple(
                replace(item, link=own(item.link), touch_links=tuple(map(own, item.touch_links))) for item in carried
            ),
            allowed=frozenset(frozenset(map(own, pair)) for pair in self.scene.allowed),
        )

    def require_robot(self, name: str) -> str:
        """Return the name of a robot of the cell; :class:`StateError` for another."""
        if name not in self.robots:
            known = choices(self.robots)
            raise StateError(f"robot {quote(name)} not found{suggest_name(name, self.robots)}: robots are {known}.")
        return name

    @cached_property
    def _names(self) -> dict[str, set[str]]:
        """The names of joints, frames and bodies of each robot, with prefix."""
        return {
            name: {
                self.prefixes[name] + each
                for each in (*robot.model.names, *(item.name for item in (*robot.model.frames, *robot.bodies)))
            }
            for name, robot in self.robots.items()
        }

    def _states_of(self, name: str) -> dict[str, tuple[float, ...]]:
        """Return the named states of a robot that are joint values."""
        robot, texts = self.robots[name], self.scene.states_of(name)
        values = {HOME: tuple(robot.home.tolist()), **robot.states}
        for state in texts:
            end = follow_names(state, texts)
            target = parse_target(end[0]) if len(end) == 1 and end[0] not in values else None
            known = target.values if isinstance(target, Joints) else values.get(end[0], ())
            if len(known) == robot.dof:
                values[state] = tuple(known)
        return values


def _load_robot(name: str, member: MemberFile, path: Path) -> Robot:
    """Return a robot of the cell file at ``path``; files next to it come before built-in names."""

    def near(file: str) -> str:
        return str(path.parent / file) if (path.parent / file).is_file() else file

    try:
        return Robot.load(
            near(member.robot),
            member.tool,
            member.fixed_joints,
            frozen(member.base.matrix()),
            JointChoice(member.group),
            near(member.srdf) if member.srdf else None,
        )
    except PlannerError as error:
        raise type(error)(f"robot '{name}' of cell file {path}: {error}", error.reason) from None
