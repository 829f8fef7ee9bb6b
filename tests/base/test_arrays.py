"""Arrays that cannot be written to, and index arithmetic."""

import numpy as np
import pytest

from planner.base.arrays import as_frozen, distinct_rows, frozen, ranges


def test_a_frozen_array_is_a_copy_that_nobody_changes() -> None:
    rows = np.arange(6).reshape(2, 3).T
    kept = frozen(rows)
    assert kept.dtype == np.float64
    assert kept.flags.c_contiguous
    rows[0, 0] = 9
    np.testing.assert_array_equal(kept, [[0, 3], [1, 4], [2, 5]])
    with pytest.raises(ValueError, match="read-only"):
        kept[0, 0] = 1.0


def test_the_dtype_is_that_asked_for() -> None:
    assert frozen([0, 2], np.bool_).tolist() == [False, True]


def test_ranges_follow_each_other() -> None:
    assert ranges(np.array([5, 0, 9]), np.array([2, 0, 3])).tolist() == [5, 6, 9, 10, 11]


def test_what_is_frozen_already_is_not_copied() -> None:
    array = np.arange(6.0).reshape(2, 3)
    once = as_frozen(array)
    assert once is not array
    assert not once.flags.writeable
    assert as_frozen(once) is once
    assert as_frozen(once, np.int64).dtype == np.int64
    assert as_frozen(once.T).flags.c_contiguous


@pytest.mark.parametrize("shape", [(0, 3), (1, 2), (400, 3), (60, 1)])
@pytest.mark.parametrize("dtype", [np.float64, np.int64])
def test_distinct_rows_are_numpys(shape: tuple[int, int], dtype: type) -> None:
    rows = np.random.default_rng(0).integers(-2, 3, shape).astype(dtype)
    rows[::7] *= -1  # zeros of either sign are equal
    _, first, which = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    found = distinct_rows(rows)
    assert found[0].tolist() == first.tolist()
    assert found[1].tolist() == which.ravel().tolist()
