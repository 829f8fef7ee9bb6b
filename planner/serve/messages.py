"""What a client may ask for, as checked data: ``{"id": ..., "method": ..., "params": {...}, "timeout": s}``.

Text frames are JSON, binary ones msgpack, and each is answered in kind. A request ends with one answer,
``{"id", "result"}`` or ``{"id", "error": {"kind", "message"}}``; before it may come
``{"id", "event": "progress", ...}``, and after a ``subscribe`` come ``{"id", "event": "world" | "field", ...}``.
Units are m, rad and s.
"""

from __future__ import annotations

import functools
import operator
from typing import Annotated, Any, Literal, TypeAlias

import pydantic

from planner.base.yamlfile import Coordinate, Name, Number, Strict, Whole
from planner.robot.scene import ObstacleFile, PoseFile

MAIN = "main"  # the world that is meant where none is named
_LONGEST = 3600.0  # s
LARGEST_ID = 1 << 63  # what every client's whole numbers hold
_Number = Annotated[int, pydantic.Field(strict=True, gt=-LARGEST_ID, lt=LARGEST_ID)]
Id: TypeAlias = Annotated[str, pydantic.Field(max_length=200)] | _Number
Joints: TypeAlias = Annotated[list[Coordinate], pydantic.Field(max_length=1000)]
Rows: TypeAlias = Annotated[list[list[Number]], pydantic.Field(max_length=100_000)]  # judged by the gate
State: TypeAlias = Annotated[str, pydantic.Field(max_length=100_000)] | Joints


class _OfWorld(Strict):
    world: Name = MAIN


class Limits(Strict):
    """What a gate judges and a motion keeps, in place of the robot's own; ``file``: a MoveIt joint_limits.yaml."""

    file: Name | None = None
    velocity_scale: Number | None = None
    acceleration_scale: Number | None = None
    acceleration: Number | None = None
    jerk: Number | None = None


class Load(_OfWorld):
    """A robot and a scene, by names or files of the server, as a world of that name; ``replace`` one that is there."""

    robot: Name = "iiwa14"
    scene: Name = "paper"
    replace: bool = False
    margin: Number = 0.0
    tool: Name | None = None
    keep: list[Name] | None = None
    limits: Limits = Limits()
    judged: list[Literal["position", "velocity", "acceleration", "jerk"]] | None = None
    min_manipulability: Number = 0.0
    nodes: Whole | None = None
    seed: Whole = 0
    beta: Annotated[Number, pydantic.Field(ge=0, le=1)] | None = None


class Plan(_OfWorld):
    """A path from start to goal, as the command line writes them or joint values; with ``motion`` in time too."""

    start: Any = "start"
    goal: Any = "goal"
    beta: Number | None = None
    motion: bool = True


class Replan(_OfWorld):
    """The last question once more, in the world as it is now."""

    motion: bool = True


class Cancel(Strict):
    """End the work on another request of this connection; that one is answered with an error."""

    id: Id


class Now(Strict):
    """Where the robot is."""

    q: list[Number]
    qd: list[Number]
    qdd: list[Number] | None = None


class Check(_OfWorld):
    """Is this chunk of joint targets proven safe? See :class:`planner.Gate`; ``want`` what takes longer to work out."""

    positions: Rows
    velocities: Rows | None = None
    accelerations: Rows | None = None
    times: list[Number]
    state: Now | None = None
    stop: bool = True
    want: tuple[Literal["stop", "clearance"], ...] = ()


class Move(PoseFile):
    """Put an obstacle to another pose: what is left out is 0."""

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


Changing: TypeAlias = Annotated[Move | Add | Remove | Attach | Detach, pydantic.Field(discriminator="do")]


class Change(_OfWorld):
    """Changes of a world, one after the other, each whole or refused; the gate knows them when the answer is there."""

    changes: Annotated[list[Changing], pydantic.Field(min_length=1, max_length=10_000)]


class Subscribe(_OfWorld):
    """Tell this connection of every change of the world, and of the field whenever a plan has settled it."""


class Unsubscribe(_OfWorld):
    """No more of it."""


class Worlds(Strict):
    """Which worlds there are."""


METHODS: dict[str, type[Strict]] = {
    "load": Load,
    "plan": Plan,
    "replan": Replan,
    "cancel": Cancel,
    "check": Check,
    "change": Change,
    "subscribe": Subscribe,
    "unsubscribe": Unsubscribe,
    "worlds": Worlds,
}


class Request(Strict):
    """Every message of a client; ``params`` are those of its method. Work ends when ``timeout`` s are over."""

    id: Id
    method: Name
    params: dict[str, Any] = pydantic.Field(default_factory=dict)
    timeout: Annotated[Number, pydantic.Field(gt=0, le=_LONGEST)] | None = None


def schema() -> dict[str, Any]:
    """The JSON schema of all that a client may send: one alternative a method."""
    create: Any = pydantic.create_model
    alternatives = [
        create(f"{name.title()}Request", __base__=Request, __doc__=model.__doc__, method=Literal[name], params=model)
        for name, model in METHODS.items()
    ]
    return pydantic.TypeAdapter(functools.reduce(operator.or_, alternatives)).json_schema()
