"""What the live page may ask for, as checked data."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import pydantic

from planner.base.yamlfile import Coordinate, Name, Number, Strict

Triple = tuple[Coordinate, Coordinate, Coordinate]


class _Placed(Strict):
    name: Name
    position: Triple
    quaternion: tuple[Coordinate, Coordinate, Coordinate, Coordinate]


class Look(_Placed):
    """Say whether the path would hold with an obstacle at a place, and change nothing: that takes a moment only."""

    do: Literal["look"]


class MoveObstacle(_Placed):
    """Put an obstacle to a place: metres, and a quaternion [x, y, z, w]."""

    do: Literal["move"]

    @property
    def what(self) -> str:
        return f"obstacle '{self.name}' moved"


class MoveGoal(Strict):
    """Put the goal to a tool position (m); of a goal that is a pose the orientation stays."""

    do: Literal["goal"]
    position: Triple
    what: ClassVar[str] = "goal moved"


class SetStart(Strict):
    """Start at joint values (rad; m where a joint slides)."""

    do: Literal["start"]
    joints: Annotated[list[Coordinate], pydantic.Field(max_length=1000)]
    what: ClassVar[str] = "start set"


class SetBeta(Strict):
    """Weigh distance by beta, manipulability by the rest."""

    do: Literal["beta"]
    beta: Annotated[Number, pydantic.Field(ge=0, le=1)]
    what: ClassVar[str] = "beta set"


class Undo(Strict):
    """Go back to before the last change."""

    do: Literal["undo"]


class Save(Strict):
    """Write the scene file."""

    do: Literal["save"]


class Reload(Strict):
    """Put the obstacles to where the scene file has them."""

    do: Literal["reload"]
    what: ClassVar[str] = "scene read again"


Change = MoveObstacle | MoveGoal | SetStart | SetBeta | Reload
Order = Annotated[Change | Look | Undo | Save, pydantic.Field(discriminator="do")]


class Request(Strict):
    order: Order
