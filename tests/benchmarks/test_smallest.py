"""Every benchmark once, at its smallest size and through its command: rows, report, resuming, refusals, Ctrl-C."""

import csv
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.gate.false_stops import SITUATIONS
from benchmarks.optimum import grid
from tests.batch.posts import write_problem
from tests.command_line import Run, assert_refused, command

Rows = list[dict[str, str]]

PLANAR = "--robot planar_2r --collision coal --acceleration 5"


def rows_of(out: Path) -> Rows:
    (table,) = out.glob("*.csv")
    with table.open(newline="") as file:
        return list(csv.DictReader(file))


def check_plan(rows: Rows) -> None:
    refused, _, row, other = rows
    assert [each["outcome"] for each in rows] == ["refused", "refused", "solved", "solved"]
    assert row["certified"] == row["edges"]
    assert (row["contacts"], row["motion_contact"], row["proven"]) == ("0", '""', "True")
    assert float(row["largest_share"]) <= 1.0
    assert float(row["timed_s"]) <= float(row["stopping_s"])
    assert 0 < float(row["first_path_s"]) < float(row["total_s"]) < float(row["process_s"])
    assert float(row["lower_bound"]) <= float(row["cost"])
    assert float(other["length_rad"]) >= float(other["straight_rad"])
    assert refused["problem"] == "far/0001"


def check_first_motion(rows: Rows) -> None:
    assert [row["method"] for row in rows] == ["planner", "planner, whole roadmap", "OMPL RRTConnect, plain coal"]
    for row in rows[:2]:
        assert (row["proven"], row["contacts"], row["motion_contact"]) == ("True", "0", '""')
        assert float(row["total_s"]) == pytest.approx(sum(float(row[k]) for k in ("ready_s", "path_s", "motion_s")))


def check_clouds(rows: Rows) -> None:
    worlds = dict.fromkeys(row["world"] for row in rows)
    assert list(worlds) == [
        *("true shapes", "covering radius", "estimated radius", "2.5 mm (VAMP)"),
        *("target touched", "depth, unknown free", "depth, unknown solid", "OMPL, coal's octree"),
    ]
    solved = [row for row in rows if row["outcome"] == "solved"]
    assert {row["world"] for row in solved} >= {"covering radius", "depth, unknown free", "OMPL, coal's octree"}
    safe = ("true shapes", "covering radius", "target touched")
    assert all(row["contacts"] == "0" for row in solved if row["world"] in safe)


def check_cells(rows: Rows) -> None:
    left_out = [row for row in rows if row["method"] == "left out"]
    assert [(row["start"], row["message"]) for row in left_out] == [("touch", "'a_panda_link5' and 'b_panda_link5'")]
    (attack,) = [row for row in rows if row["method"] == "attack"]
    assert 0 < int(attack["free"]) < int(attack["tried"]) == 24
    assert attack["false_free"] == "0"
    plans = [row for row in rows if row["method"] in ("in turn", "together")]
    assert len({row["method"] for row in plans}) == 2
    assert {(row["outcome"], row["proven"], row["contact"], row["contact_1"]) for row in plans} == {
        ("solved", "True", '""', '""')
    }
    for row in plans:
        assert 0 < float(row["makespan"]) <= float(row["flowtime"]) <= 2 * float(row["makespan"]) + 1e-9
        assert 0.2 <= float(row["makespan_1"]) < 0.21  # a joint turns by 0.2 rad, at 1 rad/s
        assert float(row["least_m"]) > 0


def check_attack(rows: Rows) -> None:
    parts = dict.fromkeys(row["attack"] for row in rows)
    by_part = {part: [row for row in rows if row["attack"] == part] for part in parts}
    assert list(by_part) == ["claims", "segments", "misses", "certificates", "changes"]
    apart, tried = (sum(int(row[name]) for row in by_part["claims"]) for name in ("apart", "tried"))
    assert 0.5 < apart / tried < 1.0  # a search among shapes that all touch, or never do, proves little
    assert sum(int(row["free"]) for row in by_part["segments"]) > 10
    assert not any(int(row["false_free"]) for part in ("segments", "changes") for row in by_part[part])
    assert all(float(row["beyond_m"]) <= 0.0 for row in by_part["claims"])
    assert [row["verdict"] for row in by_part["certificates"]] == ["proven"]


