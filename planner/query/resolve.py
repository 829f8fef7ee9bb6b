"""Configurations of the arm for a target."""

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache

import numpy as np

from planner.base.arrays import Bools, Floats, frozen
from planner.base.errors import OptionError, StateError, choices, log_notes
from planner.base.yamlfile import quote
from planner.collision.checker import CollisionChecker, contact_at, is_free
from planner.collision.world import Contact
from planner.constraints.path_constraints import PathConstraints, bind_to_start, require_bound
from planner.kinematics import inverse
from planner.kinematics.manipulability import manipulability
from planner.problem.conditions import BoxConstraint, Condition
from planner.problem.outcome import BeyondLimit, ConstraintBroken, Touching
from planner.problem.targets import (
    FORMS,
    HOME,
    TURN,
    Joints,
    Named,
    Pose,
    Position,
    RobotStates,
    Target,
    ToolGoal,
    follow_names,
    parse_target,
)
from planner.query.inverse_targets import (
    IK_SEED,
    reach_targets,
    require_finite,
    seeds_around,
    targets_of_several_tools,
)
from planner.robot.robot import Robot

NEAR_LIMIT = 0.05  # rad (m): a solution this near a joint limit is the last choice
DEGREES = "degrees? As degrees they would lie within limits; give them in rad."  # remedy for degrees
_FORGIVEN = 1e-9  # rad (m): beyond a limit that was printed and read back
_SEEDS, _BRANCH = 300, 0.3  # of goals with tolerance; rad (m): closer configurations are one branch
_GLANCE = 0.1  # rad (m) of the largest joint motion between samples of a straight motion


def resolve(
    target: Target,
    checker: CollisionChecker,
    states: Mapping[str, str],
    role: str,
    count: int = 1,
    starts: Floats | None = None,
    tolerance: inverse.Tolerance = inverse.TOLERANCE,
) -> Floats:
    """Return up to ``count`` free configurations (k, dof) for ``target``, best manipulability first.

    ``states`` are the scene's named states of this robot; ``role`` is "start", "goal" or, for several, "goal 'TEXT'".
    Solutions of ``IK_STARTS`` seeds within ``NEAR_LIMIT`` of a joint limit are the last choice. With ``starts`` (s,
    dof) as further seeds, the best by manipulability and the nearest to a start alternate: good choices for beta 0 and
    beta 1. A pose that cannot be reached exactly is reached within the ``tolerance`` (m, rad).
    Raises :class:`StateError`: out of limits, in collision, out of reach.
    """
    match target:
        case Named(names):
            inner = [target for name in names for target in _look_up(name, states, checker, role)]
            return np.vstack([resolve(each, checker, states, role, count, starts, tolerance) for each in inner])
        case Joints(values):
            found = free_configuration(np.array(values), checker, role)
            if role == "start":
                log_notes(*other_turns(target, checker, states))
            return found[None]
        case RobotStates():
            raise OptionError(
                f"state must be {FORMS}, got '{target.text[:100]}': give one of these, or --cell for states by robot."
            )
        case ToolGoal() if several := targets_of_several_tools(target, checker):
            return _choose(reach_targets(several, checker.robot, role, starts, tolerance), checker, role, count, starts)
        case ToolGoal(conditions):
            found = _spread(solve_conditions(conditions, checker, role, starts, tolerance), checker.robot)
            return _choose(found, checker, role, count, starts)
        case Position((x, y, z)) if checker.world.constraints:
            here = ToolGoal((BoxConstraint((x, y, z), (x, y, z), frame=target.frame),))
            return resolve(here, checker, states, role, count, starts)
        case Position() | Pose():
            found = reach_targets((target,), checker.robot, role, starts, tolerance)
            return _choose(_satisfy_constraints(found, target, checker, role, starts), checker, role, count, starts)


def other_turns(start: Target, checker: CollisionChecker, states: Mapping[str, str]) -> list[str]:
    """Return a sentence for each continuous joint whose start value is in another turn than the plan's."""
    if isinstance(start, Named):
        inner = [target for name in start.names for target in _look_up(name, states, checker, "start")]
        return [sentence for each in inner for sentence in other_turns(each, checker, states)]
    if not isinstance(start, Joints):
        return []
    robot, given = checker.robot, joint_values(np.array(start.values), checker.robot, "start")
    begun = robot.normalise(given)
    return [
        f"the start has joint '{robot.joints[k]}' at {given[k]:.6g} rad, the plan begins at {begun[k]:.6g}, the same "
        "position in another turn: a controller that counts turns must begin there, or it turns back first."
        for k in np.flatnonzero(robot.continuous & (np.abs(given - begun) > _FORGIVEN))
    ]


