"""Collision checks of configurations and proofs of motions. Start with :func:`make_checker`."""

from collections.abc import Sequence
from functools import lru_cache

from planner.base.errors import OptionError, choices
from planner.collision.checker import CollisionChecker
from planner.collision.self_filter import prepare_scene
from planner.collision.self_pairs import generate_disabled_pairs
from planner.collision.world import World
from planner.constraints.path_constraints import require_bound
from planner.problem.conditions import Condition, read_conditions
from planner.problem.request import WorldRequest
from planner.robot.robot import Robot
from planner.robot.scene import Scene

BACKENDS = ("fcl", "coal")


def make_checker(
    robot: Robot,
    scene: Scene | None,
    backend: str = "fcl",
    margin: float = 0.0,
    constraint: str | Condition | Sequence[str | Condition] = (),
) -> CollisionChecker:
    """Return a collision checker for ``robot`` among the obstacles of ``scene`` (None: no obstacles).

    A pair closer than ``margin`` (m) counts as a collision. Link pairs to ignore come from the SRDF or robot file;
    without these, they are computed by sampling. The ``backend`` decides contacts;
    :class:`planner.collision.edge_prover.EdgeProver` proves motions with separating planes of our own, and each
    ``constraint`` along them.
    """
    kind = _backend(backend)
    conditions = read_conditions(constraint)
    WorldRequest(margin=margin)  # refuses a margin out of range
    require_bound(conditions, robot)
    disabled = generate_disabled_pairs(robot, kind) if robot.disabled_pairs is None else robot.disabled_pairs
    return kind(World.from_scene(robot, prepare_scene(Scene.load(scene), robot), disabled, margin, conditions))


def second_checker(checker: CollisionChecker) -> CollisionChecker:
    """Return a coal checker for the same world, or ``checker`` itself if it is coal.

    Coal is fast and shares no code with our proofs or with FCL, so it rechecks finished paths independently.
    """
    return checker if checker.name == "coal" else _by_coal(checker)


@lru_cache(maxsize=8)
def _by_coal(checker: CollisionChecker) -> CollisionChecker:
    from planner.collision.coal import CoalChecker

    known = checker.second[-1] if checker.second else None
    new = CoalChecker(checker.world, known if isinstance(known, CoalChecker) else None, checker.bound)
    checker.second[:] = [new]
    return new


def coal_checker(world: World, known: CollisionChecker | None = None) -> CollisionChecker:
    """Return a coal checker for a world; ``known`` is a checker whose shapes it can share."""
    return _backend("coal")(world, known)


def _backend(name: str) -> type[CollisionChecker]:
    if name == "fcl":
        from planner.collision.fcl import FclChecker

        return FclChecker
    if name == "coal":
        from planner.collision.coal import CoalChecker

        return CoalChecker
    raise OptionError(f"collision backend '{name}' not found; backends are {choices(BACKENDS)}.")
