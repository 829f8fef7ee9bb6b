"""``planner bench plan``: problems, rows, outcomes, the report, and the log that OMPL's own tool reads."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError, OptionError
from planner.base.progress import Progress
from planner.base.request import PlanRequest
from planner.paths.measure import joint_path_length
from planner.planning import plan
from planner.studies.bench_plan import run as bench
from planner.studies.bench_plan.problems import find_problems
from planner.studies.bench_plan.rows import CRASHED, REFUSED, SOLVED, TIMED_OUT, Row, by_settings
from planner.studies.bench_plan.run import bench_plan
from planner.studies.bench_roadmap.ompl_log import to_log, write_logs
from planner.studies.table import read_rows
from tests.worlds import load

PLAIN = PlanRequest(robot="planar_2r", nodes=40, collision="coal")


def write_problem(folder: Path, number: str, start: tuple[float, float], goal: tuple[float, float]) -> None:
    """planar_2r around a post, as MoveIt's messages."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"scene{number}.yaml").write_text(
        "name: post\nworld:\n  collision_objects:\n    - id: post\n      primitives:\n"
        "        - {type: box, dimensions: [0.1, 0.02, 0.2]}\n      primitive_poses:\n"
        "        - {position: [0.75, 0, 0], orientation: [0, 0, 0, 1]}\n"
    )
    names = load("planar_2r").joints
    goals = "".join(f"      - {{joint_name: {n}, position: {v}}}\n" for n, v in zip(names, goal, strict=True))
    (folder / f"request{number}.yaml").write_text(
        f"start_state:\n  joint_state:\n    name: [{', '.join(names)}]\n    position: [{start[0]}, {start[1]}]\n"
        f"goal_constraints:\n  - joint_constraints:\n{goals}"
    )


