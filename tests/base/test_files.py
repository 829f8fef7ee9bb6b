"""Files are there whole or as they were, and folders are tried without a trace."""

import os
from pathlib import Path

import pytest

from planner.base.errors import FileError
from planner.base.files import json_text, require_writable_file, require_writable_folder, write_whole


def test_a_failing_writer_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "a.json"
    write_whole(file, b"old")

    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(FileError, match="No space left on device"):
        write_whole(file, b"new")
    assert file.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.json"]


def test_colleagues_may_read_written_files(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "a.json", b"")
    finally:
        os.umask(before)
    assert (tmp_path / "a.json").stat().st_mode & 0o777 == 0o640


def test_unwritable_folders_are_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    before = sorted(tmp_path.rglob("*"))
    for place in (tmp_path / "loop" / "c", Path("/dev/full")):
        with pytest.raises(FileError, match=r"cannot be written: .*; choose another place"):
            require_writable_folder(place)
    for place in (Path("/dev/full"), tmp_path):
        with pytest.raises(FileError, match="give the name of a file"):
            require_writable_file(place)
    require_writable_file(tmp_path / "one" / "two.npz")
    assert sorted(tmp_path.rglob("*")) == before, "nothing is left behind"


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_no_number_that_json_does_not_have(number: float) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        json_text({"a": [[number]]})
