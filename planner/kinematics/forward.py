"""Forward kinematics of many configurations at once.

Pinocchio takes one configuration per call; proofs of edges need thousands, so compiled code evaluates the chain for a
whole batch. The tests compare it with Pinocchio.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.resolutions import TOOL_ALONG_EDGE
from planner.kinematics.arm import Arm, sliding_joints
from planner.native.compiled import NativeChain


@dataclass(frozen=True, eq=False)
class Chain:
    """The joint tree of an arm as arrays; row j describes joint j + 1 of the Pinocchio model.

    Its value is x_j = factor_j q_leader(j) + zero_j with q the values of the planned joints: factor 1 and zero 0 where
    it is planned, else it follows its leader, as ``<mimic>`` in a URDF. Its placement in its parent is P (C0 + sin x C1
    + (1 - cos x) C2) with P the fixed placement's rotation (Rodrigues' formula), or P and a shift x along ``slide``
    where it is prismatic. A path q(s) is a path x(s) of the tree: bounds on x hold for q.
    """

    parent: Ints  # (joints,) Pinocchio joint index, 0 the base
    rotations: Floats  # (joints, 3, 3, 3): C0, C1, C2
    offset: Floats  # (joints, 3), in the parent's frame
    axis: Floats  # (joints, 3), in the joint's own frame
    slide: Floats  # (joints, 3), in the parent's frame
    prismatic: Bools  # (joints,)
    leader: Ints  # (joints,) numbers of planned joints
    factor: Floats  # (joints,)
    zero: Floats  # (joints,) rad, m

    @cached_property
    def native(self) -> NativeChain:
        """The same tree in the compiled library."""
        tree = self.parent, self.prismatic, self.rotations, self.offset, self.slide, self.axis
        return NativeChain(*tree, (self.leader, self.factor, self.zero))

    def __getstate__(self) -> dict[str, object]:
        """Return the arrays alone: a copy builds the compiled tree again from them."""
        return {name: value for name, value in self.__dict__.items() if name != "native"}

    def values(self, q: Floats) -> Floats:
        """Return the values x (..., joints) of all joints at configurations (..., dof)."""
        return self.factor * q[..., self.leader] + self.zero if self.follows else q

    def sizes(self, delta: Floats) -> Floats:
        """Return the motion (..., joints) of all joints for a motion ``delta`` (..., dof) of the planned ones."""
        return np.abs(self.factor * delta[..., self.leader])

    @cached_property
    def dof(self) -> int:
        """The number of planned joints."""
        return int(self.leader.max()) + 1

    @property
    def follows(self) -> bool:
        """Whether some joint follows another."""
        return len(self.parent) > self.dof

    @cached_property
    def coupling(self) -> Floats:
        """(joints, dof) dx / dq: a Jacobian in x times this is one in q."""
        return self.factor[:, None] * (self.leader[:, None] == np.arange(self.dof))

    def ancestors(self, joint: int) -> list[int]:
        """Return ``joint`` and the joints that carry it, up to the base, which is not among them."""
        found = []
        while joint > 0:
            found.append(joint)
            joint = int(self.parent[joint - 1])
        return found

    @staticmethod
    def from_arm(arm: Arm) -> Chain:
        """Return the joint tree of ``arm``, its base placement included."""
        return Chain._make_chain(arm.without_payload)

    @staticmethod
    @lru_cache(maxsize=16)
    def _make_chain(arm: Arm) -> Chain:
        model = arm.model
        data = model.createData()
        joints, leader = range(1, model.njoints), np.zeros(model.njoints - 1, dtype=np.int64)
        prismatic, factor, zero = sliding_joints(model), np.ones(model.njoints - 1), np.zeros(model.njoints - 1)
        leader[arm.rows] = np.arange(arm.dof)
        for item in arm.followers:
            row = model.getJointId(item.joint) - 1
            leader[row], factor[row] = arm.joints.index(item.leader), item.multiplier
            zero[row] = item.offset
        axes = np.array([_axis(model, data, joint, bool(prismatic[joint - 1])) for joint in joints])
        placements = [model.jointPlacements[joint] for joint in joints]
        return Chain(
            parent=frozen([model.parents[joint] for joint in joints], np.int64),
            rotations=frozen([_rodrigues(p.rotation, a) for p, a in zip(placements, axes, strict=True)]),
            offset=frozen([p.translation for p in placements]),
            axis=frozen(axes),
            slide=frozen([p.rotation @ a for p, a in zip(placements, axes, strict=True)]),
            prismatic=frozen(prismatic, np.bool_),
            leader=frozen(leader, np.int64),
            factor=frozen(factor),
            zero=frozen(zero),
        )


def joint_placements(chain: Chain, q: Floats) -> tuple[Floats, Floats]:
    """Return world rotations (joints + 1, n, 3, 3) and positions (joints + 1, n, 3) of all joint frames.

    Row 0 is the base. ``q`` is (n, dof).
    """
    return chain.native.placements(q)


def tool_joint(arm: Arm) -> tuple[int, pin.SE3]:
    """Return the joint that carries the tool frame, 0 for the base, and the frame's placement in it."""
    frame = arm.model.frames[arm.tool_id]
    return int(frame.parentJoint), frame.placement


def tool_positions(arm: Arm, q: Floats) -> Floats:
    """Return the positions (n, 3) of the tool frame in the world (m) for configurations (n, dof)."""
    joint, placement = tool_joint(arm)
    return Chain.from_arm(arm).native.points(np.atleast_2d(q), joint, placement.translation)


def tool_path_lengths(arm: Arm, start: Floats, delta: Floats) -> Floats:
    """Return the lengths (n,) of the tools' paths (m) along straight motions ``delta`` (n, dof).

    They are sums of chords between states that are ``TOOL_ALONG_EDGE`` apart, and of all tools. ``start`` is (n, dof).
    """
    chords = np.maximum(1, np.ceil(np.abs(delta).sum(axis=1) / TOOL_ALONG_EDGE)).astype(np.int64)
    placed, native = map(tool_joint, arm.with_each_tool), Chain.from_arm(arm).native
    lengths = [native.path_lengths(start, delta, chords, joint, place.translation) for joint, place in placed]
    return np.sum(lengths, axis=0)


def tool_pose(arm: Arm, q: Floats) -> pin.SE3:
    """Return the tool frame's placement in the world for one configuration (dof,)."""
    data = arm.model.createData()
    pin.framesForwardKinematics(arm.model, data, Chain.from_arm(arm).values(np.asarray(q, dtype=float)))
    return data.oMf[arm.tool_id].copy()


def travel(arm: Arm, chain: Chain, row: int) -> float:
    """Return the longest travel (m) of the joint of ``row``: 0 for one that turns."""
    led = max(abs(arm.lower[chain.leader[row]]), abs(arm.upper[chain.leader[row]]))
    return float(abs(chain.factor[row]) * led + abs(chain.zero[row])) if chain.prismatic[row] else 0.0


def _axis(model: pin.Model, data: pin.Data, joint: int, prismatic: bool) -> Floats:
    """Return the unit axis of a joint in its own frame."""
    q = pin.neutral(model)
    pin.computeJointJacobians(model, data, q)
    jacobian = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL).reshape(6, model.nv)
    column = jacobian[:, model.joints[joint].idx_v]
    return column[:3] if prismatic else column[3:]


def _rodrigues(placement: Floats, axis: Floats) -> Floats:
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.array([placement, placement @ cross, placement @ cross @ cross])
