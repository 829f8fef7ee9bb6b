"""``planner roadmap`` as a user types it: what it writes, what it refuses, and that a refusal overwrites nothing."""

from __future__ import annotations

import itertools
import json
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.base.progress import StopRequest
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap, save_roadmap
from tests.command_line import Run, assert_refused

POST = "{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}"
BALL = "{name: ball, type: sphere, radius: 0.08, position: [-0.5, 0.5, 0]}"
STATES = 'states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}}'


def scene(folder: Path, *obstacles: str) -> str:
    """A scene file of its own for these obstacles, all of them called "cell" inside."""
    path = folder / f"{zlib.crc32(''.join(obstacles).encode())}.yaml"
    path.write_text(f"name: cell\nobstacles: [{', '.join(obstacles)}]\n{STATES}\n")
    return str(path)


@pytest.fixture
def kept(run: Run, tmp_path: Path) -> Path:
    """A small roadmap of planar_2r and a post, and its scene file beside it."""
    code, out, err = run("roadmap", "build", str(tmp_path / "kept.npz"), *world(tmp_path), "--nodes", "60")
    assert code == 0, err
    assert "60 nodes, 120 edges, 1 component. Start and goal are joined." in out
    return tmp_path / "kept.npz"


def world(folder: Path, *obstacles: str) -> list[str]:
    return ["--robot", "planar_2r", "--scene", scene(folder, *(obstacles or (POST,)))]


def refused_and_kept(result: tuple[int, str, str], text: str, file: Path, before: bytes, code: int = 3) -> None:
    """Refused with a sentence; the file, and the folder around it, are as they were."""
    assert_refused(result, code, text, file.parent / "nowhere")
    assert file.read_bytes() == before
    assert not [path for path in file.parent.iterdir() if path.name.startswith(".")]


def test_build_is_what_plan_grows(run: Run, kept: Path, tmp_path: Path) -> None:
    code, _, err = run("plan", *world(tmp_path), "--nodes", "60", "--effort", "0", "--out", str(tmp_path / "plan"))
    assert code == 0, err
    assert load_roadmap(tmp_path / "plan" / "roadmap.npz").sha256 == load_roadmap(kept).sha256


