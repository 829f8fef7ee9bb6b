"""Reasons why chunks are not safe, and counts of them."""

from __future__ import annotations

import threading
from dataclasses import asdict, dataclass
from typing import Any, Literal

Kind = Literal["contact", "undecided", "reach", "limit", "floor", "constraint", "start"]
Where = Literal["start", "motion", "stop"]
Outcome = Literal["safe", "cut", "refused"]
WHERE: tuple[Where, ...] = ("start", "motion", "stop")  # as Place in gate.hpp

_HOW: dict[Kind, str] = {
    "contact": "'{0}' and '{1}' touch, or are closer than the margin",
    "undecided": "'{0}' and '{1}' are too close to prove that they do not touch",
    "reach": "'{1}' can reach '{0}' by that time within its speed limit",
    "limit": "joint '{joint}' is beyond its limit on {limit}",
    "floor": "manipulability is not proven above the floor",
    "constraint": "constraint '{constraint}' is not proven",
    "start": "joint '{joint}' has another position or velocity than the first point, which is at 0 s",
}
_ON: dict[Where, str] = {
    "motion": "on the motion",
    "stop": "on the way to rest from there",
    "start": "between the robot's state and the first point",
}


@dataclass(frozen=True, slots=True)
class Violation:
    """Why a chunk is not safe, as data.

    ``kind``: "contact", "undecided" (neither proven nor refuted), "reach" (of an obstacle with a speed limit), "limit",
    "floor", "constraint", or "start" (the first point differs from the state). ``on``: "motion", "stop" or "start".
    ``pair``: the two bodies, None if joints move too far for a proof. ``limit`` (position, velocity, acceleration or
    jerk) and ``joint``: the exceeded limit. ``constraint``: the violated constraint.
    """

    kind: Kind
    on: Where
    pair: tuple[str, str] | None = None
    limit: str | None = None
    joint: str | None = None
    constraint: str | None = None

    def __str__(self) -> str:
        if self.kind == "undecided" and self.pair is None:
            return f"{_ON[self.on]} joints move too far between two points for a proof"
        what = {"limit": self.limit, "joint": self.joint, "constraint": self.constraint}
        return f"{_ON[self.on]} {_HOW[self.kind].format(*(self.pair or ()), **what)}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, with the sentence."""
        return {**asdict(self), "text": str(self)}


class Statistics:
    """Counts of a gate's verdicts and of their reasons; several threads may count.

        gate.statistics.to_dict()["verdicts"]  # {"safe": 96, "cut": 3, "refused": 1, "slowed": 2}

    "cut" are the unsafe chunks with a safe point, "refused" those without one. "slowed" of these are proven slower, as
    far as :attr:`planner.Verdict.slowed` was used.
    """

    def __init__(self) -> None:
        self._counting = threading.Lock()
        self._verdicts = dict.fromkeys(("safe", "cut", "refused", "slowed"), 0)
        self._reasons: dict[Violation, int] = {}

    def count(self, verdict: Outcome | Literal["slowed"], reason: Violation | None = None) -> None:
        """Count a verdict, and its reason."""
        with self._counting:
            self._verdicts[verdict] += 1
            if reason is not None:
                self._reasons[reason] = self._reasons.get(reason, 0) + 1

    def to_dict(self) -> dict[str, Any]:
        """Return ``verdicts``, and ``reasons`` with their ``count``, the most frequent first."""
        with self._counting:
            verdicts, reasons = dict(self._verdicts), sorted(self._reasons.items(), key=lambda item: -item[1])
        return {"verdicts": verdicts, "reasons": [{**reason.to_dict(), "count": n} for reason, n in reasons]}
