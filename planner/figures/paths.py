"""Figures of paths, motions and their costs; imports matplotlib."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from planner.base.arrays import Floats, lengths_along, numbers
from planner.base.errors import OptionError
from planner.collision.checker import CollisionChecker
from planner.figures.style import (
    COLUMN,
    RAMP,
    SMALL,
    journal,
    label_axes,
    leave_headroom,
    sheet,
    single,
    stroke_with_markers,
)
from planner.kinematics.manipulability import manipulability as w_at
from planner.kinematics.manipulability import measure_name, unit_of
from planner.planning.result import Plan
from planner.problem.request import DEFAULT_MEASURE
from planner.robot.robot import Robot
from planner.tasks.result import TaskPlan
from planner.tradeoff.result import Interval, Tradeoff
from planner.trajectory.limits import KINDS
from planner.trajectory.measure import NOTHING_NEAR, dense_path, path_clearance
from planner.trajectory.moving_obstacles import clearance_in_time
from planner.trajectory.trajectory import Trajectory

Drawn: TypeAlias = Plan | Trajectory | Floats
Shown: TypeAlias = Tradeoff | Drawn | Mapping[str, Drawn]
"""Every path of a trade-off; a plan, a motion or a path (k, dof) rad; or several of these by their labels."""
Over: TypeAlias = Literal["path", "time"]
Curve: TypeAlias = tuple[Floats, Floats]

_ABSCISSA: dict[Over, str] = {"path": "joint motion from the start (rad)", "time": "time (s)"}
_MOMENTS = 2001  # times at which a motion is drawn: about a printer's dots on a column


@dataclass(frozen=True)
class DrawnPath:
    """A joint path (k, dof) to draw, with its label, its world, and its motion, if any."""

    label: str
    checker: CollisionChecker
    path: Floats
    motion: Trajectory | None = None

    def states(self, over: Over, moments: int = _MOMENTS) -> Curve:
        """Return the abscissa (n,), rad or s, and the configurations (n, dof) there."""
        if over == "path":
            q = dense_path(self.path)
            return lengths_along(q), q
        motion = require_motion(self.motion)
        t = np.linspace(motion.times[0], motion.times[-1], moments)
        return t, motion.at(t)

    def clearance(self, over: Over) -> Curve:
        """Return the abscissa (n,), and the distance (n,) m of the nearest item; in time what moves counts."""
        if over == "path":
            q, clearance = path_clearance(self.checker, self.path)
            return lengths_along(q), clearance
        t, _ = self.states(over, _MOMENTS // 8)
        return t, clearance_in_time(require_motion(self.motion), self.checker, t)


def paths_to_draw(shown: Shown, checker: CollisionChecker | None = None) -> list[DrawnPath]:
    """Return the paths of ``shown``, with ``checker`` as the world of those that have none."""
    if isinstance(shown, Tradeoff):
        return [DrawnPath(f"$\\beta$ {i.betas}", shown.checker, i.path) for i in intervals_of(shown)]
    items = shown if isinstance(shown, Mapping) else {"": shown}
    return [_make_path(label, item, checker) for label, item in items.items()]


def _make_path(label: str, item: Drawn, checker: CollisionChecker | None) -> DrawnPath:
    """Return an item as a path to draw."""
    if isinstance(item, Plan):
        path, checker, motion = item.path, item.checker, item.trajectory
    elif checker is None:
        raise OptionError("a path needs a robot and a scene: add checker=planner.make_checker(robot, scene).")
    elif isinstance(item, Trajectory):
        path, motion = item.at(np.linspace(item.times[0], item.times[-1], _MOMENTS)), item
    else:
        path, motion = numbers("path", item, ("k", checker.robot.dof)), None
    if not len(path):
        raise OptionError(f"{label or 'the plan'} has no path to draw: leave it out.")
    return DrawnPath(label, checker, path, motion)


def require_motion(motion: Trajectory | None) -> Trajectory:
    """Return the motion; :class:`OptionError` if there is none."""
    if motion is None:
        raise OptionError("a path has no motion to draw: make one with planner.time_path(path, checker).")
    return motion


@journal
def manipulability(shown: Shown, over: Over = "path", checker: CollisionChecker | None = None) -> Figure:
    """Draw w along paths over the joint motion (rad) or, along motions, ``over`` time (s).

        planner.figures.manipulability(plan).savefig("w.pdf")
        planner.figures.manipulability({"fast": plan, "good": other}, over="time")

    A ``checker`` is the world of a path (k, dof) or a trajectory that has none. w is drawn every 0.01 rad. Raises
    :class:`OptionError` where there is no path, and over time where there is no motion.
    """

    def w_of(way: DrawnPath) -> Curve:
        x, q = way.states(over)
        return x, w_at(way.checker.robot, q)

    drawn = paths_to_draw(shown, checker)
    return _profile(drawn, over, w_label(drawn[0].checker.robot), w_of)


@journal
def clearance(shown: Shown, over: Over = "path", checker: CollisionChecker | None = None) -> Figure:
    """Draw the distance (m) of the nearest thing along paths, every 1 cm of motion, or ``over`` time.

        planner.figures.clearance(plan).savefig("clearance.pdf")

    Arguments and errors as of :func:`manipulability`. Over time moving obstacles are at their positions of that time;
    along a path only fixed ones count.
    """
    return _profile(paths_to_draw(shown, checker), over, "clearance (m)", lambda way: way.clearance(over))


def w_label(robot: Robot) -> str:
    """Return the axis label of the robot's measure, with its unit."""
    name = "manipulability $w$" if robot.measure == DEFAULT_MEASURE else measure_name(robot.measure)
    return f"{name} ({unit_of(robot) or 'no unit'})"


