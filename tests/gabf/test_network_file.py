"""Networks on disk: what was written comes back mapped, not copied; damaged files are refused with a sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planner import gabf
from planner.base.errors import FileError, PlannerError
from tests.gabf.networks import scattered, solve

KERNEL = gabf.TradeOff(beta=0.5)


@pytest.fixture
def network() -> gabf.Network:
    return scattered(300)


def mapped(array: np.ndarray) -> bool:
    while array is not None and not isinstance(array, np.memmap):
        array = array.base  # type: ignore[assignment]
    return array is not None


def test_arrays_come_back_mapped_and_aligned(network: gabf.Network, tmp_path: Path) -> None:
    gabf.write_network(network, tmp_path / "n.npz")
    found = gabf.read_network(tmp_path / "n.npz", KERNEL)
    for name in ("indptr", "indices", "weight", "sources", "source_values", "node_cost"):
        assert np.array_equal(getattr(found, name), getattr(network, name))
    for array in (found.indices, found.weight):
        assert mapped(array)
        assert array.flags.aligned
        assert array.ctypes.data % 64 == 0
        assert not array.flags.writeable
    assert np.array_equal(solve(found).x, solve(network).x)
    assert [p.name for p in tmp_path.iterdir()] == ["n.npz"]


def test_numpy_reads_it_and_its_files_are_read(network: gabf.Network, tmp_path: Path) -> None:
    gabf.write_network(network, tmp_path / "n.npz")
    with np.load(tmp_path / "n.npz", allow_pickle=False) as arrays:
        assert np.array_equal(arrays["weight"], network.weight)
    names = ("indptr", "indices", "weight", "sources", "node_cost")
    for save, file in ((np.savez, "plain.npz"), (np.savez_compressed, "packed.npz")):
        save(tmp_path / file, **{name: getattr(network, name) for name in names})
        found = gabf.read_network(tmp_path / file, KERNEL)
        assert np.array_equal(found.weight, network.weight)
        assert mapped(found.weight) == (file == "plain.npz")


def test_what_is_no_network_is_refused(network: gabf.Network, tmp_path: Path) -> None:
    path = tmp_path / "n.npz"
    with pytest.raises(FileError, match="cannot be read"):
        gabf.read_network(path, KERNEL)
    np.savez(path, weight=network.weight)
    with pytest.raises(FileError, match="lacks indices, indptr, sources"):
        gabf.read_network(path, KERNEL)
    np.savez(path, weight=np.array([{}] * 2000, dtype=object), allow_pickle=True)
    with pytest.raises(FileError, match="cannot be read"):
        gabf.read_network(path, KERNEL)
    gabf.write_network(network, path)
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(FileError, match="cannot be read"):
        gabf.read_network(path, KERNEL)
    with pytest.raises(FileError, match="cannot be written"):
        gabf.write_network(network, tmp_path / "nowhere" / "n.npz")


def test_whatever_is_damaged_is_a_sentence(network: gabf.Network, tmp_path: Path) -> None:
    """Names, flags, methods, sizes and headers of the zip, bytes of arrays that are packed."""
    np.savez_compressed(tmp_path / "packed.npz", **{n: getattr(network, n) for n in ("indptr", "indices", "weight")})
    gabf.write_network(network, tmp_path / "n.npz")
    rng, refused = np.random.default_rng(0), 0
    for name in ("packed.npz", "n.npz"):
        whole = (tmp_path / name).read_bytes()
        for _ in range(150):
            content = bytearray(whole)
            for at in rng.integers(len(content), size=3):
                content[at] ^= 1 << int(rng.integers(8))
            (tmp_path / "x.npz").write_bytes(content)
            try:
                gabf.read_network(tmp_path / "x.npz", KERNEL)
            except PlannerError:
                refused += 1
    assert refused > 150