def resolve_as_is(target: Target, checker: CollisionChecker, states: Mapping[str, str], role: str) -> Floats:
    """Return one configuration (dof,) for ``target``, which may be in collision or out of limits.

    Joint values stay as given; a position or pose becomes the free solution of highest manipulability, or the best of
    those in collision. Raises :class:`StateError`: wrong joint count, out of reach, unknown name.
    """
    match target:
        case Named(names):
            inner = [found for name in names for found in _look_up(name, states, checker, role)]
            if len(inner) > 1:
                raise StateError(f"{role} must be one state, got {len(inner)}, {choices(names)}: name one.")
            return resolve_as_is(inner[0], checker, states, role)
        case Joints(values):
            return frozen(joint_values(np.array(values), checker.robot, role))
        case Position() | Pose():
            found = reach_targets((target,), checker.robot, role, None, inverse.TOLERANCE)
        case ToolGoal() if several := targets_of_several_tools(target, checker):
            found = reach_targets(several, checker.robot, role, None, inverse.TOLERANCE)
        case ToolGoal(conditions):
            found = solve_conditions(conditions, checker, role)
        case RobotStates():
            raise OptionError(
                f"{role} must be {FORMS}, got '{target.text[:100]}': give one of these, or --cell for states by robot."
            )
    touching = np.array([contact_at(checker, q) is not None for q in found])
    return frozen(found[np.lexsort((-manipulability(checker.robot, found), touching))[0]])


def solve_conditions(
    conditions: tuple[Condition, ...],
    checker: CollisionChecker,
    role: str,
    starts: Floats | None = None,
    tolerance: inverse.Tolerance = inverse.TOLERANCE,
) -> Floats:
    """Return configurations (k, dof) across the set of those that meet ``conditions`` and constraints.

    Seeds, and seeds around ``starts``, are projected, each to a depth of its own. If none meets the conditions exactly,
    those within the ``tolerance`` (m, rad) count, for an arm of few axes. :class:`StateError` if there are none.
    """
    robot, rng = checker.robot, np.random.default_rng(IK_SEED)
    if starts is not None:
        conditions = bind_to_start(conditions, robot, starts[0])
    require_bound(conditions, robot)
    all_of_them = PathConstraints(robot, (*conditions, *checker.world.conditions))
    seeds = np.vstack([robot.home, rng.uniform(robot.lower, robot.upper, size=(_SEEDS - 1, robot.dof))])
    if starts is not None:
        seeds = np.vstack([seeds, seeds_around(robot, starts)])
    found, good = all_of_them.project(seeds, rng.random(len(seeds)), inverse.POSITION_TOLERANCE)
    allowed = checker.world.constraints.holds(found)
    good &= allowed
    if good.any():
        return robot.normalise(found[good])
    spare = all_of_them.slacks(found)
    # pi / 2 written as 1.5708 in a URDF leaves axes 4e-6 rad off parallel: five joints miss a direction by this
    good = allowed & (spare >= [-tolerance[each.unit == "rad"] for each in all_of_them.conditions]).all(axis=1)
    if good.any():
        return robot.normalise(found[good])
    nearest = int(spare.min(axis=1).argmax())
    missed = all_of_them.conditions[int(spare[nearest].argmin())]
    raise StateError(
        f"{role} cannot be reached by frame '{robot.tool}': the nearest configuration of {len(seeds)} tries misses "
        f"'{missed.text}' by {-spare[nearest].min():.3g} {missed.unit}; choose a nearer one, or more tolerance.",
        ConstraintBroken(role, missed.text, float(-spare[nearest].min())),
    )


def _spread(found: Floats, robot: Robot) -> Floats:
    """Return those of ``found`` (k, dof) that are not near a better one: branches of the inverse."""
    order = np.argsort(-manipulability(robot, found), kind="stable")
    kept = np.zeros((0, robot.dof))
    for q in found[order]:
        if (np.abs(robot.difference(q, kept)).max(axis=1, initial=0.0) > _BRANCH).all():
            kept = np.vstack([kept, q])
    return kept


