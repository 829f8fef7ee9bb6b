"""The tube attacked: what is proven on joint curves, against the best that a hill climb finds."""

import numpy as np
import pytest

from planner.constraints.tool_bound import Frame, ToolBound
from planner.robot.robot import Robot
from planner.tool_paths.file import read_tool_path
from planner.tool_paths.ladder import build_ladder, continue_ladder
from planner.tool_paths.tool_path import ToolPath, rotate_about
from planner.tool_paths.tube import Tube
from tests.kinematics.test_tool_bound import sliding
from tests.tool_paths.judge import line_of, outside
from tests.worlds import joint_xml, link_xml, load

WRIST = [[0.35, -0.05, 0.45], [0.40, 0.05, 0.45]]


def through(robot: Robot, q: np.ndarray, way: np.ndarray, **more) -> ToolPath:
    """A path whose first point is where the robot's tool is at ``q``, and which goes ``way`` from there."""
    rotation, position = Frame.tool(robot).poses(robot, q[None])
    return line_of([position[0], position[0] + way], axis=rotation[0, :, 2].tolist(), **more)


def worst_on_arcs(ladder, rng: np.random.Generator, arcs: int = 12) -> float:
    """The largest share of the tube that a hill climb along s finds on random arcs."""
    rows = rng.choice(len(ladder.arcs), size=min(arcs, len(ladder.arcs)), replace=False)
    worst = 0.0
    for a, b in ladder.arcs[rows]:
        start, delta = ladder.q[a], ladder.robot.difference(ladder.q[a], ladder.q[b])
        s, step = rng.uniform(size=4), 0.25
        best = np.array([outside(ladder.tube.path, ladder.robot, (start + one * delta)[None]) for one in s])
        for _ in range(6):
            tries = np.clip(s + step * rng.normal(size=4), 0, 1)
            found = np.array([outside(ladder.tube.path, ladder.robot, (start + one * delta)[None]) for one in tries])
            s, best, step = np.where(found > best, tries, s), np.maximum(best, found), 0.6 * step
        worst = max(worst, float(best.max()))
    return worst


@pytest.mark.parametrize(("name", "size"), [("panda", 1e-3), ("ur5", 1e-4), ("kinova", 1e-3), ("iiwa14", 1e-5)])
def test_no_arc_of_a_ladder_leaves_the_tube(name: str, size: float) -> None:
    """kinova's continuous joints cross half a turn; tubes down to 10 um."""
    robot, rng = load(name), np.random.default_rng(3)
    ladder = build_ladder(robot, Tube(line_of(WRIST, tube=(size, 2e-3)).subdivide()))
    assert len(ladder.arcs) > 10
    assert worst_on_arcs(ladder, rng) <= 1.0


def six_axes(urdf_file, link: float = 0.3, tool: float = 1.0) -> Robot:
    """An arm with two links of a length, and its tool off the flange (m)."""
    inside = "".join(link_xml(name) for name in "abcdefgh")
    axes = ["0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0"]
    for k, axis in enumerate(axes):
        offset = f"0 0 {link}" if k in (1, 2) else "0.1 0 0"
        inside += joint_xml(f"j{k}", "abcdef"[k], "bcdefg"[k], axis=axis, xyz=offset, limit="-2.5 2.5")
    fixed = f'<joint name="end" type="fixed"><parent link="g"/><child link="h"/><origin xyz="{tool} 0 0"/></joint>'
    return Robot.load(urdf_file(inside + fixed, name="long"), "h")


ARMS = {  # an arm, and where its line begins
    "a tool a metre off the flange": (six_axes, [0.2, 0.3, 0.5, 0.1, 0.4, 0.2]),
    "a slide": (sliding, [0.1, 0.3, 0.2, 0.4, 0.0]),
    "a wrist near singular": (lambda _: load("ur5"), [0.3, -1.0, 1.2, -0.4, 0.02, 0.1]),
    "continuous joints past half a turn": (
        lambda _: load("kinova"), [np.pi - 1e-4, 2.6, 1.3, -np.pi + 1e-4, 1.0, np.pi - 1e-4]
    ),
    "seven joints": (lambda _: load("panda"), [0.1, 0.3, 0.0, -2.0, 0.0, 2.3, 0.8]),
}  # fmt: skip