def check_gabf(rows: Rows) -> None:
    errors = {row["method"]: float(row["error"]) for row in rows}
    assert errors["dijkstra"] == 0.0
    assert errors["gabf"] < min(errors["rk45 in tau"], errors["rk45 in t"]) < 1e-3


def check_gate(rows: Rows) -> None:
    assert [row["kind"] for row in rows[:3]] == ["lines", "cubics", "quintics"]
    assert [(row["kind"], row["made"], row["accepted"]) for row in rows[3:]] == [
        (name, "1", "1") for name in SITUATIONS
    ]
    for row in rows[:3]:
        assert (row["tries"], row["false"], row["beyond"]) == ("6", "0", "0")
        assert row["accepted_20"] == row["free_20"] <= row["free_5"]


def check_roadmap(rows: Rows) -> None:
    ours = rows[0]
    assert {row["outcome"] for row in rows} == {"measured"}
    assert (ours["proven"], ours["touching"], ours["contacts"], ours["solved"]) == (ours["edges"], "0", "0", "2")


def check_optimum(rows: Rows) -> None:
    (row,) = rows
    assert -2.0 < float(row["gap"]) < 15.0


def check_tool_paths(rows: Rows) -> None:
    (row,) = rows
    assert float(row["followed"]) > 0
    assert (row["proven"], row["contacts"]) == ("True", "0")
    assert max(float(row["position"]), float(row["angle"])) <= 1.0


def check_tasks(rows: Rows) -> None:
    (row,) = rows
    assert (row["outcome"], row["proven"], row["segments_bad"]) == ("solved", "True", "0")
    assert row["stuck"] == "True" or float(row["greedy_cost"]) >= float(row["cost"]) - 1e-9


def check_tradeoff(rows: Rows) -> None:
    for row in rows:
        assert 0.5 < float(row["ratio"]) <= 1.0 + 1e-12
        assert float(row["beta_min"]) <= float(row["beta"]) <= float(row["beta_max"])
        cost = 0.8 * float(row["omega"]) + 0.2 * float(row["distance"])
        assert cost == pytest.approx(float(row["sweep_cost"]), rel=1e-3)


def check_tables(rows: Rows) -> None:
    assert {(row["outcome"], row["contacts"]) for row in rows} == {("solved", "0")}
    assert {row["method"] for row in rows} == {"path only", "beta 1", "saved roadmap"}


SMALLEST: dict[str, tuple[str, Callable[[Rows], None]]] = {
    "plan": (f"FOLDER {PLANAR} --nodes 40 --seeds 0 --planners RRTConnect", check_plan),
    "first-motion": (f"FOLDER/posts {PLANAR} --seconds 2", check_first_motion),
    "clouds": ("FOLDER/posts --robot planar_2r --filters 2 --samples 3000 --dense-samples 4000", check_clouds),
    "cells": ("FOLDER/cells --nodes 30 --pairs 1 --tries 24", check_cells),
    "attack": (
        "--tries 12 --segments 2 --edges 2 --thicknesses 5 --changes 50 --robots planar_2r --scenes paper",
        check_attack,
    ),
    "gabf": ("--sizes 60", check_gabf),
    "gate": ("--chunks 3 --attack 6 --steps 4 --robots planar_2r --free 1 --clearances 2", check_gate),
    "roadmap": ("--robot planar_2r --scene paper --nodes 40 --queries 2", check_roadmap),
    "optimum": ("--nodes 60 --refinement-rounds 2 --betas 1 --seeds 0 --arms planar_2r", check_optimum),
    "tool-paths": ("--robots ur5 --scenes empty --kinds line --paths 1", check_tool_paths),
    "tasks": ("--scenes 1 --nodes 200 --kinds table", check_tasks),
    "tables": ("--nodes 60 --betas 1", check_tables),
    "tradeoff": ("--nodes 60 --betas 0.2 --seeds 1", check_tradeoff),
}


