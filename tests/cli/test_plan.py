"""The commands as a user types them: results, bad input with its sentence and exit code, Ctrl-C, fresh processes."""

from __future__ import annotations

import importlib.metadata
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planner.problem.request import PlanRequest
from planner.setup.open import make_query
from tests.command_line import Run, assert_refused, assert_total_covers, command
from tests.worlds import ROBOTS, joint_xml, link_xml, load, planar_trap


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small plan, made once."""
    out = tmp_path_factory.mktemp("solved")
    process = command("plan", "--nodes", "120", "--out", str(out), cwd=out)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    return out


def test_plan_writes_the_contract(solved: Path) -> None:
    record = json.loads((solved / "plan.json").read_text())
    assert record["outcome"] == "solved"
    assert {"robot", "scene", "seed", "config", "versions", "path", "path_nodes", "timings_s"} <= set(record)
    assert set(record["cost"]) == {"total", "manipulability", "distance", "beta"}
    assert {"min", "mean"} <= set(record["manipulability"])
    assert {"nodes", "edges", "components", "edges_certified", "sha256"} <= set(record["roadmap"])
    assert {
        "law",
        "prescribed_time",
        "settling_time",
        "settling_tau",
        "steps",
        "max_error_vs_oracle",
        "certificate",
    } <= set(record["gabf"])
    stages = {"import", "setup", "roadmap", "improve", "costs", "gabf", "path", "timing", "alternatives"}
    assert_total_covers(record["timings_s"], stages | {"files", "settling", "record", "page"})
    assert record["gabf"]["max_error_vs_oracle"] <= 1e-12
    assert record["gabf"]["settling_time"] < record["gabf"]["prescribed_time"]
    bounds = [bound for bound in record["gabf"]["certificate"] if bound["quantity"] == "settling tau"]
    assert len(bounds) >= 3
    assert all(bound["applies"] and bound["holds"] for bound in bounds)
    assert record["roadmap"]["nodes"] == 120
    assert len(record["path"]) == len(record["path_nodes"]) >= 3
    assert len(record["path"][0]) == 7
    cost = record["cost"]
    assert cost["total"] == pytest.approx(0.5 * cost["manipulability"] + 0.5 * cost["distance"], rel=1e-12)
    assert {path.name for path in solved.iterdir()} == {"plan.json", "plan.html", "roadmap.npz", "trajectory.json"}


def test_two_fresh_processes_give_the_same_path_under_load(tmp_path: Path) -> None:
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        runs = [command("plan", "--nodes", "150", "--seed", "3", "--out", f"o{k}", cwd=tmp_path) for k in range(2)]
        for process in runs:
            process.communicate(timeout=300)
            assert process.returncode == 0
    finally:
        for process in busy:
            process.kill()
            process.wait()
    first, second = (json.loads((tmp_path / f"o{k}" / "plan.json").read_text()) for k in range(2))
    assert first["path"] == second["path"]
    assert first["roadmap"]["sha256"] == second["roadmap"]["sha256"]
    assert (tmp_path / "o0" / "roadmap.npz").read_bytes() == (tmp_path / "o1" / "roadmap.npz").read_bytes()


def test_a_written_roadmap_is_planned_on_again(solved: Path, tmp_path: Path, run: Run) -> None:
    code, _, _ = run("plan", "--roadmap", str(solved / "roadmap.npz"), "--beta", "0.9", "--out", str(tmp_path / "o"))
    assert code == 0
    before = json.loads((solved / "plan.json").read_text())
    after = json.loads((tmp_path / "o" / "plan.json").read_text())
    assert after["roadmap"]["sha256"] == before["roadmap"]["sha256"]
    assert after["roadmap"]["scale"] == before["roadmap"]["scale"]


def test_version(run: Run) -> None:
    assert run("--version")[:2] == (0, f"gabf-planner {importlib.metadata.version('gabf-planner')}\n")


FOLDED = ("--robot", "planar_2r", "--scene", "empty", "--nodes", "30")


def test_goals_given_several_times_are_of_equal_right(run: Run, tmp_path: Path) -> None:
    """The nearer one is reached, wherever it stands among them, and named in summary and record."""
    near, far = "q:0.2,1.1", "xyz:-0.3,-0.5,0"
    for k, goals in enumerate((("--goal", far, f"--goal={near}"), ("--goal", near, "--goal", far))):
        out = tmp_path / str(k)
        code, words, _ = run("plan", *FOLDED, "--start", "q:0,1", *goals, "--beta", "1", "--out", str(out))
        assert code == 0
        assert near in words
        record = json.loads((out / "plan.json").read_text())
        assert record["goal"] == near
        assert record["path"][-1] == [0.2, 1.1]


def test_errors_name_the_goal_that_is_meant(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for bad, words in (
        ("q:0,9", "goal 'q:0,9' puts joint 'joint_2' at 9"),
        ("xyz:3,0,0", "goal 'xyz:3,0,0' (3, 0, 0) cannot be reached"),
        (
            "nowhere",
            "goal 'nowhere' is not among the scene's states for planar_2r (its states are start, goal, home)",
        ),
    ):
        asked = run("plan", *FOLDED, "--start", "q:0,1", "--goal", "home", "--goal", bad, "--out", str(out))
        assert_refused(asked, 3, words, out)


def test_other_options_given_twice_are_refused(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert_refused(
        run("plan", "--start", "home", "--start=goal"), 2, "option --start is given twice: give it once", out
    )
    assert_refused(run("plan", "--ik_solutions", "3", "--ik-solutions", "4"), 2, "--ik-solutions is given twice", out)


@pytest.mark.parametrize("robot", ROBOTS)
def test_home_is_known_everywhere(robot: str) -> None:
    """As ``view`` knows it: the scene's own, or else the robot's."""
    query = make_query(PlanRequest(robot=robot, scene="empty", start="home", goal="home"))
    home = load(robot).normalise(load(robot).home)
    np.testing.assert_allclose(query.starts, home[None], atol=1e-12)
    np.testing.assert_allclose(query.goals, home[None], atol=1e-12)
    assert query.goal_names == ("home",)


def test_home_of_a_robot_of_which_nobody_says_it(urdf_file: Callable[..., str]) -> None:
    inside = link_xml("a") + link_xml("b") + link_xml("c", '<sphere radius="0.1"/>')
    inside += joint_xml("turn", "a", "b", limit="0.5 1.5", xyz="0 0 1")
    inside += joint_xml("bend", "b", "c", axis="0 1 0", xyz="1 0 0")
    query = make_query(PlanRequest(robot=urdf_file(inside), scene="empty", start="home", goal="q:1,1"))
    np.testing.assert_array_equal(query.starts, [[0.5, 0.0]])


@pytest.mark.parametrize("arguments", [(), ("plan",), ("robots",), ("scenes",)])
def test_help_teaches(run: Run, arguments: tuple[str, ...]) -> None:
    code, out, _ = run(*arguments, "--help")
    assert code == 0
    assert "usage: planner" in out


SCENE_HEAD = "name: bad\nobstacles:\n"
BAD_SCENES = {
    "broken YAML": ("obstacles: [", "not valid YAML"),
    "unknown key": ("obstacels: []", "unknown key 'obstacels'"),
    "zero-size box": (
        SCENE_HEAD + "  - {name: a, type: box, size: [0.1, 0, 0.1]}",
        "greater than or equal to 0.000001",
    ),
    "unknown shape": (SCENE_HEAD + "  - {name: a, type: cone, radius: 1}", "'cone'"),
    "NaN": (SCENE_HEAD + "  - {name: a, type: sphere, radius: .nan}", "obstacles.0"),
    "two rotations": (
        SCENE_HEAD + "  - {name: a, type: sphere, radius: 1, rpy: [0, 0, 0], quaternion: [0, 0, 0, 1]}",
        "not both",
    ),
    "zero quaternion": (SCENE_HEAD + "  - {name: a, type: sphere, radius: 1, quaternion: [0, 0, 0, 0]}", "zero length"),
    "same name twice": (
        SCENE_HEAD + "  - {name: a, type: sphere, radius: 1}\n  - {name: a, type: sphere, radius: 1}",
        "used twice",
    ),
    "missing mesh": (SCENE_HEAD + "  - {name: a, type: mesh, file: none.stl}", "none.stl not found"),
    "a Python object": ("obstacles: !!python/object/apply:os.system ['touch /tmp/owned']", "not valid YAML"),
    "a list": ("- 1\n- 2", "no mapping"),
}

BAD_OPTIONS = [
    (["--robot", "r2d2"], 3, "robot 'r2d2' not found"),
    (["--robot", "nowhere/arm.urdf"], 3, "nowhere/arm.urdf not found"),
    (["--scene", "moon"], 3, "scene 'moon' not found"),
    (["--scene", "nowhere/s.yaml"], 3, "nowhere/s.yaml not found"),
    (["--scene", "a\nb"], 3, r"scene 'a\nb' not found"),
    (["--goal", "xyz:1e200,0,0"], 3, "beyond any arm's 10000"),
    (["--tool", "tol0"], 3, "frame 'tol0' not found; frames are"),
    (["--start", "q:0,0"], 3, "2 joint values, iiwa14 has 7"),
    (["--start", "q:nan,0,0,0,0,0,0"], 3, "not finite"),
    (["--goal", "xyz:0.5,inf,0.5"], 3, "not finite"),
    (["--start", "q:0,9,0,0,0,0,0"], 3, "joint 'iiwa14_joint_2' at 9, outside its limits"),
    (["--goal", "xyz:3,0,0.5"], 3, "beyond the arm's reach"),
    (["--start", "nowhere"], 3, "'nowhere' is not among the scene's states"),
    (["--goal", "pose:0.4,0,0.6,0,0,0,0"], 3, "zero length"),
    (["--roadmap", "none.npz"], 3, "none.npz not found"),
    (["--beta", "1.5"], 2, "outside [0, 1]"),
    (["--beta", "nan"], 2, "outside [0, 1]"),
    (["--beta", "much"], 2, "--beta"),
    (["--nodes", "-5"], 2, "-5 nodes"),
    (["--nodes", "1.5"], 2, "--nodes"),
    (["--prescribed-time", "0"], 2, "prescribed time 0"),
    (["--margin", "-1"], 2, "margin -1"),
    (["--seed", "-1"], 2, "seed -1"),
    (["--law", "newton"], 2, "'newton'"),
    (["--start", "q:0,zero"], 2, "no number"),
    (["--start", "abc:1,2"], 2, "starts with 'abc:'"),
    (["--goal", "xyz:1,2"], 2, "has 2 numbers, 'xyz:' takes 3"),
    (["--betta", "0.5"], 2, "--betta"),
]


@pytest.mark.parametrize(("options", "code", "text"), BAD_OPTIONS, ids=lambda value: str(value))
def test_bad_options(run: Run, tmp_path: Path, options: list[str], code: int, text: str) -> None:
    out = tmp_path / "out"
    assert_refused(run("plan", "--out", str(out), *options), code, text, out)


@pytest.mark.parametrize("name", BAD_SCENES)
def test_bad_scene_files(run: Run, tmp_path: Path, name: str) -> None:
    content, text = BAD_SCENES[name]
    (tmp_path / "scene.yaml").write_text(content)
    out = tmp_path / "out"
    assert_refused(run("plan", "--scene", str(tmp_path / "scene.yaml"), "--out", str(out)), 3, text, out)
    assert not Path("/tmp/owned").exists()


def test_start_in_collision_names_the_pair(run: Run, tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(
        "obstacles:\n  - {name: lump, type: sphere, radius: 0.2, position: [0, 0, 1.2]}\n"
        "states:\n  iiwa14: {start: 'q:0,0,0,0,0,0,0', goal: 'q:0,1,0,0,0,0,0'}\n"
    )
    out = tmp_path / "out"
    result = run("plan", "--scene", str(tmp_path / "s.yaml"), "--out", str(out))
    assert_refused(result, 3, "start is in collision: 'iiwa14_link_", out)
    assert "'lump'" in result[2]


def test_unwritable_folder(run: Run, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("precious")
    code, _, error = run("plan", "--out", str(tmp_path / "file" / "out"))
    assert code == 3
    assert "cannot be written" in error
    assert (tmp_path / "file").read_text() == "precious"


def test_damaged_and_foreign_roadmaps(run: Run, solved: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    whole = (solved / "roadmap.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    result = run("plan", "--roadmap", str(tmp_path / "cut.npz"), "--out", str(out))
    assert_refused(result, 3, "is damaged or no roadmap", out)
    result = run("plan", "--roadmap", str(solved / "roadmap.npz"), "--robot", "panda", "--start",
                 "q:0,-0.785,0,-2.356,0,1.571,0.785", "--goal", "q:0.5,-0.785,0,-2.356,0,1.571,0.785",
                 "--scene", "empty", "--out", str(out))  # fmt: skip
    assert_refused(result, 3, "build one for this robot", out)
    assert (solved / "roadmap.npz").read_bytes() == whole


def test_no_path_is_an_outcome(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    code, text, _ = run("plan", "--robot", "planar_2r", "--scene", str(planar_trap(tmp_path)), "--start", "q:0,0.5",
                        "--goal", "q:2.5,0.5", "--nodes", "40", "--out", str(out))  # fmt: skip
    record = json.loads((out / "plan.json").read_text())
    assert code == 4, text
    assert record["outcome"] == "no_path"
    assert record["reason"]["kind"] == "separated"
    assert f"'{record['reason']['obstacles'][0]}' separates them" in record["message"]
    assert record["message"] in text
    assert record["path"] == []
    assert record["cost"] is None
    assert record["roadmap"]["components"] >= 2
    assert (out / "roadmap.npz").is_file()
    assert (out / "plan.html").is_file()


def test_ctrl_c_saves_what_there_is(tmp_path: Path) -> None:
    process = command("plan", "--nodes", "200000", "--out", "o", cwd=tmp_path)
    loaded, until = Path(f"/proc/{process.pid}/maps"), time.monotonic() + 60.0
    while "ompl" not in loaded.read_text() and time.monotonic() < until:  # imports take their time on a busy machine
        time.sleep(0.1)
    time.sleep(3)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    record = json.loads((tmp_path / "o" / "plan.json").read_text())
    assert record["outcome"] == "interrupted"
    assert record["roadmap"]["nodes"] > 10
    assert (tmp_path / "o" / "roadmap.npz").is_file()


def test_every_law_plans(solved: Path, tmp_path: Path, run: Run) -> None:
    paths = []
    for law in ("nominal", "prescribed-time", "fixed-time", "singularity-free"):
        out = tmp_path / law
        code, _, error = run("plan", "--law", law, "--roadmap", str(solved / "roadmap.npz"), "--out", str(out))
        assert code == 0, error
        record = json.loads((out / "plan.json").read_text())
        assert record["gabf"]["max_error_vs_oracle"] <= 1e-9
        paths.append(record["path"])
    assert all(path == paths[0] for path in paths)


def test_every_option_changes_what_it_says(solved: Path, tmp_path: Path, run: Run) -> None:
    def plan(*options: str) -> dict:
        out = tmp_path / "o"
        code, _, error = run("plan", "--roadmap", str(solved / "roadmap.npz"), "--out", str(out), *options)
        assert code == 0, error
        return json.loads((out / "plan.json").read_text())

    base = plan()
    assert plan("--metric", "workspace")["cost"]["distance"] != base["cost"]["distance"]
    assert plan("--manipulability-cost", "inverse")["cost"]["manipulability"] != base["cost"]["manipulability"]
    assert plan("--prescribed-time", "2")["gabf"]["settling_time"] < 2
    assert plan("--beta", "1")["cost"]["total"] == plan("--beta", "1")["cost"]["distance"]
    # a start that is no node yet is linked to the roadmap through proven edges
    between = 0.7 * np.array(base["path"][0]) + 0.3 * np.array(base["path"][1])
    moved = plan("--start", "q:" + ",".join(map(repr, between.tolist())))
    assert np.allclose(moved["path"][0], between)
    assert moved["roadmap"]["nodes"] > base["roadmap"]["nodes"]  # and shortcuts may cut it up
