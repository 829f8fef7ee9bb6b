"""Read-only arrays and arithmetic on rows."""

import itertools

import numpy as np

from planner.base.arrays import cumulative_sums, cut, frozen, indices, numbers, parts_of, placement


def test_freezing_copies_an_array_unless_it_is_frozen() -> None:
    own = np.arange(6).reshape(2, 3).T
    kept = frozen(own)
    own[0, 0] = 9
    np.testing.assert_array_equal(kept, [[0.0, 3], [1, 4], [2, 5]])
    assert kept.flags.c_contiguous
    assert not kept.flags.writeable
    assert frozen(kept) is kept
    assert frozen(kept.T).flags.c_contiguous
    assert frozen([0, 2], np.bool_).tolist() == [False, True]


def test_the_parts_of_a_path_are_equal_and_its_own_rows_stay_to_the_bit() -> None:
    assert parts_of(np.array([0.0, 0.9, 1.0, 1.01, 7.0]), 1.0).tolist() == [1, 1, 1, 2, 7]
    path = np.random.default_rng(0).normal(size=(5, 3)) / 3
    path[1], path[2] = -0.0, 1.0  # a zero keeps its sign: hashes tell them apart
    parts = np.array([1, 4, 2, 3])
    rows, first = cut(path, parts), cumulative_sums(parts)
    assert rows[first].tobytes() == path.tobytes()
    for k, (a, b) in enumerate(itertools.pairwise(path)):
        np.testing.assert_allclose(rows[first[k] : first[k + 1] + 1], np.linspace(a, b, parts[k] + 1), atol=1e-15)
    past_pi = cut(np.array([[3.0], [-3.0]]), np.array([2]), np.array([[2 * np.pi - 6.0]]))
    np.testing.assert_allclose(past_pi, [[3.0], [np.pi], [-3.0]], atol=1e-15)


def test_numbers_are_those_that_were_given() -> None:
    own = np.arange(6.0).reshape(3, 2)
    assert numbers("q", own, ("n", 2)) is own
    assert numbers("q", [[1, 2]], (1, 2)).dtype == np.float64
    assert numbers("t", 3, ()) == 3.0
    np.testing.assert_array_equal(indices("k", [2.0, 0], ("m",), 3), [2, 0])
    turned = np.array([[0.0, -1, 0, 3], [1, 0, 0, 4], [0, 0, 1, 5], [0, 0, 0, 1]])
    assert placement("p", turned) is turned
