"""Following tool paths: whole, from a start, in part with the reason, again at other betas; the motion in its tube."""

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from planner.base.errors import StateError
from planner.kinematics.manipulability import manipulability
from planner.planning.follow import Follower, follow
from planner.problem.outcome import CannotFollow, Outcome
from planner.problem.request import FollowRequest, TimingRequest
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.tool_paths.file import read_tool_path
from planner.tool_paths.ladder import build_ladder
from planner.tool_paths.tube import Tube
from tests.tool_paths.judge import line_of, outside, passes_by, pose_of, raster
from tests.worlds import load, planar_trap

REQUEST = FollowRequest.from_options(robot="panda", scene="empty")
RASTER = raster(2, 10, 0.01, [0.45, -0.05, 0.4])


def box(name: str, size: tuple[float, float, float], position: list[float]) -> Scene:
    return Scene("made", (Obstacle(name, Box(size), pose(position)),))


@pytest.fixture(scope="module")
def follower() -> Follower:
    return Follower.from_tool_path(RASTER, REQUEST)


def test_a_raster_is_followed_without_a_jump(follower: Follower) -> None:
    found = follower.plan(REQUEST)
    assert found.outcome is Outcome.SOLVED
    record = found.tool_path.record
    assert (record.followed, record.points, record.first_unreachable, record.proven) == (1.0, 20, None, True)
    assert record.largest_deviation.position <= 1e-3
    assert np.abs(np.diff(found.path, axis=0)).max() < 0.1
    s = np.linspace(0, 1, 5)[:, None, None]
    q = (found.path[:-1] + s * np.diff(found.path, axis=0)).reshape(-1, 7)
    assert outside(RASTER, found.robot, q) <= 1.0
    assert found.to_dict()["tool_path"]["followed"] == 1.0


def test_beta_trades_off_on_one_ladder(follower: Follower) -> None:
    singular, short = (follower.plan(REQUEST.with_options(beta=beta)) for beta in (0.0, 1.0))
    assert singular.cost.manipulability <= short.cost.manipulability
    assert short.cost.distance <= singular.cost.distance
    assert singular.cost.manipulability < short.cost.manipulability or singular.path.tolist() == short.path.tolist()
    assert singular.max_error_vs_oracle == 0.0


def test_a_floor_is_kept(follower: Follower) -> None:
    free = follower.plan(REQUEST.with_options(beta=1.0))
    assert free.record.manipulability is not None
    floor = 1.02 * free.record.manipulability.min
    found = follow(RASTER, request=REQUEST, min_manipulability=floor, timing=None)
    assert found.outcome is Outcome.SOLVED
    s = np.linspace(0, 1, 20)[:, None, None]
    assert (
        manipulability(found.robot, (found.path[:-1] + s * np.diff(found.path, axis=0)).reshape(-1, 7)).min() >= floor
    )
    refused = follow(RASTER, request=REQUEST, min_manipulability=10.0, timing=None)
    assert isinstance(refused.reason, CannotFollow)
    assert refused.reason.cause == "below_floor"
    assert floor / 2 < refused.reason.reachable < 10.0
    lower = follow(RASTER, request=REQUEST, min_manipulability=refused.reason.reachable, timing=None)
    assert lower.outcome is Outcome.SOLVED


def test_a_free_motion_leads_to_it_from_a_start() -> None:
    path = raster(2, 8, 0.01, [0.15, -0.5, 0.98])
    found = follow(path, robot="panda", scene="table", start="home", path_only=True, timing=TimingRequest())
    assert found.outcome is Outcome.SOLVED
    np.testing.assert_allclose(found.path[0], found.roadmap.nodes[0])
    made = found.trajectory
    assert made is not None
    assert made.proven
    assert found.tool_path.record.proven
    first = int(np.argmax(np.linalg.norm(found.path[:, None] - found.roadmap.nodes[None], axis=2).min(axis=1) < 1))
    assert first == 0
    ends = np.abs(made.at(made.times) - found.path[-1]).max(axis=1)
    assert ends[-1] < 1e-9


def test_an_obstacle_on_the_way_is_named_with_the_point() -> None:
    path = line_of([[0.45, y, 0.4] for y in (-0.2, -0.1, 0.0, 0.1, 0.2)])
    found = follow(path, robot="panda", scene=box("wall", (0.4, 0.05, 1.0), [0.45, 0.1, 0.4]), timing=None)
    assert found.outcome is Outcome.PARTLY_FOLLOWED
    assert found.outcome.exit_code == 4
    record = found.tool_path.record
    assert 0.3 < record.followed < 0.7
    assert record.first_unreachable in (3, 4)
    assert isinstance(found.reason, CannotFollow)
    assert found.reason.cause in ("touching", "jump")
    if found.reason.cause == "touching":
        assert "wall" in found.reason.names
    assert len(found.path) > 2
    s = np.linspace(0, 1, 5)[:, None, None]
    assert outside(path, found.robot, (found.path[:-1] + s * np.diff(found.path, axis=0)).reshape(-1, 7)) <= 1.0


