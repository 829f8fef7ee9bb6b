"""Arrays that cannot be written to."""

import numpy as np
import pytest

from planner.base.arrays import frozen


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