def _profile(drawn: list[DrawnPath], over: Over, label: str, curve: Callable[[DrawnPath], Curve]) -> Figure:
    figure, axes = single(COLUMN, 2.1, _ABSCISSA[over], label)
    for k, way in enumerate(drawn):
        x, y = curve(way)
        axes.plot(x, np.where(np.isfinite(y), y, np.nan), label=way.label, **_look(k, len(drawn)))
        if not np.isfinite(y).any():
            axes.set_title(NOTHING_NEAR)
    leave_headroom(axes, bottom=0.0)
    axes.set_xlim(left=min(float(np.asarray(line.get_xdata())[0]) for line in axes.get_lines()))
    if any(way.label for way in drawn):
        figure.legend(loc="outside upper center", ncols=min(2, len(drawn)))
    return figure


def _look(k: int, count: int) -> dict[str, Any]:
    """Return the look of the k-th of ``count`` lines; many lines differ in lightness, from dark to light."""
    look = {"linestyle": "-", "color": "black"} if count == 1 else stroke_with_markers(k, every=0.24)
    return look | {"color": RAMP(0.8 * k / (count - 1))} if count > 4 else look


_ROWS = "$q$ ({})", "$\\dot q$ ({}/s)", "$\\ddot q$ ({}/s²)", "jerk $\\dddot q$ ({}/s³)"
_MARGIN = 0.022  # of the duration: between the marks of two joints in the margin
_LETTERS = 60.0  # the width of a legend
_NOTE: dict[str, Any] = {"color": "0.4", "fontsize": SMALL, "ha": "center", "va": "center"}


