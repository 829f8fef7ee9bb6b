"""``planner roadmap`` as a user types it."""

import itertools
import json
import zlib
from pathlib import Path

import numpy as np
import pytest

from planner.base.interrupts import StopRequest
from planner.roadmap.storage import load_roadmap
from tests.command_line import Run

POST = "{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}"
STATES = 'states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}}'


def scene(folder: Path, *obstacles: str) -> str:
    """A scene file of its own for these obstacles, all of them called "cell" inside."""
    path = folder / f"{zlib.crc32(''.join(obstacles).encode())}.yaml"
    path.write_text(f"name: cell\nobstacles: [{', '.join(obstacles)}]\n{STATES}\n")
    return str(path)


@pytest.fixture
def kept(run: Run, tmp_path: Path) -> Path:
    """A small roadmap of planar_2r and a post, with its scene file."""
    code, out, err = run("roadmap", "build", str(tmp_path / "kept.npz"), *world(tmp_path), "--nodes", "60")
    assert code == 0, err
    assert "60 nodes, 120 edges, 1 component. Start and goal are connected." in out
    return tmp_path / "kept.npz"


def world(folder: Path, *obstacles: str) -> list[str]:
    return ["--robot", "planar_2r", "--scene", scene(folder, *(obstacles or (POST,)))]


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


# Ctrl-C


def interrupt_after(questions: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if Ctrl-C came when the work asks for the so-many-th time: the clock has no part in it."""
    asked = itertools.count(1)
    monkeypatch.setattr(StopRequest, "__call__", lambda self: next(asked) > questions)


def test_an_interrupted_build_saves_its_roadmap(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    interrupt_after(600, monkeypatch)
    code, out, err = run("roadmap", "build", str(tmp_path / "r.npz"), *world(tmp_path), "--nodes", "5000")
    assert code == 130, err
    assert "Interrupted: the result is partial." in out
    assert 10 < len(load_roadmap(tmp_path / "r.npz").nodes) < 5000
