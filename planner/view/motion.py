"""A path as the page shows it: numbers, motion, w, the tool's ellipsoids, and the two worst points."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints, cumulative_sums
from planner.base.resolutions import CLEARANCES_OF_MOTION, SHOWN_STATES
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import Chain, tool_positions
from planner.kinematics.manipulability import jacobians, manipulability, unit_of
from planner.problem.outcome import Rows
from planner.robot.robot import Robot
from planner.trajectory.limits import KINDS
from planner.trajectory.measure import Nearest, dense_path, measure_path
from planner.trajectory.moving_obstacles import clearance_in_time
from planner.trajectory.trajectory import Trajectory

_SECONDS_PER_RADIAN = 0.8  # speed of the animation of a path without times
_SINGULAR = 1e9  # a larger condition number is infinite within rounding
_FINE = 1001  # samples of a motion for its lowest w
_APART = 0.1  # of the path: closer worst points are one


@dataclass(frozen=True, eq=False)
class ShownMotion:
    """A trajectory along a path, and its ``clearance`` (n,) m at evenly spaced times, if any is checked."""

    trajectory: Trajectory
    clearance: Floats | None

    @property
    def states(self) -> Floats:
        """States (n, dof) at evenly spaced times, dense enough for the picture of the tool's path."""
        return self.trajectory.at(np.linspace(self.trajectory.times[0], self.trajectory.times[-1], SHOWN_STATES))


def sample_motion(trajectory: Trajectory, checker: CollisionChecker) -> ShownMotion:
    """Return a trajectory with its clearance from start to end."""
    times = np.linspace(trajectory.times[0], trajectory.times[-1], CLEARANCES_OF_MOTION)
    clearance = clearance_in_time(trajectory, checker, times)
    return ShownMotion(trajectory, clearance if np.isfinite(clearance).all() else None)


@dataclass(frozen=True, eq=False)
class ShownPath:
    """A path (k, dof) rad with its rows of numbers and, if known, its betas and the cost-to-go (n,).

    ``costs``: Omega and D. A path with costs but without an interval is non-dominated, yet optimal for no beta. A
    ``motion`` sets the times of the animation. ``choice`` holds gain and price of these betas, see
    :meth:`planner.tradeoff.record.IntervalNumbers.choice`. ``nearest`` is the smallest clearance of the path or its
    motion.
    """

    path: Floats
    numbers: Rows
    interval: tuple[float, float] | None = None
    cost_to_go: Floats | None = None
    costs: tuple[float, float] | None = None
    motion: ShownMotion | None = None
    choice: dict[str, Any] | None = None
    nearest: Nearest | None = None


def path_rows(robot: Robot, path: Floats, omega: float, distance: float) -> Rows:
    """Return the page's rows on a path: its two costs, mean w and lengths."""
    measures, unit = measure_path(robot, path), unit_of(robot)
    return [
        ("manipulability cost Ω", f"{omega:.4f}"),
        ("distance cost D", f"{distance:.4f}"),
        (f"w mean ({unit})", f"{measures.w_mean:.3g}"),
        ("joint motion", f"{measures.joint_length:.3f} rad"),
        ("tool's path", f"{measures.workspace_length:.3f} m"),
        ("waypoints", str(len(path))),
    ]


def motion_data(robot: Robot, shown: ShownPath) -> dict[str, Any]:
    """Return the data of the animation along a joint path (k, dof) of one configuration or more.

    With a motion, its states at evenly spaced times replace the path's waypoints, and shares are of time.
    """
    path, motion = shown.path, shown.motion
    (shares, total), even = path_shares(path), np.linspace(0.0, 1.0, SHOWN_STATES)
    if motion is None:
        waypoints, states, fine = path, configurations_at(path, shares, even), dense_path(path)
        worst = find_worst_points(robot, fine, path_shares(fine)[0])
        seconds, in_time = max(2.0, total * _SECONDS_PER_RADIAN) if len(path) > 1 else 0.0, None
    else:
        waypoints = states = motion.states
        trajectory, shares, fine = motion.trajectory, even, np.linspace(0.0, 1.0, _FINE)
        worst = find_worst_points(robot, trajectory.at(trajectory.times[0] + fine * trajectory.duration), fine)
        seconds, in_time = trajectory.duration, _in_time(robot, motion)
    return {
        "waypoints": np.round(waypoints, 9).tolist(),
        "shares": shares.tolist(),
        "length": round(total, 6),
        "worst": worst,
        "seconds": seconds,
        "w": np.round(manipulability(robot, states), 7).tolist(),
        "condition": [None if value > _SINGULAR else value for value in _few_digits(robot.condition_number(states))],
        "ellipsoids": np.round(ellipsoids(robot, states[::2]), 4).tolist(),
        "clearance": None if motion is None or motion.clearance is None else np.round(motion.clearance, 5).tolist(),
        "nearest": None if shown.nearest is None else shown.nearest.to_dict(),
        "motion": in_time,
    }