@journal
def motion(shown: Plan | TaskPlan | Trajectory, robot: Robot | None = None) -> Figure:
    """Draw position, velocity, acceleration and jerk of every joint over time (s), with limits.

        planner.figures.motion(plan).savefig("motion.pdf")

    Thin lines are limits; in the margin on the right the mark of each joint stands at its own. Limits of positions are
    those of the ``robot``, which a plan has. A limit more than three times beyond a row's curves is left out, and the
    row says so. Raises :class:`OptionError` where there is no motion.
    """
    if not isinstance(shown, Trajectory):
        shown, robot = require_motion(shown.trajectory), shown.robot
    slides = np.zeros(len(shown.joints), dtype=bool) if robot is None else robot.prismatic
    unit = "rad" if not slides.any() else "m" if slides.all() else "rad, m"
    figure = sheet(COLUMN, 5.2)
    rows = figure.subplots(4, 1, sharex=True)
    t = np.linspace(shown.times[0], shown.times[-1], _MOMENTS)
    for order, (axes, name) in enumerate(zip(rows, _ROWS, strict=True)):
        label_axes(axes, y=name.format(unit))
        values = shown.at(t, order)
        for k, (joint, column) in enumerate(zip(shown.joints, values.T, strict=True)):
            axes.plot(t, column, label=joint, **stroke_with_markers(k, every=0.3, linewidth=0.8, markersize=3.0))
        leave_headroom(axes, *_draw_limits(axes, _limits(shown, robot, order), values, t))
    label_axes(rows[-1], "time (s)", rows[-1].get_ylabel())
    rows[-1].set_xlim(t[0], t[-1] + (t[-1] - t[0]) * _MARGIN * (1 + len(shown.joints)))
    rows[-1].set_xticks([tick for tick in rows[-1].get_xticks() if t[0] <= tick <= t[-1]])
    same, names = _shorten_names(shown.joints)
    look: dict[str, Any] = {"handlelength": 2.4, "handletextpad": 0.4, "columnspacing": 0.9, "title": same}
    look["ncols"] = max(1, int(_LETTERS / (7 + max(map(len, names)))))
    figure.legend(rows[0].get_lines()[: len(names)], names, loc="outside upper center", **look)
    return figure


def _shorten_names(names: tuple[str, ...]) -> tuple[str, list[str]]:
    """Return the common prefix of all names, and the rest of each; no prefix if a rest would be empty."""
    alike = [len(set(letters)) == 1 for letters in zip(*names, strict=False)]
    count = [*alike, False].index(False) % min(map(len, names))
    return f"{names[0][:count]}…" if count else "", [name[count:] for name in names]


def _limits(trajectory: Trajectory, robot: Robot | None, order: int) -> Floats:
    """Return (2, dof) the least and largest value of each joint; infinite if unknown."""
    if order and trajectory.limits is not None:
        most = getattr(trajectory.limits, KINDS[order - 1])
        return np.stack([-most, most])
    if order == 0 and robot is not None:
        return np.where(robot.continuous, np.inf, np.stack([robot.lower, robot.upper]))
    return np.full((2, len(trajectory.joints)), np.inf)


def _draw_limits(axes: Axes, limits: Floats, values: Floats, t: Floats) -> Floats:
    """Draw the limits (2, dof) that are near the ``values`` (n, dof); return these."""
    near = np.isfinite(limits) & (np.abs(limits) <= 3.0 * float(np.abs(values).max()))
    apart, dof = _MARGIN * (t[-1] - t[0]), limits.shape[1]
    axes.axvspan(t[-1], t[-1] + 2.0 * dof * apart, color="0.94", zorder=0)
    axes.text(
        t[-1] + 0.5 * apart * (1 + dof), 0.5, "limits", rotation=90, transform=axes.get_xaxis_transform(), **_NOTE
    )
    for k in range(dof):
        for value in limits[near[:, k], k]:
            axes.axhline(value, color="0.55", linewidth=0.5, zorder=1)
            axes.plot(t[-1] + apart * (1 + k), value, **stroke_with_markers(k, linestyle="none", markersize=3.0))
    far = np.abs(limits[np.isfinite(limits) & ~near])
    if len(far):
        axes.text(0.5, 0.92, f"limits from $\\pm${far.min():.4g} on, not shown", transform=axes.transAxes, **_NOTE)
    return limits[near]


OMEGA, DISTANCE = "manipulability cost $\\Omega$ (no unit)", "distance cost $D$ (no unit)"
BETA = "$\\beta$ (no unit)"
_THIN: dict[str, Any] = {"color": "0.5", "linewidth": 0.6}
Row: TypeAlias = Literal["cost", "duration", "w", "clearance"]


