"""The page in a real browser: it gets ready, asks the network for nothing, and shows what it should."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from browser import opened, page_data
from PIL import Image

from planner import PlanRequest
from planner.plan import plan
from planner.view.page import _frames, write_plan_page


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "plan.html"
    write_plan_page(plan(PlanRequest(nodes=100)), path)
    return path


def test_the_page_gets_ready_offline(page: Path) -> None:
    with opened(page) as tab:
        assert tab.settled(), tab.console
        text = tab.run("document.body.innerText")
        assert tab.requests == []
        assert tab.console == []
    for expected in ("iiwa14 in paper", "A collision-free path was found.", "100 nodes", "manipulability"):
        assert expected in text


def test_scrub_and_play_move_the_robot(page: Path, tmp_path: Path) -> None:
    with opened(page) as tab:
        assert tab.settled()
        assert tab.run("document.documentElement.dataset.frame") == "0"
        tab.screenshot(tmp_path / "start.png")
        tab.run("(() => { const s = document.getElementById('scrub'); s.value = 1000; s.oninput(); })()")
        assert tab.run("document.documentElement.dataset.frame") == str(len(page_data(page)["motion"]["frames"]) - 1)
        tab.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")
        tab.screenshot(tmp_path / "end.png")
        assert 0.005 < _changed(tmp_path / "start.png", tmp_path / "end.png") < 0.3
        tab.run("document.getElementById('play').onclick()")
        tab.run("new Promise(done => setTimeout(() => done(1), 600))")
        tab.run("document.getElementById('play').onclick()")
        assert 0 < int(tab.run("document.documentElement.dataset.frame")) < 239


def test_nodes_are_coloured_by_choice(page: Path, tmp_path: Path) -> None:
    with opened(page) as tab:
        assert tab.settled()
        legends = []
        for choice in ("w", "cost"):
            tab.run(f"(() => {{ const c = document.getElementById('colour'); c.value = '{choice}'; c.onchange(); }})()")
            legends.append(tab.run("document.getElementById('legend-unit').textContent"))
        assert "manipulability" in legends[0]
        assert "cost-to-go" in legends[1]


def test_the_page_is_small_and_holds_every_object(page: Path) -> None:
    assert page.stat().st_size < 3_000_000
    data = page_data(page)
    assert len(data["lengths"]) > 50  # viewer commands: bodies, obstacles, roadmap, path
    assert len(data["motion"]["frames"][0]) == 16 * 7
    assert data["joints"][0] == "base"
    assert {"w", "cost"} == set(data["legends"])


def test_the_motion_in_the_page_is_the_path(page: Path) -> None:
    result = plan(PlanRequest(nodes=100))
    data = page_data(page)
    ends = _frames(result.robot, result.path[[0, -1]]).transpose(0, 1, 3, 2).reshape(2, -1)
    assert np.allclose([data["motion"]["frames"][0], data["motion"]["frames"][-1]], ends, atol=1e-4)


def test_the_robot_is_seen(page: Path, tmp_path: Path) -> None:
    with opened(page) as tab:
        assert tab.settled()
        tab.screenshot(tmp_path / "whole.png")
        tab.run("show('robot', false)")
        tab.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")
        tab.screenshot(tmp_path / "bare.png")
    assert 0.005 < _changed(tmp_path / "whole.png", tmp_path / "bare.png") < 0.3


def test_a_damaged_page_is_noticed(page: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "damaged.html"
    text = page.read_text()
    at = text.index('id="scene">') + 5000
    damaged.write_text(text[:at] + text[at + 4000 :])
    with opened(damaged) as tab:
        assert not tab.settled()


def test_text_from_files_cannot_become_markup(tmp_path: Path) -> None:
    nasty = "</script><img src=x onerror=alert(1)>"
    (tmp_path / "s.yaml").write_text(
        "obstacles:\n"
        f"  - {{name: {json.dumps(nasty)}, type: sphere, radius: 0.05, position: [2, 2, 2]}}\n"
        "states:\n  iiwa14: {start: 'q:0,0.3,0,-1,0,0.5,0', goal: 'q:1,0.3,0,-1,0,0.5,0'}\n"
    )
    path = tmp_path / "plan.html"
    write_plan_page(plan(PlanRequest(scene=str(tmp_path / "s.yaml"), nodes=30)), path)
    assert nasty not in path.read_text()
    assert page_data(path)["obstacles"] == [nasty]


def _changed(first: Path, second: Path) -> float:
    """The share of pixels in the middle of two pictures that differ clearly."""
    middle = (slice(100, 700), slice(330, 1180))
    a, b = (np.asarray(Image.open(path).convert("RGB")).astype(int)[middle] for path in (first, second))
    return float((np.abs(a - b).max(axis=2) > 30).mean())
