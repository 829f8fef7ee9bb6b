"""Motions of a controller: parts of different degrees, cut where their proof ends, and checked again."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.session.gate import Gate
from planner.session.verdict import Verdict
from planner.trajectory.stopping import stop_at
from planner.trajectory.trajectory import Trajectory, to_nanoseconds

_AT_REST = 1e-9  # rad/s
_SHORTEST = 100_000  # ns: the rest of a polynomial piece that is shorter has derivatives that are rounding errors


@dataclass(frozen=True, eq=False)
class Motion:
    """Trajectories one behind the other, with times from 0, that end at rest.

    ``from_state``: the first point is the robot's state. ``proven`` says whether every part is proven.
    """

    parts: tuple[Trajectory, ...]
    from_state: bool
    proven: bool = True

    def points(self) -> Iterator[tuple[int, list[Floats]]]:
        """Yield nanoseconds and columns (dof,) of every point of a message.

        Between two points the controller uses the columns that both have. So a point between two parts has those of the
        part with more, and the state of the robot, which the controller knows, is left out.
        """
        rows: dict[int, list[Floats]] = {}
        for part in self.parts:
            for k, clock in enumerate(part.nanoseconds.tolist()):
                columns = [column[k] for column in part.columns]
                rows[clock] = max(rows.get(clock, []), columns, key=len)
        if self.from_state:
            del rows[0]
        yield from rows.items()

    def rest(self, t: float) -> Iterator[tuple[float, Trajectory, list[Floats]]]:
        """Yield what follows ``t`` s: the time of its start, the part, and positions and derivatives there."""
        clock = round(t * 1e9)
        for part in self.parts:
            later = part.nanoseconds[part.nanoseconds > clock]
            if len(later) > 1 and later[0] - clock < _SHORTEST:
                clock = int(later[0])
            if len(later) and (begin := max(clock, int(part.nanoseconds[0]))) < part.nanoseconds[-1]:
                orders = range(max(2, len(part.columns)))
                yield begin / 1e9, part, [part.at_nanoseconds(np.array([begin]), order)[0] for order in orders]


def make_motion(
    joints: tuple[str, ...],
    columns: Sequence[Floats],
    times: Floats,
    state: Sequence[Floats],
    verdict: Verdict,
    slow: bool = False,
) -> Motion | None:
    """Return the proven part of a chunk (k, dof) at ``times`` (k,) with a proven stop; None for none.

    ``state`` are position and velocity of the robot (dof,), and optionally its acceleration. If ``slow`` and the chunk
    is not safe, the motion is the slower one of the verdict, where there is one.
    """
    clock, parts = to_nanoseconds(times), list[Trajectory]()
    kept = int((clock <= to_nanoseconds(np.array([verdict.safe_until]))[0]).sum())
    slower, slowed = (verdict.slower, verdict.slowed) if slow else (None, None)
    if slower is not None and slowed is not None:
        verdict, parts = slower, [slowed]
    else:
        if kept and clock[0] > 0:
            lead = [np.stack(rows) for rows in zip(state, [column[0] for column in columns], strict=False)]
            parts.append(Trajectory(joints, np.array([0, clock[0]]), tuple(lead)))
        if kept > 1:
            parts.append(Trajectory(joints, clock[:kept], tuple(column[:kept] for column in columns)))
    from_state = not parts or bool(clock[0] > 0)
    if parts and (np.abs(parts[-1].ends(1)[0][-1]) < _AT_REST).all():
        return Motion(tuple(parts), from_state)
    if verdict.stop is None:
        return None
    begin = int(parts[-1].nanoseconds[-1]) if parts else 0
    behind = replace(verdict.stop, nanoseconds=verdict.stop.nanoseconds + begin)
    return Motion((*parts, behind), from_state)


def check_rest(gate: Gate, motion: Motion, t: float) -> Verdict | None:
    """Return the verdict on the first part behind ``t`` s that is not proven free now; None for none."""
    for begin, part, state in motion.rest(t):
        verdict = _check(gate, begin, part, state, stop=False)
        if not verdict:
            return verdict
    return None


def stop_motion(gate: Gate, motion: Motion, t: float) -> Motion:
    """Return the motion from ``t`` s on to a proven stop in the gate's world, with times from 0.

    Without one it is the hardest stop along the curve within limits, which is not proven then.
    """
    begin, part, state = next(motion.rest(t))
    later = part.nanoseconds > round(begin * 1e9)
    columns, times = [column[later] for column in part.columns], part.times[later] - begin
    cut = make_motion(gate.robot.joints, columns, times, state, _check(gate, begin, part, state, stop=True))
    if cut is not None:
        return cut
    stop = stop_at(part, begin, gate.checker, gate.limits)
    return Motion((stop.trajectory,), from_state=True, proven=stop.proven)


def _check(gate: Gate, begin: float, part: Trajectory, state: Sequence[Floats], stop: bool) -> Verdict:
    later = part.nanoseconds > round(begin * 1e9)
    if not later.any():
        raise PlannerError(f"a motion must go on behind {begin:g} s, got none.")
    columns = [column[later] for column in part.columns]
    return gate.check(*columns, times=part.times[later] - begin, state=state, stop=stop)