def test_what_is_out_of_reach_says_by_how_much() -> None:
    found = follow(line_of([[0.6, 0, 0.5], [0.9, 0, 0.5], [1.3, 0, 0.5]]), request=REQUEST, timing=None)
    assert isinstance(found.reason, CannotFollow)
    assert found.reason.cause in ("out_of_reach", "turned", "jump", "beyond_limit")
    nowhere = follow(line_of([[1.6, 0, 0.5], [1.7, 0, 0.5]]), request=REQUEST, timing=None)
    assert isinstance(nowhere.reason, CannotFollow)
    assert (nowhere.reason.cause, nowhere.reason.point) == ("out_of_reach", 1)
    assert nowhere.reason.distance > 0.3
    assert nowhere.tool_path.record.followed == 0.0
    assert len(nowhere.path) == 0
    assert nowhere.to_dict()["tool_path"]["first_unreachable"] == 1
    assert "followed over 0.0 %" in nowhere.message
    nowhere.page()


@pytest.mark.parametrize(
    ("constraint", "unit", "point"), [("box:-1,-1,0,1,0.05,1", "m", 2), ("plane:0,0,1,0.5", "m", 1)]
)
def test_what_is_to_be_kept_is_kept_and_named_where_it_is_in_the_way(constraint: str, unit: str, point: int) -> None:
    path = line_of([[0.45, -0.1, 0.4], [0.45, 0.1, 0.4]])
    found = follow(path, request=REQUEST, constraint=constraint, timing=None)
    assert found.outcome is Outcome.PARTLY_FOLLOWED
    assert isinstance(found.reason, CannotFollow)
    assert (found.reason.cause, found.reason.between, found.reason.point) == ("strays", (constraint,), point)
    assert 0 < found.reason.distance <= 0.1 + 1e-6
    assert f"the constraint '{constraint}' would be broken by" in found.message
    assert f" {unit}; move the path" in found.message
    assert all(pose_of(found.robot, q)[1][1] <= 0.05 for q in found.path)
    found.to_dict()


def test_a_turn_to_be_kept_is_about_the_start_of_the_free_motion() -> None:
    path = line_of([[0.45, -0.05, 0.4], [0.45, 0.05, 0.4]], quaternion=[1, 0, 0, 0])
    begin = "pose:0.4,0,0.5,1,0,0,0"
    found = follow(path, request=REQUEST, start=begin, path_only=True, constraint="turn:0.05", timing=None)
    assert found.outcome is Outcome.SOLVED
    s = np.linspace(0, 1, 20)[:, None, None]
    for q in (found.path[:-1] + s * np.diff(found.path, axis=0)).reshape(-1, 7):
        assert np.arccos((np.trace(pose_of(found.robot, q)[0] @ np.diag([1, -1, -1])) - 1) / 2) <= 0.05 + 1e-6
    with pytest.raises(StateError, match="must have an orientation here"):
        follow(path, request=REQUEST, constraint="turn:0.05", timing=None)


@pytest.mark.parametrize("orientation", [{"axis": [0, 0, -1]}, {"quaternion": [1, 0, 0, 0]}])
def test_the_cone_that_would_do_is_told_and_does(orientation: dict[str, Any]) -> None:
    points = [[0.6, y, 0.7] for y in (-0.02, 0.02)]
    found = follow(line_of(points, **orientation), request=REQUEST, timing=None)
    assert isinstance(found.reason, CannotFollow)
    cone = found.reason.cone
    assert cone is not None
    assert cone > 0
    assert f"give a cone of {cone:g} rad" in found.message
    wider = follow(line_of(points, cone={"axis": [0, 0, -1], "angle": cone}), request=REQUEST, timing=None)
    assert wider.outcome is Outcome.SOLVED
    far = follow(line_of([[1.6, 0, 0.5], [1.7, 0, 0.5]]), request=REQUEST, timing=None)
    assert isinstance(far.reason, CannotFollow)
    assert far.reason.cone is None


def test_what_is_out_of_reach_on_the_path_is_followed_inside_the_tube() -> None:
    """By less than the tube: the tool goes beside the path there."""
    path = line_of([[0.68, -0.08, 0.5], [0.6975, 0.08, 0.5]])
    on_path = build_ladder(load("panda"), Tube(path.subdivide()))
    assert on_path.along.max() < path.along[-1]
    found = follow(path, request=REQUEST, timing=None)
    assert found.outcome is Outcome.SOLVED
    record = found.tool_path.record
    assert record.proven
    assert 1e-5 < record.largest_deviation.position <= 1e-3
    s = np.linspace(0, 1, 5)[:, None, None]
    assert outside(path, found.robot, (found.path[:-1] + s * np.diff(found.path, axis=0)).reshape(-1, 7)) <= 1.0


