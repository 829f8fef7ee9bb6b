"""The page's first screen, its curves, the trade-off's table, and all that is taken away from a page, in a browser."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.kinematics.manipulability import manipulability
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.request import TimingRequest
from planner.tradeoff.result import Tradeoff
from tests.browser import Tab, browser, choose, dataset, text
from tests.view.conftest import TASK

DESKTOP = {"width": 1400, "height": 900, "deviceScaleFactor": 1, "mobile": False}
PHONE = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}


@pytest.fixture(scope="module")
def moving() -> Plan:
    """A plan with its motion, whose elbow stays on one side."""
    return plan(request=TASK.with_options(goal="q:2,1"), timing=TimingRequest())


@pytest.fixture(scope="module")
def singular() -> Plan:
    """A plan from an arm stretched out."""
    return plan(request=TASK.with_options(start="q:0,0"), timing=TimingRequest())


@pytest.fixture(scope="module")
def window() -> Iterator[Tab]:
    with browser() as tab:
        tab.call("Emulation.setDeviceMetricsOverride", **DESKTOP)
        yield tab


@pytest.fixture
def opened(window: Tab, tmp_path: Path) -> Iterator[Callable[..., Tab]]:
    """Open the page of a result, which must not have complained by the end."""

    def open_page(result: Plan | Tradeoff) -> Tab:
        (tmp_path / result.PAGE).write_text(result.page())
        assert window.open(tmp_path / result.PAGE), window.console
        return window

    yield open_page
    assert window.console == window.requests == []


def facts(tab: Tab) -> dict[str, str]:
    """The first screen's facts by their names."""
    each = "(f => [f.querySelector('span').textContent, f.querySelector('b').textContent])"
    return dict(tab.run(f"[...element('facts').children].map({each})"))


# the first screen


def test_the_first_screen_shows_the_main_facts(opened: Callable[..., Tab], moving: Plan) -> None:
    tab, motion = opened(moving), moving.trajectory
    q = motion.at(np.linspace(0.0, motion.duration, 2001))
    room = np.minimum(q - moving.robot.lower, moving.robot.upper - q).min()
    shown = facts(tab)
    assert shown["duration"] == f"{motion.duration:.2f} s"
    assert shown["clearance"] == f"{1000 * moving.clearance.motion.min:.0f} mm"
    assert float(shown["nearest limit"].split()[0]) == pytest.approx(room, abs=0.006)
    lowest, typical = manipulability(moving.robot, q).min(), np.median(moving.roadmap.manipulability)
    assert float(shown["lowest w"].split()[0]) == pytest.approx(lowest, rel=0.02)
    band = next(
        (name for name, share in (("singular", 0.01), ("poor", 0.1), ("fair", 0.5)) if lowest < share * typical), "good"
    )
    assert tab.run("element('facts').children[1].className") == band
    spans = "[...element('gauge').children].map(c => (b => [c.className, b.left, b.right])(c.getBoundingClientRect()))"
    *bands, (_, left, right) = tab.run(spans)
    assert next(name for name, _, end in bands if (left + right) / 2 <= end) == band
    assert tab.run(
        "element('gauge-section').getBoundingClientRect().bottom < element('panel').getBoundingClientRect().bottom"
    )
    tab.click("#facts button:nth-child(2)")
    np.testing.assert_allclose(tab.run("sampleAt(shownPath().w, share)"), lowest, atol=5e-3)


def test_a_singular_start_is_a_warning(opened: Callable[..., Tab], singular: Plan) -> None:
    tab = opened(singular)
    assert tab.run("element('message').className") == "warned"
    warnings = text(tab, "warnings")
    assert "The start is singular: w is 0 m² there." in warnings
    assert "Badly conditioned at the start itself" in warnings
    assert tab.run("element('facts').children[1].className") == "singular"
    tab.call("Emulation.setDeviceMetricsOverride", **PHONE)
    assert tab.run("element('warnings').getBoundingClientRect().bottom < innerHeight / 2"), "seen without a touch"
    tab.call("Emulation.setDeviceMetricsOverride", **DESKTOP)


# curves


def test_curves_have_limits_units_and_values_under_the_pointer(opened: Callable[..., Tab], moving: Plan) -> None:
    tab, motion, dof = opened(moving), moving.trajectory, moving.robot.dof
    titles = tab.run("[...document.querySelectorAll('#plots svg')].map(s => s.querySelector('text').textContent)")
    assert titles == [
        *("manipulability w, m²", "condition number", "clearance, mm", "joint positions q, rad"),
        *("joint velocity q′, rad/s", "joint acceleration q″, rad/s²", "joint jerk q‴, rad/s³", "tool speed, m/s"),
    ]
    assert tab.run("document.querySelectorAll('#plots .way').length") == 4 * dof + 4
    assert tab.run("document.querySelectorAll('#plots .limit').length") == 4
    assert tab.run("HEIGHT") == 120
    ways = "[...document.querySelectorAll('#plots .way')].map(way => way.getBBox())"
    for top, bottom in tab.run(f"{ways}.map(b => [b.y - TOP, b.y + b.height - TOP])"):
        assert 0 < top <= bottom < 120, "no curve lies on the frame"
    box = tab.run("(b => [b.left, b.top, b.width])(document.querySelector('#plots svg rect').getBoundingClientRect())")
    tab.mouse(box[0] + 0.25 * box[2], box[1] + 60)
    assert float(dataset(tab, "share")) == pytest.approx(0.25, abs=3e-3)
    share = float(dataset(tab, "share"))
    q = motion.at(share * motion.duration)
    values = tab.run(
        "[...document.querySelectorAll('#plots svg')].map(s => s.querySelector('.entry text').textContent)"
    )
    assert float(values[0].split()[0]) == pytest.approx(manipulability(moving.robot, q)[0], rel=0.01)
    assert values[3].replace("−", "-") == f"joint 1 {float(f'{q[0, 0]:.3g}'):g}"
    tab.click("#plots > div:nth-child(4) .entry:nth-of-type(1)")
    assert tab.run("document.querySelectorAll('#plots .way').length") == 4 * (dof - 1) + 4, "a joint is hidden"
    tab.run("hiddenJoints.clear(), showPlots(false)")
    assert tab.run("element('plots').hidden")


