"""How far any point of a link can be from a joint's axis: the factor between joint motion and motion in the room.

Joints are those of a :class:`~planner.kinematics.forward.Chain`, which include joints that follow planned ones.
Turning joint j by dq moves no point of a link further than R_j |dq|, with R_j the link's reach from that axis, and
a sum over the joints bounds the motion along any straight joint-space segment (Schwarzer, Saha and Latombe 2005).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from planner.base.arrays import Floats, dot, frozen, length, product
from planner.kinematics.forward import Chain, travel
from planner.robot.robot import Robot
from planner.robot.shapes import Body, max_distance_from_axis, max_distance_from_origin


@dataclass(frozen=True, eq=False)
class Reach:
    """``bodies`` (n_bodies, joints): metres a point of the body moves at most per unit of each joint (0: not carried).

    Valid for every configuration within the joint limits.
    """

    bodies: Floats
    chain: Chain

    @staticmethod
    def from_robot(robot: Robot, bodies: tuple[Body, ...] | None = None) -> Reach:
        """Reach of the robot's own bodies, or of any others that its joints carry."""
        if bodies is None:
            return _own_reach(robot)
        chain, reach = Chain.from_arm(robot), [_reach_of(robot.without_payload, body) for body in bodies]
        return Reach(frozen(np.reshape(reach, (len(bodies), len(chain.parent)))), chain)

    def motion(self, delta: Floats) -> Floats:
        """The most that any point of each body moves (m), (n, n_bodies), along joint segments ``delta`` (n, dof)."""
        return product(self.chain.sizes(delta), self.bodies.T)

    def relative(self, pairs: np.ndarray) -> Floats:
        """(n_pairs, joints): the same for one body seen from another; joints that carry both do not count."""
        first, second = self.bodies[pairs[:, 0]], self.bodies[pairs[:, 1]]
        return np.where((first > 0) & (second > 0), 0.0, first + second)


@lru_cache(maxsize=16)
def _own_reach(robot: Robot) -> Reach:
    """Kept, as a world that changes asks for the same robot's again and again."""
    return Reach.from_robot(robot, robot.bodies)


@lru_cache(maxsize=2048)
def _reach_of(robot: Robot, body: Body) -> Floats:
    """Walking down from the body: the distance from a joint's origin to the body's farthest point, never too small."""
    chain = Chain.from_arm(robot)
    reach = np.zeros(len(chain.parent))
    if body.joint == 0:
        return frozen(reach)
    joint = body.joint - 1
    radius = max_distance_from_origin(body.shape, body.placement)
    across = max_distance_from_axis(body.shape, body.placement, chain.axis[joint])
    while True:
        # a tiny positive reach marks "carried" even for a body that lies on the axis
        reach[joint] = 1.0 if chain.prismatic[joint] else max(across, 1e-12)
        radius += travel(robot, chain, joint)
        parent = int(chain.parent[joint]) - 1
        if parent < 0:
            return frozen(reach)
        offset, axis = chain.offset[joint], chain.axis[parent]
        across = radius + length(offset - dot(offset, axis) * axis)
        radius += length(offset)
        joint = parent


def pair_reach(robot: Robot, first: Body, second: Body) -> Floats:
    """(joints,) metres by which a joint's motion can change the distance of two bodies at most, per unit of each joint.

    Where the first hangs above the second, a joint between them as well moves the one as seen from the other: whichever
    body reaches less far from its axis bounds the change. So it is never more than :meth:`Reach.relative`.
    """
    return _pair_reach(robot.without_payload, first, second)


@lru_cache(maxsize=2048)
def _pair_reach(robot: Robot, first: Body, second: Body) -> Floats:
    reach = Reach.from_robot(robot, (first, second)).relative(np.array([[0, 1]]))[0]
    chain, radius = Chain.from_arm(robot), 0.0
    for number, joint in enumerate(_joints_down_to(chain, first.joint, second.joint)):
        if number == 0:
            across, radius = _from_below(robot, first, joint)
        else:
            radius += length(chain.offset[joint - 1])
            across = radius
        if not chain.prismatic[joint - 1]:
            reach[joint - 1] = min(reach[joint - 1], max(across, 1e-12))
        radius += travel(robot, chain, joint - 1)
    return frozen(reach)


@lru_cache(maxsize=2048)
def _from_below(robot: Robot, body: Body, joint: int) -> tuple[float, float]:
    """How far a body is at most from the axis and the origin of the ``joint`` below the one that carries it."""
    turned = robot.model.jointPlacements[joint].inverse().homogeneous @ body.placement
    axis = Chain.from_arm(robot).axis[joint - 1]
    return max_distance_from_axis(body.shape, turned, axis), max_distance_from_origin(body.shape, turned)


def _joints_down_to(chain: Chain, top: int, joint: int) -> list[int]:
    """The joints below ``top`` on the way down to ``joint``; none where that does not hang below it."""
    joints = []
    while joint not in (top, 0):
        joints.insert(0, joint)
        joint = int(chain.parent[joint - 1])
    return joints if joint == top else []