@pytest.mark.parametrize("name", SMALLEST)
def test_it_measures_and_reports(
    name: str, problems: Path, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(grid._HALVINGS, 2, 0)
    monkeypatch.setitem(grid._COARSE, 2, 0.03)
    words, check = SMALLEST[name]
    asked = [name, *words.replace("FOLDER", str(problems)).split(), "--out", str(tmp_path / "o")]
    code, text, error = run(*asked, program="benchmarks")
    assert code == 0, error
    assert text.startswith(f"# python -m benchmarks {name}\n")
    for word in ("Software: gabf-planner", "How.", "Limitations."):
        assert word in text
    assert text == (tmp_path / "o" / f"{name}.md").read_text() + "\n"
    check(rows_of(tmp_path / "o"))
    if name == "plan":
        before = (tmp_path / "o" / f"{name}.csv").read_bytes()
        assert run(*asked, program="benchmarks")[:2] == (0, text)
        assert (tmp_path / "o" / f"{name}.csv").read_bytes() == before  # seconds too: no row is measured again


def test_every_benchmark_has_a_smallest_size(run: Run) -> None:
    code, text, _ = run("--help", program="benchmarks")
    assert code == 0
    assert all(f"• {name} " in text for name in SMALLEST)
    assert text.count("• ") == len(SMALLEST)


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ("plan nowhere", 3, "nowhere holds no problems"),
        ("plan . --beta 2", 2, "beta must be less than or equal to 1, got 2"),
        ("plan . --time-limit 0", 2, "times above 0"),
        ("plan . --scene shelf", 2, "scene is what each problem says"),
        ("first-motion . --python vamp=x", 2, "python 'vamp=x' is not usable"),
        ("first-motion . --jerk 0", 2, "jerk must be greater than 0"),
        ("attack --tries 0", 2, "at least 1"),
        ("attack --thicknesses 0", 2, "thicknesses above 0"),
        ("attack --robots marvin", 3, "robot 'marvin' not found"),
        ("attack --parts proofs", 2, "nothing to measure"),
        ("cells nowhere", 3, "holds no cells"),
        ("gate --chunks 0", 2, "at least 1 chunk"),
        ("gabf --sizes 5", 2, "at least 10"),
        ("optimum --arms puma", 2, "arm 'puma' not found"),
        ("tool-paths --kinds spiral", 2, "kind 'spiral' not found"),
        ("tasks --scenes 0", 2, "at least 1 scene"),
        ("roadmap --scene moon", 3, "scene 'moon' not found"),
        ("tables --betas", 2, "at least one beta"),
    ],
)
def test_wrong_input_is_one_sentence(
    words: str, code: int, text: str, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "out"
    assert_refused(run(*words.split(), "--out", str(out), program="benchmarks"), code, text, out)


def test_an_interrupt_saves_and_the_rest_follows_later(tmp_path: Path, run: Run) -> None:
    for k in ("0001", "0002"):
        write_problem(tmp_path / "p", k, (-1.0, 0.8), (1.0, -0.8))
    words = f"plan {tmp_path / 'p'} {PLANAR} --nodes 30 --seeds 0 --out {tmp_path / 'o'}".split()
    process = command(*words, cwd=tmp_path, program="benchmarks")
    until = time.monotonic() + 120
    while not (tmp_path / "o" / "plan.csv").exists():
        assert time.monotonic() < until
        assert process.poll() is None
        time.sleep(0.01)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    process.send_signal(signal.SIGINT)
    text, error = process.communicate(timeout=60)
    assert not [child for child in children if Path(f"/proc/{child}/exe").exists()]
    assert "Traceback" not in error
    assert process.returncode == 130
    assert "Interrupted" in text
    first = rows_of(tmp_path / "o")
    assert [row["problem"] for row in first] == ["p/0001"]
    assert run(*words, program="benchmarks")[0] == 0
    again = rows_of(tmp_path / "o")
    assert again[0] == first[0]
    assert [row["problem"] for row in again] == ["p/0001", "p/0002"]
