"""Hashes tell contents apart, and the cache makes arrays once, again after any damage, and never stops a command."""

from pathlib import Path

import numpy as np
import pytest

from planner.base.cache import cache_folder, content_hash, load_or_compute


class Making:
    """Makes arrays, and counts how often."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self) -> dict[str, np.ndarray]:
        self.times += 1
        return {"a": np.arange(5.0), "b": np.array(["å", "y"]), "turned": np.ones((3, 4)).T, "none": np.zeros((0, 3))}


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_the_same_numbers_have_the_same_hash_however_they_lie_in_memory() -> None:
    a = np.arange(12.0).reshape(3, 4)
    same = (a.astype(">f8"), np.asfortranarray(a), np.arange(24.0)[::2].reshape(3, 4) / 2)
    assert {content_hash([other]) for other in same} == {content_hash([a])}


def test_different_contents_have_different_hashes() -> None:
    a = np.arange(12.0)
    contents = ([a], [a.reshape(3, 4)], [a.astype(np.float32)], [a.astype(np.int64)], [a[:6], a[6:]], [a, ""], [a + 0j])
    texts = (["ab", "c"], ["a", "bc"], ["abc"], [1], [1.0], ["1"], [1, 23], [12, 3])
    hashes = [content_hash(values) for values in (*contents, *texts)]
    assert len(set(hashes)) == len(hashes)
    assert content_hash([np.array([0.0])]) != content_hash([np.array([-0.0])])


def test_made_once_for_equal_values_and_read_as_it_was() -> None:
    make = Making()
    for _ in range(3):
        found = load_or_compute("kind", ["text", np.arange(3)], make)
        for name, array in Making()().items():
            assert found[name].dtype == array.dtype
            assert not found[name].flags.writeable
            np.testing.assert_array_equal(found[name], array)
    assert make.times == 1
    load_or_compute("kind", ["text", np.arange(4)], make)
    load_or_compute("other", ["text", np.arange(3)], make)
    assert make.times == 3


def test_any_damage_makes_it_anew() -> None:
    make = Making()
    load_or_compute("kind", [1], make)
    (path,) = cache_folder().glob("kind/*.npz")
    whole = path.read_bytes()
    damaged = [whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :] for k in range(0, len(whole), 97)]
    for content in [*damaged, b"", whole[:40], whole[:-1], whole + b"x"]:
        path.write_bytes(content)
        np.testing.assert_array_equal(load_or_compute("kind", [1], make)["a"], np.arange(5.0))


@pytest.mark.parametrize("home", [None, "~"])
def test_nothing_is_kept_in_the_working_directory(
    home: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A relative XDG_CACHE_HOME does not count, and where a user has no home ``~`` stays as it is."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", "cache")
    monkeypatch.setenv("HOME", home or str(tmp_path / "home"))
    load_or_compute("kind", [1], Making())
    assert [path.name for path in tmp_path.iterdir()] == (["home"] if home is None else [])
