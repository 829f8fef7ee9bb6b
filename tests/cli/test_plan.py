"""The commands as a user types them: results, bad input with its sentence and exit code, Ctrl-C, fresh processes."""

import json
import signal
import time
from pathlib import Path

import pytest

from tests.command_line import Run, assert_refused, assert_total_covers, command


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
    assert_total_covers(record["timings_s"], stages | {"files", "record", "page"})
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


def test_two_fresh_processes_give_the_same_path(tmp_path: Path) -> None:
    runs = [command("plan", "--nodes", "60", "--seed", "3", "--out", f"o{k}", cwd=tmp_path) for k in range(2)]
    for process in runs:
        process.communicate(timeout=300)
        assert process.returncode == 0
    first, second = (json.loads((tmp_path / f"o{k}" / "plan.json").read_text()) for k in range(2))
    assert first["path"] == second["path"]
    assert (tmp_path / "o0" / "roadmap.npz").read_bytes() == (tmp_path / "o1" / "roadmap.npz").read_bytes()


def test_ctrl_c_saves_the_roadmap(tmp_path: Path) -> None:
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


def test_no_page_is_written_with_no_page(run: Run, tmp_path: Path) -> None:
    small = ("plan", "--robot", "planar_2r", "--scene", "empty", "--start", "q:0,1", "--goal", "q:1,1", "--nodes", "20")
    assert run(*small, "--out", str(tmp_path))[0] == 0
    assert (tmp_path / "plan.html").exists()
    code, output, _ = run(*small, "--no-page", "--out", str(tmp_path))
    assert code == 0
    assert "plan.html" not in output
    assert {path.name for path in tmp_path.iterdir()} == {"plan.json", "roadmap.npz", "trajectory.json"}, (
        "the old one went"
    )
    assert "page" not in json.loads((tmp_path / "plan.json").read_text())["timings_s"]
    assert_refused(
        run(*small, "--no-page", "--view", "--out", str(tmp_path / "new")), 2, "leave out --no-page", tmp_path / "new"
    )
