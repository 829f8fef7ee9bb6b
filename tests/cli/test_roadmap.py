"""``planner roadmap`` as a user types it: what it writes, what it refuses, and that a refusal overwrites nothing."""

from __future__ import annotations

import itertools
import json
import zlib
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


def test_a_plan_in_another_scene_uses_the_edges_that_hold(
    run: Run, kept: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    out = tmp_path / "out"
    code, _, err = run("plan", *world(tmp_path, POST, BALL), "--roadmap", str(kept), "--out", str(out))
    assert code == 0, err
    assert "all edges are proven again" in caplog.text
    assert load_roadmap(out / "roadmap.npz").proven.all()
    other = ("--robot", "ur5", "--scene", "empty", "--start", "home", "--goal", "q:0,0,0,0,0,1")
    refusal = run("plan", *other, "--roadmap", str(kept))
    assert_refused(refusal, 3, "build one for this robot", tmp_path / "nowhere")


@pytest.mark.parametrize("action", ["info"])
def test_missing_damaged_and_foreign_files(run: Run, kept: Path, tmp_path: Path, action: str) -> None:
    name, *more = action.split()
    foreign = tmp_path / "foreign.npz"
    np.savez(foreign, a=np.zeros(3))
    cut = tmp_path / "cut.npz"
    cut.write_bytes(kept.read_bytes()[:-100])
    for file, text in ((foreign, "is damaged or no roadmap"), (cut, "is damaged or no roadmap")):
        refused_and_kept(run("roadmap", name, str(file), *more), text, file, file.read_bytes())
    for file, text in ((tmp_path / "none.npz", "not found"), (tmp_path, "Is a directory")):
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


@pytest.mark.parametrize("arguments", [(), ("build",), ("info",)])
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