@pytest.mark.parametrize(("name", "tube"), [("panda", 1e-3), ("ur5", 1e-4)])
def test_the_motion_itself_stays_in_the_tube(name: str, tube: float) -> None:
    path = raster(2, 6, 0.01, [0.45, -0.05, 0.4], tube=(tube, 8.7e-3))
    found = follow(path, robot=name, scene="empty", timing=TimingRequest())
    made = found.trajectory
    assert made is not None
    assert made.proven
    assert found.tool_path.record.proven
    q = made.at(np.linspace(made.times[0], made.times[-1], 1500))
    assert outside(path, found.robot, q) <= 1.0


def test_the_tool_goes_no_faster_than_asked_and_as_fast_where_it_can() -> None:
    path = line_of([[0.45, -0.1, 0.4], [0.45, 0.1, 0.4]])
    found = follow(path, request=REQUEST, tool_speed=0.05, timing=TimingRequest())
    made = found.trajectory
    assert made is not None
    speed = found.tool_path.record.speed
    assert speed is not None
    times = np.linspace(0, made.duration, 40_001)
    from planner.kinematics.forward import tool_positions

    way = np.linalg.norm(np.diff(tool_positions(found.robot, made.at(times)), axis=0), axis=1)
    seen = way / np.diff(times)
    assert seen.max() <= 0.05 * (1 + 1e-6)
    steady = float(way[np.abs(seen / 0.05 - 1) <= 0.01].sum() / way.sum())
    assert steady == pytest.approx(speed.share, abs=0.01)
    assert steady > 0.9
    free = follow(path, request=REQUEST, timing=TimingRequest())
    assert free.trajectory.duration < 0.5 * made.duration


def test_a_start_that_is_cut_off_says_why_and_keeps_the_record(tmp_path: Path) -> None:
    """The planar arm cannot turn past its posts, so nothing is followed although all could be."""
    path = line_of([[-0.8, -0.02, 0.0], [-0.8, 0.02, 0.0]], axis=[0, 0, 1])
    world = {"robot": "planar_2r", "scene": planar_trap(tmp_path)}
    assert follow(path, **world, timing=None).outcome is Outcome.SOLVED
    found = follow(path, **world, start="q:0,0.2", nodes=60, refinement_rounds=0, timing=None)
    assert found.outcome is Outcome.NO_PATH
    assert found.reason is not None
    assert found.reason.kind in ("separated", "budget_spent")
    assert found.tool_path is not None
    assert found.tool_path.record.followed == 0.0


@pytest.mark.parametrize("kinds", ["axis quaternion axis", "cone quaternion cone"])
@pytest.mark.parametrize("spin", [0.0, 2.5])
def test_lines_between_an_axis_and_a_quaternion_are_followed_in_their_tube(kinds: str, spin: float) -> None:
    """The axis along the great arc, whatever the spin; the motion meets each quaternion, at a rounded corner too."""
    lean, points = [[0.2, -0.1, 0.0], [0.35, 0.2, 0.0], [-0.1, 0.15, 0.0]], []
    for k, kind in enumerate(kinds.split()):
        rotation = pin.exp3(np.array(lean[k])) @ np.diag([1.0, -1.0, -1.0]) @ pin.exp3(np.array([0.0, 0.0, spin]))
        z = rotation[:, 2].tolist()
        how = {"axis": z, "cone": {"axis": z, "angle": 0.1}, "quaternion": pin.Quaternion(rotation).coeffs().tolist()}
        points.append({"position": [0.45, 0.1 * k - 0.1, 0.45 + 0.02 * k], kind: how[kind]})
    path = read_tool_path({"points": points})
    found = follow(path, request=REQUEST, timing=TimingRequest())
    assert found.outcome is Outcome.SOLVED
    assert found.trajectory is not None
    assert found.trajectory.proven
    on_path = found.path[:-1] + np.linspace(0, 1, 5)[:, None, None] * np.diff(found.path, axis=0)
    for q in (found.trajectory.at(np.linspace(0.0, found.trajectory.duration, 300)), on_path.reshape(-1, 7)):
        assert outside(path, found.robot, q) <= 1.0
    near = found.trajectory.at(np.linspace(0.0, found.trajectory.duration, 3000))
    assert all(passes_by(path, found.robot, near, k) <= 1.0 for k in np.flatnonzero(~path.free).tolist())
