"""Where an interrupted result goes."""

from __future__ import annotations

from pathlib import Path

from planner.cli.common import file_for_interrupted, folder_for_interrupted, kept


def test_where_an_interrupted_result_goes(tmp_path: Path) -> None:
    names = ("plan.json", "plan.html", "roadmap.npz")
    assert folder_for_interrupted(tmp_path / "new", names) == tmp_path / "new"
    assert folder_for_interrupted(tmp_path, names) == tmp_path
    (tmp_path / "roadmap.npz").touch()  # perhaps of hours of work
    assert folder_for_interrupted(tmp_path, names) == tmp_path / "interrupted"
    record = tmp_path / "plan.json"
    for text in ('{"outcome": "solved"}', '{"outcome": "no_path"}', "[]", "{", "\udcff"):
        record.write_text(text, errors="surrogateescape")
        assert folder_for_interrupted(tmp_path, names) == tmp_path / "interrupted"
    record.write_text('{"outcome": "interrupted"}')
    assert folder_for_interrupted(tmp_path, names) == tmp_path / "interrupted"
    for k, name in enumerate(("interrupted", "interrupted-2"), start=2):
        (tmp_path / name).mkdir()
        (tmp_path / name / "plan.json").touch()
        assert folder_for_interrupted(tmp_path, names) == tmp_path / f"interrupted-{k}"
    assert file_for_interrupted(tmp_path / "roadmap.npz") == tmp_path / "roadmap.interrupted.npz"
    (tmp_path / "roadmap.interrupted.npz").touch()
    assert file_for_interrupted(tmp_path / "roadmap.npz") == tmp_path / "roadmap.interrupted-2.npz"
    assert file_for_interrupted(tmp_path / "none.npz") == tmp_path / "none.npz"
    assert kept(tmp_path, tmp_path) == ""
