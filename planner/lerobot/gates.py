"""A gate in this process, or behind ``planner serve``, as the filter of actions uses it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from planner.base.arrays import Floats
from planner.serve.client import Client

if TYPE_CHECKING:
    from planner.session.gate import Gate

Start = tuple[Floats, Floats]
"""Position and velocity (dof,) in which the motion starts."""


class Answer(NamedTuple):
    """The verdict on a chunk.

    ``positions`` (n, dof) are those of the proven motion at the times asked for, None if no stop is proven.
    ``time_scale`` is its duration as a multiple of the chunk's; ``reason`` is None for a safe chunk.
    """

    safe: bool
    safe_until: float
    reason: str | None
    notes: tuple[str, ...]
    positions: Floats | None
    time_scale: float


class LocalGate:
    """A :class:`planner.Gate` of this process, with its ``joints`` and limits ``lower``, ``upper`` (dof,)."""

    def __init__(self, gate: Gate) -> None:
        self._gate = gate
        self.joints: tuple[str, ...] = gate.robot.joints
        self.lower, self.upper = gate.robot.lower, gate.robot.upper

    def judge(self, targets: Floats, times: Floats, start: Start, at: Floats, slow: bool) -> Answer:
        """Return the verdict on targets (k, dof) at ``times`` (k,) s, and the proven motion ``at`` (n,) s.

        That motion is the chunk, then a stop, then rest; with ``slow`` the slower chunk, where it is proven.
        """
        verdict = self._gate.check(targets, times=times, state=start)
        reason = None if verdict.reason is None else str(verdict.reason)
        motion = (verdict.slower if slow else None) or verdict
        positions = None if motion.stop is None else motion.positions_at(at)
        scale = 1.0 if motion is verdict else verdict.time_scale or 1.0
        return Answer(verdict.safe, verdict.safe_until, reason, verdict.notes, positions, scale)

    def is_free(self, targets: Floats, times: Floats, start: Start) -> bool:
        """Return whether the lines through targets (k, dof) are proven free and within limits, without stops."""
        return self._gate.check(targets, times=times, state=start, stop=False).safe


class ServedGate:
    """A gate behind ``planner serve``, with a world of its own; needs numpy and websockets only.

        gate = ServedGate("ws://127.0.0.1:8765/", token, robot="so101", scene="table.yaml", margin=0.01)
        gate.client.ask("change", changes=[{"do": "remove", "name": "carton"}])

    ``world`` are further params of the method ``load``; an answer must come within ``timeout`` s.
    """

    def __init__(self, address: str, token: str, timeout: float = 1.0, **world: Any) -> None:
        self.client = Client(address, token, timeout)
        loaded = self.client.ask("load", patience=600.0, **world)
        self.joints: tuple[str, ...] = tuple(loaded["joints"])
        self.lower, self.upper = (
            np.array([end if each is None else each for each in loaded[name]], dtype=np.float64)  # of continuous joints
            for name, end in (("lower", -np.inf), ("upper", np.inf))
        )

    def judge(self, targets: Floats, times: Floats, start: Start, at: Floats, slow: bool) -> Answer:
        """See :class:`LocalGate`."""
        found = self._check(targets, times, start, at=at.tolist(), want=["slower"] * slow)
        reason, positions = found["reason"], found["positions"]
        rows = None if positions is None else np.array(positions, dtype=np.float64)
        text = None if reason is None else reason["text"]
        return Answer(
            found["safe"], found["safe_until"], text, tuple(found["notes"]), rows, found.get("time_scale", 1.0)
        )

    def is_free(self, targets: Floats, times: Floats, start: Start) -> bool:
        """See :class:`LocalGate`."""
        return self._check(targets, times, start, stop=False)["safe"]

    def _check(self, targets: Floats, times: Floats, start: Start, **more: Any) -> dict[str, Any]:
        state = {"q": start[0].tolist(), "qd": start[1].tolist()}
        return self.client.ask("check", positions=targets.tolist(), times=times.tolist(), state=state, **more)