def _look_up(name: str, states: Mapping[str, str], checker: CollisionChecker, role: str) -> list[Target]:
    """Return the targets of a named state: several if the scene names alternatives."""
    found, robot, end = (
        [parse_target(text) for text in follow_names(name, states)],
        checker.robot,
        role.partition(" '")[0],
    )
    found = [Joints(tuple(robot.home.tolist())) if each.text == HOME else each for each in found]
    if unknown := [each.text for each in found if isinstance(each, Named)]:
        names = choices(dict.fromkeys([*states, HOME]))
        raise StateError(
            f"{end} {quote(unknown[0])} not found; states of {robot.name} in the scene are {names}: give one of them, "
            f"or {FORMS}."
        )
    return found


def free_configuration(values: Floats, checker: CollisionChecker, role: str) -> Floats:
    """Return the configuration of joint values (dof,), as :func:`free_configurations`."""
    return free_configurations([(role, values)], checker)[0]


def free_configurations(rows: Sequence[tuple[str, Floats]], checker: CollisionChecker) -> Floats:
    """Return joint values (n, dof) of rows (role, (dof,)), continuous ones in [-pi, pi).

    :class:`StateError` unless within limits and free. Values that exceed a limit by rounding are clipped to it, as OMPL
    tolerates less.
    """
    robot = checker.robot
    for role, values in rows:
        check_limits(robot, joint_values(values, robot, role), role)
    values = clip_to_limits(robot, np.array([values for _, values in rows]).reshape(-1, robot.dof))
    _require_constraints([(role, q) for (role, _), q in zip(rows, values, strict=True)], checker)
    found = checker.first_contact(values) if len(values) else None
    if found is not None:
        (role, _), contact = rows[found[0]], found[1]
        raise StateError(
            f"{role} is in collision: {_describe(contact, checker)}; move it or the obstacle.",
            contact_reason(role, contact),
        )
    return frozen(robot.normalise(values))


def clip_to_limits(robot: Robot, values: Floats) -> Floats:
    """Return joint values (n, dof) clipped to the limits."""
    return np.where(robot.continuous, values, np.clip(values, robot.lower, robot.upper))


def _require_constraints(rows: Sequence[tuple[str, Floats]], checker: CollisionChecker) -> None:
    """Raise :class:`StateError` for the first of ``rows`` that breaks a path constraint."""
    constraints, values = checker.world.constraints, np.array([q for _, q in rows]).reshape(-1, checker.robot.dof)
    for row in np.flatnonzero(~constraints.holds(values)).tolist():
        spare = constraints.slacks(values[row : row + 1])[0]
        role, kept, by = rows[row][0], constraints.conditions[spare.argmin()], float(-spare.min())
        raise StateError(
            f"{role} must satisfy the constraint '{kept.text}', got {by:.3g} {kept.unit} too much: choose another one, "
            "or relax the constraint.",
            ConstraintBroken(role, kept.text, by),
        )


def joint_values(values: Floats, robot: Robot, role: str) -> Floats:
    """Return the values (dof,); :class:`StateError` unless one per joint, finite and not huge."""
    if values.shape != (robot.dof,):
        raise StateError(
            f"{role} must have {robot.dof} joint values, got {values.size}: planned joints of {robot.name} "
            f"are {choices(robot.joints)}."
        )
    require_finite(values, role)
    return values


def check_limits(robot: Robot, values: Floats, role: str, remedy: str = "bring it inside.") -> None:
    """Raise :class:`StateError` for the first joint that is out of its limits.

    ``remedy`` ends the message; a command may have a better one.
    """
    beyond = beyond_limits(robot, values)
    for k in np.nonzero(beyond)[0]:
        unit = "m" if robot.prismatic[k] else "rad"
        raise StateError(
            f"{role} puts joint '{robot.joints[k]}' at {values[k]:.6g}, outside its limits "
            f"[{robot.lower[k]:.6g}, {robot.upper[k]:.6g}] by {beyond[k]:.3g} {unit}: "
            + (DEGREES if looks_like_degrees(robot, values) else remedy),
            BeyondLimit(role, robot.joints[k], float(values[k]), float(robot.lower[k]), float(robot.upper[k])),
        )


def beyond_limits(robot: Robot, values: Floats) -> Floats:
    """Return how far (..., dof) joint values exceed their limits (rad, m); 0 for continuous joints."""
    beyond = np.maximum(robot.lower - values, values - robot.upper)
    return np.where(robot.continuous | (beyond <= _FORGIVEN), 0.0, beyond)


