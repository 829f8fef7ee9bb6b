"""The world that a kept roadmap is held against: as its file says, but for what is asked for otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from os import PathLike
from typing import Any

import numpy as np
import pydantic

from planner.base.errors import FileError, OptionError
from planner.base.places import Place
from planner.base.resources import published_scene_names, robot_names, scene_names
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.models.robot import with_widened_limits
from planner.problem.request import KeptRequest, Thing, WorldRequest
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap, require_same_world
from planner.setup.open import open_world
from planner.setup.robots import files_of


def reopen(
    request: KeptRequest, roadmap: Roadmap, path: Place, remedy: str = "say where it is with --{}"
) -> CollisionChecker:
    """A checker of the robot and scene that ``request`` or else the file at ``path`` names.

    Raises :class:`FileError` with the ``remedy`` where the file names one that is not built in, and nobody says where
    it is.
    """
    origin, given = roadmap.origin, request.robot
    if given is not None and _name_of(given) != origin.robot:
        raise FileError(f"roadmap {path} is for robot '{origin.robot}', not '{given}': build one for this robot.")
    world = WorldRequest(
        robot=request.robot or _built_in("robot", origin.robot, robot_names(), path, remedy),
        scene=request.scene
        or _built_in("scene", origin.scene, [*scene_names(), *published_scene_names()], path, remedy),
        tool=request.tool or origin.tool,
        srdf=request.srdf,
        group=request.group,
        joints=request.joints,
        keep=request.keep,
        base=request.base,
        collision=request.collision,
        margin=origin.margin if request.margin is None else request.margin,
    )
    checker = open_world(world, request.motion_plan_request, lambda _: roadmap.nodes[roadmap.starts[0]])
    robot = checker.robot
    if request.widen_limits and robot.joints == origin.joints:
        wide = with_widened_limits(robot, np.array([origin.world.lower, origin.world.upper]))
        keep = checker.world.conditions
        checker = make_checker(wide, checker.world.scene, world.collision, world.margin, keep)
    return checker


def reopen_plan(config: Mapping[str, Any], path: Place) -> CollisionChecker:
    """A checker of the world that a plan was made in, by the ``config`` of its plan.json and its roadmap at ``path``.

    Raises :class:`PlannerError` where it cannot be opened, or is not to the bit what the roadmap was proven in.
    """
    names = {"request": "motion_plan_request"} | {field.name: field.name for field in fields(KeptRequest)}
    said = {names[key]: value for key, value in config.items() if key in names}
    try:
        request = pydantic.TypeAdapter(KeptRequest).validate_python(said)
    except (pydantic.ValidationError, OptionError):
        raise FileError(f"the options in the plan.json beside {path} are not what a plan writes: plan again.") from None
    roadmap = load_roadmap(path)
    checker = reopen(request, roadmap, path, "and its plan.json says no other place of it")
    require_same_world(roadmap, checker, path)
    return checker


def _name_of(robot: Thing) -> str:
    return files_of(str(robot), None).name if isinstance(robot, str | PathLike) else robot.name


def _built_in(what: str, name: str, names: Sequence[str], path: Place, remedy: str) -> str:
    if name not in names:
        raise FileError(f"roadmap {path} is for {what} '{name}', which is not built in: {remedy.format(what)}.")
    return name
