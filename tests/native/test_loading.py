"""A library that is missing or of another version is told in one sentence; arrays are read as C does."""

import ctypes.util
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import InstallationError
from planner.native import loading


def test_a_library_that_does_not_fit_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    there = Path(loading.library._name)
    assert loading.load(there).planner_version() == loading._VERSION
    with pytest.raises(InstallationError, match="install the package again"):
        loading.load(there.with_name("libmissing.so"))
    monkeypatch.setitem(loading._ARGUMENTS, "what_was_added_later", ())
    with pytest.raises(InstallationError, match="of another version of the planner: install the package again"):
        loading.load(there)
    with pytest.raises(InstallationError, match="of another version of the planner: install the package again"):
        loading.load(Path(ctypes.util.find_library("m") or "libm.so.6"))  # which says no version
    monkeypatch.undo()
    monkeypatch.setattr(loading, "_VERSION", -1)
    with pytest.raises(InstallationError, match="install the package again"):
        loading.load(there)


def test_arrays_are_read_in_c_order() -> None:
    table = np.arange(6, dtype=np.int32).reshape(2, 3).T
    for read, kind in ((loading.floats, np.float64), (loading.ints, np.int64), (loading.flags, np.uint8)):
        assert read(table).dtype == kind
        assert read(table).flags.c_contiguous
        assert np.array_equal(read(table), table)
    own = np.zeros(3)
    assert loading.floats(own) is own


def test_an_address_is_where_the_numbers_begin() -> None:
    table = np.arange(12.0).reshape(3, 4)
    fixed = table.copy()
    fixed.setflags(write=False)
    for array in (table, fixed, table[1:], table[:, 2], table.T, table[:0]):
        assert loading.address(array) == array.__array_interface__["data"][0]
