"""The logic of the processor steps, on plain arrays.

An observation gives the robot's state, and the actions after it are judged as one chunk of lines: row k of them is the
target at k / fps s after the observation. A safe chunk passes to the last bit. Otherwise rows of the proven motion
replace it, and the lines between these rows are proven again, because a stop is a curve.
"""

from __future__ import annotations

import logging
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from planner.base.arrays import Floats, Ints, numbers, plain_numbers
from planner.base.errors import ArrayError, OptionError, PlannerError, StateError, choices
from planner.lerobot.gates import LocalGate, ServedGate, Start
from planner.lerobot.joint_map import JointMap

if TYPE_CHECKING:
    from planner.session.gate import Gate

_log = logging.getLogger(__name__)

Outcome = Literal["safe", "slowed", "cut", "held"]
UNSAFE, REST = ("slow", "stop"), ("drop", "retime")
_SLOWEST = 8.0  # times the duration of a chunk, as the gate's ladder of time scales has it
_OLD = 0.5  # s: observations further apart give no velocity

DIFFERENCES = "the velocity is the difference of two observations"
FIRST = "no other observation in the last 0.5 s: the velocity is taken as 0"
COMMAND = "the motion starts at the last command, from which the observation differs by at most 'tracking'"
BEYOND = "the observation is beyond joint limits by at most 'state_tolerance': the motion starts at the limits"
CURVED = "the lines between these rows are not proven"
LAST = "the stop that was proven last goes on"


