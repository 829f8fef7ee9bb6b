"""Robots in turn: the search against a breadth-first search judged by coal, and motions against dense looks."""

import json
from collections import deque
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import OptionError, PlannerError
from planner.cells.check import check_files
from planner.cells.coordinate import _cut, coordinate
from planner.cells.planner import CellPlanner
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.planning.plan import plan as find_plan
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.request import PartialWorld
from planner.robot.cell import Cell
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.trajectory.parts import busy_seconds, merge_trajectories, split_trajectory
from planner.trajectory.trajectory import Trajectory
from tests.coal_judge import CoalWorld
from tests.command_line import Run
from tests.query.test_cells import two_planar_arms
from tests.robot.test_cell import TWO_ARMS


@cache
def cell_planner() -> CellPlanner:
    return CellPlanner(TWO_ARMS, nodes=100, collision="coal")


@cache
def exchange() -> Plan:
    return cell_planner().plan("here", "there")


def crossing() -> tuple[Cell, list[np.ndarray]]:
    """Two planar arms whose straight motions sweep through the same place."""
    return two_planar_arms(), [np.array([[1.2, 0.2], [-1.2, -0.2]]), np.array([[1.2, 0.2], [-1.2, -0.2]])]


def test_the_search_takes_as_few_moves_as_a_search_of_the_whole_product_judged_by_coal() -> None:
    cell, paths = crossing()
    checker = make_checker(cell.robot, cell.scene, "coal")
    velocity = [robot.velocity for robot in cell.robots.values()]
    path = coordinate(paths, velocity, EdgeProver(checker))
    assert path is not None
    assert EdgeProver(checker).free(path[:-1], np.diff(path, axis=0)).all()
    first, second = _cut(paths, velocity)
    judge = CoalWorld(checker.world)

    @cache
    def free(i: int, k: int, move: tuple[int, int]) -> bool:
        a, b = np.append(first[i], second[k]), np.append(first[i + move[0]], second[k + move[1]])
        return all((judge.distances(a + s * (b - a)) > 0).all() for s in np.linspace(0, 1, 9))

    ends, queue, moves = (len(first) - 1, len(second) - 1), deque([(0, 0)]), {(0, 0): 0}
    while queue:
        at = queue.popleft()
        for move in ((1, 1), (1, 0), (0, 1)):
            to = at[0] + move[0], at[1] + move[1]
            if to[0] <= ends[0] and to[1] <= ends[1] and to not in moves and free(*at, move):
                moves[to] = moves[at] + 1
                queue.append(to)
    assert max(ends) < moves[ends] < sum(ends)  # some wait, and some move at once
    assert moves[ends] <= len(path) - 1 <= moves[ends] + 1  # a proof may need more room than a look


def test_paths_that_cannot_pass_each_other_have_no_order() -> None:
    cell, paths = crossing()
    paths[1] = np.array([[0.2, 0.1], [0.2, 0.1]])
    prover = EdgeProver(make_checker(cell.robot, cell.scene, "coal"))
    assert coordinate(paths, [robot.velocity for robot in cell.robots.values()], prover) is None


def test_two_arms_exchange_sides_proven_and_free_by_coal() -> None:
    plan = exchange()
    assert plan.solved
    assert plan.trajectory is not None
    assert plan.trajectory.proven
    judge, moving = CoalWorld(plan.checker.world), plan.checker.world.moving
    for t in np.linspace(0.0, plan.trajectory.duration, 60):
        assert (judge.distances(plan.trajectory.at(t)[0])[moving] > 0).all()
    states = cell_planner().cell.robot.states
    assert np.allclose(plan.trajectory.knots()[[0, -1]], [states["here"], states["there"]])


def test_roadmaps_are_kept_and_equal_calls_give_equal_plans() -> None:
    first = exchange().path
    before = {name: session.live.roadmap.nodes for name, session in cell_planner().sessions.items()}
    assert np.array_equal(cell_planner().plan("here", "there").path, first)
    for name, session in cell_planner().sessions.items():
        kept = session.live.lasting
        assert kept >= 50
        assert np.array_equal(session.live.roadmap.nodes[:kept], before[name][:kept])


def test_a_robot_without_a_goal_stays_and_times_add_up() -> None:
    plan = cell_planner().plan("here", {"left": "home"})
    assert plan.trajectory is not None
    left, right = plan.trajectories.values()
    assert np.allclose(right.knots()[-1], right.knots()[0])
    assert plan.makespan == busy_seconds(plan.trajectory) == pytest.approx(plan.trajectory.duration, abs=1e-3)
    assert plan.flowtime == pytest.approx(busy_seconds(left) + busy_seconds(right))
    assert plan.record.cell is not None
    assert plan.record.config["in_turn"]
    with pytest.raises(OptionError, match="CellPlanner"):
        find_plan(request=plan.request)
    assert plan.record.cell.makespan == plan.makespan


def test_a_motion_split_and_merged_is_the_same_motion() -> None:
    plan = exchange()
    assert plan.trajectory is not None
    parts = split_trajectory(plan.trajectory, plan.robot)
    merged = merge_trajectories(parts, plan.robot, {})
    assert np.array_equal(merged.nanoseconds, plan.trajectory.nanoseconds)
    for mine, own in zip(merged.columns, plan.trajectory.columns, strict=True):
        assert np.array_equal(mine, own)


