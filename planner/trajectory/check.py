"""Checks of a path or a trajectory from any source: samples, proofs, limits and clearance."""

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
from planner.collision.recheck import Clearance, recheck_pieces, straight
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

_AT_REST = float(np.finfo(np.float32).eps)  # rad/s: largest final velocity that ROS 2's controller accepts
_MOST_STATES = 100_000  # for w

Touch = tuple[float, Contact, Floats]  # a location, the contact there, and the configuration (dof,)


def require_step(step: float) -> None:
    """Raise :class:`OptionError` unless ``step`` (m) is a usable distance between samples."""
    if not 1e-6 <= step <= 1.0:
        raise OptionError(f"step must be a distance from 0.000001 to 1 m, got {step:g}.")


def check_path(checker: CollisionChecker, path: Floats, step: float = RECHECK, progress: Progress = QUIET) -> Report:
    """Return the report on a joint path (k, dof) with straight segments in joint space.

    The check ends early for a path that looks like degrees.
    """
    require_step(step)
    report = Report(checker, step, timed=False, measures={"points": len(path)})
    beyond = _find_beyond_limit(path, checker)
    if beyond and looks_like_degrees(checker.robot, path):
        return replace(report, findings=(_degrees((0.0, len(path) - 1.0), timed=False),))
    pieces = straight(path[:-1], np.diff(path, axis=0)) if len(path) > 1 else straight(path, 0.0 * path)
    return _examine(replace(report, findings=beyond), pieces, np.arange(len(pieces) + 1.0), progress)


def check_trajectory(
    checker: CollisionChecker,
    trajectory: Trajectory,
    limits: MotionLimits | None = None,
    step: float = RECHECK,
    progress: Progress = QUIET,
) -> Report:
    """Return the report on a ``trajectory`` as a ROS 2 joint trajectory controller runs it.

    ``limits`` replace those that the trajectory was made for, and these the robot's own. The check ends early for times
    and velocities that no controller runs, and for positions that look like degrees.
    """
    require_step(step)
    robot = checker.robot
    require_joints(trajectory.joints, checker)
    limits = limits or trajectory.limits or MotionLimits.from_robot(robot)
    measures = {"points": len(trajectory.times), "limits": {**limits.to_dict(), "text": limits.text(robot)}}
    report = Report(checker, step, timed=True, measures=measures, notes=_collect_notes(trajectory))
    if findings := _find_controller_refusals(trajectory):
        return replace(report, findings=findings)
    _require_plausible_swings(trajectory)
    violations = find_limit_violations(trajectory, robot, limits)
    if violations and looks_like_degrees(robot, trajectory.columns[0]):
        return replace(report, findings=(_degrees((float(trajectory.times[0]), float(trajectory.times[-1]))),))
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
    report = replace(report, findings=violations, measures=measures)
    return _examine(report, trajectory.coefficients, trajectory.times, progress, touch, int((~in_time.free).sum()))


def _examine(
    report: Report,
    pieces: Floats,
    locations: Floats,
    progress: Progress,
    touch: Touch | None = None,
    unproven_in_time: int = 0,
) -> Report:
    """Add contacts, proofs and measures of pieces (k, degree + 1, dof) between ``locations`` (k + 1,).

    ``touch`` is a contact from before; ``unproven_in_time`` pieces of the motion are not proven among moving obstacles.
    """
    checker, count, findings = report.checker, len(pieces), list(report.findings)
    sample = recheck_pieces(checker, pieces, report.step, progress=partial(progress, "contacts"))
    touches = [] if touch is None else [touch]
    if sample is not None:
        at = locations[sample.piece] + sample.s * (locations[sample.piece + 1] - locations[sample.piece])
        touches.append((float(at), sample.contact, sample.q))
    progress("nearest", 0, count)
    nearest = nearest_on_pieces(pieces, locations, checker)
    progress("nearest", count, count)
    progress("proofs", 0, count)
    prover = EdgeProver(checker)
    verdict, pair = prove_pieces(pieces, prover, PROOF_OF_CHECK)
    progress("proofs", count, count)
    if touches:
        at, contact, q = min(touches, key=lambda item: item[0])
        findings.append(_contact(checker, contact, (at, at), report.timed, q))
    elif (verdict == Verdict.COLLIDES).any():
        k = int((verdict == Verdict.COLLIDES).argmax())
        contact = prover.static_contact or checker.world.contact(int(pair[k]))
        findings.append(_contact(checker, contact, (float(locations[k]), float(locations[k + 1])), report.timed))
    broken, measured = _measure(report, pieces, locations)
    free, bound = bool((verdict == Verdict.FREE).all()), None
    if free and nearest is not None:
        bound = prove_distance(checker, pieces, nearest.min)
    undecided = max(int((verdict == Verdict.UNDECIDED).sum()), unproven_in_time)
    return replace(
        report,
        findings=(*findings, *broken),
        pieces={each.name.lower(): int((verdict == each).sum()) for each in Verdict},
        clearance=nearest,
        measures=report.measures | measured | {"proven_distance": bound, "undecided": undecided},
    )


