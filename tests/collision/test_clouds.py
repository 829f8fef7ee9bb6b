"""Proofs among clouds against coal, which sees every ball as a sphere and every cuboid as a box."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner import Points, Robot, Voxels
from planner.base.errors import SceneError
from planner.base.polynomials import evaluate
from planner.collision import BACKENDS, make_checker
from planner.collision.checker import is_free
from planner.collision.coal import CoalChecker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.collision.self_filter import points_on_robot, without_robot
from planner.kinematics.forward import Chain, joint_placements, tool_pose
from planner.problem.request import WorldRequest
from planner.query.query import make_checker_for
from planner.robot.clouds import split_regions
from planner.robot.poses import pose
from planner.robot.robot import with_carried
from planner.robot.robot_in_scene import notes
from planner.robot.scene import Scene
from planner.robot.shapes import Body, Box, Carried, Obstacle, Shape, Sphere
from planner.session.session import Session
from tests.coal_judge import CoalWorld
from tests.random_shapes import QUICK, random_curves, random_pose
from tests.worlds import load, scene_of

COAL = 1e-6  # m: coal's own tolerance
ARMS = {"planar_2r": 0.8, "iiwa14": 0.9}


def random_cloud(rng: np.random.Generator, reach: float) -> tuple[Scene, Scene]:
    """A few dozen balls and cuboids in two random poses; the same as one obstacle for each of them."""
    points = Points(rng.normal(0, 0.2, (40, 3)), float(rng.uniform(1e-3, 0.03)))
    voxels = Voxels(rng.random((4, 4, 4)) < 0.15, float(rng.uniform(0.02, 0.08)), -0.1 * np.ones(3))
    first, second = random_pose(rng, reach), random_pose(rng, reach)
    single: list[tuple[Shape, np.ndarray]] = [(Sphere(points.radius), first @ pose(xyz)) for xyz in points.vertices]
    for cell in voxels.cells:
        low, high = cell.min(axis=0), cell.max(axis=0)
        single.append((Box(tuple((high - low).tolist())), second @ pose(0.5 * (low + high))))
    if rng.random() < 0.5:  # voxels alone, which no radius hands over to the planes
        return scene_of((voxels, second)), scene_of(*single[len(points.vertices) :])
    return scene_of((points, first), (voxels, second)), scene_of(*single)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("arm", ARMS)
def test_proven_free_implies_that_coal_finds_no_contact_with_any_ball_or_cuboid(arm: str, backend: str) -> None:
    verdicts: Counter[int] = Counter()

    @settings(QUICK, max_examples=15)
    @given(st.integers(0, 2**31))
    def check(seed: int) -> None:
        rng = np.random.default_rng(seed)
        seen, single = random_cloud(rng, ARMS[arm])
        checker, judge = make_checker(load(arm), seen, backend), CoalWorld(make_checker(load(arm), single).world)
        curves = random_curves(load(arm), 6, 2, rng)
        for curve, verdict in zip(curves, EdgeProver(checker).prove_curves(curves).verdict, strict=True):
            verdicts[int(verdict)] += 1
            q = evaluate(np.repeat(curve[None], 33, axis=0), np.linspace(0.0, 1.0, 33))
            gaps = np.array([judge.distances(row)[: len(load(arm).bodies) * len(single.obstacles)].min() for row in q])
            if verdict == Verdict.FREE:
                assert gaps.min() > -COAL
            for row, gap in zip(q[::8], gaps[::8], strict=True):
                if abs(gap) > 1e-5 and is_free(checker, row) != (gap > 0):
                    assert gap > 0  # what touches for us alone is a self-collision
                    assert not is_free(make_checker(load(arm), Scene("empty")), row)

    check()
    assert verdicts[int(Verdict.FREE)] >= 10


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("kind", ["one point", "needle", "voxel"])
@pytest.mark.parametrize("margin", [0.0, 0.125])
def test_a_cell_exactly_on_the_boundary_of_margin_and_radius_is_never_proven_free(
    margin: float, kind: str, backend: str
) -> None:
    """All numbers are exact in binary: the gap of a ball in the arm and the cell is the margin, to the last bit."""
    arm = replace(load("planar_2r"), bodies=(Body("ball", "ball", 2, Sphere(0.25), pose()),))
    elbow = joint_placements(Chain.from_arm(arm), np.zeros((1, 2)))[1][2, 0]
    needle = elbow + np.outer(np.linspace(1.0, 2.0, 65), [0, 0, 1])
    for shift, free in ((0.0, False), (2.0**-12, True), (-(2.0**-16), False)):
        low = elbow + np.array([0.0, 0.0, margin + 0.25 + shift])
        shape = {
            "one point": Points(low[None] + [0, 0, 0.5], 0.5),
            "needle": Points(needle + low - elbow - [0, 0, 0.5], 0.5),
            "voxel": Voxels(np.ones((1, 1, 1)), 0.5, low - [0.25, 0.25, 0.0]),
        }[kind]
        checker = make_checker(arm, scene_of((shape, pose())), backend, margin=margin)
        turns = EdgeProver(checker).prove(np.zeros((1, 2)), np.array([[0.0, 0.01]]))
        assert bool(turns.free[0]) == free
        assert is_free(checker, np.zeros(2)) == free


@pytest.mark.parametrize("arm", ARMS)
def test_coal_with_the_samples_near_each_body_equals_coal_with_every_ball(arm: str) -> None:
    """Distances, contacts and stretches that a distance clears, of clouds that are near and far."""
    rng, robot, counts = np.random.default_rng(1), load(arm), Counter[bool]()
    for size in (0.05, 0.4, 0.4):
        cloud, at = Points(rng.normal(0, size, (200, 3)) * [1, 1, 0.1], 0.02), random_pose(rng, ARMS[arm])
        checker = CoalChecker(make_checker(robot, scene_of((cloud, at), (Box((0.1, 0.1, 0.1)), at))).world)
        balls = scene_of(*((Sphere(cloud.radius), at @ pose(xyz)) for xyz in cloud.vertices))
        q, bodies = rng.uniform(-2, 2, (20, robot.dof)), len(robot.bodies)
        judge, pairs = CoalWorld(make_checker(robot, balls).world), 2 * np.arange(bodies)
        gaps = np.array([judge.distances(row)[: 200 * bodies].reshape(bodies, 200).min(axis=1) for row in q])
        mine = np.array([checker.gaps(row, pairs) for row in q])
        assert np.abs(np.maximum(gaps, 0.0) - np.maximum(mine, 0.0)).max() < 1e-5
        for apart in (0.0, 0.04):  # a larger one is not asked of coal
            every = np.zeros(checker.bound.native.pairs)
            every[pairs] = apart
            found = checker.near(q, every)
            near, sure = (gaps < apart - 2e-5).any(axis=1), (gaps > apart + 2e-5).all(axis=1)
            alone = CoalChecker(make_checker(robot, scene_of((Box((0.1, 0.1, 0.1)), at))).world).near(
                q, 0.0 * every[:1]
            )
            assert (found | ~near).all()
            assert (~found | ~sure | alone).all()
            counts.update(found.tolist())
    assert min(counts.values()) > 3


def test_the_robots_own_points_are_left_out_and_no_others() -> None:
    """Against coal: a sample is left out just where it is within the margin of a body."""
    robot, rng, margin = load("iiwa14"), np.random.default_rng(0), 0.03
    q, points = np.array([0.3, 0.5, 0, -1.2, 0.2, 0.8, 0]), rng.uniform([-0.5, -0.5, 0], [0.8, 0.5, 1.2], (300, 3))
    left_out = points_on_robot(robot, q, points, margin)
    judge = CoalWorld(make_checker(robot, scene_of(*((Sphere(margin), pose(each)) for each in points))).world)
    gaps = judge.distances(q)[: len(robot.bodies) * len(points)].reshape(-1, len(points)).min(axis=0)
    assert (left_out | (gaps > -COAL)).all()
    assert (~left_out | (gaps < COAL)).all()
    assert 3 < left_out.sum() < 290
    (item,) = without_robot([Obstacle("a", Points(points, 1e-3), np.eye(4))], robot, q, margin)
    assert len(item.shape.vertices) == (~left_out).sum()  # type: ignore[union-attr]


def write_hand_camera(folder: Path, more: str = "") -> Path:
    """A scene whose camera is on the hand: it saw a board, the arm, and the cup in the hand, from the state "look"."""
    look = np.array([0.3, 0.5, 0, -1.2, 0.2, 0.8, 0])
    robot, rng = load("iiwa14"), np.random.default_rng(0)
    hand = tool_pose(robot, look).homogeneous
    inside = [tool_pose(robot, look).act(np.array([0, 0, z])) for z in (0.0, 0.1)]
    board = np.column_stack([rng.uniform(0.3, 0.7, 200), rng.uniform(-0.4, -0.2, 200), np.zeros(200)])
    world = np.vstack([board, *inside])
    np.save(folder / "seen.npy", (world - hand[:3, 3]) @ hand[:3, :3])
    path = folder / "hand.yaml"
    path.write_text(
        "obstacles:\n  - {name: camera, type: points, file: seen.npy, radius: 0.01, frame: flange, seen_at: look, "
        f"self_filter: 0.03{more}}}\n"
        "carried:\n  - {name: cup, type: sphere, radius: 0.05, link: flange, position: [0, 0, 0.1]}\n"
        f"states: {{iiwa14: {{look: 'q:{','.join(map(str, look))}'}}}}\n"
    )
    return path


def make_query_scene(path: Path) -> Scene:
    return make_checker_for(WorldRequest(robot="iiwa14", scene=path)).world.scene


@pytest.mark.parametrize("opened", [make_query_scene, lambda path: Session("iiwa14", path).scene])
def test_a_scene_file_leaves_out_the_arm_and_its_load_and_places_a_camera_on_the_hand(
    opened: Callable[[Path], Scene], tmp_path: Path
) -> None:
    scene = opened(write_hand_camera(tmp_path, ", regions: {tray: [-9, -9, -9, 9, 9, 9]}"))
    (tray,) = scene.obstacles
    points = tray.shape.vertices @ tray.placement[:3, :3].T + tray.placement[:3, 3]  # type: ignore[union-attr]
    assert len(points) == 200
    np.testing.assert_allclose(points[:, 2], 0.0, atol=1e-12)
    (note,) = [note.text for note in scene.notes if "left out" in note.text]
    assert note == "2 of 202 points or cells of 'tray' are left out: they are within 30 mm of the robot at look."
    assert not any("202 points:" in note.text for note in scene.notes)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("seen_at: look, self_filter: 0.03", "position: [0, 0, 0]", "'flange', which moves with the arm"),
        (
            "seen_at: look",
            "seen_at: 'q:1,2'",
            "seen_at must be q: and 7 joint values, or a state of these, got 'q:1,2'",
        ),
        ("seen_at: look", "seen_at: lok", "seen_at must be q: and 7 joint values"),
        ("seen_at: look, ", "", "give seen_at, the state of the robot when the sensor saw it"),
        ("frame: flange", "frame: flage", "frame 'flage'.*'flange'.*which neither"),
    ],
)
def test_a_sensor_without_a_usable_frame_or_state_is_refused(old: str, new: str, sentence: str, tmp_path: Path) -> None:
    path = write_hand_camera(tmp_path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(SceneError, match=sentence):
        make_query_scene(path)


def test_a_declared_region_may_be_touched_and_the_rest_may_not() -> None:
    """A hand that puts its load down on a tray, a region of the cloud, whose points count in the notes."""
    q = np.array([0.3, 0.5, 0, -1.2, 0.2, 0.8, 0])
    robot = with_carried(load("iiwa14"), (Carried("flange", "cup", Sphere(0.05), pose([0, 0, 0.1])),))
    under = tool_pose(load("iiwa14"), q).act(np.array([0.0, 0, 0.15]))
    cloud, box = Points([[3.0, 3, 3], under], 0.02), (*(under - 0.01), *(under + 0.01))
    items = split_regions("scan", cloud, np.eye(4), {"tray": box})
    for allowed, free in ((frozenset[frozenset[str]](), False), (frozenset({frozenset(("tray", "cup"))}), True)):
        scene = Scene("seen", tuple(items), allowed=allowed)
        assert is_free(make_checker(robot, scene), q) == free
        assert ("cup may touch the 1 points of 'tray'." in [note.text for note in notes(robot, scene)]) == free


def test_a_session_that_sees_equals_a_session_that_begins_with_what_was_seen() -> None:
    robot, rng = Robot.load("panda"), np.random.default_rng(0)
    wall = Points(np.column_stack([rng.uniform(0.4, 0.6, 300), np.full(300, 0.0), np.linspace(-0.3, 0.5, 300)]), 0.02)
    other = Points(np.vstack([wall.vertices[:200], wall.vertices[200:] + np.array([0, 0.3, 0])]), 0.02)
    start, goal = "q:0.8,-0.2,0,-1.9,0,2.1,0.8", "q:-0.8,-0.2,0,-1.9,0,2.1,0.8"
    session = Session(robot, Scene("empty"), nodes=60)
    session.see("camera", wall)
    assert session.plan(start, goal, timing=None).solved
    kept = {id(item) for item in session.scene.obstacles}
    session.see("camera", other)
    assert any(id(item) in kept for item in session.scene.obstacles)
    plan = session.replan()
    fresh = make_checker(robot, session.scene)
    assert plan.solved
    assert all(is_free(fresh, q) for q in plan.path)
    session.remove(session.scene.obstacles[0].name)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_body_wholly_inside_a_solid_cell_is_in_contact(backend: str) -> None:
    """No face is near it: both libraries alone call it free. The same arm is free where its cell is empty."""
    full = np.ones((3, 3, 3), dtype=bool)
    hollow = full.copy()
    hollow[1, 1, 1] = False
    for occupied, free in ((full, False), (hollow, True)):
        scene = scene_of((Voxels(occupied, 4.0, (-6.0, -6.0, -6.0)), pose()))
        for arm in ("planar_2r", "panda"):
            checker = make_checker(load(arm), scene, backend)
            assert bool(is_free(checker, np.array(load(arm).home))) == free