def test_motions_with_knots_of_their_own_run_on_one_clock() -> None:
    robot, rng = two_planar_arms().robot, np.random.default_rng(0)
    motions = {
        name: Trajectory.from_points(joints, np.cumsum(rng.uniform(0.1, 0.5, 5)), *rng.normal(size=(3, 5, 2)))
        for name, joints in (("a", robot.joints[:2]), ("b", robot.joints[2:]))
    }
    whole = merge_trajectories(motions, robot, {})
    for t in np.linspace(whole.times[0], whole.times[-1], 101):
        expected = np.append(motions["a"].at(t)[0], motions["b"].at(t)[0])
        inside = [motion.times[0] <= t <= motion.times[-1] for motion in motions.values()]
        if all(inside):
            assert np.allclose(whole.at(t)[0], expected, atol=1e-9)


def test_a_check_of_several_files_names_the_links_that_touch_and_when(tmp_path: Path) -> None:
    cell, paths = crossing()
    for (name, columns), path in zip(cell.columns.items(), paths, strict=True):
        motion = Trajectory.from_points(cell.robot.joints[columns], np.array([0.0, 10.0]), path)
        motion.save(tmp_path / f"{name}.json")
    report = check_files([tmp_path / "a.json", tmp_path / "b.json"], PartialWorld(cell=cell, collision="coal"))
    assert not report.ok
    (touch,) = [finding for finding in report.findings if finding.kind == "contact"]
    assert {cell.owner(name) for name in touch.what} == {"a", "b"}
    judge = CoalWorld(make_checker(cell.robot, cell.scene, "coal").world)

    def state(t: float) -> np.ndarray:
        return np.concatenate([first + t / 10 * (last - first) for first, last in paths])

    first = next(t for t in np.linspace(0, 10, 2001).tolist() if (judge.distances(state(t)) <= 0).any())
    assert touch.where[0] == pytest.approx(first, abs=0.05)
    alone = check_files([tmp_path / "a.json"], PartialWorld(cell=cell, collision="coal"))
    assert "contact" not in {finding.kind for finding in alone.findings}


def test_the_command_plans_in_turn_writes_a_file_per_robot_and_checks_them(run: Run, tmp_path: Path) -> None:
    cell, out = ("--cell", str(TWO_ARMS)), str(tmp_path)
    ends = ("--start", "left:here", "--start", "right:here", "--goal", "left:there", "--goal", "right:there")
    turn = ("--in-turn", "--nodes", "60", "--collision", "coal", "--no-page")
    code, text, _ = run("plan", *cell, *ends, *turn, "--out", out)
    assert code == 0
    assert "all rest after" in text
    files = [str(tmp_path / f"trajectory-{name}.json") for name in ("left", "right")]
    code, text, _ = run("check", *cell, *files, "--json", "--collision", "coal")
    assert (code, json.loads(text)["proven"]) == (0, True)
    assert run("export", files[0])[0] == 0
    joints = json.loads((tmp_path / "trajectory-left-ros-json.json").read_text())["joint_names"]
    assert joints == [f"left_panda_joint{k}" for k in range(1, 8)]


REFUSED = {
    "check {files}": (2, "give their cell with --cell"),
    "check {cell} {files}": (3, "not found"),
    "plan --in-turn": (2, "--in-turn plans several robots: give --cell"),
    "plan {cell} --in-turn --goal left:there --approach 0.1": (2, "--approach must be left out with --in-turn"),
    "plan {cell} --robot panda": (2, "--cell names robots and scene: leave out --robot"),
    "plan {cell} --goal middle:there": (3, "robot 'middle' not found: robots are left, right"),
    "plan --cell none.yaml --goal left:there": (3, "cell file none.yaml not found"),
}


@pytest.mark.parametrize("words", REFUSED)
def test_wrong_options_get_one_sentence(words: str, run: Run, tmp_path: Path) -> None:
    code, part = REFUSED[words]
    given = words.format(cell=f"--cell {TWO_ARMS}", files="a.json b.json").split()
    out = ["--out", str(tmp_path)] if given[0] == "plan" else []
    result = run(*given, *out)
    assert result[0] == code
    assert part in result[2]


def test_two_files_for_one_robot_are_refused(tmp_path: Path) -> None:
    cell, paths = crossing()
    Trajectory.from_points(cell.robot.joints[:2], np.array([0.0, 10.0]), paths[0]).save(tmp_path / "a.json")
    with pytest.raises(PlannerError, match="second one of 'a'"):
        check_files([tmp_path / "a.json"] * 2, PartialWorld(cell=cell))
    Trajectory.from_points(("joint_1", "joint_2"), np.array([0.0, 10.0]), paths[0]).save(tmp_path / "c.json")
    with pytest.raises(PlannerError, match="fits robots a, b: give its joints a prefix"):
        check_files([tmp_path / "c.json"], PartialWorld(cell=cell))


def test_a_cell_that_cannot_be_planned_in_turn_is_refused() -> None:
    cell = two_planar_arms()
    moving = MovingObstacle("cart", Box((0.1, 0.1, 0.1)), KnownMotion([0], [pose([3, 0, 0])]))
    with pytest.raises(OptionError, match="plan it together"):
        CellPlanner(Cell("c", cell.robots, Scene("c", moving=(moving,))))
    with pytest.raises(PlannerError, match="option 'roadmap' of a cell planner not found"):
        CellPlanner(cell, roadmap="x.npz")


def test_an_impossible_goal_ends_without_a_path_and_with_its_reason() -> None:
    posts = tuple(Obstacle(f"post {x}", Box((0.1, 0.1, 1.0)), pose([x, 0, 0])) for x in (-0.3, 0.3))
    cell = Cell("blocked", two_planar_arms().robots, Scene("blocked", posts))
    plan = CellPlanner(cell, nodes=40).plan({"a": [1.0, 0.5], "b": [0.8, 0.4]}, {"a": [-1.0, -0.5]})
    assert plan.outcome is Outcome.NO_PATH
    assert plan.reason is not None
    assert plan.reason.names & {"post -0.3", "post 0.3"}
