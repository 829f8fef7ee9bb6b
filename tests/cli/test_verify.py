"""``planner plan --certificate`` and ``planner verify``."""

from pathlib import Path

from tests.command_line import Run

PLAN = ("plan", "--robot", "planar_2r", "--scene", "empty", "--start", "q:-1,0.5", "--goal", "q:1,0.9", "--path-only")


def test_a_certificate_is_written_and_verified(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    code, _, error = run(*PLAN, "--certificate", "--out", str(out))
    assert code == 0, error
    assert (out / "proof.npz").exists()
    for name in ("plan.json", "proof.npz"):
        assert run("verify", str(out / name))[0] == 0
    code, said, error = run("verify", str(out))
    assert (code, said[:7]) == (0, "Proven:"), error
    assert "equal, number by number, those of plan.json" in said
    record = out / "plan.json"
    record.write_text(record.read_text().replace('"path": [', '"path": [[0.0, 0.0],'))
    code, said, error = run("verify", str(out))
    assert (code, said) == (4, "")
    assert "NOT proven: plan.json is of another path." in " ".join(error.split())
