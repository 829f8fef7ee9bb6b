"""From states of single robots to configurations of the composite robot of a cell."""

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError, RobotError
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker, is_free
from planner.kinematics.inverse import TOLERANCE, Tolerance
from planner.problem.options import Backend
from planner.problem.targets import HOME, Joints, Named, RobotStates, Target, joints_text
from planner.query.resolve import resolve
from planner.robot.cell import Cell
from planner.robot.robot import with_carried

_START = "start"  # the state in which a robot begins if a scene has it
_MOST = 64  # combinations of goal configurations that are checked


def composite_targets(
    cell: Cell,
    start: Target,
    goals: Sequence[Target],
    solutions: int,
    tolerance: Tolerance = TOLERANCE,
    checkers: Mapping[str, CollisionChecker] | None = None,
) -> tuple[Target, Sequence[Target]]:
    """Return start and goals of a cell as targets of its composite: joint values for states by robot.

    A robot without a start begins at its state ``start``, or else at home; one without a goal stays. A name is a state
    of all robots. Each robot has up to ``solutions`` configurations per goal, and the first free combinations are kept.
    ``checkers`` are those of :func:`make_robot_checker`.
    Raises :class:`RobotError` for robots whose fixed links touch, and errors as :func:`planner.query.resolve.resolve`.
    """
    checkers = checkers or {name: make_robot_checker(cell, name) for name in cell.robots}
    first, last = _by_robot(cell, [start], "start"), _by_robot(cell, goals, "goal")
    if first is not None:
        rows = {name: first.get(name, [_usual_start(cell, name)]) for name in cell.robots}
        q = [
            resolve(each[0], checkers[name], _states(cell, name), f"start '{name}'", tolerance=tolerance)[0]
            for name, each in rows.items()
        ]
        start = Joints(tuple(np.concatenate(q).tolist()))
    if last is None:
        return start, goals
    begin, options = _values(cell, start), list[Floats]()
    for name, columns in cell.columns.items():
        stays, states = begin[None, columns], _states(cell, name)
        found = [
            resolve(goal, checkers[name], states, f"goal '{name}'", solutions, stays, tolerance)
            for goal in last.get(name, ())
        ]
        options.append(np.vstack(found) if found else stays)
    ranks = sorted(itertools.product(*(range(len(rows)) for rows in options)), key=sum)[:_MOST]
    whole = [np.concatenate([rows[k] for rows, k in zip(options, each, strict=True)]) for each in ranks]
    if len(whole) > 1:  # a single one is judged by the caller
        checker = make_checker(with_carried(cell.robot, cell.scene.carried), cell.scene, "coal")
        whole = [q for q in whole if is_free(checker, q)][:solutions] or whole[:1]
    return start, tuple(Joints(tuple(q.tolist())) for q in whole)


def make_robot_checker(cell: Cell, name: str, backend: Backend = "coal", margin: float = 0.0) -> CollisionChecker:
    """Return the checker of one robot among obstacles and what the others never move.

    Raises :class:`RobotError` where its fixed links touch those of another robot.
    """
    scene = cell.scene_of(name)
    checker = make_checker(with_carried(cell.robots[name], scene.carried), scene, backend, margin)
    contact = checker.static_contact
    if contact is not None and cell.owner(contact.second) not in (None, name):
        other = cell.owner(contact.second)
        raise RobotError(
            f"robots '{name}' and '{other}' must stand apart, got a contact of '{contact.first}' and "
            f"'{contact.second}': move a base."
        )
    return checker


def _by_robot(cell: Cell, targets: Sequence[Target], role: str) -> dict[str, list[Target]] | None:
    """Return targets by robot; None if they are states of the composite."""
    found = dict[str, list[Target]]()
    for target in targets:
        if isinstance(target, RobotStates):
            for name, state in target.states:
                found.setdefault(cell.require_robot(name), []).append(state)
        elif isinstance(target, Named) and len(targets) == 1 and target.text not in (HOME, *cell.robot.states):
            if role == "start" and target.text == _START:
                return {}
            if all(target.text in _states(cell, name) for name in cell.robots):
                return {name: [target] for name in cell.robots}
    if found and not all(isinstance(target, RobotStates) for target in targets):
        raise OptionError(f"{role} must be ROBOT:STATE for each robot, or one state of all, got both: give one kind.")
    return found or None


def _usual_start(cell: Cell, name: str) -> Target:
    return Named((_START if _START in _states(cell, name) else HOME,))


def _states(cell: Cell, name: str) -> dict[str, str]:
    """Return the named states of one robot as texts."""
    own = {state: joints_text(values) for state, values in cell.robots[name].states.items() if state != HOME}
    return {**own, **cell.scene.states_of(name)}


def _values(cell: Cell, start: Target) -> Floats:
    """Return the joint values (dof,) of a start; :class:`OptionError` for a pose, which has several."""
    known = {HOME: tuple(cell.robot.home.tolist()), **cell.robot.states}
    if isinstance(start, Named) and start.text in known:
        start = Joints(known[start.text])
    if not isinstance(start, Joints) or len(start.values) != cell.robot.dof:
        raise OptionError(f"start must be ROBOT:STATE for each robot, or one state of all, got '{start.text[:100]}'.")
    return np.array(start.values)