def position_bounds(robot: Robot) -> tuple[Floats, Floats]:
    """Return the lowest and the highest values (dof,) within limits and rounding."""
    lower, upper = robot.lower - _FORGIVEN, robot.upper + _FORGIVEN
    return np.where(robot.continuous, -np.inf, lower), np.where(robot.continuous, np.inf, upper)


def looks_like_degrees(robot: Robot, values: Floats) -> bool:
    """Return whether values (..., dof) out of limits, some beyond a turn, are within limits as degrees.

    A wrong guess would hide the true remedy, so values up to 2 pi count as radians.
    """
    turns = ~(robot.prismatic | robot.continuous)
    beyond = beyond_limits(robot, values) > 0
    as_degrees = np.where(robot.prismatic, values, np.radians(values))
    return bool((beyond & turns & (np.abs(values) > TURN)).any()) and not beyond_limits(robot, as_degrees).any()


def _choose(found: Floats, checker: CollisionChecker, role: str, count: int, starts: Floats | None) -> Floats:
    @cache
    def free(row: int) -> bool:  # called for few candidates: a check is as slow as a solution
        return is_free(checker, found[row])

    if not any(map(free, range(len(found)))):
        first = contact_at(checker, found[0])
        assert first is not None
        raise StateError(
            f"{role} is reached by {len(found)} configurations, all in collision (the first: "
            f"{_describe(first, checker)}); move it or the obstacle.",
            contact_reason(role, first),
        )
    robot = checker.robot
    slack = np.minimum(found - robot.lower, robot.upper - found)
    at_limit: Bools = np.any(np.where(robot.continuous, np.inf, slack) < NEAR_LIMIT, axis=1)
    best: Iterator[int] = filter(free, np.lexsort((-manipulability(robot, found), at_limit)).tolist())
    if starts is None:
        return frozen(found[_distinct(best, count)])
    nearest = _nearest(found, free, at_limit, checker, starts)
    alternately = itertools.chain.from_iterable(zip(best, nearest, strict=True))
    return frozen(found[_distinct(alternately, count)])


def _satisfy_constraints(
    found: Floats, target: Position | Pose, checker: CollisionChecker, role: str, starts: Floats | None
) -> Floats:
    """Return those of ``found`` (k, dof) within the path constraints, or solutions of both at once.

    :class:`StateError` if there are none.
    """
    good = checker.world.constraints.holds(found)
    if good.any():
        return found[good]
    with suppress(StateError):  # as joints that do not move the tool may have to follow
        return _spread(solve_conditions(ToolGoal((target,)).conditions, checker, role, starts), checker.robot)  # type: ignore[arg-type]
    _require_constraints([(role, found[int(checker.world.constraints.least_slack(found).argmax())])], checker)
    return found[good]


def _distinct(numbers: Iterable[int], count: int) -> list[int]:
    """Return the first ``count`` different ``numbers``."""
    chosen: dict[int, None] = {}
    for number in numbers:
        chosen[number] = None
        if len(chosen) == count:
            break
    return list(chosen)


def _nearest(
    found: Floats, free: Callable[[int], bool], at_limit: Bools, checker: CollisionChecker, starts: Floats
) -> Iterator[int]:
    """Yield indices of the ``free`` ones of ``found`` (k, dof), nearest to one of ``starts`` first.

    Those ``at_limit`` come last, and within each group those with a contact on the straight motion, which a few samples
    look for: a free one is likely a short way.
    """
    delta = checker.robot.difference(starts[:, None], found)  # (s, k, dof)
    lengths = np.linalg.norm(delta, axis=2)
    start, k = lengths.argmin(axis=0), np.arange(len(found))
    order = np.argsort(lengths[start, k], kind="stable")
    for group in (order[~at_limit[order]], order[at_limit[order]]):
        blocked = []
        for row in group.tolist():  # free() comes last, as the slowest test
            step = delta[start[row], row]
            count = max(1, int(np.ceil(np.abs(step).max() / _GLANCE)))
            shares = np.arange(1, count) / count if count > 1 else np.ones(1)
            if checker.bound.is_clear(starts[start[row]] + shares[:, None] * step) and free(row):
                yield row
            else:
                blocked.append(row)
        yield from filter(free, blocked)


def contact_reason(role: str, contact: Contact) -> Touching:
    """Return a contact at ``role`` as a reason."""
    return Touching(role, contact.first, contact.second, contact.enclosed)


def _describe(contact: Contact, checker: CollisionChecker) -> str:
    return f"{contact} {contact.how(checker.world.margin)}"
