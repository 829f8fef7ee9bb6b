"""The messages of a client: JSON ``{"id": ..., "method": ..., "params": {...}, "timeout": s}``.

A request ends with one answer, ``{"id", "result"}`` or ``{"id", "error": {"kind", "message"}}``; events
``{"id", "event": "progress", ...}`` may come before it. Units are m, rad and s.
"""

import functools
import operator
from typing import Annotated, Any, Literal, TypeAlias

import pydantic

from planner.base.errors import OptionError, choices
from planner.base.yamlfile import Coordinate, Name, Number, Strict, Whole, validate
from planner.problem.request import LimitsRequest
from planner.robot.scene import ObstacleFile, PoseFile
from planner.session.guard import JUDGED

Id: TypeAlias = str | Annotated[int, pydantic.Field(strict=True, ge=-(1 << 63), lt=1 << 63)]
Joints: TypeAlias = list[Coordinate]
Rows: TypeAlias = list[list[Number]]
State: TypeAlias = str | Joints


class Load(Strict):
    """Load a robot in a scene, by names or files of the server, in place of the world of this connection."""

    robot: Name = "iiwa14"
    scene: Name = "paper"
    margin: Number = 0.0
    tool: Name | None = None
    constraint: tuple[Name, ...] = ()
    limits: LimitsRequest = LimitsRequest()
    judged: tuple[Literal["position", "velocity", "acceleration", "jerk"], ...] = JUDGED
    min_manipulability: Number = 0.0
    nodes: Whole = 1012
    seed: Whole = 0


class Plan(Strict):
    """Plan a path from start to goal, given as text or joint values; ``motion``: a motion in time too."""

    start: Any = "start"
    goal: Any = "goal"
    beta: Number | None = None
    motion: bool = True


class Replan(Strict):
    """Answer the last question again, in the world as it is now."""

    motion: bool = True


class Cancel(Strict):
    """End the work on another request of this connection, which is answered with an error."""

    id: Id


class Now(Strict):
    """Where the robot is."""

    q: list[Number]
    qd: list[Number]
    qdd: list[Number] | None = None


class Check(Strict):
    """Check a chunk of joint targets, see :class:`planner.Gate`; ``want`` adds results that take longer.

    ``at`` (s from now) adds the positions of the proven motion at these times: chunk, stop, rest. With "slower" wanted
    they are those of the same path in more time, where it is proven; "slowed" is its motion.
    """

    positions: Rows
    velocities: Rows | None = None
    accelerations: Rows | None = None
    times: list[Number]
    state: Now | None = None
    stop: bool = True
    want: tuple[Literal["stop", "clearance", "slower", "slowed"], ...] = ()
    at: tuple[Number, ...] = ()


class Move(PoseFile):
    """Put an obstacle to another pose, which is given whole."""

    do: Literal["move"]
    name: Name


class Add(Strict):
    """Put an obstacle into the world, as a scene file has it."""

    do: Literal["add"]
    obstacle: ObstacleFile


class Remove(Strict):
    """Take an obstacle out of the world."""

    do: Literal["remove"]
    name: Name


class Attach(Strict):
    """Let a frame carry an obstacle, as it stands to it in the configuration ``at``."""

    do: Literal["attach"]
    name: Name
    frame: Name
    at: Joints
    touch_links: tuple[Name, ...] = ()


class Detach(Strict):
    """Put down what is carried, where the arm holds it in the configuration ``at``."""

    do: Literal["detach"]
    name: Name
    at: Joints


class See(PoseFile):
    """Replace the points that a sensor showed by those at its pose; the arm stood ``at`` a configuration."""

    do: Literal["see"]
    name: Name
    points: Rows
    radius: Number | None = None
    noise: Number = 0.0
    calibration: Number = 0.0
    at: Joints | None = None
    margin: Number = 0.02


class Allow(Strict):
    """Let a link or a carried object touch an obstacle, for so many ``seconds`` or inside a ``box``."""

    do: Literal["allow"]
    link: Name
    object: Name
    seconds: Number | None = None
    box: tuple[Number, Number, Number, Number, Number, Number] | None = None


class Forbid(Strict):
    """End the permission of a pair to touch."""

    do: Literal["forbid"]
    link: Name
    object: Name


class Statistics(Strict):
    """Count the verdicts on this connection's checks in its world, and their reasons."""


class Change(Strict):
    """Change the world of gate and planner, step by step; a wrong step changes nothing."""

    changes: list[
        Annotated[Move | Add | Remove | Attach | Detach | See | Allow | Forbid, pydantic.Field(discriminator="do")]
    ]


class Request(Strict):
    """A message of a client. Work ends when ``timeout`` s are over."""

    id: Id
    method: Name
    params: Any = pydantic.Field(default_factory=dict)
    timeout: Annotated[Number, pydantic.Field(gt=0, le=3600)] | None = None


MESSAGES: dict[str, type[Strict]] = {
    model.__name__.lower(): model for model in (Load, Plan, Replan, Cancel, Check, Change, Statistics)
}


def read_id(data: Any) -> str | int | None:
    """The id of a message that may be no request."""
    name = data.get("id") if isinstance(data, dict) else None
    return name if isinstance(name, str) or (isinstance(name, int) and abs(name) < 1 << 63) else None


def read_request(data: Any) -> Request:
    """The request with the message of its method as ``params``; :class:`OptionError` for anything else."""
    request = validate(Request, data, "the request", OptionError)
    message = MESSAGES.get(request.method)
    if message is None:
        raise OptionError(f"method '{request.method[:100]}' not found; methods are {choices(MESSAGES)}.")
    params = validate(message, request.params, f"params of '{request.method}'", OptionError)
    return request.model_copy(update={"params": params})


def schema() -> dict[str, Any]:
    """The JSON schema of all that a client may send: one alternative a method."""
    create: Any = pydantic.create_model
    alternatives = [
        create(f"{name.title()}Request", __base__=Request, __doc__=model.__doc__, method=Literal[name], params=model)
        for name, model in MESSAGES.items()
    ]
    return pydantic.TypeAdapter(functools.reduce(operator.or_, alternatives)).json_schema()
