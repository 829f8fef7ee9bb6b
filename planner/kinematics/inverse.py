"""Inverse kinematics by damped least squares from many seeded starts (Wampler 1986; Nakamura and Hanafusa 1986)."""

from __future__ import annotations

from dataclasses import dataclass

import eigenpy
import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats
from planner.base.products import dot, length, product
from planner.kinematics.forward import Chain, joint_placements
from planner.world.robot import Robot

POSITION_TOLERANCE = 1e-6  # m
ANGLE_TOLERANCE = 1e-6  # rad
_STEP = 0.5  # rad, the largest joint step of one iteration
_DAMPING = 1e-3  # at the start; it falls tenfold with every step that comes nearer


@dataclass(frozen=True, eq=False)
class Solutions:
    """What inverse kinematics found; rows are distinct and in the order in which they were found."""

    configurations: Floats  # (k, dof)
    nearest: Floats  # (dof,) the configuration that came nearest, a solution if there is one
    distance: float  # m, tool to target at ``nearest``
    angle: float  # rad, between the tool's and the target's orientation; 0 for a position


def solve_position(
    robot: Robot, position: Floats, rng: np.random.Generator, starts: int, near: Floats | None = None
) -> Solutions:
    """Configurations within limits that bring the tool's origin to ``position`` (m, world).

    From ``starts`` seeds all over the joint space, and from the configurations ``near`` (k, dof).
    """
    return _solve(robot, pin.SE3(np.eye(3), np.asarray(position, dtype=float)), False, rng, starts, near)


def solve_pose(
    robot: Robot, target: pin.SE3, rng: np.random.Generator, starts: int, near: Floats | None = None
) -> Solutions:
    """Configurations within limits that bring the tool frame to ``target``, as :func:`solve_position` finds them."""
    return _solve(robot, target, True, rng, starts, near)


def beyond_reach(robot: Robot, position: Floats) -> float:
    """How far (m) ``position`` lies outside a sphere that the tool cannot leave; 0 inside it.

    This is a proof, not an estimate: the sphere's centre is a joint whose origin does not move, and its radius is the
    sum of the chain's offsets from there to the tool.
    """
    model, chain = robot.model, Chain.of(robot)
    frame = model.frames[robot.tool_id]
    _, home = joint_placements(chain, np.zeros((1, robot.dof)))
    joint, total = int(frame.parentJoint), length(frame.placement.translation)
    best = 0.0
    while joint:
        # an offset along the first axis does not turn with it: the sphere around joint 2's origin is often smaller
        if _origin_is_fixed(chain, joint):
            with np.errstate(over="ignore"):
                apart = length(np.asarray(position) - home[joint, 0])
            best = max(best, apart - total)
        row = joint - 1
        slide = max(abs(robot.lower[row]), abs(robot.upper[row])) if chain.prismatic[row] else 0.0
        total += length(chain.offset[row]) + float(slide)
        joint = int(chain.parent[row])
    return best


def _origin_is_fixed(chain: Chain, joint: int) -> bool:
    """Whether a joint's origin cannot move: it is the first joint's, or lies on the axis of a first, revolute joint."""
    parent = int(chain.parent[joint - 1])
    if parent == 0:
        return not chain.prismatic[joint - 1]
    if int(chain.parent[parent - 1]) != 0 or chain.prismatic[parent - 1] or chain.prismatic[joint - 1]:
        return False
    offset, axis = chain.offset[joint - 1], chain.axis[parent - 1]
    return bool(length(offset - dot(offset, axis) * axis) < 1e-9)


def _solve(
    robot: Robot, target: pin.SE3, oriented: bool, rng: np.random.Generator, starts: int, near: Floats | None
) -> Solutions:
    seeds = np.vstack([robot.home, rng.uniform(robot.lower, robot.upper, size=(starts - 1, robot.dof))])
    if near is not None:
        seeds = np.vstack([seeds, near])
    task = _Task(robot, target, oriented)
    with np.errstate(over="ignore"):  # a target that is inf squared metres away is out of reach, as the caller will say
        ends = [task.descend(seed) for seed in seeds]
        errors = np.array([task.error_norms(q) for q in ends])
    nearest = int(np.argmin(errors[:, 0] + 0.1 * errors[:, 1]))  # 0.1 m/rad weighs an angle against a distance
    solved = (errors[:, 0] <= POSITION_TOLERANCE) & (errors[:, 1] <= ANGLE_TOLERANCE)
    found = _distinct(robot, np.array(ends)[solved])
    return Solutions(found, ends[nearest], float(errors[nearest, 0]), float(errors[nearest, 1]))


def _distinct(robot: Robot, found: Floats, apart: float = 1e-3) -> Floats:
    kept: list[Floats] = []
    for q in found:
        if all(np.abs(robot.difference(q, other)).max() > apart for other in kept):
            kept.append(robot.normalise(q))
    return np.array(kept).reshape(-1, robot.dof)


class _Task:
    """One target: its error in the tool's own axes, and the descent to it from a seed."""

    def __init__(self, robot: Robot, target: pin.SE3, oriented: bool, iterations: int = 100) -> None:
        self.robot, self.target, self.oriented, self.iterations = robot, target, oriented, iterations
        self.data = robot.model.createData()
        self.frame = robot.tool_id

    def error(self, q: Floats) -> tuple[Floats, Floats]:
        """The task error e and its Jacobian J, with de = J dq: 3 rows for a position, 6 for a pose."""
        model, data = self.robot.model, self.data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacement(model, data, self.frame)
        jacobian = pin.getFrameJacobian(model, data, self.frame, pin.ReferenceFrame.LOCAL)
        miss = self.target.actInv(data.oMf[self.frame])  # the tool seen from the target
        if not self.oriented:
            return miss.translation.copy(), product(miss.rotation, jacobian[:3])
        return pin.log6(miss).vector, product(pin.Jlog6(miss), jacobian)

    def error_norms(self, q: Floats) -> tuple[float, float]:
        pin.framesForwardKinematics(self.robot.model, self.data, q)
        tool = self.data.oMf[self.frame]
        turn = pin.log3(product(self.target.rotation.T, tool.rotation)) if self.oriented else np.zeros(3)
        return length(tool.translation - self.target.translation), length(turn)

    def descend(self, seed: Floats) -> Floats:
        """Levenberg-Marquardt: a step that does not come nearer is taken back and damped more."""
        q, (error, jacobian) = np.array(seed), self.error(seed)
        size, damping = dot(error, error), _DAMPING
        for _ in range(self.iterations):
            if size < (0.1 * POSITION_TOLERANCE) ** 2 or damping > 1e6:
                break
            moved = self._step(q, error, jacobian, damping)
            error_there, jacobian_there = self.error(moved)
            size_there = dot(error_there, error_there)
            if size_there < size:
                q, error, jacobian, size = moved, error_there, jacobian_there, size_there
                damping *= 0.1
            else:
                damping = max(10.0 * damping, 1e-6)
        return q

    def _step(self, q: Floats, error: Floats, jacobian: Floats, damping: float) -> Floats:
        damped = product(jacobian, jacobian.T) + (damping + 1e-14) * np.eye(len(error))
        step = product(-eigenpy.LDLT(damped).solve(error), jacobian)  # Eigen has one code for all processors
        step *= min(1.0, _STEP / max(float(np.abs(step).max()), 1e-12))
        robot, moved = self.robot, q + step
        return np.where(robot.continuous, moved, np.clip(moved, robot.lower, robot.upper))
