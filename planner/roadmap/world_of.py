"""The world that a plan was made in, opened again by its plan.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from planner.base.errors import FileError, OptionError
from planner.base.files import StrPath
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.problem.request import WorldRequest
from planner.query.query import open_world
from planner.roadmap.storage import load_roadmap, same_world
from planner.robot.robot import with_widened_limits


def world_in(config: Mapping[str, Any], where: str) -> WorldRequest:
    """The robot and the scene in the ``config`` of a plan.json; :class:`FileError` for options that are not valid."""
    names = {field.name for field in fields(WorldRequest)}  # type: ignore[arg-type]
    try:
        return WorldRequest(**{name: value for name, value in config.items() if name in names})
    except OptionError:
        raise FileError(f"the options in the plan.json {where} are not valid: plan again.") from None


def reopen_plan(config: Mapping[str, Any], path: StrPath) -> CollisionChecker:
    """A checker of the world that a plan was made in, by the ``config`` of its plan.json and its roadmap at ``path``.

    Raises :class:`PlannerError` where it cannot be opened, or differs from what the roadmap was proven in.
    """
    request = world_in(config, f"next to {path}")
    roadmap = load_roadmap(path)
    checker = open_world(request, config.get("request"), lambda _: roadmap.nodes[roadmap.starts[0]])
    robot, origin = checker.robot, roadmap.origin
    if config.get("widen_limits") and robot.joints == origin.joints:
        wide = with_widened_limits(robot, np.array([origin.lower, origin.upper]))
        world = checker.world
        checker = make_checker(wide, world.scene, request.collision, request.margin, world.conditions)
    if not same_world(roadmap, checker):
        raise FileError(f"roadmap {path} was proven for another robot or scene than its plan.json names: plan again.")
    return checker
