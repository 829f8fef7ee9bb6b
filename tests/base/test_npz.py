"""What a file of arrays unpacks to is known before it is."""

from __future__ import annotations

import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.base.npz import DAMAGE, require_sane_sizes


def test_a_small_file_that_unpacks_to_a_gigabyte_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive, archive.open("q.npy", "w") as q:
        for _ in range(200):
            q.write(bytes(1_000_000))
    begin = time.process_time()
    with pytest.raises(FileError, match=r"it would unpack to 200000000 bytes, far more than it is: write it again\."):
        require_sane_sizes(path, "it", slack=1 << 20)
    assert time.process_time() - begin < 0.2


def test_large_arrays_as_they_are_and_small_ones_are_fine(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", a=np.zeros(1_000_000))
    require_sane_sizes(tmp_path / "a.npz", "it", slack=0, largest=0)
    np.savez_compressed(tmp_path / "b.npz", a=np.zeros(1_000_000))
    require_sane_sizes(tmp_path / "b.npz", "it", slack=8_000_200)
    with pytest.raises(FileError):
        require_sane_sizes(tmp_path / "b.npz", "it", slack=1_000)


def test_one_content_under_many_names_is_as_large_as_they_say(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("a0.npy", bytes(100_000))
        (first,) = archive.filelist
        for k in range(1, 1000):
            other = zipfile.ZipInfo(f"a{k}.npy")
            other.header_offset, other.file_size, other.compress_size = 0, first.file_size, first.compress_size
            other.CRC = first.CRC
            archive.filelist.append(other)
    with pytest.raises(FileError, match="would unpack to 100000000 bytes"):
        require_sane_sizes(tmp_path / "a.npz", "it", slack=0)


def test_an_array_has_the_size_that_it_says(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", a=np.zeros(100_000))
    content = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(content.replace(b"(100000,)", b"(999999,)"))
    with pytest.raises(DAMAGE, match="does not fit its size"):
        require_sane_sizes(tmp_path / "a.npz", "it", slack=0)