def _measure(report: Report, pieces: Floats, locations: Floats) -> tuple[list[Finding], dict[str, Any]]:
    """Return broken constraints, and lengths, w and slacks of constraints at states along the pieces."""
    checker, robot = report.checker, report.checker.robot
    motion = np.abs(bernstein(derivative(pieces))).max(axis=(1, 2))
    parts = parts_of(motion, max(W_ALONG_PATH, motion.sum() / _MOST_STATES))
    piece = np.repeat(np.arange(len(parts)), parts)
    s = (np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[piece]
    q = np.vstack([evaluate(pieces[piece], s), pieces[-1:].sum(axis=1)])
    at = np.append(locations[piece] + s * np.diff(locations)[piece], locations[-1])
    findings, constraints = [], []
    for result in checker.world.constraints.along(q, pieces):
        text, unit, where = result.condition.text, result.condition.unit, float(at[result.row])
        row = {"condition": text, "unit": unit, "spare": result.slack, "at": where, "proven": result.proven}
        constraints.append(row | {"strays": result.violates})
        if result.violates:
            findings.append(Finding("constraint", (text,), (where, where), -result.slack, 0.0, unit, report.timed))
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
    """Return a distance (m), at least the checker's margin, that pieces proven free are proven to keep.

    It tries margins slightly below the measured ``clearance``, so it may underestimate.
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
    """Return the finding on a contact; within the margin but without touch it is a clearance."""
    margin, pair = checker.world.margin, (contact.first, contact.second)
    gap = 0.0 if q is None else float(Clearance(checker)(q[None])[0])
    closer = margin > 0.0 and not contact.enclosed and (q is None or gap > 0.0)
    note = ", one wholly inside the other, a closed mesh" if contact.enclosed else ""
    note += "" if q is None else f", q:{','.join(f'{value:.4f}' for value in q)}"
    value = None if q is None else gap
    return Finding("clearance" if closer else "contact", pair, where, value, margin, "m", timed, q, note)


def _find_beyond_limit(path: Floats, checker: CollisionChecker) -> tuple[Finding, ...]:
    """Return the largest violation of a joint limit by a waypoint; segments have no larger one."""
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


def _find_controller_refusals(trajectory: Trajectory) -> tuple[Finding, ...]:
    """Return the reason why no controller runs these times and velocities, if there is one."""
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


def _collect_notes(trajectory: Trajectory) -> tuple[str, ...]:
    """Return notes of the file, and on the first point: the controller's motion to it is not checked."""
    notes = list(trajectory.notes)
    if trajectory.times[0] > 0:
        notes.append(f"the motion to the first point, until {trajectory.times[0]:g} s, is not checked")
    joint, velocity = _fastest(trajectory, 0)
    if abs(velocity) > _AT_REST:
        notes.append(f"joint '{joint}' starts at a velocity of {velocity:.3g}: the robot must move so already")
    return tuple(notes)


def _fastest(trajectory: Trajectory, row: int) -> tuple[str, float]:
    """Return the joint of the largest given velocity at a point, and that velocity; 0 if none is given."""
    velocity = trajectory.columns[1][row] if len(trajectory.columns) > 1 else np.zeros(1)
    joint = int(np.abs(velocity).argmax())
    return trajectory.joints[joint], float(velocity[joint])


def _require_plausible_swings(trajectory: Trajectory) -> None:
    """Raise :class:`FileError` for swings beyond any arm's, whose sampling would not end."""
    hull = np.abs(bernstein(trajectory.coefficients)).max(axis=(1, 2))
    if hull.max() > FAR:
        k = int(hull.argmax())
        raise FileError(
            f"positions between {trajectory.times[k]:g} and {trajectory.times[k + 1]:g} s must be at most {FAR:g}, got "
            f"{hull[k]:.3g}: mend the positions or velocities."
        )
