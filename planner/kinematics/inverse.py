"""Inverse kinematics by damped least squares from many seeds.

Wampler 1986; Nakamura and Hanafusa 1986.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, dot, length
from planner.kinematics.arm import Arm
from planner.kinematics.forward import Chain, joint_placements, tool_joint, travel

POSITION_TOLERANCE = 1e-6  # m
ANGLE_TOLERANCE = 1e-6  # rad: solutions are exact to these
Tolerance: TypeAlias = tuple[float, float]  # m, rad
TOLERANCE: Tolerance = (1e-6, 1e-4)  # poses that an arm cannot reach exactly are reached within these
_ITERATIONS = 100
_ARM = 0.1  # m/rad: weighs angles against metres
_APART = 1e-3  # rad: nearer solutions count as one


@dataclass(frozen=True, eq=False)
class Solutions:
    """Distinct solutions of inverse kinematics in the order of their seeds, and the nearest configuration."""

    configurations: Floats  # (k, dof)
    nearest: Floats  # (dof,) the configuration nearest to the target, a solution if there is one
    distance: float  # m, tool to target at ``nearest``
    angle: float  # rad, between the tool's and the target's orientation; 0 for a position


Target: TypeAlias = pin.SE3 | Floats  # a pose, or a position (3,)


def solve(
    arm: Arm,
    target: Target | Sequence[Target],
    rng: np.random.Generator,
    starts: int,
    near: Floats | None = None,
    tolerance: Tolerance = TOLERANCE,
) -> Solutions:
    """Return configurations within limits that bring the tool frame to a pose or a position (3,).

    The ``target`` is in the world; several, one for each of ``arm.tools``, are reached at once. Descents begin at
    ``starts`` seeds all over the joint space, and at ``near`` (k, dof). Where none reaches a pose exactly, as with
    fewer than six axes, those that bring the tool within the ``tolerance``.
    """
    seeds = np.vstack([arm.home, rng.uniform(arm.lower, arm.upper, size=(starts - 1, arm.dof))])
    if near is not None:
        seeds = np.vstack([seeds, near])
    wanted = [target] if isinstance(target, pin.SE3 | np.ndarray) else list(target)
    oriented = [isinstance(each, pin.SE3) for each in wanted]
    places = np.array([_matrix(each) for each in wanted])
    targets = np.broadcast_to(places, (len(seeds), len(places), 4, 4))
    within = tolerance if any(oriented) else None
    ends, distance, angle, configurations = solve_within(arm, targets, seeds, within, oriented)
    # a target that is inf metres away is out of reach, as the caller will say
    off = np.nan_to_num(distance + _ARM * angle, nan=np.inf)
    nearest = int(np.argmin(off))
    distinct = distinct_configurations(arm, ends[configurations])
    return Solutions(distinct, ends[nearest], float(distance[nearest]), float(angle[nearest]))


def _matrix(target: Target) -> Floats:
    """Return the placement (4, 4) of a target, a position without a turn."""
    if isinstance(target, np.ndarray):
        return pin.SE3(np.eye(3), np.asarray(target, dtype=float)).homogeneous
    return target.homogeneous


def solve_each(
    arm: Arm,
    targets: Floats,
    seeds: Floats,
    turns_freely: bool = False,
    weight: float = 1.0,
    oriented: Sequence[bool] = (True,),
) -> tuple[Floats, Floats, Floats]:
    """Return the ends of descents from ``seeds`` (n, dof), each to its own target (n, 4, 4).

    Configurations (n, dof) within limits, and the errors (n,) m and rad of the tool there: a solution where they are
    within the tolerances. With ``turns_freely`` a turn about the tool's z axis is no error. Elsewhere a descent ends
    where ``weight`` times metres and radians are least in squares. Targets are those of the main tool; (n, k, 4, 4)
    those of all k tools, of which ``oriented`` tells whose orientation counts; the errors are those of the worst tool.
    """
    arms = arm.with_each_tool[:1] if targets.ndim == 3 else arm.with_each_tool
    joints, placements = zip(*map(tool_joint, arms), strict=True)
    places = np.array([place.homogeneous for place in placements])
    rows = np.where(oriented, 5 if turns_freely else 6, 3)
    limits = arm.lower, arm.upper, arm.continuous
    targets = np.ascontiguousarray(targets.reshape(len(targets), len(joints), 4, 4))
    return Chain.from_arm(arm).native.inverse(
        seeds, np.array(joints), places, rows, targets, limits, _ITERATIONS, weight
    )


def solve_within(
    arm: Arm, targets: Floats, seeds: Floats, tolerance: Tolerance | None, oriented: Sequence[bool] = (True,)
) -> tuple[Floats, Floats, Floats, Bools]:
    """Return as :func:`solve_each`, and which ends (n,) are solutions.

    Exact ones, else those within ``tolerance``: then the descents continue in units of it. None means positions only,
    exactly.
    """
    ends, distance, angle = solve_each(arm, targets, seeds, oriented=oriented)
    exact = (distance <= POSITION_TOLERANCE) & (angle <= ANGLE_TOLERANCE)
    if tolerance is None or exact.any():
        return ends, distance, angle, exact
    metres, radians = tolerance
    # the first descent minimises the sum of both squares; the factor 2 is for one that has not ended yet
    near = np.flatnonzero(np.hypot(distance, angle) <= 2.0 * np.hypot(metres, radians))
    again = solve_each(arm, targets[near], ends[near], weight=radians / metres, oriented=oriented)
    good = (again[1] <= metres) & (again[2] <= radians)
    for former, better in zip((ends, distance, angle), again, strict=True):
        former[near[good]] = better[good]
    return ends, distance, angle, (distance <= metres) & (angle <= radians)


def beyond_reach(arm: Arm, position: Floats) -> float:
    """Return the distance (m) of ``position`` from a sphere that the tool cannot leave; 0 inside it.

    This is a proof: the sphere's centre is a joint whose origin does not move, and its radius is the sum of the chain's
    offsets from there to the tool.
    """
    chain = Chain.from_arm(arm)
    _, home = joint_placements(chain, np.zeros((1, arm.dof)))
    joint, placement = tool_joint(arm)
    total, best = length(placement.translation), 0.0
    while joint:
        # an offset along the first axis does not turn with it: the sphere around joint 2's origin is often smaller
        if _has_fixed_origin(chain, joint):
            with np.errstate(over="ignore"):
                apart = length(np.asarray(position) - home[joint, 0])
            best = max(best, apart - total)
        row = joint - 1
        total += length(chain.offset[row]) + travel(arm, chain, row)
        joint = int(chain.parent[row])
    return best


def _has_fixed_origin(chain: Chain, joint: int) -> bool:
    """Return whether a joint's origin cannot move.

    It is the first joint's, or lies on the axis of a first, revolute joint.
    """
    parent = int(chain.parent[joint - 1])
    if parent == 0:
        return not chain.prismatic[joint - 1]
    if int(chain.parent[parent - 1]) != 0 or chain.prismatic[parent - 1] or chain.prismatic[joint - 1]:
        return False
    offset, axis = chain.offset[joint - 1], chain.axis[parent - 1]
    return bool(length(offset - dot(offset, axis) * axis) < 1e-9)


def distinct_configurations(arm: Arm, configurations: Floats, apart: float = _APART, most: float = np.inf) -> Floats:
    """Return the first ``most`` configurations of (n, dof) that are ``apart`` (rad, m) from all before."""
    distinct = np.empty((0, arm.dof))
    for q in configurations:
        if len(distinct) >= most:
            break
        if (np.abs(arm.difference(q, distinct)).max(axis=1, initial=0.0) > apart).all():
            distinct = np.vstack([distinct, arm.normalise(q)])
    return distinct
