"""The cache of arrays: made once, made anew after any damage, and never in the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planner.base import cache as module
from planner.base.cache import cache_folder, cached


class Making:
    """Makes arrays, and counts how often."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self) -> dict[str, np.ndarray]:
        self.times += 1
        return {"a": np.arange(5.0), "b": np.array(["x", "y"])}


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_made_once_for_equal_values() -> None:
    make = Making()
    for _ in range(3):
        found = cached("kind", ["text", np.arange(3)], make)
        np.testing.assert_array_equal(found["a"], np.arange(5.0))
        assert found["b"].tolist() == ["x", "y"]
    assert make.times == 1
    cached("kind", ["text", np.arange(4)], make)
    cached("other", ["text", np.arange(3)], make)
    assert make.times == 3


def test_arrays_come_back_as_they_were() -> None:
    rng = np.random.default_rng(0)
    arrays = {
        "words": np.array(["å", "xyz", ""]),
        "turned": rng.normal(size=(3, 4, 5)).T,
        "none": np.zeros((0, 3)),
        "one": np.array(2.5),
        "small": np.arange(5, dtype=np.int8),
        "big": np.arange(3, dtype=">i4"),
        "yes": np.array([True, False]),
    }
    cached("kind", ["all"], lambda: arrays)
    found = cached("kind", ["all"], lambda: arrays)
    assert list(found) == list(arrays)
    for name, array in arrays.items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array)
    assert all(array.flags.aligned and not array.flags.writeable for array in found.values() if array.size)


def test_any_damage_makes_it_anew() -> None:
    make = Making()
    cached("kind", [1], make)
    (path,) = cache_folder().glob("kind/*.npz")
    whole = path.read_bytes()
    damaged = [whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :] for k in range(0, len(whole), 97)]
    for content in [*damaged, b"", whole[:40], whole[:-1], whole + b"x"]:
        path.write_bytes(content)
        np.testing.assert_array_equal(cached("kind", [1], make)["a"], np.arange(5.0))


def test_a_folder_that_cannot_be_written_costs_time_only(own_cache: Path) -> None:
    own_cache.write_text("a file where the folder should be")
    make = Making()
    for _ in range(2):
        np.testing.assert_array_equal(cached("kind", [1], make)["a"], np.arange(5.0))
    assert make.times == 2


def test_the_oldest_go_when_there_is_no_room(monkeypatch: pytest.MonkeyPatch) -> None:
    cached("kind", [0], Making())
    (path,) = cache_folder().glob("kind/*.npz")
    monkeypatch.setattr(module, "_MOST", int(2.5 * path.stat().st_size))
    for k in range(1, 6):
        cached("kind", [k], Making())
    assert len(list(cache_folder().glob("kind/*"))) == 2


@pytest.mark.parametrize("home", [None, "~", "."])
def test_nothing_is_kept_in_the_working_directory(
    home: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A relative XDG_CACHE_HOME does not count, and where a user has no home ``~`` stays as it is."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", "cache")
    monkeypatch.setenv("HOME", home or str(tmp_path / "home"))
    make = Making()
    for _ in range(2):
        np.testing.assert_array_equal(cached("kind", [1], make)["a"], np.arange(5.0))
    assert make.times == (1 if home is None else 2)
    assert [path.name for path in tmp_path.iterdir()] == (["home"] if home is None else [])