# the sweep


def test_the_sweeps_table_shows_the_gain_of_each_beta(opened: Callable[..., Tab], tradeoff: Tradeoff) -> None:
    tab = opened(tradeoff)
    rows = tab.run("[...element('choices').tBodies[0].rows].map(r => [...r.cells].map(c => c.textContent))")
    assert len(rows) == len(tradeoff.intervals)
    for row, item in zip(rows, tradeoff.intervals, strict=True):
        assert item.duration is not None
        assert item.clearance is not None
        assert float(row[1]) == pytest.approx(item.w_min, abs=6e-5)
        assert row[2:4] == [f"{item.duration:.2f}", f"{1000 * item.clearance:.1f}"]
        assert [int(cell.split()[0]) / 100 for cell in row[4:]] == pytest.approx(
            [item.gain, item.added_length], abs=5.1e-3
        )
    knee = tradeoff.knee
    assert [k for k, row in enumerate(rows) if row[0].startswith("◆")] == [tradeoff.intervals.index(knee)]
    assert tab.run(
        "[...element('costs').querySelectorAll('g')].findIndex(g => g.querySelector('.knee'))"
    ) == rows.index(next(row for row in rows if row[0].startswith("◆")))
    tab.click("#choices tr.knee")
    assert dataset(tab, "path") == str(tradeoff.intervals.index(knee))
    assert text(tab, "buys").startswith(f"This path: {knee.buys.split(': ')[1]}")
    assert "This is the knee" in text(tab, "buys")


# what is taken away


def test_the_copied_command_makes_the_plan(opened: Callable[..., Tab], moving: Plan, tmp_path: Path) -> None:
    from tests.command_line import command

    tab = opened(moving)
    tab.click("#copy")
    line = text(tab, "command")
    program, *words = shlex.split(line)
    assert program == "planner"
    process = command(*words, "--out", str(tmp_path / "again"), "--no-page", cwd=tmp_path)
    assert process.wait() == 0
    again = json.loads((tmp_path / "again" / "plan.json").read_text())
    assert again["path"] == moving.path.tolist()
    assert again["roadmap"]["sha256"] == moving.record.roadmap.sha256


def choose_file(tab: Tab, path: Path) -> None:
    document = tab.call("DOM.getDocument")["root"]["nodeId"]
    node = tab.call("DOM.querySelector", nodeId=document, selector="#file")["nodeId"]
    tab.call("DOM.setFileInputFiles", nodeId=node, files=[str(path)])
    tab.run("new Promise(done => setTimeout(done, 300))")


def test_another_plan_is_drawn_over_this_one(
    opened: Callable[..., Tab], moving: Plan, singular: Plan, tmp_path: Path
) -> None:
    other = replace(singular, trajectory=None)
    other.save_without_page(tmp_path / "other")
    tab, robot = opened(moving), moving.robot
    count = tab.run("data.paths.length")
    choose_file(tab, tmp_path / "other" / "plan.json")
    assert dataset(tab, "compared") == str(count)
    assert text(tab, "file-message") == ""
    assert tab.run(f"group('paths/{count}').visible && ghost.visible")
    assert tab.run("document.querySelectorAll('#plots [stroke-dasharray=\"4 3\"]').length") >= 1 + robot.dof
    assert "dashed: plan.json" in text(tab, "plots")
    for share in (0.0, 0.4, 1.0):
        q = np.array(tab.run(f"configurationAt(otherPath(), {share})"))
        assert tab.run(f"manipulabilityAt({q.tolist()})") == pytest.approx(manipulability(robot, q)[0], abs=1e-7)
    np.testing.assert_allclose(tab.run("otherPath().waypoints"), other.path)
    assert f"{other.cost.distance:.4f}" in text(tab, "numbers")
    choose(tab, "compare", "")
    assert tab.run("ghost.visible") is False


def test_the_page_is_dark_where_that_is_preferred_and_by_its_switch(opened: Callable[..., Tab], moving: Plan) -> None:
    tab = opened(moving)
    assert dataset(tab, "theme") == "light"
    light = tab.screenshot().mean()
    tab.click("#theme")
    tab.drawn()
    assert dataset(tab, "theme") == "dark"
    assert tab.screenshot().mean() < 0.4 * light
    tab.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    tab = opened(moving)
    assert dataset(tab, "theme") == "dark"
    for ink in ("ink", "soft", "bad", "warn", "good", "shown", "other", "worst"):
        assert contrast(tab, ink) > 4.5, ink
    tab.call("Emulation.setEmulatedMedia", features=[])
    tab = opened(moving)
    for ink in ("ink", "soft", "bad", "warn", "good", "other", "worst"):
        assert contrast(tab, ink) > 4.5, ink


def contrast(tab: Tab, ink: str) -> float:
    """How much a colour of the style sheet differs from the page, as WCAG 2 counts it."""
    levels = []
    for name in (ink, "page"):
        colour = tab.run(
            f"(p => (p.fillStyle = colour('{name}'), p.fillStyle))(document.createElement('canvas').getContext('2d'))"
        )
        parts = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        levels.append(float(linear @ [0.2126, 0.7152, 0.0722]) + 0.05)
    return max(levels) / min(levels)
