"""``planner sweep`` as a user types it: files, refusals, Ctrl-C, no path."""

import json
import signal
from pathlib import Path
from typing import Any

import pytest

from planner.tradeoff.envelope import EnvelopeSearch
from tests.command_line import Run, assert_refused, assert_total_covers, command

FILES = {"sweep.json", "sweep.csv", "sweep.html", "roadmap.npz"}
SMALL = ("--nodes", "80", "--seed", "2")


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A folder with a small sweep of the paper's scenario, made once, and the output of the command."""
    out = tmp_path_factory.mktemp("swept")
    process = command("sweep", *SMALL, "--out", str(out), cwd=out)
    text, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    return out, text


def read(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "sweep.json").read_text())


def test_sweep_writes_the_contract(swept: tuple[Path, str]) -> None:
    out, text = swept
    record = read(out)
    motions = {f"trajectory-{k + 1}.json" for k in range(len(record["intervals"]))}
    assert {path.name for path in out.iterdir()} == FILES | motions
    assert record["outcome"] == "solved"
    intervals = record["intervals"]
    assert [intervals[0]["beta_min"], intervals[-1]["beta_max"]] == [0.0, 1.0]
    keys = {"beta_min", "beta_max", "path_nodes", "manipulability_cost", "distance_cost", "w_min", "w_mean"}
    keys |= {"workspace_length", "duration", "clearance", "gain", "added_length", "goal", "trajectory"}
    assert all(set(interval) >= keys for interval in intervals)
    assert ("knee" not in record) == (len(intervals) < 3)
    assert (record["complete"], record["max_error_vs_oracle"]) == (True, 0.0)
    stages = {"import", "setup", "roadmap", "improve", "costs", "gabf", "path", "timing", "measures"}
    stages |= {"files", "record", "page"}
    assert_total_covers(record["timings_s"], stages)
    assert (out / "sweep.csv").read_text().count("\n") == 1 + len(intervals)
    assert max(map(len, text.splitlines()[: 4 + len(intervals)])) <= 80
    assert f"{out / 'sweep.html'}" in text
    assert f"To run one: planner export {out} --beta" in text


def test_a_motion_is_chosen_by_beta_and_exported(swept: tuple[Path, str], run: Run, tmp_path: Path) -> None:
    out, first = swept[0], read(swept[0])["intervals"][0]
    code, text, error = run("export", str(out), "--beta", "0.001", "--format", "csv")
    assert code == 0, error
    assert "of the paths in its roadmap" in error
    rows = (out / "trajectory-1-csv.csv").read_text().splitlines()
    assert f"{first['duration']:.3f} s" in text
    assert [float(value) for value in rows[1].split(",")[1:8]] == pytest.approx(first["path"][0])
    boundary = repr(first["beta_max"])
    code, text, error = run("export", str(out), "--beta", boundary, "--rate", "250", "--out", str(tmp_path / "m.json"))
    assert code == 0, error
    assert "the plan takes the shorter one" in error
    assert "proven free and within limits" in text
    assert run("check", str(out / first["trajectory"]))[0] == 0
    none = tmp_path / "none"
    assert_refused(run("export", str(out), "--out", str(none)), 3, "give --beta", none)
    assert_refused(run("check", str(out)), 3, "trajectory-1.json", none)
    assert_refused(run("export", str(tmp_path), "--beta", "0.2", "--out", str(none)), 3, "sweep.json not found", none)


@pytest.mark.parametrize("step", [1, 2])
def test_ctrl_c_saves_the_proven_intervals(
    swept: tuple[Path, str], tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch, step: int
) -> None:
    out, arguments = tmp_path / "o", (*SMALL, "--roadmap", str(swept[0] / "roadmap.npz"))
    steps: list[int] = []
    real = EnvelopeSearch.step

    def interrupted(search: EnvelopeSearch) -> Any:
        steps.append(1)
        if len(steps) == step:
            signal.raise_signal(signal.SIGINT)
        return real(search)

    monkeypatch.setattr(EnvelopeSearch, "step", interrupted)
    code, text, error = run("sweep", *arguments, "--out", str(out))
    assert code == 130, error
    assert "Interrupted" in text
    assert {path.name for path in out.iterdir()} == FILES - {"sweep.html"}
    assert (read(out)["outcome"], read(out)["complete"]) == ("interrupted", False)
