"""Proofs in time, among obstacles with known motions or with speed limits.

The rate of a pair's distance grows by the obstacle's speed. An obstacle with a speed limit may be anywhere it can reach
by that time. The loop is the same as without time: ``native/source/prover.hpp``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.resolutions import PROOF
from planner.collision.bounds import ClearanceBound
from planner.collision.checker import CollisionChecker
from planner.collision.containment import Containment
from planner.collision.edge_prover import Verdict
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle


class TimedProver:
    """Proofs of motions in time against some obstacles only.

        prover = TimedProver(checker, scene.moving)
        prover.free(coefficients, spans)       # (m,) which curves are proven, begun at the times of their spans

    ``moving`` obstacles have known motions; ``limited`` ones are at their placements at time 0 and have speed limits.
    The checker's margin applies. Proofs cover surfaces: :meth:`starts` checks enclosure at time 0, which holds along
    proven motions.
    """

    def __init__(
        self, checker: CollisionChecker, moving: Sequence[MovingObstacle] = (), limited: Sequence[Obstacle] = ()
    ) -> None:
        motions = {item.name: item.motion for item in moving}
        self.world = moving_world(checker.world, (*(item.standing() for item in moving), *limited))
        self.motions: Mapping[str, KnownMotion] = motions
        self._bound = ClearanceBound(self.world, motions=motions)
        self._chain = checker.chain
        self._left_out = ~self.world.checked.ravel()
        native = self._bound.native
        self._bounds = native.bounds(self.world.pair_reach, self.world.reach.bodies, self._left_out)
        self._inside = Containment(self.world, checker.chain)

    @property
    def robot(self) -> Robot:
        return self.world.robot

    @property
    def end(self) -> float:
        """Time (s) at which the last known motion ends."""
        return max((motion.end for motion in self.motions.values()), default=0.0)

    def free(self, coefficients: Floats, spans: Floats, resolution: float = PROOF) -> Bools:
        """Return which curves (m, degree + 1, dof) are proven free, (m,).

        ``spans`` (m, 3) s: begin, duration, and the tolerance of the begin.
        """
        return self.prove(coefficients, spans, resolution)[0] == Verdict.FREE

    def prove(self, coefficients: Floats, spans: Floats, resolution: float = PROOF) -> tuple[Ints, Ints]:
        """Return verdicts (m,), free or undecided, and the pairs (m,) that stopped them."""
        verdict, pair, *_ = self._bound.native.prove(self._bounds, coefficients, resolution, spans)
        return verdict, pair

    def starts(self, q: Floats) -> bool:
        """Return whether the configuration (dof,) encloses nothing and is enclosed by nothing at time 0."""
        return bool((self._inside.pairs(q[None]) < 0).all())

    def gaps(self, q: Floats) -> Floats:
        """Return lower bounds (pairs,) m on distances beyond the margin, in a configuration (dof,) at time 0."""
        rotation, position = joint_placements(self._chain, q[None])
        pairs = np.flatnonzero(~self._left_out)
        gaps = np.full(len(self._left_out), np.inf)
        gaps[pairs] = self._bound.close(rotation, position, np.zeros_like(pairs), pairs) - self.world.margin
        return gaps


def moving_world(world: World, obstacles: Sequence[Obstacle]) -> World:
    """Return the world of the same robot among other ``obstacles``, without self-collision pairs."""
    scene = Scene(world.scene.name, tuple(obstacles), allowed=world.scene.allowed)
    whole = World.from_scene(world.robot, scene, frozenset(), world.margin)
    return replace(whole, self_pairs=whole.self_pairs[:0])
