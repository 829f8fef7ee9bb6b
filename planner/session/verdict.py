"""What the gate says of a chunk."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from planner.trajectory.trajectory import Trajectory

Kind = Literal["contact", "undecided", "reach", "limit", "floor", "kept", "start"]
Where = Literal["start", "motion", "stop"]
WHERE: tuple[Where, ...] = ("start", "motion", "stop")  # by the numbers that compiled code gives them

_HOW: dict[Kind, str] = {
    "contact": "'{0}' and '{1}' touch, or are closer than the margin",
    "undecided": "'{0}' and '{1}' are too near each other to prove that they keep apart",
    "reach": "'{1}' may be at '{0}' by then, for all that its speed limit says",
    "limit": "joint '{joint}' is beyond its limit on {limit}",
    "floor": "manipulability is not proven above the floor",
    "kept": "'{kept}' is not proven to be kept",
    "start": "joint '{joint}' is elsewhere, or moves otherwise, than the first point says, which is at 0 s",
}
_ON: dict[Where, str] = {
    "motion": "on the motion",
    "stop": "on the way to rest from there",
    "start": "between where the robot is and the first point",
}


@dataclass(frozen=True, slots=True)
class Unsafe:
    """Why a chunk is not safe, as data.

    ``kind``: "contact", "undecided" (neither proven nor refuted), "reach" (of an obstacle with a speed limit), "limit",
    "floor", "kept" (a condition on the motion), or "start" (not where, or as fast as, it begins). ``on``: "motion",
    "stop" or "start". ``pair``: the link and what it meets, None where joints go too far to prove anything; ``limit``
    and ``joint``: what is exceeded (position, velocity, acceleration, jerk); ``kept``: the condition.
    """

    kind: Kind
    on: Where
    pair: tuple[str, str] | None = None
    limit: str | None = None
    joint: str | None = None
    kept: str | None = None

    def __str__(self) -> str:
        if self.kind == "undecided" and self.pair is None:
            return f"{_ON[self.on]} joints go too far from one point to the next to prove anything"
        what = {"limit": self.limit, "joint": self.joint, "kept": self.kept}
        return f"{_ON[self.on]} {_HOW[self.kind].format(*(self.pair or ()), **what)}"

    def to_dict(self) -> dict[str, Any]:
        """As plain data, with the sentence."""
        return {**asdict(self), "text": str(self)}


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """Whether a chunk is ``safe``, and until when it is.

    ``safe_until`` (s from now): all pieces until this point of the chunk are proven, and a stop from every point until
    there; the time of the last point where it is safe, 0 where nothing is. ``reason`` says why not, at ``first_bad`` s:
    where on the first bad piece the proof stopped, or the point from which no stop is proven. A verdict is true where
    the chunk is safe. ``notes`` say what was not judged. ``revision`` is that of the world of the check: it grows with
    every change. ``stop`` and ``clearance`` are worked out when they are asked for, in that world.
    """

    safe: bool
    safe_until: float
    reason: Unsafe | None
    first_bad: float | None
    notes: tuple[str, ...]
    revision: int
    _judged: Any  # the judgement, which works out stop and clearance of its first pieces
    _pieces: int

    def __bool__(self) -> bool:
        return self.safe

    def __repr__(self) -> str:
        return f"<Verdict: {self}>"

    def __str__(self) -> str:
        if self.safe:
            return f"safe until {self.safe_until:g} s"
        return f"unsafe at {self.first_bad:g} s: {self.reason}; safe until {self.safe_until:g} s"

    def to_dict(self) -> dict[str, Any]:
        """As plain data, without what is worked out later; s."""
        found = {name: getattr(self, name) for name in ("safe", "safe_until", "first_bad", "revision")}
        return found | {"reason": self.reason and self.reason.to_dict(), "notes": list(self.notes)}

    @property
    def stop(self) -> Trajectory | None:
        """The proven motion to rest from ``safe_until`` on, its times from 0 there; never None of a safe chunk.

        It is None where nothing is safe and no stop is proven from where the robot is, of a robot that is too fast or
        too near already. Where no stops were asked for one is sought now, and may not be there.
        """
        return self._judged.stop(self._pieces)

    @property
    def clearance(self) -> float | None:
        """The smallest distance (m) along the safe part, to a tenth; None where nothing moves or can come near."""
        return self._judged.clearance(self._pieces)
