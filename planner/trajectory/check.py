"""A check of a path or a trajectory from any source, as a controller runs it: samples, proofs, limits, clearance."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from planner.base.arrays import Floats, parts_of
from planner.base.errors import FileError, OptionError
from planner.base.polynomials import bernstein, derivative, evaluate
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF, PROOF_OF_CHECK, RECHECK, W_ALONG_PATH
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.looks import Clearance, second_look, straight
from planner.collision.world import Contact
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.query.resolve import DEGREES, beyond_limits, looks_like_degrees
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.measure import nearest_on_pieces, slack
from planner.trajectory.moving_obstacles import first_touch_in_time, prove_in_time
from planner.trajectory.proof import find_limit_violations, largest_jump, prove_pieces, require_joints, unit_of
from planner.trajectory.recorded import FAR
from planner.trajectory.report import Finding, Report
from planner.trajectory.trajectory import Trajectory

_AT_REST = float(np.finfo(np.float32).eps)  # rad/s: what ROS 2's controller lets a trajectory end with
_MOST_STATES = 100_000  # at which w is looked at

Touch = tuple[float, Contact, Floats]  # a place, what touches there, and the configuration (dof,)


def require_step(step: float) -> None:
    """Raise :class:`OptionError` unless ``step`` (m) is a usable distance between the samples of a path."""
    if not 1e-6 <= step <= 1.0:
        raise OptionError(f"step must be a distance from 0.000001 to 1 m, got {step:g}.")


def check_path(checker: CollisionChecker, path: Floats, step: float = RECHECK, progress: Progress = QUIET) -> Report:
    """The report on a joint path (k, dof), straight in joint space between its waypoints.

    A path that looks like degrees is checked no further: the motions between its rows mean nothing.
    """
    require_step(step)
    begun = Report(checker, step, timed=False, measures={"points": len(path)})
    beyond = _beyond_waypoint(path, checker)
    if beyond and looks_like_degrees(checker.robot, path):
        return replace(begun, findings=(_degrees((0.0, len(path) - 1.0), timed=False),))
    pieces = straight(path[:-1], np.diff(path, axis=0)) if len(path) > 1 else straight(path, 0.0 * path)
    return _examine(replace(begun, findings=beyond), pieces, np.arange(len(pieces) + 1.0), progress)


def check_trajectory(
    checker: CollisionChecker,
    trajectory: Trajectory,
    limits: MotionLimits | None = None,
    step: float = RECHECK,
    progress: Progress = QUIET,
) -> Report:
    """The report on what a ROS 2 joint trajectory controller makes of a ``trajectory``: lines, cubics or quintics.

    ``limits`` are in place of those that the trajectory was made for, and these in place of the robot's own. Times and
    velocities that no controller runs, and positions that look like degrees, are checked no further.
    """
    require_step(step)
    robot = checker.robot
    require_joints(trajectory.joints, checker)
    limits = limits or trajectory.limits or MotionLimits.from_robot(robot)
    measures = {"points": len(trajectory.times), "limits": {**limits.to_dict(), "text": limits.text(robot)}}
    begun = Report(checker, step, timed=True, measures=measures, notes=_notes(trajectory))
    if faults := _faults(trajectory):
        return replace(begun, findings=faults)
    _require_within_reason(trajectory)
    exceeded = find_limit_violations(trajectory, robot, limits)
    if exceeded and looks_like_degrees(robot, trajectory.columns[0]):
        return replace(begun, findings=(_degrees((float(trajectory.times[0]), float(trajectory.times[-1]))),))
    jump, in_time = largest_jump(trajectory, limits), prove_in_time(trajectory, checker)
    infinite = () if jump is None else jump.infinite
    shares = {
        kind: None if kind in infinite else trajectory.worst(order, getattr(limits, kind))[0]
        for order, kind in enumerate(KINDS, start=1)
    }
    measures |= {
        "duration": trajectory.duration,
        "begin": float(trajectory.times[0]),
        "interpolation": trajectory.interpolation,
        "shares": shares,
        "jump": None if jump is None else jump.text(robot),
        "not_judged": [kind for kind in infinite if not limits.is_given(kind)],
        **in_time.to_dict(),
    }
    touch = first_touch_in_time(trajectory, checker, checker.world.scene.moving, step)
    begun = replace(begun, findings=exceeded, measures=measures)
    return _examine(begun, trajectory.coefficients, trajectory.times, progress, touch, int((~in_time.free).sum()))


def _examine(
    begun: Report,
    pieces: Floats,
    places: Floats,
    progress: Progress,
    touch: Touch | None = None,
    late: int = 0,
) -> Report:
    """The report with what pieces (k, degree + 1, dof) between ``places`` (k + 1,) touch, keep and are proven to do.

    ``touch`` is a contact that is known already, of a motion of which ``late`` pieces are not proven in time.
    """
    checker, count, findings = begun.checker, len(pieces), list(begun.findings)
    seen = second_look(checker, pieces, begun.step, progress=partial(progress, "contacts"))
    touches = [] if touch is None else [touch]
    if seen is not None:
        at = places[seen.piece] + seen.s * (places[seen.piece + 1] - places[seen.piece])
        touches.append((float(at), seen.contact, seen.q))
    progress("nearest", 0, count)
    nearest = nearest_on_pieces(pieces, places, checker)
    progress("nearest", count, count)
    progress("proofs", 0, count)
    prover = EdgeProver(checker)
    verdict, pair = prove_pieces(pieces, prover, PROOF_OF_CHECK)
    progress("proofs", count, count)
    if touches:
        at, contact, q = min(touches, key=lambda item: item[0])
        findings.append(_contact(checker, contact, (at, at), begun.timed, q))
    elif (verdict == Verdict.COLLIDES).any():
        k = int((verdict == Verdict.COLLIDES).argmax())
        contact = prover.static_contact or checker.world.contact(int(pair[k]))
        findings.append(_contact(checker, contact, (float(places[k]), float(places[k + 1])), begun.timed))
    strayed, measured = _measure(begun, pieces, places)
    free, bound = bool((verdict == Verdict.FREE).all()), None
    if free and nearest is not None:
        bound = prove_distance(checker, pieces, nearest.min)
    undecided = max(int((verdict == Verdict.UNDECIDED).sum()), late)
    return replace(
        begun,
        findings=(*findings, *strayed),
        pieces={each.name.lower(): int((verdict == each).sum()) for each in Verdict},
        clearance=nearest,
        measures=begun.measures | measured | {"proven_distance": bound, "undecided": undecided},
    )


def _measure(begun: Report, pieces: Floats, places: Floats) -> tuple[list[Finding], dict[str, Any]]:
    """Constraints that pieces break, and lengths, w and what constraints have to spare at states along the pieces."""
    checker, robot = begun.checker, begun.checker.robot
    motion = np.abs(bernstein(derivative(pieces))).max(axis=(1, 2))
    parts = parts_of(motion, max(W_ALONG_PATH, motion.sum() / _MOST_STATES))
    piece = np.repeat(np.arange(len(parts)), parts)
    s = (np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[piece]
    q = np.vstack([evaluate(pieces[piece], s), pieces[-1:].sum(axis=1)])
    at = np.append(places[piece] + s * np.diff(places)[piece], places[-1])
    findings, constraints = [], []
    for kept in checker.world.constraints.along(q, pieces):
        text, unit, where = kept.condition.text, kept.condition.unit, float(at[kept.row])
        told = {"condition": text, "unit": unit, "spare": kept.spare, "at": where, "proven": kept.proven}
        constraints.append(told | {"strays": kept.strays})
        if kept.strays:
            findings.append(Finding("constraint", (text,), (where, where), -kept.spare, 0.0, unit, begun.timed))
    w, tool = manipulability(robot, q), tool_positions(robot, q)
    return findings, {
        "joint_length": float(np.linalg.norm(np.diff(q, axis=0), axis=1).sum()),
        "workspace_length": float(np.linalg.norm(np.diff(tool, axis=0), axis=1).sum()),
        "w_min": float(w.min()),
        "w_mean": float(w.mean()),
        "w_at": float(at[w.argmin()]),
        "constraints": constraints,
    }


def prove_distance(checker: CollisionChecker, pieces: Floats, clearance: float) -> float:
    """A distance (m) that pieces, proven free at the checker's margin, are proven to keep: that margin or more.

    Proofs are tried at margins a little below the ``clearance`` that was found, so it may be smaller than the truth.
    """
    world = checker.world
    for margin in (clearance - slack(clearance) - PROOF_OF_CHECK, 0.5 * clearance):
        if world.margin < margin < np.inf:
            wider = type(checker)(replace(world, margin=margin))
            if EdgeProver(wider).all_free(pieces, PROOF):
                return float(margin)
    return world.margin


def _contact(
    checker: CollisionChecker, contact: Contact, where: tuple[float, float], timed: bool, q: Floats | None = None
) -> Finding:
    """The finding on a contact: a clearance below the margin where the two do not touch."""
    margin, pair = checker.world.margin, (contact.first, contact.second)
    gap = 0.0 if q is None else float(Clearance(checker)(q[None])[0])
    closer = margin > 0.0 and not contact.enclosed and (q is None or gap > 0.0)
    note = ", one wholly inside the other, a closed mesh" if contact.enclosed else ""
    note += "" if q is None else f", q:{','.join(f'{value:.4f}' for value in q)}"
    value = None if q is None else gap
    return Finding("clearance" if closer else "contact", pair, where, value, margin, "m", timed, q, note)


def _beyond_waypoint(path: Floats, checker: CollisionChecker) -> tuple[Finding, ...]:
    """The value farthest beyond a joint limit; between waypoints within limits the path is within them too."""
    robot, beyond = checker.robot, beyond_limits(checker.robot, path)
    row, joint = (int(k) for k in np.unravel_index(int(beyond.argmax()), beyond.shape))
    if not beyond[row, joint]:
        return ()
    value, name = float(path[row, joint]), robot.joints[joint]
    allowed = float((robot.lower if value < robot.lower[joint] else robot.upper)[joint])
    at = (float(row), float(row))
    return (Finding("limit", ("position", name), at, value, allowed, unit_of(robot, name), timed=False),)


def _degrees(where: tuple[float, float], timed: bool = True) -> Finding:
    text = f"positions are beyond the joint limits: {DEGREES}"
    return Finding("limit", ("position", ""), where, unit="rad", timed=timed, text=text)


def _faults(trajectory: Trajectory) -> tuple[Finding, ...]:
    """Why no controller runs these times and velocities; empty where one does."""
    times = trajectory.times
    if times[0] < 0:
        text = f"the first point is {-times[0]:g} s before the start"
        return (Finding("discontinuity", ("time",), (float(times[0]), 0.0), float(times[0]), 0.0, "s", text=text),)
    joint, velocity = _fastest(trajectory, -1)
    if abs(velocity) <= _AT_REST:
        return ()
    text = f"the last velocity is not 0: joint '{joint}' ends with {velocity:.3g}"
    text += ", which a ROS 2 joint trajectory controller refuses"
    end = (float(times[-1]), float(times[-1]))
    return (Finding("discontinuity", ("velocity", joint), end, velocity, 0.0, "rad/s", text=text),)


def _notes(trajectory: Trajectory) -> tuple[str, ...]:
    """Notes of the file, and on how the motion begins: what comes before its first point is the controller's."""
    notes = list(trajectory.notes)
    if trajectory.times[0] > 0:
        notes.append(f"until {trajectory.times[0]:g} s it moves there from where the robot is: that is not checked")
    joint, velocity = _fastest(trajectory, 0)
    if abs(velocity) > _AT_REST:
        moves = f"joint '{joint}' begins with a velocity of {velocity:.3g}"
        notes.append(f"{moves}: right only for a robot that moves so already")
    return tuple(notes)


def _fastest(trajectory: Trajectory, row: int) -> tuple[str, float]:
    """The joint of the largest velocity that is given for a point, and this velocity; 0 where none is given."""
    velocity = trajectory.columns[1][row] if len(trajectory.columns) > 1 else np.zeros(1)
    joint = int(np.abs(velocity).argmax())
    return trajectory.joints[joint], float(velocity[joint])


def _require_within_reason(trajectory: Trajectory) -> None:
    """Raise :class:`FileError` for swings that no arm does, and that would take forever to sample."""
    hull = np.abs(bernstein(trajectory.coefficients)).max(axis=(1, 2))
    if hull.max() > FAR:
        k = int(hull.argmax())
        raise FileError(
            f"between {trajectory.times[k]:g} and {trajectory.times[k + 1]:g} s the trajectory swings as far as "
            f"{hull[k]:.3g}: mend its positions or velocities."
        )