@dataclass(frozen=True, eq=False)
class Filtered:
    """``actions`` to send, in the shape and units in which they came, and the verdict.

    ``outcome``: "safe" (unchanged), "slowed" (the same path in more time), "cut" (until ``safe_until`` s, then a stop)
    or "held" (no stop is proven: the start is repeated). ``proven``: whether the lines through all rows are proven.
    """

    actions: Floats
    outcome: Outcome
    safe_until: float
    reason: str | None
    proven: bool
    notes: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the verdict as plain data, without the actions."""
        return {name: value for name, value in asdict(self).items() if name != "actions"}


class ActionFilter:
    """Passes safe actions on, and replaces others by a proven motion.

        actions = ActionFilter(gate, ["shoulder_pan.pos", ..., "gripper.pos"], fps=30)
        actions.observe(state)               # (a,) or (1, a): observation.state
        actions.judge(chunk).actions         # (1, T, a), or (1, a) for one action

    ``gate`` is a :class:`planner.Gate` or a :class:`ServedGate`. ``unsafe`` "slow" prefers the same path in more time
    to the stop; ``rest`` "drop" then keeps the number of rows, "retime" returns all rows of the slower motion. A single
    action starts at the last command if the observation is within ``tracking`` rad of it, so that the error of a servo
    does not add up. Joints beyond a limit by ``state_tolerance`` rad count as at the limit. ``units``, ``spans`` and
    ``renamed``: see :meth:`JointMap.from_limits`. ``clock`` gives s. ``counts`` and ``reasons`` count verdicts.
    """

    def __init__(
        self,
        gate: Gate | LocalGate | ServedGate,
        names: Sequence[str],
        *,
        fps: float = 30.0,
        unsafe: str = "slow",
        rest: str = "drop",
        units: str = "degrees",
        spans: Mapping[str, tuple[float, float]] | None = None,
        renamed: Mapping[str, str] | None = None,
        tracking: float = 0.1,
        state_tolerance: float = 0.02,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        for name, value, known in (("unsafe", unsafe, UNSAFE), ("rest", rest, REST)):
            if value not in known:
                raise OptionError(f"{name} must be one of {choices(known)}, got {value!r}.")
        least = {"fps": (fps, 0.1), "tracking": (tracking, 0.0), "state_tolerance": (state_tolerance, 0.0)}
        for name, (size, bound) in least.items():
            if not bound <= size < np.inf:
                raise OptionError(f"{name} must be at least {bound:g} and finite, got {size:g}.")
        self._gate = gate if isinstance(gate, LocalGate | ServedGate) else LocalGate(gate)
        limits = self._gate.joints, self._gate.lower, self._gate.upper
        self.joint_map = JointMap.from_limits(names, *limits, units, spans, renamed)
        self._fps, self._slow, self._retime = float(fps), unsafe == "slow", rest == "retime"
        self._tracking, self._tolerance, self._clock = tracking, state_tolerance, clock
        self.counts: Counter[Outcome] = Counter()
        self.reasons: Counter[str] = Counter()
        self._last: tuple[Outcome, str | None] = ("safe", None)
        self._forget()

    def reset(self) -> None:
        """Forget the observations of an episode, and log all counts."""
        if self.counts:
            _log.info("actions so far: %s; reasons: %s", dict(self.counts), dict(self.reasons.most_common(5)))
        self._forget()

    def observe(self, state: Any) -> None:
        """Remember ``observation.state`` (a,) or (1, a), in the units of the actions."""
        what = "observation.state"
        row = numbers(what, np.reshape(plain_numbers(what, state), -1), (len(self.joint_map.names),))
        q, now, before = self.joint_map.to_joints(row[None])[0], self._clock(), self._seen
        self._seen, self._velocity, self._notes = (now, q), np.zeros_like(q), (FIRST,)
        if before is not None and 0.0 < now - before[0] <= _OLD:
            self._velocity, self._notes = (q - before[1]) / (now - before[0]), (DIFFERENCES,)
        start, sent = self._start, self._sent
        self._start, self._sent = None, np.zeros((0, len(q)))
        if start is None or len(sent) != 1:  # of several rows the one under way is not known
            return
        usable = (self._gate.lower <= sent[0]) & (sent[0] <= self._gate.upper) & (np.abs(sent[0] - q) <= self._tracking)
        if usable.all():
            self._start, self._notes = (sent[0], (sent[0] - start[0]) * self._fps), (COMMAND,)

    def judge(self, actions: Any) -> Filtered:
        """Return actions (1, T, a) or (1, a) to send; those since the last observation continue each other.

        Raises :class:`ArrayError` for another shape and for more than one robot, :class:`StateError` without an
        observation. Everything else, as NaN or a gate that does not answer, holds the robot.
        """
        given, width = plain_numbers("actions", actions), len(self.joint_map.names)
        if given.ndim not in (2, 3) or given.shape[-1] != width or not given.size:
            raise ArrayError(f"actions must have shape (1, T, {width}) or (1, {width}), got {given.shape}.")
        if len(given) > 1:
            raise ArrayError(f"actions must be those of one robot, got {len(given)}: give each robot its own filter.")
        if self._seen is None:
            raise StateError("observation.state must come before actions, got none: put GateState before the policy.")
        rows, notes = given.reshape(-1, width), self._notes
        try:
            self._start, clipped = self._find_start(self._seen[1])
            notes += clipped
            targets = self.joint_map.to_joints(numbers("actions", rows, rows.shape))
            found, taken = self._decide(targets, self._start, given.ndim == 3)
        except PlannerError as error:
            self._start = self._start or (self._seen[1], self._velocity)
            found, taken = self._hold(len(rows), self._start[0], str(error))
        self._sent = np.vstack([self._sent, found.actions])
        self._count(found)
        values = given if found.outcome == "safe" else self.joint_map.replace(rows[taken], found.actions)
        shape = given.shape if given.ndim == 2 else (1, -1, width)
        return replace(found, actions=values.reshape(shape), notes=(*notes, *found.notes))

    def _forget(self) -> None:
        self._seen: tuple[float, Floats] | None = None
        self._start: Start | None = None
        self._velocity, self._notes = np.zeros(len(self._gate.joints)), (FIRST,)
        self._sent = self._backup = np.zeros((0, len(self._gate.joints)))

    def _find_start(self, q: Floats) -> tuple[Start, tuple[str, ...]]:
        """Return the state in which the motion since the observation starts, with a note on clipped joints."""
        if self._start is not None:
            return self._start, ()
        self._backup, lower, upper = self._backup[:0], self._gate.lower, self._gate.upper
        inside = np.clip(q, lower, upper)
        off = np.abs(q - inside)
        if off.max() > self._tolerance:
            j = int(off.argmax())
            raise StateError(
                f"state of joint '{self._gate.joints[j]}' must be in [{lower[j]:g}, {upper[j]:g}], got {q[j]:.4g} rad: "
                "check units and calibration, or move the joint back by hand."
            )
        return (inside, self._velocity), (BEYOND,) if off.any() else ()

    def _decide(self, targets: Floats, start: Start, growing: bool) -> tuple[Filtered, Ints]:
        """Return the motion for targets (k, dof) after the rows that were sent, as positions (n, dof), rad.

        With it comes, for each row, the target (n,) whose other columns it takes. Only a ``growing`` chunk may have
        more rows than targets.
        """
        done, count = len(self._sent), len(targets)
        slow = self._slow and not done  # rows that were sent cannot be slowed
        retime = self._retime and growing
        more = int(count * _SLOWEST if slow and retime else self._fps)  # 1 s of a stop that may have to go on
        chunk, times = np.vstack([self._sent, targets]), np.arange(1, done + count + more + 1) / self._fps
        answer = self._gate.judge(chunk, times[: len(chunk)], start, times, slow)
        ahead, kept, every = answer.positions, count, np.arange(count)
        if ahead is None and not answer.safe:
            return self._hold(count, self._sent[-1] if done else start[0], f"{answer.reason}; no stop is proven")
        if ahead is not None and answer.time_scale > 1.0:
            kept = int(np.ceil(count * answer.time_scale)) if retime else count
            if self._gate.is_free(ahead[:kept], times[:kept], start):  # corners of the path are cut between rows
                rows = (
                    np.minimum(np.ceil(np.arange(1, kept + 1) / answer.time_scale - 1e-9), count).astype(np.int64) - 1
                )
                return Filtered(ahead[:kept], "slowed", answer.safe_until, answer.reason, True, answer.notes), rows
            answer = self._gate.judge(chunk, times[: len(chunk)], start, times, False)
            ahead = answer.positions
            if ahead is None:
                return self._hold(count, start[0], f"{answer.reason}; no stop is proven")
        self._backup = ahead[done + 1 :] if ahead is not None and count == 1 else self._backup[:0]
        if answer.safe or ahead is None:
            return Filtered(targets, "safe", answer.safe_until, None, True, answer.notes), every
        lines = np.vstack([self._sent, ahead[done : done + count]])
        proven = self._gate.is_free(lines, times[: len(lines)], start)
        notes = answer.notes if proven else (*answer.notes, CURVED)
        return Filtered(lines[done:], "cut", answer.safe_until, answer.reason, proven, notes), every

    def _hold(self, count: int, q: Floats, reason: str) -> tuple[Filtered, Ints]:
        """Return the rest of the last proven stop of single actions, else ``q`` (dof,) repeated."""
        if count == 1 and len(self._backup):
            row, self._backup = self._backup[:1], self._backup[1:]
            return Filtered(row, "cut", 0.0, reason, False, (LAST,)), np.arange(1)
        return Filtered(np.tile(q, (count, 1)), "held", 0.0, reason, False), np.arange(count)

    def _count(self, found: Filtered) -> None:
        """Count, and log each change of outcome or reason once."""
        self.counts[found.outcome] += 1
        if found.reason is not None:
            self.reasons[found.reason] += 1
        if (found.outcome, found.reason) != self._last:
            self._last = found.outcome, found.reason
            _log.warning("actions are %s%s", found.outcome, f": {found.reason}" if found.reason else " again")