def _in_time(robot: Robot, motion: ShownMotion) -> dict[str, Any]:
    """Return a motion's derivatives and tool speed (m/s) at evenly spaced times, and the joints' limits."""
    trajectory, limits = motion.trajectory, motion.trajectory.limits
    times = np.linspace(trajectory.times[0], trajectory.times[-1], SHOWN_STATES)
    rates = {kind: trajectory.at(times, order) for order, kind in enumerate(KINDS, start=1)}
    moving = np.einsum("nij,nj->ni", robot.jacobian(motion.states)[:, :3], rates["velocity"])
    return {
        "begin": float(trajectory.times[0]),
        "duration": trajectory.duration,
        "proven": trajectory.proven,
        "limits": None if limits is None else limits.to_dict(),
        "tool_speed": _few_digits(np.linalg.norm(moving, axis=1)),
        **{kind: [_few_digits(row) for row in values.T] for kind, values in rates.items()},
    }


def _few_digits(values: Floats) -> list[float]:
    return [float(f"{value:.4g}") for value in values.tolist()]


def chain_data(robot: Robot) -> dict[str, Any]:
    """Return the joint tree of :class:`~planner.kinematics.forward.Chain`, and the tool's offset."""
    chain, frame = Chain.from_arm(robot), robot.model.frames[robot.tool_id]
    return {
        "parent": chain.parent.tolist(),
        "leader": chain.leader.tolist(),
        "factor": chain.factor.tolist(),
        "zero": chain.zero.tolist(),
        "rotations": chain.rotations.reshape(-1, 3, 9).tolist(),
        "offset": chain.offset.tolist(),
        "slide": chain.slide.tolist(),
        "prismatic": chain.prismatic.tolist(),
        "tool": {"parent": int(frame.parentJoint), "offset": frame.placement.translation.tolist()},
    }


def joint_data(robot: Robot) -> dict[str, Any]:
    """Return names and limits of the planned joints; a continuous joint has none."""
    return {
        "names": list(robot.joints),
        "lower": robot.lower.tolist(),
        "upper": robot.upper.tolist(),
        "free": robot.continuous.tolist(),
        "unit": ["m" if slides else "rad" for slides in robot.prismatic],
    }


def path_shares(path: Floats) -> tuple[Floats, float]:
    """Return the share (k,) of the joint motion at each row of a path, and the total motion (rad)."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    along = cumulative_sums(steps)
    total = float(along[-1])
    return along / total if total > 0 else 0.0 * along, total


def configurations_at(path: Floats, shares: Floats, requested: Floats) -> Floats:
    """Return configurations (n, dof) at the ``requested`` shares (n,) of a path's joint motion."""
    return np.column_stack([np.interp(requested, shares, column) for column in path.T])


def ellipsoids(robot: Robot, q: Floats) -> Floats:
    """Return xx, yy, zz, xy, xz, yz (n, 6) of (J Jᵀ)^½, J the linear rows of the tool's Jacobian (m/rad).

    It maps the unit ball onto the tool velocities at joint velocities of norm 1: Yoshikawa's manipulability ellipsoid
    of the translation. Planar robots have a flat one.
    """
    linear = np.zeros((len(q), 3, robot.dof))
    rows = jacobians(robot, q)[:, :3]
    linear[:, : rows.shape[1]] = rows
    u, s, _ = np.linalg.svd(linear, full_matrices=False)
    root = np.einsum("nij,nj,nkj->nik", u, s, u)
    return root[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def find_worst_points(robot: Robot, q: Floats, shares: Floats) -> list[dict[str, Any]]:
    """Return the two lowest local minima of w over states ``q`` (n, dof) at ``shares`` (n,), or ends.

    The lowest comes first; each has its ``share``, ``w`` and the tool's ``position`` (m).
    """
    w, chosen = manipulability(robot, q), list[int]()
    for row in _local_minima(w):
        if len(chosen) < 2 and all(abs(shares[row] - shares[other]) > _APART for other in chosen):
            chosen.append(int(row))
    places = tool_positions(robot, q[chosen]).tolist()
    rows = zip(chosen, places, strict=True)
    return [{"share": float(shares[row]), "w": float(w[row]), "position": place} for row, place in rows]


def _local_minima(values: Floats) -> Ints:
    """Return the rows of the local minima, the lowest first; equal neighbours count as their first row."""
    rows = np.nonzero(np.concatenate([[True], np.diff(values) != 0]))[0]
    padded = np.concatenate([[np.inf], values[rows], [np.inf]])
    lowest = rows[(padded[1:-1] < padded[:-2]) & (padded[1:-1] < padded[2:])]
    return lowest[np.argsort(values[lowest], kind="stable")]