def test_build_of_what_cannot_be_joined(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kept all the same. The 40000 motions that it would take to give up on a real one are spared."""
    from planner.construction import obtain

    real = obtain.obtain_roadmap

    def parted(*arguments: Any) -> Roadmap:
        roadmap = real(*arguments)
        return roadmap.part(np.ones(30, dtype=bool), np.zeros(len(roadmap.edges), dtype=bool))

    monkeypatch.setattr(obtain, "obtain_roadmap", parted)
    code, out, _ = run("roadmap", "build", str(tmp_path / "r.npz"), *world(tmp_path), "--nodes", "30")
    assert code == 4
    assert "not connected" in out
    assert not load_roadmap(tmp_path / "r.npz").connected


def test_info(run: Run, kept: Path) -> None:
    roadmap = load_roadmap(kept)
    code, out, _ = run("roadmap", "info", str(kept), "--json")
    facts = json.loads(out)
    assert code == 0
    assert (facts["robot"], facts["scene"], facts["tool"], facts["margin"]) == ("planar_2r", "cell", "tool", 0)
    assert (facts["nodes"], facts["edges"], facts["edges_certified"]) == (60, 120, 120)
    assert facts["components"] == [60]
    assert facts["joints"] == ["joint_1", "joint_2"]
    assert facts["obstacles"] == ["post"]
    assert facts["degree"]["mean"] == 4.0
    assert facts["manipulability"]["0.5"] == pytest.approx(np.median(roadmap.manipulability))
    assert facts["manipulability"]["0"] == roadmap.manipulability.min()
    assert facts["joint_length"]["max"] == roadmap.joint_length.max()
    assert facts["clearance"]["min"] == roadmap.clearance.min()
    assert facts["samples"] == roadmap.samples.sum() > 120
    assert facts["sha256"] == roadmap.sha256
    assert {"seed", "versions", "starts", "goals", "connected", "tool_length", "scale"} <= set(facts)
    code, out, _ = run("roadmap", "info", str(kept))
    assert code == 0
    for part in ("planar_2r", "cell", "60", "120 of them proven free", "1: 60 nodes", "clearance proven", "seed 0"):
        assert part in out


def test_info_of_many_parts_and_nothing_to_touch(run: Run, kept: Path, tmp_path: Path) -> None:
    roadmap = load_roadmap(kept)
    parts = roadmap.part(np.ones(60, dtype=bool), np.zeros(120, dtype=bool))
    save_roadmap(parts, tmp_path / "p.npz")
    code, out, _ = run("roadmap", "info", str(tmp_path / "p.npz"))
    assert code == 0
    shown = " ".join(out.replace("│", " ").split())
    assert "60: 1, 1, 1, 1, 1, 1, 1, 1 nodes and 52 more; start and goal are not joined" in shown
    assert run("roadmap", "info", str(tmp_path / "p.npz"), "--json")[0] == 0


def test_check_of_its_own_world(run: Run, kept: Path, tmp_path: Path) -> None:
    before = kept.read_bytes()
    code, out, _ = run("roadmap", "check", str(kept), "--scene", scene(tmp_path, POST))
    assert code == 0
    assert "120 of 120 edges proven again: 120 hold, 0 undecided, 0 collide." in out
    code, out, _ = run("roadmap", "check", str(kept), *world(tmp_path), "--collision", "coal")
    assert code == 0
    assert kept.read_bytes() == before


def test_built_in_robot_and_scene_need_not_be_named(run: Run, tmp_path: Path) -> None:
    file = str(tmp_path / "r.npz")
    here = ["--robot", "planar_2r", "--scene", "empty", "--start", "q:0,1", "--goal", "q:1,1", "--nodes", "20"]
    assert run("roadmap", "build", file, *here)[0] == 0
    assert run("roadmap", "check", file)[0] == 0
    assert run("roadmap", "extend", file, "--nodes", "5")[0] == 0
    assert len(load_roadmap(Path(file)).nodes) == 25


def test_check_names_what_differs(run: Run, kept: Path, tmp_path: Path) -> None:
    before = kept.read_bytes()
    cases = [
        (world(tmp_path, POST, BALL), "obstacle 'ball' added"),
        (world(tmp_path, POST.replace("0.75, 0, 0", "0.7, 0, 0")), "obstacle 'post' moved"),
        (world(tmp_path, BALL), "obstacle 'post' removed, obstacle 'ball' added"),
        (["--scene", "empty"], "is for scene 'cell', not 'empty'"),
        (["--robot", "iiwa14", "--scene", "paper", "--tool", "flange"], "is for robot 'planar_2r', not 'iiwa14'"),
        (["--robot", "ur5"], "is for robot 'planar_2r', not 'ur5'"),
        ([*world(tmp_path), "--margin", "0.01"], "margin of 0 m, less than the 0.01 m"),
        ([*world(tmp_path), "--tool", "link_2"], "tool frame 'tool', not 'link_2'"),
        ([], "is for scene 'cell', which is not built in: say where it is with --scene"),
        (["--scene", "nowhere.yaml"], "nowhere.yaml not found"),
        (["--robot", "r2d2", "--scene", "empty"], "robot 'r2d2' not found"),
    ]
    for options, text in cases:
        refused_and_kept(run("roadmap", "check", str(kept), *options), text, kept, before)


def test_check_finds_lies(run: Run, kept: Path, tmp_path: Path) -> None:
    roadmap, own = load_roadmap(kept), ["--scene", scene(tmp_path, POST)]
    across = np.array([[0, 1], *roadmap.edges[1:].tolist()])

    def check(lie: Roadmap) -> tuple[int, str, str]:
        save_roadmap(lie, tmp_path / "lie.npz")
        return run("roadmap", "check", str(tmp_path / "lie.npz"), *own)

    # start and goal lie on two sides of the post
    assert_refused(check(replace(roadmap, edges=across)), 3, "1 of 120 edges of roadmap", tmp_path / "nowhere")
    nodes = np.array(roadmap.nodes)
    nodes[-1] = nodes[-1] + [9.0, 0]
    lie = replace(roadmap, nodes=nodes).part(np.ones(60, dtype=bool), (roadmap.edges != 59).all(axis=1))
    assert_refused(check(lie), 3, "1 nodes of roadmap", tmp_path / "nowhere")
    lie = replace(roadmap, manipulability=roadmap.manipulability + 1)
    assert_refused(check(lie), 3, "wrong manipulabilities or lengths", tmp_path / "nowhere")


@pytest.mark.parametrize("more", [1.0, np.inf])
def test_check_finds_clearances_that_are_not_there(run: Run, kept: Path, tmp_path: Path, more: float) -> None:
    """Whoever asks for a larger margin has edges of such certificates kept without another proof."""
    roadmap, lie, own = load_roadmap(kept), tmp_path / "lie.npz", ["--scene", scene(tmp_path, POST)]
    nearest = np.arange(len(roadmap.edges)) == roadmap.clearance.argmin()
    save_roadmap(replace(roadmap, clearance=roadmap.clearance + np.where(nearest, more, 0.0)), lie)
    code, _, error = run("roadmap", "check", str(lie), *own)
    assert code == 3
    assert "which is not proven: prove all anew with --repair" in " ".join(error.split())
    assert run("roadmap", "check", str(lie), *own, "--repair")[0] == 0
    assert run("roadmap", "check", str(lie), *own)[0] == 0


def test_repair(run: Run, kept: Path, tmp_path: Path) -> None:
    before = kept.read_bytes()
    there = world(tmp_path, POST, BALL)
    out = tmp_path / "new" / "repaired.npz"
    code, text, err = run("roadmap", "check", str(kept), *there, "--repair", "--out", str(out))
    assert code == 0, err
    assert "Difference: obstacle 'ball' added." in text
    assert kept.read_bytes() == before
    repaired = load_roadmap(out)
    assert f"{120 - len(repaired.edges)} dropped" in text
    assert 0 < len(repaired.edges) < 120
    assert run("roadmap", "check", str(out), *there)[0] == 0
    assert run("plan", "--roadmap", str(out), *there, "--out", str(tmp_path / "plan"))[0] == 0
    assert run("roadmap", "check", str(kept), *there, "--repair")[0] == 0
    assert load_roadmap(kept).sha256 == repaired.sha256


def test_repair_refused(run: Run, kept: Path, tmp_path: Path) -> None:
    before = kept.read_bytes()
    cases = [
        (
            ["--robot", "iiwa14", "--scene", "paper", "--tool", "flange", "--repair"],
            "is for robot 'planar_2r', not 'iiwa14'",
            3,
        ),
        ([*world(tmp_path), "--out", str(tmp_path / "x.npz")], "--out says where a repaired roadmap goes", 2),
        ([*world(tmp_path), "--repair", "--out", str(tmp_path)], "is a folder", 3),
        ([*world(tmp_path), "--repair", "--out", str(kept / "x.npz")], "cannot be written", 3),
        ([*world(tmp_path, "{name: all, type: sphere, radius: 9}"), "--repair"], "nothing of the roadmap is free", 3),
        ([*world(tmp_path), "--repair", "--margin", "-1"], "margin -1", 2),
    ]
    for options, text, code in cases:
        refused_and_kept(run("roadmap", "check", str(kept), *options), text, kept, before, code)


def test_extend(run: Run, kept: Path, tmp_path: Path) -> None:
    before, own = load_roadmap(kept), ["--scene", scene(tmp_path, POST)]
    code, out, err = run("roadmap", "extend", str(kept), "--nodes", "20", *own)
    assert code == 0, err
    after = load_roadmap(kept)
    assert "20 nodes and 40 edges more: 80 nodes, 160 edges, 1 component." in out
    np.testing.assert_array_equal(after.nodes[:60], before.nodes)
    assert run("roadmap", "check", str(kept), *own)[0] == 0
    save_roadmap(before, kept)
    copy = tmp_path / "copy.npz"
    assert run("roadmap", "extend", str(kept), "--nodes", "20", "--out", str(copy), *own)[0] == 0
    assert load_roadmap(copy).sha256 == after.sha256
    assert load_roadmap(kept).sha256 == before.sha256
    assert run("roadmap", "extend", str(kept), "--nodes", "20", "--seed", "5", "--out", str(copy), *own)[0] == 0
    assert load_roadmap(copy).sha256 != after.sha256


def test_extend_refused(run: Run, kept: Path, tmp_path: Path) -> None:
    before = kept.read_bytes()
    cases = [
        ([*world(tmp_path), "--nodes", "0"], "0 nodes are no extension", 2),
        ([*world(tmp_path), "--nodes", "5", "--seed", "-1"], "seed -1", 2),
        ([*world(tmp_path), "--nodes", "99999999"], "make no roadmap", 2),
        (world(tmp_path), "--nodes", 2),
        ([*world(tmp_path, POST, BALL), "--nodes", "5"], "obstacle 'ball' added", 3),
        ([*world(tmp_path), "--nodes", "5", "--out", str(tmp_path)], "is a folder", 3),
    ]
    for options, text, code in cases:
        refused_and_kept(run("roadmap", "extend", str(kept), *options), text, kept, before, code)


@pytest.mark.parametrize("action", ["info", "check", "check --repair", "extend --nodes 5"])
def test_missing_damaged_and_foreign_files(run: Run, kept: Path, tmp_path: Path, action: str) -> None:
    name, *more = action.split()
    foreign = tmp_path / "foreign.npz"
    np.savez(foreign, a=np.zeros(3))
    cut = tmp_path / "cut.npz"
    cut.write_bytes(kept.read_bytes()[:-100])
    for file, text in ((foreign, "is damaged or no roadmap"), (cut, "is damaged or no roadmap")):
        refused_and_kept(run("roadmap", name, str(file), *more), text, file, file.read_bytes())
    for file, text in ((tmp_path / "none.npz", "not found"), (tmp_path, "is a folder")):
        assert_refused(run("roadmap", name, str(file), *more), 3, text, tmp_path / "none.npz")


def test_build_refused(run: Run, kept: Path, tmp_path: Path) -> None:
    before, here = kept.read_bytes(), world(tmp_path)
    cases = [
        ([str(kept), "--robot", "r2d2"], "robot 'r2d2' not found", 3),
        ([str(kept), *here, "--start", "q:-0.5,1.2"], "start is in collision", 3),
        ([str(kept), *here, "--nodes", "1"], "1 nodes make no roadmap", 2),
        ([str(tmp_path), *here], "is a folder", 3),
        ([str(kept / "r.npz"), *here], "cannot be written", 3),
        ([*here], "file", 2),
    ]
    for options, text, code in cases:
        refused_and_kept(run("roadmap", "build", *options), text, kept, before, code)


@pytest.mark.parametrize("arguments", [(), ("build",), ("info",), ("check",), ("extend",)])
def test_help(run: Run, arguments: tuple[str, ...]) -> None:
    code, out, _ = run("roadmap", *arguments, "--help")
    assert code == 0
    assert "usage: planner roadmap" in out


def test_debug_shows_where(run: Run, kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from planner import cli
    from planner.base.errors import FileError

    monkeypatch.setattr("sys.argv", ["planner", "roadmap", "info", str(kept.parent / "none.npz"), "--debug"])
    with pytest.raises(FileError):
        cli.main()


# Ctrl-C


def interrupt_after(questions: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if Ctrl-C came when the work asks for the so-many-th time: the clock has no part in it."""
    asked = itertools.count(1)
    monkeypatch.setattr(StopRequest, "__call__", lambda self: next(asked) > questions)


def test_an_interrupted_build_keeps_what_there_is(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    interrupt_after(600, monkeypatch)
    code, out, err = run("roadmap", "build", str(tmp_path / "r.npz"), *world(tmp_path), "--nodes", "5000")
    assert code == 130, err
    assert "Interrupted: this is what was done so far." in out
    assert 10 < len(load_roadmap(tmp_path / "r.npz").nodes) < 5000


def test_an_interrupted_extension_keeps_what_there_is(run: Run, kept: Path, tmp_path: Path, monkeypatch) -> None:
    before = load_roadmap(kept)
    interrupt_after(60, monkeypatch)
    code, _, err = run("roadmap", "extend", str(kept), "--nodes", "5000", *world(tmp_path))
    assert code == 130, err
    after = load_roadmap(kept)
    assert 60 < len(after.nodes) < 5000
    np.testing.assert_array_equal(after.nodes[:60], before.nodes)


def test_an_interrupted_check_says_how_far_it_came(run: Run, kept: Path, tmp_path: Path, monkeypatch) -> None:
    before = kept.read_bytes()
    interrupt_after(0, monkeypatch)
    code, out, _ = run("roadmap", "check", str(kept), *world(tmp_path))
    assert (code, out.split(":")[0]) == (130, "0 of 120 edges proven again")
    code, out, _ = run("roadmap", "check", str(kept), *world(tmp_path, POST, BALL), "--repair")
    assert code == 130
    assert "is as it was" in out
    assert kept.read_bytes() == before
