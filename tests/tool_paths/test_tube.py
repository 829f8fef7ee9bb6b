"""The tube attacked: what is proven on joint curves, against the best that a hill climb finds."""

import numpy as np
import pytest

from planner.constraints.tool_bound import Frame, ToolBound
from planner.robot.robot import Robot
from planner.tool_paths.file import read_tool_path
from planner.tool_paths.ladder import build_ladder, continue_ladder
from planner.tool_paths.tool_path import ToolPath, TubeSize, rotate_about
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


def test_whole_orientations_that_turn_are_kept_too() -> None:
    robot, rng = load("panda"), np.random.default_rng(4)
    path = line_of(WRIST, quaternion=[1, 0, 0, 0])
    turns = path.turns.copy()
    turns[1] = turns[1] @ np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1.0]])
    turned = type(path)(path.name, path.positions, turns, path.free, path.cones, path.given, path.tube)
    ladder = build_ladder(robot, Tube(turned.subdivide()))
    assert np.isin([0.0, ladder.stations[-1]], np.round(ladder.along, 12)).any()
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
    "links of five metres": (lambda file: six_axes(file, 5.0, 0.1), [0.2, 0.3, 0.5, 0.1, 0.4, 0.2]),
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


def test_a_short_motion_past_a_point_of_the_path_is_proven() -> None:
    """It leaves its chord by less than is halved for, and still is beside one line first, then beside the next."""
    robot, q, rng = load("panda"), np.array([0.1, 0.3, 0.0, -2.0, 0.0, 2.3, 0.8]), np.random.default_rng(0)
    rotation, position = Frame.tool(robot).poses(robot, q[None])
    delta = rng.uniform(-1, 1, 7)
    ends = Frame.tool(robot).poses(robot, np.stack([q - 1e-3 * delta, q + 1e-3 * delta]))[1]
    way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    points = position[0] + np.array([[-0.02], [0.0], [0.02]]) * way
    tube, bound = Tube(line_of(points, axis=rotation[0, :, 2].tolist()).subdivide()), ToolBound(robot)
    size = 1.4e-7 / np.linalg.norm(ends[1] - ends[0])
    curve = np.stack([q - size * delta, 2.5 * size * delta])[None]
    assert bound(curve)[0][0] < 1e-6
    assert tube.prove(bound, curve, np.array([[0, 1]])).all()
    assert not tube.prove(bound, curve, np.array([[0, 0]])).any()


def test_deviations_are_what_they_are() -> None:
    tube = Tube(line_of([[0, 0, 0], [1, 0, 0]], axis=[0, 0, 1]).subdivide())
    lean = np.array([[np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]])
    off, angle = tube.deviations(np.zeros((1, 1), dtype=int), lean[None], np.array([[0.5, 0.02, 0.0]]))
    assert off[0] == pytest.approx(0.02)
    assert angle[0] == pytest.approx(0.3)
    spare = tube.spare(np.zeros((1, 1), dtype=int), lean[None], np.array([[0.5, 0.02, 0.0]]))
    assert spare[0, 0, 0] == pytest.approx(0.9e-3 - 0.02)
    assert spare[0, 0, 1] < 0


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
                assert (tube.spare(lines, rotation, position[None]).min(axis=2).max() >= 0) == inside


def test_beside_a_bend_deviations_are_those_from_the_line_that_a_pose_keeps_to() -> None:
    """It is nearer to the line before, on which the tool has not turned yet."""
    turned = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    corners = np.array([[0.0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0]])
    turns, none = np.stack([np.eye(3), np.eye(3), turned]), np.zeros(3)
    tube = Tube(ToolPath("bend", corners, turns, none.astype(bool), none, np.arange(1, 4), TubeSize(0.002, 0.01)))
    rotation, position = tube.path.at(np.array([1]), np.array([0.12]))[1], np.array([[0.0085, 0.0012, 0.0]])
    both = [tube.deviations(np.array([[line]]), rotation, position) for line in (0, 1)]
    assert both[0][0] < both[1][0] < 0.002
    assert both[1][1] < 1e-9 < 0.01 < both[0][1]
    off, angle = tube.deviations(np.array([[0, 1]]), rotation, position)
    np.testing.assert_array_equal([off, angle], both[1])


@pytest.mark.parametrize("cone", [1e-3, 0.6])
def test_what_a_cone_allows_changes_no_faster_than_the_proof_reckons(
    cone: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From a cone narrower than the tube's angle, or wider, to an axis within that angle."""
    points: list[dict] = [{"position": [0.4, 0, 0.3], "cone": {"axis": [0, 0, -1], "angle": cone}}]
    points.append({"position": [0.41, 0, 0.3], "axis": [0, 0, -1]})
    path = read_tool_path({"points": points, "tube": {"position": 0.01, "angle": 0.3}})
    tube, down, robot = Tube(path.subdivide()), np.diag([1.0, -1.0, -1.0])[None], load("panda")
    places = [np.array([[x, 0.0, 0.3]]) for x in np.linspace(0.4, 0.41, 101)]
    spare = np.array([tube.spare(np.zeros((1, 1), dtype=int), down, place)[0, 0, 1] for place in places])
    claimed: list[np.ndarray] = []
    monkeypatch.setattr(
        "planner.tool_paths.tube.prove_along", lambda *given: claimed.append(given[3]) or np.ones(1, bool)
    )
    tube.prove(ToolBound(robot), np.stack([robot.home, 0 * robot.home])[None], np.zeros((1, 1), dtype=int))
    assert np.abs(np.diff(spare) / 1e-4).max() <= claimed[0][1]
