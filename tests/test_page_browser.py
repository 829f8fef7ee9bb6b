"""The page in a real browser: it gets ready, asks the network for nothing, and shows what it should."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from browser import page_data, require_browser, screenshot, visit

from planner import PlanRequest
from planner.plan import plan
from planner.view.page import write_plan_page


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "plan.html"
    write_plan_page(plan(PlanRequest(nodes=100)), path)
    return path


def test_the_page_gets_ready_offline(page: Path) -> None:
    require_browser()
    seen = visit(page)
    assert seen.ready, seen.console
    assert seen.requests == []
    assert seen.console == []
    assert 'data-frame="0"' in seen.dom
    text = re.sub(r"<[^>]+>", " ", seen.dom.split("<script>")[0])
    for expected in ("iiwa14 in paper", "A collision-free path was found.", "100 nodes", "manipulability"):
        assert expected in text


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
    from planner.view.page import _frames

    ends = _frames(result.robot, result.path[[0, -1]]).transpose(0, 1, 3, 2).reshape(2, -1)
    assert np.allclose([data["motion"]["frames"][0], data["motion"]["frames"][-1]], ends, atol=1e-4)


def test_the_robot_is_seen(page: Path, tmp_path: Path) -> None:
    require_browser()
    screenshot(page, tmp_path / "whole.png")
    bare = tmp_path / "bare.html"
    text = page.read_text()
    assert "  startPlayer();" in text
    bare.write_text(text.replace("  startPlayer();", '  startPlayer(); show("robot", false);'))
    screenshot(bare, tmp_path / "bare.png")
    whole, empty = (_pixels(tmp_path / name) for name in ("whole.png", "bare.png"))
    middle = (slice(150, 650), slice(350, 1100))
    changed = np.abs(whole[middle].astype(int) - empty[middle].astype(int)).max(axis=2) > 30
    assert 0.005 < changed.mean() < 0.3, "pixels that differ once the robot is hidden"


def test_a_damaged_page_is_noticed(page: Path, tmp_path: Path) -> None:
    require_browser()
    damaged = tmp_path / "damaged.html"
    text = page.read_text()
    at = text.index('id="scene">') + 5000
    damaged.write_text(text[:at] + text[at + 4000 :])
    assert not visit(damaged).ready


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


def _pixels(path: Path) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB"))
