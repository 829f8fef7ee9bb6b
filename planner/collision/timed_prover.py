"""Proofs in time: motions among obstacles that move along known motions, or anywhere within their speed limits.

In time a pair's distance changes at most by what the joints and the obstacle move: the rate of a proof grows by the
obstacle's speed. Of one whose motion is unknown all is free that it cannot have reached by then. The same loop as
without time, ``native/source/prover.hpp``, and the same geometry.
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
    """Proves motions of one robot in time against some obstacles, and against nothing else.

        prover = TimedProver(checker, scene.moving)
        prover.free(coefficients, spans)       # (m,) which pieces are proven, each begun when its span says

    ``moving`` have known motions, ``limited`` are where they are at time 0 and have speed limits. The checker's margin
    is kept. Proofs are of surfaces: what lies inside a closed mesh at time 0 is asked of :meth:`starts`, and stays so
    along whatever is proven from there on.
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
        """When (s) the last of the known motions has ended."""
        return max((motion.end for motion in self.motions.values()), default=0.0)

    def free(self, coefficients: Floats, spans: Floats, room: float = PROOF) -> Bools:
        """(m,) which polynomial pieces (m, degree + 1, dof) are proven free.

        ``spans`` (m, 3) s: when a piece begins, how long it takes, and by how much it may begin sooner or later.
        """
        return self.prove(coefficients, spans, room)[0] == Verdict.FREE

    def prove(self, coefficients: Floats, spans: Floats, room: float = PROOF) -> tuple[Ints, Ints]:
        """Verdicts (m,), free or undecided, and the pairs (m,) that stopped them; as :meth:`free`."""
        verdict, pair, *_ = self._bound.native.prove(self._bounds, coefficients, room, spans)
        return verdict, pair

    def starts(self, q: Floats) -> bool:
        """Whether the configuration (dof,) is outside of every closed mesh at time 0, and holds none inside."""
        return bool((self._inside.pairs(q[None]) < 0).all())

    def gaps(self, q: Floats) -> Floats:
        """(pairs,) lower bounds (m) on distances beyond the margin, of a configuration (dof,) at time 0."""
        rotation, position = joint_placements(self._chain, q[None])
        pairs = np.flatnonzero(~self._left_out)
        gaps = np.full(len(self._left_out), np.inf)
        gaps[pairs] = self._bound.close(rotation, position, np.zeros_like(pairs), pairs) - self.world.margin
        return gaps


def moving_world(world: World, obstacles: Sequence[Obstacle]) -> World:
    """The world of the same robot and permissions among other ``obstacles``, without pairs of its own links."""
    scene = Scene(world.scene.name, tuple(obstacles), allowed=world.scene.allowed)
    whole = World.of(world.robot, scene, frozenset(), world.margin)
    return replace(whole, self_pairs=whole.self_pairs[:0])
