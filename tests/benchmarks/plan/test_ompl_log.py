"""The log that OMPL's own tool reads."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.plan.ompl_log import to_log, write_logs
from benchmarks.plan.rows import Row
from planner.batch.outcomes import CRASHED, SOLVED
from tests.benchmarks.plan.test_run import row, rows_of


def bare(outcome: str, **more) -> Row:
    """A run that was not solved."""
    empty = dict.fromkeys(("total_s", "first_path_s", "nodes", "edges", "certified", "waypoints", "length_rad"))
    empty |= dict.fromkeys(("length_m", "w_min", "w_mean", "clearance_m", "contacts", "memory_mib"))
    return row(outcome=outcome, message="why", **empty | more)


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
