"""Questions about a configuration or a motion among obstacles. Start with :func:`make_checker`."""

from collections.abc import Sequence
from functools import lru_cache

from planner.base.errors import OptionError, choices
from planner.collision.checker import CollisionChecker
from planner.collision.self_pairs import compute_disabled_pairs
from planner.collision.world import World
from planner.constraints.path_constraints import require_orientations
from planner.problem.conditions import Condition, read_conditions
from planner.problem.request import WorldRequest
from planner.robot.robot import Robot
from planner.robot.robot_in_scene import resolve_frames
from planner.robot.scene import Scene

BACKENDS = ("fcl", "coal")


def make_checker(
    robot: Robot,
    scene: Scene | None,
    backend: str = "fcl",
    margin: float = 0.0,
    constraint: str | Condition | Sequence[str | Condition] = (),
) -> CollisionChecker:
    """A collision checker of ``robot`` among the scene's obstacles, where it is None among none.

    ``margin`` (m) is a distance to keep from everything: what comes closer counts as a collision. Link pairs that need
    no check come from the robot (its SRDF or robot file), else they are worked out. The ``backend`` says what touches;
    proofs of whole motions, :class:`planner.collision.edge_prover.EdgeProver`, rest on planes of our own. What motions
    ``constraint`` besides is proven with them; limits of joints are the robot's.
    """
    kind = _backend(backend)
    conditions = read_conditions(constraint)
    WorldRequest(margin=margin)  # refuses a margin out of range
    require_orientations(conditions, robot)
    disabled, made = robot.disabled_pairs, None
    if disabled is None:
        disabled, made = compute_disabled_pairs(robot, kind)
    return kind(World.of(robot, resolve_frames(Scene.load(scene), robot), disabled, margin, conditions), made)


def second_checker(checker: CollisionChecker) -> CollisionChecker:
    """A checker by coal in the world of ``checker``; ``checker`` itself where it is coal.

    Coal is quick, and shares no code with our proofs, nor with FCL: it checks finished paths once more.
    """
    return checker if checker.name == "coal" else _by_coal(checker)


@lru_cache(maxsize=8)
def _by_coal(checker: CollisionChecker) -> CollisionChecker:
    from planner.collision.coal import CoalChecker

    known = checker.second[-1] if checker.second else None
    made = CoalChecker(checker.world, known if isinstance(known, CoalChecker) else None, checker.bound)
    checker.second[:] = [made]
    return made


def coal_checker(world: World, known: CollisionChecker | None = None) -> CollisionChecker:
    """A checker by coal of any world, one with some of the pairs only included; ``known``: by coal in one like it."""
    return _backend("coal")(world, known)


def _backend(name: str) -> type[CollisionChecker]:
    if name == "fcl":
        from planner.collision.fcl import FclChecker

        return FclChecker
    if name == "coal":
        from planner.collision.coal import CoalChecker

        return CoalChecker
    raise OptionError(f"collision backend '{name}' not found; backends are {choices(BACKENDS)}.")
