"""Forward kinematics of many configurations at once, in NumPy.

Pinocchio answers one configuration a call; proving edges asks for thousands, so the chain's placements are
evaluated for a whole batch here. The tests hold it against Pinocchio.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.world.robot import Robot

_ROWS = 2048  # configurations at a time: what is worked on stays in cache, which takes a quarter of the time


@dataclass(frozen=True, eq=False)
class Chain:
    """The joint tree of a robot as arrays; row j describes joint j + 1 of the Pinocchio model.

    Joint j's placement in its parent is P (C0 + sin q C1 + (1 - cos q) C2) with P the fixed placement's rotation
    (Rodrigues' formula), or P and a shift q along ``slide`` where it is prismatic.
    """

    parent: Ints  # (dof,) Pinocchio joint index, 0 the base
    rotations: Floats  # (dof, 3, 3, 3): C0, C1, C2
    offset: Floats  # (dof, 3), in the parent's frame
    axis: Floats  # (dof, 3), in the joint's own frame
    slide: Floats  # (dof, 3), in the parent's frame
    prismatic: Bools  # (dof,)

    @staticmethod
    def of(robot: Robot) -> Chain:
        """The joint tree of ``robot``, its base placement included."""
        model = robot.model
        data = model.createData()
        joints = range(1, model.njoints)
        prismatic = robot.prismatic
        axes = np.array([_axis(model, data, joint, bool(prismatic[joint - 1])) for joint in joints])
        placements = [model.jointPlacements[joint] for joint in joints]
        return Chain(
            parent=frozen([model.parents[joint] for joint in joints], np.int64),
            rotations=frozen([_rodrigues(p.rotation, a) for p, a in zip(placements, axes, strict=True)]),
            offset=frozen([p.translation for p in placements]),
            axis=frozen(axes),
            slide=frozen([p.rotation @ a for p, a in zip(placements, axes, strict=True)]),
            prismatic=frozen(prismatic, np.bool_),
        )


def joint_placements(chain: Chain, q: Floats) -> tuple[Floats, Floats]:
    """World rotations (joints + 1, n, 3, 3) and positions (joints + 1, n, 3) of every joint frame; row 0 is the base.

    ``q`` is (n, dof).
    """
    n, dof = q.shape
    rotation = np.empty((dof + 1, n, 3, 3))
    position = np.zeros((dof + 1, n, 3))
    rotation[0] = np.eye(3)
    sine, versine = np.sin(q), 1.0 - np.cos(q)
    for j in range(dof):
        parent = chain.parent[j]
        position[j + 1] = position[parent] + rotation[parent] @ chain.offset[j]
        if chain.prismatic[j]:
            position[j + 1] += (rotation[parent] @ chain.slide[j]) * q[:, j, None]
            rotation[j + 1] = rotation[parent] @ chain.rotations[j, 0]
            continue
        c0, c1, c2 = chain.rotations[j]
        local = c0 + sine[:, j, None, None] * c1 + versine[:, j, None, None] * c2
        np.matmul(rotation[parent], local, out=rotation[j + 1])
    return rotation, position


def tool_positions(robot: Robot, q: Floats, chain: Chain | None = None) -> Floats:
    """Positions (n, 3) of the tool frame in the world (m) for configurations (n, dof)."""
    chain, q = chain or Chain.of(robot), np.atleast_2d(q)
    parts = np.array_split(q, max(1, len(q) // _ROWS))
    return np.concatenate([_tool_positions(robot, part, chain) for part in parts])


def _tool_positions(robot: Robot, q: Floats, chain: Chain) -> Floats:
    frame = robot.model.frames[robot.tool_id]
    point = np.tile(frame.placement.translation, (len(q), 1))
    joint = int(frame.parentJoint)
    while joint > 0:  # from the tool to the base, so that only a point is turned, never a frame
        row, joint = joint - 1, int(chain.parent[joint - 1])
        if chain.prismatic[row]:
            point = point @ chain.rotations[row, 0].T + chain.slide[row] * q[:, row, None]
        else:
            turned = (point @ chain.rotations[row].reshape(9, 3).T).reshape(-1, 3, 3)
            point = turned[:, 0] + np.sin(q[:, row, None]) * turned[:, 1]
            point += (1.0 - np.cos(q[:, row, None])) * turned[:, 2]
        point += chain.offset[row]
    return point


def tool_pose(robot: Robot, q: Floats) -> pin.SE3:
    """The tool frame's placement in the world for one configuration (dof,)."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, np.asarray(q, dtype=float))
    return data.oMf[robot.tool_id].copy()


def _axis(model: pin.Model, data: pin.Data, joint: int, prismatic: bool) -> Floats:
    """The unit direction that a joint turns about or slides along, in its own frame."""
    q = pin.neutral(model)
    pin.computeJointJacobians(model, data, q)
    jacobian = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL).reshape(6, model.nv)
    column = jacobian[:, model.joints[joint].idx_v]
    return column[:3] if prismatic else column[3:]


def _rodrigues(placement: Floats, axis: Floats) -> Floats:
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.array([placement, placement @ cross, placement @ cross @ cross])
