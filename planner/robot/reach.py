"""Reach of links from joint axes: the factor from joint motion to motion of points (m).

Joints are those of a :class:`~planner.kinematics.forward.Chain`, which includes joints that follow planned ones. A
rotation of joint j by dq moves no point of a link farther than R_j |dq|, where R_j is the link's reach from that axis;
the sum over joints bounds the motion along any straight joint segment (Schwarzer, Saha and Latombe 2005).
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
    """Largest motion (m) of each body's points per unit of each joint; 0 if not carried.

    Valid for all configurations within the joint limits. ``bodies`` is (n_bodies, joints).
    """

    bodies: Floats
    chain: Chain

    @staticmethod
    def from_robot(robot: Robot, bodies: tuple[Body, ...] | None = None) -> Reach:
        """Return the reach of the robot's own bodies, or of others that its joints carry."""
        if bodies is None:
            bodies = robot.bodies
        chain, reach = Chain.from_arm(robot), [_reach_of(robot.without_payload, body) for body in bodies]
        return Reach(frozen(np.reshape(reach, (len(bodies), len(chain.parent)))), chain)

    def motion(self, delta: Floats) -> Floats:
        """Return bounds (n, n_bodies) m on the motion of each body along joint segments ``delta`` (n, dof)."""
        return product(self.chain.sizes(delta), self.bodies.T)

    def relative(self, pairs: np.ndarray) -> Floats:
        """Return the reach (n_pairs, joints) of pairs; joints that carry both bodies do not count."""
        first, second = self.bodies[pairs[:, 0]], self.bodies[pairs[:, 1]]
        return np.where((first > 0) & (second > 0), 0.0, first + second)


@lru_cache(maxsize=2048)
def _reach_of(robot: Robot, body: Body) -> Floats:
    """Return the reach (joints,) of a body, by distances summed down the chain."""
    chain = Chain.from_arm(robot)
    reach = np.zeros(len(chain.parent))
    if body.joint == 0:
        return frozen(reach)
    joint = body.joint - 1
    radius = max_distance_from_origin(body.shape, body.placement)
    across = max_distance_from_axis(body.shape, body.placement, chain.axis[joint])
    while True:
        # a tiny positive reach marks a carried body that lies on the axis
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
    """Return bounds (joints,) m on the change of a pair's distance, per unit of each joint.

    If the first body hangs above the second, a joint between them is bounded by the smaller reach of the two bodies, so
    the result never exceeds :meth:`Reach.relative`.
    """
    return _pair_reach(robot.without_payload, first, second)


@lru_cache(maxsize=2048)
def _pair_reach(robot: Robot, first: Body, second: Body) -> Floats:
    reach = Reach.from_robot(robot, (first, second)).relative(np.array([[0, 1]]))[0]
    chain, radius = Chain.from_arm(robot), 0.0
    for number, joint in enumerate(_joints_between(chain, first.joint, second.joint)):
        if number == 0:
            across, radius = _reach_from_below(robot, first, joint)
        else:
            radius += length(chain.offset[joint - 1])
            across = radius
        if not chain.prismatic[joint - 1]:
            reach[joint - 1] = min(reach[joint - 1], max(across, 1e-12))
        radius += travel(robot, chain, joint - 1)
    return frozen(reach)


@lru_cache(maxsize=2048)
def _reach_from_below(robot: Robot, body: Body, joint: int) -> tuple[float, float]:
    """Return a body's largest distances from the axis and from the origin of the next joint below."""
    turned = robot.model.jointPlacements[joint].inverse().homogeneous @ body.placement
    axis = Chain.from_arm(robot).axis[joint - 1]
    return max_distance_from_axis(body.shape, turned, axis), max_distance_from_origin(body.shape, turned)


def _joints_between(chain: Chain, top: int, joint: int) -> list[int]:
    """Return the joints below ``top`` down to ``joint``; none if ``joint`` does not hang below it."""
    joints = []
    while joint not in (top, 0):
        joints.insert(0, joint)
        joint = int(chain.parent[joint - 1])
    return joints if joint == top else []
