"""``planner follow`` as a user types it."""

import json
from pathlib import Path

from tests.command_line import Run, assert_total_covers
from tests.documents import ROOT

SEAM = str(ROOT / "scenes/examples/seam.yaml")


def test_a_seam_is_followed_and_its_record_and_page_say_so(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    code, text, _ = run(
        "follow", SEAM, "--robot", "panda", "--scene", "table", "--tool-speed", "0.2", "--out", str(out)
    )
    assert code == 0
    record = json.loads((out / "plan.json").read_text())
    found = record["tool_path"]
    assert (found["followed"], found["points"], found["first_unreachable"], found["proven"]) == (1.0, 5, None, True)
    assert found["largest_deviation"]["position"] <= found["tube"]["position"] == 0.001
    assert found["largest_deviation"]["angle"] <= found["tube"]["angle"] == 0.0087
    assert 0 < found["speed"]["largest"] <= found["speed"]["asked"] == 0.2
    assert record["outcome"] == "solved"
    assert record["config"]["tool_speed"] == 0.2
    assert record["trajectory"]["proven"]
    words = " ".join(text.replace("│", " ").split())
    assert "100.0 % of 5 points followed" in words
    assert (out / "plan.html").exists()
    stages = {"import", "setup", "ladder", "proofs", "costs", "gabf", "path", "timing", "alternatives"}
    assert_total_covers(record["timings_s"], stages | {"files", "record", "page"})
    code, text, _ = run("check", str(out / "trajectory.json"), "--robot", "panda", "--scene", "table")
    assert code == 0, text


def test_a_path_followed_in_part_ends_with_4_and_a_reason(run: Run, tmp_path: Path) -> None:
    file, out = tmp_path / "line.csv", tmp_path / "out"
    file.write_text("x,y,z,ax,ay,az\n0.5,0,0.4,0,0,-1\n0.6,0,0.4,0,0,-1\n1.4,0,0.4,0,0,-1\n")
    code, text, _ = run("follow", str(file), "--robot", "panda", "--scene", "empty", "--no-timing", "--out", str(out))
    assert code == 4
    record = json.loads((out / "plan.json").read_text())
    assert record["outcome"] == "partly_followed"
    assert 0 < record["tool_path"]["followed"] < 1
    assert record["tool_path"]["first_unreachable"] == 3
    assert record["reason"]["kind"] == "cannot_follow"
    assert record["path"]
    assert "not to point 3" in text