def hardest(robot: Robot, tube: Tube, q: np.ndarray, rng: np.random.Generator, steps: int) -> tuple[float, int]:
    """The largest share of the tube that a climber finds on curves proven to stay in it, and how often it rose.

    It moves the coefficients of a curve, cubic at most, and keeps what is proven and worse.
    """
    ladder, bound = continue_ladder(robot, tube, q), ToolBound(robot)
    assert len(ladder.arcs)
    a, b = ladder.arcs[rng.integers(len(ladder.arcs))]
    delta = robot.difference(ladder.q[a], ladder.q[b])
    curve, size, best, rose = np.stack([ladder.q[a], delta, 0 * delta, 0 * delta]), 0.3, 0.0, 0
    lines, s = np.arange(len(tube.path.lengths))[None], np.linspace(0, 1, 9)[:, None] ** np.arange(4)
    reach = np.abs(delta).max() * np.array([[0.1], [1.0], [1.0], [1.0]])
    for _ in range(steps):
        tried = curve + size * reach * rng.normal(size=curve.shape)
        good = bool(tube.prove(bound, tried[None], lines)[0])
        worst = outside(tube.path, robot, s @ tried) if good else 0.0
        if worst > best:
            curve, best, rose, size = tried, worst, rose + 1, min(1.3 * size, 1.0)
        else:
            size = max(0.93 * size, 1e-3)
    fine = np.linspace(0, 1, 101)[:, None] ** np.arange(4)
    return max(best, outside(tube.path, robot, fine @ curve)), rose


@pytest.mark.parametrize(("arm", "size"), [*((arm, 1e-3) for arm in ARMS), ("a wrist near singular", 1e-5)])
def test_the_hardest_proven_curve_stays_in_the_tube(arm: str, size: float, urdf_file) -> None:
    made, begin = ARMS[arm]
    robot, q = made(urdf_file), np.array(begin)
    axis = Frame.tool(robot).poses(robot, q[None])[0][0]
    way = np.array([0.0, 0.04, 0.0]) if arm == "a slide" else 0.04 * (axis[:, 0] + 0.3 * axis[:, 1])
    path = through(robot, q, way, tube=(size, 2e-3))
    best, rose = hardest(robot, Tube(path.subdivide()), q, np.random.default_rng(1), 200)
    assert rose > 1
    assert 0.3 < best <= 1.0  # it came near the boundary, not over it


def test_what_leaves_the_tube_is_refused_and_what_stays_is_proven() -> None:
    """A tube just wide enough, and one just too narrow, for a motion whose deviation is measured densely."""
    robot = load("iiwa14")
    q, delta = np.array([0.3, 0.8, 0.1, -1.2, 0.2, 0.9, 0.0]), np.full(7, 0.02)
    bound, s = ToolBound(robot), np.linspace(0, 1, 5001)
    rotation, position = bound.frame.poses(robot, q + s[:, None] * delta)
    chord = position[0] + s[:, None] * (position[-1] - position[0])
    off = float(np.linalg.norm(position - chord, axis=1).max())
    verdicts = []
    for size in (1.2 * off, 0.9 * off):
        axis = rotation[0, :, 2]
        path = line_of(position[[0, -1]], tube=(size, 0.4), axis=(axis / np.linalg.norm(axis)).tolist())
        found = Tube(path.subdivide()).prove(bound, np.stack([q, delta])[None], np.zeros((1, 1), dtype=int))
        verdicts.append(bool(found[0]))
    assert verdicts == [True, False]


@pytest.mark.parametrize("bend", [0.0, 0.04, 0.2])
def test_nothing_passes_a_quaternion_that_is_turned_otherwise(bend: float) -> None:
    """Neither at the point nor within a tube's radius of it, on a hairpin too; what is turned as it says is inside."""
    at, down = np.array([[0.4, 0.0, 0.3], [0.4, 0.1, 0.3], [0.4 + bend, 0.0, 0.3]]), np.diag([1.0, -1.0, -1.0])
    points: list[dict] = [{"position": row.tolist(), "axis": [0, 0, -1]} for row in at]
    points[1] = {"position": at[1].tolist(), "quaternion": [1, 0, 0, 0]}
    tube = Tube(read_tool_path({"points": points}).subdivide())
    lines, size = np.arange(len(tube.path.lengths))[None], tube.path.tube
    for turned, inside in ((0.0, True), (1.5 * size.angle, False)):
        rotation = down @ rotate_about(np.array([[0.0, 0.0, 1.0]]), np.array([turned]))
        for way in (at[0] - at[1], at[2] - at[1]):
            for off in (0.0, 0.5, 0.9):
                position = at[1] + off * size.position * way / np.linalg.norm(way)
                assert (tube.slack(lines, rotation, position[None]).min(axis=2).max() >= 0) == inside