@pytest.fixture(scope="module")
def problems(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One that is solved, and one whose goal is out of limits."""
    folder = tmp_path_factory.mktemp("problems")
    write_problem(folder / "posts", "0001", (-1.0, 0.8), (1.0, -0.8))
    write_problem(folder / "far", "0001", (-1.0, 0.8), (1.0, -2.99))
    return folder


@pytest.fixture(scope="module")
def out(problems: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("bench")
    assert bench_plan(problems, place, PLAIN, seeds=(0, 1)).complete
    return place


def rows_of(out: Path) -> list[Row]:
    return read_rows(out / "plan.csv", Row, "planner bench plan")


def test_problems_are_found_in_folders_and_flat(problems: Path, tmp_path: Path) -> None:
    found = find_problems(problems)
    assert [(p.name, p.kind) for p in found] == [("far/0001", "far"), ("posts/0001", "posts")]
    assert len({p.content for p in found}) == 2
    flat = find_problems(problems / "posts")
    assert [(p.name, p.kind) for p in flat] == [("posts/0001", "posts")]
    assert flat[0].content == found[1].content
    write_problem(tmp_path, "_a", (0, 0), (1, 1))
    (tmp_path / "scene_a.yaml").rename(tmp_path / "scene_a.scene")
    (tmp_path / "request_b.yml").write_text("")
    (tmp_path / "scene0001_sensed.yaml").write_text("")
    a, b = find_problems(tmp_path)
    assert (a.name, a.scene.name) == (f"{tmp_path.name}/_a", "scene_a.scene")
    assert (b.scene.name, b.scene.exists(), b.content) == ("scene_b.yaml", False, "")


def test_a_folder_without_problems_is_refused(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(FileError, match="holds no problems"):
            bench_plan(folder, tmp_path / "out", PLAIN)
    assert not (tmp_path / "out").exists()


def test_every_run_has_a_row(out: Path) -> None:
    rows = rows_of(out)
    assert [(r.problem, r.seed, r.outcome) for r in rows] == [
        ("far/0001", 0, REFUSED),
        ("far/0001", 1, REFUSED),
        ("posts/0001", 0, SOLVED),
        ("posts/0001", 1, SOLVED),
    ]
    for row in rows[:2]:
        assert "by 0.0229 rad" in row.message
        assert row.nodes is row.contacts is row.total_s is None
    for row in rows[2:]:
        assert row.certified == row.edges
        assert row.contacts == 0
        assert row.nodes is not None
        assert row.nodes >= 40
        assert row.total_s is not None
        assert row.process_s is not None
        assert row.first_path_s is not None
        assert 0 < row.first_path_s < row.total_s < row.process_s


def test_a_row_is_the_plan(problems: Path, out: Path) -> None:
    """Length, w and clearance of the row against the same plan made here."""
    row = rows_of(out)[3]
    problem = find_problems(problems)[1]
    made = plan(replace(PLAIN, scene=str(problem.scene), motion_plan_request=problem.request, seed=1))
    assert row.length_rad == pytest.approx(joint_path_length(made.path))
    assert row.waypoints == len(made.path)
    assert row.edges == len(made.roadmap.edges)
    assert row.w_min is not None
    assert row.w_mean is not None
    elbow = np.abs(np.sin(made.path[:, 1]))  # a planar arm's w is l1 l2 |sin q2|
    assert row.w_min <= 0.5 * 0.4 * elbow.min() + 1e-9
    assert 0 < row.w_min < row.w_mean
    assert row.clearance_m is not None
    assert row.clearance_m > 0


def test_rows_that_hold_are_not_measured_again(problems: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda run, progress, **_: measured.append(run[1].seed) or [])
    again = bench_plan(problems, out, PLAIN, seeds=(0, 1))
    assert (measured, again.complete, len(again.rows)) == ([], True, 4)
    # another seed, other settings, other software or a limit that a row was over: measured anew
    for change in ({"seeds": (2,)}, {"plain": replace(PLAIN, beta=1.0)}, {"time_limit": 1e-3}):
        measured.clear()
        stopped = bench_plan(problems, out, **{"plain": PLAIN, "seeds": (0,)} | change)  # type: ignore[arg-type]
        assert len(measured) == 1
        assert not stopped.complete
    measured.clear()
    monkeypatch.setattr(bench, "software", lambda versions: "newer")
    bench_plan(problems, out, PLAIN, seeds=(0,))
    assert measured == [0]


def test_a_changed_problem_is_measured_again(problems: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda run, progress, **_: measured.append(run[0].name) or [])
    write_problem(problems / "far", "0001", (-1.0, 0.8), (1.0, -2.98))
    try:
        bench_plan(problems, out, PLAIN, seeds=(0,))
    finally:
        write_problem(problems / "far", "0001", (-1.0, 0.8), (1.0, -2.99))
    assert measured == ["far/0001"]


def test_the_limit_kills_and_says_so(problems: Path, tmp_path: Path) -> None:
    found = bench_plan(problems / "posts", tmp_path, PLAIN, seeds=(0,), time_limit=0.05)
    assert found.complete
    assert found.rows[0].outcome == TIMED_OUT
    assert "killed after 0.05 s" in found.rows[0].message
    assert "| posts | 1 | 0 | 0 | 0 % | 0 | 1 |" in found.report
    # under a higher limit it is measured again, under a lower one it stays
    assert bench_plan(problems / "posts", tmp_path, PLAIN, seeds=(0,), time_limit=0.04).rows == found.rows
    assert bench_plan(problems / "posts", tmp_path, PLAIN, seeds=(0,), time_limit=100).rows[0].outcome == SOLVED


def test_a_crash_is_a_row(problems: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench.json, "dumps", lambda value: "{")
    row = bench_plan(problems / "posts", tmp_path, PLAIN, seeds=(0,)).rows[0]
    assert row.outcome == CRASHED
    assert "ended with code 1: json.decoder.JSONDecodeError" in row.message


def test_a_stop_saves_what_there_is(problems: Path, tmp_path: Path) -> None:
    calls = iter([False] * 3)
    found = bench_plan(problems, tmp_path, PLAIN, seeds=(0,), progress=Progress(stop=lambda: next(calls, True)))
    assert not found.complete
    assert found.rows == ()
    assert "Interrupted: the runs that were not measured" in (tmp_path / "plan.md").read_text()


def row(**more) -> Row:
    plain = Row(
        *("posts/1", "posts", 0, "panda", "coal", 1000, 1.0, False, "", 60.0, "abcd", "here", SOLVED, "yes"),
        total_s=2.0,
        process_s=3.0,
        first_path_s=0.3,
        nodes=1000,
        edges=2000,
        certified=2000,
        waypoints=5,
        length_rad=4.0,
        length_m=1.0,
        w_min=0.02,
        w_mean=0.06,
        clearance_m=0.004,
        contacts=0,
        memory_mib=200.0,
    )
    return replace(plain, **more)


def bare(outcome: str, **more) -> Row:
    """A run that was not solved."""
    empty = dict.fromkeys(("total_s", "first_path_s", "nodes", "edges", "certified", "waypoints", "length_rad"))
    empty |= dict.fromkeys(("length_m", "w_min", "w_mean", "clearance_m", "contacts", "memory_mib"))
    return row(outcome=outcome, message="why", **empty | more)


def test_options_of_a_plan_tell_rows_apart(problems: Path) -> None:
    problem = find_problems(problems)[1]
    plain = bench._blank(problem, PLAIN, 60.0)
    kept = bench._blank(problem, replace(PLAIN, margin=0.01), 60.0)
    assert plain.options == ""
    assert kept.options == "margin 0.01"
    assert len(by_settings([plain, kept])) == 2


def test_ompls_own_tool_reads_the_log(out: Path, tmp_path: Path) -> None:
    logs = sorted((out / "logs").glob("*.log"))
    assert [path.name for path in logs] == ["far_0001.log", "posts_0001.log"]
    made = [bare(CRASHED, problem="p q/2", kind="p q"), row(problem="p q/2", kind="p q", beta=0.0, contacts=2)]
    logs += write_logs(made, tmp_path / "logs")
    command = [sys.executable, "-m", "ompl.ompl_benchmark_statistics", "-d", str(tmp_path / "b.db"), *map(str, logs)]
    subprocess.run(command, check=True, capture_output=True, text=True)
    base = sqlite3.connect(tmp_path / "b.db")
    query = "SELECT e.name, p.name, r.* FROM runs r, experiments e, plannerConfigs p WHERE e.id = r.experimentid"
    cursor = base.execute(f"{query} AND p.id = r.plannerid")
    names = [column[0] for column in cursor.description]
    found = [dict(zip(names[2:], line[2:], strict=True)) | {"of": line[:2]} for line in cursor]
    base.close()
    assert len(found) == 6
    solved = [run for run in found if run["solved"] == 1]
    assert len(solved) == 3
    assert {run["seed"] for run in solved if run["of"][0] == "posts_0001"} == {0, 1}
    rows = {row.seed: row for row in rows_of(out) if row.outcome == SOLVED}
    for run in solved[:2]:
        kept = rows[run["seed"]]
        assert run["time"] == pytest.approx(kept.total_s)
        assert run["solution_length"] == pytest.approx(kept.length_rad)
        assert (run["graph_states"], run["correct_solution"], run["status"]) == (kept.nodes, 1, 6)
    ours = [run for run in found if run["of"][0] == "p_q_2"]
    assert sorted((run["status"], run["correct_solution"]) for run in ours) == [(6, 0), (7, None)]
    assert {run["of"][1] for run in ours} == {f"gabf (panda, coal, 1000 nodes, beta {b})" for b in (0, 1)}
    refused = [run for run in found if run["of"][0] == "far_0001"]
    assert all(run["status"] == 1 and run["solution_length"] is None for run in refused)
    assert to_log("a b", made).splitlines()[1] == "Experiment a_b"


def test_wrong_input(problems: Path, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="scene is what each problem says"):
        bench_plan(problems, tmp_path, replace(PLAIN, scene="shelf"))
    with pytest.raises(OptionError, match="time limit"):
        bench_plan(problems, tmp_path, PLAIN, time_limit=0.0)
    with pytest.raises(OptionError, match="at least one seed"):
        bench_plan(problems, tmp_path, PLAIN, seeds=())
    with pytest.raises(OptionError, match="seed -1"):
        bench_plan(problems, tmp_path, PLAIN, seeds=(-1,))
