"""Arrays that cannot be written to, index arithmetic, and what is refused where arrays enter."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.base.arrays import as_frozen, distinct_rows, frozen, indices, numbers, placement, quantile, ranges, rows
from planner.base.errors import ArrayError, StateError


def test_a_frozen_array_is_a_copy_that_nobody_changes() -> None:
    own = np.arange(6).reshape(2, 3).T
    kept = frozen(own)
    assert kept.dtype == np.float64
    assert kept.flags.c_contiguous
    own[0, 0] = 9
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


def test_numbers_are_those_that_were_given() -> None:
    own = np.arange(6.0).reshape(3, 2)
    assert numbers("q", own, ("n", 2)) is own
    assert numbers("q", [[1, 2]], (1, 2)).dtype == np.float64
    assert numbers("q", np.zeros((0, 2)), ("n", 2)).shape == (0, 2)
    assert numbers("t", 3, ()) == 3.0
    huge = np.array([1e200, -1e308])
    np.testing.assert_array_equal(numbers("q", huge, (2,)), huge)  # their squares overflow, they do not
    np.testing.assert_array_equal(rows("q", own[0], 2), own[:1])
    assert rows("q", own, 2) is own
    np.testing.assert_array_equal(indices("k", [2.0, 0], ("m",), 3), [2, 0])
    turned = np.array([[0.0, -1, 0, 3], [1, 0, 0, 4], [0, 0, 1, 5], [0, 0, 0, 1]])
    assert placement("p", turned) is turned


def test_a_rounded_rotation_becomes_the_nearest_one() -> None:
    """A body of 200 m that is scaled by 4e-7 would reach 0.04 mm too far, or too short."""
    turned = np.eye(4)
    turned[:3] = np.column_stack([Rotation.from_euler("xyz", [0.3, -0.2, 1.0]).as_matrix(), [3.0, 4.0, 5.0]])
    scaled = turned.copy()
    scaled[:3, :3] *= 1 - 4e-7
    np.testing.assert_allclose(placement("p", scaled), turned, atol=1e-15)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: numbers("q", np.zeros((3, 1)), ("n", 2)), "q has shape (3, 1): give an array of shape (n, 2)."),
        (lambda: numbers("q", np.zeros(3), (2,)), "q has shape (3,): give an array of shape (2,)."),
        (lambda: numbers("q", [[0, 1], [np.nan, 0]], ("n", 2)), "q[1, 0] is nan: every number has to be finite."),
        (lambda: numbers("t", -np.inf, ()), "t is -inf: every number has to be finite."),
        (
            lambda: numbers("q", [0, 200.0], (2,), most=100),
            "q[1] is 200: every number has to be finite, no farther than 100 from 0.",
        ),
        (lambda: numbers("q", ["a"], ("n",)), "q is no array of numbers: give one of shape (n,)."),
        (lambda: numbers("q", 10**400, ()), "q is no array of numbers: give one of shape ()."),
        (lambda: rows("q", [[1], [2, 3]], 2), "q is no array of numbers: give one of shape (n, 2)."),
        (lambda: indices("k", [0, 3], ("m",), 3), "k[1] is 3: give whole numbers from 0 to 2."),
        (lambda: indices("k", [0.5], ("m",), 3), "k[0] is 0.5: give whole numbers from 0 to 2."),
        (lambda: indices("k", [np.nan], ("m",), 3), "k[0] is nan: give whole numbers from 0 to 2."),
        (lambda: placement("p", 2 * np.eye(4)), "p is not rigid: give a (4, 4) placement, as planner.pose makes it."),
    ],
)
def test_others_are_refused_in_one_sentence(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ArrayError) as caught:
        call()
    assert str(caught.value) == words
    with pytest.raises(ValueError, match=r"\."):  # what reads files takes it for one
        call()


def test_the_error_is_the_callers() -> None:
    with pytest.raises(StateError, match=r"^start has shape"):
        numbers("start", np.zeros(3), (2,), StateError)


@pytest.mark.parametrize("share", [0.0, 0.05, 0.5, 0.97, 1.0])
@pytest.mark.parametrize("count", [1, 2, 3, 10, 101])
def test_quantiles_are_numpys(count: int, share: float) -> None:
    values = np.random.default_rng(count).normal(size=count)
    assert quantile(values, share) == pytest.approx(float(np.quantile(values, share)), rel=1e-14)