@journal
def pareto_front(tradeoff: Tradeoff) -> Figure:
    """Draw the paths of a trade-off in the plane of their two costs, each with its betas.

        planner.figures.pareto_front(tradeoff).savefig("front.pdf")

    The line is the lower convex hull, which is all that beta can reach. Raises :class:`OptionError` where there is no
    path.
    """
    intervals = intervals_of(tradeoff)
    figure, axes = single(COLUMN, 2.8, OMEGA, DISTANCE)
    points = np.array([[i.manipulability_cost, i.distance_cost] for i in intervals])
    axes.plot(*points.T, zorder=3, **stroke_with_markers(0))
    leave_headroom(axes)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    axes.set_xlim(left, right + 0.45 * (right - left))
    places, gap = points.copy(), 0.06 * (high - low)
    for k in range(len(places) - 2, -1, -1):  # a label that would lie on the next one stands above it
        if places[k, 1] < places[k + 1, 1] + gap:
            places[k] = places[k + 1] + [0.0, gap]
    places += [0.05 * (right - left), 0.5 * gap]
    look: dict[str, Any] = {"va": "center", "fontsize": SMALL, "bbox": {"fc": "white", "ec": "none", "pad": 0.5}}
    line = {"arrowstyle": "-", "linewidth": 0.4, "color": "0.5", "shrinkA": 0, "shrinkB": 3}
    for interval, point, place in zip(intervals, points, places, strict=True):
        axes.annotate(f"$\\beta$ {interval.betas}", point, place, arrowprops=line, **look)
    return figure


@journal
def over_beta(tradeoff: Tradeoff, rows: Sequence[Row] = ("cost", "duration", "w", "clearance")) -> Figure:
    """Draw the least cost, and duration (s), smallest w and clearance (m) of its path over beta.

        planner.figures.over_beta(tradeoff).savefig("beta.pdf")
        planner.figures.over_beta(tradeoff, rows=["duration"])

    All betas of an interval have one path, so a row consists of steps; cost is the least of the thin lines, which are
    the paths: (1 - beta) Omega + beta D. The grey band is the knee. Raises :class:`OptionError` where there is no path,
    and for a row that has no numbers, as durations without motions.
    """
    intervals, knee, unit = intervals_of(tradeoff), tradeoff.knee, unit_of(tradeoff.robot) or "no unit"
    labels = {"cost": "cost (no unit)", "duration": "duration (s)", "w": f"smallest $w$ ({unit})"}
    figure = sheet(COLUMN, 0.6 + 1.1 * len(rows))
    panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    betas = np.array([[item.beta_min, item.beta_max] for item in intervals])
    for axes, row in zip(panels, rows, strict=True):
        label_axes(axes, y=labels.get(row, "clearance (m)"))
        if knee is not None:
            axes.axvspan(knee.beta_min, knee.beta_max, color="0.88", zorder=0, label="knee")
        if row == "cost":
            paths = axes.plot([0, 1], [[item.at(beta) for item in intervals] for beta in (0.0, 1.0)], **_THIN)
            paths[0].set_label("a path")
            values = np.array([[item.at(beta) for beta in ends] for item, ends in zip(intervals, betas, strict=True)])
        else:
            known = [getattr(item, "w_min" if row == "w" else row) for item in intervals]
            if None in known:
                raise OptionError(f"the trade-off has no {row} for every path: leave this row out.")
            values = np.repeat(np.array(known)[:, None], 2, axis=1)
        corners = {"marker": "o", "markerfacecolor": "white"} if row == "cost" else {}
        axes.plot(betas.ravel(), values.ravel(), color="black", label="the best path", **corners)
        leave_headroom(axes, bottom=0.0)
    label_axes(panels[-1], BETA, panels[-1].get_ylabel())
    panels[-1].set_xlim(-0.02, 1.02)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def intervals_of(tradeoff: Tradeoff) -> tuple[Interval, ...]:
    """Return the intervals; :class:`OptionError` if there are none."""
    if not tradeoff.intervals:
        raise OptionError(f"the trade-off has no path to draw: {tradeoff.outcome.value}")
    return tradeoff.intervals
