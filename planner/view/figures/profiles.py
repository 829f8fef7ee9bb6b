"""What happens along a path: manipulability and clearance against the joint motion so far. A door to matplotlib."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.base.polylines import lengths_along
from planner.collision.checker import CollisionChecker
from planner.kinematics.manipulability import manipulability
from planner.trajectory.measure import dense_path, path_clearance
from planner.view.figures.strokes import labelled, marked, single, stroke
from planner.view.motion import W_UNIT


def path_profiles(checker: CollisionChecker, paths: Mapping[str, Floats]) -> Figure:
    """w and clearance along joint paths (k, dof), by the label they get, against the joint motion so far (rad).

    w every 0.01 rad, clearance every centimetre of motion. Raises :class:`OptionError` where a path is empty.
    """
    figure = Figure(figsize=(7.2, 5.0), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    robot = checker.robot
    for k, (label, path) in enumerate(paths.items()):
        if not len(path):
            raise OptionError(f"'{label}' has no path to draw: leave it out, or plan with another seed or more nodes.")
        q = dense_path(path)
        upper.plot(motion_along(q), manipulability(robot, q), label=label, **stroke(k))
        q, clearance = path_clearance(checker, path)
        lower.plot(motion_along(q), clearance, **stroke(k))
    labelled(upper, y=f"manipulability $w$ ({W_UNIT[robot.manipulability]})")
    labelled(lower, "joint motion from the start (rad)", "clearance (m)")
    for axes in (upper, lower):
        axes.set_ylim(bottom=0.0)
        axes.margins(x=0.01)
    figure.legend(loc="outside upper center", ncols=min(4, len(paths)), frameon=False, handlelength=3.6)
    return figure


def clearance_bounds(certified: Floats, measured: Floats) -> Figure:
    """What proofs say of edges against what measuring finds, (m,) metres each: no dot may lie above the diagonal."""
    measured_axis, certified_axis = (
        "smallest clearance measured along the edge (m)",
        "clearance that its proof certifies (m)",
    )
    figure, axes = single(4.8, 4.4, measured_axis, certified_axis)
    end = 1.05 * float(max(certified.max(initial=0.0), measured.max(initial=0.0)))
    axes.plot([0.0, end], [0.0, end], color="0.5", linewidth=1.0, label="equal")
    axes.plot(measured, certified, label="an edge", **{**marked(0), "linestyle": "none"})
    axes.set_aspect("equal")
    axes.legend(frameon=False)
    return figure


def motion_along(q: Floats) -> Floats:
    """Joint motion (n,) rad from the first of the configurations (n, dof) to each."""
    return lengths_along(q)
